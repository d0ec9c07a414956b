//! STEP files of others, written again by Loftsman: OpenCASCADE finds the same in both.

use std::path::{Path, PathBuf};

use loftsman_tests::oracle::{Oracle, at, list, number, position};
use serde_json::json;

use crate::LOFTSMAN;

/// Files of nine writers: solids, shells, assemblies, in millimetres, inches, centimetres and metres.
const FILES: [&str; 12] = [
    "MAINBODY_FRONT.stp",
    "NIST_MBE_PMI_11.stp",
    "as1-oc-214.stp",
    "base_interface_AP203.STEP",
    "dm1-id-214.stp",
    "face.stp",
    "featuretype.STEP",
    "io1-cm-214.stp",
    "nacelle.stp",
    "red_cube_blue_cylinder.step",
    "revolved_sphere.step",
    "sliced_cylinder.step",
];

/// Files that OpenCASCADE made of what is extruded and turned (`tests/data/made`).
const MADE: [&str; 8] = [
    "../made/elprism.step",
    "../made/elrev.step",
    "../made/elslant.step",
    "../made/hyper.step",
    "../made/parab.step",
    "../made/splext.step",
    "../made/splrev.step",
    "../made/splrevpart.step",
];

#[test]
fn opencascade_finds_the_same_solids_in_files_that_were_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/step");
    let (mut before, mut after): (Vec<PathBuf>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    for (k, name) in FILES.iter().chain(&MADE).enumerate() {
        let (from, to) = (data.join(name), folder.path().join(format!("{k}.step")));
        LOFTSMAN.done(folder.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
        before.push(from);
        after.push(to);
    }
    let Some(before) = Oracle::OpenCascade.ask(&before, &[]) else { return };
    let Some(after) = Oracle::OpenCascade.ask(&after, &[]) else { return };
    for ((name, before), after) in FILES.iter().chain(&MADE).zip(&before).zip(&after) {
        assert_eq!(at(before, "counts"), at(after, "counts"), "{name}");
        assert_eq!(at(after, "valid"), true, "{name}");
        let size = crate::apart(position(at(before, "low")), position(at(before, "high")));
        for corner in ["low", "high"] {
            let off = crate::apart(position(at(before, corner)), position(at(after, corner)));
            assert!(off < 1e-6 * size, "{name}: the box is {off} off");
        }
        for measure in ["area", "volume"] {
            let (a, b) = (number(before, measure), number(after, measure));
            assert!((a - b).abs() <= 1e-8 * a.abs(), "{name}: {measure} {a}, written again {b}");
        }
    }
}

/// Solids as meshes: what Blender opens of OBJ and glTF is closed, right side out, and as full as OpenCASCADE says the solids are.
#[test]
fn blender_sees_closed_solids_of_the_right_volume() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/step");
    let names: Vec<&str> =
        FILES.into_iter().filter(|name| !["face.stp", "nacelle.stp"].contains(name)).collect();
    let [mut sources, mut objs, mut glbs] = [const { Vec::<PathBuf>::new() }; 3];
    for (k, name) in names.iter().enumerate() {
        let from = data.join(name);
        for (extension, list) in [("obj", &mut objs), ("glb", &mut glbs)] {
            let to = folder.path().join(format!("{k}.{extension}"));
            LOFTSMAN.done(folder.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
            list.push(to);
        }
        sources.push(from);
    }
    let Some(objs) = Oracle::Blender.ask(&objs, &[]) else { return };
    let Some(glbs) = Oracle::Blender.ask(&glbs, &[]) else { return };
    let exact = Oracle::OpenCascade.ask(&sources, &[]);
    let mut solids = 0;
    for (k, name) in names.iter().enumerate() {
        let meshes: Vec<_> = list(&objs[k], "objects").iter().filter(|o| o["type"] == "MESH").collect();
        assert!(!meshes.is_empty(), "{name}");
        for mesh in &meshes {
            assert_eq!(mesh["watertight"], true, "{name} {}", mesh["name"]);
            assert!(number(mesh, "volume_signed") > 0.0, "{name} {}: inside out", mesh["name"]);
            assert_eq!(number(mesh, "degenerate_faces"), 0.0, "{name} {}", mesh["name"]);
        }
        solids += meshes.len();
        // glTF is in metres; its vertices are doubled where faces meet, so that only the volume tells that nothing is missing.
        let volume: f64 = list(&glbs[k], "objects")
            .iter()
            .filter(|o| o["type"] == "MESH")
            .map(|o| number(o, "volume_signed"))
            .sum();
        if let Some(exact) = &exact {
            let expected = number(&exact[k], "volume") * 1e-9;
            assert!((volume / expected - 1.0).abs() < 5e-3, "{name}: {volume} {expected}");
        }
    }
    assert!(solids >= 30, "{solids}");
}

/// MeshLab's word on every solid of every file that lies here: two-manifold without any border, in OBJ as it is and in glTF (whose vertices are doubled where
/// faces meet) once what is at one place is one; and as large as OpenCASCADE says.
#[test]
fn meshlab_finds_every_solid_watertight() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/step");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&data).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files.retain(|file| {
        ["stp", "step"].iter().any(|e| file.extension().is_some_and(|own| own.eq_ignore_ascii_case(e)))
    });
    let (mut solids, mut sources, [mut objs, mut glbs]) =
        (0, Vec::new(), [const { Vec::<PathBuf>::new() }; 2]);
    let mut units: Vec<f64> = Vec::new();
    for (k, file) in files.iter().enumerate() {
        let from = file.to_string_lossy();
        let found = LOFTSMAN.json(folder.path(), &["info", &from]);
        let totals = &found["totals"];
        // Shells have borders.
        if totals["solids"] != totals["breps"] {
            continue;
        }
        solids += totals["solids"].as_u64().unwrap();
        for (extension, list) in [("obj", &mut objs), ("glb", &mut glbs)] {
            let to = folder.path().join(format!("{k}.{extension}"));
            LOFTSMAN.done(folder.path(), &["convert", &from, &to.to_string_lossy()]);
            list.push(to);
        }
        sources.push(file.clone());
        // OBJ has the numbers of the file, OpenCASCADE millimetres.
        units.push(match found["unit"].as_str() {
            Some("mm") => 1.0,
            Some("cm") => 10.0,
            Some("m") => 1000.0,
            Some("in") => 25.4,
            other => panic!("{from}: {other:?}"),
        });
    }
    assert!(sources.len() >= 14 && solids >= 38, "{} files, {solids} solids", sources.len());
    let Some(objs) = Oracle::MeshLab.ask(&objs, &[]) else { return };
    let Some(glbs) = Oracle::MeshLab.ask(&glbs, &["--weld"]) else { return };
    let exact = Oracle::OpenCascade.ask(&sources, &[]);
    for (k, source) in sources.iter().enumerate() {
        let name = source.display();
        let meshes = list(&objs[k], "meshes");
        assert!(!meshes.is_empty(), "{name}");
        for mesh in meshes {
            assert_eq!(mesh["watertight"], true, "{name}, OBJ: {mesh:#}");
        }
        for mesh in list(&glbs[k], "meshes") {
            assert_eq!(mesh["welded"]["watertight"], true, "{name}, GLB: {mesh:#}");
        }
        let Some(exact) = &exact else { continue };
        for (measure, power) in [("area", 2), ("volume", 3)] {
            let found: f64 =
                meshes.iter().map(|mesh| number(mesh, measure)).sum::<f64>() * units[k].powi(power);
            let expected = number(&exact[k], measure);
            assert!((found / expected - 1.0).abs() < 0.02, "{name}: {measure} {found}, exactly {expected}");
        }
    }
}

