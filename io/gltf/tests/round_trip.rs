//! There and back: what a scene holds and glTF can hold comes back, and what a file holds goes out again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;
use std::sync::Arc;

use loftsman_gltf::Gltf;
use loftsman_kernel::conformance::sample_scene;
use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, NONE, Polyline};
use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format, Memory, Parameters, ReadOptions, ReadReport, UpChoice, WriteOptions,
};
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene, Unit, Up};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;
use nalgebra::Matrix4;
use serde_json::{Value, json};

/// The samples are wild: a fine tessellation of them is large.
fn coarse() -> WriteOptions<'static> {
    let fineness = Fineness { chord: Chord::Relative(0.05), angle: 3.0 };
    WriteOptions { fineness, ..WriteOptions::default() }
}

fn write_as(scene: &Scene, name: &str, own: Value) -> Memory {
    let tessellator = Adaptive::default();
    let own = Parameters::new(own, "options").unwrap();
    let options = WriteOptions { tessellator: Some(&tessellator), own, ..coarse() };
    let mut file = Memory::new(name, "");
    Gltf.write(scene, &mut file, &options).unwrap();
    file
}

fn write(scene: &Scene) -> Memory {
    write_as(scene, "part.glb", json!({}))
}

fn read(file: &Memory) -> (Scene, ReadReport) {
    let (scene, report) = Gltf.read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(report.adds_up());
    (scene, report)
}

fn back(scene: &Scene) -> Scene {
    read(&write(scene)).0
}

fn json_of(file: &Memory) -> Value {
    if file.name.ends_with(".gltf") {
        return serde_json::from_slice(&file.bytes).unwrap();
    }
    let length = u32::from_le_bytes(file.bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&file.bytes[20..20 + length]).unwrap()
}

fn patch() -> Surface {
    let space = Space::clamped(2, &[0.0, 1.0 / 3.0, 1.0]).unwrap();
    let points =
        (0..16).map(|k| Point::new(f64::from(k / 4), f64::from(k % 4), f64::from(k * k % 7) / 7.0)).collect();
    let weights = (0..16).map(|k| 1.0 + f64::from(k) / 17.0).collect();
    Surface::rational(space.clone(), space, points, weights).unwrap()
}

#[test]
fn splines_colours_layers_and_transforms_come_back_to_the_bit() {
    for (unit, up) in
        [(Unit::Millimetre, Up::Z), (Unit::Inch, Up::X), (Unit::Metre, Up::Y), (Unit::Metre, Up::Z)]
    {
        let mut scene = Scene::new();
        (scene.unit, scene.up) = (unit, up);
        let far = Vector::new(1e6, -2e6, 3e6);
        let curve = |offset: Vector| {
            let points = (0..7)
                .map(|i| Point::new(f64::from(i) / 3.0, f64::from(i * i) / 7.0, 0.1) + offset)
                .collect();
            Curve::new(Space::clamped(3, &[0.0, 0.1, 0.7, 1.1, 2.0]).unwrap(), points).unwrap()
        };
        let mut shear = Matrix4::new_translation(&Vector::new(5.0, 1.0 / 3.0, 0.0));
        shear[(0, 1)] = 0.5;
        let mut turn = Matrix4::from_axis_angle(&Vector::y_axis(), 0.7)
            * Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, -1.0 / 3.0));
        (turn[(0, 3)], turn[(1, 3)]) = (-0.0, 2.0);
        let mut add =
            |name: &str, geometry: Geometry, parent: Option<&str>, transform: Option<Matrix4<f64>>| {
                let mut object = Object::new(name, geometry);
                (object.parent, object.transform) = (parent.map(str::to_owned), transform);
                object.color = Some([0.1, 1.0 / 3.0, 0.7, 0.25]);
                object.layer = Some("decks \"é\"".to_owned());
                scene.add(object).unwrap();
            };
        // Far from its origin, with others below: the node moves, and what hangs under it must not.
        add("far", curve(far).into(), None, None);
        add("below far", curve(Vector::zeros()).into(), Some("far"), None);
        add("sheared", curve(Vector::zeros()).into(), Some("far"), Some(shear));
        add("below shear", patch().into(), Some("sheared"), Some(turn));
        add("group", Geometry::Group, Some("sheared"), Some(turn));
        add("last", patch().into(), Some("group"), None);
        let file = write(&scene);
        let (read, report) = read(&file);
        for (a, b) in scene.objects().iter().zip(read.objects()) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"), "{unit:?} {up:?}");
        }
        assert_eq!((read.unit, read.up), (unit, up));
        assert!(report.left_out.is_empty(), "{report:?}");
        assert_eq!(write(&read).bytes, file.bytes, "and the same bytes again");
    }
}

