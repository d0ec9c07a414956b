//! W3 with trims: solids of NIST's test files as triangles, to a thousandth of the diagonal of their boxes.
//!
//! Aim: a third of OpenCASCADE's time at the same deviation. Ours bounds the deviation of every triangle beforehand, and the meshes are watertight;
//! OpenCASCADE's is sampled (`peers/solids.py`), and the coarsest of its settings counts that meets the tolerance.

use std::hint::black_box;
use std::path::Path;

use criterion::BenchmarkId;
use loftsman_benches::measure::{self, Case};
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Chord, Fineness, Format, Memory, ReadOptions, Tessellator};
use loftsman_kernel::scene::Geometry;
use loftsman_step::Step;
use loftsman_tessellation::Adaptive;

/// Files of tests/data/step, each of one solid.
const FILES: [&str; 3] = ["NIST_MBE_PMI_1", "NIST_MBE_PMI_3", "NIST_MBE_PMI_11"];

const GROUP: &str = "W3 solids";

fn solid(name: &str) -> Brep {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../tests/data/step/{name}.stp"));
    let bytes = std::fs::read(path).expect("a bundled file");
    let (scene, _) = Step.read(&Memory::new(name, bytes), &ReadOptions::default()).expect("it can be read");
    let found = scene.objects().iter().find_map(|object| match object.geometry() {
        Geometry::Brep(brep) => Some(brep.clone()),
        _ => None,
    });
    found.expect("a solid")
}

/// A thousandth of the diagonal of the box of the vertices.
fn tolerance(brep: &Brep) -> f64 {
    let points = brep.vertices();
    let first = points.first().copied().unwrap_or_default();
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    1e-3 * (high - low).norm()
}

fn main() {
    let mut criterion = measure::criterion();
    let mut qualities = Vec::new();
    let mut group = criterion.benchmark_group(GROUP);
    for name in FILES {
        let brep = solid(name);
        let chord = tolerance(&brep);
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: std::f64::consts::PI };
        let ours = Adaptive::default();
        group.bench_function(BenchmarkId::new("loftsman", name), |b| {
            b.iter(|| ours.measured_brep(black_box(&brep), black_box(&fineness)).is_ok());
        });
        let cut = ours.measured_brep(&brep, &fineness).expect("a solid that can be cut");
        assert!(cut.left_out.is_empty(), "{name}: all of its faces are there");
        qualities.push((name, cut.mesh.triangle_count(), cut.error / chord));
    }
    group.finish();
    criterion.final_summary();
    let case = |name: &str| Case { name: name.to_owned(), size: 1.0, row: String::new() };
    let cases: Vec<Case> = FILES.into_iter().map(case).collect();
    measure::summary(GROUP, &["loftsman", "OpenCASCADE"], "loftsman", &["loftsman"], &cases);
    println!("\n| loftsman | triangles | bound of the deviation, in tolerances |\n|---|---|---|");
    for (name, triangles, bound) in qualities {
        println!("| {name} | {triangles} | {bound:.3} |");
    }
}
