//! Files of other programs, with facts counted by someone else (`tests/data/step/SOURCES.md`).

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may stop at what should not be")]

use std::collections::BTreeSet;

use loftsman_kernel::brep::{Brep, SurfaceForm};
use loftsman_kernel::plugin::{Confidence, Format, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit, Up};
use loftsman_step::Step;

/// What is in a file.
struct Facts {
    file: &'static str,
    /// ADVANCED_FACE, B-spline surfaces, MANIFOLD_SOLID_BREP.
    counts: [usize; 3],
    /// Millimetres of its unit; 0 where it says none.
    unit: f64,
    /// How far, relative to the size, edges may be off their faces: what the file itself is off.
    off: f64,
}

const fn facts(file: &'static str, counts: [usize; 3], unit: f64, off: f64) -> Facts {
    Facts { file, counts, unit, off }
}

const FILES: &[Facts] = &[
    facts("NIST_MBE_PMI_1.stp", [113, 57, 1], 1.0, 1e-6),
    facts("NIST_MBE_PMI_3.stp", [120, 58, 1], 25.4, 2e-6),
    facts("NIST_MBE_PMI_11.stp", [10, 8, 1], 1.0, 1e-6),
    facts("nacelle.stp", [6, 6, 0], 1.0, 1e-7),
    facts("face.stp", [1, 0, 0], 1.0, 1e-15),
    facts("revolved_sphere.step", [1, 0, 1], 1.0, 1e-15),
    facts("sliced_cylinder.step", [5, 0, 1], 10.0, 1e-6),
    facts("tet.step", [4, 0, 1], 10.0, 1e-15),
    facts("test_pipe.step", [6, 6, 0], 1.0, 1e-6),
    facts("as1-oc-214.stp", [53, 28, 5], 1.0, 1e-6),
    facts("dm1-id-214.stp", [24, 19, 3], 25.4, 1e-5),
    facts("io1-cm-214.stp", [29, 0, 1], 1.0, 1e-6),
    facts("MAINBODY_FRONT.stp", [22, 6, 1], 25.4, 3e-5),
    facts("featuretype.STEP", [96, 1, 1], 25.4, 1e-6),
    facts("base_interface_AP203.STEP", [30, 0, 1], 25.4, 1e-6),
    facts("base_interface_AP214.STEP", [30, 0, 1], 25.4, 1e-6),
    facts("red_cube_blue_cylinder.step", [9, 0, 2], 1000.0, 1e-6),
];

/// Files that are too large to go along; they are looked at where they are beside the project.
const LARGE: &[Facts] = &[
    facts("NIST_MBE_PMI_2.stp", [597, 460, 1], 1.0, 1e-5),
    facts("IEA_15MW_CFD.stp", [3, 3, 0], 1.0, 1e-4),
    facts("boxed_sphere.step", [192, 42, 2], 10.0, 1e-2),
];

fn data(name: &str) -> Option<Vec<u8>> {
    let root = env!("CARGO_MANIFEST_DIR");
    let places = ["../../tests/data/step", "../../../shared/data/step"];
    places.iter().find_map(|place| std::fs::read(format!("{root}/{place}/{name}")).ok())
}