/// A mesh with everything: two materials, values by corner and by point, lines, loose points.
fn painted() -> Mesh {
    let points = (0..7).map(|i| Point::new(f64::from(i % 3), f64::from(i / 3), f64::from(i) / 8.0)).collect();
    let mut mesh = Mesh::new(points, &[[0, 1, 4], [0, 4, 3], [1, 2, 5]]).unwrap();
    mesh.set_lines(vec![0, 1, 2, 5, 4], vec![0, 3, 5]).unwrap();
    mesh.materials = vec![0, 0, 1];
    mesh.normals = Layer::per_point(vec![Vector::new(0.0, 0.0, -1.0); 7]);
    mesh.uvs = Layer::per_point((0..7).map(|i| [f64::from(i) / 8.0, 0.25]).collect());
    mesh.more_uvs = vec![Layer::per_point(vec![[0.5, 0.125]; 7])];
    mesh.colors = Layer::per_point((0..7).map(|i| [f64::from(i) / 8.0, 0.5, 0.25, 0.75]).collect());
    mesh
}

const PNG: &[u8] = &[
    0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0, 0, 0, 0x0D, 0x49, 0x48, 0x44, 0x52, 0, 0, 0, 1, 0, 0,
    0, 1, 8, 0, 0, 0, 0, 0x3A, 0x7E, 0x9B, 0x55, 0, 0, 0, 0x0A, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9C, 0x63,
    0x60, 0, 0, 0, 2, 0, 1, 0x48, 0xAF, 0xA4, 0x71, 0, 0, 0, 0, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60,
    0x82,
];

