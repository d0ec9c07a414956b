//! STEP and IGES files of other programs with something in them changed: read or refused, sound, and never for long.
//!
//! A few hundred changes are tried as a rule. `LOFTSMAN_MUTATE_SECONDS=3600 cargo test --release -p loftsman-tests --test library mutated` goes on
//! for so long with each format. What it finds is named by the file and the number of the change, and becomes a test of the crate at fault.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "how many changes were tried is asked for with --nocapture"
)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use loftsman::kernel::plugin::{Chord, Fate, Fineness, Format, Memory, ReadOptions, WriteOptions};
use loftsman::kernel::scene::Geometry;

/// Changes of each format where no time is given.
const CHANGES: u64 = 150;
/// No file of these sizes may take longer, however slow the machine.
const LONGEST: Duration = Duration::from_secs(60);
/// Larger files are left out: the changes would be fewer.
const LARGEST: u64 = 100_000;

/// Numbers in a fixed order, the same every time (Steele and Vigna's SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { (self.next() % count as u64) as usize }
    }
}

/// Where in a text runs of digits and what belongs to numbers are, from a place on; the first one.
fn number_from(bytes: &[u8], from: usize) -> Option<(usize, usize)> {
    let start = from + bytes[from..].iter().position(u8::is_ascii_digit)?;
    let end = bytes[start..].iter().position(|b| !b.is_ascii_digit() && !b".eE+-".contains(b));
    Some((start, end.map_or(bytes.len(), |end| start + end)))
}

/// One to four changes: bytes, numbers, lines, references, words of elsewhere, the end.
fn changed(original: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    const ODD: [&str; 16] = [
        "0",
        "1",
        "-1",
        "2",
        "3",
        "1e308",
        "-1e308",
        "1e-308",
        "999999999999",
        "0.5",
        "1e9",
        "4294967296",
        "-0.",
        "1.",
        "1000000",
        "17",
    ];
    let mut bytes = original.to_vec();
    for _ in 0..=numbers.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = numbers.below(bytes.len());
        let line = |bytes: &[u8], at: usize| {
            let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
            let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |k| at + k + 1);
            start..end
        };
        match numbers.below(8) {
            0 => bytes[at] = (numbers.next() & 0xff) as u8,
            1 => {
                let own = line(&bytes, at);
                bytes.drain(own);
            }
            2 => {
                let copy = bytes[line(&bytes, at)].to_vec();
                let to = numbers.below(bytes.len());
                let to = line(&bytes, to).start;
                bytes.splice(to..to, copy);
            }
            // Of both formats most of what matters are numbers.
            3..=5 => {
                if let Some((start, end)) = number_from(&bytes, at) {
                    bytes.splice(start..end, ODD[numbers.below(ODD.len())].bytes());
                }
            }
            6 => {
                let from = numbers.below(original.len());
                if let (Some((a, b)), Some((c, d))) = (number_from(&bytes, at), number_from(original, from)) {
                    let other = original[c..d].to_vec();
                    bytes.splice(a..b, other);
                }
            }
            _ => {
                let far = numbers.below(200);
                let end = (at + far).min(bytes.len());
                bytes.drain(at..end);
            }
        }
    }
    bytes
}

/// Reads, and where something is read, writes it and reads that.
fn survives(format: &dyn Format, name: &str, bytes: Vec<u8>) -> bool {
    let memory = Memory::new(name, bytes);
    let (scene, report) = match format.read(&memory, &ReadOptions::default()) {
        Ok(read) => read,
        Err(error) => {
            assert!(error.file == name && !error.problem.is_empty(), "{error}");
            return false;
        }
    };
    assert!(report.adds_up(), "{report:?}");
    scene.check().unwrap();
    let finite = scene
        .objects()
        .iter()
        .all(|o| o.geometry().points().iter().flat_map(|p| p.iter()).all(|c| c.is_finite()));
    assert!(finite, "NaN or infinity came through");
    let mut out = Memory::new(name, Vec::new());
    if let Ok(report) = format.write(&scene, &mut out, &WriteOptions::default())
        && report.objects.iter().any(|o| o.fate != Fate::LeftOut)
    {
        format.read(&out, &ReadOptions::default()).unwrap();
    }
    true
}

/// Names what has been going on for too long, while it does: one that never ends could not be told afterwards.
#[derive(Default)]
struct Watch(Arc<Mutex<(String, u64)>>);

