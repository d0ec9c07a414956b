//! Whatever a file says is in the scene, or counted in the report; whatever a scene holds goes out, or is noted.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::material::{Channel, Image, ImageData, Material, Texture};
use loftsman_kernel::mesh::Layer;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_obj::Obj;

fn read(text: &str) -> (Scene, ReadReport) {
    let (scene, report) = Obj.read(&Memory::new("part.obj", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up(), "{report:?}");
    scene.check().unwrap();
    (scene, report)
}

fn write(scene: &Scene) -> (Memory, Vec<String>) {
    let mut file = Memory::new("part.obj", "");
    let report = Obj.write(scene, &mut file, &WriteOptions::default()).unwrap();
    (file, report.told())
}

/// How many of what was left out for a reason that has these words.
fn left_out(report: &ReadReport, words: &str) -> usize {
    report.left_out.iter().filter(|(why, _)| why.contains(words)).map(|(_, count)| count).sum()
}

const COLORED: &str = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\n";

#[test]
fn colours_of_lines_and_points_come_back() {
    for element in ["l 1 2 3", "l 1 2 3 4 1", "p 1 2 4"] {
        let (scene, report) = read(&format!("{COLORED}o a\n{element}\n"));
        assert_eq!(left_out(&report, "colour"), 0, "{report:?}");
        let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!("{element}") };
        assert_eq!((mesh.face_count(), mesh.colors.values().len()), (0, mesh.points().len()));
        assert_eq!(mesh.lines().count(), usize::from(element.starts_with('l')));
        let (file, _) = write(&scene);
        let (back, _) = Obj.read(&file, &ReadOptions::default()).unwrap();
        let Geometry::Mesh(again) = back.objects()[0].geometry() else { unreachable!("{element}") };
        assert_eq!(again.points(), mesh.points(), "{element}");
        assert!(again.lines().eq(mesh.lines()), "{element}");
        for (a, b) in again.colors.values().iter().zip(mesh.colors.values()) {
            assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-15), "{a:?} {b:?}");
        }
    }
}

#[test]
fn colours_that_have_no_place_are_counted() {
    // Only some vertices of the line, and of the points; the control points of a curve; a line beside half-coloured faces.
    let (_, report) = read("v 0 0 0 1 0 0\nv 1 0 0\nl 1 2\n");
    assert_eq!(left_out(&report, "colour"), 1, "{report:?}");
    let (_, report) = read("v 0 0 0 1 0 0\nv 1 0 0\nv 2 0 0 0 0 1\np 1 2 3\n");
    assert_eq!(left_out(&report, "colour"), 2, "{report:?}");
    let curve = "cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\n";
    let (scene, report) = read(&format!("{COLORED}{curve}"));
    assert_eq!((scene.objects().len(), left_out(&report, "colour")), (1, 4), "{report:?}");
    let (_, report) = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5 1 0 0\nf 1 2 3\nl 1 4\n");
    assert_eq!(left_out(&report, "colour"), 1, "{report:?}");
}

#[test]
fn materials_of_lines_and_points_come_back() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nusemtl red\nl 1 2\nusemtl blue\nl 2 3\np 1\nusemtl red\np 3\n";
    let (scene, report) = read(text);
    let looks =
        |scene: &Scene| -> Vec<Vec<String>> { scene.objects().iter().map(|o| o.materials.clone()).collect() };
    assert_eq!(looks(&scene), [["red"], ["blue"], ["blue"], ["red"]], "{report:?}");
    let (file, _) = write(&scene);
    let (back, _) = Obj.read(&file, &ReadOptions::default()).unwrap();
    assert_eq!(looks(&back), looks(&scene));
    // Beside faces lines look as the first material does, or it is said.
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    assert_eq!(left_out(&read(&format!("{faces}l 1 2\n")).1, "materials of lines"), 0);
    assert_eq!(left_out(&read(&format!("{faces}usemtl blue\nl 1 2\n")).1, "materials of lines"), 1);
}

