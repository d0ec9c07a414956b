//! What is written, read back by the crate `gltf`.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use gltf::mesh::Mode;
use loftsman_gltf::Gltf;
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format, Memory, Parameters, UpChoice, WriteOptions, WriteReport,
};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
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
        for (p, q) in scene.objects()[index].geometry().points().iter().zip(&found) {
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

/// Frames at a rate, of a line that moves.
fn moving(rate: f64, frames: usize) -> Scene {
    let mut scene = one("line", Curve::bezier(vec![Point::origin(), Point::new(1.0, 0.0, 0.0)]).unwrap());
    let frame = |k: usize| vec![Point::origin(), Point::new(1.0, k as f64, 0.0)];
    let frames = (0..frames).map(frame).collect();
    scene.object_mut("line").unwrap().animation = Some(Animation { rate, frames });
    scene
}

#[test]
fn times_beyond_single_precision_are_refused_and_all_others_are_as_they_should_be() {
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..WriteOptions::default() };
    let (mut refused, mut written) = (0, 0);
    for exponent in -320..=308 {
        for (mantissa, frames) in [(1.0, 3), (2.9, 40)] {
            let rate = mantissa * 10_f64.powi(exponent);
            let mut file = Memory::new("a.glb", "");
            match Gltf.write(&moving(rate, frames), &mut file, &options) {
                Err(error) => {
                    let words = error.to_string();
                    assert!(words.contains("single precision") && words.contains("line"), "{words}");
                    assert!(!(-37..=37).contains(&exponent), "{rate:e}: {words}");
                    refused += 1;
                }
                Ok(_) => {
                    let text = String::from_utf8_lossy(&file.bytes);
                    assert!(!text.contains("null"), "{rate:e}");
                    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
                    let channel = document.animations().next().unwrap().channels().next().unwrap();
                    let times: Vec<f32> =
                        channel.reader(|_| blob.as_deref()).read_inputs().unwrap().collect();
                    assert_eq!(times.len(), frames);
                    for (k, &time) in times.iter().enumerate() {
                        let exact = k as f64 / rate;
                        assert!((f64::from(time) - exact).abs() <= 1e-7 * exact, "{rate:e}: {time} {exact}");
                    }
                    written += 1;
                }
            }
        }
    }
    assert!(written >= 140 && refused >= 1000, "{written} {refused}");
    // A single frame has no time to be told apart from.
    assert!(Gltf.write(&moving(1e-39, 1), &mut Memory::new("a.glb", ""), &options).is_ok());
}

