//! A step of a simulation, and a frame of it (an `advance` by 1/24 s, in as many steps as it takes): a rope that slides through rings, and a sheet on three places that slide and one that does not.
//!
//! Aims: 60 µs for 60 vertices and 14 rings, 15 ms for 100,000 and 20; 60 µs for the sheet of 7²; linear in the number of vertices. W6
//! asks in addition for three times the banded solve alone, which is the floor here: Cholesky factors of the mass matrix, forward and
//! back, for three axes. Peers (`peers/dynamics.py`): MuJoCo's cable, PyElastica.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BatchSize, BenchmarkId, Criterion};
use loftsman_benches::floor::Banded;
use loftsman_benches::measure::{self, Case};
use loftsman_dynamics::{Body, Scheme, Setup, Simulation, fixed, sliding};
use loftsman_kernel::Point;
use loftsman_kernel::solve::{EnvelopeCholesky, RangeSpace, Weight};
use loftsman_kernel::spline::{Curve, Space, Surface};

const ROPES: [(usize, u32); 5] = [(60, 14), (250, 20), (1000, 20), (10_000, 20), (100_000, 20)];
const FRAMES: [(usize, u32); 2] = [(60, 14), (250, 20)];
const SHEETS: [usize; 3] = [7, 25, 50];
/// What is solved alone: ropes, and patches of as many rows as columns.
const SOLVED: [usize; 3] = [50, 1000, 100_000];
const PATCHES: [usize; 2] = [50, 200];
/// How long a rope falls, in seconds, before it begins anew (which costs less than a hundredth of the steps until then): without damping it slides
/// faster and faster through its rings, in the end farther in a step of a given length than it may.
const FALL: f64 = 3.0;
const SCHEMES: [(&str, Scheme); 3] =
    [("epsilon", Scheme::Epsilon), ("exact", Scheme::Exact), ("implicit", Scheme::Implicit)];

/// A coiled rope of `n` control vertices through `rings` rings.
fn rope(n: usize, rings: u32, scheme: Scheme) -> Simulation {
    let at = |i: usize| {
        let (sin, cos) = (0.3 * i as f64).sin_cos();
        Point::new(cos, sin, 0.1 * i as f64)
    };
    let space = Space::clamped_uniform(3, n).expect("knots of a cubic");
    let curve = Curve::new(space, (0..n).map(at).collect()).expect("a cubic");
    let body = Body::new(&curve).mass(0.1).stiffness(50.0);
    let setup = Setup::new(body).gravity([0.0, 0.0, -9.81]).scheme(scheme);
    let between = (n as f64 - 8.0) / f64::from(rings);
    let hung = (0..rings).fold(setup, |setup, i| setup.hold(sliding(3.0 + between * f64::from(i))));
    hung.prepare().expect("a rope through rings")
}

/// A wavy sheet of `n × n` control vertices: three places slide, a corner is fixed.
fn sheet(n: usize, scheme: Scheme) -> Simulation {
    let space = Space::clamped_uniform(3, n).expect("knots of a cubic");
    let at = |k: usize| Point::new((k / n) as f64, (k % n) as f64, 0.1 * (k % 5) as f64);
    let surface = Surface::new(space.clone(), space, (0..n * n).map(at).collect()).expect("a bicubic");
    Setup::new(Body::new(&surface))
        .gravity([0.0, 0.0, -9.81])
        .scheme(scheme)
        .hold(fixed([0.0, 0.0]))
        .hold(sliding([1.0, 3.0]))
        .hold(sliding([3.0, 1.0]))
        .hold(sliding([2.5, 2.5]))
        .prepare()
        .expect("a sheet")
}

fn steps<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group("W6 rope, a step");
    for (n, rings) in ROPES {
        for (name, scheme) in SCHEMES {
            if scheme == Scheme::Implicit && n > 1000 {
                continue; // it would move what 20 rings of a rope of thousands hold for seconds
            }
            let mut simulation = rope(n, rings, scheme);
            let step = 0.5 * simulation.stable_step();
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| {
                    if simulation.time() > FALL {
                        simulation = rope(n, rings, scheme);
                    }
                    simulation.step(black_box(step)).expect("a stable step");
                });
            });
            // Steps of a given length do not follow the drift, as those of `advance` do.
            let missed = simulation.worst_error() / (0.1 * n as f64);
            assert!(missed < 1e-3, "{name} {n}: its rings hold: {missed}");
        }
        let mut solve = Banded::mass_of_uniform_cubic(n);
        group.bench_function(BenchmarkId::new("floor", n), |b| {
            b.iter_batched_ref(
                || vec![[1.0, 2.0, 3.0]; n],
                |values| solve.solve(black_box(values)),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
    let mut group = criterion.benchmark_group("W6 sheet, a step");
    for n in SHEETS {
        for (name, scheme) in SCHEMES {
            if scheme == Scheme::Implicit && n > 7 {
                continue;
            }
            let mut simulation = sheet(n, scheme);
            let step = 0.5 * simulation.stable_step();
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| simulation.step(black_box(step)).expect("a stable step"));
            });
        }
    }
    group.finish();
}