fn with_materials(mesh: Mesh) -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    let data = ImageData::Embedded { media_type: "image/png".into(), bytes: Arc::from(PNG) };
    scene.images.add(Image::new("grain", data)).unwrap();
    scene.images.add(Image::new("beside", ImageData::File("pictures/ü 1.png".into()))).unwrap();
    let mut wood = Material::new("wood", [0.3, 0.2, 0.1, 1.0]);
    (wood.metallic, wood.roughness, wood.double_sided) = (0.1, 1.0 / 3.0, true);
    (wood.emissive, wood.alpha) = ([0.1, 0.7, 12.5], Alpha::Mask(0.45));
    let everything = Texture {
        set: 1,
        strength: 0.7,
        offset: [0.25, -0.5],
        tiling: [2.0, -3.0],
        wrap: [Wrap::Mirror, Wrap::Clamp],
        magnify: Some(Filter::Nearest),
        minify: Some(Filter::LinearOfMixed),
        ..Texture::new("grain")
    };
    wood.textures.insert(Channel::Normal, everything.clone());
    wood.textures.insert(Channel::Occlusion, everything.clone());
    wood.textures.insert(Channel::BaseColor, Texture { strength: 1.0, ..everything });
    wood.textures.insert(Channel::Emissive, Texture::new("beside"));
    wood.textures.insert(Channel::MetallicRoughness, Texture::new("grain"));
    let clearcoat = "KHR_materials_clearcoat";
    wood.textures.insert(Channel::Other(format!("{clearcoat}.clearcoatTexture")), Texture::new("grain"));
    wood.statements = vec![
        (format!("gltf {clearcoat}"), r#"{"clearcoatFactor":0.5}"#.into()),
        ("gltf extras".into(), r#"{"price":12}"#.into()),
    ];
    scene.materials.add(wood).unwrap();
    scene.materials.add(Material::new("glass", [1.0, 1.0, 1.0, 0.25])).unwrap();
    let mut object = Object::new("panel", mesh.into());
    object.materials = vec!["wood".into(), "glass".into()];
    scene.add(object).unwrap();
    scene
}

#[test]
fn meshes_materials_and_pictures_come_back() {
    let scene = with_materials(painted());
    for name in ["part.glb", "part.gltf"] {
        let file = write_as(&scene, name, json!({}));
        let (read, report) = read(&file);
        assert_eq!(format!("{:?}", read.objects()), format!("{:?}", scene.objects()), "{name}");
        assert_eq!(read.images.as_slice(), scene.images.as_slice());
        for (a, b) in scene.materials.iter().zip(&read.materials) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
        assert!(report.left_out.is_empty() && report.approximated.is_empty(), "{report:?}");
        assert_eq!(write_as(&read, name, json!({})).bytes, file.bytes);
    }
}

#[test]
fn values_by_corner_double_points_only_where_they_differ() {
    let mut mesh = painted();
    // The first two faces share an edge with equal normals; colours are on the second material only.
    mesh.normals = Layer::per_corner(vec![Vector::z(), Vector::x()], vec![0, 0, 0, 0, 0, 0, 1, 1, 1]);
    mesh.colors = Layer::per_corner(vec![[1.0, 0.0, 0.0, 1.0]], [[NONE; 6].as_slice(), &[0; 3]].concat());
    let scene = with_materials(mesh);
    let file = write(&scene);
    let document = json_of(&file);
    let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!(primitives.len(), 3, "two materials and the lines");
    // Point 1 is in both normals: one point more.
    assert_eq!(
        document["accessors"][primitives[0]["attributes"]["POSITION"].as_u64().unwrap() as usize]["count"],
        8
    );
    assert!(primitives[0]["attributes"].get("COLOR_0").is_none());
    assert!(primitives[1]["attributes"].get("COLOR_0").is_some());
    let once = back(&scene);
    let Geometry::Mesh(mesh) = once.objects()[0].geometry() else { panic!("no mesh") };
    for (corner, &point) in mesh.corners().iter().enumerate() {
        assert_eq!(mesh.normals.at(corner, point), Some(&if corner < 6 { Vector::z() } else { Vector::x() }));
        let red = [1.0, 0.0, 0.0, 1.0];
        assert_eq!(mesh.colors.at(corner, point), (corner >= 6).then_some(&red));
    }
    assert_eq!(back(&once), once, "from there on nothing changes");
}

/// Closed lines of two points and more, and open ones: the same lines, and written again the same file.
#[test]
fn short_lines_come_back() {
    for count in 2..6 {
        for closed in [false, true] {
            let points = (0..count).map(|k| Point::new(f64::from(k), f64::from(k * k), 0.0)).collect();
            let mut scene = Scene::new();
            scene.add(Object::new("line", Polyline { points, closed }.into())).unwrap();
            let first = write(&scene);
            let (read, _) = read(&first);
            let Geometry::Polyline(line) = read.object("line").unwrap().geometry() else { panic!("{count}") };
            assert_eq!((line.points.len(), line.closed), (count as usize, closed));
            assert!(write(&read).bytes == first.bytes, "{count} {closed}");
        }
    }
}

#[test]
fn frames_come_back() {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Centimetre, Up::Z);
    let frames = |points: &[Point]| -> Vec<Vec<Point>> {
        (0..5)
            .map(|k| points.iter().map(|p| p + Vector::new(0.5, 0.25, 1.0) * f64::from(k * k)).collect())
            .collect()
    };
    let mut add = |name: &str, geometry: Geometry, rate: f64| {
        let mut object = Object::new(name, geometry);
        object.animation = Some(Animation { rate, frames: frames(object.geometry().points()) });
        scene.add(object).unwrap();
    };
    let points: Vec<Point> = (0..5).map(|i| Point::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
    add("curve", Curve::new(Space::periodic_uniform(3, 5).unwrap(), points.clone()).unwrap().into(), 24.0);
    add("patch", patch().into(), 30.0);
    add("chain", Polyline { points: points.clone(), closed: true }.into(), 29.97);
    add("cloud", Cloud { points: points.clone() }.into(), 24.0);
    let mut mesh = painted();
    mesh.uvs = Layer::per_corner((0..9).map(|c| [f64::from(c), 0.0]).collect(), (0..9).collect());
    mesh.materials.clear();
    add("mesh", mesh.into(), 24.0);
    let file = write(&scene);
    let once = read(&file).0;
    for (a, b) in scene.objects().iter().zip(once.objects()) {
        let name = a.name();
        let (a, b) = (a.animation.as_ref().unwrap(), b.animation.as_ref().unwrap());
        assert_eq!((a.rate, a.frames.len()), (b.rate, b.frames.len()));
        // A mesh has its doubled points after the others.
        let pairs = a.frames.iter().zip(&b.frames).flat_map(|(a, b)| a.iter().zip(b));
        for (p, q) in pairs {
            assert!((p - q).norm() < 1e-5, "{p} {q} of {name}");
        }
    }
    let splines =
        |s: &Scene| format!("{:?}", s.objects()[..2].iter().map(|o| &o.animation).collect::<Vec<_>>());
    assert_eq!(splines(&scene), splines(&once), "those of splines to the bit");
    assert_eq!(back(&once), once, "from there on nothing changes");
    let document = json_of(&file);
    assert_eq!(document["animations"].as_array().unwrap().len(), 1);
    assert_eq!(document["meshes"][0]["extras"]["targetNames"][4], "frame 4");
}

#[test]
fn a_changed_mesh_counts_more_than_the_spline_that_it_showed() {
    let mut scene = Scene::new();
    scene.up = Up::Y;
    scene.add(Object::new("patch", patch().into())).unwrap();
    let file = write(&scene);
    // As it is, it is the surface.
    let (same, report) = read(&file);
    assert!(same.objects()[0].geometry() == scene.objects()[0].geometry() && report.left_out.is_empty());
    let json = json_of(&file);
    let accessor = &json["accessors"]
        [json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize];
    let count = accessor["count"].as_u64().unwrap() as usize;
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let start = file.bytes.len() - json["buffers"][0]["byteLength"].as_u64().unwrap() as usize
        + view["byteOffset"].as_u64().unwrap() as usize;
    let tessellation = mesh_of(&file);
    assert!(count > 8 && tessellation.len() == count);
    // A program moves any vertex by however little, along any axis, and keeps the extras.
    for vertex in 0..count {
        for axis in 0..3 {
            let mut moved = Memory::new("part.glb", file.bytes.clone());
            let at = start + 12 * vertex + 4 * axis;
            let old = f32::from_le_bytes(moved.bytes[at..at + 4].try_into().unwrap());
            let new = if vertex % 2 == 0 { old.next_up() } else { old + 0.25 };
            moved.bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
            let (found, report) = read(&moved);
            let Geometry::Mesh(mesh) = found.objects()[0].geometry() else { panic!("{vertex} {axis}") };
            assert_eq!(
                report.left_out.keys().filter(|k| k.contains("changed since")).count(),
                1,
                "{report:?}"
            );
            for (k, (p, q)) in mesh.points().iter().zip(&tessellation).enumerate() {
                let expected = if k == vertex { f64::from(new) } else { q[axis] };
                assert_eq!(p[axis], expected, "{vertex} {axis} {k}");
            }
        }
    }
}

/// The positions of the first primitive, as the crate `gltf` reads them.
fn mesh_of(file: &Memory) -> Vec<Point> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let positions = primitive.reader(|_| blob.as_deref()).read_positions().unwrap();
    positions.map(|p| Point::from(p.map(f64::from))).collect()
}

