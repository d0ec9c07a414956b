//! Files of which nothing is left: where that is decided, and why; and files that were cut off.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use crate::common::read;
use loftsman_kernel::plugin::Place;

fn data(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../tests/data/step/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// A tetrahedron with the first of these texts in place of the other.
fn changed(from: &str, to: &str) -> String {
    let text = data("tet.step");
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn a_file_of_which_nothing_is_left_says_where_and_why() {
    const SOLID: &str = "#11=MANIFOLD_SOLID_BREP('brep_1',#13)";
    const SHELL: &str = "#13=CLOSED_SHELL('',(#14,#15,#16,#17))";
    const ITEMS: &str = "#12=ADVANCED_BREP_SHAPE_REPRESENTATION('brep_rep_0',(#11,#150)";
    let list = |items: &str| ITEMS.replace("(#11,#150)", items);
    let representation = "#12 (ADVANCED_BREP_SHAPE_REPRESENTATION), line 27";
    let solid = "#11 (MANIFOLD_SOLID_BREP), line 26";
    for (from, to, says) in [
        // Another type, or one that is not read.
        (
            SOLID,
            SOLID.replace("MANIFOLD_SOLID_BREP", "EDGE_LOOP"),
            format!("{representation}: it lists #11 (EDGE_LOOP), line 26"),
        ),
        (
            SOLID,
            SOLID.replace("MANIFOLD_SOLID_BREP", "CSG_SOLID"),
            format!("{representation}: it lists #11 (CSG_SOLID), line 26"),
        ),
        (ITEMS, list("(#12,#150)"), format!("{representation}: it lists itself")),
        (ITEMS, list("(#150)"), format!("{representation}: it lists nothing but placements")),
        (ITEMS, list("()"), format!("{representation}: it lists nothing")),
        (ITEMS, list("#11"), format!("{representation}: attribute 2 is #11 where a list is needed")),
        // Not there; the cause and not what follows from it.
        (
            SOLID,
            "#911=MANIFOLD_SOLID_BREP('brep_1',#13)".to_owned(),
            format!("{representation}: #11 is named, but is not in the file"),
        ),
        (SHELL, SHELL.replace("#13", "#913"), format!("{solid}: #13 is named, but is not in the file")),
        (
            SHELL,
            SHELL.replace("(#14,#15,#16,#17)", "()"),
            format!("{solid}: nothing of it is left: it lists no face"),
        ),
        (SOLID, SOLID.replace("#13", "#11"), format!("{solid}: a shell is needed where it is named")),
        (
            SHELL,
            SHELL.replace("CLOSED_SHELL", "EDGE_LOOP"),
            "#13 (EDGE_LOOP), line 28: a shell is needed where it is named".to_owned(),
        ),
    ] {
        let error = read(&changed(from, &to)).unwrap_err().to_string();
        assert!(error.contains(&says), "{to}:\n{error}");
    }
}

#[test]
fn a_file_without_a_representation_says_what_stands_in_it() {
    let bare = |data: &str| {
        format!("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AP242'));\nENDSEC;\n{data}END-ISO-10303-21;\n")
    };
    for (data, says) in [
        ("", "not one entity stands in its 5 lines"),
        ("DATA;\nENDSEC;\n", "not one entity stands in its 7 lines"),
        (
            "DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\n",
            "none of its entities (1, the first is #1 (CARTESIAN_POINT), line 6) is a representation",
        ),
    ] {
        let error = read(&bare(data)).unwrap_err().to_string();
        assert!(error.contains("there is no geometry in it that is read") && error.contains(says), "{error}");
    }
}

#[test]
fn a_file_that_was_cut_off_says_up_to_where_it_is_whole() {
    let text = data("tet.step");
    let start = text.find("#54=").unwrap();
    let end = start + text[start..].find(';').unwrap() + 1;
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    let last = format!("the last whole entity is #54, line {}", line(end));
    for (cut, place) in [
        (end, end),
        (end + 1, end + 1),
        // Within the next one: behind its number, in the middle.
        (end + 5, end + 1),
        (end + 15, end + 1),
    ] {
        let error = read(&text[..cut]).unwrap_err();
        assert!(matches!(error.place, Place::Line(found) if found == line(place)), "{cut}: {error}");
        assert!(error.problem.contains("cut off") && error.problem.contains(&last), "{cut}: {error}");
    }
    // Anywhere within the next one.
    for cut in end + 1..end + text[end..].find(';').unwrap() {
        let error = read(&text[..cut]).unwrap_err();
        assert!(error.problem.contains("cut off") && error.problem.contains(&last), "{cut}: {error}");
    }
    // Within a text.
    let at = text.find("'brep_rep_0").unwrap() + 4;
    let error = read(&text[..at]).unwrap_err();
    assert!(error.problem.contains("within a text in #12: it was cut off"), "{error}");
    assert!(error.problem.contains("the last whole entity is #11, line 26"), "{error}");
}
