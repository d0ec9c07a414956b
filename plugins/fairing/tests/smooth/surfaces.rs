//! Surfaces, made fair: what was smooth along a knot line is smooth.

use std::f64::consts::{PI, TAU};

use loftsman_fairing::{Fair, bend, near, stretch, variation};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::{Curve, Direction, Surface};
use loftsman_kernel::{Point, Vector};

use super::Dice;
use super::evaluator::{angle, joints, on_surface, turned};
use super::families::{chain_of, conic};

/// A net of Bézier patches, some rational: the product of two smooth chains, so that every knot line is smooth, bent.
fn patches(dice: &mut Dice, rational: bool) -> Surface {
    let (u, v) = (chain_of(2 + dice.below(2), dice), chain_of(1 + dice.below(3), dice));
    let (a, b) = (dice.between(-0.3, 0.3), dice.vector(1.0));
    let points = u.points().iter().flat_map(|p| {
        v.points().iter().map(move |q| Point::new(p.x + a * q.y, q.x + a * p.z, b.x * p.y + b.y * q.z))
    });
    if !rational {
        return Surface::new(u.space().clone(), v.space().clone(), points.collect()).unwrap();
    }
    let weight = |c: &Curve, i: usize| c.weights().map_or(1.0, |w| w[i]);
    let weights = (0..u.points().len()).flat_map(|i| (0..v.points().len()).map(move |j| (i, j)));
    let weights = weights.map(|(i, j)| weight(&u, i) * weight(&v, j)).collect();
    Surface::rational(u.space().clone(), v.space().clone(), points.collect(), weights).unwrap()
}

/// Exact surfaces of revolution: spheres with poles, tori, cones, vases; full turns and parts; some periodic.
fn revolved(dice: &mut Dice) -> Surface {
    let profile = match dice.below(5) {
        0 => Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI).unwrap(),
        1 => Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap(),
        2 => Curve::line(Point::new(1.0, 0.0, -1.0), Point::new(2.0, 0.0, 1.0)).unwrap(),
        3 => conic(dice),
        _ => vase(),
    };
    let sweep = if dice.below(3) == 0 { dice.between(2.0, 6.0) } else { TAU };
    let surface = Surface::revolution(&profile, Point::origin(), Vector::z(), sweep).unwrap();
    if sweep == TAU && dice.below(3) == 0 {
        return surface.to_periodic(Direction::U, 1e-9).unwrap().shape;
    }
    surface
}

fn vase() -> Curve {
    let points = [[0.6, 0.0], [1.2, 0.5], [0.5, 1.5], [0.9, 2.2]].map(|[x, z]| Point::new(x, 0.0, z));
    let space = loftsman_kernel::spline::Space::clamped_uniform(3, 4).unwrap();
    Curve::new(space, points.to_vec()).unwrap()
}

/// Along every knot line: where both sides met they meet, and where `S_u₊ = r S_u₋` held its direction is one.
fn check(before: &Surface, after: &Surface, what: &str) -> usize {
    let mut kept = 0;
    for (before, after) in [(before.clone(), after.clone()), (turned(before), turned(after))] {
        let size = after.points().iter().map(|p| p.coords.amax()).fold(1.0, f64::max);
        for [left, right] in joints(before.u(), before.u().degree(), true) {
            let t = before.v().flat();
            let q = before.v().degree();
            for s in (q..t.len() - q - 1).filter(|&s| t[s] < t[s + 1]) {
                let places = [0.0, 0.21, 0.5, 0.83, 1.0].map(|share| (s, t[s] + share * (t[s + 1] - t[s])));
                let pairs = |of: &Surface| {
                    places.map(|along| [on_surface(of, left, along), on_surface(of, right, along)])
                };
                let (old, new) = (pairs(&before), pairs(&after));
                // Ends that have but a pole in common are no seam.
                if old.iter().any(|[a, b]| (b[0] - a[0]).norm() > 1e-12) {
                    continue;
                }
                let ratio = old
                    .iter()
                    .map(|[a, b]| (a[1].norm(), b[1].norm()))
                    .fold((0.0, 0.0), |m, n| if n.0 > m.0 { n } else { m });
                let ratio = ratio.1 / ratio.0;
                let smooth =
                    |[a, b]: &[[Vector; 3]; 2]| (b[1] - a[1] * ratio).norm() < 1e-9 * (1.0 + b[1].norm());
                let smooth = old.iter().all(smooth);
                for [a, b] in new {
                    assert!(
                        (b[0] - a[0]).norm() <= 1e-11 * size,
                        "{what}: a gap of {:e}",
                        (b[0] - a[0]).norm()
                    );
                    if smooth && a[1].norm() > 1e-6 * size && b[1].norm() > 1e-6 * size {
                        let turned = angle(a[1], b[1]);
                        assert!(turned < 1e-6, "{what}: a crease of {turned:e}");
                        kept += 1;
                    }
                }
            }
        }
    }
    kept
}