#[test]
fn only_meshes_for_programs_that_take_lines_for_triangles() {
    let mut scene = with_materials(painted());
    scene.add(Object::new("cloud", Cloud { points: vec![Point::origin()] }.into())).unwrap();
    scene.add(Object::new("patch", patch().into())).unwrap();
    let document = json_of(&write_as(&scene, "m.glb", json!({ "meshes-only": true })));
    let modes: Vec<&Value> = document["meshes"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|m| m["primitives"].as_array().unwrap())
        .collect();
    assert!(modes.len() == 3 && modes.iter().all(|p| p["mode"] == 4), "{modes:?}");
}

#[test]
fn what_cannot_be_shown_comes_back_too() {
    // No tessellator: nothing of a spline is to be seen, trimmed or not.
    let mut file = Memory::new("part.glb", "");
    let report = Gltf.write(&sample_scene(), &mut file, &WriteOptions::default()).unwrap();
    // A Brep is not carried beside its triangles.
    let left_out = report.objects.iter().filter(|o| o.fate == Fate::LeftOut);
    assert!(left_out.map(|o| o.object.as_str()).eq(["block"]), "{report:?}");
    let (read, _) = read(&file);
    for (a, b) in sample_scene().objects().iter().zip(read.objects()) {
        let same = format!("{a:?}") == format!("{b:?}");
        assert!(
            same || matches!(
                a.geometry(),
                Geometry::Mesh(_) | Geometry::Polyline(_) | Geometry::Cloud(_) | Geometry::Brep(_)
            ),
            "{a:?} {b:?}"
        );
    }
}

