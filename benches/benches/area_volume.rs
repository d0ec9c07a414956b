//! W5: what do area and volume cost, once for a space and at every event?
//!
//! `area form`: the banded form of a periodic cubic with uneven knots. `volume`: value and gradient of a doubly periodic
//! bicubic. `area event`, `volume event`: a drag of one point by a hundredth of the size with the area (the volume) kept,
//! `n` control vertices (`n × n`), all axes together, from `Session::to_point`.
//!
//! The peer is numpy with the same Gauss rules, iteration and inputs: `benches/run.sh area_volume` runs `peers/area_volume.py`
//! first, which leaves its medians among criterion's, and then this, which prints both; without numpy the column is empty.

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion};
use loftsman_area_volume::{AreaForm, area, volume};
use loftsman_benches::inputs::sequence;
use loftsman_benches::measure::{Case, criterion, summary};
use loftsman_kernel::edit::{Ask, Edit, Session};
use loftsman_kernel::functional::{Functional, Shapes, Store, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use std::hint::black_box;

const CURVES: [usize; 3] = [1000, 10_000, 100_000];
const SURFACES: [usize; 3] = [20, 50, 100];

/// `n` spans of lengths `0.5 + u_k`, seed 5.
fn space(n: usize) -> Space {
    let mut at = 0.0;
    let mut knots = vec![0.0];
    knots.extend(sequence(5, n).into_iter().map(|u| {
        at += 0.5 + u;
        at
    }));
    Space::periodic(3, knots).expect("the knots are in order")
}

/// A wavy ring.
fn ring(n: usize) -> Curve {
    let at = |i: usize| {
        let a = std::f64::consts::TAU * i as f64 / n as f64;
        let r = 1.0 + 0.2 * (3.0 * a).sin();
        Point::new(r * a.cos(), r * a.sin(), 0.0)
    };
    Curve::new(space(n), (0..n).map(at).collect()).expect("as many as the space has")
}

/// A wobbly torus, `n × n` control vertices, uniform.
fn torus(n: usize) -> Surface {
    let at = |k: usize| {
        let turn = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let (a, b) = (turn(k / n), turn(k % n));
        let r = 0.4 + 0.05 * (3.0 * a + 2.0 * b).sin();
        Point::new((1.0 + r * b.cos()) * a.cos(), (1.0 + r * b.cos()) * a.sin(), r * b.sin())
    };
    let space = Space::periodic_uniform(3, n).expect("enough vertices");
    Surface::new(space.clone(), space, (0..n * n).map(at).collect()).expect("as many as the spaces have")
}

fn forms<M: Measurement>(criterion: &mut Criterion<M>) {
    for n in CURVES {
        let space = space(n);
        criterion
            .benchmark_group("W5 area form")
            .bench_function(BenchmarkId::new("loftsman", n), |b| b.iter(|| AreaForm::new(black_box(&space))));
    }
}

fn volumes<M: Measurement>(criterion: &mut Criterion<M>) {
    for n in SURFACES {
        let surface = torus(n);
        let shapes = Shapes::one(&surface);
        let Ok(Some(bound)) = volume().bind(&shapes) else { unreachable!("a torus is closed") };
        let (mut store, mut value) = (Store::default(), [0.0]);
        criterion.benchmark_group("W5 volume and gradient").bench_function(
            BenchmarkId::new("loftsman", n),
            |b| {
                b.iter(|| {
                    store.clear();
                    bound.linearize(black_box(&shapes), &mut store.rows(&shapes), &mut value)
                });
            },
        );
    }
}

/// The handle goes back and forth by a hundredth of the size.
fn drag<S: Shape, M: Measurement>(
    criterion: &mut Criterion<M>,
    group: &str,
    n: usize,
    mut session: Session<S>,
    from: Point,
) {
    criterion.benchmark_group(group).bench_function(BenchmarkId::new("loftsman", n), |b| {
        let mut k = 0_u32;
        b.iter(|| {
            k = (k + 1) % 16;
            let to = from + Vector::new(0.02 + 0.01 * f64::from(k.min(16 - k)), 0.01, 0.0);
            black_box(session.to_point(to).is_ok())
        });
    });
    assert!(session.to_point(from + Vector::new(0.1, 0.0, 0.0)).is_ok());
    println!("{group} {n}: {}", session.report());
}

fn events<M: Measurement>(criterion: &mut Criterion<M>) {
    for n in [100, 1000, 10_000] {
        let curve = ring(n);
        let (a, b) = curve.domain();
        let (at, held) = (a + 0.25 * (b - a), a + 0.75 * (b - a));
        let from = curve.point(at).expect("within the domain");
        let edit = Edit::of(curve).ask(area().keep()).ask(position(held).keep()).handle(position(at));
        let session = edit.prepare(Automatic).expect("it can be asked");
        drag(criterion, "W5 area event", n, session, from);
    }
    for n in SURFACES {
        let surface = torus(n);
        let at = [0.25 * n as f64, 0.25 * n as f64];
        let from = surface.point(at[0], at[1]).expect("within the domain");
        let edit = Edit::of(surface).ask(volume().keep()).handle(position(at));
        let session = edit.prepare(Automatic).expect("it can be asked");
        drag(criterion, "W5 volume event", n, session, from);
    }
}

fn main() {
    let mut criterion = criterion();
    forms(&mut criterion);
    volumes(&mut criterion);
    events(&mut criterion);
    criterion.final_summary();
    let cases = |sizes: &[usize], square: bool| -> Vec<Case> {
        let size = |n: usize| if square { (n * n) as f64 } else { n as f64 };
        sizes.iter().map(|&n| Case { name: n.to_string(), size: size(n), row: String::new() }).collect()
    };
    for (group, sizes, square) in [
        ("W5 area form", CURVES, false),
        ("W5 area event", [100, 1000, 10_000], false),
        ("W5 volume and gradient", SURFACES, true),
        ("W5 volume event", SURFACES, true),
    ] {
        summary(group, &["loftsman", "numpy"], "loftsman", &["loftsman"], &cases(&sizes, square));
    }
}
