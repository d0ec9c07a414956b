//! Whatever comes in: an answer that holds, or an error. Never a panic, never nonsense.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

mod common;

use std::cell::{Cell, RefCell};

use common::evaluator::{LONGEST, Spline, holds, length, polygon, size};
use loftsman_fitting::{Duplicates, Ends, Fit, FitError, GridFit, Interpolation, Parametrization, Target};
use loftsman_kernel::{Point, Vector};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestCaseError, TestRng, TestRunner};

/// Coordinates that coincide often, jump, vanish, and now and then are huge or no numbers at all.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-3_i32..4).prop_map(f64::from),
        8 => -1.0_f64..1.0,
        1 => Just(1e-300),
        1 => Just(1e300),
        1 => Just(-1.7e308),
        1 => Just(f64::MIN_POSITIVE / 1024.0),
    ]
}

fn points() -> impl Strategy<Value = Vec<Point>> {
    let point = (coordinate(), coordinate(), Just(0.0)).prop_map(|(x, y, z)| Point::new(x, y, z));
    let tame = ((-3_i32..4), (-3_i32..4)).prop_map(|(x, y)| Point::new(f64::from(x), f64::from(y), 0.0));
    prop_oneof![proptest::collection::vec(point, 0..40), proptest::collection::vec(tame, 0..40)]
}

/// Runs `test` on so many members, the same ones every time.
fn run<S: Strategy>(cases: u32, strategy: &S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    TestRunner::new_with_rng(config, rng).run(strategy, test).unwrap();
}

#[test]
fn fits_hold_what_they_say() {
    let counts = RefCell::new([[0_usize; 2]; TARGETS.len()]);
    let refused = RefCell::new(Vec::new());
    let all = (points(), 0_usize..28, any::<bool>(), 0_usize..4, any::<bool>(), 0_usize..3, any::<bool>());
    run(640, &all, |(points, degree, closed, way, smooth, corrections, best_effort)| {
        let target = match way {
            0 => Target::Relative(1e-2),
            1 => Target::Tolerance(1e-3),
            2 => Target::Vertices(points.len() / 2 + 1),
            _ => Target::AtMost { tolerance: 0.1, vertices: degree + 4 },
        };
        let fit = Fit { closed, smooth, corrections, best_effort, ..Fit::new(degree, target) };
        // What can be fitted at all: a known degree, and enough different places; where coordinates are beyond 1e307,
        // what a curve overshoots is no number.
        let places = 1 + points.windows(2).filter(|w| (w[1] - w[0]).amax() > 1e-6 * size(&points)).count();
        let possible = (1..=25).contains(&degree) && places > degree.max(3) && size(&points) < 1e307;
        let possible = possible
            && match target {
                // As many vertices as the degree needs, and no more than places.
                Target::Vertices(n) => (degree + 1).max(3) <= n && n <= places,
                // A tolerance that so many vertices can keep, or the best that they can.
                Target::AtMost { .. } => best_effort,
                _ => true,
            };
        counts.borrow_mut()[way][0] += usize::from(possible);
        let fitted = match fit.curve(&points) {
            Ok(fitted) => fitted,
            Err(error) => {
                if possible {
                    counts.borrow_mut()[way][1] += 1;
                    let kind =
                        format!("{target:?}, degree {degree}, closed {closed}, {} points", points.len());
                    refused.borrow_mut().push(format!("{kind}: {error}"));
                }
                return Ok(());
            }
        };
        prop_assert!(fitted.curve.points().iter().all(|p| p.iter().all(|c| c.is_finite())));
        prop_assert!(fitted.met || best_effort);
        match target {
            Target::Vertices(n) => prop_assert_eq!(fitted.curve.points().len(), n),
            Target::AtMost { vertices, .. } => prop_assert!(fitted.curve.points().len() <= vertices),
            _ => {}
        }
        holds(&fitted, &points, closed, "anything");
        Ok(())
    });
    // Most of what can be had is had, whatever is aimed at.
    let told = refused.into_inner().join("\n");
    let counts = counts.into_inner();
    println!("[possible, refused] of each target: {counts:?}\n{told}");
    for ((name, least, most), [asked, refused]) in TARGETS.into_iter().zip(counts) {
        assert!(asked >= least && refused <= most, "{name}: {refused} of {asked} refused:\n{told}");
    }
}

/// The targets; of how many members at least each can be had, and how many of those may be refused at most.
const TARGETS: [(&str, usize, usize); 4] =
    [("relative", 40, 1), ("tolerance", 40, 1), ("vertices", 28, 1), ("at most", 24, 5)];

