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
        // In Bézier form its own knots are noted beside it; where somebody has changed that form, it holds.
        let (file, _) = write(&scene, &keep());
        assert_eq!(read(&file).curve("a").unwrap(), &curve);
        let text = String::from_utf8(file.bytes).unwrap();
        let without: String =
            text.lines().filter(|l| !l.starts_with('#')).map(|l| format!("{l}\n")).collect();
        let bezier = curve.bezier_form().unwrap();
        assert_eq!(read(&Memory::new("b.obj", without)).curve("a").unwrap(), &bezier);
        let moved = text.replacen("\nv ", "\nv 1", 1);
        assert_eq!(read(&Memory::new("m.obj", moved)).curve("a").unwrap().space(), bezier.space());
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
    assert!(lines[2].starts_with("# Loftsman curve 3 open; knots "));
    assert!(lines[3].starts_with("v ") && lines[3].split(' ').count() == 5);
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
    assert_eq!(*back.object("mesh").unwrap().geometry(), Geometry::Mesh(mesh));
    assert_eq!(*back.object("loop").unwrap().geometry(), Geometry::Polyline(line));
    assert_eq!(*back.object("open").unwrap().geometry(), Geometry::Polyline(open));
    assert_eq!(*back.object("cloud").unwrap().geometry(), Geometry::Cloud(cloud));
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
    let p = back.object("p").unwrap().geometry().points()[0];
    assert!((p - Point::new(0.002, 0.003, -0.002)).norm() < 1e-18);
    let notes = report.losses.join("; ");
    assert!(notes.contains("baked") && notes.contains("hierarchy") && !notes.contains("colour"));
    assert_eq!(back.object("p").unwrap().color, Some([1.0; 4]));
}

#[test]
fn surfaces_are_exact_and_tessellated_or_one_of_both() {
    let space = Space::clamped_uniform(2, 3).unwrap();
    let points = (0..9).map(|k| Point::new(f64::from(k / 3), f64::from(k % 3), f64::from(k % 2))).collect();
    let surface = Surface::new(space.clone(), space, points).unwrap();
    let scene = one("s", &surface);
    let (file, report) = write(&scene, &keep());
    assert_eq!((report.objects[0].fate, report.objects[0].tolerance), (Fate::Kept, None));
    assert_eq!(*read(&file).object("s").unwrap().geometry(), Geometry::Surface(surface.clone()));
    let tessellator = Adaptive::default();
    let fineness = Fineness { chord: Chord::Absolute(0.01), angle: 0.3 };
    let with = |word: &str| {
        let own = Parameters::new(serde_json::json!({ "surfaces": word }), "options").unwrap();
        WriteOptions { tessellator: Some(&tessellator), fineness, own, ..keep() }
    };
    for (word, fate, kinds) in [
        ("both", Fate::Kept, "surface"),
        ("exact", Fate::Kept, "surface"),
        ("mesh", Fate::Approximated, "mesh"),
    ] {
        let (file, report) = write(&scene, &with(word));
        assert_eq!(report.objects[0].fate, fate);
        assert_eq!(report.objects[0].tolerance, (word != "exact").then_some(0.01));
        let error = report.objects[0].error;
        assert!(
            error.is_some() == (word != "exact") && error.is_none_or(|e| e > 0.0 && e <= 0.01),
            "{error:?}"
        );
        let back = read(&file);
        let found: Vec<_> = back.objects().iter().map(|o| o.geometry().kind()).collect();
        assert_eq!(found.join(" "), kinds);
        assert_eq!(back.objects()[0].name(), "s");
        for object in back.objects() {
            match object.geometry() {
                Geometry::Mesh(m) => {
                    assert!(m.normals.values().len() == m.points().len() && !m.uvs.is_empty());
                    assert!(report.objects[0].form.contains(&format!("{} triangles", m.face_count())));
                }
                other => assert_eq!(other, &Geometry::Surface(surface.clone())),
            }
        }
    }
}

