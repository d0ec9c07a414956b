//! The many ways in which rows of coordinates are written.

use loftsman_kernel::plugin::{Confidence, Format, Memory, ReadOptions};
use loftsman_kernel::scene::{Geometry, Unit};
use loftsman_points::Points;

use super::common::{coordinates, polyline, read, read_as};

#[test]
fn one_row_in_every_spelling() {
    for (text, note) in [
        ("0 0 0\n1.5 -2 0.001\n", "blanks"),
        ("\u{feff}0 0 0\r\n1.5 -2 0.001\r\n", "blanks"),
        ("0\t0\t0\r1.5\t-2\t1.0D-3\r", "blanks"),
        ("0,0,0\n1.5, -2 ,0.001", "commas"),
        ("0;0;0\n1,5;-2;0,001", "commas are decimal signs"),
        ("0,0 0,0 0,0\n1,5 -2,0 0,001\n", "commas are decimal signs"),
        ("0 0 0 # start\n! all of it\n\n% more\n// more\n  1.5 -2 1e-3 ! end", "blanks"),
        ("x,y,z\n0,0,0\n\"1.5\",\"-2\",\"0.001\"\n", "commas"),
        ("X [m];Y [m];Z [m]\n0;0;0\n1.5;-2;.001;\n", "semicolons"),
        ("2\n0 0 0\n1.5 -2 0.001\n", "line 1 counts the rows"),
        ("# x y z\n0 0 0\n1.5 -2 0.001\n\x1a", "blanks"),
    ] {
        let (scene, report) = read("a.csv", text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!(coordinates(&scene), [[0.0; 3], [1.5, -2.0, 0.001]], "{text:?}");
        assert!(report.notes.iter().any(|n| n.contains(note)), "{text:?}: {:?}", report.notes);
        assert!(report.adds_up() && report.entities == 2);
        assert_eq!(scene.objects()[0].name(), "a");
        assert!(Points.confidence(text.as_bytes()) > Confidence::No, "{text:?}");
    }
}

#[test]
fn columns_by_name_and_columns_left_out() {
    let (scene, report) = read("a.csv", "id,t,z,y,x\nfirst,0.1,3,2,1\nsecond,0.2,6,5,4\n").unwrap();
    assert_eq!(coordinates(&scene), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(
        report.left_out.keys().collect::<Vec<_>>(),
        ["column \"id\" is not a coordinate", "column \"t\" is not a coordinate"]
    );
    assert!(report.adds_up() && report.entities == 4);
    let (scene, report) = read("a.csv", "1 2 3 255 0 0\n4 5 6 0 255 0\n").unwrap();
    assert_eq!(coordinates(&scene), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(report.left_out.values().sum::<usize>(), 3);
    let (scene, report) = read("a.csv", "width,height\n1,2\n3,4\n").unwrap();
    assert_eq!(coordinates(&scene), [[1.0, 2.0, 0.0], [3.0, 4.0, 0.0]]);
    assert!(report.notes.iter().any(|n| n.contains("no x and y: width, height")), "{:?}", report.notes);
    let (_, report) = read("a.csv", "1,5,2,5\n2,5,3,5\n").unwrap();
    assert!(report.notes.iter().any(|n| n.contains("separate columns by ;")), "{:?}", report.notes);
}

const LEDNICER: &str = "\
NACA M-2, a part
       3.       4.

 0.000000  0.000000
 0.500000  0.040000
 1.000000  0.001000

 0.000000  0.000000
 0.300000 -0.030000
 0.700000 -0.020000
 1.000000 -0.001000
";

#[test]
fn lednicer_becomes_one_outline() {
    let expected = [[1.0, 0.001], [0.5, 0.04], [0.0, 0.0], [0.3, -0.03], [0.7, -0.02], [1.0, -0.001]];
    let expected = expected.map(|[x, y]| [x, y, 0.0]);
    let without_gaps = LEDNICER.replace("\n\n", "\n");
    for text in [LEDNICER, &without_gaps] {
        let (scene, report) = read("m2.dat", text).unwrap();
        assert_eq!(coordinates(&scene), expected);
        assert!(!polyline(&scene).1);
        assert_eq!(scene.objects()[0].name(), "NACA M-2, a part");
        assert!(report.notes.iter().any(|n| n.starts_with("Lednicer")), "{:?}", report.notes);
        assert_eq!((report.entities, report.kept, report.adds_up()), (8, 6, true));
    }
    let cut = &LEDNICER[..LEDNICER.len() - 40];
    let error = read("m2.dat", cut).unwrap_err().to_string();
    assert!(error.contains("counts 3 and 4 rows, but 5 follow"), "{error}");
}

#[test]
fn closed_where_the_last_row_repeats_the_first() {
    let square = "0 0\n1 0\n1 1\n0 1\n0 0\n";
    let (scene, report) = read("a.dat", square).unwrap();
    assert_eq!((polyline(&scene).0.len(), polyline(&scene).1), (4, true));
    assert_eq!((report.entities, report.kept), (5, 4));
    let (scene, _) = read("a.dat", "0 0\n1 0\n0 0\n").unwrap();
    assert_eq!((polyline(&scene).0.len(), polyline(&scene).1), (3, false));
    let (scene, _) = read_as("a.dat", square, "cloud").unwrap();
    assert_eq!(coordinates(&scene).len(), 5);
}

#[test]
fn chains_and_clouds_by_extension_and_by_option() {
    let kind = |name: &str, option: Option<&str>| {
        let rows = "1 2 3\n4 5 6\n7 8 10\n";
        let read = option.map_or_else(|| read(name, rows), |option| read_as(name, rows, option));
        read.unwrap().0.objects()[0].geometry().kind().to_owned()
    };
    for name in ["a.xyz", "a.asc", "B.PTS"] {
        assert_eq!([kind(name, None), kind(name, Some("polyline"))], ["cloud", "polyline"]);
    }
    for name in ["a.csv", "a.txt", "a.dat", "-", "xyz"] {
        assert_eq!([kind(name, None), kind(name, Some("cloud"))], ["polyline", "cloud"]);
    }
    let error = read_as("a.xyz", "1 2 3\n", "clouds").unwrap_err().to_string();
    assert!(error.contains("did you mean \"cloud\"?"), "{error}");
}

#[test]
fn every_zone_is_an_object() {
    let text = "TITLE = \"wing\"\nVARIABLES = \"y\"\n\"x\"\n\"cp\"\nZONE T=\"upper\", I=2, F=POINT\n1 0 9\n2 0 9\n\
                ZONE\nI=1\n3 1 9\nZONE T=\"upper\"\n1 1 1\n";
    let (scene, report) = read("wing.plt.dat", text).unwrap();
    let names: Vec<_> = scene.objects().iter().map(|o| o.name()).collect();
    assert_eq!(names, ["upper", "wing.plt", "upper.001"]);
    assert_eq!(scene.objects()[0].geometry().points()[1].coords.as_slice(), [0.0, 2.0, 0.0]);
    assert_eq!((report.entities, report.kept), (5, 4));
    assert!(scene.objects().iter().all(|o| matches!(o.geometry(), Geometry::Polyline(_))));
}

#[test]
fn names_from_name_lines_and_old_encodings() {
    let name = |bytes: &[u8]| read("file.dat", bytes).unwrap().0.objects()[0].name().to_owned();
    assert_eq!(name(b"G\xD6 398\n1 0\n0 1\n"), "GÖ 398");
    assert_eq!(name("Gö 398\n1 0\n0 1\n".as_bytes()), "Gö 398");
    assert_eq!(name(b"2412\n1 0\n0 1\n0.5 0\n"), "2412");
    assert_eq!(name(b"12% thick, smoothed\n1 0\n0 1\n"), "12% thick, smoothed");
    assert_eq!(name(b"1 0\n0 1\n"), "file");
    let (_, report) = read("file.dat", "one\ntwo\nthree\n1 0\n0 1\n").unwrap();
    assert_eq!((report.entities, report.left_out.values().sum::<usize>()), (4, 2));
}

#[test]
fn the_unit_is_noted_as_asked_for() {
    let options = ReadOptions { unit: Some(Unit::Inch), ..ReadOptions::default() };
    let (scene, report) = Points.read(&Memory::new("a.xyz", "1 2 3\n"), &options).unwrap();
    assert_eq!(scene.unit, Unit::Inch);
    assert!(!report.notes.iter().any(|n| n.contains("no unit")));
    assert_eq!(coordinates(&scene), [[1.0, 2.0, 3.0]]);
}

#[test]
fn counts_that_contradict_the_blocks_give_way_to_them() {
    let usual = coordinates(&read("a.dat", LEDNICER).unwrap().0);
    // The counts are wrong one way or another; the second surface is told by the blank line, or by x falling back.
    let wrong = LEDNICER.replace("       3.       4.\n", "       17.       17.\n");
    let unparted = wrong.replace("1.000000  0.001000\n\n", "1.000000  0.001000\n");
    assert!(wrong != LEDNICER && unparted != wrong);
    for text in [wrong, unparted] {
        let (scene, report) = read("a.dat", text.as_str()).unwrap();
        assert_eq!(coordinates(&scene), usual);
        let told = "line 2 counts 17 and 17 rows, but 3 and 4 follow: these are taken";
        assert!(report.adds_up() && report.notes.iter().any(|n| n == told), "{:?}", report.notes);
    }
}

/// Counts that add up to the rows and part them elsewhere than where x falls back to the leading edge.
#[test]
fn counts_that_add_up_and_part_the_rows_wrongly_are_told() {
    let side = |sign: f64, count: usize| -> Vec<String> {
        let at = |k: usize| k as f64 / (count - 1) as f64;
        (0..count).map(|k| format!("{} {}", at(k), sign * 0.1 * at(k) * (1.0 - at(k)))).collect()
    };
    for (upper, lower) in [(9, 9), (12, 7)] {
        let rows = [side(1.0, upper), side(-1.0, lower)].concat().join("\n");
        let right = read("a.dat", format!("FOIL\n{upper}. {lower}.\n{rows}\n")).unwrap();
        let (one, other) = (upper + 1, lower - 1);
        let (scene, report) = read("a.dat", format!("FOIL\n{one}. {other}.\n{rows}\n")).unwrap();
        assert_eq!(coordinates(&scene), coordinates(&right.0));
        let told =
            format!("line 2 counts {one} and {other} rows, but {upper} and {lower} follow: these are taken");
        assert!(report.notes.contains(&told), "{:?}", report.notes);
        // Set apart by blank lines, counts of nothing, too.
        let blocks = [side(1.0, upper).join("\n"), side(-1.0, lower).join("\n")].join("\n\n");
        for counts in ["0. 0.", "1. 1.", "9. 0."] {
            let (scene, report) = read("a.dat", format!("FOIL\n{counts}\n\n{blocks}\n")).unwrap();
            assert_eq!(coordinates(&scene), coordinates(&right.0), "{counts}: {:?}", report.notes);
        }
    }
}

/// Footnotes of any beginning; a row of which one number is wrong is none.
#[test]
fn footnotes_may_begin_with_a_mark_or_a_number() {
    for note in [
        "* 3 points by hand",
        "* three points by hand",
        "12% thick",
        "1. See report",
        "0.5 at the nose",
        "-- end --",
        "3 rows follow no more",
        "* see p. 3",
        "** 25 points **",
        "$12",
        "12 % thick or so",
    ] {
        for (file, rows) in [
            ("a.dat", "RAE\n1 0\n0 0.1\n1 0\n"),
            ("a.xyz", "1 0 0\n0 0.1 0\n1 0 3\n"),
            ("a.csv", "1,0,0\n0,0.1,0\n1,0,2\n"),
        ] {
            let (scene, report) = read(file, format!("{rows}{note}\n")).unwrap();
            assert_eq!(scene.objects()[0].geometry().points().len(), 3, "{file}: {note}");
            assert!(report.left_out.keys().any(|why| why.contains("text below the rows")), "{report:?}");
        }
    }
    for note in [
        "17 May 1998",
        "12 points 1987",
        "3 4 sept 1987",
        "0.12 0.30 max thickness",
        "---",
        "1987-03-12",
        "12:30",
    ] {
        let (scene, report) = read("a.dat", format!("RAE\n1 0\n0 0.1\n1 0\n{note}\nmore\n")).unwrap();
        assert_eq!(scene.objects()[0].geometry().points().len(), 3, "{note}");
        assert!(report.left_out.keys().any(|why| why.contains("text below the rows")), "{report:?}");
        // Above rows it is none.
        let error = read("a.dat", format!("RAE\n1 0\n0 0.1\n{note}\n1 0\n0 0\n")).unwrap_err();
        assert!(error.to_string().contains("line 4"), "{note}: {error}");
    }
    for (file, row) in [
        ("a.dat", "0.5 oops"),
        ("a.dat", "0.5 nan"),
        ("a.dat", "inf 0.5"),
        ("a.dat", "0.5 O.25"),
        ("a.dat", "0.5 0.2 x"),
        ("a.dat", "0.5"),
        ("a.csv", "0.5,oops,bad"),
        ("a.csv", "0.5,,"),
    ] {
        let rows = if file == "a.csv" { "1,0,0\n0,0.1,0\n" } else { "1 0\n0 0.1\n" };
        assert!(read(file, format!("{rows}{row}\n")).is_err(), "{row}");
    }
}

#[test]
fn footnotes_and_further_outlines_under_their_own_heading() {
    let (scene, report) = read("a.dat", "RAE\n1 0\n0 0.1\n1 0\nSource: report 1\n(no 2)\n").unwrap();
    assert_eq!((scene.objects().len(), scene.objects()[0].name()), (1, "RAE"));
    let lines: Vec<&String> = report.left_out.keys().filter(|why| why.contains("below the rows")).collect();
    assert_eq!(lines, ["line 5: text below the rows", "line 6: text below the rows"]);
    assert!(report.adds_up());

    let (scene, report) =
        read("a.dat", "Wing root\n1 0\n0.5 0.1\n0 0\n\nWing tip\n1 0.1\n0 0\n0.5 -1\n").unwrap();
    let names: Vec<_> = scene.objects().iter().map(|o| (o.name(), o.geometry().points().len())).collect();
    assert_eq!(names, [("Wing root", 3), ("Wing tip", 3)]);
    assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");

    // Each as it would be alone.
    let two = format!("{LEDNICER}\n{}", LEDNICER.replace("NACA M-2, a part", "Second"));
    let (scene, report) = read("a.dat", two).unwrap();
    let alone = read("a.dat", LEDNICER).unwrap().0;
    assert_eq!(scene.objects().len(), 2, "{report:?}");
    for object in scene.objects() {
        assert_eq!(object.geometry(), alone.objects()[0].geometry());
    }
    assert_eq!(scene.objects()[1].name(), "Second");
    assert!(report.adds_up());
}

/// Tables pad the row of their name with separators, which are none of it; what holds for all outlines of a file is said once.
#[test]
fn padded_names_and_what_is_said_of_all_outlines() {
    for (text, name) in [
        ("root,\n0,0\n1,0\n2,1\n", "root"),
        ("root,,\n0,0,0\n1,0,0\n2,1,0\n", "root"),
        ("wing, root;;\n0;0;0\n1;0;0\n2;1;0\n", "wing, root"),
        (" root , , \n0,0,0\n1,0,0\n2,1,0\n", "root"),
    ] {
        let (scene, report) = read("a.csv", text).unwrap();
        assert_eq!((scene.objects().len(), scene.objects()[0].name()), (1, name), "{text:?}: {report:?}");
    }
    let (scene, report) = read("a.dat", "Root\n0 0\n1 0\n2 1\n\nTip\n0 1\n1 2\n2 4\n").unwrap();
    assert_eq!(scene.objects().len(), 2);
    let said =
        report.notes.iter().filter(|note| note.starts_with("the rows are taken as a polyline")).count();
    assert_eq!(said, 1, "{report:?}");
}

#[test]
fn names_have_their_accents_whatever_wrote_them() {
    for bytes in [
        &b"G\x94 387\n1 0\n0 0.1\n1 0\n"[..],
        b"G\xf6 387\n1 0\n0 0.1\n1 0\n",
        "Gö 387\n1 0\n0 0.1\n1 0\n".as_bytes(),
    ] {
        assert_eq!(read("a.dat", bytes).unwrap().0.objects()[0].name(), "Gö 387");
    }
}

/// Where no blank lines set the counts apart, the shape of the rows does, or the report asks.
#[test]
fn counts_that_contradict_the_rows_are_no_silent_point() {
    let usual = coordinates(&read("a.dat", LEDNICER).unwrap().0);
    let wrong = LEDNICER.replace("       3.       4.\n", "       4.       5.\n").replace("\n\n", "\n");
    let (scene, report) = read("a.dat", wrong.as_str()).unwrap();
    assert_eq!(coordinates(&scene), usual);
    let told = "line 2 counts 4 and 5 rows, but 3 and 4 follow: these are taken";
    assert!(report.adds_up() && report.notes.iter().any(|n| n == told), "{:?}", report.notes);

    // Not two surfaces: a point, as it stands, and the report says so.
    let rows = "0 0\n0.5 0.08\n1 0\n0.2 0\n0.5 -0.05\n0.1 0\n";
    let (scene, report) = read("a.dat", format!("FOIL\n4. 3.\n{rows}")).unwrap();
    assert_eq!(coordinates(&scene).len(), 7);
    let told = "line 2 is taken as the point (4, 3), far from all others: if it counts rows, it is not the 6 that follow";
    assert!(report.notes.iter().any(|n| n == told), "{:?}", report.notes);
    // A polygon of points is one.
    for polygon in ["2 2\n0 0\n5 5\n9 0\n3 -4\n1 1\n", "0.5 0.5\n0 0\n1 0\n1 1\n0 1\n", "3 2\n0 0\n1 0\n"] {
        let (scene, report) = read("a.dat", polygon).unwrap();
        assert_eq!(coordinates(&scene).len(), polygon.lines().count());
        assert!(report.notes.iter().all(|n| !n.contains("counts")), "{:?}", report.notes);
    }

    // A third block: which two are meant is not said.
    for counts in ["4. 3.", "3. 3."] {
        let text = format!("FOIL\n{counts}\n\n0 0\n0.5 0.08\n1 0\n\n0 0\n0.5 -0.05\n1 0\n\n7 7\n8 8\n");
        let error = read("a.dat", text).unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("but 8 follow in 3 blocks"), "{error}");
    }
}

#[test]
fn a_heading_of_one_row_is_named() {
    let error =
        read("a.xyz", "0 0 0\n1 0 0\n2 1 0\nsecond\n0 0 1\n1 0 1\nthird\n5 5 5\n").unwrap_err().to_string();
    assert!(
        error.contains("line 7")
            && error
                .contains("\"third\" is not a number: a heading of rows has two of them or more below it"),
        "{error}"
    );
    let error = read("a.xyz", "0 0 0\n1 0 0\n2 x 0\n").unwrap_err().to_string();
    assert!(error.contains("line 3") && error.contains("over two rows or more"), "{error}");
}

/// What holds for all outlines is said once; how a text that is no UTF-8 was read is said.
#[test]
fn notes_come_once_and_tell_the_encoding() {
    let outline = "1 0\n0.5 0.1\n0 0\n0.5 -0.05\n1 0\n";
    let (_, report) = read("a.dat", format!("ONE\n{outline}TWO\n{outline}")).unwrap();
    assert_eq!(
        report.notes.iter().filter(|n| n.starts_with("Selig airfoil")).count(),
        1,
        "{:?}",
        report.notes
    );
    for (name, text, encoding) in [
        (&b"\x93NACA\x94 0012 \x96 12 %"[..], "“NACA” 0012 – 12 %", "Windows-1252"),
        (b"\xc9\xcd\xcd\xbb FOIL \xba", "╔══╗ FOIL ║", "code page 437"),
        (b"M\x9aLLER H\x94he", "MÜLLER Höhe", "code page 437"),
        (b"G\xf6ttingen 12\xb0", "Göttingen 12°", "Windows-1252"),
    ] {
        let (scene, report) = read("a.dat", [name, b"\n", outline.as_bytes()].concat()).unwrap();
        assert_eq!(scene.objects()[0].name(), text);
        let told = format!("the text is not UTF-8: it was read as {encoding}");
        assert!(report.notes.contains(&told), "{:?}", report.notes);
    }
    let (_, report) = read("a.dat", format!("“GÖ”\n{outline}")).unwrap();
    assert!(report.notes.iter().all(|n| !n.contains("UTF-8")), "{:?}", report.notes);
}
