//! Fine tuning of a cubic with 12 … 10,000 control vertices: the exact product of α and the derivative with its integral, and the
//! whole of an exact tuning, whose ends stay by equations on α.
//!
//! Aim (W8): product and integral in a fifth of OpenCASCADE's time, which interpolates, as scipy does (`peers/fine_tuning.py` asks both),
//! growing linearly; an exact tuning of 1000 vertices in 2 ms.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion};
use loftsman_benches::inputs::{coil, knots, sequence};
use loftsman_benches::measure::{self, Case};
use loftsman_fine_tuning::{FineTune, alpha_of, derivative};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

const SIZES: [usize; 4] = [12, 100, 1000, 10_000];

fn bench<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group("fine-tuning");
    for size in SIZES {
        let points = coil(size).into_iter().map(Point::from).collect();
        let space = Space::open(3, knots(size, 3, 5)).expect("knots of a cubic");
        let curve = Curve::new(space, points).expect("a cubic");
        let values = sequence(7, size - 1).into_iter().map(|x| 0.9 + 0.2 * x).collect();
        let alpha = alpha_of(&curve, values).expect("as many values as the derivative has");
        let slope = derivative(&curve).expect("a polynomial cubic");
        group.bench_function(BenchmarkId::new("product and integral", size), |b| {
            b.iter(|| slope.times(black_box(&alpha)).and_then(|product| product.integral(Vector::zeros())));
        });
        let tune = FineTune::new(&curve, alpha.clone());
        let tuned = tune.solve().expect("α has freedom enough").into_curve();
        let end = curve.domain().1;
        let off = (tuned.point(end).expect("an end") - curve.point(end).expect("an end")).norm();
        assert!(off < 1e-10, "the end stays: {off}");
        group.bench_function(BenchmarkId::new("exact tuning", size), |b| b.iter(|| black_box(&tune).solve()));
    }
    group.finish();
}

fn main() {
    let mut criterion = measure::criterion();
    bench(&mut criterion);
    criterion.final_summary();
    let case = |size: usize| Case { name: size.to_string(), size: size as f64, row: String::new() };
    let cases: Vec<Case> = SIZES.into_iter().map(case).collect();
    let both = ["product and integral", "exact tuning"];
    let all = [both[0], "OpenCASCADE", "scipy", both[1]];
    measure::summary("fine-tuning", &all, both[0], &both, &cases);
    measure::summary("fine-tuning", &both[1..], both[1], &both, &cases);
}
