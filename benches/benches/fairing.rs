//! What does a fair shape cost, from the shape to the report?
//!
//! `fair curve`: a clamped cubic of `n` control vertices on uneven knots, its bending least while sixteen of its points stay.
//! `fair surface`: a clamped bicubic of `n × n`, its thin-plate energy least while sixteen points stay.
//!
//! The curve's preconditioner is a band, so that everything is linear in `n`. The surface's is an envelope as wide as the net has
//! columns: `n³` numbers and `n⁴` multiplications for `n²` vertices, its square. The aim is well under a second for 100 × 100: 0.50 s, the peer
//! 0.61 s; growth with the power 1.5 of the vertices from 25² on.
//!
//! The peer is scipy with the normal equations and the constraints in one sparse matrix, factored by SuperLU:
//! `peers/fairing.py`, run by hand in the same minutes; its lines read like the table that this prints. It squares the condition
//! number, which ours does not.

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion};
use loftsman_benches::inputs::{coil, knots, sheet};
use loftsman_benches::measure::{Case, criterion, summary};
use loftsman_fairing::{Fair, bend};
use loftsman_kernel::Point;
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::{Curve, Space, Surface};
use std::hint::black_box;

const CURVES: [usize; 3] = [100, 1000, 10_000];
const SURFACES: [usize; 3] = [25, 50, 100];

fn curve(n: usize) -> Curve {
    let points = coil(n).into_iter().map(Point::from).collect();
    Curve::new(Space::open(3, knots(n, 3, 5)).expect("the knots are in order"), points)
        .expect("as many as the space has")
}

fn surface(n: usize) -> Surface {
    let points = sheet(n).into_iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
    let space = Space::open(3, knots(n, 3, 5)).expect("the knots are in order");
    Surface::new(space.clone(), space, points).expect("as many as the spaces have")
}

fn fair_curve(curve: &Curve) -> f64 {
    let mut fair = Fair::new(curve).energy(bend());
    for k in 0..16 {
        fair = fair.ask(position((f64::from(k) + 0.5) / 16.0).keep());
    }
    fair.solve().expect("there is a fairest").report().energy_after
}

fn fair_surface(surface: &Surface) -> f64 {
    let mut fair = Fair::new(surface).energy(bend());
    for k in 0..16 {
        let at = [f64::from(k / 4) / 4.0 + 0.125, f64::from(k % 4) / 4.0 + 0.125];
        fair = fair.ask(position(at).keep());
    }
    fair.solve().expect("there is a fairest").report().energy_after
}

fn bench<M: Measurement>(criterion: &mut Criterion<M>) {
    for n in CURVES {
        let curve = curve(n);
        println!("curve of {n}: energy {:.9e}", fair_curve(&curve));
        let mut group = criterion.benchmark_group("fair curve");
        group.bench_function(BenchmarkId::new("loftsman", n), |b| b.iter(|| fair_curve(black_box(&curve))));
    }
    for n in SURFACES {
        let surface = surface(n);
        println!("surface of {n} x {n}: energy {:.9e}", fair_surface(&surface));
        let mut group = criterion.benchmark_group("fair surface");
        group.bench_function(BenchmarkId::new("loftsman", n), |b| {
            b.iter(|| fair_surface(black_box(&surface)))
        });
    }
}

fn main() {
    let mut criterion = criterion();
    bench(&mut criterion);
    criterion.final_summary();
    for (group, sizes, power) in [("fair curve", CURVES, 1), ("fair surface", SURFACES, 2)] {
        let case = |n: &usize| Case { name: n.to_string(), size: (n.pow(power)) as f64, row: String::new() };
        let cases: Vec<Case> = sizes.iter().map(case).collect();
        summary(group, &["loftsman"], "loftsman", &["loftsman"], &cases);
    }
}
