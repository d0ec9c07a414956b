//! Every file of other programs that lies in `tests/data`, converted: the Khronos validator finds nothing to say of any,
//! and what the formats hold comes back.

use std::path::{Path, PathBuf};

use loftsman::kernel::scene::{Geometry, Scene};
use loftsman::kernel::spline::Trimmed;
use loftsman_tests::oracle::Oracle;
use serde_json::json;

use crate::LOFTSMAN;

/// Files that are refused, with words of the one message that says why: they break their format's rules.
const REFUSED: [(&str, &str); 2] =
    [("spec_trimmed_nurb_surface.obj", "is repeated 6 times"), ("CubeHierarchy.gltf", "CubeHierarchy.bin")];

/// The files of a folder of the data, by name, with or without those that are refused.
fn files(folder: &str, refused: bool) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(loftsman_tests::repository().join("tests/data").join(folder)).unwrap();
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    let is_refused = |name: &str| REFUSED.iter().any(|(file, _)| *file == name);
    all.retain(|path| {
        let name = path.file_name().unwrap().to_string_lossy();
        !name.starts_with('.')
            && !name.ends_with(".md")
            && !name.ends_with(".bin")
            && is_refused(&name) == refused
    });
    all.sort();
    all
}

#[test]
fn the_validator_finds_nothing_to_say_of_any_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut outputs = Vec::new();
    for (group, least) in [("gltf", 20), ("obj", 25), ("points", 5)] {
        let inputs = files(group, false);
        assert!(inputs.len() >= least, "{group} has only {}", inputs.len());
        for extension in ["glb", "gltf"] {
            let into = folder.path().join(format!("{group}-{extension}"));
            std::fs::create_dir(&into).unwrap();
            for input in &inputs {
                let out = into.join(format!("{}.{extension}", input.file_name().unwrap().to_string_lossy()));
                LOFTSMAN.done(folder.path(), &["convert", &text(input), &text(&out)]);
                outputs.push(out);
            }
        }
    }
    let Some(reports) = Oracle::GltfValidator.ask(&outputs, &[]) else { return };
    for report in reports {
        assert_eq!((&report["errors"], &report["warnings"]), (&json!(0), &json!(0)), "{report:#}");
    }
}

/// Normal maps need tangents: these are made where a file has none, whatever the texture coordinates are like.
#[test]
fn the_validator_finds_nothing_to_say_of_the_tangents_we_make() {
    let folder = tempfile::tempdir().unwrap();
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nv 0.5 0.5 1\n";
    // As usual, mirrored, all in one place, along a line, and far out.
    let coordinates = [
        ("usual", "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n"),
        ("mirrored", "vt 1 0\nvt 0 0\nvt 0 1\nvt 1 1\nvt 0.5 0.5\n"),
        ("one", "vt 0 0\nvt 0 0\nvt 0 0\nvt 0 0\nvt 0 0\n"),
        ("line", "vt 0 0\nvt 1 1\nvt 2 2\nvt 3 3\nvt 4 4\n"),
        ("far", "vt 1e9 0\nvt -1e9 0\nvt 1e-9 1\nvt 0 1e9\nvt 0.5 0.5\n"),
    ];
    let library = "newmtl bumpy\nKd 0.8 0.7 0.6\nnorm bump.png\nnewmtl plain\nKd 0.1 0.2 0.3\n";
    std::fs::write(folder.path().join("a.mtl"), library).unwrap();
    let picture = loftsman_tests::repository().join("examples/blade-section/section.png");
    std::fs::copy(picture, folder.path().join("bump.png")).unwrap();
    let mut outputs = Vec::new();
    for (name, coordinates) in coordinates {
        let faces = "usemtl bumpy\nf 1/1 2/2 3/3 4/4\nf 1/1 2/2 5/5\nusemtl plain\nf 3/3 4/4 5/5\n";
        let source = format!("mtllib a.mtl\n{points}{coordinates}{faces}");
        std::fs::write(folder.path().join(format!("{name}.obj")), source).unwrap();
        for extension in ["glb", "gltf"] {
            let [from, to] = [format!("{name}.obj"), format!("{name}.{extension}")];
            LOFTSMAN.done(folder.path(), &["convert", &from, &to]);
            outputs.push(folder.path().join(to));
        }
        let written = std::fs::read_to_string(folder.path().join(format!("{name}.gltf"))).unwrap();
        assert!(written.contains("\"TANGENT\"") && written.contains("normalTexture"), "{name}: {written}");
    }
    let Some(reports) = Oracle::GltfValidator.ask(&outputs, &[]) else { return };
    for report in reports {
        assert_eq!((&report["errors"], &report["warnings"]), (&json!(0), &json!(0)), "{report:#}");
    }
}

