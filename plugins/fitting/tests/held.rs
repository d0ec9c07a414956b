//! Constraints of a fit hold on the curve that is handed out, measured by the test's own evaluator, or the fit is refused.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use crate::common::evaluator::{Spline, size, spread};
use crate::common::families::{Random, member};
use loftsman_fitting::{Corners, Fit, FitError, Target};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::position;
use loftsman_kernel::{Point, Vector};

#[test]
fn positions_hold_on_the_curve_or_the_fit_is_refused() {
    let (mut fitted, mut conflicts, mut flung, mut missed, mut others) = (0, 0, 0, Vec::new(), Vec::new());
    for seed in 0..320 {
        let member = member(seed);
        let mut r = Random::new(seed + 7000);
        let degree = r.pick(&[1, 2, 3, 4, 5, 7]);
        let size = size(&member.points);
        let extent = spread(&member.points, size);
        // Some next to one another: nearly equal, nearly contradictory.
        let mut at: Vec<f64> = (0..r.whole(1, 4)).map(|_| r.between(0.05, 0.95)).collect();
        let pair = r.whole(0, 2) == 0;
        if pair {
            at.push((at[0] + 10.0_f64.powf(r.between(-13.0, -1.0))).min(0.99));
        }
        let aim = |u: f64, r: &mut Random| {
            let near = member.points[(u * (member.points.len() - 1) as f64) as usize].coords / size;
            near + Vector::new(r.normal(), r.normal(), 0.0) * (extent * r.pick(&[0.0, 1e-3, 0.1]))
        };
        let aims: Vec<(f64, Vector)> = at.iter().map(|&u| (u, aim(u, &mut r))).collect();
        let constraint = |(u, q): &(f64, Vector)| position(*u).to(<[f64; 3]>::from(q * size));
        let fit = Fit {
            closed: member.closed,
            best_effort: true,
            constraints: aims.iter().map(constraint).collect(),
            ..Fit::new(degree, Target::Relative(0.01))
        };
        let what = format!("seed {seed}, {}, degree {degree}, {aims:?}", member.kind);
        match fit.curve(&member.points) {
            Ok(found) => {
                fitted += 1;
                let spline = Spline::of(&found.curve, size);
                let vertices: f64 =
                    found.curve.points().iter().fold(1.0, |m: f64, p: &Point| m.max(p.coords.amax() / size));
                for (u, q) in &aims {
                    let off = (spline.at(*u) - q).amax();
                    assert!(off <= 1e-13 * vertices.min(1e6), "{what}: off by {off:e}");
                }
                assert!(found.kept.residuals.len() >= aims.len(), "{what}");
            }
            Err(FitError::Conflict { .. }) => conflicts += 1,
            // What pairs far apart for their distance in the parameter ask is far out.
            Err(FitError::Astray { .. } | FitError::IllConditioned { .. }) if pair => flung += 1,
            Err(error @ FitError::Missed { .. }) => missed.push(format!("{what}: {error}")),
            Err(error) => others.push(format!("{what}: {error}")),
        }
    }
    let counts = format!("{fitted} fitted, {conflicts} in conflict, {flung} flung");
    assert!(fitted > 220 && conflicts + flung > 10 && conflicts + flung < 80, "{counts}");
    assert!(missed.is_empty(), "{counts}, {} missed\n{missed:#?}", missed.len());
    assert!(others.len() <= 12, "{counts}, {} others\n{others:#?}", others.len());
}

#[test]
fn an_end_of_a_cornered_curve_goes_where_a_constraint_puts_it() {
    // An L, and a zigzag: corners inside, the ends asked elsewhere.
    let line = |corners: &[(f64, f64)]| -> Vec<Point> {
        let legs = corners.windows(2).flat_map(|w| {
            let at = move |k: i32| {
                let t = f64::from(k) / 8.0;
                Point::new(w[0].0 + t * (w[1].0 - w[0].0), w[0].1 + t * (w[1].1 - w[0].1), 0.0)
            };
            (0..8).map(at).collect::<Vec<_>>()
        });
        legs.chain(corners.last().map(|&(x, y)| Point::new(x, y, 0.0))).collect()
    };
    let shapes = [
        line(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]),
        line(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]),
    ];
    let mut fitted = 0;
    for points in &shapes {
        for degree in [1, 2, 3] {
            for (u, end) in [(0.0, points[0]), (1.0, points[points.len() - 1])] {
                let to = end + Vector::new(0.0, 0.3, 0.1);
                let fit = Fit {
                    corners: Corners::Angle(60.0_f64.to_radians()),
                    constraints: vec![position(u).to(<[f64; 3]>::from(to.coords))],
                    ..Fit::new(degree, Target::Tolerance(0.5))
                };
                let found = fit.curve(points).unwrap_or_else(|e| panic!("degree {degree}, {u}: {e}"));
                let there = Spline::of(&found.curve, 1.0).at(u);
                assert!((there - to.coords).norm() < 1e-12, "degree {degree}, {u}: {there:?}");
                assert!(!found.corners.is_empty());
                fitted += 1;
            }
        }
    }
    assert_eq!(fitted, 12);
}

#[test]
fn with_a_given_number_of_vertices_a_curve_stays_about_its_points() {
    let (mut fitted, mut out, mut others) = (0, 0, Vec::new());
    for seed in 0..160 {
        let mut r = Random::new(9000 + seed);
        let (m, height) = (r.whole(16, 60), r.between(0.1, 3.0));
        let closed = r.whole(0, 1) == 1;
        let points: Vec<Point> = (0..m)
            .map(|i| Point::new(i as f64, if i % 2 == 0 { height } else { 0.0 }, 0.0))
            .map(|p| if r.whole(0, 3) == 0 { p + Vector::new(0.0, r.normal() * 0.1, 0.0) } else { p })
            .collect();
        let degree = r.pick(&[2, 3, 4, 5, 7, 19]);
        let vertices = r.whole(m / 2, m).max(degree + 1);
        let fit = Fit { closed, ..Fit::new(degree, Target::Vertices(vertices)) };
        let what = format!("seed {seed}, {m} points, degree {degree}, {vertices} vertices, closed {closed}");
        match fit.curve(&points) {
            Ok(found) => {
                fitted += 1;
                let spline = Spline::of(&found.curve, 1.0);
                let side = (m - 1) as f64;
                let (low, high) =
                    points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
                for (_, p) in spline.samples(24) {
                    let beyond = (p - high.coords).sup(&(low.coords - p)).max();
                    assert!(beyond <= 0.51 * side, "{what}: {beyond} beyond");
                }
            }
            Err(error @ FitError::Astray { .. }) => {
                out += usize::from(error.to_string().contains("leaves the box"));
            }
            Err(error) => others.push(format!("{what}: {error}")),
        }
    }
    assert!(fitted + out > 150 && fitted > 140, "{fitted} fitted, {out} out\n{others:#?}");
    assert!(others.len() < 8, "{fitted} fitted, {out} out\n{others:#?}");
}