#[test]
fn every_kind_goes_there_and_back_at_every_size() {
    let (mut exact, mut rounded) = (0, 0);
    for size in [1e-9, 1e-3, 1.0, 1e9] {
        let mut scene = sample_scene();
        for object in scene.objects().iter().map(|o| o.name().to_owned()).collect::<Vec<_>>() {
            let map = Matrix4::new_scaling(size);
            let geometry = scene.object(&object).unwrap().geometry().transformed(&map).unwrap();
            scene.replace(&object, geometry).unwrap();
        }
        let tessellator = Adaptive::default();
        let options = WriteOptions { tessellator: Some(&tessellator), ..coarse() };
        let report = Gltf.write(&scene, &mut Memory::new("a.glb", ""), &options).unwrap();
        assert!(report.objects.iter().all(|o| o.fate != Fate::LeftOut), "{size}: {report:#?}");
        let once = back(&scene);
        let names = |s: &Scene| s.objects().iter().map(|o| o.name().to_owned()).collect::<Vec<_>>();
        assert_eq!(names(&once), names(&scene));
        for (a, b) in scene.objects().iter().zip(once.objects()) {
            let became = if matches!(a.geometry(), Geometry::Brep(_)) { "mesh" } else { a.geometry().kind() };
            assert_eq!((became, &a.parent, &a.layer), (b.geometry().kind(), &b.parent, &b.layer));
            if became != a.geometry().kind() {
                continue;
            }
            let (p, q) = (a.geometry().points(), b.geometry().points());
            assert_eq!(p.len(), q.len());
            match a.geometry() {
                Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Trimmed(_) => {
                    assert_eq!(a.geometry(), b.geometry(), "{size} {}: to the bit", a.name());
                    exact += 1;
                }
                _ => {
                    // Half a unit in the last place of single precision, along each axis, of the largest coordinate.
                    let largest = p.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
                    let slack = f64::from(f32::EPSILON) * largest;
                    let off = p.iter().zip(q).map(|(p, q)| (p - q).amax()).fold(0.0, f64::max);
                    assert!(off <= slack, "{size} {}: {off} {slack}", a.name());
                    rounded += usize::from(off > 0.0);
                }
            }
        }
        assert_eq!(back(&once), once);
    }
    assert!(exact >= 12 && rounded > 0, "{exact} {rounded}");
}

