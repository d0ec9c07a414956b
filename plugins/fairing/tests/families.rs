//! Fairing of many kinds of curves between many kinds of bounds: what can be had is had, measured by an evaluator of the
//! test's own and beside another program's least; what cannot is refused, naming what contradicts and nothing else.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use crate::book::{Book, least, violation};
use crate::dice::Dice;
use loftsman_fairing::{EnergySum, Fair, bend, near, stretch, variation};
use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Axis, Constraint};
use loftsman_kernel::functional::{derivative, position};
use loftsman_kernel::spline::{Curve, Space};

/// A curve of any kind: clamped, floating or periodic, knots of any multiplicity, chains of Bézier curves, unlike weights.
fn curve(dice: &mut Dice, number: usize) -> Curve {
    let degree = 1 + number % 7;
    let spans = 1 + dice.below(5);
    let breaks: Vec<f64> = (0..=spans)
        .scan(dice.between(-1.0, 1.0), |u, _| {
            let here = *u;
            *u += dice.between(0.2, 2.0);
            Some(here)
        })
        .collect();
    let kind = dice.below(5);
    let space = match kind {
        0 if spans > 1 => {
            let mut knots = vec![0.3];
            for _ in 0..spans + degree {
                let repeated = knots.len() > 1 && degree > 1 && dice.chance(0.15);
                let step = if repeated { 0.0 } else { dice.between(0.2, 1.5) };
                knots.push(knots[knots.len() - 1] + step);
            }
            knots.push(knots[knots.len() - 1] + 0.7);
            Space::periodic(degree, knots)
                .unwrap_or_else(|_| Space::periodic_uniform(degree, spans + degree + 1).unwrap())
        }
        1 => {
            let extra = degree as f64;
            let mut knots: Vec<f64> = (0..degree).map(|i| breaks[0] - (extra - i as f64) * 0.4).collect();
            knots.extend(&breaks);
            knots.extend((1..=degree).map(|i| breaks[spans] + i as f64 * 0.3));
            Space::open(degree, knots).unwrap()
        }
        _ => {
            let mut knots = vec![breaks[0]; degree + 1];
            for &u in &breaks[1..spans] {
                let times = match kind {
                    2 => degree,
                    3 => 1 + dice.below(degree + 1),
                    _ => 1,
                };
                knots.extend(vec![u; times]);
            }
            knots.extend(vec![breaks[spans]; degree + 1]);
            Space::open(degree, knots).unwrap()
        }
    };
    let count = space.len();
    let points = (0..count)
        .map(|i| {
            Point::new(i as f64 + dice.between(-0.4, 0.4), dice.between(-2.0, 2.0), dice.between(-1.0, 1.0))
        })
        .collect();
    let weights = dice.chance(0.3).then(|| (0..count).map(|_| dice.between(0.4, 2.5)).collect());
    Curve::build(space, points, weights).unwrap()
}

/// Energies as fairing and as the book know them: weight and order of the derivative, 0 for nearness.
fn energy(dice: &mut Dice, degree: usize) -> (EnergySum, Vec<(f64, usize)>) {
    match dice.below(6) {
        0 => (stretch(), vec![(1.0, 1)]),
        1 if degree > 1 => (bend() + 0.1 * stretch(), vec![(1.0, 2), (0.1, 1)]),
        2 if degree > 2 => (variation(), vec![(1.0, 3)]),
        3 if degree > 1 => (bend() + 0.5 * near(), vec![(1.0, 2), (0.5, 0)]),
        _ if degree > 1 => (bend(), vec![(1.0, 2)]),
        _ => (stretch() + 2.0 * near(), vec![(1.0, 1), (2.0, 0)]),
    }
}

/// One thing asked: a row over the vertices of one axis, and its value; `≥` unless it is an equation.
struct Asked {
    axis: usize,
    row: Vec<f64>,
    value: f64,
    equation: bool,
    /// The name of the constraint that it is of.
    name: String,
}

struct Problem {
    curve: Curve,
    book: Book,
    energy: EnergySum,
    terms: Vec<(f64, usize)>,
    constraints: Vec<Constraint>,
    asked: Vec<Asked>,
    locks: Vec<i64>,
}