fn read(name: &str, bytes: &[u8]) -> (Scene, ReadReport) {
    assert_eq!(Step.confidence(&bytes[..bytes.len().min(4096)]), Confidence::Sure, "{name}");
    let (scene, report) = Step.read(&Memory::new(name, bytes), &ReadOptions::default()).unwrap();
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

fn size(brep: &Brep) -> f64 {
    let first = brep.points()[0];
    let (low, high) = brep.points().iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// How many entities of a type a text has.
fn count(bytes: &[u8], kind: &str) -> usize {
    let text = String::from_utf8_lossy(bytes);
    text.match_indices(kind)
        .filter(|(at, _)| {
            let before = text[..*at].chars().next_back();
            let after = text[at + kind.len()..].trim_start().chars().next();
            before.is_some_and(|c| c == '=' || c == ' ') && after == Some('(')
        })
        .count()
}

fn check(facts: &Facts, bytes: &[u8]) {
    let name = facts.file;
    let (scene, report) = read(name, bytes);
    let entities = String::from_utf8_lossy(bytes);
    let entities = entities.lines().filter(|line| line.trim_start().starts_with('#')).count();
    assert!(
        report.entities <= entities && report.entities * 10 > entities * 9,
        "{name}: {}",
        report.entities
    );
    if facts.unit > 0.0 {
        let unit = scene.unit.metres().unwrap() * 1e3;
        assert!((unit - facts.unit).abs() < 1e-12 * facts.unit, "{name}: {unit}");
    }
    let [faces, splines, solids] = facts.counts;
    assert_eq!(count(bytes, "ADVANCED_FACE"), faces, "{name}");
    let at_fault = report.left_out.keys().filter(|why| why.starts_with('#')).count();
    assert_eq!(at_fault, 0, "{name}: {report:?}");
    assert_eq!(breps(&scene).map(Brep::face_count).sum::<usize>(), faces, "{name}");
    assert_eq!(breps(&scene).map(|brep| brep.solids().len()).sum::<usize>(), solids, "{name}");
    // Of the faces without another form those on swept surfaces are no splines in the file, and those without knots were not
    // counted as such.
    let others = ["SURFACE_OF_REVOLUTION", "SURFACE_OF_LINEAR_EXTRUSION", "QUASI_UNIFORM_SURFACE"];
    let swept: usize = others.iter().map(|kind| count(bytes, kind)).sum();
    let plain = breps(&scene)
        .flat_map(|brep| (0..brep.face_count()).map(|face| brep.surface_form(face)))
        .filter(|form| *form == SurfaceForm::Spline)
        .count();
    assert!((splines..=splines + swept).contains(&plain), "{name}: {plain} of {splines} and {swept}");
    let mut worst = 0.0_f64;
    for brep in breps(&scene) {
        let size = size(brep);
        let flaws = brep.flaws(facts.off * size).unwrap();
        assert!(flaws.is_empty(), "{name}: {}", flaws[0]);
        let off = brep.flaws(0.0).unwrap().iter().map(|flaw| flaw.distance() / size).fold(0.0, f64::max);
        worst = worst.max(off);
    }
    println!("{name}: edges at most {worst:.1e} of the size off, beyond their tolerance");
}

#[test]
fn files_have_the_counted_faces_surfaces_and_solids() {
    for facts in FILES {
        check(facts, &data(facts.file).unwrap());
    }
    assert!(FILES.len() >= 17);
    for facts in LARGE {
        match data(facts.file) {
            Some(bytes) => check(facts, &bytes),
            None => println!("not looked at, as it is not here: {}", facts.file),
        }
    }
}

#[test]
fn what_is_used_twice_is_there_once() {
    let (scene, report) = read("as1-oc-214.stp", &data("as1-oc-214.stp").unwrap());
    let names: Vec<_> = scene.objects().iter().map(|o| (o.name(), o.geometry().kind())).collect();
    assert_eq!(
        names,
        [
            ("as1", "group"),
            ("rod-assembly", "group"),
            ("nut_1", "instance"),
            ("nut_2", "instance"),
            ("rod", "brep"),
            ("l-bracket-assembly_1", "instance"),
            ("plate", "brep"),
            ("l-bracket-assembly_2", "instance"),
        ]
    );
    let definitions: BTreeSet<_> = scene.definitions().iter().map(|d| d.name()).collect();
    // A bolt is in one other product only, however often that is shown.
    let used = ["l-bracket-assembly", "nut", "nut-bolt-assembly"];
    assert_eq!(definitions, used.into_iter().collect());
    // Two brackets of three bolts with nuts, two nuts on the rod, the rod and the plate.
    let shown = scene.placed(1000).unwrap().filter(|p| matches!(p.object.geometry(), Geometry::Brep(_)));
    assert_eq!(shown.count(), 2 * (1 + 3 * 2) + 2 + 2);
    let rod = scene.object("rod").unwrap();
    assert_eq!((rod.layer.as_deref(), rod.parent.as_deref()), (Some("256"), Some("rod-assembly")));
    let [r, g, b, a] = rod.color.unwrap();
    assert!((r - 1.0).abs() < 1e-12 && g < 0.22 && b == 0.0 && a == 1.0);
    assert!(report.notes[0].contains("Open CASCADE 6.1"), "{:?}", report.notes);
    assert!(report.left_out["parameter curves are computed anew"] > 1000);
    // Parts touch: the nuts are where the rod ends.
    let nut = scene.placed(1000).unwrap().find(|p| p.object.name() == "nut").unwrap();
    let map = nut.to_world.unwrap();
    assert!(map != nalgebra::Matrix4::identity());
}

#[test]
fn colours_of_faces_and_names_are_kept() {
    let (scene, _) = read("red_cube_blue_cylinder.step", &data("red_cube_blue_cylinder.step").unwrap());
    assert_eq!(scene.unit, Unit::Metre);
    for (name, color) in [("red_cube", 0), ("blue_cylinder", 2)] {
        let Geometry::Brep(brep) = scene.object(name).unwrap().geometry() else { unreachable!() };
        for face in 0..brep.face_count() {
            let found = brep.face_color(face).unwrap();
            assert!((0..3).all(|k| k == color || found[k] < found[color]), "{name} {face}: {found:?}");
        }
    }
}

#[test]
fn a_whole_sphere_is_one_face_around_its_pole() {
    let (scene, _) = read("revolved_sphere.step", &data("revolved_sphere.step").unwrap());
    let brep = breps(&scene).next().unwrap();
    assert_eq!((brep.face_count(), brep.edge_count(), brep.vertices().len()), (1, 0, 1));
    assert_eq!((brep.solids().len(), brep.lone_vertices(0)), (1, &[0][..]));
    assert!(matches!(brep.surface_form(0), SurfaceForm::Sphere { radius: 5.0, .. }));
}

/// Of the faces of a tetrahedron one has its bound the wrong way round, as OpenCASCADE writes some of its tori: all others say how it runs.
#[test]
fn a_bound_that_runs_against_all_neighbours_is_turned_and_told() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/step/tet.step");
    let text = std::fs::read_to_string(path).unwrap();
    let read = |text: String| {
        let (scene, report) =
            Step.read(&Memory::new("tet.step", text.into_bytes()), &ReadOptions::default()).unwrap();
        let mut breps = scene.objects().iter().filter_map(|object| match object.geometry() {
            Geometry::Brep(brep) => Some(brep.clone()),
            _ => None,
        });
        (breps.next_back().unwrap(), report.notes.join("\n"))
    };
    // A loop starts elsewhere, or runs through the same edges the same way.
    let uses = |brep: &Brep| -> BTreeSet<(usize, usize, bool)> {
        (0..4)
            .flat_map(|face| brep.loops(face).iter().flatten().map(move |one| (face, one.edge, one.reversed)))
            .collect()
    };
    let (right, notes) = read(text.clone());
    assert!(!notes.contains("turned round"), "{notes}");
    for bound in ["#18=FACE_OUTER_BOUND('',#22,", "#20=FACE_OUTER_BOUND('',#24,"] {
        let wrong = text.replace(&format!("{bound}.T.)"), &format!("{bound}.F.)"));
        assert_ne!(wrong, text);
        let (brep, notes) = read(wrong);
        assert_eq!((brep.solids().len(), brep.is_closed(&[0, 1, 2, 3])), (1, true), "{notes}");
        assert!(notes.contains("run against those of the faces around it: they are turned round"), "{notes}");
        assert_eq!(uses(&brep), uses(&right));
    }
    // So are two side by side: a plane says which way its outer bound runs.
    let both = text
        .replace("#18=FACE_OUTER_BOUND('',#22,.T.)", "#18=FACE_OUTER_BOUND('',#22,.F.)")
        .replace("#19=FACE_OUTER_BOUND('',#23,.T.)", "#19=FACE_OUTER_BOUND('',#23,.F.)");
    let (brep, notes) = read(both);
    assert_eq!(notes.matches("turned round").count(), 2, "{notes}");
    assert_eq!((brep.solids().len(), uses(&brep)), (1, uses(&right)));
}

/// The edges of a Brep's faces, and which way they run.
type Uses = BTreeSet<(usize, usize, bool)>;

/// Up to four bounds of a file are the wrong way round, side by side, and of faces with several only some: where those that are right are many more all are
/// turned back.
#[test]
fn whichever_bounds_run_the_wrong_way_they_are_turned() {
    let (mut tried, mut turned) = (0, 0);
    for name in ["sliced_cylinder.step", "io1-cm-214.stp", "base_interface_AP203.STEP", "dm1-id-214.stp"] {
        let text = String::from_utf8(data(name).unwrap()).unwrap();
        let uses = |text: &str| -> (Vec<Uses>, usize, String) {
            let (scene, report) = read(name, text.as_bytes());
            let of = |brep: &Brep| {
                let uses = |face: usize| {
                    let uses = brep.loops(face).iter().flatten();
                    uses.map(move |one| (face, one.edge, one.reversed)).collect::<Vec<_>>()
                };
                (0..brep.face_count()).flat_map(uses).collect()
            };
            let solids = breps(&scene).map(|brep| brep.solids().len()).sum();
            (breps(&scene).map(of).collect(), solids, report.notes.join("\n"))
        };
        let (right, solids, _) = uses(&text);
        assert!(solids > 0);
        let places: Vec<usize> = text.match_indices("BOUND").map(|(at, _)| at).collect();
        // The whole of a small part of a solid may be wrong: what hangs together by itself says so by its planes.
        for (first, count) in (0..12).map(|k| (k % places.len(), k % (places.len() / 4).min(4) + 1)) {
            let mut wrong = text.clone();
            for &at in places.iter().skip(first).take(count) {
                let end = at + wrong[at..].find(';').unwrap();
                let flag = wrong[..end].rfind(".T.").unwrap();
                wrong.replace_range(flag..flag + 3, ".F.");
            }
            assert_ne!(wrong, text);
            let (found, closed, notes) = uses(&wrong);
            tried += 1;
            // Of few that only have to do with each other nobody can say which are wrong.
            if closed == solids {
                assert_eq!(found, right, "{name} {first} {count}: {notes}");
                turned += 1;
            } else {
                assert!(notes.contains("its shell does not close"), "{name} {first} {count}: {notes}");
            }
        }
    }
    println!("{turned} of {tried}");
    assert!(tried == 48 && turned >= 40, "{turned} of {tried}");
}

/// The length of a direction says nothing, and its square need not be a number.
#[test]
fn directions_may_be_of_any_length() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/step/tet.step");
    let text = std::fs::read_to_string(path).unwrap();
    let read = |text: String| Step.read(&Memory::new("tet.step", text.into_bytes()), &ReadOptions::default());
    let (scene, _) = read(text.clone()).unwrap();
    for length in ["1.E308", "1.E-300", "7."] {
        let long = text.replace("DIRECTION('',(0.,0.,1.))", &format!("DIRECTION('',(0.,0.,{length}))"));
        let long = long.replace("DIRECTION('',(1.,0.,0.))", &format!("DIRECTION('',({length},0.,0.))"));
        assert_ne!(long, text);
        let (found, _) = read(long).unwrap();
        let points = |scene: &Scene| -> Vec<loftsman_kernel::Point> {
            scene.objects().iter().flat_map(|o| o.geometry().points().to_vec()).collect()
        };
        let (a, b) = (points(&scene), points(&found));
        assert!(a.len() == b.len() && a.iter().zip(&b).all(|(p, q)| (p - q).norm() <= 1e-12), "{length}");
    }
}