/// Everything that two files have in common must be in both: primitives by triangles, attributes, materials.
#[test]
fn what_files_of_other_programs_hold_goes_out_again() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gltf/");
    let mut compared = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.ends_with(".glb") && !name.ends_with(".gltf") || name.starts_with("CubeHierarchy") {
            continue;
        }
        let mut file = Memory::new(&name, std::fs::read(&path).unwrap());
        let bin = name.replace(".gltf", ".bin");
        if let Ok(bytes) = std::fs::read(path.with_file_name(&bin)) {
            file.siblings.insert(bin, bytes);
        }
        let (scene, _) = read(&file);
        let out = write(&scene);
        let (first, second) = (elements(&file), elements(&out));
        assert_eq!(first.len(), second.len(), "{name}");
        for (node, a) in &first {
            let b = &second[node];
            for (x, y) in a.iter().zip(b) {
                if x != y {
                    let at = x.bytes().zip(y.bytes()).position(|(p, q)| p != q).unwrap_or(0);
                    let near =
                        |text: &str| text.chars().skip(at.saturating_sub(40)).take(80).collect::<String>();
                    panic!("{name}: {node}:\n{}\n{}", near(x), near(y));
                }
            }
            assert_eq!(a.len(), b.len(), "{name}: {node}");
            compared += a.len();
        }
    }
    assert!(compared > 20, "{compared}");
}

/// Of each node: its place, and of each primitive the mode, the material's parts and every attribute in the order in
/// which the primitive draws it. Read by the crate `gltf`.
fn elements(file: &Memory) -> BTreeMap<String, Vec<String>> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&file.bytes).unwrap();
    let buffer = |b: gltf::Buffer<'_>| -> Vec<u8> {
        match b.source() {
            gltf::buffer::Source::Bin => blob.clone().unwrap(),
            gltf::buffer::Source::Uri(uri) => match uri.split_once(";base64,") {
                Some((_, data)) => base64_decode(data),
                None => file.siblings[uri].clone(),
            },
        }
    };
    let buffers: Vec<Vec<u8>> = document.buffers().map(buffer).collect();
    let mut all = BTreeMap::new();
    for (index, node) in document.nodes().enumerate() {
        let name = node.name().map_or_else(|| format!("node {index}"), str::to_owned);
        let mut parts = Vec::new();
        let map = node.transform().matrix();
        let rounded = map.map(|column| column.map(|x| (f64::from(x) * 1e5).round() / 1e5 + 0.0));
        parts.push(format!("{rounded:?}"));
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let reader = primitive.reader(|b| Some(&buffers[b.index()]));
            let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let order: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            let order = drawn(primitive.mode(), &order);
            fn at<T: std::fmt::Debug + Copy>(list: &[T], order: &[u32]) -> String {
                format!("{:?}", order.iter().map(|&i| list[i as usize]).collect::<Vec<_>>())
            }
            parts.push(at(&positions, &order));
            if let Some(normals) = reader.read_normals() {
                parts.push(at(&normals.collect::<Vec<_>>(), &order));
            }
            if let Some(uvs) = reader.read_tex_coords(0) {
                parts.push(at(&uvs.into_f32().collect::<Vec<_>>(), &order));
            }
            if let Some(colors) = reader.read_colors(0) {
                parts.push(at(&colors.into_rgba_f32().collect::<Vec<_>>(), &order));
            }
            let material = primitive.material();
            if material.index().is_some() {
                let pbr = material.pbr_metallic_roughness();
                parts.push(format!(
                    "{:?} {:?} {} {} {:?} {} {:?} {:?}",
                    material.name().unwrap_or("material 0"),
                    pbr.base_color_factor(),
                    pbr.metallic_factor(),
                    pbr.roughness_factor(),
                    material.alpha_mode(),
                    material.double_sided(),
                    material.emissive_factor(),
                    pbr.base_color_texture().map(|t| t.tex_coord()),
                ));
            }
        }
        all.insert(name, parts);
    }
    all
}

