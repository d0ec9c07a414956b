//! Flags that turn something round: of curves, edges, loops, bounds, faces and shells, by ISO 10303-42.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::f64::consts::PI;

use crate::common::{AXES, file, read};
use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Format, Memory, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::Curve;
use loftsman_step::Step;

/// Half a disc: #61 is the upper half of a circle, from its right end to the left one, and #62 the line back.
const HALF: &str = "#100=OPEN_SHELL('',(#101));\n#101=ADVANCED_FACE('',(#95),#102,.T.);\n#102=PLANE('',#10);\n\
                    #95=FACE_OUTER_BOUND('',#90,.T.);\n#90=EDGE_LOOP('',(#91,#92));\n\
                    #91=ORIENTED_EDGE('',*,*,#61,.T.);\n#92=ORIENTED_EDGE('',*,*,#62,.T.);\n\
                    #61=EDGE_CURVE('',#41,#42,#71,.T.);\n#62=EDGE_CURVE('',#42,#41,#72,.T.);\n\
                    #41=VERTEX_POINT('',#51);\n#42=VERTEX_POINT('',#52);\n#71=CIRCLE('',#10,1.);\n\
                    #72=LINE('',#52,#73);\n#73=VECTOR('',#13,1.);\n\
                    #51=CARTESIAN_POINT('',(1.,0.,0.));\n#52=CARTESIAN_POINT('',(-1.,0.,0.));\n";

/// A text with places of it, each of which it has once, as others.
fn with(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}\n{text}");
        text.replace(from, to)
    })
}