#[test]
fn periodic_surfaces_and_trimmed_ones_come_back_exactly() {
    let around = Space::periodic(2, vec![0.0, 1.0, 1.5, 3.0, 4.0]).unwrap();
    let along = Space::clamped(1, &[0.0, 0.1, 1.0 / 3.0]).unwrap();
    let points: Vec<Point> =
        (0..12).map(|k| Point::new(f64::from(k).sin(), f64::from(k) / 3.0, f64::from(k * k % 7))).collect();
    let weights: Vec<f64> = (0..12).map(|k| 1.0 + f64::from(k) / 7.0).collect();
    for (u, v) in [(around.clone(), along.clone()), (along, around)] {
        for weights in [None, Some(weights.clone())] {
            let surface = Surface::build(u.clone(), v.clone(), points.clone(), weights).unwrap();
            let back = read(&write(&one("s", &surface), &keep()).0);
            assert_eq!(*back.object("s").unwrap().geometry(), Geometry::Surface(surface));
        }
    }
    let sample = loftsman_kernel::conformance::sample_scene();
    let window = sample.object("window").unwrap();
    let mut scene = one("window", window.geometry().clone());
    let Geometry::Trimmed(trimmed) = window.geometry() else { unreachable!() };
    let side = loftsman_kernel::connection::Side {
        object: "window".into(),
        curve: trimmed.regions()[0].outer[1].clone(),
    };
    scene.connect(loftsman_kernel::connection::Connection { first: side.clone(), second: side }).unwrap();
    let (file, report) = write(&scene, &keep());
    assert_eq!(report.objects[0].fate, Fate::Kept);
    assert!(report.objects[0].reason.as_ref().unwrap().contains("none is registered"));
    let back = read(&file);
    assert_eq!(back.object("window").unwrap().geometry(), window.geometry());
    assert_eq!(back.connections(), scene.connections());
    let own = Parameters::new(serde_json::json!({ "surfaces": "mesh" }), "options").unwrap();
    let (_, report) = write(&scene, &WriteOptions { own, ..keep() });
    assert_eq!(report.objects[0].fate, Fate::LeftOut);
    assert!(report.objects[0].reason.as_ref().unwrap().contains("none is registered"));
}

/// Everything a mesh of an OBJ file can hold, twice, so that indices count on.
#[test]
fn layers_groups_smoothing_materials_and_lines_come_back() {
    let text = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nv 0 0 1 0 0 0\n\
        vt 0 0\nvt 1 0\nvt 0.1 0.2\nvn 0 0 1\nvn 1 0 0\nvn 0.6 0 0.8\n\
        o first\ng left all\ns 1\nusemtl red\nf 1/1/1 2/2/1 3/3/2 4/1/3\ng right all\ns off\nusemtl blue steel\n\
        f 1//1 2//2 5//3\ng\nf 1/1 2/2 5/3\ng left\ns 7\nf 1 2 5\nl 1 3 5\nl 2 4\n\
        o second\ng all\nusemtl red\nf 5 4 3 2 1\n";
    let mut file = Memory::new("t.obj", text);
    let library = "newmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 10\nillum 2\nmap_Kd -s 2 2 1 tex/red.png\n\
        newmtl blue steel\nKd 0 0 1\nd 0.5\nPr 0.25\nPm 1\nmap_Bump -bm 0.3 b.png\nmap_Ks -imfchan r k.png\n";
    file.siblings.insert("m.mtl".into(), library.into());
    let scene = read(&file);
    let Geometry::Mesh(mesh) = scene.object("first").unwrap().geometry() else { unreachable!() };
    let groups: Vec<_> = mesh.groups.iter().map(|g| (g.name.as_str(), g.faces.as_slice())).collect();
    assert_eq!(groups, [("left", &[0, 3][..]), ("all", &[0, 1]), ("right", &[1])]);
    assert_eq!(
        (mesh.smoothing.as_slice(), mesh.materials.as_slice()),
        (&[1, 0, 0, 7][..], &[0, 1, 1, 1][..])
    );
    assert_eq!(mesh.lines().collect::<Vec<_>>(), [&[0, 2, 4][..], &[1, 3]]);
    assert_eq!((mesh.uvs.values().len(), mesh.normals.values().len()), (3, 3));
    let (written, report) = write(&scene, &keep());
    assert!(report.objects.iter().all(|o| o.fate == Fate::Kept));
    let back = read(&written);
    let same_colors = |a: &Mesh, b: &Mesh| {
        let pairs = a.colors.values().iter().flatten().zip(b.colors.values().iter().flatten());
        a.colors.corners() == b.colors.corners() && pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12)
    };
    for (a, b) in scene.objects().iter().zip(back.objects()) {
        assert_eq!((a.name(), &a.materials), (b.name(), &b.materials));
        let (Geometry::Mesh(a), Geometry::Mesh(b)) = (a.geometry(), b.geometry()) else { unreachable!() };
        assert!(same_colors(a, b));
        let plain = |m: &Mesh| {
            let mut plain = m.clone();
            plain.colors = Layer::none();
            plain
        };
        assert_eq!(plain(a), plain(b));
    }
    assert_eq!((&scene.materials, &scene.images), (&back.materials, &back.images));
}

