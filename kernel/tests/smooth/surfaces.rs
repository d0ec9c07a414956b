//! Surfaces, edited: what was smooth along a knot line is smooth.

use std::f64::consts::{PI, TAU};

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{position, vertex};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use super::evaluator::{angle, joints, on_surface, turned};
use super::families::{chain, conic};
use super::{Dice, solvers};

/// A net of Bézier patches of any degrees: the product of two smooth chains, so that every knot line is smooth, bent.
fn patches(dice: &mut Dice) -> Surface {
    let (u, v) = (chain(dice), chain(dice));
    let (a, b) = (dice.between(-0.3, 0.3), dice.vector(1.0));
    let points = u.points().iter().flat_map(|p| {
        v.points()
            .iter()
            .map(move |q| Point::new(p.x + a * q.y, q.x + a * p.z, b.x * p.y + b.y * q.z + b.z * q.y))
    });
    let weight = |c: &Curve, i: usize| c.weights().map_or(1.0, |w| w[i]);
    let weights = (0..u.points().len()).flat_map(|i| (0..v.points().len()).map(move |j| (i, j)));
    let weights = weights.map(|(i, j)| weight(&u, i) * weight(&v, j)).collect();
    Surface::rational(u.space().clone(), v.space().clone(), points.collect(), weights).unwrap()
}

/// Exact surfaces of revolution: spheres with poles, tori, cones, of any profile; full turns and parts; some periodic.
fn revolved(dice: &mut Dice) -> Surface {
    let profile = match dice.below(4) {
        0 => Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI).unwrap(),
        1 => Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap(),
        2 => Curve::line(Point::new(1.0, 0.0, -1.0), Point::new(2.0, 0.0, 1.0)).unwrap(),
        _ => conic(dice),
    };
    let sweep = if dice.below(3) == 0 { dice.between(2.0, 6.0) } else { TAU };
    let surface = Surface::revolution(&profile, Point::new(0.0, 0.0, 0.0), Vector::z(), sweep).unwrap();
    if sweep == TAU && dice.below(3) == 0 {
        return surface.to_periodic(Direction::U, 1e-9).unwrap().shape;
    }
    surface
}

/// Along every knot line: where both sides met they meet, and where `S_u₊ = r S_u₋` held it holds.
fn check(before: &Surface, after: &Surface, what: &str) -> usize {
    let mut kept = 0;
    for (before, after) in [(before.clone(), after.clone()), (turned(before), turned(after))] {
        let size = after.points().iter().map(|p| p.coords.amax()).fold(1.0, f64::max);
        for [left, right] in joints(before.u(), before.u().degree(), true) {
            let t = before.v().flat();
            let q = before.v().degree();
            for s in (q..t.len() - q - 1).filter(|&s| t[s] < t[s + 1]) {
                let places = [0.0, 0.21, 0.5, 0.83, 1.0].map(|share| (s, t[s] + share * (t[s + 1] - t[s])));
                // Ends that have but a pole in common are no seam.
                let apart = |&along: &(usize, f64)| {
                    (on_surface(&before, right, along)[0] - on_surface(&before, left, along)[0]).norm()
                        > 1e-12
                };
                if places.iter().any(apart) {
                    continue;
                }
                for along in places {
                    let see = |x: &Surface| [left, right].map(|place| on_surface(x, place, along));
                    let ([l, r], [nl, nr]) = (see(&before), see(&after));
                    let gap = (nr[0] - nl[0]).norm();
                    assert!(gap <= 1e-9 * size, "{what}: a gap of {gap:e} at {} {}", right.1, along.1);
                    if l[1].norm() < 1e-9 || angle(l[1], r[1]) > 1e-9 {
                        continue;
                    }
                    kept += 1;
                    let ratio = r[1].norm() / l[1].norm();
                    let miss = (nr[1] - nl[1] * ratio).norm();
                    let scale = r[1].norm() + nr[1].norm() + ratio * nl[1].norm();
                    assert!(miss <= 1e-9 * scale, "{what}: S_u jumps by {miss:e} at {} {}", right.1, along.1);
                }
            }
        }
    }
    kept
}

