//! A search is no worse than what can be had without one: least squares on even knots, and parameters left alone.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use std::f64::consts::{PI, TAU};

use crate::common::evaluator::extent;
use crate::common::families::Random;
use loftsman_fitting::{Fit, FittedCurve, LeastSquares, Parametrization, Target};
use loftsman_kernel::Point;
use loftsman_kernel::spline::Space;

const KINDS: [&str; 7] = ["helix", "sine", "arc", "spiral", "half a section", "wave over wave", "polynomial"];

/// Exact points of a smooth curve, the kind in turn and everything else drawn.
fn smooth(seed: u64) -> (&'static str, Vec<Point>) {
    let r = &mut Random::new(seed);
    let kind = (seed % KINDS.len() as u64) as usize;
    let (m, turns, rise) = (r.whole(80, 300), r.between(0.5, 3.0), r.between(0.0, 3.0));
    let (size, thick, bunched) = (r.between(0.1, 10.0), r.between(0.3, 1.0), r.whole(0, 1) == 1);
    let at = |t: f64| {
        let a = TAU * turns * t;
        match kind {
            0 => [a.cos(), a.sin(), rise * t],
            1 => [4.0 * t, thick * a.sin(), 0.0],
            2 => [(0.6 * a).cos(), (0.6 * a).sin(), 0.0],
            3 => [(0.2 + t) * a.cos(), (0.2 + t) * a.sin(), rise * t * t],
            4 => {
                let x = if bunched { 0.5 * (1.0 - (PI * t).cos()) } else { 0.02 + 0.98 * t };
                let root = 0.2969 * x.sqrt() - 0.1260 * x;
                [x, thick * (root - 0.3516 * x * x + 0.2843 * x.powi(3) - 0.1015 * x.powi(4)), 0.0]
            }
            5 => [4.0 * t, a.sin() + 0.2 * (1.9 * a).cos(), 0.1 * t * t],
            _ => [t, thick * t * t, rise * t.powi(5) - t.powi(4)],
        }
    };
    let points = (0..m).map(|i| Point::from(at(i as f64 / (m - 1) as f64)) * size);
    (KINDS[kind], points.collect())
}

/// Least squares with knots at even steps of the parameter, its ends free.
fn plain(points: &[Point], degree: usize, vertices: usize) -> f64 {
    let sites = Parametrization::ChordLength.parameters(points, false).unwrap();
    let spans = vertices - degree;
    let breaks: Vec<f64> = (0..=spans).map(|i| i as f64 / spans as f64).collect();
    let fit = LeastSquares::new(Space::clamped(degree, &breaks).unwrap());
    fit.curve(&sites, points).map_or(f64::INFINITY, |f| f.max_error)
}

fn count(fitted: &FittedCurve) -> usize {
    fitted.curve.points().len()
}

#[test]
fn the_helix_that_was_missed() {
    let at = |i: u32| TAU * 3.0 * f64::from(i) / 299.0;
    let points: Vec<Point> = (0..300).map(|i| Point::new(at(i).cos(), at(i).sin(), at(i) / 6.0)).collect();
    for (degree, most) in [(3, 43), (5, 25)] {
        for corrections in [0, 4] {
            let fit = |target| Fit { corrections, ..Fit::new(degree, target) }.curve(&points).unwrap();
            let free = fit(Target::Tolerance(1e-4));
            assert!(count(&free) <= most, "degree {degree}, {corrections}: {}", count(&free));
            let limited = fit(Target::AtMost { tolerance: 1e-4, vertices: most });
            assert!(limited.met && count(&limited) <= most);
            assert!(fit(Target::Vertices(most)).max_error <= 1e-4);
        }
    }
}

#[test]
fn a_tolerance_takes_no_more_vertices_than_even_knots() {
    let mut compared = 0;
    for seed in 0..84 {
        let (name, points) = smooth(seed);
        let mut r = Random::new(!seed);
        let degree = r.whole(2, 7);
        let tolerance = 10.0_f64.powf(r.between(-5.0, -2.5)) * extent(&points);
        let needed = (degree + 1..points.len() / 2).find(|&n| plain(&points, degree, n) <= tolerance);
        let Some(needed) = needed else { continue };
        let found = |corrections: usize| {
            let fit = Fit { corrections, ..Fit::new(degree, Target::Tolerance(tolerance)) };
            let fitted = fit.curve(&points).unwrap();
            assert!(fitted.met && fitted.max_error <= tolerance * (1.0 + 1e-9));
            count(&fitted)
        };
        let (with, without) = (found(4), found(0));
        let what = format!("{name} (seed {seed}), degree {degree}, {tolerance:e}");
        // The ends are kept, which plain least squares do not: that may take a vertex.
        assert!(with <= needed + 1 + needed / 20, "{what}: {with}, plain {needed}");
        assert!(with <= without, "{what}: {with}, without corrections {without}");
        compared += 1;
    }
    assert!(compared >= 70, "{compared}");
}

#[test]
fn a_given_number_comes_as_near_as_even_knots_and_corrections_never_harm() {
    for seed in 0..84 {
        let (name, points) = smooth(1000 + seed);
        let mut r = Random::new(!seed);
        let degree = r.whole(2, 7);
        let closed = name == "helix" && r.whole(0, 1) == 1;
        let vertices = r.whole(degree + 2, points.len() / 3);
        let what = format!("{name} (seed {seed}), degree {degree}, {vertices} vertices");
        let fit = |corrections: usize, target: Target| Fit {
            corrections,
            closed,
            keep_ends: seed % 2 == 0,
            ..Fit::new(degree, target)
        };
        let found =
            |corrections| fit(corrections, Target::Vertices(vertices)).curve(&points).unwrap().max_error;
        let without = found(0);
        for corrections in [1, 4] {
            let with = found(corrections);
            assert!(with <= without * (1.0 + 1e-9), "{what}: {with:e}, without corrections {without:e}");
        }
        if seed % 2 == 1 && !closed {
            let even = plain(&points, degree, vertices);
            assert!(without <= even * (1.0 + 1e-6) + 1e-14, "{what}: {without:e}, plain {even:e}");
        }
        // What is met unasked is met when it is asked for.
        let tolerance = without * (1.0 + 1e-6) + 1e-14 * extent(&points);
        for corrections in [0, 4] {
            let asked = fit(corrections, Target::AtMost { tolerance, vertices }).curve(&points).unwrap();
            assert!(asked.met && count(&asked) <= vertices, "{what}");
        }
    }
}
