//! Bytes that are wrong: an error with its line, or a report; never a panic.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::plugin::{Format, FormatError, Memory, Place, ReadOptions};
use loftsman_obj::Obj;
use proptest::prelude::*;

fn error(text: &str) -> FormatError {
    Obj.read(&Memory::new("t.obj", text), &ReadOptions::default()).unwrap_err()
}

#[test]
fn every_defect_is_named_with_its_line() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (tail, line, says) in [
        ("f 1 2", 4, "2 corner"),
        ("f 1 2 4\n", 4, "vertex 4"),
        ("f 1 2 0", 4, "start at 1"),
        ("f -1 -2 -4", 4, "before the first"),
        ("f 1 2 x", 4, "\"x\""),
        ("f 1/1 2/1 3/1", 4, "texture vertex 1"),
        ("f 1//1 2//1 3//1", 4, "normal 1"),
        ("f 1/1/1/1 2 3", 4, ""),
        ("f 99999999999999999999 1 2", 4, "not the number"),
        ("v 1 2 nan", 4, "NaN"),
        ("v 1 2 1e999", 4, "inf"),
        ("v 1 2 3 1 4e200 0", 4, "4e200"),
        ("v 1 2", 4, "2 numbers"),
        ("v 1 2 3.1+e2", 4, "3.1+e2"),
        ("l 1", 4, "at least 2"),
        ("p", 4, "no vertex"),
        ("deg 1000000000", 4, "1000000000"),
        ("deg 0", 4, "1 to 25"),
        ("cstype nurbs", 4, "unknown type"),
        ("parm u 0 1", 4, "without"),
        ("end", 4, "without"),
        ("cstype bspline\ndeg 1\ncurv 0 1 1 2\nparm u 0 0 1\nend", 7, "needs 4"),
        ("cstype bspline\ndeg 1\ncurv 0 1 1 2\nend", 6, "no parm"),
        ("cstype bspline\ndeg 1\ncurv 0 1\nparm u 0 0\nend", 7, ""),
        ("cstype bspline\ndeg 1\ncurv 0 1 1 9\n", 6, "vertex 9"),
        ("cstype bspline\ndeg 1\ncurv 1 7 1 2\nparm u 0 0 1 1\nend", 6, "from 1 to 7"),
        ("cstype bspline\ndeg 1\ncurv 1 0 1 2\nparm u 0 0 1 1\nend", 6, "backwards, from 1 to 0"),
        ("cstype bezier\ndeg 2\ncurv 0 1 1 2\nparm u 0 1\nend", 7, "pieces"),
        ("cstype bezier\ndeg 2\ncurv 0 1 1 2 3\nparm u 1 0\nend", 7, "increase"),
        ("cstype rat bspline\ndeg 1\nv 1 1 1 -2\ncurv 0 1 1 4\nparm u 0 0 1 1\nend", 7, "weight"),
        ("cstype cardinal\ndeg 2\ncurv 0 1 1 2 3\nend", 6, "degree 3"),
        ("cstype bmatrix\ndeg 1\nbmat u 1 2 3\nstep 1\ncurv 0 1 1 2\nend", 8, "needs 4"),
        ("cstype bmatrix\ndeg 1\ncurv 0 1 1 2\nend", 6, "step"),
        ("bmat w 1", 4, "only u and v"),
        ("step 0", 4, "leads nowhere"),
        ("cstype bspline\ndeg 1 1\nsurf 0 1 0 1 1 2 3\nparm u 0 0 1 1\nparm v 0 0 1 1\nend", 6, "2 × 2"),
        ("cstype bspline\ndeg 1 1\nsurf 0 1 0 1 1 2 3 3\nparm u 0 0 1 1\nparm v 0 0 1\nend", 8, "at least 2"),
        ("cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 3 3 3\nend", 6, "parm u and parm v"),
        ("surf 0 1 0", 4, "missing"),
        ("trim 0 1 1", 4, "without"),
        ("cstype bezier\ndeg 1\nsurf 0 1 0 1 1 2 3 3\ntrim 0 1 1", 7, "so far"),
        ("cstype bezier\ndeg 1\ncurv 0 1 1 2\ntrim 0 1 1", 7, "only surfaces"),
        ("con 1 2 3", 4, "8 are right"),
        ("con 1 0 1 1 1 0 1 1", 4, "surface 1"),
        ("s x", 4, "smoothing"),
        ("vp", 4, "without numbers"),
        ("vp a", 4, "not a number"),
        ("deg 1\ncurv 0 1 1 2\nparm u 0 0 1 1\nend", 5, "cstype"),
        ("\u{1}\u{2}", 4, "no statement"),
    ] {
        let error = error(&format!("{triangle}{tail}"));
        assert_eq!(error.place, Place::Line(line), "{tail}: {error}");
        assert!(error.to_string().contains(says), "{tail}: {error}");
    }
    assert!(error(&format!("{triangle}cstype bezier\ndeg 2\ncurv 0 1 1 2 3")).to_string().contains("line 6"));
    for nothing in ["", "x", "# only a comment\n", "hello world\n", "\0"] {
        assert!(Obj.read(&Memory::new("t.obj", nothing), &ReadOptions::default()).is_err(), "{nothing:?}");
    }
}