#[test]
fn pictures_in_the_scene_become_files_beside_it_and_never_elsewhere() {
    use loftsman_kernel::material::{Channel, Image, ImageData, Material, Texture};
    let mut scene = one("cloud", Cloud { points: vec![Point::origin()] });
    let png = || ImageData::Embedded { media_type: "image/png".into(), bytes: (*b"png").into() };
    scene.images.add(Image::new("../../etc/pass\nwd", png())).unwrap();
    scene.images.add(Image::new("out", ImageData::File("../out.png".into()))).unwrap();
    let mut material = Material::new("a\nb", [0.1, 0.2, 0.3, 1.0]);
    material.textures.insert(Channel::BaseColor, Texture::new("../../etc/pass\nwd"));
    material.textures.insert(Channel::Emissive, Texture::new("out"));
    scene.materials.add(material).unwrap();
    let (file, report) = write(&scene, &keep());
    let names: Vec<_> = file.siblings.keys().chain(file.pictures.keys()).map(String::as_str).collect();
    assert_eq!(names, ["part.mtl", "_.._etc_pass_wd.png"]);
    let library = String::from_utf8(file.siblings["part.mtl"].clone()).unwrap();
    assert!(
        library.contains("newmtl a_b\nKd 0.1 0.2 0.3\n") && library.contains("map_Kd _.._etc_pass_wd.png\n")
    );
    assert!(!library.contains("out.png") && report.notes.iter().any(|n| n.contains("outside")));
    assert!(String::from_utf8(file.bytes).unwrap().contains("mtllib part.mtl\n"));
}

#[test]
fn pictures_without_names_do_not_take_those_of_other_files_of_the_folder() {
    use loftsman_kernel::material::{Channel, Image, ImageData, Material, Texture};
    let mut scene = one("cloud", Cloud { points: vec![Point::origin()] });
    // The second of them is one of another file, which was merged.
    for name in ["image 0", "image 0.001", "wood"] {
        let data = ImageData::Embedded { media_type: "image/png".into(), bytes: (*b"png").into() };
        scene.images.add(Image::new(name, data)).unwrap();
        let mut material = Material::new(name, [0.1, 0.2, 0.3, 1.0]);
        material.textures.insert(Channel::BaseColor, Texture::new(name));
        scene.materials.add(material).unwrap();
    }
    let mut names = Vec::new();
    for file in ["left.obj", "right.obj"] {
        let mut file = Memory::new(file, "");
        Obj.write(&scene, &mut file, &keep()).unwrap();
        names.extend(file.pictures.into_keys());
    }
    let of =
        |stem: &str| [format!("{stem} image 0.001.png"), format!("{stem} image 0.png"), "wood.png".into()];
    assert_eq!(names, [of("left"), of("right")].concat());
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
    assert!(report.notes.iter().any(|n| n.contains("1 mesh without normals")));
    assert_eq!(String::from_utf8_lossy(&file.bytes).matches("vn ").count(), 8);
    let back = read(&file);
    // They are noted as made here, and do not come back.
    assert_eq!(*back.object("flat").unwrap().geometry(), Geometry::Mesh(flat.clone()));
    let text = String::from_utf8_lossy(&file.bytes).replace("# Loftsman normals\n", "");
    let back = read(&Memory::new("n.obj", text));
    let Geometry::Mesh(given) = back.object("flat").unwrap().geometry() else { unreachable!() };
    for (corner, &point) in given.corners().iter().enumerate() {
        assert_eq!(given.normals.at(corner, point), flat.face_normal(corner / 3).as_ref());
    }
    assert_eq!(*back.object("smooth").unwrap().geometry(), Geometry::Mesh(smooth));
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
        prop_assert_eq!(back.object("m").unwrap().geometry(), &Geometry::Mesh(mesh));
    }
}

#[test]
fn it_is_a_format() {
    use loftsman_kernel::conformance::{format_conformance, sample_scene};
    let verdict = format_conformance(&Obj, &sample_scene());
    assert!(verdict.passed(), "{verdict}");
}

