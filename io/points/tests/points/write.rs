//! What is written reads back, to the bit.

use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{
    Confidence, Fate, Format, FormatError, Memory, Parameters, UpChoice, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::{Point, Vector};
use loftsman_points::Points;
use proptest::prelude::*;

use super::common::{polyline, read};

fn write(
    scene: &Scene,
    name: &str,
    options: &WriteOptions<'_>,
) -> Result<(String, WriteReport), FormatError> {
    let mut sink = Memory::new(name, "");
    let report = Points.write(scene, &mut sink, options)?;
    Ok((String::from_utf8(sink.bytes).unwrap(), report))
}

fn square() -> Object {
    let points = [[0.0, -0.0], [1.0, 0.0], [1.0, 0.1]].map(|[x, y]| Point::new(x, y, 1e-300)).to_vec();
    Object::new("square \"1\"", Polyline { points, closed: true }.into())
}

#[test]
fn the_text_is_plain() {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    scene.add(square()).unwrap();
    scene.add(Object::new("dust", Cloud { points: vec![Point::new(1e16, 2.0, 3.0)] }.into())).unwrap();
    let (text, report) = write(&scene, "a.csv", &WriteOptions::default()).unwrap();
    let expected = "x,y,z\n# loftsman points, unit mm, z up\n# closed polyline \"square \\\"1\\\"\"\n0,-0.0,1e-300\n\
                    1,0,1e-300\n1,0.1,1e-300\n0,-0.0,1e-300\n# cloud \"dust\"\n1e+16,2,3\n";
    assert_eq!(text, expected);
    assert!(report.objects.iter().all(|o| o.fate == Fate::Kept));
    let (back, report) = read("a.csv", text).unwrap();
    assert_eq!(format!("{:?}", back.objects()), format!("{:?}", scene.objects()));
    assert_eq!((back.unit, report.adds_up()), (Unit::Millimetre, true));
    assert_eq!(Points.confidence(expected.as_bytes()), Confidence::Sure);
}

#[test]
fn bare_rows_without_comments() {
    let mut scene = Scene::new();
    scene.add(square()).unwrap();
    let own = Parameters::new(serde_json::json!({ "comments": false }), "options").unwrap();
    let options = WriteOptions { own, ..WriteOptions::default() };
    let (text, _) = write(&scene, "a.xyz", &options).unwrap();
    assert_eq!(text, "0 -0.0 1e-300\n1 0 1e-300\n1 0.1 1e-300\n0 -0.0 1e-300\n");
    let (back, _) = read("a.dat", text).unwrap();
    assert_eq!((polyline(&back).0.len(), polyline(&back).1), (3, true));
    scene.add(Object::new("dust", Cloud::default().into())).unwrap();
    assert!(write(&scene, "a.xyz", &options).unwrap_err().problem.contains("several objects"));
}

#[test]
fn what_has_no_place_is_left_out_and_told() {
    let mut scene = Scene::new();
    let mut group = Object::new("group", Geometry::Group);
    group.transform = Some(nalgebra_translation(10.0));
    scene.add(group).unwrap();
    let mesh = Mesh::new(vec![Point::origin(); 3], &[[0, 1, 2]]).unwrap();
    scene.add(Object::new("mesh", mesh.into())).unwrap();
    let error = write(&scene, "a.xyz", &WriteOptions::default()).unwrap_err();
    assert!(error.problem.contains("no polyline and no cloud"));
    let mut dust = Object::new("dust", Cloud { points: vec![Point::new(1.0, 2.0, 3.0)] }.into());
    dust.parent = Some("group".into());
    dust.color = Some([1.0; 4]);
    scene.add(dust).unwrap();
    let options =
        WriteOptions { unit: Some(Unit::Millimetre), up: UpChoice::To(Up::Y), ..WriteOptions::default() };
    let (text, report) = write(&scene, "a.xyz", &options).unwrap();
    assert!(text.ends_with("# cloud \"dust\"\n11000 3000 -2000\n"), "{text}");
    let fates: Vec<_> = report.objects.iter().map(|o| (o.object.as_str(), o.fate)).collect();
    assert_eq!(fates, [("group", Fate::LeftOut), ("mesh", Fate::LeftOut), ("dust", Fate::Kept)]);
    assert!(report.objects[1].reason.as_ref().unwrap().contains("not a mesh"));
    assert!(report.losses.iter().any(|note| note.contains("colour")), "{report:?}");
    scene.replace("dust", Cloud { points: vec![Point::new(f64::NAN, 0.0, 0.0)] }).unwrap();
    let error = write(&scene, "a.xyz", &options).unwrap_err();
    assert!(error.to_string().contains("\"dust\""), "{error}");
}

fn nalgebra_translation(x: f64) -> nalgebra::Matrix4<f64> {
    nalgebra::Matrix4::new_translation(&Vector::new(x, 0.0, 0.0))
}

proptest! {
    #[test]
    fn any_objects_come_back_to_the_bit(
        lines in prop::collection::vec(
            (prop::collection::vec(prop::array::uniform3(finite()), 0..6), 0..3, "\\PC{0,9}"),
            1..4,
        ),
        csv: bool,
    ) {
        let mut scene = Scene::new();
        for (points, kind, name) in lines {
            let points: Vec<Point> = points.into_iter().map(Point::from).collect();
            let geometry = match kind {
                0 => Cloud { points }.into(),
                kind => Polyline { points, closed: kind == 2 }.into(),
            };
            let name = scene.unique_name(&name);
            scene.add(Object::new(name, geometry)).unwrap();
        }
        let name = if csv { "a.csv" } else { "a.xyz" };
        let (text, _) = write(&scene, name, &WriteOptions::default()).unwrap();
        let (back, report) = read(name, text.clone()).unwrap();
        prop_assert_eq!(format!("{:?}", back.objects()), format!("{:?}", scene.objects()));
        prop_assert!(report.adds_up());
        prop_assert_eq!(write(&back, name, &WriteOptions::default()).unwrap().0, text);
    }
}

fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO, Just(-0.0), -2.0..2.0]
}
