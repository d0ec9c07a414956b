//! Every number comes back to the last bit, and the same scene gives the same bytes.

use super::common::{bits, everything, read, write};
use loftsman_kernel::mesh::{Cloud, Layer, Polyline};
use loftsman_kernel::plugin::{Confidence, Format, Memory, ReadOptions, UpChoice, WriteOptions};
use loftsman_kernel::scene::{self, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use loftsman_native::Native;
use proptest::prelude::*;

#[test]
fn everything_a_scene_holds_comes_back() {
    let scene = everything();
    let bytes = write(&scene);
    let (back, report) = read(bytes.clone()).unwrap();
    assert_eq!(bits(&back), bits(&scene));
    assert_eq!(write(&back), bytes);
    assert!(report.adds_up() && report.entities == 10 && report.kept == 10);
    assert_eq!(Native.confidence(&bytes[..40]), Confidence::Sure);
}

/// Documents as they were written before meshes had layers, materials and lines.
#[test]
fn old_documents_are_read_as_ever() {
    let text = r#"{ "loftsman": 1, "objects": [ { "name": "m", "color": [1, 0, 0, 1], "mesh": {
        "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]], "normals": [[0, 0, 1], [0, 0, 1], [0, 0, 1]],
        "uvs": [[0, 0], [1, 0], [0, 1]], "colors": [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]] } } ] }"#;
    let (scene, _) = read(text).unwrap();
    let Geometry::Mesh(mesh) = scene.object("m").unwrap().geometry() else { panic!("no mesh") };
    assert_eq!(mesh.normals, Layer::per_point(vec![Vector::z(); 3]));
    assert_eq!((mesh.uvs.values()[2], mesh.colors.values()[1][1]), ([0.0, 1.0], 1.0));
    assert!(scene.materials.is_empty() && scene.images.is_empty());
    assert!(mesh.lines().next().is_none() && mesh.materials.is_empty());
}

/// What a document says of layers, labels and units, as people write it; without them it is as it was.
#[test]
fn layers_and_labels_are_written_as_they_are_read() {
    let text = r#"{
  "loftsman": 1,
  "unit": "0.3 m",
  "up": "z",
  "layers": [
    {
      "name": "bolts",
      "color": [1, 0, 0, 1],
      "visible": false,
      "parent": "steel"
    },
    {
      "name": "steel"
    }
  ],
  "objects": [
    {
      "name": "bolt",
      "layer": "bolts",
      "group": {}
    },
    {
      "name": "bolt.001",
      "label": "bolt",
      "layer": "not listed",
      "group": {}
    }
  ]
}
"#;
    let (scene, report) = read(text).unwrap();
    assert_eq!((String::from_utf8(write(&scene)).unwrap().as_str(), report.notes.len()), (text, 0));
    assert_eq!(scene.layers.len(), 2);
    assert_eq!(scene.all_layers().iter().map(|l| l.name().to_owned()).collect::<Vec<_>>()[2], "not listed");
    let labels: Vec<_> = scene.objects().iter().map(Object::label).collect();
    assert_eq!(labels, ["bolt", "bolt"]);
    let mut renamed = scene.clone();
    renamed.rename("bolt.001", "screw").unwrap();
    assert_eq!((renamed.objects()[1].label(), renamed.objects()[1].label.as_deref()), ("screw", None));
    // Only named, layers are not listed in the document.
    let old = text.find("  \"layers\"").unwrap()..text.find("  \"objects\"").unwrap();
    let mut plain = text.to_owned();
    plain.replace_range(old, "");
    assert_eq!(String::from_utf8(write(&read(plain.clone()).unwrap().0)).unwrap(), plain);
}

#[test]
fn the_text_is_what_people_can_read() {
    let mut scene = Scene::new();
    let points = vec![Point::new(0.0, -0.0, 5e-324), Point::new(1e23, 0.1, -3.0)];
    scene
        .add(Object::new("a", Curve::new(Space::clamped_uniform(1, 2).unwrap(), points).unwrap().into()))
        .unwrap();
    let expected = r#"{
  "loftsman": 1,
  "unit": "m",
  "up": "z",
  "objects": [
    {
      "name": "a",
      "curve": {
        "degree": 1,
        "periodic": false,
        "knots": [0, 0, 1, 1],
        "points": [
          [0, -0.0, 5e-324],
          [1e+23, 0.1, -3]
        ]
      }
    }
  ]
}
"#;
    assert_eq!(String::from_utf8(write(&scene)).unwrap(), expected);
}

#[test]
fn numbers_may_be_written_in_any_way_that_json_has() {
    let text = r#"{ "objects": [ { "curve": { "points": [[0.0, 1E2, 1.0e+2], [-0, 18446744073709551616, 1e-400]],
        "weights": [1, 1.0], "knots": [0, 0.0, 1, 1e0], "degree": 1.0 }, "name": "a" } ], "loftsman": 1.0 }"#;
    let (scene, _) = read(text).unwrap();
    let points = scene.curve("a").unwrap().points();
    assert_eq!(points[0], Point::new(0.0, 100.0, 100.0));
    assert!(points[1].x == 0.0 && points[1].x.is_sign_negative());
    assert_eq!((points[1].y, points[1].z), (18_446_744_073_709_551_616.0, 0.0));
    assert_eq!((scene.unit, scene.up), (Unit::Metre, Up::Z));
}

