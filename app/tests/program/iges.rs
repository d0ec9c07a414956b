//! IGES by the program: what is in a file, and on to other formats and back.

use serde_json::Value;

use crate::LOFTSMAN;

fn data(name: &str) -> String {
    loftsman_tests::repository().join("tests/data/iges").join(name).to_string_lossy().into_owned()
}

fn kinds(info: &Value) -> Vec<&str> {
    info["objects"].as_array().unwrap().iter().map(|object| object["type"].as_str().unwrap()).collect()
}

#[test]
fn files_are_told_and_converted_both_ways() {
    let folder = tempfile::tempdir().unwrap();
    let work = folder.path();
    let info = LOFTSMAN.json(work, &["info", &data("as1_pe_203.igs")]);
    assert_eq!(
        (info["format"].as_str(), info["unit"].as_str(), info["up"].as_str()),
        (Some("iges"), Some("mm"), Some("z"))
    );
    let count = |kind: &str| kinds(&info).into_iter().filter(|k| *k == kind).count();
    assert_eq!((count("group"), count("trimmed"), count("curve")), (19, 160, 32));
    assert_eq!(
        (info["report"]["entities"].as_u64(), info["report"]["kept"].as_u64()),
        (Some(2339), Some(2339))
    );
    // Through the native document and back nothing changes.
    for name in ["D150WithGuides_wing.igs", "test_pipe.igs", "as1_pe_203.igs"] {
        LOFTSMAN.done(work, &["convert", &data(name), "a.loft.json"]);
        LOFTSMAN.done(work, &["convert", "a.loft.json", "b.igs"]);
        LOFTSMAN.done(work, &["convert", "b.igs", "b.loft.json"]);
        LOFTSMAN.done(work, &["convert", "b.loft.json", "c.igs"]);
        let (b, c) = (std::fs::read(work.join("b.igs")).unwrap(), std::fs::read(work.join("c.igs")).unwrap());
        assert!(b.len() > 1000 && c.len() > 1000, "{name}");
        LOFTSMAN.done(work, &["convert", "c.igs", "c.loft.json"]);
        let read = |file: &str| std::fs::read_to_string(work.join(file)).unwrap();
        assert!(read("b.loft.json") == read("c.loft.json"), "{name}");
    }
}

#[test]
fn what_is_no_file_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    for (name, says) in [
        ("first_line_82_cols.iges", "line 1: there is no global section"),
        ("first_line_without_80_cols.iges", "its directory section is missing"),
        (
            "up_to_line_7_of_DE_section.iges",
            "line 12: an entity of the directory without its second line: the file was cut off",
        ),
    ] {
        let run = LOFTSMAN.run(folder.path(), &["convert", &data(name), "out.loft.json"]);
        assert_eq!(run.code, Some(1), "{}", run.err);
        assert!(run.err.contains(says) && run.err.trim_end().lines().count() == 1, "{}", run.err);
        assert!(!folder.path().join("out.loft.json").exists());
    }
}
