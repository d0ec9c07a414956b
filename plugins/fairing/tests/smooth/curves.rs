//! Curves of every kind with such knots, made fair under constraints of every kind.

use std::collections::BTreeMap;

use loftsman_fairing::{EnergySum, Fair};
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::evaluator::{angle, joints, on_curve};
use super::families::{chain, conic, cornered, inserted};
use super::{Dice, energy};
use crate::book::{Book, least, violation};

/// Two sides of a joint as rows over the vertices: position and first derivative, left and right.
struct Sides {
    rows: [[Vec<f64>; 2]; 2],
    /// Whether even the position may differ.
    torn: bool,
    /// What is smooth there: `C'₊ = r C'₋`.
    ratio: Option<f64>,
    meets: bool,
}

/// All joints of a curve at which a corner can appear, by evaluating unit vectors.
fn sides(curve: &Curve) -> Vec<Sides> {
    let (space, points, weights) = curve.clone().into_parts();
    let p = space.degree();
    let seam = !space.is_periodic() || space.multiplicity(space.domain().0) >= p;
    let unit = |i: usize| {
        let at = |k: usize| Point::new(f64::from(u8::from(k == i)), 0.0, 0.0);
        Curve::build(space.clone(), (0..points.len()).map(at).collect(), weights.clone()).unwrap()
    };
    let units: Vec<Curve> = (0..points.len()).map(unit).collect();
    let each = joints(&space, p, seam).into_iter().map(|pair| {
        let rows = pair.map(|at| [0, 1].map(|k| units.iter().map(|c| on_curve(c, at)[k].x).collect()));
        let [left, right] = pair.map(|at| on_curve(curve, at));
        let length = pair.map(|(s, _)| space.flat()[s + 1] - space.flat()[s]);
        let size = points.iter().map(|p| (p.coords - left[0]).norm()).fold(0.0, f64::max);
        let meets = (left[0] - right[0]).norm() <= 1e-9 * size;
        let moves = left[1].norm() * length[0] > 1e-8 * size && right[1].norm() * length[1] > 1e-8 * size;
        let smooth = meets && moves && angle(left[1], right[1]) < 1e-7;
        let closing = !space.is_periodic() && pair[1].1 == space.domain().0;
        let torn = closing || space.multiplicity(pair[1].1) > p;
        Sides { rows, torn, ratio: smooth.then(|| right[1].norm() / left[1].norm()), meets }
    });
    each.collect()
}

fn value(row: &[f64], points: &[Point]) -> Vector {
    row.iter().zip(points).fold(Vector::zeros(), |sum, (c, p)| sum + p.coords * *c)
}

impl Sides {
    /// The rows that keep it: zero for every axis.
    fn kept(&self) -> Vec<Vec<f64>> {
        let [left, right] = &self.rows;
        let sum = |k: usize, r: f64| left[k].iter().zip(&right[k]).map(|(a, b)| b - r * a).collect();
        let closed = (self.torn && self.meets).then(|| sum(0, 1.0));
        closed.into_iter().chain(self.ratio.map(|r| sum(1, r))).collect()
    }

    /// What another curve of the same knots makes of it: how far apart, by which angle, where there is one.
    fn seen(&self, points: &[Point]) -> (f64, Option<f64>) {
        let at = |side: usize, k: usize| value(&self.rows[side][k], points);
        let (a, b) = (at(0, 1), at(1, 1));
        let reach = |side: usize| {
            let each = self.rows[side][1].iter().zip(points).map(|(c, p)| (p.coords * *c).norm());
            each.fold(0.0, f64::max)
        };
        // Where the curve all but stands still it has no direction.
        let moves = a.norm() > 1e-6 * reach(0) && b.norm() > 1e-6 * reach(1);
        ((at(1, 0) - at(0, 0)).norm(), moves.then(|| angle(a, b)))
    }
}

struct Problem {
    curve: Curve,
    energy: EnergySum,
    terms: Vec<(f64, usize)>,
    constraints: Vec<Constraint>,
    /// Of each axis: a row, its value, whether it is an equation.
    rows: [Vec<(Vec<f64>, f64, bool)>; 3],
    locks: Vec<usize>,
    within: Option<f64>,
}

impl Problem {
    fn new(dice: &mut Dice, number: usize) -> Self {
        let curve = match number % 4 {
            0 => chain(dice),
            1 => conic(dice),
            2 => inserted(dice),
            _ => cornered(dice),
        };
        let (energy, terms) = energy(dice, curve.degree());
        let mut problem = Self {
            energy,
            terms,
            constraints: Vec::new(),
            rows: [const { Vec::new() }; 3],
            locks: Vec::new(),
            within: None,
            curve,
        };
        problem.ask(dice);
        problem
    }