#[test]
fn no_crease_and_no_gap_appears() {
    let mut dice = Dice(0x05af_ace5_0000_0003);
    let (mut kept, mut torn, mut done) = (0, 0, 0);
    for number in 0..110 {
        let surface =
            if number % 2 == 0 { revolved(&mut dice) } else { patches(&mut dice, number % 10 == 1) };
        let degree = surface.u().degree().min(surface.v().degree());
        let energy = match dice.below(4) {
            0 if degree > 2 => variation(),
            1 if degree > 1 => bend(),
            2 if degree > 1 => bend() + 0.1 * near(),
            _ => stretch() + near(),
        };
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        let mut asked = Vec::new();
        let knots = surface.u().breakpoints();
        if dice.below(2) == 0 {
            for &u in knots.iter().skip(1) {
                asked.push(position([u.clamp(a, b), 0.5 * (c + d)]).keep());
            }
        } else {
            asked.push(position([a, c]).keep());
        }
        if dice.below(2) == 0 {
            let by = dice.vector(0.3);
            let at = [dice.between(a, b), dice.between(c, d)];
            asked.push(position(at).by([by.x, by.y, by.z]));
        }
        let (n, some) = (surface.points().len(), dice.below(4) == 0);
        let locks: Vec<i64> = (0..n as i64).filter(|_| some && dice.below(3) == 0).collect();
        let fair = |level: u8| {
            let fair = Fair::new(&surface).energy(energy.clone()).smooth(level).lock(locks.iter().copied());
            asked.iter().fold(fair, |fair, c| fair.ask(c.clone())).solve()
        };
        let what = format!(
            "{number}: degrees {} and {}, {} vertices, {energy}",
            surface.u().degree(),
            surface.v().degree(),
            surface.points().len()
        );
        let sharp = fair(0);
        match fair(1) {
            Ok(fair) => {
                done += 1;
                kept += check(&surface, fair.shape(), &format!("{what}: {}", fair.report()));
            }
            Err(why) => {
                let why = why.to_string();
                assert!(sharp.is_err() || why.contains("smooth = 0"), "{what}: {why}");
            }
        }
        torn += sharp.map_or(0, |sharp| sharp.report().smooth.corners.len());
    }
    assert!(done >= 90 && kept >= 2000 && torn >= 100, "{done} done, {kept} kept, {torn} torn");
}

/// The vase of revolution that burst at its seam.
#[test]
fn a_revolution_that_is_bent_least_does_not_burst() {
    let vase = Surface::revolution(&vase(), Point::origin(), Vector::z(), TAU).unwrap();
    let fair = |level: u8| {
        let fair = Fair::new(&vase).energy(bend()).smooth(level);
        let fair = fair.ask(position([1.0, 0.5]).by([0.0, 0.3, 0.0]));
        [0.0, 2.0, 3.0].iter().fold(fair, |fair, &u| fair.ask(position([u, 0.5]).keep())).solve().unwrap()
    };
    let (whole, burst) = (fair(1), fair(0));
    assert_eq!(check(&vase, whole.shape(), "vase"), 20);
    assert!(whole.report().smooth.corners.is_empty(), "{}", whole.report());
    assert_eq!(whole.report().smooth.knots, 4);
    let told = burst.report().notes.join(" · ");
    assert!(told.contains("a gap of") && told.contains("a corner of"), "{told}");
}
