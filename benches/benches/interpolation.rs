//! The cubic through 100 … 100,000 points: banded here, dense in curvo (truck-geometry has none).
//!
//! Aim: 1000 points in 0.3 ms, growing linearly. Measured: 0.26 ms on a shared machine, the floor 0.06 ms. Ours finds
//! rank and condition by orthogonal rotations and measures the curve that it hands out, some five times the work of the
//! floor, which eliminates without looking.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion};
use curvo::prelude::{Interpolation as _, NurbsCurve3D};
use loftsman_benches::floor;
use loftsman_benches::inputs::coil;
use loftsman_benches::measure::{self, Case};
use loftsman_fitting::Interpolation;
use loftsman_kernel::Point;
use nalgebra::Point3;

const SIZES: [usize; 4] = [100, 1000, 10_000, 100_000];
/// curvo solves a dense system: a second and more from here on.
const PATIENCE: usize = 1000;

fn bench<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group("interpolation");
    for size in SIZES {
        let id = |name: &str| BenchmarkId::new(name, size);
        let plain = coil(size);
        group.bench_function(id("floor"), |b| b.iter(|| floor::interpolate(black_box(&plain))));
        let points: Vec<Point> = plain.iter().map(|&p| Point::from(p)).collect();
        let interpolation = Interpolation::new(3);
        group.bench_function(id("loftsman"), |b| b.iter(|| interpolation.curve(black_box(&points))));
        let ours = interpolation.curve(&points).expect("distinct points can be interpolated").curve;
        let far = |(a, b): (&Point, &[f64; 3])| (a - Point::from(*b)).amax();
        assert!(
            ours.points().iter().zip(&floor::interpolate(&plain)).map(far).all(|d| d < 1e-9),
            "the same curve"
        );
        if size <= PATIENCE {
            let points: Vec<Point3<f64>> = plain.iter().map(|&p| Point3::from(p)).collect();
            group.bench_function(id("curvo"), |b| {
                b.iter(|| NurbsCurve3D::<f64>::interpolate(black_box(&points), 3).is_ok());
            });
        }
    }
    group.finish();
}

fn main() {
    let mut criterion = measure::criterion();
    bench(&mut criterion);
    criterion.final_summary();
    let case = |size: usize| Case { name: size.to_string(), size: size as f64, row: String::new() };
    let cases: Vec<Case> = SIZES.into_iter().map(case).collect();
    measure::summary("interpolation", &["floor", "loftsman", "curvo"], "loftsman", &["loftsman"], &cases);
}