#[test]
fn knot_lines_stay_smooth() {
    let (mut kept, mut refused, mut trials) = (0, 0, 0);
    for seed in 0..120 {
        let mut dice = Dice(20_000 + seed);
        let surface = if seed % 2 == 0 { patches(&mut dice) } else { revolved(&mut dice) };
        let place = |space: &Space, dice: &mut Dice| {
            let breaks = space.breakpoints();
            let (a, b) = space.domain();
            if dice.below(2) == 0 { breaks[dice.below(breaks.len() - 1)] } else { dice.between(a, b) }
        };
        let at = [place(surface.u(), &mut dice), place(surface.v(), &mut dice)];
        let by = dice.vector(0.3);
        let mut edit = Edit::new(&surface).ask(position(at).by(by));
        if dice.below(2) == 0 {
            edit = edit.ask(vertex(dice.below(surface.points().len()) as i64).by(by));
        }
        let solver = solvers()[[0, 1, 2][dice.below(3)]].clone();
        trials += 1;
        match edit.solve_with(solver) {
            Ok(edited) => {
                let what = format!("{seed}, {}", edited.report());
                kept += check(&surface, edited.shape(), &what);
                let there = edited.shape().point(at[0], at[1]).unwrap();
                assert!((there - surface.point(at[0], at[1]).unwrap() - by).norm() < 1e-9, "{what}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(kept > 5000, "{kept} places were kept smooth");
    // A translation meets all of it.
    assert_eq!(refused, 0, "of {trials}");
}

#[test]
fn a_crease_that_no_column_relation_forbids_is_reported() {
    // Weights that differ along the line: columns that are smooth each, but not in the same way.
    let chain =
        |w: f64| (vec![1.0, 1.0, w, 1.0, 1.0], [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [4.0, 0.0]]);
    let u = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
    let v = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let columns = [chain(1.0), chain(3.0)];
    let at = |i: usize, j: usize| Point::new(columns[j].1[i][0], columns[j].1[i][1], 5.0 * j as f64);
    let points = (0..5).flat_map(|i| [at(i, 0), at(i, 1)]).collect();
    let weights = (0..5).flat_map(|i| [columns[0].0[i], columns[1].0[i]]).collect();
    let surface = Surface::rational(u, v, points, weights).unwrap();
    let edited = Edit::new(&surface).ask(position([1.0, 0.4]).by([0.0, 0.5, 0.0])).solve().unwrap();
    let smooth = &edited.report().smooth;
    assert_eq!(smooth.knots, 0);
    assert_eq!(smooth.corners.len(), 1);
    assert!(smooth.corners[0].place.starts_with("along u = 1"), "{}", smooth.corners[0]);
    assert!(smooth.corners[0].degrees.unwrap() > 1.0);
    assert!(edited.report().notes[0].contains("a corner of"), "{:?}", edited.report().notes);
}

/// Where a surface has shrunk to a curve, but for rounding, it has no normals, and so no corners.
#[test]
fn what_has_no_normal_has_no_corner() {
    let mut dice = Dice(0x0c01_1a95_ed00_0011);
    for _ in 0..20 {
        let radius = dice.between(0.5, 5.0);
        let profile = Curve::line(Point::new(radius, 0.0, -1.0), Point::new(radius, 0.0, 1.3)).unwrap();
        let axis = (Point::from(dice.vector(2.0)), dice.vector(1.0));
        let tube = Surface::revolution(&profile, axis.0, axis.1, TAU).unwrap();
        let mut edit = Edit::new(&tube).smooth(0);
        for (k, pair) in tube.points().chunks_exact(2).enumerate() {
            let noise = Vector::from_fn(|i, _| pair[0][i] * f64::EPSILON * dice.between(-2.0, 2.0));
            let there = pair[0] + noise;
            edit = edit.ask(vertex(2 * k as i64 + 1).to([there.x, there.y, there.z]));
        }
        let edited = edit.solve().unwrap();
        assert!(edited.report().smooth.corners.is_empty(), "{}", edited.report());
    }
}

/// Two columns across a knot line, each a chain of two quadratic pieces with a weight a vertex; pieces that have their ends for
/// themselves where `torn`.
fn two_columns(columns: [(&[f64], &[[f64; 2]]); 2], torn: bool) -> Surface {
    let inner = if torn { vec![1.0; 3] } else { vec![1.0; 2] };
    let u = Space::open(2, [vec![0.0; 3], inner, vec![2.0; 3]].concat()).unwrap();
    let v = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let at = |i: usize, j: usize| Point::new(columns[j].1[i][0], columns[j].1[i][1], 5.0 * j as f64);
    let points = (0..u.len()).flat_map(|i| [at(i, 0), at(i, 1)]).collect();
    let weights = (0..u.len()).flat_map(|i| [columns[0].0[i], columns[1].0[i]]).collect();
    Surface::rational(u, v, points, weights).unwrap()
}

const ARCH: [[f64; 2]; 5] = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [4.0, 0.0]];

#[test]
fn a_line_is_smooth_where_all_its_columns_are() {
    let one = [1.0; 5];
    // As fast behind the line as before it.
    let kinked = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.6, 1.8], [4.0, 0.0]];
    for (columns, knots) in
        [([ARCH, ARCH], 1), ([ARCH, kinked], 0), ([kinked, ARCH], 0), ([kinked, kinked], 1)]
    {
        let surface = two_columns([(&one, &columns[0]), (&one, &columns[1])], false);
        let edited = Edit::new(&surface).ask(position([1.0, 0.4]).by([0.0, 0.5, 0.0])).solve().unwrap();
        let expected = if columns[0] == kinked { 0 } else { knots };
        assert_eq!(edited.report().smooth.knots, expected, "{}", edited.report());
    }
}

/// Pieces that meet in every column, each with weights of its own: they are one surface where the factors between the weights on
/// both sides are one.
#[test]
fn weights_on_both_sides_differ_by_one_factor_or_the_sides_only_meet() {
    let arch: Vec<[f64; 2]> = [&ARCH[..3], &ARCH[2..]].concat();
    let weights = |factor: f64| vec![1.0, 1.0, 1.0, factor, factor, factor];
    for (first, second, equations) in [(1.0, 1.0, 12), (2.5, 2.5, 12), (2.0, 3.0, 6)] {
        let columns = [weights(first), weights(second)];
        let surface = two_columns([(&columns[0], &arch), (&columns[1], &arch)], true);
        let edited = Edit::new(&surface).ask(position([0.6, 0.4]).by([0.0, 0.5, 0.0])).solve().unwrap();
        assert_eq!(edited.report().smooth.equations, equations, "{first} {second}: {}", edited.report());
    }
}

/// A rational surface cut in two, one half of it traced by another parameter (a linear rational one: the weights of its rows are
/// multiplied by powers of a number): smooth to the second order, as it was, with factors between weights that bend, too.
#[test]
fn level_2_keeps_a_relation_that_weights_are_part_of() {
    let mut dice = Dice(41);
    for round in 0..30 {
        let p = 2 + round % 3;
        let u = Space::clamped(p, &[0.0, 2.0]).unwrap();
        let v = Space::clamped_uniform(2, 4).unwrap();
        let count = u.len() * v.len();
        let net = (0..count).map(|k| {
            let (i, j) = ((k / v.len()) as f64, (k % v.len()) as f64);
            Point::new(i, j, (0.9 * i).sin() + 0.3 * j * j) + dice.vector(0.2)
        });
        let net: Vec<Point> = net.collect();
        let weights: Vec<f64> = (0..count).map(|_| dice.between(0.6, 1.8)).collect();
        let whole = Surface::rational(u, v.clone(), net, weights).unwrap();
        let cut = whole.insert_knots(Direction::U, &vec![1.0; p]).unwrap();
        let (u, v, points, weights) = cut.into_parts();
        let mut weights = weights.unwrap();
        let by = dice.between(0.5, 2.0);
        for i in p..u.len() {
            (0..v.len()).for_each(|j| weights[i * v.len() + j] *= by.powi((i - p) as i32));
        }
        let surface = Surface::rational(u, v, points, weights).unwrap();
        let knots = |s: &Surface| {
            let t = s.v().flat().to_vec();
            let q = s.v().degree();
            let places = (q..t.len() - q - 1).filter(|&s| t[s] < t[s + 1]);
            places
                .flat_map(|s| [0.1, 0.5, 0.8].map(|x| (s, t[s] + x * (t[s + 1] - t[s]))))
                .collect::<Vec<_>>()
        };
        let [left, right] = joints(surface.u(), p, false)[0];
        // S_u₊ = r S_u₋ and S_uu₊ = r² S_uu₋ + s S_u₋, with the same numbers all along.
        let relation = |x: &Surface| -> Vec<(f64, f64)> {
            let each = knots(x).into_iter().map(|along| {
                let [l, m] = [left, right].map(|place| on_surface(x, place, along));
                let r = m[1].norm() / l[1].norm();
                let rest = m[2] - l[2] * (r * r);
                let s = rest.dot(&l[1]) / l[1].norm_squared();
                let missed = (m[1] - l[1] * r).norm() / m[1].norm()
                    + (rest - l[1] * s).norm() / (m[2].norm() + l[2].norm());
                assert!(missed < 1e-9, "{round}: {missed:e}");
                (r, s)
            });
            each.collect()
        };
        let before = relation(&surface);
        let edit = Edit::new(&surface).smooth(2).ask(position([0.7, 0.4]).by(dice.vector(0.3)));
        let edited = edit.solve().unwrap();
        for ((r, s), (now, bend)) in before.iter().zip(relation(edited.shape())) {
            assert!((r - now).abs() < 1e-9 * r && (s - bend).abs() < 1e-7 * (1.0 + s.abs()), "{round}");
        }
    }
}
