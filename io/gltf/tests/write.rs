//! What is written, read back by the crate `gltf`.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use gltf::mesh::Mode;
use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::{Cloud, Mesh, Polyline};
use loftsman_kernel::plugin::{Fate, Format, Memory, Parameters, UpChoice, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion};

fn try_write(scene: &Scene, name: &str, options: WriteOptions<'_>) -> (Memory, WriteReport) {
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..options };
    let mut file = Memory::new(name, "");
    let report = Gltf.write(scene, &mut file, &options).unwrap();
    assert_eq!(report.objects.len(), scene.objects().len());
    (file, report)
}

fn write(scene: &Scene) -> (gltf::Document, Vec<u8>, WriteReport) {
    let (file, report) = try_write(scene, "part.glb", WriteOptions::default());
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    (document, blob.unwrap_or_default(), report)
}

fn one(name: &str, geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new(name, geometry.into())).unwrap();
    scene
}

/// Positions of every node's primitive in the world, by name; transforms in double precision, as the file has them.
fn world(file: &Memory) -> Vec<(String, Vec<Point>)> {
    let length = u32::from_le_bytes(file.bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&file.bytes[20..20 + length]).unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let numbers = |node: usize, field: &str, default: &[f64]| -> Vec<f64> {
        json["nodes"][node][field]
            .as_array()
            .map_or(default.to_vec(), |l| l.iter().map(|x| x.as_f64().unwrap()).collect())
    };
    let mut out = Vec::new();
    let mut open: Vec<_> =
        document.default_scene().unwrap().nodes().map(|n| (n, Matrix4::<f64>::identity())).collect();
    while let Some((node, above)) = open.pop() {
        let t = numbers(node.index(), "translation", &[0.0; 3]);
        let r = numbers(node.index(), "rotation", &[0.0, 0.0, 0.0, 1.0]);
        let s = numbers(node.index(), "scale", &[1.0; 3]);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(r[3], r[0], r[1], r[2]));
        let map = above
            * Matrix4::new_translation(&Vector::new(t[0], t[1], t[2]))
            * rotation.to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&Vector::new(s[0], s[1], s[2]));
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let positions = primitive.reader(|_| blob.as_deref()).read_positions().unwrap();
                let points = positions.map(|p| map.transform_point(&Point::from(p.map(f64::from)))).collect();
                out.push((node.name().unwrap().to_owned(), points));
            }
        }
        open.extend(node.children().map(|c| (c, map)));
    }
    out
}

fn circle() -> Curve {
    let h = 0.5_f64.sqrt();
    let points = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
        .map(|(x, y)| Point::new(f64::from(x), f64::from(y), 0.25));
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
    let weights = vec![1.0, h, 1.0, h, 1.0, h, 1.0, h, 1.0];
    Curve::rational(Space::open(2, knots).unwrap(), points.to_vec(), weights).unwrap()
}

#[test]
fn curves_are_closed_strips_and_carry_themselves_exactly() {
    let (document, blob, report) = write(&one("ring", circle()));
    let node = document.nodes().next().unwrap();
    let primitive = node.mesh().unwrap().primitives().next().unwrap();
    assert_eq!((node.name(), primitive.mode()), (Some("ring"), Mode::LineStrip));
    let indices: Vec<u32> = primitive.reader(|_| Some(&blob)).read_indices().unwrap().into_u32().collect();
    assert_eq!(indices.first(), indices.last());
    // z up in metres becomes y up: (x, y, z) → (x, z, -y).
    let (file, _) = try_write(&one("ring", circle()), "part.glb", WriteOptions::default());
    for p in &world(&file)[0].1 {
        assert!((p.y - 0.25).abs() < 1e-6 && (p.x.hypot(p.z) - 1.0).abs() < 1e-6);
    }
    assert_eq!(report.objects[0].fate, Fate::Approximated);
    assert!(report.objects[0].tolerance.unwrap() > 0.0);
    let extras: serde_json::Value = serde_json::from_str(node.extras().as_ref().unwrap().get()).unwrap();
    let exact: serde_json::Value = serde_json::from_str(extras["loftsman"].as_str().unwrap()).unwrap();
    assert_eq!(exact["curve"]["degree"], 2);
    let weight: f64 = serde_json::from_value(exact["curve"]["weights"][1].clone()).unwrap();
    assert_eq!(weight.to_bits(), 0.5_f64.sqrt().to_bits());
    assert_eq!(exact["curve"]["points"][1], serde_json::json!([1.0, 1.0, 0.25]));
}