#[test]
fn files_that_break_the_rules_are_refused_with_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let refused: Vec<PathBuf> = ["gltf", "obj"].iter().flat_map(|group| files(group, true)).collect();
    assert_eq!(refused.len(), REFUSED.len());
    for input in refused {
        let run = LOFTSMAN.run(folder.path(), &["convert", &text(&input), "out.glb"]);
        let said = run.err;
        let name = input.file_name().unwrap().to_string_lossy();
        let words = REFUSED.iter().find(|(file, _)| *file == name).unwrap().1;
        assert_eq!(run.code, Some(1), "{said}");
        assert!(said.contains(words) && said.trim().lines().count() == 1, "{said}");
        assert!(!folder.path().join("out.glb").exists());
    }
}

/// What a folder holds, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<_> = entries
        .filter(|path| path.is_file())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap()))
        .collect();
    all.sort();
    all
}

/// What was written once is written again with the same bytes, and what lies beside it, too; and so it is where a native document, which holds
/// everything, stands between.
#[test]
fn one_pass_reaches_a_fixed_point() {
    let mut done = 0;
    for (group, extensions, least) in
        [("gltf", &["glb", "gltf"][..], 20), ("obj", &["obj"], 25), ("points", &["obj", "glb"], 5)]
    {
        let inputs = files(group, false);
        assert!(inputs.len() >= least, "{group} has only {}", inputs.len());
        for input in inputs {
            for extension in extensions {
                let folder = tempfile::tempdir().unwrap();
                let folders = ["first", "second", "document", "third"].map(|name| folder.path().join(name));
                folders.iter().for_each(|into| std::fs::create_dir(into).unwrap());
                let [first, second, document, third] = &folders;
                let name = format!("x.{extension}");
                let native = text(&document.join("x.loft.json"));
                let [once, twice, by_native] = [first, second, third].map(|into| text(&into.join(&name)));
                LOFTSMAN.done(folder.path(), &["convert", &text(&input), &once]);
                LOFTSMAN.done(folder.path(), &["convert", &once, &twice]);
                LOFTSMAN.done(folder.path(), &["convert", &text(&input), &native]);
                LOFTSMAN.done(folder.path(), &["convert", &native, &by_native]);
                let once = contents(first);
                for (again, way) in [(second, "read and written again"), (third, "by way of a document")] {
                    let again = contents(again);
                    let [a, b] =
                        [&once, &again].map(|all| all.iter().map(|(name, _)| name).collect::<Vec<_>>());
                    assert_eq!(a, b, "{} as {extension}, {way}", input.display());
                    for ((name, once), (_, again)) in once.iter().zip(&again) {
                        assert!(once == again, "{} as {extension}, {way}: {name} changed", input.display());
                    }
                }
                done += 1;
            }
        }
    }
    assert!(done >= 75, "{done}");
}

/// So it is with what we wrote ourselves in other units and axes than glTF's, which we note and read again: solids of CAD files, and meshes with smooth normals.
#[test]
fn our_own_files_reach_a_fixed_point_in_any_unit_and_axes() {
    let small = |path: &PathBuf| std::fs::metadata(path).unwrap().len() < 120_000;
    let inputs: Vec<PathBuf> =
        ["step", "iges", "obj"].iter().flat_map(|group| files(group, false)).filter(small).collect();
    let mut done = 0;
    for (k, input) in inputs.iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["0.glb", "1.glb", "2.glb"].map(|name| folder.path().join(name));
        let [first, once, twice] = paths.each_ref().map(|path| text(path));
        let input_name = text(input);
        // CAD files have units of their own, of numbers in OBJ files it names them.
        let unit = ["mm", "in", "m"][k % 3];
        let mut words = vec!["convert", &input_name, &first];
        if input_name.ends_with(".obj") {
            words.extend(["--unit", unit, "--from-up", "z"]);
        }
        if LOFTSMAN.run(folder.path(), &words).code != Some(0) {
            continue;
        }
        LOFTSMAN.done(folder.path(), &["convert", &first, &once]);
        LOFTSMAN.done(folder.path(), &["convert", &once, &twice]);
        let [first, once, twice] = paths.each_ref().map(|path| std::fs::read(path).unwrap());
        // Meshes of other programs may have a -0 that turning makes 0; what we cut has none.
        let is_cut = !input_name.ends_with(".obj");
        assert!((first == once || !is_cut) && once == twice, "{} in {unit}", input.display());
        done += 1;
    }
    assert!(done >= 40, "{done} of {}", inputs.len());
}

#[test]
fn what_gltf_holds_comes_back() {
    let inputs = files("gltf", false);
    assert!(inputs.len() >= 20, "{}", inputs.len());
    for input in inputs {
        let first = loftsman::read_scene(&input).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for out in ["out.glb", "out.gltf"] {
            let path = folder.path().join(out);
            LOFTSMAN.done(folder.path(), &["convert", &text(&input), out]);
            same(&input, &first, &loftsman::read_scene(path).unwrap(), 0.0, false);
        }
    }
}

