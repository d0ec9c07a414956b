//! Files of other programs, with facts counted by someone else (`tests/data/iges/SOURCES.md`).

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;

use loftsman_iges::Iges;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Confidence, Format, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};

/// What is in a file.
struct Facts {
    file: &'static str,
    /// Entities of each type.
    types: &'static [(u32, usize)],
    unit: Unit,
    /// Curves, surfaces, trimmed surfaces, faces of Breps that it becomes.
    objects: [usize; 4],
}

const FILES: &[Facts] = &[
    Facts {
        file: "test_pipe.igs",
        types: &[
            (100, 16),
            (102, 10),
            (108, 2),
            (110, 32),
            (120, 4),
            (124, 12),
            (142, 6),
            (144, 6),
            (402, 1),
        ],
        unit: Unit::Millimetre,
        objects: [0, 0, 6, 0],
    },
    Facts {
        file: "test_pipe.iges",
        types: &[
            (100, 8),
            (102, 6),
            (108, 2),
            (110, 14),
            (120, 2),
            (124, 6),
            (126, 2),
            (142, 4),
            (144, 4),
            (402, 1),
        ],
        unit: Unit::Metre,
        objects: [0, 0, 4, 0],
    },
    Facts {
        file: "test_pipe_hollow.iges",
        types: &[
            (100, 4),
            (102, 8),
            (108, 2),
            (110, 28),
            (120, 4),
            (124, 3),
            (126, 12),
            (142, 8),
            (144, 6),
            (402, 3),
        ],
        unit: Unit::Metre,
        objects: [0, 0, 6, 0],
    },
    // Boundaries of most of its faces do not close: these are the whole surfaces.
    Facts {
        file: "test_pipe_hollow_out_true.iges",
        types: &[(126, 8), (128, 6), (142, 8), (144, 6), (402, 1)],
        unit: Unit::Millimetre,
        objects: [0, 4, 0, 2],
    },
    Facts {
        file: "test_pipe_out_true.iges",
        types: &[(126, 4), (128, 4), (142, 4), (144, 4), (402, 1)],
        unit: Unit::Millimetre,
        objects: [0, 0, 0, 4],
    },
    Facts {
        file: "test_pipe_out_true.igs",
        types: &[(102, 6), (126, 24), (128, 6), (142, 6), (144, 6), (402, 1)],
        unit: Unit::Millimetre,
        objects: [0, 0, 6, 0],
    },
    Facts {
        file: "D150WithGuides_wing.igs",
        types: &[
            (110, 20),
            (116, 2),
            (123, 4),
            (126, 18),
            (128, 6),
            (190, 2),
            (406, 9),
            (502, 1),
            (504, 1),
            (508, 8),
            (510, 8),
            (514, 1),
        ],
        unit: Unit::Millimetre,
        objects: [0, 0, 0, 8],
    },
    Facts {
        file: "input.igs",
        types: &[
            (100, 4),
            (102, 14),
            (110, 28),
            (120, 1),
            (124, 4),
            (126, 30),
            (128, 6),
            (142, 7),
            (144, 7),
            (314, 1),
        ],
        unit: Unit::Millimetre,
        objects: [0, 0, 7, 0],
    },
    // Two of its lines have no ends; copious data are points and a polyline.
    Facts {
        file: "sample_curves.igs",
        types: &[(100, 4), (102, 1), (104, 1), (106, 2), (110, 4), (124, 6), (126, 1)],
        unit: Unit::Millimetre,
        objects: [6, 0, 0, 0],
    },
    Facts {
        file: "as1_pe_203.igs",
        types: &[
            (100, 280),
            (102, 280),
            (108, 90),
            (110, 880),
            (120, 70),
            (124, 350),
            (142, 210),
            (144, 160),
            (402, 19),
        ],
        unit: Unit::Millimetre,
        objects: [32, 0, 160, 0],
    },
];

/// Files that are too large to go along; they are looked at where they are beside the project.
const LARGE: &[Facts] = &[
    Facts {
        file: "D150WithGuides_fuselage.igs",
        types: &[
            (110, 941),
            (116, 2),
            (123, 4),
            (126, 479),
            (128, 236),
            (190, 2),
            (406, 239),
            (502, 1),
            (504, 1),
            (508, 238),
            (510, 238),
            (514, 1),
        ],
        unit: Unit::Millimetre,
        objects: [0, 0, 0, 238],
    },
    Facts {
        file: "IEA_15MW_CFD.igs",
        types: &[(126, 40), (128, 3), (141, 2), (143, 2), (314, 1), (406, 16)],
        unit: Unit::Metre,
        objects: [24, 1, 2, 0],
    },
];

fn data(name: &str) -> Option<Vec<u8>> {
    let root = env!("CARGO_MANIFEST_DIR");
    let places = ["../../tests/data/iges", "../../../shared/data/iges"];
    places.iter().find_map(|place| std::fs::read(format!("{root}/{place}/{name}")).ok())
}

fn read(name: &str, bytes: &[u8]) -> (Scene, ReadReport) {
    assert_eq!(Iges.confidence(&bytes[..bytes.len().min(4096)]), Confidence::Sure, "{name}");
    let (scene, report) = Iges.read(&Memory::new(name, bytes), &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && scene.up == Up::Z, "{name}: {report:?}");
    scene.check().unwrap();
    (scene, report)
}

fn objects(scene: &Scene) -> impl Iterator<Item = &Object> {
    scene.objects().iter().chain(scene.definitions().iter().flat_map(|d| d.objects()))
}

fn breps(scene: &Scene) -> impl Iterator<Item = &Brep> {
    objects(scene).filter_map(|o| if let Geometry::Brep(brep) = o.geometry() { Some(brep) } else { None })
}