impl Problem {
    fn new(dice: &mut Dice, number: usize) -> Self {
        let curve = curve(dice, number);
        let (energy, terms) = energy(dice, curve.degree());
        let book = Book::new(&curve);
        Self { curve, book, energy, terms, constraints: Vec::new(), asked: Vec::new(), locks: Vec::new() }
    }

    fn anywhere(&self, dice: &mut Dice) -> f64 {
        let (a, b) = self.book.domain;
        match dice.below(12) {
            0 => a,
            1 => b,
            2 => self.curve.space().breakpoints()[dice.below(self.curve.space().breakpoints().len())]
                .clamp(a, b),
            _ => dice.between(a, b),
        }
    }

    fn equation(&mut self, u: f64, order: usize, value: [f64; 3]) {
        let constraint = derivative(u, order).to(value);
        for (axis, value) in value.into_iter().enumerate() {
            let (row, name) = (self.book.row(u, order), constraint.label());
            self.asked.push(Asked { axis, row, value, equation: true, name });
        }
        self.constraints.push(constraint);
    }

    fn bound(&mut self, u: f64, axis: usize, low: bool, value: f64) {
        let which = [Axis::X, Axis::Y, Axis::Z][axis];
        let asked = position(u).axis(which);
        let constraint = if low { asked.at_least(value) } else { asked.at_most(value) };
        let sign = if low { 1.0 } else { -1.0 };
        let row = self.book.row(u, 0).iter().map(|c| sign * c).collect();
        let name = constraint.label();
        self.asked.push(Asked { axis, row, value: sign * value, equation: false, name });
        self.constraints.push(constraint);
    }

    fn fair(&self) -> Result<(Vec<Point>, f64), String> {
        let fair = Fair::new(&self.curve).energy(self.energy.clone()).lock(self.locks.iter().copied());
        let fair = self.constraints.iter().fold(fair, |fair, c| fair.ask(c.clone()));
        let done = fair.solve().map_err(|e| e.to_string())?;
        Ok((done.shape().points().to_vec(), done.report().energy_after))
    }

    /// Rows and right-hand sides of one axis whose squares are the energy.
    fn squares(&self, axis: usize) -> Vec<(Vec<f64>, f64)> {
        let mut all = Vec::new();
        for &(weight, order) in &self.terms {
            for row in self.book.integral(order) {
                let target = match order {
                    0 => row.iter().zip(self.curve.points()).map(|(c, p)| c * p[axis]).sum(),
                    _ => 0.0,
                };
                let root = f64::sqrt(weight);
                all.push((row.iter().map(|c| c * root).collect(), target * root));
            }
        }
        all
    }

    fn energy_of(&self, points: &[Point]) -> f64 {
        let of = |axis: usize| -> f64 {
            let rows = self.squares(axis);
            let each =
                rows.iter().map(|(a, r)| a.iter().zip(points).map(|(c, p)| c * p[axis]).sum::<f64>() - r);
            each.map(|e| e * e).sum()
        };
        (0..3).map(of).sum()
    }

    /// The rows of one axis that are named, equations first, and how many these are.
    fn rows(&self, axis: usize, named: &dyn Fn(&str) -> bool) -> (Vec<(Vec<f64>, f64)>, usize) {
        let of = |equation: bool| {
            let some = self.asked.iter().filter(move |a| a.axis == axis && a.equation == equation);
            some.filter(|a| named(&a.name)).map(|a| (a.row.clone(), a.value))
        };
        let mut rows: Vec<(Vec<f64>, f64)> = of(true).collect();
        let mut equations = rows.len();
        for &lock in &self.locks {
            let mut row = vec![0.0; self.book.count];
            row[lock as usize] = 1.0;
            rows.insert(0, (row, self.curve.points()[lock as usize][axis]));
            equations += 1;
        }
        rows.extend(of(false));
        (rows, equations)
    }

    /// By how much something must be missed of what is named.
    fn contradiction(&self, named: &dyn Fn(&str) -> bool) -> f64 {
        let of = |axis| {
            let (rows, equations) = self.rows(axis, named);
            violation(&rows, equations, self.book.count)
        };
        (0..3).map(of).fold(0.0, |m: f64, v| if v.is_nan() || m.is_nan() { f64::NAN } else { m.max(v) })
    }
}

