//! Breps: every field there and back, and what cannot be one.

use super::common::{bits, read, write};
use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Vertex};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use proptest::prelude::*;

fn frame() -> Frame {
    Frame::new(Point::new(0.1, -0.0, 5e-324), Vector::new(0.3, 0.2, 1.0), Vector::x()).unwrap()
}

/// A line in the parameter plane, and a part of it.
fn plane_line() -> ParameterCurve {
    let line = Curve::line(Point::new(1.0 / 3.0, -0.0, 0.0), Point::new(0.9, 0.1, 0.0)).unwrap();
    ParameterCurve::new(line, 0.125, 0.7).unwrap()
}

/// A block with a hollow, and beside it faces and edges with everything that they may have.
pub(crate) fn everything() -> Brep {
    let mut parts = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap().parts();
    let hollow = Brep::block(Point::new(0.5, 0.5, 0.25), Point::new(1.0, 1.0 / 0.7, 0.75)).unwrap().parts();
    let (vertices, edges, faces) = (parts.vertices.len(), parts.edges.len(), parts.faces.len());
    parts.vertices.extend(hollow.vertices);
    parts.edges.extend(hollow.edges.into_iter().map(|e| Edge { ends: e.ends.map(|v| v + vertices), ..e }));
    for mut face in hollow.faces {
        face.reversed = true;
        for chain in &mut face.loops {
            chain.reverse();
            chain.iter_mut().for_each(|one| (one.edge, one.reversed) = (one.edge + edges, !one.reversed));
        }
        parts.faces.push(face);
    }
    parts.shells.push(Shell { faces: (faces..parts.faces.len()).collect() });
    parts.solids = vec![Solid { name: Some("body \"1\"\n".into()), outer: 0, voids: vec![1] }];
    parts.faces[0].name = Some("top é".into());
    parts.faces[0].color = Some([0.1, 1.0 / 3.0, -0.0, 0.5]);
    parts.faces[0].loops[0][1].parameters = Some(plane_line());
    parts.faces[1].points = vec![3, 0];
    parts.vertices[2].tolerance = 1e-7 / 3.0;
    parts.edges[4].tolerance = 5e-324;
    // A closed edge on a periodic curve, that runs on beyond the seam, and is no face's.
    let ring = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
    let (start, end) = ring.domain();
    let over = (start + 0.3 * (end - start), start + 1.3 * (end - start));
    for (form, range) in [
        (CurveForm::Spline, if ring.is_periodic() { over } else { (start, end) }),
        (CurveForm::Circle { frame: frame(), radius: 1.0 / 3.0 }, (start, end)),
        (CurveForm::Ellipse { frame: frame(), radii: [0.1, 1e300] }, (0.1 / 3.0, 0.7)),
    ] {
        let vertex = parts.vertices.len();
        parts.vertices.push(Vertex { point: ring.point(range.0).unwrap(), tolerance: 0.0 });
        parts.edges.push(Edge { curve: ring.clone(), range, ends: [vertex; 2], tolerance: 0.0, form });
    }
    let space = Space::periodic(3, vec![0.1, 0.7, 1.3, 2.9, 3.3]).unwrap();
    let net = (0..4).map(|k| Point::new(f64::from(k) / 3.0, f64::from(k * k), -0.0)).collect();
    let loose = Curve::rational(space, net, vec![1.0, 0.7, 2.5, 1e-3]).unwrap();
    let vertex = parts.vertices.len();
    parts.vertices.push(Vertex { point: loose.point(1.3).unwrap(), tolerance: 1e300 });
    let (range, form) = ((1.3, 4.5), CurveForm::Line);
    parts.edges.push(Edge { curve: loose, range, ends: [vertex; 2], tolerance: 0.0, form });
    // Whole surfaces of every form, in no shell.
    let (frame, radius) = (frame(), 1.0 / 3.0);
    let sphere = SurfaceForm::Sphere { frame, radius }.covering(&[]).unwrap();
    let u = Space::clamped_uniform(2, 3).unwrap();
    let v = Space::periodic_uniform(1, 3).unwrap();
    let net = (0..9).map(|k| Point::new(f64::from(k), 0.1, 1.0 / f64::from(k + 1))).collect();
    let loose = Surface::new(u, v, net).unwrap();
    for (form, surface, reversed) in [
        (SurfaceForm::Spline, &loose, true),
        (SurfaceForm::Cylinder { frame, radius }, &sphere, false),
        (SurfaceForm::Cone { frame, radius: 0.0, angle: 0.1 }, &sphere, true),
        (SurfaceForm::Sphere { frame, radius }, &sphere, false),
        (SurfaceForm::Torus { frame, major: 2.0, minor: radius }, &sphere, true),
    ] {
        let (name, surface) = (Some(String::new()), surface.clone());
        let face = Face { name, color: None, surface, form, reversed, loops: vec![], points: vec![] };
        parts.faces.push(face);
    }
    parts.shells.push(Shell { faces: vec![parts.faces.len() - 1, parts.faces.len() - 3] });
    parts.shells.push(Shell::default());
    Brep::new(parts).unwrap()
}