#[test]
fn surfaces_are_smooth_and_materials_are_not_metal() {
    let space = Space::clamped_uniform(2, 3).unwrap();
    let points = (0..9).map(|k| Point::new(f64::from(k / 3), f64::from(k % 3), f64::from(k % 2))).collect();
    let mut scene = one("s", Surface::new(space.clone(), space, points).unwrap());
    scene.object_mut("s").unwrap().color = Some([0.2, 0.4, 0.6, 0.5]);
    let (document, blob, _) = write(&scene);
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let count = reader.read_positions().unwrap().count();
    assert_eq!(reader.read_normals().unwrap().count(), count);
    assert_eq!(reader.read_tex_coords(0).unwrap().into_f32().count(), count);
    let pbr = primitive.material().pbr_metallic_roughness();
    assert_eq!((pbr.metallic_factor(), pbr.base_color_factor()), (0.0, [0.2, 0.4, 0.6, 0.5]));
    let b = primitive.bounding_box();
    assert!(b.min[0] == 0.0 && b.max[0] == 2.0);
}

#[test]
fn hierarchy_units_shear_and_mirrors_end_where_they_should() {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    let mut shear = Matrix4::new_translation(&Vector::new(5.0, 0.0, 0.0));
    shear[(0, 1)] = 0.5;
    let turn = Matrix4::from_axis_angle(&Vector::z_axis(), 0.7)
        * Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, -1.0));
    let far = Vector::new(1e6, -2e6, 3e6);
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, 0.5], [0.3, 0.2, 2.0]];
    let cloud = |offset: Vector| Cloud { points: points.map(|p| Point::from(p) + offset).to_vec() };
    // Listed from the leaf up: order must not matter.
    let mut add = |name: &str, geometry: Geometry, parent: Option<&str>, transform: Matrix4<f64>| {
        let mut object = Object::new(name, geometry);
        (object.parent, object.transform) = (parent.map(str::to_owned), Some(transform));
        scene.add(object).unwrap();
    };
    add("d", cloud(-far).into(), Some("c"), Matrix4::new_translation(&far));
    add("c", cloud(far).into(), Some("b"), turn);
    add("b", cloud(Vector::zeros()).into(), Some("a"), shear);
    add("a", Geometry::Group, None, turn);
    let (file, report) = try_write(&scene, "part.glb", WriteOptions::default());
    let baked =
        |o: &&loftsman_kernel::plugin::Written| o.reason.as_ref().is_some_and(|r| r.contains("shears"));
    assert_eq!(
        report.objects.iter().filter(baked).map(|o| o.object.as_str()).collect::<Vec<_>>(),
        ["d", "c", "b"]
    );
    let maps = scene.world_transforms().unwrap();
    let found = world(&file);
    assert_eq!(found.len(), 3);
    for (name, found) in found {
        let index = scene.objects().iter().position(|o| o.name() == name).unwrap();
        for (p, q) in scene.objects()[index].geometry.points().iter().zip(&found) {
            let w = maps[index].unwrap().transform_point(p);
            let expected = Point::new(w.x, w.z, -w.y) / 1000.0;
            // Relative to the shape, wherever it is: 4 mm across.
            assert!((expected - q).norm() < 1e-6 * 0.004, "{name} {expected} {q}");
        }
    }
}

#[test]
fn large_coordinates_keep_their_shape() {
    let points: Vec<Point> =
        (0..50).map(|i| Point::new(6e6 + f64::from(i) * 0.01, 5e6, f64::from(i % 7) * 1e-3)).collect();
    let (document, blob, _) = write(&one("p", Cloud { points: points.clone() }));
    let node = document.nodes().next().unwrap();
    let primitive = node.mesh().unwrap().primitives().next().unwrap();
    let found: Vec<[f32; 3]> = primitive.reader(|_| Some(&blob)).read_positions().unwrap().collect();
    for (p, q) in points.iter().zip(&found) {
        let first = Vector::new(
            f64::from(q[0] - found[0][0]),
            f64::from(q[2] - found[0][2]),
            f64::from(q[1] - found[0][1]),
        );
        let exact = p - points[0];
        assert!((first - Vector::new(exact.x, -exact.y, exact.z)).norm() < 1e-6, "{first} {exact}");
    }
}

