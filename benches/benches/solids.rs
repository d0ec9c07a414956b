//! W3 with trims: solids of NIST's test files as triangles, to a thousandth of the diagonal of their boxes.
//!
//! Aim: a third of OpenCASCADE's time at the same deviation. Ours bounds the deviation of every triangle beforehand, and the meshes are watertight;
//! OpenCASCADE's is sampled (`peers/solids.py`), and the coarsest of its settings counts that meets the tolerance.

use std::hint::black_box;

use criterion::BenchmarkId;
use loftsman_benches::measure::{self, Case};
use loftsman_benches::shapes::{SOLIDS, read, repeated, solid, tolerance};
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_tessellation::Adaptive;

const GROUP: &str = "W3 solids";

/// Reading of a file that holds the first solid so many times: 0.27, 3.2 and 27 MB. Aim: 3 MB in 0.15 s, and linear.
const READING: &str = "STEP read";
const TIMES: [usize; 3] = [1, 12, 100];

fn main() {
    let mut criterion = measure::criterion();
    let mut qualities = Vec::new();
    let mut group = criterion.benchmark_group(GROUP);
    for name in SOLIDS {
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
    let mut group = criterion.benchmark_group(READING);
    for times in TIMES {
        let bytes = repeated(SOLIDS[0], times);
        assert_eq!(read(bytes.clone()).objects().len(), times, "as many solids");
        group.bench_function(BenchmarkId::new("loftsman", times), |b| {
            b.iter(|| read(black_box(bytes.clone())));
        });
    }
    group.finish();
    criterion.final_summary();
    let case = |name: &str| Case { name: name.to_owned(), size: 1.0, row: String::new() };
    let cases: Vec<Case> = SOLIDS.into_iter().map(case).collect();
    measure::summary(GROUP, &["loftsman", "OpenCASCADE"], "loftsman", &["loftsman"], &cases);
    let size = |times: usize| repeated(SOLIDS[0], times).len() as f64 / 1e6;
    let case = |times: usize| Case { name: times.to_string(), size: size(times), row: String::new() };
    let cases: Vec<Case> = TIMES.into_iter().map(case).collect();
    measure::summary(READING, &["loftsman", "OpenCASCADE"], "loftsman", &["loftsman"], &cases);
    println!("\n| loftsman | triangles | bound of the deviation, in tolerances |\n|---|---|---|");
    for (name, triangles, bound) in qualities {
        println!("| {name} | {triangles} | {bound:.3} |");
    }
}