#[test]
fn no_number_of_a_file_is_beyond_single_precision() {
    use loftsman_kernel::material::{Alpha, Channel, Image, ImageData, Material, Texture};
    use loftsman_kernel::mesh::Layer;
    let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e39, 3e38, 1e-300, 1e-60, -0.0];
    let net = || vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
    let (mut refused, mut written) = (0, 0);
    for (i, &x) in wild.iter().enumerate() {
        for place in 0..14 {
            let mut mesh = Mesh::new(net(), &[[0, 1, 2]]).unwrap();
            mesh.normals = Layer::per_point(vec![Vector::z(); 3]);
            mesh.tangents = Layer::per_point(vec![[1.0, 0.0, 0.0, 1.0]; 3]);
            mesh.uvs = Layer::per_point(vec![[0.25, 0.5]; 3]);
            mesh.colors = Layer::per_point(vec![[0.5; 4]; 3]);
            let mut material = Material::new("m", [0.5; 4]);
            let mut texture = Texture::new("i");
            let mut transform = Matrix4::identity();
            match place {
                0 => mesh.normals = Layer::per_point(vec![Vector::new(x, 0.0, x); 3]),
                1 => mesh.tangents = Layer::per_point(vec![[0.0, x, x, 1.0]; 3]),
                2 => mesh.uvs = Layer::per_point(vec![[x, 0.5]; 3]),
                3 => mesh.colors = Layer::per_point(vec![[x; 4]; 3]),
                4 => material.base_color = [x; 4],
                5 => (material.metallic, material.roughness) = (x, x),
                6 => material.emissive = [x, 0.5, 2.0],
                7 => material.alpha = Alpha::Mask(x),
                8 => texture.strength = x,
                9 => texture.offset = [x, 0.0],
                10 => texture.tiling = [1.0, x],
                11 => texture.rotation = x,
                12 => transform = Matrix4::new_translation(&Vector::new(x, 0.0, 0.0)),
                _ => transform = Matrix4::new_scaling(x),
            }
            let bytes = b"\x89PNG\r\n\x1a\n".as_slice().into();
            let mut scene = Scene::new();
            scene
                .images
                .add(Image::new("i", ImageData::Embedded { media_type: "image/png".into(), bytes }))
                .unwrap();
            material.textures.insert(Channel::Normal, texture.clone());
            material.textures.insert(Channel::Occlusion, texture);
            scene.materials.add(material).unwrap();
            let mut object = Object::new("o", mesh.into());
            object.materials = vec!["m".into()];
            object.transform = Some(transform);
            if scene.add(object).is_err() {
                continue;
            }
            let mut child = Object::new("child", Geometry::Group);
            child.parent = Some("o".into());
            scene.add(child).unwrap();
            let mut file = Memory::new("a.glb", "");
            match Gltf.write(&scene, &mut file, &WriteOptions::default()) {
                Err(error) => {
                    assert!(place >= 12, "{x:e} at {place}: {error}");
                    refused += 1;
                }
                Ok(_) => {
                    let length = u32::from_le_bytes(file.bytes[12..16].try_into().unwrap()) as usize;
                    let json: serde_json::Value =
                        serde_json::from_slice(&file.bytes[20..20 + length]).unwrap();
                    all_numbers(&json, &mut |n| assert!((n as f32).is_finite(), "{x:e} at {place}: {json}"));
                    let floats = floats(&file);
                    assert!(floats.iter().all(|f| f.is_finite()), "{x:e} at {place}: {floats:?}");
                    let is_unit = |v: &[f32]| (v.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5;
                    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
                    for primitive in document.meshes().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
                        let reader = primitive.reader(|_| blob.as_deref());
                        for n in reader.read_normals().into_iter().flatten() {
                            assert!(is_unit(&n), "{x:e} at {place}: {n:?}");
                        }
                        for t in reader.read_tangents().into_iter().flatten() {
                            assert!(is_unit(&t[..3]), "{x:e} at {place}: {t:?}");
                        }
                    }
                    written += 1;
                }
            }
        }
        assert!(i < 10);
    }
    assert!(written >= 120 && refused <= 14, "{written} {refused}");
}

/// Calls on every number of a document; `null` is one that was not finite.
fn all_numbers(value: &serde_json::Value, call: &mut impl FnMut(f64)) {
    use serde_json::Value;
    match value {
        Value::Null => call(f64::NAN),
        Value::Number(n) => call(n.as_f64().unwrap()),
        Value::Array(list) => list.iter().for_each(|v| all_numbers(v, call)),
        Value::Object(map) => map.values().for_each(|v| all_numbers(v, call)),
        _ => {}
    }
}

/// All single-precision numbers of all accessors.
fn floats(file: &Memory) -> Vec<f32> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let blob = blob.unwrap();
    let of = |a: gltf::Accessor<'_>| {
        let view = a.view().unwrap();
        let bytes = blob[view.offset()..view.offset() + view.length()].to_vec();
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect::<Vec<_>>()
    };
    let floats = document.accessors().filter(|a| a.data_type() == gltf::accessor::DataType::F32);
    floats.flat_map(of).collect()
}

