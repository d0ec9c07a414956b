//! Curves with repeated, jagged and straight runs of control points, of degrees 1 to 7, and of degree 25: `D' = αC'`, `κ_D = κ/α`, ends that stay.

#![allow(clippy::unwrap_used, reason = "helpers of tests may fail the test")]

use loftsman_fine_tuning::{Ends, FineTune};
use loftsman_kernel::Point;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};

use crate::curves::{Lcg, any_alpha, any_curve, size};

/// Control points one way and back, each now and then the one before once more, or a hundred times as far away.
fn jagged(count: usize, seed: u64) -> Vec<Point> {
    let mut random = Lcg(seed * 77 + 5);
    let mut points: Vec<Point> = Vec::with_capacity(count);
    for k in 0..count {
        let far = if random.next() < 0.1 { 100.0 } else { 1.0 };
        let zigzag = if k % 2 == 0 { 1.0 } else { -1.0 };
        let next = Point::new(k as f64 + random.next(), far * zigzag * random.next(), 0.3 * random.next());
        let again = random.next() < 0.3;
        points.push(points.last().copied().filter(|_| again).unwrap_or(next));
    }
    points
}

fn places(curve: &Curve, seed: u64) -> Vec<f64> {
    let mut random = Lcg(seed + 31);
    let breaks = curve.space().breakpoints();
    let within = |pair: &[f64]| pair[0] + (pair[1] - pair[0]) * (0.02 + 0.96 * random.next());
    breaks.windows(2).map(within).collect()
}

/// Of the tuned curve and the given one at places within its spans; what `κ` is of where it turns too fast to be told is left out, and counted.
fn is_scaled(given: &Curve, tuned: &Curve, alpha: &Function<f64>, case: u64) -> [usize; 2] {
    let all = places(given, case);
    let largest = all.iter().fold(0.0_f64, |m, t| m.max(given.derivative(*t, 1).unwrap().norm()));
    let (mut told, mut untold) = (0, 0);
    for t in all {
        let (was, is) = (given.derivative(t, 1).unwrap(), tuned.derivative(t, 1).unwrap());
        let by = alpha.value(t).unwrap();
        assert!((is - was * by).norm() <= 1e-10 * largest, "{case} {t}: {is} {was} {by}");
        // Of degree 13 second derivatives have 1e-10 of the first ones some ten thousand times.
        if !(2..=7).contains(&given.degree()) || was.norm().min(is.norm()) < 1e-3 * largest {
            untold += 1;
            continue;
        }
        told += 1;
        let bent = |curve: &Curve| {
            let (first, second) = (curve.derivative(t, 1).unwrap(), curve.derivative(t, 2).unwrap());
            (first.cross(&second).norm(), first.norm().powi(3), second.norm() * first.norm())
        };
        let ((a, c, whole), (b, d, _)) = (bent(given), bent(tuned));
        // Of what cancels in the cross product.
        assert!((b / d * by.abs() - a / c).abs() <= 1e-9 * (whole / c), "{case} {t}: κ {} {}", a / c, b / d);
    }
    [told, untold]
}

#[test]
fn jagged_curves_are_scaled_like_others() {
    let (mut counts, mut exact) = ([0, 0], 0);
    for case in 0..150 {
        let like = any_curve(case);
        let points = jagged(like.points().len(), case);
        let factor = [1.0, 1e-9, 1e9][case as usize % 3];
        let points = points.into_iter().map(|p| Point::from(p.coords * factor)).collect();
        let curve = Curve::new(like.space().clone(), points).unwrap();
        let alpha = any_alpha(&curve, case);
        let free = FineTune::new(&curve, alpha.clone()).ends(Ends::Free).solve().unwrap();
        let told = is_scaled(&curve, free.curve(), free.alpha(), case);
        (counts[0], counts[1]) = (counts[0] + told[0], counts[1] + told[1]);
        let Ok(held) = FineTune::new(&curve, alpha).any_sign().solve() else { continue };
        exact += 1;
        is_scaled(&curve, held.curve(), held.alpha(), case);
        let (a, b) = curve.domain();
        for t in [a, b] {
            let off = (held.curve().point(t).unwrap() - curve.point(t).unwrap()).norm();
            assert!(off <= 1e-11 * size(&curve), "{case}: {off:e} at {t}");
        }
    }
    println!("{counts:?} κ told and untold, {exact} exact");
    assert!(counts[0] > 500 && counts[1] < counts[0] && exact > 120, "{counts:?} {exact}");
}

/// The highest degree, whose derivative leaves α a number or steps.
#[test]
fn degree_twenty_five() {
    for case in 0..20 {
        let mut knots = vec![0.0; 26];
        let inner = [0.7, 1.0, 2.1];
        let times = [1, 3, 25][case as usize % 3];
        inner.iter().for_each(|t| knots.extend(std::iter::repeat_n(*t, times)));
        knots.extend([3.0; 26]);
        let points = jagged(knots.len() - 26, case);
        let curve = Curve::new(Space::open(25, knots).unwrap(), points).unwrap();
        let steps = Space::clamped(0, &[0.0, 0.7, 1.0, 2.1, 3.0]).unwrap();
        let alpha = Function::new(steps, vec![0.5, 1.7, 0.9, 1.2]).unwrap();
        let tuned = FineTune::new(&curve, alpha).ends(Ends::Free).solve().unwrap();
        assert_eq!(tuned.curve().degree(), 25);
        is_scaled(&curve, tuned.curve(), tuned.alpha(), case);
        let held = FineTune::new(&curve, tuned.alpha().clone()).any_sign().solve().unwrap();
        is_scaled(&curve, held.curve(), held.alpha(), case);
        let off = (held.curve().point(3.0).unwrap() - curve.point(3.0).unwrap()).norm();
        assert!(off <= 1e-11 * size(&curve), "{case}: {off:e}");
    }
}