#[test]
fn groups_name_lines_and_points_or_are_counted() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let (scene, report) = read(&format!("{vertices}g keel\nl 1 2\ng stem\np 3\n"));
    let names: Vec<&str> = scene.objects().iter().map(Object::name).collect();
    assert_eq!((names.as_slice(), left_out(&report, "group")), (["keel", "stem"].as_slice(), 0));
    assert_eq!(left_out(&read(&format!("{vertices}o a\ng keel\nl 1 2\n")).1, "groups of lines"), 1);
    assert_eq!(left_out(&read(&format!("{vertices}g b\nf 1 2 3\nl 1 2\n")).1, "groups of lines beside"), 1);
    assert_eq!(left_out(&read(&format!("{vertices}g b\ng c\nf 1 2 3\n")).1, "groups (g) that have no"), 1);
}

/// Blender writes meshes first, each after its `o`, then curves, each after a `g`.
#[test]
fn curves_behind_a_mesh_have_the_names_of_their_groups() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\no Cube\ng side\nf 1 2 3\n";
    let curve = "cstype bspline\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 0 0 1 1 1\nend\n";
    let (scene, report) = read(&format!("{mesh}g path\n{curve}g ring\n{curve}"));
    let names: Vec<&str> = scene.objects().iter().map(Object::name).collect();
    assert_eq!((names.as_slice(), left_out(&report, "group")), (["Cube", "path", "ring"].as_slice(), 0));
    // The group of the faces is not the curve's name, and of a named curve a group is left out as before.
    for text in [format!("{mesh}{curve}"), format!("v 0 0 0\nv 1 0 0\nv 0 1 0\no Cube\ng path\n{curve}")] {
        let (scene, report) = read(&text);
        assert_eq!(scene.objects().last().map(Object::label), Some("Cube"), "{text}");
        assert_eq!(left_out(&report, "groups of curves"), 1, "{text}");
    }
}

#[test]
fn names_without_elements_and_weights_without_use_are_counted() {
    let (scene, report) = read("o nothing\nv 0 0 0\nv 1 0 0 2\nv 0 1 0\no a\nf 1 2 3\no b\n");
    assert_eq!(scene.objects().len(), 1);
    assert_eq!(left_out(&report, "names of objects"), 2, "{report:?}");
    assert_eq!(left_out(&report, "weights of vertices"), 1, "{report:?}");
}

#[test]
fn statements_about_display_are_counted() {
    for statement in ["mg 1 0.5", "lod 3", "bevel on", "usemap wood", "maplib a.map", "ctech cparm 1"] {
        let (_, report) = read(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{statement}\nf 1 2 3\n"));
        assert_eq!(report.left_out.values().sum::<usize>(), 1, "{statement}: {report:?}");
    }
    // Smoothing groups are kept.
    let (scene, report) = read("v 0 0 0\nv 1 0 0\nv 0 1 0\ns 3\nf 1 2 3\n");
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!() };
    assert_eq!((mesh.smoothing.as_slice(), report.left_out.len()), ([3].as_slice(), 0));
}

#[test]
fn what_obj_cannot_hold_is_noted() {
    let (mut scene, _) = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let name = scene.objects()[0].name().to_owned();
    let object = scene.object_mut(&name).unwrap();
    object.statements.push(("gltf extras".into(), "{}".into()));
    let Geometry::Mesh(mesh) = object.geometry_mut() else { unreachable!() };
    mesh.tangents = Layer::per_point(vec![[1.0, 0.0, 0.0, 1.0]; 3]);
    let (_, notes) = write(&scene);
    for what in ["tangents", "1 statement of other formats is left out (gltf extras)"] {
        assert!(notes.iter().any(|note| note.contains(what)), "{what}: {notes:?}");
    }
}