impl Watch {
    fn over(&self, name: String) {
        let mut one = self.0.lock().unwrap();
        if one.1 == 0 {
            let all = Arc::downgrade(&self.0);
            std::thread::spawn(move || {
                let mut before = 0;
                while let Some(now) = all.upgrade().map(|one| one.lock().unwrap().clone()) {
                    if now.1 == before {
                        eprintln!("{} goes on for more than {LONGEST:?}", now.0);
                    }
                    before = now.1;
                    std::thread::sleep(LONGEST);
                }
            });
        }
        *one = (name, one.1 + 1);
    }
}

fn mutated(format: &str, extensions: &[&str]) {
    let registry = loftsman::registry();
    let format = registry.formats().iter().find(|f| f.declaration().name == format).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(format.declaration().name);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()).collect();
    files.retain(|file| {
        let extension = file.path().extension().map(|e| e.to_string_lossy().to_lowercase());
        extension.is_some_and(|e| extensions.contains(&e.as_str()))
            && file.metadata().unwrap().len() <= LARGEST
    });
    files.sort_by_key(std::fs::DirEntry::path);
    let files: Vec<(String, Vec<u8>)> = files
        .iter()
        .map(|file| (file.file_name().to_string_lossy().into_owned(), std::fs::read(file.path()).unwrap()))
        .collect();
    assert!(files.len() >= 5);
    let given = std::env::var("LOFTSMAN_MUTATE_SECONDS").ok().map(|text| text.parse().unwrap());
    let first: u64 = std::env::var("LOFTSMAN_MUTATE_FROM").map_or(0, |text| text.parse().unwrap());
    let (started, mut read, mut failed, mut change) = (Instant::now(), 0, Vec::new(), first);
    let watch = Watch::default();
    while given.map_or(change < CHANGES, |seconds| started.elapsed() < Duration::from_secs(seconds)) {
        let (name, original) = &files[(change % files.len() as u64) as usize];
        let bytes = changed(original, &mut Numbers(change));
        let begun = Instant::now();
        watch.over(format!("{name}, change {change}"));
        match catch_unwind(AssertUnwindSafe(|| survives(format.as_ref(), name, bytes))) {
            Ok(is_read) => read += u64::from(is_read),
            Err(_) => failed.push(format!("{name}, change {change}")),
        }
        if begun.elapsed() > LONGEST {
            failed.push(format!("{name}, change {change}: {:?}", begun.elapsed()));
        }
        change += 1;
    }
    let tried = change - first;
    println!(
        "{}: {tried} changes from {first} on, {read} read, {} failed",
        format.declaration().name,
        failed.len()
    );
    assert!(failed.is_empty(), "{failed:#?}");
    // Most changes cost something in the file and not the file.
    assert!(4 * read > tried, "{read} of {tried}");
}

#[test]
fn changed_step_files_are_read_or_refused() {
    mutated("step", &["stp", "step"]);
}

#[test]
fn changed_iges_files_are_read_or_refused() {
    mutated("iges", &["igs", "iges"]);
}

/// Changes after which edges are far from surfaces to which a million places are about as near: that took some 40 s of processor time a file, as all of them were
/// looked for at each place of each edge.
#[test]
fn edges_far_from_their_surfaces_are_told_soon() {
    let registry = loftsman::registry();
    let begun = Instant::now();
    for (name, file, change) in [
        ("step", "base_interface_AP203.STEP", 1_221_602),
        ("step", "NIST_MBE_PMI_11.stp", 1_171_357),
        ("iges", "D150WithGuides_wing.igs", 1_038_410),
        ("iges", "D150WithGuides_wing.igs", 1_099_700),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).join(file);
        let bytes = changed(&std::fs::read(path).unwrap(), &mut Numbers(change));
        let format = registry.formats().iter().find(|f| f.declaration().name == name).unwrap();
        let (_, report) = format.read(&Memory::new(file, bytes.clone()), &ReadOptions::default()).unwrap();
        assert!(
            report.notes.iter().any(|note| note.contains("off the surface of face")),
            "{file}: {report:?}"
        );
        assert!(survives(format.as_ref(), file, bytes));
    }
    // Both times of all four: it was five minutes on a quiet machine.
    assert!(begun.elapsed() < LONGEST, "{:?}", begun.elapsed());
}