/// Bands around a curve that there is: some wide, some narrow, some of no width.
fn feasible(dice: &mut Dice, number: usize) -> (Problem, Vec<Point>) {
    let mut problem = Problem::new(dice, number);
    let wild = dice.between(0.1, 3.0);
    let mut reference: Vec<Point> = problem
        .curve
        .points()
        .iter()
        .map(|p| Point::new(p.x, p.y + dice.between(-wild, wild), p.z))
        .collect();
    if dice.chance(0.2) {
        let lock = dice.below(reference.len());
        problem.locks.push(lock as i64);
        reference[lock] = problem.curve.points()[lock];
    }
    let at = |problem: &Problem, u: f64, order: usize| {
        [0, 1, 2].map(|axis| problem.book.value(&reference, u, order, axis))
    };
    for _ in 0..dice.below(3) {
        let u = problem.anywhere(dice);
        let order = dice.below(2).min(problem.curve.degree());
        let value = at(&problem, u, order);
        // Some say the same twice.
        for _ in 0..=dice.below(2) {
            problem.equation(u, order, value);
        }
        // Drawn for what is no longer there, so that the problems stay those that they were.
        _ = dice.chance(0.2);
    }
    let width = [0.5, 0.1, 0.02][dice.below(3)];
    for _ in 0..10 + dice.below(51) {
        let u = problem.anywhere(dice);
        let axis = if dice.chance(0.9) { 1 } else { dice.below(3) };
        let value = at(&problem, u, 0)[axis];
        let narrow = if dice.chance(0.05) { 0.0 } else { 1.0 };
        let (below, above) = (dice.between(0.0, width) * narrow, dice.between(0.0, width) * narrow);
        match dice.below(4) {
            0 => problem.bound(u, axis, true, value - below),
            1 => problem.bound(u, axis, false, value + above),
            _ => {
                problem.bound(u, axis, true, value - below);
                problem.bound(u, axis, false, value + above);
            }
        }
    }
    (problem, reference)
}

#[test]
fn whatever_can_be_had_between_bounds_is_had() {
    let mut dice = Dice(0x5eed_cafe_f00d_d1ce);
    let (mut refused, mut compared) = (Vec::new(), 0);
    for number in 0..210 {
        let (problem, reference) = feasible(&mut dice, number);
        let kind = format!(
            "{number}: degree {}, {} vertices, {} asked, {}",
            problem.curve.degree(),
            problem.book.count,
            problem.asked.len(),
            problem.energy
        );
        let (a, b) = problem.book.domain;
        for k in 0..5 {
            let u = a + (b - a) * (0.03 + 0.23 * f64::from(k));
            let own = problem.book.value(problem.curve.points(), u, 0, 1);
            assert!((own - problem.curve.point(u).unwrap().y).abs() < 1e-12, "{kind}: the book at {u}");
        }
        let (points, told) = match problem.fair() {
            Ok(done) => done,
            Err(why) => {
                refused.push(format!("{kind}: {why}"));
                continue;
            }
        };
        let size = points.iter().chain(&reference).fold(1.0, |m: f64, p| m.max(p.coords.amax()));
        for asked in &problem.asked {
            let value: f64 = asked.row.iter().zip(&points).map(|(c, p)| c * p[asked.axis]).sum();
            let all: f64 = asked.row.iter().map(|c| c.abs()).sum();
            let error = if asked.equation { (value - asked.value).abs() } else { asked.value - value };
            assert!(error <= 2e-11 * size * all.max(1.0), "{kind}: {} by {error:e}", asked.name);
        }
        for &lock in &problem.locks {
            assert_eq!(points[lock as usize], problem.curve.points()[lock as usize], "{kind}");
        }
        let (energy, before) = (problem.energy_of(&points), problem.energy_of(&reference));
        assert!((energy - told).abs() <= 1e-8 * energy + 1e-12 * before, "{kind}: {energy} and {told}");
        assert!(energy <= before * (1.0 + 1e-9) + 1e-18 * size * size, "{kind}: {energy} from {before}");
        assert!(
            points.iter().zip(problem.curve.points()).all(|(p, q)| (p - q).norm() < 1e3 * size),
            "{kind}: {points:?}"
        );
        // Another program's least.
        let mut all = Some(0.0);
        for axis in 0..3 {
            let (rows, equations) = problem.rows(axis, &|_| true);
            let one = least(&problem.squares(axis), &rows, equations, problem.book.count);
            all = all.zip(one).map(|(a, b)| a + b);
        }
        if let Some(least) = all {
            compared += 1;
            assert!(
                energy <= least + 1e-5 * least.abs() + 1e-6 * before,
                "{kind}: {energy} where {least} can be had"
            );
        }
    }
    assert!(refused.is_empty(), "{} refused: {refused:#?}", refused.len());
    assert!(compared >= 150, "only {compared} compared");
}