fn scene(brep: Brep) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("part", brep.into())).unwrap();
    scene
}

#[test]
fn every_field_of_a_brep_comes_back() {
    let scene = scene(everything());
    let bytes = write(&scene);
    let (back, report) = read(bytes.clone()).unwrap();
    assert_eq!(bits(&back), bits(&scene));
    assert_eq!(write(&back), bytes);
    assert!(report.adds_up() && report.kept == 1);
    // What says nothing is not written.
    let text = String::from_utf8(bytes).unwrap();
    for (word, times) in
        [("\"reversed\": false", 0), ("\"tolerance\"", 3), ("\"voids\"", 1), ("\"color\"", 1)]
    {
        assert_eq!(text.matches(word).count(), times, "{word}");
    }
}

/// Every form that edges and faces may have comes back to the last bit, with the form of what is swept.
#[test]
fn forms_of_every_kind_come_back() {
    let frame = Frame::new(Point::new(0.1, -2.0, 1e-9), Vector::new(1.0, 2.0, 0.3), Vector::x()).unwrap();
    let curves = [
        CurveForm::Spline,
        CurveForm::Line,
        CurveForm::Circle { frame, radius: 1.0 / 3.0 },
        CurveForm::Ellipse { frame, radii: [3.0, 0.1] },
        CurveForm::Parabola { frame, focal: 1e-7 },
        CurveForm::Hyperbola { frame, radii: [1e9, 0.7] },
    ];
    let mut surfaces = vec![
        SurfaceForm::Spline,
        SurfaceForm::Plane { frame },
        SurfaceForm::Cylinder { frame, radius: 0.3 },
        SurfaceForm::Cone { frame, radius: 0.0, angle: 0.3 },
        SurfaceForm::Sphere { frame, radius: 0.3 },
        SurfaceForm::Torus { frame, major: 0.3, minor: 0.7 },
    ];
    for profile in curves {
        surfaces.push(SurfaceForm::Extrusion { along: Vector::new(0.1, -0.2, 1e-8), profile });
        surfaces.push(SurfaceForm::Revolution { frame, profile });
    }
    let block = Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0)).unwrap();
    for (k, &form) in surfaces.iter().enumerate() {
        let mut parts = block.parts();
        parts.faces[k % 6].form = form;
        parts.edges[k % 12].form = curves[k % curves.len()];
        let scene = scene(Brep::new(parts).unwrap());
        assert_eq!(bits(&read(write(&scene)).unwrap().0), bits(&scene), "{form:?}");
    }
}