    fn ask(&mut self, dice: &mut Dice) {
        let book = Book::new(&self.curve);
        let (a, b) = self.curve.domain();
        let breaks = self.curve.space().breakpoints();
        let kept = match dice.below(4) {
            // Every knot, as the reviewer of a fair circle would.
            0 => breaks.iter().map(|u| u.clamp(a, b)).collect(),
            1 => vec![a, b],
            k => (0..k).map(|_| dice.between(a, b)).collect::<Vec<f64>>(),
        };
        let mut known: BTreeMap<u64, ()> = BTreeMap::new();
        for u in kept.into_iter().filter(|u| known.insert(u.to_bits(), ()).is_none()) {
            let at = self.curve.point(u).unwrap();
            self.constraints.push(position(u).keep());
            (0..3).for_each(|axis| self.rows[axis].push((book.row(u, 0), at[axis], true)));
        }
        if dice.below(2) == 0 {
            let (u, by) = (dice.between(a, b), dice.vector(0.5));
            let at = self.curve.point(u).unwrap() + by;
            self.constraints.push(position(u).by([by.x, by.y, by.z]));
            (0..3).for_each(|axis| self.rows[axis].push((book.row(u, 0), at[axis], true)));
        }
        for _ in 0..[0, 0, 3][dice.below(3)] {
            let (u, up) = (dice.between(a, b), dice.between(-0.3, 0.2));
            let low = self.curve.point(u).unwrap().z + up;
            self.constraints.push(position(u).axis(Axis::Z).at_least(low));
            self.rows[2].push((book.row(u, 0), low, false));
        }
        let n = self.curve.points().len();
        match dice.below(8) {
            0 => self.locks = (0..n).collect(),
            1 | 2 => self.locks = (0..n).filter(|_| dice.below(3) == 0).collect(),
            3 => self.within = Some(dice.between(0.05, 2.0)),
            _ => {}
        }
        if self.locks.len() == n {
            self.constraints.retain(|c| matches!(c.wanted(), loftsman_kernel::edit::Wanted::Keep));
            self.rows.iter_mut().for_each(|rows| rows.truncate(self.constraints.len()));
        }
    }

    fn fair(&self) -> Fair<Curve> {
        let fair = Fair::new(&self.curve).energy(self.energy.clone());
        let fair = fair.lock(self.locks.iter().map(|&l| l as i64));
        let fair = self.within.iter().fold(fair, |fair, distance| fair.within(*distance));
        self.constraints.iter().fold(fair, |fair, c| fair.ask(c.clone()))
    }

    /// The rows of one axis, equations first, with those that keep what is smooth; and how many are equations.
    fn rows(&self, axis: usize, kept: &[Vec<f64>]) -> (Vec<(Vec<f64>, f64)>, usize) {
        let unit =
            |at: &usize| (0..self.curve.points().len()).map(|i| f64::from(u8::from(i == *at))).collect();
        let points = self.curve.points();
        let mut rows: Vec<(Vec<f64>, f64)> =
            self.locks.iter().map(|at| (unit(at), points[*at][axis])).collect();
        rows.extend(kept.iter().map(|row| (row.clone(), value(row, points)[axis])));
        let of = |equation| self.rows[axis].iter().filter(move |row| row.2 == equation);
        rows.extend(of(true).map(|row| (row.0.clone(), row.1)));
        let equations = rows.len();
        rows.extend(of(false).map(|row| (row.0.clone(), row.1)));
        (rows, equations)
    }

    fn squares(&self, book: &Book, axis: usize) -> Vec<(Vec<f64>, f64)> {
        let mut all = Vec::new();
        for &(weight, order) in &self.terms {
            for row in book.integral(order) {
                let root = weight.sqrt();
                let near = if order == 0 { value(&row, self.curve.points())[axis] } else { 0.0 };
                all.push((row.iter().map(|c| c * root).collect(), near * root));
            }
        }
        all
    }
}

