//! Entities of each type, by their formulas.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::common::{Entity, entity, file, read};
use loftsman_kernel::brep::{Brep, CurveForm, SurfaceForm};
use loftsman_kernel::mesh::color::from_srgb;
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};

/// The scene of entities, all of which are kept.
fn scene(entities: &[Entity<'_>]) -> Scene {
    let (scene, report) = read(&file(entities)).unwrap();
    assert!(report.left_out.is_empty() && report.approximated.is_empty(), "{report:?}");
    scene.check().unwrap();
    scene
}

/// The only object of a scene.
fn only(scene: &Scene) -> &Geometry {
    assert_eq!(scene.objects().len(), 1, "{:?}", scene.objects());
    scene.objects()[0].geometry()
}

fn curve(entities: &[Entity<'_>]) -> Curve {
    let scene = scene(entities);
    match only(&scene) {
        Geometry::Curve(curve) => curve.clone(),
        other => panic!("{}", other.kind()),
    }
}

fn surface(entities: &[Entity<'_>]) -> Surface {
    let scene = scene(entities);
    match only(&scene) {
        Geometry::Surface(surface) => surface.clone(),
        other => panic!("{}", other.kind()),
    }
}

fn trimmed(entities: &[Entity<'_>]) -> Trimmed {
    let scene = scene(entities);
    match only(&scene) {
        Geometry::Trimmed(trimmed) => trimmed.clone(),
        other => panic!("{}", other.kind()),
    }
}

fn brep(entities: &[Entity<'_>]) -> Brep {
    let scene = scene(entities);
    match only(&scene) {
        Geometry::Brep(brep) => brep.clone(),
        other => panic!("{}", other.kind()),
    }
}

fn near(a: Point, b: [f64; 3], within: f64) {
    assert!((a - Point::from(b)).norm() < within, "{a} {b:?}");
}

/// Places all along a domain.
fn along((from, to): (f64, f64)) -> impl Iterator<Item = f64> {
    (0..=16).map(move |k| from + (to - from) * f64::from(k) / 16.0)
}

#[test]
fn lines_arcs_and_composites() {
    let line = curve(&[entity(0, "110,1.,2.,3.,4.,6.,3.;")]);
    near(line.point(0.5).unwrap(), [2.5, 4.0, 3.0], 1e-15);
    // Counterclockwise from (0, -2) to (2, 0) about the origin, at z = 5: three quarters the other way.
    let arc = curve(&[entity(0, "100,5.,0.,0.,0.,-2.,2.,0.;")]);
    assert_eq!(arc.domain(), (0.0, FRAC_PI_2));
    let back = curve(&[entity(0, "100,5.,0.,0.,2.,0.,0.,-2.;")]);
    assert_eq!(back.domain(), (0.0, 1.5 * PI));
    for curve in [&arc, &back] {
        for t in along(curve.domain()) {
            let p = curve.point(t).unwrap();
            assert!((p.x.hypot(p.y) - 2.0).abs() < 1e-14 && (p.z - 5.0).abs() < 1e-14);
        }
    }
    let circle = curve(&[entity(0, "100,0.,1.,1.,4.,5.,4.,5.;")]);
    assert_eq!(circle.domain(), (0.0, TAU));
    let parts =
        ["110,0.,0.,0.,2.,0.,0.;", "100,0.,2.,1.,2.,0.,2.,2.;", "110,2.,2.,0.,0.,2.,0.;", "102,3,1,3,5;"];
    let whole = curve(&parts.map(|text| entity(0, text)));
    near(whole.point(whole.domain().1).unwrap(), [0.0, 2.0, 0.0], 1e-14);
    near(whole.point(1.0 + FRAC_PI_2).unwrap(), [3.0, 1.0, 0.0], 1e-14);
}

#[test]
fn conics_copious_data_and_splines_of_powers() {
    // x²/16 + y²/4 = 1 from (4, 0) to (0, 2).
    let ellipse = curve(&[entity(1, "104,0.0625,0.,0.25,0.,0.,-1.,7.,4.,0.,0.,2.;")]);
    for t in along(ellipse.domain()) {
        let p = ellipse.point(t).unwrap();
        assert!(
            (p.x * p.x / 16.0 + p.y * p.y / 4.0 - 1.0).abs() < 1e-13
                && (p.z - 7.0).abs() < 1e-13
                && p.x > -1e-12
        );
    }
    let scene_of = |form, text: &str| scene(&[entity(form, text)]);
    for (form, text, closed, count) in [
        (11, "106,1,3,7.,0.,0.,1.,0.,1.,1.;", false, 3),
        (12, "106,2,3,0.,0.,7.,1.,0.,7.,1.,1.,7.;", false, 3),
        (13, "106,3,2,0.,0.,7.,9.,9.,9.,1.,1.,7.,9.,9.,9.;", false, 2),
        (63, "106,1,4,7.,0.,0.,1.,0.,1.,1.,0.,0.;", true, 3),
    ] {
        match only(&scene_of(form, text)) {
            Geometry::Polyline(line) => {
                assert_eq!((line.closed, line.points.len()), (closed, count), "{text}");
                assert!(line.points.iter().all(|p| p.z == 7.0), "{text}");
            }
            other => panic!("{}", other.kind()),
        }
    }
    assert!(
        matches!(only(&scene_of(2, "106,2,2,0.,0.,7.,1.,0.,7.;")), Geometry::Cloud(cloud) if cloud.points.len() == 2)
    );
    // x = t, y = t² - t, z = t³ / 8 over [0, 2], then x = 2 + s, y = 2 + s, z = 1 over [2, 3].
    let text = "112,3,1,3,2,0.,2.,3.,0.,1.,0.,0.,0.,-1.,1.,0.,0.,0.,0.,.125,2.,1.,0.,0.,2.,1.,0.,0.,1.,0.,0.,0.,\
                0.,0.,0.,0.,0.,0.,0.,0.,0.,0.,0.,0.;";
    let spline = curve(&[entity(0, text)]);
    for t in along((0.0, 2.0)) {
        near(spline.point(t).unwrap(), [t, t * t - t, t * t * t / 8.0], 1e-14);
    }
    near(spline.point(2.5).unwrap(), [2.5, 2.5, 1.0], 1e-14);
    // One patch: x = s, y = t, z = s t² over [0, 2] × [0, 3]; patches at the ends say nothing.
    let powers = |terms: &[(usize, f64)]| {
        let mut all = [0.0; 16];
        terms.iter().for_each(|(k, c)| all[*k] = *c);
        all.map(|c| format!("{c}.")).join(",")
    };
    let patch = [powers(&[(1, 1.0)]), powers(&[(4, 1.0)]), powers(&[(9, 1.0)])].join(",");
    let blank = [powers(&[]), powers(&[]), powers(&[])].join(",");
    let text = format!("114,3,1,1,1,0.,2.,0.,3.,{patch},{blank},{blank},{blank};");
    let sheet = surface(&[entity(0, &text)]);
    for u in along((0.0, 2.0)) {
        for v in along((0.0, 3.0)) {
            near(sheet.point(u, v).unwrap(), [u, v, u * v * v], 1e-13);
        }
    }
}

const QUARTER: &str =
    "126,2,2,1,0,0,0,0.,0.,0.,1.,1.,1.,1.,.5D0,1.,1.,0.,0.,1.,1.,0.,0.,1.,0.,0.,1.,0.,0.,1.;";

#[test]
fn b_splines_with_their_ends() {
    let whole = curve(&[entity(0, QUARTER)]);
    assert_eq!((whole.degree(), whole.weights()), (2, Some(&[1.0, 0.5, 1.0][..])));
    let part = curve(&[entity(0, &QUARTER.replace("0.,1.,0.,0.,1.;", ".25,.5,0.,0.,1.;"))]);
    assert_eq!(part.domain(), (0.25, 0.5));
    near(part.point(0.3).unwrap(), whole.point(0.3).unwrap().into(), 1e-15);
    // Rows of the file run along u: x = u, y = v with three control points along u.
    let net = "0.,0.,0.,.5,0.,1.,1.,0.,0.,0.,1.,0.,.5,1.,1.,1.,1.,0.";
    let text =
        format!("128,2,1,2,1,0,0,1,0,0,0.,0.,0.,1.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,1.,1.,{net},0.,1.,0.,1.;");
    let sheet = surface(&[entity(0, &text)]);
    assert_eq!((sheet.u().degree(), sheet.v().degree(), sheet.weights()), (2, 1, None));
    near(sheet.point(0.5, 0.25).unwrap(), [0.5, 0.25, 0.5], 1e-15);
}

#[test]
fn swept_surfaces_count_as_the_file_does() {
    // A line about the z axis, from a quarter turn to a whole one: a cone's piece.
    let parts = ["110,0.,0.,0.,0.,0.,1.;", "110,1.,0.,0.,3.,0.,4.;"];
    let turned = format!("120,1,3,{FRAC_PI_2},{TAU};");
    let all = [entity(0, parts[0]), entity(0, parts[1]), entity(0, &turned)];
    let sheet = surface(&all);
    near(sheet.point(0.0, 0.5).unwrap(), [0.0, 2.0, 2.0], 1e-14);
    near(sheet.point(PI, 0.0).unwrap(), [0.0, -1.0, 0.0], 1e-14);
    // Its part between 60° and 90° of the file, and a half and the whole of the line, as a rectangle of parameters.
    let (a, b) = (FRAC_PI_2 + PI / 7.0, FRAC_PI_2 + 1.0);
    let side = |p: [f64; 2], q: [f64; 2]| format!("110,{},{},0.,{},{},0.;", p[0], p[1], q[0], q[1]);
    let sides = [
        side([0.5, a], [1.0, a]),
        side([1.0, a], [1.0, b]),
        side([1.0, b], [0.5, b]),
        side([0.5, b], [0.5, a]),
    ];
    let mut all: Vec<Entity<'_>> = all.into_iter().collect();
    all.extend(sides.iter().map(|text| entity(0, text)));
    all.extend([entity(0, "102,4,7,9,11,13;"), entity(0, "142,0,5,15,0,1;"), entity(0, "144,5,1,0,17;")]);
    let part = trimmed(&all);
    let outer = &part.regions()[0].outer;
    assert_eq!(outer.len(), 4);
    for (curve, (t, angle)) in outer.iter().zip([(0.5, a), (1.0, a), (1.0, b), (0.5, b)]) {
        let [[u, v], _] = curve.ends().unwrap();
        let r = 1.0 + 2.0 * t;
        near(part.surface().point(u, v).unwrap(), [r * angle.cos(), r * angle.sin(), 4.0 * t], 1e-13);
    }
    // An arc along a vector, and lines between two arcs.
    let arc = "100,0.,0.,0.,1.,0.,0.,1.;";
    let tube = surface(&[entity(0, arc), entity(0, "122,1,1.,0.,5.;")]);
    for u in along(tube.u().domain()) {
        let p = tube.point(u, 0.5).unwrap();
        assert!((p.x.hypot(p.y) - 1.0).abs() < 1e-14 && (p.z - 2.5).abs() < 1e-14);
    }
    let ruled = surface(&[entity(0, arc), entity(0, "100,2.,0.,0.,3.,0.,0.,3.;"), entity(1, "118,1,3,0,0;")]);
    for u in along(ruled.u().domain()) {
        let p = ruled.point(u, 0.5).unwrap();
        assert!((p.x.hypot(p.y) - 2.0).abs() < 1e-14 && (p.z - 1.0).abs() < 1e-14);
    }
    // Offsets of a circle: towards its centre, seen from the tip of the normal.
    let inner = curve(&[entity(0, arc), entity(0, "130,1,1,0,0,0,.25,0.,0.,0.,0.,0.,1.,0.,0.;")]);
    assert!(inner.points().iter().all(|p| p.coords.norm() > 0.74) && inner.point(0.0).unwrap().x == 0.75);
}

#[test]
fn planes_are_as_large_as_their_boundaries() {
    let ring = "100,0.,0.,0.,2.,0.,2.,0.;";
    let bounded = trimmed(&[entity(0, ring), entity(1, "108,0.,0.,1.,0.,1,0.,0.,0.,1.;")]);
    assert_eq!(bounded.regions()[0].outer.len(), 1);
    let plane = entity(0, "108,0.,0.,-2.,0.,0;");
    let hole = "100,0.,0.,0.,.5,0.,.5,0.;";
    let cut = [
        entity(0, ring),
        plane,
        entity(0, "142,0,3,0,1,2;"),
        entity(0, hole),
        entity(0, "142,0,3,0,7,2;"),
        entity(0, "144,3,1,1,5,9;"),
    ];
    let cut = trimmed(&cut);
    assert_eq!((cut.regions()[0].outer.len(), cut.regions()[0].holes.len()), (1, 1));
    for (curve, radius) in [(&cut.regions()[0].outer[0], 2.0), (&cut.regions()[0].holes[0][0], 0.5)] {
        for t in along(curve.range()) {
            let p = curve.curve().point(t).unwrap();
            let at = cut.surface().point(p.x, p.y).unwrap();
            assert!((at.coords.norm() - radius).abs() < 1e-14 && at.z.abs() < 1e-15, "{at}");
        }
    }
}

#[test]
fn faces_without_parameter_curves_keep_their_edges() {
    // A cylinder between two rings: no loop of it closes in the plane of parameters.
    let all = [
        entity(0, "110,0.,0.,0.,0.,0.,1.;"),
        entity(0, "110,1.,0.,-1.,1.,0.,4.;"),
        entity(0, "120,1,3,0.,6.283185307;"),
        entity(0, "100,0.,0.,0.,1.,0.,1.,0.;"),
        entity(0, "142,0,5,0,7,2;"),
        entity(0, "100,3.,0.,0.,1.,0.,1.,0.;"),
        entity(0, "142,0,5,0,11,2;"),
        entity(0, "144,5,1,1,9,13;"),
    ];
    let ring = brep(&all);
    assert_eq!((ring.face_count(), ring.edge_count()), (1, 2));
    assert!(matches!(ring.surface_form(0), SurfaceForm::Cylinder { radius: 1.0, .. }));
    assert!(
        (0..2).all(|edge| matches!(ring.edge(edge).unwrap().form, CurveForm::Circle { radius: 1.0, .. }))
    );
    assert!(ring.flaws(1e-12).unwrap().is_empty());
    // With the seam in its boundary, that is one edge, run through twice.
    let mut all: Vec<Entity<'_>> = all.into_iter().take(3).collect();
    all.extend([
        entity(0, "100,0.,0.,0.,1.,0.,1.,0.;"),
        entity(0, "110,1.,0.,0.,1.,0.,3.;"),
        Entity { matrix: 19, ..entity(0, "100,-3.,0.,0.,1.,0.,1.,0.;") },
        entity(0, "110,1.,0.,3.,1.,0.,0.;"),
        entity(0, "102,4,7,9,11,13;"),
        entity(0, "142,0,5,0,15,2;"),
        entity(0, "124,1.,0.,0.,0.,0.,-1.,0.,0.,0.,0.,-1.,0.;"),
        entity(0, "144,5,1,0,17;"),
    ]);
    let tube = brep(&all);
    assert_eq!((tube.edge_count(), tube.vertices().len(), tube.loops(0)[0].len()), (3, 2, 4));
}

#[test]
fn solids_of_elementary_surfaces() {
    // A sphere without edges; a half of a cylinder's shell would not close.
    let sphere = [
        entity(0, "116,1.,2.,3.,0;"),
        entity(0, "196,1,2.5;"),
        entity(1, "510,3,0,0;"),
        entity(1, "514,1,5,1;"),
        entity(0, "186,7,1,0;"),
    ];
    let ball = brep(&sphere);
    assert_eq!(ball.solids().len(), 1);
    let SurfaceForm::Sphere { frame, radius } = ball.surface_form(0) else { panic!() };
    assert_eq!((frame.origin, radius), (Point::new(1.0, 2.0, 3.0), 2.5));
    assert!(!ball.is_reversed(0));
    let turned = brep(&[
        entity(0, "116,1.,2.,3.,0;"),
        entity(0, "196,1,2.5;"),
        entity(1, "510,3,0,0;"),
        entity(1, "514,1,5,0;"),
    ]);
    assert!(turned.is_reversed(0) && turned.solids().is_empty());
    for (text, form) in [
        ("192,1,3,2.5,5;", "cylinder"),
        ("194,1,3,2.5,30.,5;", "cone"),
        ("198,1,3,2.5,1.,5;", "torus"),
        ("190,1,3,5;", "plane"),
    ] {
        let radius = match form {
            "torus" => 3.5,
            _ => 2.5,
        };
        let circle = format!("100,0.,0.,0.,{radius},0.,{radius},0.;");
        let vertex = format!("502,1,{radius},0.,0.;");
        let all = [
            entity(0, "116,0.,0.,0.,0;"),
            entity(0, "123,0.,0.,1.;"),
            entity(0, "123,1.,0.,0.;"),
            entity(1, text),
            entity(0, &circle),
            entity(1, &vertex),
            entity(1, "504,1,9,11,1,11,1;"),
            entity(1, "508,1,0,13,1,1,0;"),
            entity(1, "510,7,1,1,15;"),
        ];
        let face = brep(&all);
        assert_eq!((face.surface_form(0).name(), face.edge_count()), (form, 1));
        assert!(face.flaws(1e-12).unwrap().is_empty(), "{form}");
    }
}

#[test]
fn matrices_turn_within_one_another() {
    // A quarter turn about z, then a shift along x.
    let text = ["124,0.,-1.,0.,0.,1.,0.,0.,0.,0.,0.,1.,0.;", "124,1.,0.,0.,5.,0.,1.,0.,0.,0.,0.,1.,0.;"];
    let line = Entity { matrix: 3, ..entity(0, "110,1.,0.,0.,2.,0.,0.;") };
    let moved = curve(&[line, Entity { matrix: 5, ..entity(0, text[0]) }, entity(0, text[1])]);
    near(moved.point(0.0).unwrap(), [5.0, 1.0, 0.0], 1e-15);
    // A mirrored circle still is one, and turns the other way.
    let mirror = "124,1.,0.,0.,0.,0.,-1.,0.,0.,0.,0.,1.,0.;";
    let all = [
        Entity { matrix: 3, ..entity(0, "100,0.,0.,0.,2.,0.,0.,2.;") },
        entity(1, mirror),
        entity(1, "502,2,2.,0.,0.,0.,-2.,0.;"),
        entity(1, "504,1,1,5,1,5,2;"),
        entity(0, "116,0.,0.,0.,0;"),
        entity(0, "123,0.,0.,1.;"),
        entity(0, "190,9,11;"),
        entity(0, "110,0.,-2.,0.,2.,0.,0.;"),
        entity(1, "504,2,1,5,1,5,2,15,5,2,5,1;"),
        entity(1, "508,2,0,17,1,1,0,0,17,2,1,0;"),
        entity(1, "510,13,1,1,19;"),
    ];
    let (scene, _) = read(&file(&all)).unwrap();
    let Geometry::Brep(face) = scene.objects()[0].geometry() else { panic!() };
    let edge = face.edge(0).unwrap();
    let CurveForm::Circle { frame, radius } = edge.form else { panic!("{:?}", edge.form) };
    assert!((radius - 2.0).abs() < 1e-15 && (frame.z + Vector::z()).norm() < 1e-15);
    assert!(face.flaws(1e-12).unwrap().is_empty());
}

#[test]
fn subfigures_groups_names_layers_and_colours() {
    let colored = |color, text| Entity { color, ..entity(0, text) };
    let all = [
        entity(0, "110,0.,0.,0.,1.,0.,0.;"),
        entity(0, "116,0.,0.,1.,0;"),
        entity(0, "308,0,4Hbolt,2,1,3;"),
        entity(0, "408,5,1.,2.,3.,2.;"),
        entity(0, "408,5,0.,0.,0.,1.,0,1,11;"),
        entity(15, "406,1,9Hother one;"),
        colored(-15, "110,0.,0.,0.,0.,1.,0.;"),
        entity(0, "314,100.,50.,0.,3Hred;"),
        Entity { level: 7, label: "side", ..entity(0, "110,0.,0.,0.,0.,0.,1.;") },
        Entity { level: 7, ..entity(3, "406,2,0,6Hframes;") },
        entity(7, "402,2,13,17,0,1,23;"),
        entity(15, "406,1,4Hpair;"),
        Entity { status: "01000000", level: 9, ..entity(0, "110,0.,0.,0.,9.,0.,1.;") },
    ];
    let scene = scene(&all);
    let names: Vec<_> =
        scene.objects().iter().map(|o| (o.name(), o.geometry().kind(), o.parent.as_deref())).collect();
    assert_eq!(
        names,
        [
            ("bolt", "instance", None),
            ("other one", "instance", None),
            ("pair", "group", None),
            ("t", "curve", Some("pair")),
            ("side", "curve", Some("pair")),
            ("t.001", "curve", None),
        ]
    );
    let bolt = scene.object("bolt").unwrap().transform.unwrap();
    assert_eq!(bolt.transform_point(&Point::new(1.0, 0.0, 0.0)), Point::new(3.0, 2.0, 3.0));
    assert!(scene.object("other one").unwrap().transform.is_none());
    assert_eq!(scene.definition("bolt").unwrap().objects().len(), 2);
    assert_eq!(scene.object("side").unwrap().layer.as_deref(), Some("frames"));
    let [r, g, b, _] = scene.object("t").unwrap().color.unwrap();
    assert_eq!((r, g, b), (1.0, from_srgb(0.5), 0.0));
    let hidden = scene.object("t.001").unwrap();
    assert!(hidden.layer.as_deref() == Some("9") && scene.hidden_layers().hides(hidden));
    assert_eq!(scene.unit, Unit::Millimetre);
}

#[test]
fn lines_of_old_writers() {
    let good = file(&[
        entity(0, "126,1,1,0,0,1,0,0.,0.,1.D0,1.D0,1.,1.,0.,0.,0.,1.d1,2.5E0,-3.;"),
        entity(0, "116,1.,2.,3.,0;"),
    ]);
    let expected = read(&good).unwrap().0;
    assert_eq!(expected.objects().len(), 2);
    let trimmed_ends: String = good.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    for text in [
        good.replace('\n', "\r\n"),
        good.replace('\n', "\r"),
        good.replace('\n', "  \n"),
        format!("\u{feff}{good}"),
        good.replace("       0       0       1", "\t       0       1"),
        trimmed_ends,
        // Numbers of lines that are all the same, or none.
        good.lines().map(|line| format!("{}\n", &line[..73])).collect(),
        good.lines().map(|line| format!("{}      1\n", &line[..73])).collect(),
        // Blank fields, and a directory that points elsewhere.
        good.replace("       0", "        "),
        good.replace("     126       1", "     126       2"),
        // Lines that end before their letter should stand.
        good.lines()
            .map(|line| match line.as_bytes()[72] {
                b'P' => format!("{}P{}\n", &line[..64].trim_end(), &line[73..]),
                _ => format!("{line}\n"),
            })
            .collect(),
    ] {
        let (found, report) = read(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert!(report.left_out.is_empty(), "{report:?} {text}");
        assert_eq!(found, expected, "{text}");
    }
}

/// An edge that is not on its surface is told as in STEP files, and so is a loop beside the others.
#[test]
fn edges_off_their_faces_and_loops_beside_one_another_are_told() {
    // Squares of a plane: their corners, four lines between them each, and what is said.
    let told = |squares: &[[[f64; 3]; 4]]| {
        let mut all = vec!["116,0.,0.,0.,0;".to_owned(), "123,0.,0.,1.;".to_owned(), "190,1,3;".to_owned()];
        let mut forms = vec![0, 0, 0];
        let corners: Vec<[f64; 3]> = squares.iter().flatten().copied().collect();
        let numbers: Vec<String> = corners.iter().flatten().map(|x| format!("{x:?}")).collect();
        all.push(format!("502,{},{};", corners.len(), numbers.join(",")));
        forms.push(1);
        let (mut edges, mut first) = (Vec::new(), 1);
        for square in squares {
            for k in 0..4 {
                let line: Vec<String> =
                    square[k].iter().chain(&square[(k + 1) % 4]).map(|x| format!("{x:?}")).collect();
                all.push(format!("110,{};", line.join(",")));
                forms.push(0);
                edges.push(format!("{},7,{},7,{}", 2 * all.len() - 1, first + k, first + (k + 1) % 4));
            }
            first += 4;
        }
        all.push(format!("504,{},{};", edges.len(), edges.join(",")));
        forms.push(1);
        let list = 2 * all.len() - 1;
        let mut loops = Vec::new();
        for k in 0..squares.len() {
            let uses: Vec<String> = (1..=4).map(|e| format!("0,{list},{},1,0", 4 * k + e)).collect();
            all.push(format!("508,4,{};", uses.join(",")));
            forms.push(1);
            loops.push((2 * all.len() - 1).to_string());
        }
        all.push(format!("510,5,{},1,{};", loops.len(), loops.join(",")));
        forms.push(1);
        let face = 2 * all.len() - 1;
        all.push(format!("514,1,{face},1;"));
        forms.push(2);
        let entities: Vec<Entity<'_>> =
            all.iter().zip(&forms).map(|(text, form)| entity(*form, text)).collect();
        let (scene, report) = read(&file(&entities)).unwrap();
        assert!(matches!(only(&scene), Geometry::Brep(_)));
        let notes: Vec<String> = report.notes.into_iter().filter(|note| note.starts_with('D')).collect();
        (face, notes)
    };
    let square = |x: f64, a: f64| [[x, 0.0, 0.0], [x + a, 0.0, 0.0], [x + a, a, 0.0], [x, a, 0.0]];
    let hole = [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [4.0, 4.0, 0.0], [4.0, 2.0, 0.0]];
    assert_eq!(told(&[square(0.0, 10.0), hole]).1, [""; 0]);
    let (face, notes) = told(&[square(0.0, 10.0), hole, square(25.0, 4.0)]);
    let begins = format!("D{face}: a loop of it, around an area of 16, lies outside the largest");
    assert!(notes.len() == 1 && notes[0].starts_with(&begins), "{notes:?}");
    let mut bent = square(0.0, 10.0);
    bent[2][2] = 50.0;
    let (_, notes) = told(&[bent]);
    assert!(
        notes.len() == 1
            && notes[0].contains("is up to 50 off the surface of face 0; ")
            && notes[0].contains("the file states "),
        "{notes:?}"
    );
}

/// An offset (140) of what is a spline here is one near to it, on the side that the indicator points to, and it is said how near; that of a tube is a tube.
#[test]
fn offsets_of_surfaces() {
    // Lines along z at distance 2 from the z axis: a quarter of a tube (122), and a whole one (120).
    let (arc, axis, line) = ("100,0.,0.,0.,2.,0.,0.,2.;", "110,0.,0.,0.,0.,0.,1.;", "110,2.,0.,0.,2.,0.,5.;");
    let tubes: [&[&str]; 2] = [&[arc, "122,1,2.,0.,5."], &[axis, line, "120,1,3,0.,6.28318530717959"]];
    for tube in tubes {
        for (side, radius) in [("1.,0.,0.", 2.5), ("-1.,0.,0.", 1.5)] {
            let last = format!("140,{side},0.5,{};", 2 * tube.len() - 1);
            let texts: Vec<String> =
                tube.iter().map(|text| format!("{};", text.trim_end_matches(';'))).chain([last]).collect();
            let entities: Vec<Entity<'_>> = texts.iter().map(|text| entity(0, text)).collect();
            let (scene, report) = read(&file(&entities)).unwrap();
            assert!(report.left_out.is_empty(), "{report:?}");
            let told = format!("{:?}", report.approximated);
            assert!(told.contains("an offset of a free-form surface, approximated"), "{told}");
            let Geometry::Surface(found) = only(&scene) else { panic!("{:?}", only(&scene)) };
            for u in along(found.u().domain()) {
                for v in along(found.v().domain()) {
                    let p = found.point(u, v).unwrap();
                    assert!(
                        (p.x.hypot(p.y) - radius).abs() < 1e-6 && (-1e-9..5.0 + 1e-9).contains(&p.z),
                        "{side}: {p}"
                    );
                }
            }
        }
    }
}

/// OpenCASCADE's torus of one trimmed surface: its boundary runs along two circles there and back, which are one edge each.
#[test]
fn a_boundary_along_seams_that_close_has_each_of_them_once() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/made/torus.igs");
    let (scene, report) = read(&std::fs::read_to_string(path).unwrap()).unwrap();
    let Geometry::Brep(brep) = only(&scene) else { panic!("{report:?}") };
    assert_eq!((brep.face_count(), brep.edge_count(), brep.vertices().len()), (1, 2, 1), "{report:?}");
    for edge in 0..2 {
        let directions: Vec<bool> =
            brep.uses(edge).iter().map(|one| brep.loops(0)[one.chain][one.number].reversed).collect();
        assert!(directions == [false, true] || directions == [true, false], "{directions:?}");
    }
    assert!(brep.is_closed(&[0]));
}

/// Boundaries of balls and tori with a hole over the seam: laid out they run counterclockwise, and no further around than the surface goes, whichever way round files have them and
/// whichever use of a seam that closes comes first. A boundary whose seams bound nothing runs clockwise about the hole.
#[test]
fn boundaries_over_seams_have_the_face_to_their_left() {
    for (name, closes, hole) in [
        ("bitten_ball", [true, false], false),
        ("bitten_sphere", [true, false], false),
        ("bitten_torus", [true, true], false),
        ("bitten_corner", [true, true], true),
    ] {
        let path = format!("{}/../../tests/data/made/{name}.igs", env!("CARGO_MANIFEST_DIR"));
        let (scene, report) = read(&std::fs::read_to_string(path).unwrap()).unwrap();
        let Geometry::Brep(brep) = only(&scene) else { panic!("{report:?}") };
        let curves = brep.parameter_curves(0).unwrap();
        let mut places: Vec<[f64; 2]> = Vec::new();
        for (one, found) in brep.loops(0)[0].iter().zip(&curves[0]) {
            let (from, to) = found.curve.range();
            for k in 0..=40 {
                let share = f64::from(if one.reversed { 40 - k } else { k }) / 40.0;
                let p = found.curve.curve().point((from + (to - from) * share).min(to)).unwrap();
                places.push([p.x, p.y]);
            }
        }
        let next = places.iter().skip(1).chain(places.first());
        let area: f64 = places.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
        assert_eq!((area > 0.0) != brep.is_reversed(0), !hole, "{name}: {area}");
        let surface = brep.surface(0).unwrap();
        for (d, space) in
            [surface.u(), surface.v()].into_iter().enumerate().filter(|(d, _)| closes[*d] && !hole)
        {
            let low = places.iter().map(|p| p[d]).fold(f64::INFINITY, f64::min);
            let high = places.iter().map(|p| p[d]).fold(f64::NEG_INFINITY, f64::max);
            let turn = space.domain().1 - space.domain().0;
            assert!(high - low <= turn * (1.0 + 1e-6), "{name}: {} of {turn}", high - low);
        }
    }
}

/// All four curves of that boundary end in one point: listed there and back at once, as files have them, they are a chain, too, which bounds nothing.
#[test]
fn seams_there_and_back_at_once_are_put_in_order() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/made/torus.igs");
    let text = std::fs::read_to_string(path).unwrap();
    // Which circle comes when, by its radius, and whether forwards, from the first run of the large one on.
    let order = |text: &str| -> Vec<(bool, bool)> {
        let (scene, report) = read(text).unwrap();
        let Geometry::Brep(brep) = only(&scene) else { panic!("{report:?}") };
        let is_large = |edge: usize| {
            let points = brep.curve(edge).unwrap().into_parts().1;
            points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max) > 4.0
        };
        // Which way each circle runs at the start is by its own direction.
        let way = |edge: usize| {
            let tangent = brep.curve(edge).unwrap().derivative(brep.edge(edge).unwrap().range.0, 1).unwrap();
            tangent[tangent.iamax()] > 0.0
        };
        let chain = &brep.loops(0)[0];
        let mut all: Vec<_> =
            chain.iter().map(|one| (is_large(one.edge), way(one.edge) != one.reversed)).collect();
        let first = all.iter().position(|one| *one == (true, true)).unwrap();
        all.rotate_left(first);
        all
    };
    let right = order(&text);
    assert!(right[0].0 && !right[1].0 && right[2].0 && !right[3].0, "{right:?}");
    // About z by the right hand and seen from outside, what is beside the outermost circle is to the left of it where the small one comes up there.
    let (scene, _) = read(&text).unwrap();
    let Geometry::Brep(brep) = only(&scene) else { panic!("a brep") };
    let surface = brep.surface(0).unwrap();
    let foot = surface.closest(Point::new(6.0, 0.0, 0.0)).unwrap().at;
    let normal = surface
        .derivative(foot.0, foot.1, 1, 0)
        .unwrap()
        .cross(&surface.derivative(foot.0, foot.1, 0, 1).unwrap());
    let outward = (normal.x > 0.0) != brep.is_reversed(0);
    assert_eq!(right[1].1, outward, "{right:?}");
    let listed = "102,4,25,29,33,35;";
    assert!(text.contains(listed));
    for other in [
        "29,33,35,25",
        "33,29,25,35",
        "25,33,29,35",
        "29,35,25,33",
        "33,25,35,29",
        "25,35,29,33",
        "35,29,33,25",
        "29,33,25,35",
    ] {
        assert_eq!(order(&text.replace(listed, &format!("102,4,{other};"))), right, "{other}");
    }
}