/// The Cholesky factor of the mass matrix of `n` uniform cubics, as it is far from the ends (which costs as much).
fn mass_of_uniform_cubic(n: usize) -> EnvelopeCholesky {
    let mass = [2416.0 / 5040.0, 1191.0 / 5040.0, 120.0 / 5040.0, 1.0 / 5040.0];
    let first = (0..n as u32).map(|i| i.saturating_sub(3)).collect();
    EnvelopeCholesky::factor(first, 1e-15, |i, j| mass[i - j]).expect("a mass matrix")
}

/// The solve with the mass matrix that a step makes, alone, for three axes: of a rope the band, of a sheet the product of two of them. Nothing is held.
fn solves<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group("W6 solve alone");
    let ropes = SOLVED.map(|n| (n, Weight::Vertices(mass_of_uniform_cubic(n))));
    let patches = PATCHES.map(|n| (n * n, Weight::Grid(mass_of_uniform_cubic(n), mass_of_uniform_cubic(n))));
    for (name, n, weight) in
        ropes.map(|(n, w)| ("rope", n, w)).into_iter().chain(patches.map(|(n, w)| ("patch", n, w)))
    {
        let mut space = RangeSpace::new([(weight, None)]);
        space.float(0, 0.0);
        space.factor();
        group.bench_function(BenchmarkId::new(name, n), |b| {
            b.iter_batched_ref(
                || [1.0, 2.0, 3.0].repeat(n),
                |values| space.solve(black_box(values), &[], &mut [], &mut []),
                BatchSize::LargeInput,
            );
        });
    }
    for n in SOLVED {
        let mut floor = Banded::mass_of_uniform_cubic(n);
        group.bench_function(BenchmarkId::new("floor", n), |b| {
            b.iter_batched_ref(
                || vec![[1.0, 2.0, 3.0]; n],
                |values| floor.solve(black_box(values)),
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

/// A frame of 1/24 s: explicit ones of hundreds of steps, which are taken again, shorter, where a constraint drifts. Of what has moved for a while.
fn frames<M: Measurement>(criterion: &mut Criterion<M>) {
    let frame = 1.0 / 24.0;
    let mut group = criterion.benchmark_group("W6 rope, a frame");
    for (n, rings) in FRAMES {
        for (name, scheme) in SCHEMES {
            let mut simulation = rope(n, rings, scheme);
            (0..5).for_each(|_| simulation.advance(frame).expect("a first frame"));
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| simulation.advance(black_box(frame)).expect("a frame"));
            });
            let missed = simulation.worst_error() / (0.1 * n as f64);
            assert!(missed < 1e-5, "{name} {n}: its rings hold: {missed}");
        }
    }
    group.finish();
    let mut group = criterion.benchmark_group("W6 sheet, a frame");
    for (name, scheme) in SCHEMES {
        let mut simulation = sheet(7, scheme);
        (0..5).for_each(|_| simulation.advance(frame).expect("a first frame"));
        group.bench_function(BenchmarkId::new(name, 7), |b| {
            b.iter(|| simulation.advance(black_box(frame)).expect("a frame"));
        });
    }
    group.finish();
}

fn main() {
    let mut criterion = measure::criterion();
    steps(&mut criterion);
    solves(&mut criterion);
    frames(&mut criterion);
    criterion.final_summary();
    let case =
        |size: usize, count: usize| Case { name: size.to_string(), size: count as f64, row: String::new() };
    let ropes: Vec<Case> = ROPES.into_iter().map(|(n, _)| case(n, n)).collect();
    let all = ["epsilon", "exact", "implicit", "MuJoCo cable", "PyElastica", "floor"];
    measure::summary("W6 rope, a step", &all, "epsilon", &["epsilon", "exact", "implicit"], &ropes);
    let frames: Vec<Case> = FRAMES.into_iter().map(|(n, _)| case(n, n)).collect();
    measure::summary("W6 rope, a frame", &all[..3], "epsilon", &all[..3], &frames);
    measure::summary("W6 sheet, a frame", &all[..3], "epsilon", &all[..3], &[case(7, 49)]);
    let solved: Vec<Case> = SOLVED.into_iter().map(|n| case(n, n)).collect();
    measure::summary("W6 solve alone", &["rope", "floor"], "rope", &["rope"], &solved);
    let patches: Vec<Case> = PATCHES.into_iter().map(|n| case(n * n, n * n)).collect();
    measure::summary("W6 solve alone", &["patch"], "patch", &["patch"], &patches);
    let sheets: Vec<Case> = SHEETS.into_iter().map(|n| case(n, n * n)).collect();
    measure::summary("W6 sheet, a step", &all[..3], "epsilon", &all[..3], &sheets);
}