#[test]
fn what_contradicts_is_named_and_nothing_else() {
    let mut dice = Dice(0x0bad_5eed_0bad_f00d);
    let (mut judged, mut wrong) = (0, Vec::new());
    for number in 0..150 {
        let (mut problem, reference) = feasible(&mut dice, number);
        let gap = dice.between(0.05, 1.0);
        match number % 4 {
            // Above one value and below a lesser one, at places that are near.
            0 => {
                let u = problem.anywhere(&mut dice);
                let value = problem.book.value(&reference, u, 0, 1);
                problem.bound(u, 1, true, value + gap);
                problem.bound(u, 1, false, value - gap);
            }
            // More wiggles than there are vertices.
            1 => {
                let (a, b) = problem.book.domain;
                for k in 0..3 * problem.book.count {
                    let u = a + (b - a) * (k as f64 + 0.5) / (3 * problem.book.count) as f64;
                    problem.bound(u, 1, k % 2 == 0, if k % 2 == 0 { gap } else { -gap });
                }
            }
            // Two equations.
            2 => {
                let u = dice.between(problem.book.domain.0, problem.book.domain.1);
                let value = [0, 1, 2].map(|axis| problem.book.value(&reference, u, 0, axis));
                problem.equation(u, 0, value);
                problem.bound(u, 1, number % 8 == 2, value[1] + if number % 8 == 2 { gap } else { -gap });
            }
            // The curve pinned everywhere, and a bound elsewhere.
            _ => {
                let (a, b) = problem.book.domain;
                let count = problem.book.count;
                for k in 0..count {
                    let u = a + (b - a) * (k as f64 + 0.5) / count as f64;
                    let value = [0, 1, 2].map(|axis| problem.book.value(&reference, u, 0, axis));
                    problem.equation(u, 0, value);
                }
                let u = a + (b - a) * dice.between(0.2, 0.8);
                let value = problem.book.value(&reference, u, 0, 1);
                problem.bound(u, 1, false, value - gap);
            }
        }
        let kind = format!("{number}: degree {}, {} vertices", problem.curve.degree(), problem.book.count);
        let must = problem.contradiction(&|_| true);
        let done = problem.fair();
        if must.is_nan() || must < 1e-5 {
            // The additions did not contradict after all (a pinned curve may still bend), or nobody can tell.
            if must < 1e-9 {
                assert!(done.is_ok(), "{kind}: {}", done.unwrap_err());
            }
            continue;
        }
        let text = match done {
            Ok(_) => panic!("{kind}: an answer though {must} must be missed"),
            Err(text) => text,
        };
        judged += 1;
        let named = |name: &str| text.contains(&format!("\"{name}\""));
        let mut names: Vec<&str> =
            problem.asked.iter().map(|a| a.name.as_str()).filter(|n| named(n)).collect();
        names.sort_unstable();
        names.dedup();
        let together = problem.contradiction(&|name| names.contains(&name));
        if names.is_empty() || together.is_nan() || together < 1e-9 {
            wrong.push(format!("{kind}: {} named that can all hold ({together:e}): {text}", names.len()));
            continue;
        }
        for spared in &names {
            let without = problem.contradiction(&|name| name != *spared && names.contains(&name));
            if without > 1e-6 {
                wrong.push(format!("{kind}: \"{spared}\" can be spared ({without:e}): {text}"));
            }
        }
    }
    assert!(judged >= 100, "only {judged} contradict");
    let wrong: Vec<String> = wrong.into_iter().map(|w: String| w.chars().take(400).collect()).collect();
    assert!(wrong.is_empty(), "{} wrong: {wrong:#?}", wrong.len());
}