/// Indices as a list of triangles, segments or points: whatever the mode.
fn drawn(mode: gltf::mesh::Mode, order: &[u32]) -> Vec<u32> {
    use gltf::mesh::Mode;
    let n = order.len();
    match mode {
        Mode::Points | Mode::Lines | Mode::Triangles => order.to_vec(),
        Mode::LineStrip => order.windows(2).flatten().copied().collect(),
        Mode::LineLoop => order.windows(2).flatten().copied().chain([order[n - 1], order[0]]).collect(),
        Mode::TriangleStrip => (0..n - 2)
            .flat_map(|i| {
                if i % 2 == 0 {
                    [order[i], order[i + 1], order[i + 2]]
                } else {
                    [order[i], order[i + 2], order[i + 1]]
                }
            })
            .collect(),
        Mode::TriangleFan => (1..n - 1).flat_map(|i| [order[i], order[i + 1], order[0]]).collect(),
    }
}

fn base64_decode(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let bits: Vec<u8> = text.bytes().filter(|c| *c != b'=').map(digit).collect();
    let mut out = Vec::new();
    for group in bits.chunks(4) {
        let word = group.iter().fold(0_u32, |w, &b| w << 6 | u32::from(b)) << (6 * (4 - group.len()));
        out.extend_from_slice(&word.to_be_bytes()[1..group.len()]);
    }
    out
}

#[test]
fn a_scene_of_one_fate_is_reported_as_such() {
    let (_, report) = read(&write(&sample_scene()));
    assert!(report.kept > 0 && report.left_out.is_empty(), "{report:?}");
    let tessellator = Adaptive::default();
    let options = WriteOptions { tessellator: Some(&tessellator), ..coarse() };
    let report = Gltf.write(&sample_scene(), &mut Memory::new("a.glb", ""), &options).unwrap();
    assert!(report.objects.iter().all(|o| o.fate != Fate::LeftOut));
    assert!(report.notes.iter().any(|n| n.contains("rounded by at most")), "{report:?}");
}

/// A file of a program that keeps what belongs to nodes and nothing else; `change` changes its document further.
fn passed_on(scene: &Scene, change: impl Fn(&mut Value)) -> Memory {
    let mut document = json_of(&write_as(scene, "part.gltf", json!({})));
    document["asset"].as_object_mut().unwrap().remove("extras");
    change(&mut document);
    let mut file = Memory::new("part.gltf", document.to_string());
    let written = write_as(scene, "part.gltf", json!({}));
    file.siblings = written.siblings;
    file
}

fn sheet_in(unit: Unit, up: Up) -> Scene {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (unit, up);
    let mut sheet = Object::new("sheet", patch().into());
    sheet.transform = Some(Matrix4::new_translation(&Vector::new(0.1, 0.2, 1.0 / 3.0)));
    scene.add(sheet).unwrap();
    scene
}