fn check(facts: &Facts, bytes: &[u8]) {
    let name = facts.file;
    let (scene, report) = read(name, bytes);
    // What the directory lists, by its first lines.
    let text = String::from_utf8_lossy(bytes);
    let mut types: BTreeMap<u32, usize> = BTreeMap::new();
    for line in text.lines().filter(|line| line.as_bytes().get(72) == Some(&b'D')).step_by(2) {
        *types.entry(line[..8].trim().parse().unwrap()).or_default() += 1;
    }
    assert_eq!(types, facts.types.iter().copied().collect(), "{name}");
    assert_eq!(report.entities, facts.types.iter().map(|(_, count)| count).sum::<usize>(), "{name}");
    assert_eq!(scene.unit, facts.unit, "{name}");
    let count = |kind: &str| objects(&scene).filter(|o| o.geometry().kind() == kind).count();
    let faces = breps(&scene).map(Brep::face_count).sum();
    assert_eq!(
        [count("curve"), count("surface"), count("trimmed"), faces],
        facts.objects,
        "{name}: {report:?}"
    );
    for brep in breps(&scene) {
        let first = brep.points()[0];
        let size = brep.points().iter().map(|p| (p - first).norm()).fold(0.0, f64::max);
        // What was deformed by its control points has curves of its own beside its surfaces.
        let off = if name.contains("out_true") { 5e-3 } else { 2e-6 };
        let flaws = brep.flaws(off * size).unwrap();
        assert!(flaws.is_empty(), "{name}: {}", flaws[0]);
    }
    let changed: Vec<_> = report.approximated.keys().filter(|why| !why.contains("off its surface")).collect();
    assert_eq!(changed.len(), if name == "test_pipe_hollow_out_true.iges" { 4 } else { 0 }, "{changed:?}");
    assert!(changed.iter().all(|why| why.ends_with(" mm: the whole surface is kept")), "{changed:?}");
    let at_fault: usize =
        report.left_out.iter().filter(|(why, _)| why.starts_with('D')).map(|(_, n)| n).sum();
    assert_eq!(at_fault, if name == "sample_curves.igs" { 2 } else { 0 }, "{name}: {report:?}");
}

#[test]
fn files_have_the_counted_entities() {
    for facts in FILES {
        check(facts, &data(facts.file).unwrap());
    }
    assert!(FILES.len() >= 10);
    for facts in LARGE {
        match data(facts.file) {
            Some(bytes) => check(facts, &bytes),
            None => println!("not looked at, as it is not here: {}", facts.file),
        }
    }
}

#[test]
fn broken_files_are_refused_with_where_and_why() {
    for (name, says) in [
        ("first_line_82_cols.iges", "line 1: there is no global section"),
        ("first_line_without_80_cols.iges", "its directory section is missing"),
        ("up_to_line_7_of_DE_section.iges", "line 12: an entity of the directory without its second line"),
    ] {
        let error = Iges.read(&Memory::new(name, data(name).unwrap()), &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
    }
}

#[test]
fn names_colours_and_layers_are_kept() {
    let (scene, _) = read("D150WithGuides_wing.igs", &data("D150WithGuides_wing.igs").unwrap());
    let wing = breps(&scene).next().unwrap();
    assert_eq!(scene.objects()[0].name(), "D150_wing_1ID");
    let names: Vec<_> = (0..wing.face_count()).map(|face| wing.face_name(face).unwrap()).collect();
    assert_eq!(names, ["Bottom", "Top", "Bottom", "Top", "Bottom", "Top", "Inside", "Outside"]);
    // The edges of all faces are shared: only the end of the wing is open.
    assert!(wing.is_closed(&(0..8).collect::<Vec<_>>()));
    let (scene, _) = read("input.igs", &data("input.igs").unwrap());
    assert!(scene.objects().iter().all(|o| o.color.is_some_and(|c| c[2] > c[0])));
    let (scene, _) = read("as1_pe_203.igs", &data("as1_pe_203.igs").unwrap());
    let groups = scene.objects().iter().filter(|o| matches!(o.geometry(), Geometry::Group)).count();
    assert_eq!(groups, 19);
}

#[test]
fn a_hundred_thousand_entities_take_time_by_their_number() {
    let text = |count: usize| {
        let mut directory = String::new();
        let mut parameters = String::new();
        for k in 0..count {
            let (entry, line) = (2 * k + 1, k + 1);
            directory += &format!("{:>8}{line:8}{:48}00000000D{entry:7}\n", 110, "");
            directory += &format!("{:>8}{:16}{:>8}{:40}D{:7}\n", 110, "", 1, "", entry + 1);
            parameters += &format!("{:<64}{entry:8}P{line:7}\n", format!("110,{k}.,0.,0.,{k}.,1.,0.;"));
        }
        let head = format!("{:72}S      1\n{:<72}G      1\n", "", "1H,,1H;,,,,,,,,,,,,,2,2HMM,,,,1.D-6;");
        format!("{head}{directory}{parameters}{:72}T      1\n", "S      1G      1")
    };
    let time = |count: usize| {
        let memory = Memory::new("many.igs", text(count));
        let start = std::time::Instant::now();
        let (scene, report) = Iges.read(&memory, &ReadOptions::default()).unwrap();
        assert_eq!((scene.objects().len(), report.kept), (count, count));
        start.elapsed().as_secs_f64()
    };
    time(1_000);
    let (small, large) = (time(10_000), time(100_000));
    println!("10,000 lines in {small:.3} s, 100,000 in {large:.3} s");
    assert!(large < 40.0 * small.max(0.01), "{small} {large}");
}
