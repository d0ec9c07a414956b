//! Whatever the bytes: a scene or one error that says where and what, never a panic.

use loftsman_kernel::plugin::{Confidence, Format};
use loftsman_points::Points;
use proptest::prelude::*;

use super::common::{coordinates, read, says};

fn refused(bytes: impl Into<Vec<u8>>) -> String {
    read("a.csv", bytes).unwrap_err().to_string()
}

#[test]
fn errors_name_the_line_and_what_to_do() {
    for (text, parts) in [
        ("1 2\n3 nan\n", &["line 2", "\"nan\"", "not finite"][..]),
        ("1 2\n-inf 3\n", &["line 2", "\"-inf\"", "not finite"]),
        ("inf 2\n", &["line 1", "\"inf\"", "not finite"]),
        ("1 2\n1e999 3\n", &["line 2", "1e999", "too large"]),
        ("1 2\n3\n", &["line 2", "one number", "two or three"]),
        ("1\n", &["line 1", "no row of at least two numbers"]),
        ("1\n2\n", &["line 2", "one number"]),
        ("1 2\n1 2 3\n", &["line 2", "3 columns", "the rows before have 2"]),
        ("1,2,3\n1,,3\n", &["line 2", "a column is empty"]),
        ("1 2\nend\n3 4\n", &["line 2", "\"end\" is not a number", "before and below the rows"]),
        ("1 2\n3 4\nend\n5 6\nend\n", &["line 3", "\"end\" is not a number"]),
        ("1 2\n3 x\n5 6\n", &["line 2", "\"x\" is not a number"]),
        ("a\n17. 17.\n\n0 0\n1 0\n0.5 0\n0 0\n1 0\n", &["line 2", "17 and 17", "5 follow"]),
        ("1;2\n1,5;2.5\n", &["line 2", "mixes decimal commas and decimal points"]),
        ("x y\n", &["line 1", "\"x y\" and no row"]),
        ("3\n1 2\n3 4\n", &["line 1", "counts 3 rows, but there are 2"]),
        ("5 NumCoords ! five\n0.25 0\n1 0\n0 1\n", &["line 1", "counts 5 rows, but there are 3"]),
        ("ZONE F=BLOCK, T=\"a\"\n1 2\n", &["line 1", "F=POINT"]),
        ("1 2\n1 a\x1b[31m\n", &["line 2", "\\u{1b}"]),
    ] {
        says(&refused(text), parts);
    }
}

#[test]
fn bytes_that_are_no_rows() {
    for (bytes, part) in [
        (&b""[..], "empty"),
        (b"\r\n \t", "empty"),
        (b"\xEF\xBB\xBF", "empty"),
        (b"\x00", "zero byte"),
        (b"x", "no row"),
        (b"#", "no row"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "zero byte"),
        (b"\x01\x02\x03", "control characters"),
        (b"\xFF\xFE1\x00 \x002\x00", "UTF-16"),
        (b"1\x00 \x002\x00\n\x00", "UTF-16"),
        (b"<?xml version=\"1.0\"?>\n<a>\n</a>\n", "no row"),
    ] {
        says(&refused(bytes), &[part]);
        assert_eq!(Points.confidence(bytes), Confidence::No);
    }
    says(&refused("word\n".repeat(100)), &["line 33", "does not look like a point file"]);
    let long = "x".repeat(1_000_000);
    says(&refused(long.clone()), &["no row"]);
    says(&refused(format!("1 2\n3 {long}\n")), &["line 2", "is not a number"]);
    says(&refused(format!("1 2\n{}\n", "7 ".repeat(1_000_000))), &["line 2", "1000000 columns"]);
    says(&refused(format!("1 2\n3 {}\n", "7".repeat(100_000))), &["line 2", "is not a number"]);
}

#[test]
fn other_formats_are_not_claimed() {
    for text in [
        "{ \"loftsman\": 1, \"objects\": [] }",
        "[[1, 2], [3, 4]]",
        "# a cube\no cube\nv 1 2 3\nv 4 5 6\nf 1 2 3\n",
        "v 1 2 3\nv 4 5 6\n",
        "mtllib a.mtl\no a\nv 1 2 3\nv 1 2 3\n",
        "glTF\x02\x00\x00\x00",
        "ply\nformat ascii 1.0\nelement vertex 2\nend_header\n1 2 3\n4 5 6\n",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n",
        "ISO-10303-21;\nHEADER;\n",
        "  0\nSECTION\n  2\nHEADER\n",
        "<svg viewBox=\"0 0 1 1\">\n1 2\n3 4\n",
        "input = \"a\"\noutput = [\"b\"]\n",
        "1 2\n",
    ] {
        assert_eq!(Points.confidence(text.as_bytes()), Confidence::No, "{text}");
    }
}

#[test]
fn two_hundred_thousand_rows_come_through() {
    let text: String = (0..200_000).map(|i| format!("{i}.5,{},-0.25\n", i * 2)).collect();
    let (scene, report) = read("a.csv", text).unwrap();
    assert_eq!(coordinates(&scene)[199_999], [199_999.5, 399_998.0, -0.25]);
    assert_eq!(report.kept, 200_000);
}

fn valid() -> impl Strategy<Value = &'static str> {
    prop_oneof![
        Just("RAE\n1 0\n0.5 0.1\n0 0\n0.5 -0.1\n1 0\n"),
        Just("201 NumCoords ! n\n! ref\n0.25 0\n1 0\n0 1\n"),
        Just("a\n2. 2.\n\n0 0\n1 0.1\n\n0 0\n1 -0.1\n"),
        Just("x;y;label\n1,5;2,5;a\n2,5;3,5;b\n"),
        Just("TITLE=\"a\"\nZONE T=\"b\"\n1 2\n3 4\nZONE\n1 2\n"),
        Just(
            "x,y,z\n# loftsman points, unit mm, z up\n# closed polyline \"a\"\n1,2,3\n1,2,3\n# cloud \"b\"\n"
        ),
    ]
}

fn fine(bytes: &[u8]) -> Result<(), TestCaseError> {
    let confidence = Points.confidence(bytes);
    for name in ["a.xyz", "a.csv", "-"] {
        match read(name, bytes) {
            Ok((scene, report)) => {
                prop_assert!(report.adds_up(), "{report:?}");
                let points: usize = scene.objects().iter().map(|o| o.geometry().points().len()).sum();
                prop_assert_eq!(report.kept, points);
                let mut points = scene.objects().iter().flat_map(|o| o.geometry().points());
                let finite = points.all(|p| p.iter().all(|c| c.is_finite()));
                prop_assert!(finite);
            }
            Err(error) => prop_assert!(!error.problem.is_empty() && (error.file == name)),
        }
    }
    let _ = confidence;
    Ok(())
}

proptest! {
    #[test]
    fn arbitrary_bytes_give_a_scene_or_one_error(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        fine(&bytes)?;
    }

    #[test]
    fn arbitrary_rows_give_a_scene_or_one_error(text in "[0-9 .,;\\-+eEdD\n\t#!\"=a-z]{0,80}") {
        fine(text.as_bytes())?;
    }

    #[test]
    fn a_truncated_or_changed_file_gives_a_scene_or_one_error(text in valid(), cut: prop::sample::Index, byte: u8) {
        let at = cut.index(text.len());
        fine(&text.as_bytes()[..at])?;
        let mut bytes = text.as_bytes().to_vec();
        bytes[at] = byte;
        fine(&bytes)?;
    }
}