fn brep(text: &str) -> Brep {
    let (scene, _) = read(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    match scene.objects()[0].geometry() {
        Geometry::Brep(brep) => brep.clone(),
        other => panic!("{other:?}"),
    }
}

/// The area that the loop of the first face goes round about `z`, whether it is above or below the line, and where the face's normal points.
fn disc(changes: &[(&str, &str)]) -> (f64, f64, f64) {
    let brep = brep(&file("#100", &with(&format!("{AXES}{HALF}"), changes)));
    let mut points = Vec::new();
    for one in &brep.loops(0)[0] {
        let edge = brep.edge(one.edge).unwrap();
        let (a, b) = edge.range;
        let at = |k: u32| edge.curve.point(a + (b - a) * f64::from(k) / 256.0).unwrap();
        let along: Vec<Point> = (0..=256).map(at).collect();
        if one.reversed { points.extend(along.into_iter().rev()) } else { points.extend(along) }
    }
    let next = points.iter().skip(1).chain(points.first());
    let area = points.iter().zip(next).map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum();
    let height: f64 = points.iter().map(|p| p.y).sum();
    let surface = brep.surface(0).unwrap();
    let at = Location::Face(0, surface.u().domain().0, surface.v().domain().0);
    let value = |by: [usize; 2]| brep.value(at, Derivative::from(by)).unwrap();
    let normal = value([1, 0]).cross(&value([0, 1])).z * if brep.is_reversed(0) { -1.0 } else { 1.0 };
    (area, height.signum(), normal.signum())
}

/// Places of the text as others, and what comes of it: area, side and normal of [`disc`].
type Case<'a> = (Vec<(&'a str, &'a str)>, (f64, f64, f64));

#[test]
fn flags_of_curves_edges_bounds_and_faces() {
    let against = ("#41,#42,#71,.T.)", "#41,#42,#71,.F.)");
    let trimmed = |sense: &str| {
        format!(
            "#71=TRIMMED_CURVE('',#74,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(180.)),.{sense}.,.PARAMETER.);\n#74=CIRCLE('',#10,1.);"
        )
    };
    let (trim_along, trim_back) = (trimmed("T"), trimmed("F"));
    let (along, back) = (trim_along.as_str(), trim_back.as_str());
    let basis = |curve| ("#71=CIRCLE('',#10,1.);", curve);
    let reversed_loop: &[(&str, &str)] =
        &[("(#91,#92)", "(#92,#91)"), ("#61,.T.)", "#61,.F.)"), ("#62,.T.)", "#62,.F.)")];
    let bound = ("#90,.T.)", "#90,.F.)");
    let same = ("#102,.T.)", "#102,.F.)");
    let face = |flag: &'static str| match flag {
        "T" => ("(#101));", "(#103));#103=ORIENTED_FACE('',*,#101,.T.);"),
        _ => ("(#101));", "(#103));#103=ORIENTED_FACE('',*,#101,.F.);"),
    };
    let shell = |flag: &'static str| match flag {
        "T" => (
            "#100=OPEN",
            "#100=SHELL_BASED_SURFACE_MODEL('',(#105));#105=ORIENTED_OPEN_SHELL('',*,#104,.T.);#104=OPEN",
        ),
        _ => (
            "#100=OPEN",
            "#100=SHELL_BASED_SURFACE_MODEL('',(#105));#105=ORIENTED_OPEN_SHELL('',*,#104,.F.);#104=OPEN",
        ),
    };
    let half = 0.5 * PI;
    let table: Vec<Case<'_>> = vec![
        (vec![], (half, 1.0, 1.0)),
        // Against the circle the edge goes from its first end to its second over the lower half.
        (vec![against], (-half, -1.0, 1.0)),
        (vec![basis(along)], (half, 1.0, 1.0)),
        // A trimmed curve that is against its circle, and an edge that is against that.
        (vec![basis(back)], (-half, -1.0, 1.0)),
        (vec![basis(back), against], (half, 1.0, 1.0)),
        (vec![basis("#71=SURFACE_CURVE('',#74,(#102),.CURVE_3D.);#74=CIRCLE('',#10,1.);")], (half, 1.0, 1.0)),
        (reversed_loop.to_vec(), (-half, 1.0, 1.0)),
        (vec![bound], (-half, 1.0, 1.0)),
        ([reversed_loop, &[bound]].concat(), (half, 1.0, 1.0)),
        (vec![same], (half, 1.0, -1.0)),
        (vec![bound, same], (-half, 1.0, -1.0)),
        // What is turned with its face: the bounds and the normal.
        (vec![face("T")], (half, 1.0, 1.0)),
        (vec![face("F")], (-half, 1.0, -1.0)),
        (vec![face("F"), same], (-half, 1.0, 1.0)),
        (vec![face("F"), bound], (half, 1.0, -1.0)),
        (vec![shell("T")], (half, 1.0, 1.0)),
        (vec![shell("F")], (-half, 1.0, -1.0)),
        (vec![shell("F"), face("F")], (half, 1.0, 1.0)),
    ];
    for (changes, wanted) in table {
        let found = disc(&changes);
        assert!((found.0 - wanted.0).abs() < 1e-3, "{changes:?}: {found:?}");
        assert_eq!((found.1, found.2), (wanted.1, wanted.2), "{changes:?}");
    }
}

/// An edge of no face runs from its first vertex to its second, along its curve or against it.
#[test]
fn edges_alone_run_from_their_first_vertex_to_the_second() {
    let lone = |flag: &str| -> Curve {
        let text = format!("{AXES}{HALF}").replace("#71,.T.)", &format!("#71,.{flag}.)"));
        let text = text.lines().filter(|line| !line.starts_with("#100=")).collect::<Vec<_>>().join("\n");
        let (scene, _) = read(&file("#61", &text)).unwrap();
        let Geometry::Curve(curve) = scene.objects()[0].geometry() else { panic!() };
        curve.clone()
    };
    for (flag, middle) in [("T", 1.0), ("F", -1.0)] {
        let curve = lone(flag);
        let (a, b) = curve.domain();
        let found = [0.0, 0.5, 1.0].map(|t| curve.point(a + t * (b - a)).unwrap());
        let wanted = [[1.0, 0.0, 0.0], [0.0, middle, 0.0], [-1.0, 0.0, 0.0]].map(Point::from);
        for (p, q) in found.iter().zip(wanted) {
            assert!((p - q).norm() < 1e-14, "{flag}: {found:?}");
        }
    }
}

fn mesh(data: &str) -> Mesh {
    let (scene, _) = read(&file("#100", data)).unwrap();
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { panic!() };
    mesh.clone()
}

