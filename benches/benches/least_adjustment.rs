//! W4: the least adjustment `d = Fᵀ(F Fᵀ)⁻¹ b` of a cubic under `c` constraints, of `n` vertices: mouse down
//! (`prepare`) and mouse move (`event`), for our solvers, nalgebra and faer.
//!
//! Aims: prepare within 3 × the floor, an event within 2 ×, neither dependent on `n`. The floor factors a band whose order
//! and width are given, into memory that it has: no rank, no scale, no allocation. Measured (medians of three runs on two
//! shared cores at 2.5 GHz, n = 1000, in one run): prepare 53 ns / 0.12 µs / 0.87 µs for 1 / 10 / 100 constraints against
//! 6.6 ns / 45 ns / 0.44 µs, 8 × / 2.7 × / 2.0 ×; event 18 / 88 / 840 ns against 11 / 54 / 575 ns, 1.6 × / 1.6 × / 1.5 ×.
//! What bounds one to five constraints from below is the answer's own memory: itself, the places of its rows and their
//! numbers are three blocks, and asking for and giving back each costs 8 to 10 ns, more than a floor of 7 to 25 ns has
//! in all; one row is otherwise a square root and a division, as in the floor. (The numbers within the answer itself were
//! slower: it is moved once, and the moving waits for what was just written.) From ten constraints on the aims hold.
//! Peers keep dense matrices and are left out above a million numbers; they give the whole `n × 3` answer, because
//! they know no other.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BatchSize, BenchmarkId, Criterion};
use faer::linalg::solvers::Solve;
use loftsman_benches::floor::BandCholesky;
use loftsman_benches::inputs::{Rows, coil};
use loftsman_benches::measure::{self, Case};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::solve::{
    Adjoint, Automatic, HouseholderQr, Solver, Sparse, SparseRows, System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};
use nalgebra::DMatrix;

const SIZES: [usize; 5] = [12, 100, 1000, 10_000, 1_000_000];
const CONSTRAINTS: [usize; 5] = [1, 2, 3, 10, 100];
/// Above this many vertices curves are not copied.
const ROUND: usize = 10_000;
/// The most numbers that a peer's dense matrix gets to have.
const DENSE: usize = 1_000_000;

const SOLVERS: [(&str, &dyn Solver); 4] = [
    ("automatic", &Automatic),
    ("adjoint", &Adjoint),
    ("sparse", &Sparse),
    ("householder-qr", &HouseholderQr),
];

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    CONSTRAINTS.into_iter().flat_map(|c| SIZES.into_iter().filter(move |&n| c < n).map(move |n| (n, c)))
}

fn name(n: usize, c: usize) -> String {
    format!("n={n},c={c}")
}

/// The rows over the columns that they touch.
fn system(rows: &Rows) -> System {
    let mut touched: Vec<usize> = rows.first.iter().flat_map(|&f| f..f + 4).collect();
    touched.sort_unstable();
    touched.dedup();
    let mut sparse = SparseRows::with_capacity(touched.len(), rows.count(), 4 * rows.count());
    for (&first, values) in rows.first.iter().zip(&rows.values) {
        let local = touched.partition_point(|&t| t < first);
        sparse.push(values.iter().enumerate().map(|(k, &v)| (local + k, v)));
    }
    System::new(sparse, touched, 3, SystemMetric::Least)
}