#[test]
fn whatever_is_made_fair_has_no_corner_that_it_had_not() {
    let mut dice = Dice(0x00fa_1e5b_0075_0001);
    let (mut done, mut refused, mut compared, mut kept_at, mut torn) = (0, 0, 0, 0, 0);
    for number in 0..320 {
        let problem = Problem::new(&mut dice, number);
        let curve = &problem.curve;
        let what = format!(
            "{number}: degree {}, {} vertices, {}, {} asked, {} locked, within {:?}",
            curve.degree(),
            curve.points().len(),
            problem.energy,
            problem.constraints.len(),
            problem.locks.len(),
            problem.within
        );
        let sides = sides(curve);
        let kept: Vec<Vec<f64>> = sides.iter().flat_map(Sides::kept).collect();
        let must = || {
            let of = |axis| {
                let (rows, equations) = problem.rows(axis, &kept);
                violation(&rows, equations, curve.points().len())
            };
            (0..3).map(of).fold(0.0, f64::max)
        };
        let fair = match problem.fair().solve() {
            Ok(fair) => fair,
            Err(why) => {
                // Only what cannot be had is refused; and where corners would help, that is said.
                let why = why.to_string();
                let near = problem.within.is_some() && why.contains("may move further");
                assert!(near || must() > 1e-7, "{what}: {why}");
                if problem.fair().smooth(0).solve().is_ok() {
                    let named =
                        why.contains("smooth knot") || why.contains("closed") || why.contains("smooth seam");
                    assert!(named && why.contains("smooth = 0"), "{what}: {why}");
                }
                refused += 1;
                continue;
            }
        };
        done += 1;
        let (report, points) = (fair.report(), fair.shape().points());
        let size = points.iter().chain(curve.points()).map(|p| p.coords.amax()).fold(1.0, f64::max);
        for (k, side) in sides.iter().enumerate() {
            let (gap, turned) = side.seen(points);
            assert!(!side.meets || gap <= 1e-12 * size, "{what}: a gap of {gap:e} at joint {k}");
            if side.ratio.is_some() {
                let turned = turned.unwrap_or(0.0);
                assert!(turned < 1e-6, "{what}: a corner of {turned:e} at joint {k}: {report}");
                kept_at += 1;
            }
        }
        for row in &kept {
            let far = value(row, points) - value(row, curve.points());
            let all: f64 = row.iter().map(|c| c.abs()).sum();
            assert!(far.amax() <= 1e-11 * size * all, "{what}: a relation is missed by {far}");
        }
        assert!(report.smooth.corners.iter().all(|c| c.gap.is_none()), "{what}: {report}");
        for &lock in &problem.locks {
            assert_eq!(points[lock], curve.points()[lock], "{what}");
        }
        for axis in 0..3 {
            let (rows, equations) = problem.rows(axis, &[]);
            for (k, (row, wanted)) in rows.iter().enumerate() {
                let (value, all) = (value(row, points)[axis], row.iter().map(|c| c.abs()).sum::<f64>());
                let error = if k < equations { (value - wanted).abs() } else { wanted - value };
                assert!(error < 2e-11 * size * all.max(1.0), "{what}: {error:e}");
            }
        }
        // What is not asked for stays asked apart: as many constraints as were asked.
        let bounds = problem.constraints.iter().filter(|c| c.label() != c.describe()).count();
        assert!(report.constraints.len() >= problem.constraints.len() - bounds, "{what}");
        assert!(report.constraints.iter().all(|c| !c.name.contains("smooth")), "{what}");
        // Another program's least under the same relations, and that corners would have been fairer still.
        if problem.within.is_none() && problem.locks.len() < curve.points().len() && number % 3 == 0 {
            let book = Book::new(curve);
            let of = |axis| {
                let (rows, equations) = problem.rows(axis, &kept);
                least(&problem.squares(&book, axis), &rows, equations, curve.points().len())
            };
            if let Some(least) = (0..3).map(of).sum::<Option<f64>>() {
                compared += 1;
                // (Where it is stiff the library is too high, never too low: what is asked was found to hold.)
                let slack = 1e-5 * least.abs() + 1e-7 * report.energy_before.max(1.0);
                assert!(report.energy_after <= least + slack, "{what}: {report}, and {least} can be had");
            }
        }
        if let Ok(sharp) = problem.fair().smooth(0).solve() {
            let sharp = sharp.report();
            let within = if problem.within.is_some() { 2e-3 } else { 1e-7 };
            let much = sharp.energy_after * (1.0 - within) - 1e-9 * sharp.energy_before;
            assert!(report.energy_after >= much, "{what}: {report}, {sharp}");
            torn += sharp.smooth.corners.len();
            assert_eq!(sharp.smooth.knots, 0);
        }
    }
    assert!(done >= 200 && refused < 100, "{done} done, {refused} refused");
    assert!(
        compared >= 40 && kept_at >= 500 && torn >= 300,
        "{compared} compared, {kept_at} kept, {torn} torn"
    );
}

/// The circle that became a square: its knots kept, stretched.
#[test]
fn a_circle_with_its_knots_kept_stays_round_there() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    for degree in [2, 3, 4] {
        let circle = circle.elevate(degree - 2).unwrap();
        let fair = |level: u8| {
            let fair = Fair::new(&circle).energy(loftsman_fairing::stretch()).smooth(level);
            let (a, b) = circle.domain();
            let knots = (0..5).map(|k| a + (b - a) * 0.25 * f64::from(k));
            knots.fold(fair, |fair, u| fair.ask(position(u).keep())).solve().unwrap()
        };
        let (round, square) = (fair(1), fair(0));
        for side in sides(&circle) {
            let (gap, turned) = side.seen(round.shape().points());
            assert!(gap < 1e-14 && turned.unwrap() < 1e-9, "{degree}: {gap:e}, {turned:?}");
            let (_, turned) = side.seen(square.shape().points());
            assert!((turned.unwrap().to_degrees() - 90.0).abs() < 1e-6, "{degree}: {turned:?}");
        }
        assert_eq!((round.report().smooth.knots, round.report().smooth.equations), (4, 15));
        assert!(round.report().smooth.corners.is_empty() && square.report().smooth.corners.len() == 4);
        let told = square.report().notes.join(" · ");
        assert!(told.contains("a corner of 90.0° at") && told.contains("and 1 more corners"), "{told}");
    }
}
