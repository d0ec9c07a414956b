//! W1: a million points, and points with first and second derivatives, on a cubic of 1000 vertices.
//!
//! Aims, one thread: a fifth of the best peer's time and 2.5 × the floor. The floor converts to one polynomial a span
//! beforehand and counts only Horner's rule; "store" is what writing the answer to memory costs. "loftsman" evaluates
//! in a batch, on one thread (spans found and expanded once, within the time; then Horner's rule on four parameters at
//! once); "loftsman, one by one" asks for one parameter at a time, as the peers do: what bounds it is the search for the
//! span and the recurrence, anew each time. For a million, memory bounds: storing the answer takes three quarters of the
//! time. For 10,000, ten a span, half of the time is the expansion of the spans.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion, Throughput};
use curvo::prelude::NurbsCurve3D;
use loftsman_benches::floor::SpanPolynomials;
use loftsman_benches::inputs::{coil, knots, parameters};
use loftsman_benches::measure::{self, Case};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use nalgebra::Point4;
use truck_geometry::prelude::{BSplineCurve, KnotVec, ParametricCurve, Point3};

const VERTICES: usize = 1000;
const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];
/// truck takes seconds for a million.
const PATIENCE: usize = 10_000;

fn bench<M: Measurement>(criterion: &mut Criterion<M>) {
    let (t, net) = (knots(VERTICES, 3, 1), coil(VERTICES));
    let floor = SpanPolynomials::new(&t, &net);
    let space = Space::open(3, t.clone()).expect("the knots are in order");
    let curve =
        Curve::new(space, net.iter().map(|&p| Point::from(p)).collect()).expect("as many as the space has");
    let homogeneous = net.iter().map(|p| Point4::new(p[0], p[1], p[2], 1.0)).collect();
    let curvo: NurbsCurve3D<f64> =
        NurbsCurve3D::try_new(3, homogeneous, t.clone()).expect("a curve for curvo too");
    let truck =
        BSplineCurve::new(KnotVec::from(t), net.iter().map(|p| Point3::new(p[0], p[1], p[2])).collect());

    for size in SIZES {
        let at = parameters(size);
        let id = |name: &str| BenchmarkId::new(name, size);
        let mut points = vec![[0.0; 3]; size];
        let mut reference = points.clone();
        floor.points(&at, &mut reference);

        let mut group = criterion.benchmark_group("W1 points");
        group.throughput(Throughput::Elements(size as u64));
        group.bench_function(id("store"), |b| b.iter(|| black_box(&mut points).fill(black_box([1.0; 3]))));
        group.bench_function(id("floor"), |b| b.iter(|| floor.points(black_box(&at), &mut points)));
        let mut ours = vec![Point::origin(); size];
        group.bench_function(id("loftsman, one by one"), |b| {
            b.iter(|| {
                for (out, &u) in ours.iter_mut().zip(&at) {
                    *out = curve.point(u).unwrap_or_default();
                }
            });
        });
        group.bench_function(id("loftsman"), |b| {
            b.iter(|| black_box(curve.points_into(black_box(&at), &mut ours).is_ok()));
        });
        let far = |(a, b): (&Point, &[f64; 3])| (a - Point::from(*b)).amax();
        assert!(ours.iter().zip(&reference).map(far).all(|d| d < 1e-12), "the same points");
        group.bench_function(id("curvo"), |b| {
            b.iter(|| {
                let mut evaluator = curvo.evaluator();
                for (out, &u) in points.iter_mut().zip(&at) {
                    let p = evaluator.point_at(u);
                    *out = [p.x, p.y, p.z];
                }
            });
        });
        if size <= PATIENCE {
            group.bench_function(id("truck"), |b| {
                b.iter(|| {
                    for (out, &u) in points.iter_mut().zip(&at) {
                        let p = truck.subs(u);
                        *out = [p.x, p.y, p.z];
                    }
                });
            });
        }
        group.finish();

        let mut jets = vec![[[0.0; 3]; 3]; size];
        let mut group = criterion.benchmark_group("W1 derivatives");
        group.throughput(Throughput::Elements(size as u64));
        group.bench_function(id("store"), |b| b.iter(|| black_box(&mut jets).fill(black_box([[1.0; 3]; 3]))));
        group.bench_function(id("floor"), |b| b.iter(|| floor.derivatives(black_box(&at), &mut jets)));
        let mut ours = vec![Vector::zeros(); 3 * size];
        group.bench_function(id("loftsman, one by one"), |b| {
            b.iter(|| {
                for (out, &u) in ours.chunks_exact_mut(3).zip(&at) {
                    black_box(curve.derivatives_into(u, out).is_ok());
                }
            });
        });
        group.bench_function(id("loftsman"), |b| {
            b.iter(|| black_box(curve.derivatives_many_into(black_box(&at), 3, &mut ours).is_ok()));
        });
        group.bench_function(id("curvo"), |b| {
            b.iter(|| {
                let mut evaluator = curvo.evaluator();
                for (out, &u) in jets.iter_mut().zip(&at) {
                    let d = evaluator.rational_derivatives(u, 2);
                    for k in 0..3 {
                        out[k] = [d[k].x, d[k].y, d[k].z];
                    }
                }
            });
        });
        if size <= PATIENCE {
            group.bench_function(id("truck"), |b| {
                b.iter(|| {
                    for (out, &u) in jets.iter_mut().zip(&at) {
                        let (p, d, e) = (truck.subs(u), truck.der(u), truck.der2(u));
                        *out = [[p.x, p.y, p.z], [d.x, d.y, d.z], [e.x, e.y, e.z]];
                    }
                });
            });
        }
        group.finish();
    }
}

fn main() {
    let mut criterion = measure::criterion();
    bench(&mut criterion);
    criterion.final_summary();
    let case = |size: usize| Case { name: size.to_string(), size: size as f64, row: String::new() };
    let cases: Vec<Case> = SIZES.into_iter().map(case).collect();
    let contestants = ["store", "floor", "loftsman", "loftsman, one by one", "curvo", "truck"];
    for group in ["W1 points", "W1 derivatives"] {
        measure::summary(
            group,
            &contestants,
            "loftsman",
            &["store", "loftsman", "loftsman, one by one"],
            &cases,
        );
    }
}
