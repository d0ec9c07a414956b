//! Poles: edges of surfaces that are points stay points, and smooth where they are.

use std::f64::consts::{PI, TAU};

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{position, vertex};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::evaluator::on_surface;
use super::{Dice, solvers};

/// A surface with a pole at `v = 0`, smooth there or a cone's tip; spheres and ellipsoids with two of them; any size.
fn poled(dice: &mut Dice) -> Surface {
    let size = [1.0, 1.0, 1e-6, 1e6][dice.below(4)];
    let surface = match dice.below(4) {
        0 | 1 => {
            let half = Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI).unwrap();
            let sweep = if dice.below(4) == 0 { dice.between(2.0, 6.0) } else { TAU };
            Surface::revolution(&half, Point::origin(), Vector::z(), sweep).unwrap()
        }
        2 => {
            let slant = Curve::line(Point::origin(), Point::new(1.0, 0.0, dice.between(0.2, 2.0))).unwrap();
            Surface::revolution(&slant, Point::origin(), Vector::z(), TAU).unwrap()
        }
        _ => {
            // A net of any degrees whose second row lies in one plane with the pole, or does not.
            let (p, q) = (1 + dice.below(4), 1 + dice.below(4));
            let (m, n) = (q + 1 + dice.below(4), p + 1 + dice.below(3));
            let flat = dice.below(2) == 0;
            let points = (0..m).flat_map(|i| {
                let angle = 5.5 * i as f64 / (m - 1) as f64;
                (0..n).map(move |j| (angle, j))
            });
            let points: Vec<Point> = points
                .map(|(angle, j)| {
                    let r = j as f64;
                    let rise = if j == 1 && flat { 0.0 } else { 0.3 * r * r };
                    let aside = if j < 2 { 0.0 } else { 0.2 };
                    let wave = if j == 1 && !flat { 0.3 * (3.0 * angle).sin() } else { 0.0 };
                    Point::new(r * angle.cos(), 0.7 * r * angle.sin(), rise + wave) + dice.vector(aside)
                })
                .collect();
            let (u, v) = (Space::clamped_uniform(q, m).unwrap(), Space::clamped_uniform(p, n).unwrap());
            let weights = (0..m * n).map(|_| dice.between(0.5, 2.0)).collect();
            Surface::rational(u, v, points, weights).unwrap()
        }
    };
    // An affine image has poles where the surface has.
    let (a, b) = (dice.vector(0.4), dice.vector(1.0));
    let mut surface = surface;
    for p in surface.control_vertices_mut() {
        *p = Point::new(p.x + a.x * p.y, p.y + a.y * p.z, p.z + a.z * p.x) * size + b * size;
    }
    surface
}

/// What leaves the surface at an end of `v`, and where from, at places all round.
fn round(surface: &Surface, end: bool) -> (Vec<Vector>, Vec<Vector>) {
    let turned = super::evaluator::turned(surface);
    let space = turned.u();
    let (flat, p) = (space.flat(), space.degree());
    let across = if end { (flat.len() - p - 2, flat[flat.len() - 1]) } else { (p, flat[0]) };
    let along = turned.v().flat();
    let q = turned.v().degree();
    let mut all = (Vec::new(), Vec::new());
    for s in (q..along.len() - q - 1).filter(|&s| along[s] < along[s + 1]) {
        for share in [0.0, 0.2, 0.45, 0.8, 1.0] {
            let jet = on_surface(&turned, across, (s, along[s] + share * (along[s + 1] - along[s])));
            all.0.push(jet[0]);
            all.1.push(jet[1]);
        }
    }
    all
}

/// How far the directions are out of the plane of the two that span it best, at most.
fn out_of_plane(ways: &[Vector]) -> f64 {
    let mut normal = Vector::zeros();
    for a in ways {
        for b in ways {
            let n = a.normalize().cross(&b.normalize());
            if n.norm() > normal.norm() {
                normal = n;
            }
        }
    }
    let n = normal.normalize();
    ways.iter().fold(0.0, |most, w| most.max(w.normalize().dot(&n).abs()))
}

#[test]
fn poles_stay_points_and_smooth() {
    let (mut points, mut smooth, mut tips, mut refused) = (0, 0, 0, Vec::new());
    for seed in 0..200 {
        let mut dice = Dice(70_000 + seed);
        let surface = poled(&mut dice);
        let size = surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let (a, b) = surface.u().domain();
        let (c, d) = surface.v().domain();
        let v = [c, c + 0.1 * (d - c), dice.between(c, d)][dice.below(3)];
        let (at, by) = ([dice.between(a, b), v], dice.vector(0.3 * size));
        let mut edit = Edit::new(&surface).ask(position(at).by(by));
        if dice.below(3) == 0 {
            edit = edit.ask(vertex(dice.below(surface.points().len()) as i64).by(by));
        }
        let solver = solvers()[[0, 1, 2][dice.below(3)]].clone();
        let edited = match edit.solve_with(solver) {
            Ok(edited) => edited,
            Err(error) => {
                refused.push(format!("{seed}: {error}"));
                continue;
            }
        };
        let what = format!("{seed}, {}", edited.report());
        let there = edited.shape().point(at[0], at[1]).unwrap();
        assert!((there - surface.point(at[0], at[1]).unwrap() - by).norm() < 1e-9 * size, "{what}");
        for end in [false, true] {
            let (before, ways) = round(&surface, end);
            if before.iter().any(|p| (p - before[0]).norm() > 1e-12 * size) {
                continue;
            }
            let (after, now) = round(edited.shape(), end);
            points += 1;
            let gap = after.iter().fold(0.0_f64, |m, p| m.max((p - after[0]).norm()));
            assert!(gap <= 1e-11 * size, "{what}: the pole opens by {gap:e}");
            if out_of_plane(&ways) < 1e-9 {
                smooth += 1;
                let out = out_of_plane(&now);
                assert!(out < 1e-7, "{what}: a tip, {out:e} out of its plane");
            } else {
                tips += 1;
            }
        }
    }
    assert!(points > 200 && smooth > 120 && tips > 30, "{points} poles, {smooth} smooth, {tips} tips");
    assert!(refused.len() <= 4, "{}\n{}", refused.len(), refused.join("\n"));
}

#[test]
fn a_conflict_names_the_pole_and_smooth_0_lets_it_go() {
    let half = Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), TAU).unwrap();
    let (a, b) = ball.u().domain();
    let apart = |smooth: u8| {
        Edit::new(&ball)
            .smooth(smooth)
            .ask(position([a, ball.v().domain().1]).by([0.0, 0.0, 0.1]))
            .ask(position([0.5 * a + 0.5 * b, ball.v().domain().1]).by([0.0, 0.0, -0.1]))
            .solve()
    };
    let error = apart(1).unwrap_err().to_string();
    assert!(error.contains("smooth pole v = ") && error.contains("smooth = 0"), "{error}");
    apart(0).unwrap();
}