/// The corners of all triangles, by the numbers that the points have as their `x`.
fn corners(mesh: &Mesh) -> Vec<[u32; 3]> {
    let name = |&corner: &u32| mesh.points()[corner as usize].x.round() as u32;
    let mut all = Vec::new();
    for face in mesh.faces() {
        let mut three: Vec<u32> = face.iter().map(name).collect();
        // From the least on: which comes first says nothing.
        let least = (0..3).min_by_key(|&k| three[k]).unwrap();
        three.rotate_left(least);
        all.push([three[0], three[1], three[2]]);
    }
    all
}

/// ISO 10303-42: every second triangle of a strip is taken the other way round, those of a fan all share the first corner; indices go through
/// those of the face, where it has some.
#[test]
fn strips_and_fans_are_what_they_say() {
    let list =
        "#101=COORDINATES_LIST('',6,((1.,0.,0.),(2.,1.,0.),(3.,0.,0.),(4.,1.,0.),(5.,0.,7.),(6.,2.,7.)));";
    let all = |own: &str, strips: &str, fans: &str| {
        corners(&mesh(&format!(
            "#100=COMPLEX_TRIANGULATED_FACE('',#101,6,(),$,({own}),({strips}),({fans}));{list}"
        )))
    };
    assert_eq!(all("", "(1,2,3,4,5)", ""), [[1, 2, 3], [2, 4, 3], [3, 4, 5]]);
    assert_eq!(all("", "", "(1,3,4,5)"), [[1, 3, 4], [1, 4, 5]]);
    // Over a triangle without area it goes on as if that were there.
    assert_eq!(all("", "(1,2,3,3,4,5)", ""), [[1, 2, 3], [3, 5, 4]]);
    assert_eq!(all("6,4,2,1", "(1,2,3,4)", "(4,3,2)"), [[2, 6, 4], [1, 2, 4], [1, 2, 4]]);
    let set = format!("#100=COMPLEX_TRIANGULATED_SURFACE_SET('',#101,6,(),(),((1,2,3,4)),((6,5,4)));{list}");
    assert_eq!(corners(&mesh(&set)), [[1, 2, 3], [2, 4, 3], [4, 6, 5]]);
    let set = format!("#100=TRIANGULATED_SURFACE_SET('',#101,6,(),(3,5,6),((1,2,3)));{list}");
    assert_eq!(corners(&mesh(&set)), [[3, 5, 6]]);
}

/// Names, units and the orientation of hollows are in the text itself, for other programs to read.
#[test]
fn what_is_written_says_names_units_and_orientations() {
    let write = |scene: &Scene| {
        let mut memory = Memory::new("t.step", Vec::new());
        Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
        String::from_utf8(memory.bytes).unwrap()
    };
    let mut scene = Scene::new();
    let points = vec![Point::origin(), Point::new(1.0, 2.0, 3.0)];
    scene.add(Object::new("seeds", Cloud { points: points.clone() }.into())).unwrap();
    scene.add(Object::new("path", Polyline { points, closed: false }.into())).unwrap();
    for (unit, prefix) in [(Unit::Decimetre, ".DECI."), (Unit::Centimetre, ".CENTI."), (Unit::Metre, "$")] {
        scene.unit = unit;
        let text = write(&scene);
        for said in [
            format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))"),
            "=GEOMETRIC_SET('seeds',".to_owned(),
            "=GEOMETRIC_CURVE_SET('path',".to_owned(),
        ] {
            assert_eq!(text.matches(&said).count(), 1, "{said}\n{text}");
        }
        assert_eq!(read(&text).unwrap().0.unit, unit);
    }
    let hollow = format!("{}/../../tests/data/made/hollow.step", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(hollow).unwrap();
    let text = with(&text, &[("#17 = ADVANCED_FACE(''", "#17 = ADVANCED_FACE('lid'")]);
    let text = write(&read(&text).unwrap().0);
    assert_eq!(text.matches("=ADVANCED_FACE('lid',").count(), 1, "{text}");
    assert_eq!(text.matches("=ADVANCED_FACE(").count(), 7);
    // The hollow's faces look into it as they are, so that its shell is not turned round.
    let void = text.lines().find(|line| line.contains("=ORIENTED_CLOSED_SHELL(")).unwrap();
    assert!(void.ends_with(",.T.);"), "{void}");
}