#[test]
fn nothing_is_a_brep_too() {
    let empty = scene(Brep::new(Parts::default()).unwrap());
    assert_eq!(bits(&read(write(&empty)).unwrap().0), bits(&empty));
    let (back, _) = read(r#"{ "loftsman": 1, "objects": [ { "name": "part", "brep": {} } ] }"#).unwrap();
    assert_eq!(bits(&back), bits(&empty));
}

const SPACE: &str = r#"{ "degree": 1, "knots": [0, 0, 1, 1] }"#;
const LINE: &str = r#""curve": { "degree": 1, "knots": [0, 0, 1, 1], "points": [[0, 0, 0], [1, 0, 0]] }"#;

fn surface() -> String {
    format!(r#""surface": {{ "u": {SPACE}, "v": {SPACE}, "points": [[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0]]] }}"#)
}

/// The message of a Brep of two vertices and these fields.
fn refused(fields: &str) -> String {
    let vertices = r#""vertices": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }]"#;
    read(format!(
        r#"{{ "loftsman": 1, "objects": [ {{ "name": "a", "brep": {{ {vertices}, {fields} }} }} ] }}"#
    ))
    .unwrap_err()
    .to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    for part in parts.iter().chain(&["object \"a\""]) {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
    assert!(message.chars().count() < 400, "too long: {message}");
}

#[test]
fn parts_that_cannot_be_say_which() {
    let vertex = |fields: &str| refused(&format!(r#""vertices": [{fields}]"#));
    says(&vertex("{}"), &["there twice"]);
    let document = |text: &str| {
        read(format!(r#"{{ "loftsman": 1, "objects": [ {{ "name": "a", "brep": {text} }} ] }}"#))
            .unwrap_err()
            .to_string()
    };
    says(&document(r#"{ "vertices": [{}] }"#), &["objects[0].brep.vertices[0]", "\"at\""]);
    says(&document(r#"{ "vertices": [{ "at": [0, 1] }] }"#), &["brep.vertices[0].at", "2 numbers"]);
    says(
        &document(r#"{ "vertices": [{ "at": [0, 0, 0], "tolerance": -1 }] }"#),
        &["objects[0].brep,", "vertex 0: the tolerance -1 is no length"],
    );
    says(&document(r#"{ "vertexes": [] }"#), &["objects[0].brep", "did you mean \"vertices\"?"]);
    says(&document("[]"), &["objects[0].brep", "a brep"]);

    let edge = |fields: &str| refused(&format!(r#""edges": [{{ {LINE}, {fields} }}]"#));
    says(&edge(r#""from": 0"#), &["brep.edges[0]", "\"vertices\""]);
    says(&refused(r#""edges": [{ "vertices": [0, 1] }]"#), &["brep.edges[0]", "\"curve\""]);
    says(&edge(r#""vertices": [0]"#), &["brep.edges[0].vertices", "1 vertices", "at its end"]);
    says(&edge(r#""vertices": [0, 2]"#), &["objects[0].brep,", "edge 0: it names vertex 2", "2 vertices"]);
    says(&edge(r#""vertices": [0, -1]"#), &["brep.edges[0].vertices[1]", "-1"]);
    says(&edge(r#""vertices": [0, 1.5]"#), &["brep.edges[0].vertices[1]", "1.5"]);
    says(&edge(r#""vertices": [0, 4294967296]"#), &["brep.edges[0].vertices[1]", "4294967296"]);
    says(
        &edge(r#""vertices": [0, 1], "to": 1.5"#),
        &["objects[0].brep,", "edge 0", "from 0 to 1.5", "at most 1"],
    );
    says(&edge(r#""vertices": [0, 1], "from": 1, "to": 0"#), &["objects[0].brep,", "edge 0", "from 1 to 0"]);
    says(&edge(r#""vertices": [0, 1], "from": 2"#), &["objects[0].brep,", "edge 0", "2"]);
    let form = |fields: &str| edge(&format!(r#""vertices": [0, 1], "form": {{ {fields} }}"#));
    says(&form(r#""radius": 1"#), &["edges[0].form", "\"kind\""]);
    says(&form(r#""kind": "circel""#), &["edges[0].form.kind", "did you mean \"circle\"?"]);
    says(&form(r#""kind": "circle", "radius": 1"#), &["edges[0].form", "\"origin\""]);
    says(&form(r#""kind": "extrusion", "along": [0, 0, 1]"#), &["edges[0].form.kind", "no kind of curve"]);
    says(&form(r#""kind": "extrusion""#), &["edges[0].form", "\"along\""]);
    let nested =
        r#""kind": "extrusion", "along": [0, 0, 1], "profile": { "kind": "extrusion", "along": [0, 0, 1] }"#;
    says(&form(nested), &["edges[0].form.profile.kind", "no kind of curve"]);
    let at = r#""origin": [0, 0, 0], "x": [1, 0, 0], "z": [0, 0, 1]"#;
    says(
        &form(&format!(r#""kind": "sphere", {at}, "radius": 1"#)),
        &["edges[0].form.kind", "no kind of curve"],
    );
    says(&form(&format!(r#""kind": "circle", {at}"#)), &["edges[0].form", "\"radius\""]);
    says(
        &form(&format!(r#""kind": "circle", {at}, "radius": 0"#)),
        &["objects[0].brep,", "edge 0", "a radius of 0"],
    );
    let bent = r#""origin": [0, 0, 0], "x": [1, 0, 0], "z": [1, 0, 0]"#;
    says(
        &form(&format!(r#""kind": "circle", {bent}, "radius": 1"#)),
        &["objects[0].brep,", "edge 0", "right angles"],
    );
    says(&form(&format!(r#""kind": "ellipse", {at}, "radii": [1]"#)), &["edges[0].form.radii", "1 numbers"]);
}

#[test]
fn faces_and_loops_that_cannot_be_say_which() {
    let surface = surface();
    let face = |fields: &str| {
        let edges =
            format!(r#""edges": [{{ {LINE}, "vertices": [0, 1] }}, {{ {LINE}, "vertices": [1, 0] }}]"#);
        refused(&format!(r#"{edges}, "faces": [{{ {surface}, {fields} }}]"#))
    };
    let chain = |uses: &str| face(&format!(r#""loops": [{uses}]"#));
    says(&chain("[]"), &["objects[0].brep,", "face 0: loop 0: it has no edges"]);
    says(&chain(r#"[{ "edge": 2 }]"#), &["objects[0].brep,", "face 0: loop 0: it names edge 2", "2 edges"]);
    says(&chain(r#"[{ "edge": 0 }]"#), &["face 0: loop 0", "does not close", "ends at vertex 1"]);
    says(
        &chain(r#"[{ "edge": 0 }, { "edge": 1 }], [{ "edge": 0 }, { "edge": 1, "reversed": true }]"#),
        &["face 0: loop 1", "it is torn"],
    );
    says(&chain(r#"[{ "edge": -1 }]"#), &["brep.faces[0].loops[0][0].edge", "-1"]);
    says(&chain(r#"[{ "edge": 0 }, {}]"#), &["brep.faces[0].loops[0][1]", "\"edge\""]);
    says(&chain(r#"[{ "edge": 0, "reversed": 1 }]"#), &["brep.faces[0].loops[0][0].reversed"]);
    says(
        &chain(r#"[{ "edge": 0, "parameters": { "from": 0 } }]"#),
        &["brep.faces[0].loops[0][0].parameters", "\"curve\""],
    );
    says(&face(r#""points": [0, 5]"#), &["objects[0].brep,", "face 0: it names vertex 5"]);
    says(&face(r#""color": [1, 0, 0]"#), &["brep.faces[0].color", "3 numbers"]);
    says(&face(r#""form": { "kind": "line" }"#), &["brep.faces[0].form.kind", "no kind of surface"]);
    says(&refused(r#""faces": [{ "name": "x" }]"#), &["brep.faces[0]", "\"surface\""]);
    let whole = format!(r#""faces": [{{ {surface} }}]"#);
    says(&refused(&format!(r#"{whole}, "shells": [[1]]"#)), &["shell 0: it names face 1", "1 faces"]);
    says(&refused(&format!(r#"{whole}, "shells": [[0], [0]]"#)), &["shell 1: face 0 is in shell 0 already"]);
    says(&refused(&format!(r#"{whole}, "solids": [{{}}]"#)), &["brep.solids[0]", "\"outer\""]);
    says(&refused(&format!(r#"{whole}, "solids": [{{ "outer": 0 }}]"#)), &["solid 0: it names shell 0"]);
    let solid = format!(r#"{whole}, "shells": [[0]], "solids": [{{ "outer": 0 }}]"#);
    says(&refused(&solid), &["solid 0", "without loops on a surface that does not close"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any block, at any size, with any tolerance, name and colour.
    #[test]
    fn any_block_comes_back_to_the_bit(
        low in prop::array::uniform3(-1e3..1e3_f64),
        sides in prop::array::uniform3(1e-3..1e3_f64),
        scale in prop_oneof![Just(1e-100), Just(1.0), Just(1e100)],
        tolerance in prop_oneof![Just(0.0), 0.0..1.0_f64, Just(f64::MIN_POSITIVE), Just(f64::MAX)],
        name in "\\PC{0,12}",
        color in prop::array::uniform4(-1.0..2.0_f64),
    ) {
        let at = |k: f64| Point::from(Vector::from(low) + Vector::from(sides) * k) * scale;
        let mut parts = Brep::block(at(0.0), at(1.0)).unwrap().parts();
        parts.vertices[7].tolerance = tolerance;
        (parts.faces[5].name, parts.faces[5].color) = (Some(name), Some(color));
        let scene = scene(Brep::new(parts).unwrap());
        let bytes = write(&scene);
        let (back, _) = read(bytes.clone()).unwrap();
        prop_assert_eq!(bits(&back), bits(&scene));
        prop_assert_eq!(write(&back), bytes);
    }

    /// Any byte of it changed: a scene or one error.
    #[test]
    fn a_changed_byte_never_panics(at in 0.0..1.0_f64, byte: u8) {
        let mut bytes = write(&scene(everything()));
        let at = (bytes.len() as f64 * at) as usize;
        bytes[at] = byte;
        if let Err(error) = read(bytes) {
            prop_assert!(!error.problem.is_empty());
        }
    }
}