/// Edits of faces with their neighbours that keep the solid's volume: OpenCASCADE finds it kept in the STEP that was written, and the solid whole.
#[test]
fn opencascade_finds_the_volume_kept_and_the_solid_whole() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/step");
    let (mut before, mut after) = (Vec::new(), Vec::new());
    // The faces of the second one are 1e-4 of an inch apart along edges of a foot, around a volume 30 times that of its wall.
    let cases = [
        ("NIST_MBE_PMI_11.stp", "Document", "neighbours = 1", [22.0, 0.0, 9.0], [0.1, 0.2, 0.6], 1e-8),
        (
            "MAINBODY_FRONT.stp",
            "MAINBODY_FRONT",
            "faces = [5, 6, 7, 8]",
            [5.9, -1.0, 2.6],
            [0.3, -0.1, 0.4],
            3e-5,
        ),
    ];
    for (k, (file, object, moving, at, by, _)) in cases.iter().enumerate() {
        let from = data.join(file);
        let recipe = format!(
            "input = {from:?}\noutput = \"{k}.step\"\n[[step]]\nop = \"edit\"\nobject = {object:?}\n{moving}\n\
             constraints = [{{ kind = \"volume\", keep = true }}, \
             {{ kind = \"position\", at = {{ closest = {at:?} }}, by = {by:?} }}]\n"
        );
        std::fs::write(folder.path().join(format!("{k}.toml")), recipe).unwrap();
        LOFTSMAN.done(folder.path(), &["run", &format!("{k}.toml")]);
        before.push(from);
        after.push(folder.path().join(format!("{k}.step")));
    }
    let Some(before) = Oracle::OpenCascade.ask(&before, &[]) else { return };
    let Some(after) = Oracle::OpenCascade.ask(&after, &[]) else { return };
    for (((file, .., within), before), after) in cases.iter().zip(&before).zip(&after) {
        assert_eq!(at(before, "counts"), at(after, "counts"), "{file}");
        assert_eq!(at(after, "valid"), true, "{file}");
        let change = number(after, "volume") / number(before, "volume") - 1.0;
        assert!(change.abs() < *within, "{file}: {change:e}");
        assert!((number(after, "area") / number(before, "area") - 1.0).abs() > 1e-4, "{file}");
    }
}