/// What a report calls the tolerance is what was asked of the triangles and segments: the error stays within it, and so it does
/// measured on the file's own numbers (to their single precision).
#[test]
fn the_error_stays_within_the_tolerance_that_is_told() {
    let wave = |i: usize| Point::new(i as f64, (1.3 * i as f64).sin(), (0.4 * i as f64).cos());
    let curve = Curve::new(Space::clamped_uniform(3, 14).unwrap(), (0..14).map(wave).collect()).unwrap();
    let net = (0..8)
        .flat_map(|i| (0..8).map(move |j| wave(i) + Vector::new(0.0, j as f64, (1.1 * j as f64).sin())));
    let space = || Space::clamped_uniform(3, 8).unwrap();
    let surface = Surface::new(space(), space(), net.collect()).unwrap();
    for chord in [1e-2, 1e-3, 1e-4] {
        let fineness = Fineness { chord: Chord::Relative(chord), angle: 3.0 };
        let options = || WriteOptions { fineness, ..WriteOptions::default() };
        let (file, report) = try_write(&one("curve", curve.clone()), "part.glb", options());
        let (tolerance, error) = (report.objects[0].tolerance.unwrap(), report.objects[0].error.unwrap());
        assert!(error <= tolerance && error > 0.2 * tolerance, "{chord}: {error:e} of {tolerance:e}");
        let places = world(&file).remove(0).1;
        let apart = |u: f64| {
            // glTF is y-up.
            let p = curve.point(u).unwrap();
            let p = Point::new(p.x, p.z, -p.y);
            let to = |pair: &[Point]| {
                let (along, from) = (pair[1] - pair[0], p - pair[0]);
                (from - along * (from.dot(&along) / along.norm_squared()).clamp(0.0, 1.0)).norm()
            };
            places.windows(2).map(to).fold(f64::INFINITY, f64::min)
        };
        let (a, b) = curve.domain();
        let worst = (0..=2000).map(|k| apart(a + (b - a) * f64::from(k) / 2000.0)).fold(0.0, f64::max);
        assert!(worst <= tolerance + 2e-6, "{chord}: {worst:e} of {tolerance:e}");
        let (_, report) = try_write(&one("surface", surface.clone()), "part.glb", options());
        let (tolerance, error) = (report.objects[0].tolerance.unwrap(), report.objects[0].error.unwrap());
        assert!(error <= tolerance, "{chord}: {error:e} of {tolerance:e}");
    }
}

#[test]
fn normals_without_length_do_not_cost_the_others_theirs() {
    // A roof of two faces and a face without area; the points of its gable ends and of that face have no normal.
    let at = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
        [2.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [1.0, 2.0, 0.0],
    ];
    let points = at.map(Point::from).to_vec();
    let faces: [&[usize]; 3] = [&[0, 1, 2, 3], &[3, 2, 4, 5], &[5, 6, 4]];
    let mut mesh = Mesh::new(points, &faces).unwrap();
    let mut normals = vec![Vector::z(); 7];
    for gone in [0, 2, 6] {
        normals[gone] = Vector::zeros();
    }
    mesh.normals = Layer::per_point(normals);
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    scene.add(Object::new("roof", mesh.into())).unwrap();
    let mut file = Memory::new("roof.glb", "");
    let report = Gltf.write(&scene, &mut file, &WriteOptions::default()).unwrap();
    let reason = report.objects[0].reason.clone().unwrap();
    assert!(reason.contains("3 points without a normal of any length have that of their faces"), "{reason}");
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let found: Vec<_> = primitive.reader(|_| blob.as_deref()).read_normals().unwrap().collect();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for (p, wanted) in
        [(0, [0.0, -half, half]), (1, [0.0, 0.0, 1.0]), (2, [0.0, 0.0, 1.0]), (6, [0.0, 0.0, 1.0])]
    {
        assert!((0..3).all(|k| (found[p][k] - wanted[k]).abs() < 1e-6), "{p}: {:?}", found[p]);
    }
}