/// A weight of 1e308 makes nearly all of a face one point: to write the edges of it in its parameters took an hour, as each place of them was looked for all over the face.
#[test]
fn edges_on_faces_that_are_nearly_points_are_written_soon() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/step/dm1-id-214.stp");
    let bytes = changed(&std::fs::read(path).unwrap(), &mut Numbers(7_025_200));
    assert!(String::from_utf8_lossy(&bytes).contains("0.500000001e308"));
    let registry = loftsman::registry();
    let format = registry.formats().iter().find(|f| f.declaration().name == "step").unwrap();
    let begun = Instant::now();
    assert!(survives(format.as_ref(), "dm1-id-214.stp", bytes));
    assert!(begun.elapsed() < LONGEST, "{:?}", begun.elapsed());
}

/// Files of which one number was changed so that faces are nowhere near their edges: what cannot be cut is left out with the reason, after a search that
/// ends. Each took minutes and more.
#[test]
fn solids_whose_edges_are_far_from_their_faces_are_cut_soon() {
    let damaged = [
        ("step", "base_interface_AP203.STEP", 375, "#360 = DIRECTION ( 'NONE',  ( 0.0, 1.0, -1.0 ) ) ;"),
        ("step", "base_interface_AP203.STEP", 375, "#360 = DIRECTION ( 'NONE',  ( 0.0, 1.E308, -1.0 ) ) ;"),
        ("step", "io1-cm-214.stp", 326, "#3150=DIRECTION('',(1.,-1.E300,0.));"),
        (
            "iges",
            "test_pipe.igs",
            203,
            "120,47,41,4.71238898,6.283185307;                                0000037P0000020",
        ),
    ];
    let registry = loftsman::registry();
    let fineness = Fineness { chord: Chord::Relative(1e-3), angle: 0.3 };
    for (name, file, line, text) in damaged {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).join(file);
        let original = std::fs::read_to_string(path).unwrap();
        let lines = original.lines().enumerate().map(|(k, own)| if k + 1 == line { text } else { own });
        let bytes = lines.collect::<Vec<_>>().join("\n").into_bytes();
        let format = registry.formats().iter().find(|f| f.declaration().name == name).unwrap();
        let begun = Instant::now();
        let (scene, _) = format.read(&Memory::new(file, bytes), &ReadOptions::default()).unwrap();
        let mut faces = 0;
        for object in scene.objects() {
            if let Geometry::Brep(brep) = object.geometry() {
                faces += brep.face_count();
                if let Ok(found) = registry.tessellator().unwrap().measured_brep(brep, &fineness) {
                    faces -= found.left_out.len();
                }
            }
        }
        assert!(begun.elapsed() < LONGEST, "{file}: {:?}", begun.elapsed());
        assert!(faces > 0, "{file}: nothing of it is cut");
    }
}

/// One control point of an edge far away or at nothing: the edge is anywhere about as far from its face as from all of it. Looking for the nearest place for each
/// of a hundred thousand chords took more than a minute.
#[test]
fn one_number_far_too_large_or_small_costs_no_time() {
    let registry = loftsman::registry();
    let format = registry.formats().iter().find(|f| f.declaration().name == "step").unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/made/offset.step");
    let original = std::fs::read_to_string(path).unwrap();
    let point = "#94 = CARTESIAN_POINT('',(3.516531655413,0.,3.025526813982));";
    let fineness = Fineness { chord: Chord::Relative(1e-3), angle: 0.3 };
    assert_eq!(original.matches(point).count(), 1);
    for number in ["1e30", "1e60", "1e100", "1e200", "1e300", "1e308", "-1e200", "1e-200", "100."] {
        let text =
            original.replace(point, &format!("#94 = CARTESIAN_POINT('',(3.516531655413,0.,{number}));"));
        let begun = Instant::now();
        let memory = Memory::new("offset.step", text.into_bytes());
        let (scene, _) = format.read(&memory, &ReadOptions::default()).unwrap();
        let breps = scene.objects().iter().filter_map(|object| match object.geometry() {
            Geometry::Brep(brep) => Some(brep),
            _ => None,
        });
        for brep in breps {
            let told = registry.tessellator().unwrap().measured_brep(brep, &fineness);
            let said = match told {
                Ok(found) => format!("{:?}", found.left_out),
                Err(error) => error.to_string(),
            };
            assert!(number == "1e-200" || said.contains("edge"), "{number}: {said}");
        }
        assert!(begun.elapsed() < LONGEST / 4, "{number}: {:?}", begun.elapsed());
    }
}
