//! Ours → OBJ → ours: what the format holds comes back to the bit.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format, Memory, Parameters, ReadOptions, UpChoice, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_obj::Obj;
use loftsman_tessellation::Adaptive;
use proptest::prelude::*;

fn write(scene: &Scene, options: &WriteOptions<'_>) -> (Memory, WriteReport) {
    let mut file = Memory::new("part.obj", "");
    let report = Obj.write(scene, &mut file, options).unwrap();
    assert_eq!(report.objects.len(), scene.objects().len());
    (file, report)
}

fn read(file: &Memory) -> Scene {
    let (scene, report) = Obj.read(file, &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene
}

fn keep() -> WriteOptions<'static> {
    WriteOptions { up: UpChoice::Keep, ..WriteOptions::default() }
}

fn any_knots() -> WriteOptions<'static> {
    let own = Parameters::new(serde_json::json!({ "knots": "any" }), "options").unwrap();
    WriteOptions { own, ..keep() }
}

fn one(name: &str, geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new(name, geometry.into())).unwrap();
    scene
}

fn floating() -> Curve {
    let knots = vec![0.0, 0.5, 1.0, 2.5, 3.0, 5.0, 5.5, 7.0, 7.25];
    let points = (0..5).map(|i| Point::new(f64::from(i), f64::from(i * i) / 3.0, -0.1)).collect();
    Curve::rational(Space::open(3, knots).unwrap(), points, vec![1.0, 0.3, 2.0, 1.0, 1.5]).unwrap()
}

#[test]
fn curves_come_back_exactly_in_either_dialect() {
    let periodic = Curve::new(
        Space::periodic(3, vec![0.0, 1.0, 1.5, 3.0, 4.0, 6.0]).unwrap(),
        [(0.0, 0.0), (2.0, 0.1), (3.0, 2.0), (1.0, 4.0), (-1.0, 2.0)]
            .map(|(x, y)| Point::new(x, y, 0.5))
            .to_vec(),
    )
    .unwrap();
    for curve in [floating(), periodic.clone()] {
        let scene = one("a", &curve);
        let back = read(&write(&scene, &any_knots()).0);
        assert_eq!(back.curve("a").unwrap(), &curve);
        let back = read(&write(&scene, &keep()).0);
        let bezier = back.curve("a").unwrap();
        assert_eq!(bezier, &curve.bezier_form().unwrap());
    }
    // A cut range of a curve is the same curve on that range.
    let (file, _) = write(&one("a", floating()), &any_knots());
    let text = String::from_utf8(file.bytes).unwrap().replace("curv 2.5 5", "curv 2.75 4.5");
    let part = read(&Memory::new("p.obj", text));
    let part = part.curve("a").unwrap();
    assert_eq!(part.domain(), (2.75, 4.5));
    for k in 0..=20 {
        let u = 2.75 + 1.75 * f64::from(k) / 20.0;
        assert!((part.point(u).unwrap() - floating().point(u).unwrap()).norm() < 1e-14);
    }
}

#[test]
fn blender_needs_this_text() {
    let scene = one("my curve", floating());
    let text = String::from_utf8(write(&scene, &keep()).0.bytes).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[1], "o my curve");
    assert!(lines[2].starts_with("v ") && lines[2].split(' ').count() == 5);
    assert!(text.contains(
        "\ncstype rat bspline\ndeg 3\ncurv 2.5 5 1 2 3 4 5 6 7\nparm u 2.5 2.5 2.5 2.5 3 3 3 5 5 5 5\nend\n"
    ));
    assert!(lines.iter().all(|l| !l.ends_with(' ')));
}

#[test]
fn everything_else_comes_back() {
    let mut mesh = Mesh::new(
        vec![
            Point::new(0.1, 0.0, 0.0),
            Point::new(1.0, 1e-300, 0.0),
            Point::new(1.0, 1.0, 1e9),
            Point::new(0.0, 1.0, 0.0),
        ],
        &[vec![0, 1, 2, 3], vec![0, 3, 2]],
    )
    .unwrap();
    mesh.normals = Layer::per_point(vec![Vector::z(); 4]);
    mesh.uvs = Layer::per_point(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0 / 3.0]]);
    let mut scene = one("mesh", &mesh);
    let line = Polyline { points: mesh.points().to_vec(), closed: true };
    scene.add(Object::new("loop", (&line).into())).unwrap();
    let open = Polyline { points: mesh.points().to_vec(), closed: false };
    scene.add(Object::new("open", (&open).into())).unwrap();
    let cloud = Cloud { points: mesh.points().to_vec() };
    scene.add(Object::new("cloud", (&cloud).into())).unwrap();
    let (file, report) = write(&scene, &keep());
    assert!(report.objects.iter().all(|o| o.fate == Fate::Kept));
    let back = read(&file);
    assert_eq!(back.object("mesh").unwrap().geometry, Geometry::Mesh(mesh));
    assert_eq!(back.object("loop").unwrap().geometry, Geometry::Polyline(line));
    assert_eq!(back.object("open").unwrap().geometry, Geometry::Polyline(open));
    assert_eq!(back.object("cloud").unwrap().geometry, Geometry::Cloud(cloud));
}