/// Of statements all of which are wrong the first is the error, with its line.
#[test]
fn where_all_is_wrong_the_first_line_is_told() {
    for (text, line, says) in [
        ("v 1 2\n", 1, "2 numbers"),
        ("# a comment\n\nf 1 2 3\n", 3, "vertex 1"),
        ("l 1 2\n", 1, "vertex 1"),
        ("f 1 2 3\nf 1 2 4\n", 1, "vertex 1"),
        ("vn a b c\nvt x\n", 1, "not a number"),
    ] {
        let error = error(text);
        assert_eq!(error.place, Place::Line(line), "{text}: {error}");
        assert!(error.to_string().contains(says), "{text}: {error}");
    }
}

const WHOLE: &str = "mtllib a.mtl\no one\nv 0 0 0 1\nv 1 0 0 .5\nv 0 1 0\nv 0 1 1 1 0 0\nvt 0 1\nvn 0 0 1\ns 1\nusemtl m\nf 1/1/1 2/1/1 \\\n3/1/1\nf -1 -2 -3\nl 1 2 3\nl 3 1\np 1 2\ncstype rat bspline\ndeg 1\ncurv 0 2 1 2 3\nparm u 0 0 1 2 2\nend\nbmat u 1 0 -1 1\nstep 1\ng a b\nvp 0 0\nvp 1 0\nvp 0 1\ncstype bezier\ndeg 1 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\ntrim 0 3 1\nhole 0 3 1\nscrv 0 1 1\nsp 1\nend\ncon 1 0 1 1 1 1 2 -1\n#MRGB ff00ff00\nvp 1 2\n";

#[test]
fn every_truncation_is_read_or_refused_and_adds_up() {
    // From the first face on there is something whatever follows.
    let face = WHOLE.find("3/1/1\nf").unwrap();
    for end in 0..=WHOLE.len() {
        match Obj.read(&Memory::new("t.obj", &WHOLE[..end]), &ReadOptions::default()) {
            Ok((scene, report)) => {
                assert!(report.adds_up() && scene.check().is_ok(), "{end}");
                assert!(end < face + 5 || !scene.objects().is_empty(), "{end}");
            }
            Err(error) => assert!(end < face + 5, "{end}: {error}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn any_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        _ = Obj.read(&Memory::new("t.obj", bytes.clone()), &ReadOptions::default());
        _ = Obj.confidence(&bytes);
    }

    #[test]
    fn any_statements_do_not_panic(words in prop::collection::vec(
        prop::sample::select(vec![
            "v", "vt", "vn", "f", "l", "p", "o", "g", "curv", "parm", "u", "end", "deg", "cstype", "bspline", "bezier",
            "rat", "vp", "surf", "curv2", "trim", "hole", "scrv", "sp", "con", "bmat", "step", "bmatrix", "taylor", "cardinal", "s", "usemtl", "\n", "\n", "\n", "\n", "0", "1", "2", "3", "-1", "1/1", "1//1", "-2", "0.5", "1e30", "9", "\\\n", "a",
        ]), 0..200)) {
        let text = words.join(" ");
        if let Ok((scene, report)) = Obj.read(&Memory::new("t.obj", text.as_str()), &ReadOptions::default()) {
            prop_assert!(report.adds_up());
            prop_assert!(scene.check().is_ok());
        }
    }

    #[test]
    fn one_wrong_byte_does_not_panic(at in 0..WHOLE.len(), byte in any::<u8>()) {
        let mut bytes = WHOLE.as_bytes().to_vec();
        bytes[at] = byte;
        _ = Obj.read(&Memory::new("t.obj", bytes), &ReadOptions::default());
    }
}
