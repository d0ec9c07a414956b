//! Bytes that are wrong: an error with its line, or a report; never a panic, never a hang.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use crate::common::{Entity, entity, file, read};
use loftsman_iges::Iges;
use loftsman_kernel::plugin::{Confidence, Format, Memory, Place, ReadOptions, Source, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::shape::Shape;
use proptest::prelude::*;

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/iges/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Reads bytes: a scene that is sound and can be written, or an error that says something.
fn survives(bytes: &[u8]) -> bool {
    match Iges.read(&Memory::new("t.igs", bytes), &ReadOptions::default()) {
        Ok((scene, report)) => {
            assert!(report.adds_up());
            scene.check().unwrap();
            let finite = scene.objects().iter().flat_map(|o| o.geometry().points());
            assert!(finite.flat_map(|p| p.iter()).all(|c| c.is_finite()));
            let mut out = Memory::new("out.igs", "");
            // What overflows is refused.
            _ = Iges.write(&scene, &mut out, &WriteOptions::default());
            true
        }
        Err(error) => {
            assert!(error.file == "t.igs" && !error.problem.is_empty(), "{error}");
            assert!(error.to_string().lines().count() == 1 && error.problem.len() < 1000, "{error}");
            false
        }
    }
}

/// The curves in space of loops on a surface with a vertex at the end of all numbers: once 5.6 MB of pieces from 20 kB, and a quarter of an hour
/// to read them.
#[test]
fn surfaces_that_overflow_do_not_swell() {
    let bytes = data("test_pipe_out_true.igs");
    let (scene, _) = Iges.read(&Memory::new("t.igs", bytes.clone()), &ReadOptions::default()).unwrap();
    let mut written = 0;
    for object in scene.objects() {
        let Geometry::Trimmed(trimmed) = object.geometry() else { continue };
        for vertex in 0..trimmed.control_vertices().len() {
            for far in [-1e308, 1e200, -1e160] {
                let mut moved = trimmed.clone();
                moved.control_vertices_mut()[vertex].y = far;
                let mut one = Scene::new();
                one.add(Object::new("t", moved.into())).unwrap();
                let mut out = Memory::new("out.igs", "");
                if Iges.write(&one, &mut out, &WriteOptions::default()).is_ok() {
                    assert!(out.bytes().len() < 10 * bytes.len(), "{vertex} at {far}: {}", out.bytes().len());
                    written += 1;
                }
            }
        }
    }
    assert!(written > 0);
}

#[test]
fn every_beginning_of_a_file_is_read_in_part_or_refused() {
    for name in ["sample_curves.igs", "test_pipe.iges"] {
        let bytes = data(name);
        let mut read = 0;
        for end in (0..bytes.len()).step_by(7) {
            read += usize::from(survives(&bytes[..end]));
        }
        assert!(read > 0 && survives(&bytes), "{name}");
    }
}

#[test]
fn without_any_one_line_the_rest_is_read_or_refused() {
    for name in ["sample_curves.igs", "test_pipe.iges", "input.igs"] {
        let text = String::from_utf8(data(name)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let mut read = 0;
        for without in 0..lines.len() {
            let rest: Vec<&str> =
                lines.iter().enumerate().filter(|(k, _)| *k != without).map(|(_, line)| *line).collect();
            read += usize::from(survives(rest.join("\n").as_bytes()));
        }
        assert!(read * 4 > lines.len(), "{name}: {read} of {}", lines.len());
    }
}

#[test]
fn numbers_that_lead_elsewhere_do_no_harm() {
    for name in ["test_pipe.iges", "D150WithGuides_wing.igs"] {
        let text = String::from_utf8(data(name)).unwrap();
        let lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let last = lines.iter().filter(|line| line.as_bytes()[72] == b'D').count();
        for (k, line) in lines.iter().enumerate() {
            if line.as_bytes()[72] != b'P' || k % 5 != 0 {
                continue;
            }
            let Some(at) = line[..64].rfind(',').filter(|at| *at > 4) else { continue };
            let own: usize = line[64..72].trim().parse().unwrap();
            // To itself, to another, to nothing.
            for number in [own, k * 7919 % last + 1, 9_999_999] {
                let mut changed = lines.clone();
                changed[k] = format!("{:<64}{}", format!("{},{number};", &line[..at.min(50)]), &line[64..]);
                survives(changed.join("\n").as_bytes());
            }
        }
    }
}

#[test]
fn what_is_broken_in_the_text_is_named_with_its_line() {
    let good = file(&[entity(0, "110,0.,0.,0.,1.,0.,0.;")]);
    assert!(survives(good.as_bytes()));
    for (from, to, line, says) in [
        ("1H,,1H;,4Hpart", "1HA,1H;,4Hpart", 2, "cannot be one"),
        ("01,;", "01, ", 2, "does not end"),
        ("     110       1", "     xyz       1", 4, "a type, a whole number"),
        (
            "     110       0       0       1",
            "     112       0       0       1",
            5,
            "a line of the directory is missing",
        ),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        let error = read(&bad).unwrap_err();
        assert!(error.place == Place::Line(line) && error.problem.contains(says), "{error}");
    }
    let compressed = format!("{:72}C      1\n{}", "", &good[81..]);
    for (letter, says) in [("C", "compressed"), ("B", "binary")] {
        let bad = compressed.replacen('C', letter, 1);
        let error = read(&bad).unwrap_err();
        assert!(error.place == Place::Line(1) && error.problem.contains(says), "{error}");
        assert!(error.problem.contains("ASCII of 80 columns"), "{error}");
    }
    assert!(read("").is_err() && read("solid cube\n").unwrap_err().problem.contains("no IGES file"));
    assert_eq!(Iges.confidence(b"solid cube\nfacet normal 0 0 1\n"), Confidence::No);
    assert_eq!(Iges.confidence(good.as_bytes()), Confidence::Sure);
}

#[test]
fn what_was_cut_off_is_refused() {
    let text = String::from_utf8(data("test_pipe.igs")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let cut = |count: usize| read(&lines[..count].join("\n"));
    let parameters = lines.iter().position(|line| line.as_bytes()[72] == b'P').unwrap();
    for count in [parameters - 1, parameters, parameters + 1, lines.len() - 2, (parameters + lines.len()) / 2]
    {
        let error = cut(count).unwrap_err();
        assert!(
            error.place == Place::Line(count) && error.problem.contains("cut off, get it again"),
            "{error}"
        );
    }
    // All but the last line is there.
    let (scene, report) = cut(lines.len() - 1).unwrap();
    let (whole, _) = cut(lines.len()).unwrap();
    assert!(scene.objects().len() == whole.objects().len() && scene.objects().len() > 1);
    assert!(report.notes.iter().any(|note| note.contains("no terminate section")), "{:?}", report.notes);
}

#[test]
fn groups_of_which_nothing_is_left_are_nothing() {
    let error = read(&file(&[entity(0, "100,0.,0.,x,0.,0.,1.,0.;"), entity(7, "402,1,1;")])).unwrap_err();
    assert!(error.problem.contains("nothing in it can be read: D1 (100)"), "{error}");
}

/// The cause is told, and not that what holds it goes with it: what holds itself, what is of a kind that is not read.
#[test]
fn a_file_of_which_nothing_is_left_says_why() {
    let matrix = |matrix: i32, parameters: &'static str| Entity { matrix, ..entity(0, parameters) };
    let turned = "124,1.,0.,0.,5.,0.,1.,0.,0.,0.,0.,1.,0.;";
    for (entities, says) in [
        (
            vec![entity(0, "308,0,4HPART,1,3;"), entity(0, "408,1,0.,0.,0.,1.;")],
            ": it is in itself, and nothing else shows it: take it out",
        ),
        (vec![entity(7, "402,1,1;")], "D1 (402), line 4: it is in itself"),
        (
            vec![entity(0, "999,1,2,3;")],
            "D1 (999), line 4: type 999, which is not read; export curves, surfaces or solids",
        ),
        (
            vec![matrix(3, "110,0.,0.,0.,1.,2.,3.;"), matrix(3, turned)],
            "nothing in it can be read: D3 (124), line 6: ",
        ),
    ] {
        let error = read(&file(&entities)).unwrap_err();
        assert!(error.problem.contains(says), "{error}");
    }
}

#[test]
fn units_that_are_not_named_are_told() {
    let good = file(&[entity(0, "110,0.,0.,0.,1.,0.,0.;")]);
    for (unit, found, says) in [
        (",,    ", Unit::Inch, "lengths are inches, which is the default"),
        ("0,,   ", Unit::Unknown, "the flag \"0\" of the unit"),
        ("3,,   ", Unit::Unknown, "the flag \"3\" of the unit"),
        ("2,2HMM", Unit::Millimetre, ""),
    ] {
        // Blanks before the next number are none of it.
        let text = good.replacen(
            "2,2HMM,",
            &if unit.ends_with(' ') { format!("{unit} ") } else { format!("{unit},") },
            1,
        );
        let (scene, report) = read(&text).unwrap();
        let told = report.notes.iter().any(|note| note.contains("unit"));
        assert_eq!((scene.unit, told), (found, !says.is_empty()), "{unit}: {:?}", report.notes);
        assert!(says.is_empty() || report.notes.iter().any(|n| n.contains(says)), "{:?}", report.notes);
    }
}

#[test]
fn an_entity_at_fault_is_left_out_with_its_number_and_line() {
    let good = "110,0.,0.,0.,1.,0.,0.;";
    for (form, bad, says) in [
        (0, "110,0.,0.,0.,1.,x,0.;", "\"x\" where a number"),
        (0, "110,0.,0.,0.,1.,1.E999,0.;", "where a number is needed"),
        (1, good, "a line without ends"),
        (0, "100,0.,0.,0.,1.,0.;", "5 parameters where 7"),
        (0, "100,0.,0.,0.,0.,0.,1.,0.;", "an arc of the radius 0"),
        (0, "102,2,1,99;", "names D99, which is not in the file"),
        (0, "102,999999999,1;", "says 999999999, but there are only"),
        (0, "102,1,3;", "lies in itself"),
        (0, "102,0;", "without curves"),
        (1, "104,0.,0.,0.,1.,0.,0.,0.,0.,0.,1.,1.;", "without squares"),
        (12, "106,2,999999999,0.;", "but there are only"),
        (12, "106,7,1,0.;", "copious data of the kind 7"),
        (0, "112,3,1,3,0,0.;", "without pieces"),
        (0, "126,1,1,0,0,1,0,0.,0.,1.,0.,1.,1.,0.,0.,0.,1.,0.,0.,0.,1.;", "knot"),
        (0, "126,1,1,0,0,0,0,0.,0.,1.,1.,1.,-1.,0.,0.,0.,1.,0.,0.,0.,1.;", "the weight -1"),
        (0, "126,999999999,3;", "999999999 + 1 control points"),
        (0, "126,1,-3;", "of the degree -3"),
        (0, "128,1,1,1,1,0,0,1,0,0,0.,0.,1.;", "parameters"),
        (0, "128,9,9,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,1.,1.,1.,1.,1.,1.;", "10 × 10"),
        (0, "120,1,1,0.,6.;", ""),
        (0, "120,1,3,0.,6.;", "parameter 2 names the entity itself"),
        (0, "122,1,0.,0.,0.;", "no length"),
        (0, "108,0.,0.,0.,1.;", "without a normal"),
        (0, "108,0.,0.,1.,1.;", "a plane without ends"),
        (0, "144,1,1,0,0;", "parameter 4 is 0 where the number"),
        (0, "144,1,0,0;", "is no surface"),
        (0, "144,3,0,0;", "parameter 1 names the entity itself"),
        (0, "186,1,1,0;", "type 110 where a shell"),
        (0, "408,1,0.,0.,0.,1.;", "type 110 where a subfigure"),
        (0, "408,7,1.E300,0.,0.,1.E300;", "not in the file"),
        (0, "130,1,2,0,0,0,1.,0.,0.,0.,0.,0.,1.;", "distance varies"),
        (0, "110,0.,0.,0.,1.,0.,0.", "where a number is needed"),
        (0, "110,9999H;", "a text of 9999 characters"),
    ] {
        let text = file(&[entity(0, good), entity(form, bad), entity(0, good)]);
        match read(&text) {
            Ok((scene, report)) => {
                scene.check().unwrap();
                let told: Vec<_> = report.left_out.into_keys().chain(report.notes).collect();
                let kind = bad.split(',').next().unwrap();
                let found = told.iter().find(|line| line.contains(says) || says.is_empty());
                let line = found.unwrap_or_else(|| panic!("{bad}: {told:#?}"));
                let at = format!("D3 ({kind}), line 6");
                assert!(
                    says.is_empty() || told.iter().any(|line| line.starts_with(&at)),
                    "{bad}: {line}: {told:#?}"
                );
            }
            Err(error) => panic!("{bad}: {error}"),
        }
    }
}

#[test]
fn matrices_in_circles_and_groups_in_themselves_end() {
    let placed = |matrix| Entity { matrix, ..entity(0, "110,0.,0.,0.,1.,0.,0.;") };
    let turn = |matrix| Entity { matrix, ..entity(0, "124,1.,0.,0.,1.,0.,1.,0.,0.,0.,0.,1.,0.;") };
    let (scene, report) =
        read(&file(&[entity(0, "110,0.,0.,0.,1.,0.,0.;"), placed(5), turn(7), turn(5)])).unwrap();
    assert_eq!(scene.objects().len(), 1);
    assert!(report.left_out.keys().any(|why| why.contains("lies in itself")), "{report:?}");
    let line = || entity(0, "110,0.,0.,0.,1.,0.,0.;");
    for groups in [
        vec![line(), entity(7, "402,2,1,5;"), entity(7, "402,1,3;")],
        vec![line(), entity(7, "402,2,1,3;")],
        vec![line(), entity(0, "308,0,1Ha,2,5,1;"), entity(0, "408,3,1.,0.,0.,1.;"), entity(0, "408,3;")],
        vec![line(), entity(0, "184,1,3,0;"), entity(0, "430,3;")],
    ] {
        survives(file(&groups).as_bytes());
    }
    // A chain of groups that is too deep for anything.
    let mut groups = vec!["110,0.,0.,0.,1.,0.,0.;".to_owned()];
    groups.extend((0..2000).map(|k| format!("402,1,{};", 2 * k + 1)));
    let entities: Vec<Entity<'_>> =
        groups.iter().enumerate().map(|(k, g)| entity(if k == 0 { 0 } else { 7 }, g)).collect();
    survives(file(&entities).as_bytes());
}

#[test]
fn a_directory_that_points_to_one_place_ends() {
    // Each entity names the same long record, which never ends.
    let long = format!("110,{}", "0.,".repeat(20_000));
    let mut entities = vec![entity(0, long.as_str())];
    entities.extend((0..2000).map(|_| entity(0, "110,1.;")));
    let text = file(&entities);
    let text: String = text
        .lines()
        .map(|line| {
            let directory = line.as_bytes()[72] == b'D' && line.ends_with(|c: char| "13579".contains(c));
            if directory { format!("{}       1{}\n", &line[..8], &line[16..]) } else { format!("{line}\n") }
        })
        .collect();
    survives(text.as_bytes());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]
    #[test]
    fn mutations_do_no_harm(
        which in 0..4_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..6),
    ) {
        static FILES: std::sync::OnceLock<Vec<Vec<u8>>> = std::sync::OnceLock::new();
        let files = FILES.get_or_init(|| {
            ["sample_curves.igs", "test_pipe.iges", "input.igs", "test_pipe_hollow.iges"].map(data).to_vec()
        });
        let mut bytes = files[which].clone();
        for (at, byte, how) in changes {
            let at = at.index(bytes.len());
            match how {
                // Numbers turn into numbers: what is well formed gets further.
                0 | 1 => bytes[at] = b"0123456789,;.-DH "[byte as usize % 17],
                2 => bytes[at] = byte,
                _ => {
                    let to = (at + byte as usize).min(bytes.len());
                    bytes.drain(at..to);
                    if bytes.is_empty() {
                        bytes.push(byte);
                    }
                }
            }
        }
        survives(&bytes);
    }
}