fn ours<M: Measurement>(criterion: &mut Criterion<M>) {
    for (n, c) in pairs() {
        let rows = Rows::new(n, c);
        let system = system(&rows);
        let wanted = rows.wanted(0).concat();
        let mut reference = vec![[0.0; 3]; n];
        let mut floor = BandCholesky::new(&rows);
        floor.factor(&rows);
        floor.solve(&rows, &rows.wanted(0), &mut reference);
        for (solver, factors) in SOLVERS {
            let Ok(mut factored) = factors.factor(&system) else { continue };
            let mut d = vec![0.0; 3 * system.touched().len()];
            factored.solve_into(&wanted, &mut d);
            let expected = system.touched().iter().flat_map(|&t| reference[t]);
            assert!(d.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{solver} {}", name(n, c));
            criterion
                .benchmark_group("W4 prepare")
                .bench_function(BenchmarkId::new(solver, name(n, c)), |b| {
                    b.iter(|| factors.factor(black_box(&system)))
                });
            criterion.benchmark_group("W4 event").bench_function(BenchmarkId::new(solver, name(n, c)), |b| {
                b.iter(|| {
                    factored.solve_into(black_box(&wanted), &mut d);
                    black_box(&mut d);
                });
            });
        }
    }
}

/// All constraints but the first, kept: positions and derivatives in turn.
fn asked(edit: Edit<Curve>, rows: &Rows, c: usize) -> Edit<Curve> {
    (1..c).fold(edit, |edit, k| match k % 2 {
        0 => edit.ask(position(rows.at[k]).keep()),
        _ => edit.ask(derivative(rows.at[k], 1).keep()),
    })
}

/// The whole way a user goes: `Edit::prepare` (constraints bound, stencils taken, rank found, targets checked) and
/// `Session::to_point`, a drag of the first constraint.
fn sessions<M: Measurement>(criterion: &mut Criterion<M>) {
    for (n, c) in pairs() {
        let rows = Rows::new(n, c);
        let space = Space::open(3, rows.knots.clone()).expect("the knots are in order");
        let net = coil(n).into_iter().map(Point::from).collect();
        let mut curve = Some(Curve::new(space, net).expect("as many as the space has"));
        let edit = |curve| asked(Edit::of(curve).handle(position(rows.at[0])), &rows, c);
        // `Edit::prepare` alone: curves are copied, edits said and sessions ended outside what is measured.
        if n <= ROUND {
            criterion.benchmark_group("W4 prepare").bench_function(
                BenchmarkId::new("mouse down", name(n, c)),
                |b| {
                    let said = || curve.clone().map(edit);
                    let prepare = |edit: Option<Edit<Curve>>| edit.map(|edit| edit.prepare(Automatic));
                    b.iter_batched(said, prepare, BatchSize::NumIterations(64));
                },
            );
        }
        // The curve goes round, so that it is not copied: committing is measured along.
        criterion.benchmark_group("W4 prepare").bench_function(
            BenchmarkId::new("session", name(n, c)),
            |b| {
                b.iter(|| {
                    let session = edit(curve.take()?).prepare(Automatic).ok()?;
                    curve = Some(session.commit().unwrap().into_shape());
                    Some(())
                });
            },
        );
        // One edit from beginning to end: prepared, solved, measured on the rounded vertices, reported.
        criterion.benchmark_group("W4 whole").bench_function(BenchmarkId::new("edit", name(n, c)), |b| {
            let mut x = 0.0;
            b.iter(|| {
                x += 1e-6;
                let moved = position(rows.at[0]).to(Point::new(x, 1.0, 0.0));
                let edit = Edit::of(curve.take()?).ask(moved);
                curve = Some(asked(edit, &rows, c).solve().ok()?.into_shape());
                Some(())
            });
        });
        let Some(mut session) = curve.and_then(|curve| edit(curve).prepare(Automatic).ok()) else {
            unreachable!("these constraints are independent")
        };
        criterion.benchmark_group("W4 event").bench_function(BenchmarkId::new("session", name(n, c)), |b| {
            let mut x = 0.0;
            b.iter(|| {
                x += 1e-6;
                black_box(session.to_point(Point::new(x, 1.0, 0.0)).is_ok())
            });
        });
    }
}

fn floor<M: Measurement>(criterion: &mut Criterion<M>) {
    for (n, c) in pairs() {
        let rows = Rows::new(n, c);
        let mut floor = BandCholesky::new(&rows);
        criterion.benchmark_group("W4 prepare").bench_function(BenchmarkId::new("floor", name(n, c)), |b| {
            b.iter(|| {
                floor.factor(black_box(&rows));
                black_box(&mut floor);
            });
        });
        let (wanted, mut d) = (rows.wanted(0), vec![[0.0; 3]; n]);
        criterion.benchmark_group("W4 event").bench_function(BenchmarkId::new("floor", name(n, c)), |b| {
            b.iter(|| {
                floor.solve(&rows, black_box(&wanted), &mut d);
                black_box(&mut d);
            });
        });
    }
}

fn peers<M: Measurement>(criterion: &mut Criterion<M>) {
    faer::set_global_parallelism(faer::Par::Seq);
    for (n, c) in pairs().filter(|(n, c)| n * c <= DENSE) {
        let rows = Rows::new(n, c);
        let case = name(n, c);
        let mut f = DMatrix::<f64>::zeros(c, n);
        for (k, values) in rows.values.iter().enumerate() {
            for (a, &value) in values.iter().enumerate() {
                f[(k, rows.first[k] + a)] = value;
            }
        }
        let b = DMatrix::from_row_slice(c, 3, &rows.wanted(0).concat());
        let ft = f.transpose();

        let mut prepare = criterion.benchmark_group("W4 prepare");
        prepare.bench_function(BenchmarkId::new("nalgebra Cholesky", &case), |t| {
            t.iter(|| (&f * &ft).cholesky())
        });
        prepare.bench_function(BenchmarkId::new("nalgebra QR", &case), |t| t.iter(|| ft.clone().qr()));
        let ff = faer::Mat::from_fn(c, n, |i, j| f[(i, j)]);
        let fft = ff.transpose().to_owned();
        let fb = faer::Mat::from_fn(c, 3, |i, j| b[(i, j)]);
        prepare.bench_function(BenchmarkId::new("faer LLT", &case), |t| {
            t.iter(|| (&ff * &fft).llt(faer::Side::Lower));
        });
        prepare.bench_function(BenchmarkId::new("faer QR", &case), |t| t.iter(|| fft.qr()));
        prepare.finish();

        let mut event = criterion.benchmark_group("W4 event");
        if let Some(cholesky) = (&f * &ft).cholesky() {
            event.bench_function(BenchmarkId::new("nalgebra Cholesky", &case), |t| {
                t.iter(|| &ft * cholesky.solve(black_box(&b)));
            });
        }
        let qr = ft.clone().qr();
        let (q, rt) = (qr.q(), qr.r().transpose());
        event.bench_function(BenchmarkId::new("nalgebra QR", &case), |t| {
            t.iter(|| rt.solve_lower_triangular(black_box(&b)).map(|y| &q * y));
        });
        if let Ok(llt) = (&ff * &fft).llt(faer::Side::Lower) {
            event.bench_function(BenchmarkId::new("faer LLT", &case), |t| {
                t.iter(|| &fft * llt.solve(black_box(&fb)));
            });
        }
        let qr = fft.qr();
        let (q, rt) = (qr.compute_thin_Q(), qr.thin_R().transpose().to_owned());
        event.bench_function(BenchmarkId::new("faer QR", &case), |t| {
            t.iter(|| {
                let mut y = black_box(&fb).clone();
                let (l, y_) = (rt.as_ref(), y.as_mut());
                faer::linalg::triangular_solve::solve_lower_triangular_in_place(l, y_, faer::Par::Seq);
                &q * &y
            });
        });
        event.finish();
    }
}

/// What a user waits for, beside what no session could do without (the aims: `Edit::prepare` at most 8 × the factorisation
/// for one constraint and 10 × for a hundred, an event at most 2 × `solve_into`), and one edit from beginning to end beside
/// OpenCASCADE's `MovePoint` where `peers/elsewhere.tsv` has its time (of another machine: ask both on one).
fn ratios() {
    let move_point = |n: usize| {
        let known = include_str!("../peers/elsewhere.tsv").lines().filter(|_| n == 10_000);
        let seconds = known.filter_map(|line| line.strip_prefix("W4 whole\tOCCT, MovePoint\t1\t")).next();
        seconds.and_then(|seconds| seconds.parse::<f64>().ok()).map(|seconds| 1e9 * seconds)
    };
    let rows = pairs().filter(|(n, c)| [12, 100, 10_000].contains(n) && [1, 10, 100].contains(c));
    let time = |t: Option<f64>| t.map_or("–".into(), measure::readable);
    let over =
        |a: Option<f64>, b: Option<f64>| a.zip(b).map_or("–".into(), |(a, b)| format!("{:.1}", a / b));
    let mut shown = false;
    for (n, c) in rows {
        let of = |group: &str, who: &str| measure::median(group, who, &name(n, c));
        let (factor, prepare) = (of("W4 prepare", "automatic"), of("W4 prepare", "mouse down"));
        let (solve, event) = (of("W4 event", "automatic"), of("W4 event", "session"));
        let whole = of("W4 whole", "edit");
        let peer = move_point(n).filter(|_| c == 1);
        if [factor, prepare, solve, event, whole].iter().all(Option::is_none) {
            continue;
        }
        if !std::mem::replace(&mut shown, true) {
            println!("\n## W4 a session beside its solver\n");
            println!(
                "| case | factor | prepare | prepare / factor | solve_into | to_point | to_point / solve_into | one edit | MovePoint |"
            );
            println!("|---|---|---|---|---|---|---|---|---|");
        }
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            name(n, c),
            time(factor),
            time(prepare),
            over(prepare, factor),
            time(solve),
            time(event),
            over(event, solve),
            time(whole),
            time(peer),
        );
    }
}

fn main() {
    let mut criterion = measure::criterion();
    floor(&mut criterion);
    ours(&mut criterion);
    sessions(&mut criterion);
    peers(&mut criterion);
    criterion.final_summary();
    let cases: Vec<Case> =
        pairs().map(|(n, c)| Case { name: name(n, c), size: n as f64, row: c.to_string() }).collect();
    let mine: Vec<&str> = SOLVERS.iter().map(|(name, _)| *name).collect();
    let mine = [&mine[..], &["session", "mouse down"]].concat();
    let contestants =
        [&["floor"], &mine[..], &["nalgebra Cholesky", "nalgebra QR", "faer LLT", "faer QR"]].concat();
    for group in ["W4 prepare", "W4 event"] {
        measure::summary(group, &contestants, "automatic", &mine, &cases);
    }
    measure::summary("W4 whole", &["edit"], "edit", &["edit"], &cases);
    ratios();
}