/// Names that OBJ cannot hold are told beforehand and afterwards, each with what it becomes; those that it can are not.
#[test]
fn changed_names_are_said() {
    let (mut scene, _) = read("v 0 0 0\nv 1 0 0\nv 0 1 0\no plain\ng side\nf 1 2 3\n");
    let options = WriteOptions::default();
    assert!(Obj.losses(&scene, &options).unwrap().iter().all(|loss| !loss.contains("name")));
    let mesh = scene.objects()[0].geometry().clone();
    for name in ["a # b", "ünï\\", " lead", "line\nbreak"] {
        scene.add(Object::new(name, mesh.clone())).unwrap();
    }
    let Geometry::Mesh(grouped) = scene.object_mut("plain").unwrap().geometry_mut() else { unreachable!() };
    grouped.groups[0].name = "left side".to_owned();
    scene.materials.add(Material::new("#1", [1.0; 4])).unwrap();
    let told: Vec<String> = (Obj.losses(&scene, &options).unwrap().into_iter())
        .filter(|loss| loss.contains("cannot stand in OBJ"))
        .collect();
    assert_eq!(
        told,
        [
            "4 names of objects cannot stand in OBJ and are changed: \"a # b\" as \"a _# b\", \"ünï\\\\\" as \"ünï_\", \" lead\" as \"lead\", …",
            "1 name of a material cannot stand in OBJ and is changed: \"#1\" as \"_#1\"",
            "1 name of a group cannot stand in OBJ and is changed: \"left side\" as \"left_side\"",
        ]
    );
    let mut file = Memory::new("part.obj", "");
    let report = Obj.write(&scene, &mut file, &options).unwrap();
    assert!(told.iter().all(|told| report.losses.contains(told)), "{:?}", report.losses);
    let names = Obj.read(&file, &ReadOptions::default()).unwrap().0;
    let names: Vec<&str> = names.objects().iter().map(|o| o.name()).collect();
    assert_eq!(names, ["plain", "a _# b", "ünï_", "lead", "line_break"]);
}

#[test]
fn pictures_go_along() {
    let (mut scene, _) = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for picture in ["tex/wood.png", "lost.png"] {
        scene.images.add(Image::new(picture, ImageData::File(picture.into()))).unwrap();
    }
    let mut material = Material::new("wood", [1.0; 4]);
    material.textures.insert(Channel::BaseColor, Texture::new("tex/wood.png"));
    material.textures.insert(Channel::Emissive, Texture::new("lost.png"));
    scene.materials.add(material).unwrap();
    let mut source = Memory::new("in.obj", "");
    source.pictures.insert("tex/wood.png".into(), b"picture".to_vec());
    let mut file = Memory::new("part.obj", "");
    let options = WriteOptions { pictures: Some(&source), ..WriteOptions::default() };
    let report = Obj.write(&scene, &mut file, &options).unwrap();
    assert_eq!(file.pictures, source.pictures);
    assert!(report.notes.iter().any(|n| n.starts_with("1 picture") && n.contains("missing")), "{report:?}");
}

/// A surface of `n × n` control vertices by a basis matrix of some degree, whose pieces begin one vertex after the other: straight between the first two of
/// their vertices, so that they meet.
fn overlapping(degree: usize, n: usize) -> String {
    let order = degree + 1;
    let entry = |i: usize, power: usize| match (i, power) {
        (0, 0) | (1, 1) => "1",
        (0, 1) => "-1",
        _ => "0",
    };
    let matrix: Vec<&str> = (0..order * order).map(|k| entry(k / order, k % order)).collect();
    let matrix = matrix.join(" ");
    let numbers =
        |range: std::ops::RangeInclusive<usize>| range.map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    let points: String = (0..n * n).map(|k| format!("v {} {} {}\n", k % n, k / n, k % 7)).collect();
    let (pieces, vertices) = (n - degree, numbers(1..=n * n));
    let breaks = numbers(0..=pieces);
    format!(
        "{points}cstype bmatrix\ndeg {degree} {degree}\nstep 1 1\nbmat u {matrix}\nbmat v {matrix}\n\
         surf 0 {pieces} 0 {pieces} {vertices}\nparm u {breaks}\nparm v {breaks}\nend\n"
    )
}

/// A small file does not become a large surface: one of which more than 32 times the control vertices would be made is left out and said; one of 22
/// times is kept, and so is a small one, whatever it grows by.
#[test]
fn surfaces_that_would_grow_too_large_are_left_out() {
    for (degree, n, kept) in [(5, 100, true), (6, 250, false), (12, 28, true)] {
        let (scene, report) = read(&overlapping(degree, n));
        let left = left_out(&report, "the B-spline form would be more than 32 times as large");
        let sizes: Vec<usize> =
            scene.objects().iter().map(|object| object.geometry().points().len()).collect();
        let expected = if kept { vec![(degree * (n - degree) + 1).pow(2)] } else { vec![] };
        assert_eq!((sizes, left), (expected, usize::from(!kept)), "{degree} {n}: {:?}", report.left_out);
    }
}