/// Two curves under one name: two objects with one label. OBJ would make one object of them again, so that names go out.
#[test]
fn one_name_for_several_is_their_label_and_names_go_out() {
    let curve = "cstype bspline\ndeg 1\ncurv 0 1 1 2\nparm u 0 0 1 1\nend\n";
    let text = format!("v 0 0 0\nv 1 0 0\no bolt\n{curve}{curve}{curve}");
    let scene = read(&Memory::new("part.obj", text));
    let names: Vec<_> = scene.objects().iter().map(|o| (o.name(), o.label.as_deref())).collect();
    assert_eq!(names, [("bolt", None), ("bolt.001", Some("bolt")), ("bolt.002", Some("bolt"))]);
    let (file, report) = write(&scene, &keep());
    assert!(
        report.losses.iter().any(|note| note.starts_with("2 labels are left out")),
        "{:?}",
        report.losses
    );
    let back = read(&file);
    let names: Vec<_> = back.objects().iter().map(|o| (o.name(), o.label.as_deref())).collect();
    assert_eq!(names, [("bolt", None), ("bolt.001", None), ("bolt.002", None)]);
    assert_eq!(write(&back, &keep()).0.bytes, file.bytes);
    // What is called after the file has no name in it.
    let nameless = read(&Memory::new("part.obj", format!("v 0 0 0\nv 1 0 0\n{curve}{curve}")));
    assert!(nameless.objects().iter().all(|o| o.label.is_none() && o.name().starts_with("part")));
}

#[test]
fn what_obj_cannot_say_of_layers_and_units_is_said() {
    let mut scene = one("dot", Cloud { points: vec![Point::origin()] });
    let mut layer = loftsman_kernel::scene::Layer::new("off");
    (layer.visible, layer.color) = (false, Some([1.0, 0.0, 0.0, 1.0]));
    scene.layers.add(layer).unwrap();
    scene.object_mut("dot").unwrap().layer = Some("off".into());
    let (file, report) = write(&scene, &keep());
    for words in ["1 layer name is", "1 object is on a hidden layer and goes out as all others"] {
        assert!(report.losses.iter().any(|note| note.contains(words)), "{words}: {:?}", report.losses);
    }
    let (back, _) = Obj.read(&file, &ReadOptions::default()).unwrap();
    // The colour that the layer lent.
    assert_eq!(back.object("dot").unwrap().color, Some([1.0, 0.0, 0.0, 1.0]));
    // The unit that a comment says.
    assert_eq!((back.unit, back.objects().len()), (scene.unit, 1));
    let text =
        String::from_utf8_lossy(&file.bytes).lines().skip(1).map(|l| format!("{l}\n")).collect::<String>();
    let file = Memory::new("part.obj", text);
    let (back, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    assert_eq!((back.unit, back.objects().len()), (Unit::Unknown, 1));
    // That it is unknown is no news to who reads it.
    assert!(!report.notes.iter().any(|note| note.contains("unit")), "{:?}", report.notes);
    let known = ReadOptions { unit: Some(Unit::Inch), ..ReadOptions::default() };
    let (known, report) = Obj.read(&file, &known).unwrap();
    assert!(known.unit == Unit::Inch && !report.notes.iter().any(|note| note.contains("unknown")));
    // An unknown unit goes out as the one that is asked for, unchanged.
    let options = WriteOptions { unit: Some(Unit::Millimetre), ..keep() };
    let (file, report) = write(&back, &options);
    assert!(String::from_utf8_lossy(&file.bytes).starts_with("# Loftsman; unit mm"));
    assert!(report.losses.iter().any(|note| note.contains("in mm, as asked for")), "{:?}", report.losses);
}

/// What was written of nothing but groups, which OBJ does not have, is read as the empty scene that it is; nothing at all is no file still.
#[test]
fn a_file_of_groups_alone_is_read_again() {
    let mut scene = one("rig", Geometry::Group);
    for (unit, up) in [(Unit::Millimetre, Up::Z), (Unit::Unknown, Up::Y)] {
        (scene.unit, scene.up) = (unit, up);
        let (file, report) = write(&scene, &keep());
        assert_eq!(report.objects[0].fate, Fate::LeftOut);
        let back = read(&file);
        assert_eq!((back.objects().len(), back.unit, back.up), (0, unit, up));
    }
    for bytes in ["", "\n", "# a comment\n", "# Loftsman\n"] {
        let refused = Obj.read(&Memory::new("part.obj", bytes), &ReadOptions::default()).unwrap_err();
        assert!(refused.to_string().contains("no statement of an OBJ file"), "{refused}");
    }
}