#[test]
fn what_obj_holds_comes_back() {
    let inputs = files("obj", false);
    assert!(inputs.len() >= 25, "{}", inputs.len());
    for input in inputs {
        let first = loftsman::read_scene(&input).unwrap();
        let folder = tempfile::tempdir().unwrap();
        LOFTSMAN.done(
            folder.path(),
            &["convert", &text(&input), "out.obj", "--write", "knots=any", "--write", "surfaces=exact"],
        );
        same(&input, &first, &loftsman::read_scene(folder.path().join("out.obj")).unwrap(), 1e-14, true);
    }
}

/// Objects by name with their points, frames, layers and materials; the hierarchy. `flat`: the format has none.
fn same(file: &Path, first: &Scene, second: &Scene, within: f64, flat: bool) {
    let names = |scene: &Scene| -> Vec<String> {
        let kept = scene.objects().iter().filter(|o| !flat || !matches!(o.geometry(), Geometry::Group));
        kept.map(|o| o.name().to_owned()).collect()
    };
    assert_eq!(names(first), names(second), "{}", file.display());
    for name in names(first) {
        let what = format!("{} \"{name}\"", file.display());
        let (a, b) = (first.get(&name).unwrap(), second.get(&name).unwrap());
        assert_eq!(a.geometry().kind(), b.geometry().kind(), "{what}");
        let (p, q) = (a.geometry().points(), b.geometry().points());
        assert_eq!(p.len(), q.len(), "{what}");
        for (p, q) in p.iter().zip(q) {
            assert!((p - q).amax() <= within * p.coords.amax().max(1.0), "{what}: {p} {q}");
        }
        assert_eq!((a.materials.len(), a.color), (b.materials.len(), b.color), "{what}");
        if !flat {
            assert_eq!(
                (&a.parent, &a.transform, &a.animation),
                (&b.parent, &b.transform, &b.animation),
                "{what}"
            );
            assert_eq!((&a.materials, &a.statements), (&b.materials, &b.statements), "{what}");
        }
        match (a.geometry(), b.geometry()) {
            (Geometry::Mesh(a), Geometry::Mesh(b)) => {
                assert_eq!((a.corners(), a.starts()), (b.corners(), b.starts()), "{what}");
                assert!(a.lines().eq(b.lines()), "{what}");
                assert_eq!(
                    (&a.materials, &a.smoothing, &a.groups),
                    (&b.materials, &b.smoothing, &b.groups),
                    "{what}"
                );
                for corner in 0..a.corners().len() {
                    let point = a.corners()[corner];
                    assert_eq!(a.uvs.at(corner, point), b.uvs.at(corner, point), "{what}");
                    assert_eq!(a.tangents.at(corner, point), b.tangents.at(corner, point), "{what}");
                    match (a.normals.at(corner, point), b.normals.at(corner, point)) {
                        (Some(n), Some(m)) => assert!((n - m).amax() < 1e-6, "{what}: {n} {m}"),
                        (n, m) => assert_eq!(n.is_some(), m.is_some(), "{what}"),
                    }
                    match (a.colors.at(corner, point), b.colors.at(corner, point)) {
                        (Some(c), Some(d)) => {
                            assert!((0..4).all(|k| (c[k] - d[k]).abs() < 1e-6), "{what}: {c:?} {d:?}");
                        }
                        (c, d) => assert_eq!(c.is_some(), d.is_some(), "{what}"),
                    }
                }
            }
            (Geometry::Curve(a), Geometry::Curve(b)) => {
                assert_eq!((a.space(), a.weights()), (b.space(), b.weights()), "{what}");
            }
            (Geometry::Surface(a), Geometry::Surface(b)) => {
                assert_eq!((a.u(), a.v(), a.weights()), (b.u(), b.v(), b.weights()), "{what}");
            }
            (Geometry::Trimmed(a), Geometry::Trimmed(b)) => {
                let of = |t: &Trimmed| {
                    let s = t.surface();
                    (s.u().clone(), s.v().clone(), s.weights().map(<[f64]>::to_vec))
                };
                assert_eq!(of(a), of(b), "{what}");
                assert_eq!(
                    (a.regions(), a.curves(), a.points()),
                    (b.regions(), b.curves(), b.points()),
                    "{what}"
                );
            }
            (Geometry::Polyline(a), Geometry::Polyline(b)) => assert_eq!(a.closed, b.closed, "{what}"),
            // Nothing but their points, which are compared above.
            (Geometry::Group, Geometry::Group) | (Geometry::Cloud(_), Geometry::Cloud(_)) => {}
            (a, b) => panic!("{what}: a {} and a {} are not compared", a.kind(), b.kind()),
        }
    }
}

fn text(path: &Path) -> String {
    path.display().to_string()
}
