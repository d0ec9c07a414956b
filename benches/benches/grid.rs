//! W2: a grid of points with unit normals on a rational bicubic surface of 50 × 50 vertices, and pairs of parameters.
//!
//! Aim: a third of the time of SISL's own grid evaluator (C; not in this run, see `docs/performance.md`), one thread.
//! "store" is what writing the answer to memory costs, the floor is a plain program for just this input.
//! "loftsman, pairs" gives each pair of parameters, as if the grid were not known to be one; "loftsman, one by one" asks
//! for a point and its derivatives at a time, as the peers do.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion, Throughput};
use curvo::prelude::NurbsSurface3D;
use loftsman_benches::floor;
use loftsman_benches::inputs::{knots, parameters, sheet};
use loftsman_benches::measure::{self, Case};
use loftsman_kernel::spline::batch::OrientedPoint;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Point4;
use truck_geometry::prelude::{BSplineSurface, KnotVec, NurbsSurface, ParametricSurface3D, Vector4};

const VERTICES: usize = 50;
const SIZES: [usize; 3] = [100, 300, 1000];
/// truck takes half a second for a hundred by a hundred.
const PATIENCE: usize = 100;

fn bench<M: Measurement>(criterion: &mut Criterion<M>) {
    let (u, v, net) = (knots(VERTICES, 3, 2), knots(VERTICES, 3, 3), sheet(VERTICES));
    let space = |t: &[f64]| Space::open(3, t.to_vec()).expect("the knots are in order");
    let points = net.iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
    let surface = Surface::rational(space(&u), space(&v), points, net.iter().map(|p| p[3]).collect())
        .expect("as many vertices as the spaces have");
    let rows = || net.chunks_exact(VERTICES);
    let curvo: NurbsSurface3D<f64> = NurbsSurface3D::new(
        3,
        3,
        u.clone(),
        v.clone(),
        rows()
            .map(|row| row.iter().map(|p| Point4::new(p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3])).collect())
            .collect(),
    );
    let truck = NurbsSurface::new(BSplineSurface::new(
        (KnotVec::from(u.clone()), KnotVec::from(v.clone())),
        rows()
            .map(|row| {
                row.iter().map(|p| Vector4::new(p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3])).collect()
            })
            .collect(),
    ));

    let mut group = criterion.benchmark_group("W2 grid");
    for size in SIZES {
        let at = parameters(size);
        let id = |name: &str| BenchmarkId::new(name, size);
        group.throughput(Throughput::Elements((size * size) as u64));
        let mut plain = vec![[[0.0; 3]; 2]; size * size];
        group
            .bench_function(id("store"), |b| b.iter(|| black_box(&mut plain).fill(black_box([[1.0; 3]; 2]))));
        group.bench_function(id("floor"), |b| {
            b.iter(|| floor::grid(&u, &v, &net, black_box(&at), &mut plain));
        });
        floor::grid(&u, &v, &net, &at, &mut plain);
        let mut ours = vec![OrientedPoint::ZERO; size * size];
        group.bench_function(id("loftsman"), |b| {
            b.iter(|| black_box(surface.grid_oriented_into(black_box(&at), &at, &mut ours).is_ok()));
        });
        surface.grid_oriented_into(&at, &at, &mut ours).expect("parameters of the domain");
        let far = |(a, b): (&OrientedPoint, &[[f64; 3]; 2])| {
            (a.point - Point::from(b[0])).amax().max((a.normal - Vector::from(b[1])).amax())
        };
        assert!(ours.iter().zip(&plain).map(far).all(|d| d < 1e-10), "the same points and normals");
        let pairs: Vec<(f64, f64)> = at.iter().flat_map(|&u| at.iter().map(move |&v| (u, v))).collect();
        group.bench_function(id("loftsman, pairs"), |b| {
            b.iter(|| black_box(surface.oriented_into(black_box(&pairs), &mut ours).is_ok()));
        });
        group.bench_function(id("loftsman, one by one"), |b| {
            b.iter(|| {
                let mut jet = [Vector::zeros(); 4];
                for (out, &(u, v)) in ours.iter_mut().zip(&pairs) {
                    black_box(surface.derivatives_into(u, v, [1, 1], &mut jet).is_ok());
                    *out = OrientedPoint { point: jet[0].into(), normal: jet[2].cross(&jet[1]).normalize() };
                }
            });
        });
        group.bench_function(id("curvo"), |b| {
            b.iter(|| {
                let mut evaluator = curvo.evaluator();
                for (out, &(u, v)) in plain.iter_mut().zip(&pairs) {
                    let d = evaluator.rational_derivatives(u, v, 1);
                    let n = d[1][0].cross(&d[0][1]).normalize();
                    *out = [[d[0][0].x, d[0][0].y, d[0][0].z], [n.x, n.y, n.z]];
                }
            });
        });
        if size <= PATIENCE {
            group.bench_function(id("truck"), |b| {
                b.iter(|| {
                    for (out, &(u, v)) in plain.iter_mut().zip(&pairs) {
                        let (p, n) = (truck.subs(u, v), truck.normal(u, v));
                        *out = [[p.x, p.y, p.z], [n.x, n.y, n.z]];
                    }
                });
            });
        }
    }
    group.finish();
}

fn main() {
    let mut criterion = measure::criterion();
    bench(&mut criterion);
    criterion.final_summary();
    let case = |size: usize| Case { name: size.to_string(), size: (size * size) as f64, row: String::new() };
    let cases: Vec<Case> = SIZES.into_iter().map(case).collect();
    let contestants =
        ["store", "floor", "loftsman", "loftsman, pairs", "loftsman, one by one", "curvo", "truck"];
    let mine = ["store", "loftsman", "loftsman, pairs", "loftsman, one by one"];
    measure::summary("W2 grid", &contestants, "loftsman", &mine, &cases);
}