#[test]
fn another_unit_and_axis_on_the_way_out() {
    let mut scene = Scene::new();
    scene.add(Object::new("p", Cloud { points: vec![Point::new(1.0, 2.0, 3.0)] }.into())).unwrap();
    let mut sink = Memory::new("p.loft.json", "");
    let options =
        WriteOptions { unit: Some(Unit::Millimetre), up: UpChoice::To(Up::Y), ..WriteOptions::default() };
    Native.write(&scene, &mut sink, &options).unwrap();
    let (back, _) = Native.read(&sink, &ReadOptions::default()).unwrap();
    assert_eq!((back.unit, back.up), (Unit::Millimetre, Up::Y));
    assert_eq!(back.objects()[0].geometry().points()[0], Point::new(1000.0, 3000.0, -2000.0));
    // Noted otherwise on the way in: the numbers stay.
    let options = ReadOptions { unit: Some(Unit::Inch), ..ReadOptions::default() };
    let (noted, report) = Native.read(&sink, &options).unwrap();
    assert_eq!((noted.unit, report.notes.len()), (Unit::Inch, 1));
    assert_eq!(noted.objects()[0].geometry().points()[0], Point::new(1000.0, 3000.0, -2000.0));
}

/// Any finite number, small ones and zeros of both signs often.
fn number() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![
        POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO,
        -1.0..1.0,
        (-1_000_000..1_000_000_i64).prop_map(|i| i as f64),
        Just(9_007_199_254_740_993.0),
        Just(f64::MAX),
    ]
}

fn point() -> impl Strategy<Value = Point> {
    (number(), number(), number()).prop_map(|(x, y, z)| Point::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_tree_of_layers_and_any_unit_come_back(
        layers in prop::collection::vec(
            ("\\PC{1,12}", any::<bool>(), any::<prop::sample::Index>(), any::<bool>(), prop::option::of([number(), number(), number(), number()])),
            0..12,
        ),
        on in prop::collection::vec((any::<prop::sample::Index>(), prop::option::of("\\PC{1,8}")), 0..6),
        metres in 1e-300..1e300_f64,
    ) {
        let mut scene = Scene::new();
        scene.unit = Unit::of_metres(metres).unwrap();
        for (number, (name, visible, above, is_below, color)) in layers.iter().enumerate() {
            let mut layer = scene::Layer::new(scene.layers.unique_name(name));
            (layer.visible, layer.color) = (*visible, *color);
            // Below one before it: no circle.
            if *is_below && number > 0 {
                layer.parent = Some(scene.layers.as_slice()[above.index(number)].name().to_owned());
            }
            scene.layers.add(layer).unwrap();
        }
        for (number, (layer, label)) in on.iter().enumerate() {
            let mut object = Object::new(format!("{number}"), Geometry::Group);
            object.label.clone_from(label);
            if !scene.layers.is_empty() {
                object.layer = Some(scene.layers.as_slice()[layer.index(scene.layers.len())].name().to_owned());
            }
            scene.add(object).unwrap();
        }
        scene.check().unwrap();
        let bytes = write(&scene);
        let (back, _) = read(bytes.clone()).unwrap();
        prop_assert_eq!(bits(&back), bits(&scene));
        prop_assert_eq!(write(&back), bytes);
        // A layer is hidden where one on the way up is.
        let hidden = scene.hidden_layers();
        for layer in &scene.layers {
            let up = std::iter::successors(Some(layer), |l| scene.layers.get(l.parent.as_deref()?));
            prop_assert_eq!(hidden.contains(layer.name()), up.into_iter().any(|l| !l.visible));
        }
    }

    #[test]
    fn any_points_come_back_to_the_bit(
        points in prop::collection::vec(point(), 0..40), closed: bool, name in "\\PC{1,20}") {
        let mut scene = Scene::new();
        scene.add(Object::new(name, Polyline { points, closed }.into())).unwrap();
        let bytes = write(&scene);
        let (back, _) = read(bytes.clone()).unwrap();
        prop_assert_eq!(bits(&back), bits(&scene));
        prop_assert_eq!(write(&back), bytes);
    }

    #[test]
    fn any_spline_comes_back_to_the_bit(
        degree in 1..6_usize,
        periodic: bool,
        mut knots in prop::collection::vec(-1e3..1e3_f64, 12..30),
        scale in prop_oneof![Just(1e-300), Just(1.0), Just(1e300)],
        seed in prop::collection::vec((point(), 1e-9..1e9_f64), 30),
    ) {
        knots.sort_by(f64::total_cmp);
        knots.iter_mut().for_each(|k| *k *= scale);
        let space = if periodic { Space::periodic(degree, knots) } else { Space::open(degree, knots) }.unwrap();
        let (points, weights) = seed.into_iter().take(space.len()).unzip();
        let mut scene = Scene::new();
        scene.add(Object::new("c", Curve::rational(space, points, weights).unwrap().into())).unwrap();
        let (back, _) = read(write(&scene)).unwrap();
        prop_assert_eq!(bits(&back), bits(&scene));
    }
}

#[test]
fn a_large_document_keeps_its_size_in_hand() {
    let mut scene = Scene::new();
    let points: Vec<Point> = (0..100_000)
        .map(|i| {
            let t = f64::from(i) * 1e-3;
            Point::from(Vector::new(t.cos(), t.sin(), t))
        })
        .collect();
    let space = Space::clamped_uniform(3, points.len()).unwrap();
    scene.add(Object::new("long", Curve::new(space, points).unwrap().into())).unwrap();
    let bytes = write(&scene);
    let (back, _) = read(bytes).unwrap();
    assert!(back == scene);
}