/// Trimmed surfaces go out by their loops in parameters: OpenCASCADE makes faces of them, of the area that we find.
#[test]
fn opencascade_reads_trimmed_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/obj");
    let (mut files, mut areas) = (Vec::new(), Vec::new());
    // Its quadrature stops early inside the second one's loop, whose weights are 0.5 to 10.7: asked for 1e-9 it is 1.4e-4 off, for 1e-12 6e-6.
    let cases = [("spec_two_regions_with_holes.obj", 1e-6), ("spec_trimmed_nurb_surface_fixed.obj", 2e-4)];
    for (name, _) in cases {
        let (from, to) = (data.join(name), folder.path().join(name).with_extension("step"));
        let (from, into) = (from.to_string_lossy(), to.to_string_lossy());
        LOFTSMAN.done(folder.path(), &["convert", &from, &into, "--unit", "mm"]);
        let found = LOFTSMAN.json(folder.path(), &["info", &to.to_string_lossy()]);
        let trimmed: Vec<f64> = list(&found, "objects")
            .iter()
            .filter(|o| o["type"] == "trimmed")
            .map(|o| number(o, "area"))
            .collect();
        assert!(!trimmed.is_empty(), "{name}: {found}");
        areas.push((trimmed.len(), trimmed.iter().sum::<f64>()));
        files.push(to);
    }
    let Some(found) = Oracle::OpenCascade.ask(&files, &[]) else { return };
    for (((file, found), (count, area)), (_, within)) in files.iter().zip(&found).zip(areas).zip(cases) {
        assert_eq!(number(at(found, "counts"), "face"), count as f64, "{}", file.display());
        let told = number(found, "area");
        assert!((told / area - 1.0).abs() < within, "{}: {told} {area}", file.display());
    }
}

/// A ball whose net is pulled out of shape with weights from 0.04 to 4: what OpenCASCADE integrates over rational faces is off by 4e-3 here, whatever it is asked
/// for; its own triangles are not, nor is what we say. The exact numbers are those of NumPy, by 40 nodes of Gauss in each direction of each piece.
#[test]
fn rational_solids_are_as_large_as_they_are() {
    const VOLUME: f64 = 1375.0868889013;
    const AREA: f64 = 775.9154510806;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let around: [[f64; 2]; 9] = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
        [1.0, 0.0],
    ];
    let (wide, heavy) = ([0.0, 1.3, 0.7, 1.6, 0.0], [1.0, 3.0, 0.35, 2.2, 1.0]);
    let heights = [-5.0, -5.0, 0.0, 5.0, 5.0];
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (i, [x, y]) in around.iter().enumerate() {
        let turn = 1.0 + 0.9 * (1.0 + 1.7 * (i % 8) as f64).sin();
        let row = |j: usize| json!([7.0 * x * wide[j], 5.0 * y * wide[j], 1.2 * heights[j]]);
        let weight = |j: usize| {
            let own = if i % 2 == 1 { half } else { 1.0 } * if j % 2 == 1 { half } else { 1.0 };
            own * heavy[j] * if (1..4).contains(&j) { turn } else { 1.0 }
        };
        points.push((0..5).map(row).collect::<Vec<_>>());
        weights.push((0..5).map(weight).collect::<Vec<f64>>());
    }
    let u: Vec<i32> = vec![0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4];
    let direction = |knots: &[i32]| json!({ "degree": 2, "periodic": false, "knots": knots });
    let surface = json!({ "u": direction(&u), "v": direction(&[0, 0, 0, 1, 1, 2, 2, 2]), "points": points, "weights": weights });
    let brep = json!({
        "vertices": [{ "at": [0.0, 0.0, -6.0], "tolerance": 1e-7 }],
        "edges": [],
        "faces": [{ "surface": surface, "loops": [], "points": [0] }],
        "shells": [[0]],
        "solids": [{ "outer": 0 }],
    });
    let folder = tempfile::tempdir().unwrap();
    let document = loftsman_tests::curves::document("mm", &[json!({ "name": "lump", "brep": brep })]);
    crate::save(folder.path(), "lump.loft.json", &document);
    let found = LOFTSMAN.json(folder.path(), &["info", "lump.loft.json"]);
    for (measure, exact) in [("volume", VOLUME), ("area", AREA)] {
        let ours = number(&found["objects"][0], measure);
        assert!((ours / exact - 1.0).abs() < 1e-3, "{measure}: {ours}, exactly {exact}");
    }
    LOFTSMAN.done(folder.path(), &["convert", "lump.loft.json", "lump.step"]);
    let Some(seen) = Oracle::OpenCascade.ask(&[folder.path().join("lump.step")], &["--meshed"]) else {
        return;
    };
    assert_eq!(at(&seen[0], "valid"), true);
    let meshed = number(&seen[0], "meshed");
    assert!((meshed / VOLUME - 1.0).abs() < 1e-3, "{meshed}, exactly {VOLUME}");
}