#[test]
fn up_unit_and_transforms_are_in_the_numbers_and_the_report_says_so() {
    let mut scene = one("g", Geometry::Group);
    scene.unit = Unit::Millimetre;
    scene.object_mut("g").unwrap().transform =
        Some(nalgebra::Matrix4::new_translation(&Vector::new(1.0, 0.0, 0.0)));
    let mut object = Object::new("p", Cloud { points: vec![Point::new(1.0, 2.0, 3.0)] }.into());
    object.parent = Some("g".into());
    object.color = Some([1.0; 4]);
    scene.add(object).unwrap();
    let options = WriteOptions { unit: Some(Unit::Metre), ..WriteOptions::default() };
    let (file, report) = write(&scene, &options);
    let back = read(&file);
    assert_eq!(back.up, Up::Y);
    let p = back.object("p").unwrap().geometry.points()[0];
    assert!((p - Point::new(0.002, 0.003, -0.002)).norm() < 1e-18);
    let notes = report.notes.join("; ");
    assert!(notes.contains("baked") && notes.contains("hierarchy") && notes.contains("colour"));
}

#[test]
fn surfaces_are_tessellated_or_left_out_by_name() {
    let space = Space::clamped_uniform(2, 3).unwrap();
    let points = (0..9).map(|k| Point::new(f64::from(k / 3), f64::from(k % 3), f64::from(k % 2))).collect();
    let scene = one("s", Surface::new(space.clone(), space, points).unwrap());
    let (_, report) = write(&scene, &keep());
    assert_eq!(report.objects[0].fate, Fate::LeftOut);
    let tessellator = Adaptive::default();
    let fineness = Fineness { chord: Chord::Absolute(0.01), angle: 0.3 };
    let options = WriteOptions { tessellator: Some(&tessellator), fineness, ..keep() };
    let (file, report) = write(&scene, &options);
    assert_eq!((report.objects[0].fate, report.objects[0].tolerance), (Fate::Approximated, Some(0.01)));
    let back = read(&file);
    let Geometry::Mesh(mesh) = &back.object("s").unwrap().geometry else { unreachable!() };
    assert!(
        mesh.normals.values().len() == mesh.points().len() && mesh.uvs.values().len() == mesh.points().len()
    );
    assert_eq!(report.objects[0].form, format!("{} triangles", mesh.face_count()));
}

#[test]
fn flat_meshes_beside_smooth_ones_have_normals_by_face() {
    let points =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point::from).to_vec();
    let flat = Mesh::new(points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
    let mut smooth = flat.clone();
    smooth.normals = Layer::per_point(vec![Vector::x(); 4]);
    let mut scene = one("flat", &flat);
    assert!(!String::from_utf8(write(&scene, &keep()).0.bytes).unwrap().contains("vn"));
    scene.add(Object::new("smooth", (&smooth).into())).unwrap();
    let (file, report) = write(&scene, &keep());
    assert!(report.notes.iter().any(|n| n.contains("1 mesh(es) without normals")));
    assert_eq!(String::from_utf8_lossy(&file.bytes).matches("vn ").count(), 8);
    let back = read(&file);
    assert_eq!(back.object("flat").unwrap().geometry, Geometry::Mesh(flat));
    assert_eq!(back.object("smooth").unwrap().geometry, Geometry::Mesh(smooth));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn random_meshes_come_back(
        coordinates in prop::collection::vec(any::<f64>().prop_filter("finite", |x| x.is_finite()), 12..60),
        picks in prop::collection::vec(prop::collection::vec(any::<prop::sample::Index>(), 3..7), 1..12),
    ) {
        let points: Vec<Point> = coordinates.chunks_exact(3).map(|c| Point::new(c[0], c[1], c[2])).collect();
        let mut faces: Vec<Vec<usize>> = picks.iter().map(|f| f.iter().map(|i| i.index(points.len())).collect()).collect();
        // So that every point is in use.
        faces.push((0..points.len()).collect());
        let mesh = Mesh::new(points, &faces).unwrap();
        let back = read(&write(&one("m", &mesh), &keep()).0);
        prop_assert_eq!(&back.object("m").unwrap().geometry, &Geometry::Mesh(mesh));
    }
}

#[test]
fn it_is_a_format() {
    use loftsman_kernel::conformance::{format_conformance, sample_scene};
    let verdict = format_conformance(&Obj, &sample_scene());
    assert!(verdict.passed(), "{verdict}");
}