#[test]
fn interpolations_interpolate() {
    let counts = [Cell::new(0), Cell::new(0), Cell::new(0)];
    let all = (points(), 0_usize..12, any::<bool>(), 0_u8..3, any::<bool>());
    run(256, &all, |(points, degree, closed, ends, centripetal)| {
        let through = Interpolation {
            degree,
            closed,
            parameters: if centripetal { Parametrization::Centripetal } else { Parametrization::ChordLength },
            ends: match ends {
                0 => Ends::Averaged,
                1 => Ends::NotAKnot,
                _ => Ends::Natural,
            },
            duplicates: Duplicates::Merge,
        };
        let through = match through.curve(&points) {
            Ok(through) => through,
            Err(FitError::Astray { .. }) => {
                counts[1].set(counts[1].get() + 1);
                return Ok(());
            }
            Err(_) => {
                counts[2].set(counts[2].get() + 1);
                return Ok(());
            }
        };
        counts[0].set(counts[0].get() + 1);
        let size = size(&points);
        let spline = Spline::of(&through.curve, size);
        let kept: Vec<Point> =
            points.iter().enumerate().filter(|(i, _)| !through.merged.contains(i)).map(|(_, p)| *p).collect();
        prop_assert_eq!(kept.len(), through.parameters.len());
        let worst = through
            .parameters
            .iter()
            .zip(&kept)
            .map(|(u, p)| (spline.at(*u) - p.coords / size).norm())
            .fold(0.0, f64::max);
        prop_assert!(worst < 1e-9, "{:e}", worst);
        prop_assert!((worst - through.residual / size).abs() < 1e-13);
        let line: Vec<Vector> = spline.samples(48).into_iter().map(|s| s.1).collect();
        prop_assert!(length(&line) <= LONGEST * polygon(&kept, closed, size) + 1e-9);
        Ok(())
    });
    let [done, astray, refused] = counts.map(Cell::into_inner);
    assert!(done >= 40 && astray <= 24 && refused <= 200, "{done} done, {astray} astray, {refused} refused");
}

#[test]
fn grids_answer() {
    let counts = [Cell::new(0), Cell::new(0)];
    let coordinates = proptest::collection::vec((-4_i32..5, -1.0_f64..1.0), 9..64);
    run(
        256,
        &(coordinates, 3_usize..7, 1_usize..5, any::<bool>(), any::<bool>()),
        |(all, columns, degree, closed, fewer)| {
            // A full grid that goes somewhere, with bumps.
            let rows = all.len() / columns;
            let grid: Vec<Point> = (0..rows * columns)
                .map(|k| {
                    Point::new(
                        (k / columns) as f64,
                        (k % columns) as f64 + 0.1 * all[k].1,
                        0.2 * f64::from(all[k].0),
                    )
                })
                .collect();
            let vertices = [fewer.then_some((degree + 1).max(3)), None];
            let fit = GridFit { closed: [closed, false], vertices, ..GridFit::new([degree, 2]) };
            let Ok(fitted) = fit.surface(columns, &grid) else {
                counts[1].set(counts[1].get() + 1);
                return Ok(());
            };
            counts[0].set(counts[0].get() + 1);
            // By de Boor's algorithm along u for every column of vertices, then along v.
            let (u, v) = (fitted.surface.u(), fitted.surface.v());
            let column =
                |j: usize| (0..u.len()).map(|i| fitted.surface.points()[i * v.len() + j].coords).collect();
            let columns_u: Vec<Spline> = (0..v.len()).map(|j| Spline::from_parts(u, column(j))).collect();
            let mut worst = 0.0_f64;
            for (i, at) in fitted.parameters[0].iter().enumerate() {
                let line = Spline::from_parts(v, columns_u.iter().map(|c| c.at(*at)).collect());
                for (j, b) in fitted.parameters[1].iter().enumerate() {
                    worst = worst.max((line.at(*b) - grid[i * columns + j].coords).norm());
                }
                let own = polygon(&grid[i * columns..(i + 1) * columns], false, 1.0);
                let long = length(&line.samples(32).into_iter().map(|s| s.1).collect::<Vec<_>>());
                prop_assert!(
                    long <= LONGEST * own + 8.0 * fitted.max_error + 1e-9,
                    "row {}: {} for {}",
                    i,
                    long,
                    own
                );
            }
            prop_assert!((worst - fitted.max_error).abs() <= 1e-12 + 1e-9 * worst);
            prop_assert!(fewer || worst < 1e-10, "{:e}", worst);
            Ok(())
        },
    );
    let [done, refused] = counts.map(Cell::into_inner);
    assert!(done >= 150 && refused <= 100, "{done} done, {refused} refused");
}
