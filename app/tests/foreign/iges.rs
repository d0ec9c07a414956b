//! IGES files of others, and what STEP files hold, written by Loftsman: OpenCASCADE finds the same in both.

use std::path::{Path, PathBuf};

use loftsman_tests::oracle::{Oracle, at, number, position};
use serde_json::Value;

use crate::LOFTSMAN;

/// Files of three writers whose boundaries close: trimmed surfaces, a shell.
const FILES: [&str; 6] = [
    "D150WithGuides_wing.igs",
    "as1_pe_203.igs",
    "input.igs",
    "test_pipe.igs",
    "test_pipe_hollow.iges",
    "test_pipe_out_true.igs",
];

/// Solids of planes, cylinders, cones, spheres, tori and splines, assemblies, shells.
#[cfg(feature = "step")]
const SOLIDS: [&str; 9] = [
    "MAINBODY_FRONT.stp",
    "NIST_MBE_PMI_11.stp",
    "as1-oc-214.stp",
    "dm1-id-214.stp",
    "io1-cm-214.stp",
    "featuretype.STEP",
    "red_cube_blue_cylinder.step",
    "revolved_sphere.step",
    "sliced_cylinder.step",
];

/// What OpenCASCADE finds in files of a folder, and in what Loftsman makes IGES of.
fn both(folder: &str, names: &[&str]) -> Option<Vec<(Value, Value)>> {
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data").join(folder);
    let (mut before, mut after): (Vec<PathBuf>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    for (k, name) in names.iter().enumerate() {
        let (from, to) = (data.join(name), work.path().join(format!("{k}.igs")));
        LOFTSMAN.done(work.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
        before.push(from);
        after.push(to);
    }
    let (before, after) = (Oracle::OpenCascade.ask(&before, &[])?, Oracle::OpenCascade.ask(&after, &[])?);
    Some(before.into_iter().zip(after).collect())
}

/// That both are the same, lengths to a part of the size.
fn same(name: &str, before: &Value, after: &Value) {
    assert_eq!(at(before, "counts"), at(after, "counts"), "{name}");
    assert_eq!(at(after, "valid"), true, "{name}");
    let size = crate::apart(position(at(before, "low")), position(at(before, "high")));
    for corner in ["low", "high"] {
        let off = crate::apart(position(at(before, corner)), position(at(after, corner)));
        assert!(off < 1e-6 * size, "{name}: the box is {off} off");
    }
    for measure in ["area", "volume"] {
        let (a, b) = (number(before, measure), number(after, measure));
        assert!((a - b).abs() <= 1e-7 * a.abs(), "{name}: {measure} {a}, written again {b}");
    }
}

#[test]
fn opencascade_finds_the_same_faces_in_files_that_were_written_again() {
    for (name, (before, after)) in FILES.iter().zip(both("iges", &FILES).into_iter().flatten()) {
        same(name, &before, &after);
    }
}

#[cfg(feature = "step")]
#[test]
fn opencascade_finds_the_same_solids_in_what_was_step() {
    for (name, (before, after)) in SOLIDS.iter().zip(both("step", &SOLIDS).into_iter().flatten()) {
        same(name, &before, &after);
    }
}

/// A sphere that is a spline and has no edges, alone and as a cavity: with the edges along which it closes OpenCASCADE reads what it is.
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_balls_without_edges() {
    let files = ["spline_sphere.step", "spline_cavity.step"];
    let folder = "../../app/tests/foreign/files";
    for (name, (before, after)) in files.iter().zip(both(folder, &files).into_iter().flatten()) {
        same(name, &before, &after);
    }
}

/// A whole sphere whose seam lies a rounding error to one side of its frame, and a torus: in STEP both uses of a seam are told apart, or OpenCASCADE finds no
/// area (of the sphere, seen).
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_whole_spheres_and_tori_in_step() {
    use std::f64::consts::PI;
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/made");
    let cases = [("ball", 4.0 * PI * 2.196575395_f64.powi(2)), ("torus", 4.0 * PI * PI * 5.0)];
    let mut files = Vec::new();
    for (name, _) in cases {
        let (from, to) =
            (data.join(name).with_extension("igs"), work.path().join(name).with_extension("step"));
        LOFTSMAN.done(work.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
        assert!(std::fs::read_to_string(&to).unwrap().contains("=SEAM_CURVE("), "{name}");
        files.push(to);
    }
    for ((name, exact), found) in cases.iter().zip(Oracle::OpenCascade.ask(&files, &[]).into_iter().flatten())
    {
        assert_eq!(at(&found, "valid"), true, "{name}");
        let area = number(&found, "area");
        assert!((area / exact - 1.0).abs() < 1e-6, "{name}: {area}, {exact}");
    }
}

/// Balls and tori with a hole over their seam, in STEP: which side of it an edge starts from is said. Without OpenCASCADE read the first three with the hole added or as their complement; of the
/// last, where seams cross in the hole, it must not be said, as no seam bounds it. Loftsman finds what it found before.
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_faces_with_a_hole_over_their_seam_in_step() {
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/made");
    let cases = [
        ("bitten_ball", 294.437876814984, 2),
        ("bitten_sphere", 15.35787838268077, 2),
        ("bitten_torus", 2246.8406304668138, 3),
        ("bitten_corner", 1013.5920324285494, 0),
    ];
    let mut files = Vec::new();
    for (name, exact, seams) in cases {
        let (from, to) =
            (data.join(name).with_extension("igs"), work.path().join(name).with_extension("step"));
        let (from, into) = (from.to_string_lossy().into_owned(), to.to_string_lossy().into_owned());
        LOFTSMAN.done(work.path(), &["convert", &from, &into]);
        let text = std::fs::read_to_string(&to).unwrap();
        assert_eq!(text.matches("=SEAM_CURVE(").count(), seams, "{name}");
        for file in [from, into] {
            let told = LOFTSMAN.json(work.path(), &["info", &file]);
            let area = number(&told, "objects/0/area");
            assert!((area / exact - 1.0).abs() < 1e-3, "{file}: {area}, {exact}");
        }
        files.push(to);
    }
    for ((name, exact, _), found) in
        cases.iter().zip(Oracle::OpenCascade.ask(&files, &[]).into_iter().flatten())
    {
        assert_eq!(at(&found, "valid"), true, "{name}");
        let area = number(&found, "area");
        assert!((area / exact - 1.0).abs() < 1e-6, "{name}: {area}, {exact}");
    }
}

/// Bores whose boundaries are torn in space, as OpenCASCADE turned the ellipses there when it wrote them; in the parameters they close, and OpenCASCADE takes them from there. The first was left
/// out, of the second the whole cylinder kept.
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_the_areas_of_bores_whose_ellipses_it_turned() {
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/made");
    let cases = [("turned_bore", 473.97609904427884), ("turned_drill", 10.516251512182624)];
    let mut files = Vec::new();
    for (name, exact) in cases {
        let (from, to) =
            (data.join(name).with_extension("igs"), work.path().join(name).with_extension("step"));
        LOFTSMAN.done(work.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
        for file in [&from, &to] {
            let told = LOFTSMAN.json(work.path(), &["info", &file.to_string_lossy()]);
            let area = number(&told, "objects/0/area");
            assert!((area / exact - 1.0).abs() < 1e-6, "{file:?}: {area}, {exact}");
        }
        files.extend([from, to]);
    }
    let found = Oracle::OpenCascade.ask(&files, &[]).into_iter().flatten();
    for ((file, found), (_, exact)) in files.iter().zip(found).zip(cases.iter().flat_map(|case| [case; 2])) {
        assert_eq!(at(&found, "valid"), true, "{file:?}");
        let area = number(&found, "area");
        assert!((area / exact - 1.0).abs() < 1e-6, "{file:?}: {area}, {exact}");
    }
}

/// Solids whose seams miss the frames of balls and the tips of cones by what ten digits leave, one with an ellipse that OpenCASCADE turned, and one with the flag of a bound that it wrote wrongly:
/// OpenCASCADE finds in what is written of them what it had. It read the first as nothing, the second without its cone.
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_solids_whose_seams_are_off_by_noise() {
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/made");
    let cases = [
        ("bitten_solid.igs", 1050525.506002728),
        ("cone_tip.igs", 32.654601038667366),
        ("turned_ellipse.igs", 7.2824643174456405),
        ("mirrored_torus.step", 239.39128670361498),
    ];
    let mut files = Vec::new();
    for (name, _) in cases {
        for kind in ["igs", "step"] {
            let (from, to) = (data.join(name), work.path().join(name).with_extension(kind));
            LOFTSMAN.done(work.path(), &["convert", &from.to_string_lossy(), &to.to_string_lossy()]);
            files.push(to);
        }
    }
    let found = Oracle::OpenCascade.ask(&files, &[]).into_iter().flatten();
    for ((file, found), (_, exact)) in files.iter().zip(found).zip(cases.iter().flat_map(|case| [case; 2])) {
        assert_eq!(at(&found, "valid"), true, "{file:?}");
        let area = number(&found, "area");
        assert!((area / exact - 1.0).abs() < 2e-5, "{file:?}: {area}, {exact}");
    }
}

/// Instances beside solids in groups that are placed: the reader of plain shapes and the one of assemblies find each solid once, where it is.
#[cfg(feature = "step")]
#[test]
fn opencascade_finds_the_solids_of_assemblies_once() {
    let work = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/step/as1-oc-214.stp");
    let out = work.path().join("as1.igs");
    LOFTSMAN.done(work.path(), &["convert", &data.to_string_lossy(), &out.to_string_lossy()]);
    let again = work.path().join("again.igs");
    LOFTSMAN.done(work.path(), &["convert", &out.to_string_lossy(), &again.to_string_lossy()]);
    for found in Oracle::OpenCascade.ask(&[out, again], &["--assembled"]).into_iter().flatten() {
        assert_eq!((at(&found, "counts/solid"), at(&found, "assembled")), (&18.into(), &18.into()));
    }
}