#[test]
fn a_node_says_its_unit_and_axes_itself() {
    for (unit, up) in
        [(Unit::Millimetre, Up::Z), (Unit::Inch, Up::Y), (Unit::Metre, Up::Z), (Unit::Metre, Up::Y)]
    {
        let scene = sheet_in(unit, up);
        let (found, report) = read(&passed_on(&scene, |_| {}));
        assert!(report.left_out.is_empty(), "{report:?}");
        assert_eq!((found.unit, found.up), (unit, up));
        assert_eq!(format!("{:?}", found.objects()), format!("{:?}", scene.objects()));
    }
    // Files that were written before say it of the whole only.
    let forget = |document: &mut Value| {
        let own = &mut document["nodes"][0]["extras"]["loftsman"];
        let mut fields: Value = serde_json::from_str(own.as_str().unwrap()).unwrap();
        assert_eq!((&fields["unit"], &fields["up"]), (&json!("cm"), &json!("z")));
        fields.as_object_mut().unwrap().retain(|key, _| key != "unit" && key != "up");
        *own = fields.to_string().into();
    };
    let scene = sheet_in(Unit::Centimetre, Up::Z);
    let before = passed_on(&scene, |document| {
        forget(document);
        document["asset"]["extras"] = json!({ "loftsman": { "unit": "cm", "up": "z" } });
    });
    let (found, _) = read(&before);
    assert_eq!((found.unit, found.up), (Unit::Centimetre, Up::Z));
    assert_eq!(format!("{:?}", found.objects()), format!("{:?}", scene.objects()));
    // One in millimetres and one in metres: both as large as they are.
    let two = passed_on(&scene, |document| {
        let mut other = document["nodes"][0].clone();
        other["name"] = "other".into();
        let own = other["extras"]["loftsman"].as_str().unwrap().to_owned();
        let mut fields: Value = serde_json::from_str(&own).unwrap();
        (fields["unit"], fields["up"]) = ("m".into(), "y".into());
        fields.as_object_mut().unwrap().retain(|key, _| key != "shown_by" && key != "transform");
        other["extras"]["loftsman"] = fields.to_string().into();
        other.as_object_mut().unwrap().remove("mesh");
        document["nodes"].as_array_mut().unwrap().push(other);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let (found, report) = read(&two);
    assert_eq!((found.unit, found.up), (Unit::Metre, Up::Y));
    assert!(
        report.notes.iter().any(|note| note.contains("in cm with z up and in m with y up")),
        "{report:?}"
    );
    for (p, q) in found.objects()[0].geometry().points().iter().zip(patch().points()) {
        assert!((p - Point::new(q.x, q.z, -q.y) / 100.0).norm() < 1e-15, "{p} {q}");
    }
    assert_eq!(found.objects()[1].geometry().points(), patch().points());
}

#[test]
fn a_spline_whose_mesh_is_gone_is_there_all_the_same() {
    let scene = sheet_in(Unit::Millimetre, Up::Z);
    let file = passed_on(&scene, |document| {
        document["nodes"][0].as_object_mut().unwrap().remove("mesh");
        document.as_object_mut().unwrap().remove("meshes");
    });
    let (found, report) = read(&file);
    assert!(report.left_out.is_empty(), "{report:?}");
    let said = "1 exact spline has no lines or faces in the file any more";
    assert_eq!(report.notes.iter().filter(|note| note.starts_with(said)).count(), 1, "{report:?}");
    assert_eq!(format!("{:?}", found.objects()), format!("{:?}", scene.objects()));
}

/// Who says what a file's numbers are means the numbers as they stand in the file, whatever we noted of them.
#[test]
fn a_unit_and_an_axis_that_are_asked_for_are_those_of_the_numbers_in_the_file() {
    let file = write(&sheet_in(Unit::Millimetre, Up::Z));
    for (unit, up) in [(Unit::Metre, Up::Y), (Unit::Inch, Up::Y), (Unit::Metre, Up::Z)] {
        let options = ReadOptions { unit: Some(unit), up: Some(up), ..ReadOptions::default() };
        let (found, report) = Gltf.read(&file, &options).unwrap();
        assert!(report.left_out.is_empty(), "{report:?}");
        for (p, q) in found.objects()[0].geometry().points().iter().zip(patch().points()) {
            assert!((p - Point::new(q.x, q.z, -q.y) / 1000.0).norm() < 1e-15, "{unit:?} {up:?}: {p} {q}");
        }
    }
    // What goes out in axes of one's own is told.
    let mut file = Memory::new("turned.glb", "");
    let options = WriteOptions { up: UpChoice::To(Up::Z), ..coarse() };
    let report = Gltf.write(&sheet_in(Unit::Millimetre, Up::Z), &mut file, &options).unwrap();
    assert!(report.notes.iter().any(|note| note.contains("go out with z up")), "{report:?}");
}