#[test]
fn text_files_have_their_bytes_beside_them() {
    let mesh =
        Mesh::new(vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)], &[[0, 1, 2]])
            .unwrap();
    let (file, _) = try_write(&one("m", &mesh), "my part.gltf", WriteOptions::default());
    let parsed = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let source = parsed.buffers().next().unwrap();
    assert!(matches!(source.source(), gltf::buffer::Source::Uri("my%20part.bin")));
    assert_eq!(file.siblings["my part.bin"].len(), source.length());
}

#[test]
fn what_cannot_go_out_is_left_out_by_name() {
    let mut scene = one("point", Curve::bezier(vec![Point::origin(); 3]).unwrap());
    scene
        .add(Object::new("short", Polyline { points: vec![Point::origin()], closed: false }.into()))
        .unwrap();
    scene.add(Object::new("none", Cloud::default().into())).unwrap();
    let flat = Mesh::new(vec![Point::origin(); 3], &[[0, 1, 1]]).unwrap();
    scene.add(Object::new("flat", flat.into())).unwrap();
    let mut moving = Object::new("moving", circle().into());
    let frame = circle().points().to_vec();
    moving.animation = Some(Animation { rate: 24.0, frames: vec![frame; 2001] });
    scene.add(moving).unwrap();
    let (document, _, report) = write(&scene);
    // The point of a curve is a node without a mesh.
    assert_eq!((document.nodes().count(), document.meshes().count()), (2, 1));
    assert_eq!(report.objects.iter().filter(|o| o.fate == Fate::LeftOut && o.reason.is_some()).count(), 3);
    assert!(report.objects[4].reason.as_ref().unwrap().contains("2001 frames was left out"), "{report:?}");
    let own = Parameters::new(serde_json::json!({ "meshes-only": true }), "options").unwrap();
    let (file, report) = try_write(&scene, "m.glb", WriteOptions { own, ..WriteOptions::default() });
    assert_eq!(gltf::Gltf::from_slice(&file.bytes).unwrap().nodes().count(), 0);
    assert!(report.objects.iter().all(|o| o.fate == Fate::LeftOut));
    let unknown = Parameters::new(serde_json::json!({ "mesh-only": true }), "options").unwrap();
    let options = WriteOptions { own: unknown, ..WriteOptions::default() };
    let error = Gltf.write(&scene, &mut Memory::new("m.glb", ""), &options).unwrap_err();
    assert!(error.to_string().contains("meshes-only"), "{error}");
    // Too large for single precision, and named.
    let huge = one("huge", Cloud { points: vec![Point::new(1e300, 0.0, 0.0), Point::origin()] });
    let error = Gltf.write(&huge, &mut Memory::new("m.glb", ""), &WriteOptions::default()).unwrap_err();
    assert_eq!(error.object.as_deref(), Some("huge"));
}

#[test]
fn wide_indices_only_where_needed() {
    for (side, wide) in [(255_usize, false), (256, true)] {
        let points: Vec<Point> =
            (0..side * 257).map(|k| Point::new((k / 257) as f64, (k % 257) as f64, 0.0)).collect();
        let faces: Vec<[usize; 4]> = (0..side - 1)
            .flat_map(|i| {
                (0..256)
                    .map(move |j| [i * 257 + j, (i + 1) * 257 + j, (i + 1) * 257 + j + 1, i * 257 + j + 1])
            })
            .collect();
        let mesh = Mesh::new(points, &faces).unwrap();
        let options = WriteOptions { up: UpChoice::Keep, ..WriteOptions::default() };
        let (file, report) = try_write(&one("m", mesh), "m.glb", options);
        let parsed = gltf::Gltf::from_slice(&file.bytes).unwrap();
        let primitive = parsed.meshes().next().unwrap().primitives().next().unwrap();
        let indices = primitive.indices().unwrap();
        assert_eq!(indices.data_type() == gltf::accessor::DataType::U32, wide, "{side}");
        assert_eq!(indices.count(), faces.len() * 6);
        assert_eq!(report.objects[0].form, format!("{} triangles", faces.len() * 2));
    }
}

#[test]
fn it_is_a_format() {
    use loftsman_kernel::conformance::{format_conformance, sample_scene};
    let verdict = format_conformance(&Gltf, &sample_scene());
    assert!(verdict.passed(), "{verdict}");
}
