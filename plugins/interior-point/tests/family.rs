//! A random family with inequalities for every solver, the interior-point one among them: what can be had is had and least, by
//! conditions that the test checks itself; what contradicts is named, no more and no less, by non-negative least squares.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_interior_point::InteriorPoint;
use loftsman_kernel::edit::{Ask, Axis, Constraint, Edit};
use loftsman_kernel::functional::{curvature, derivative, position};
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, HouseholderQr, Outcome, Program, SaddlePoint, Sense, SolveError, Solver,
    Sparse, SparseRows, Symmetric, System, SystemMetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Numbers without order, the same on every machine (Marsaglia's xorshift).
struct Dice(u64);

impl Dice {
    fn number(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.number() * count as f64) as usize).min(count - 1)
    }
}

fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Sparse),
        Arc::new(Adjoint),
        Arc::new(HouseholderQr),
        Arc::new(DenseLu),
        Arc::new(SaddlePoint),
        Arc::new(InteriorPoint),
    ]
}

/// Rows `aᵀx` beside their sides, and a metric that is banded or none.
struct Rows {
    n: usize,
    rows: Vec<Vec<f64>>,
    senses: Vec<Sense>,
    rhs: Vec<f64>,
    banded: bool,
}

impl Rows {
    fn dot(&self, row: usize, x: &[f64]) -> f64 {
        self.rows[row].iter().zip(x).map(|(a, x)| a * x).sum()
    }

    fn metric(&self, x: &[f64]) -> Vec<f64> {
        let at = |i: usize, by: i64| i.checked_add_signed(by as isize).and_then(|j| x.get(j)).unwrap_or(&0.0);
        let row = |i| 2.5 * x[i] - at(i, 1) - at(i, -1);
        if self.banded { (0..self.n).map(row).collect() } else { x.to_vec() }
    }

    fn system(&self) -> System {
        let mut rows = SparseRows::new(self.n);
        for row in &self.rows {
            rows.push(row.iter().copied().enumerate().filter(|(_, v)| *v != 0.0));
        }
        let matrix = || {
            let band = (0..self.n).flat_map(|i| {
                [Some((i, i, 2.5)), i.checked_sub(1).map(|j| (i, j, -1.0))].into_iter().flatten()
            });
            SystemMetric::Matrix(Arc::new(Symmetric::from_entries(self.n, band)))
        };
        let metric = if self.banded { matrix() } else { SystemMetric::Least };
        System::new(rows, (0..self.n).collect(), 1, metric)
    }

    /// Whether some of the rows contradict each other (Farkas): a combination of them, of the right signs, says `0 ≥ 1`.
    fn contradict(&self, named: &[usize]) -> bool {
        let mut columns = Vec::new();
        for &row in named {
            let sign = if self.senses[row] == Sense::AtMost { -1.0 } else { 1.0 };
            let column = |sign: f64| -> Vec<f64> {
                self.rows[row].iter().chain([&self.rhs[row]]).map(|v| sign * v).collect()
            };
            columns.push(column(sign));
            if self.senses[row] == Sense::Equal {
                columns.push(column(-1.0));
            }
        }
        let mut wanted = vec![0.0; self.n];
        wanted.push(1.0);
        nonnegative_residual(&columns, &wanted) < 1e-7
    }
}

/// `|Σ yᵢ cᵢ - b|` at its least over `y ≥ 0` (Lawson and Hanson 1974), squares solved by orthogonalization.
fn nonnegative_residual(columns: &[Vec<f64>], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let least = |some: &[usize]| -> Vec<f64> {
        let (mut q, mut r): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        for &k in some {
            let (mut column, mut above) = (columns[k].clone(), vec![0.0; q.len()]);
            for _ in 0..2 {
                for (axis, sum) in q.iter().zip(&mut above) {
                    let part = dot(axis, &column);
                    *sum += part;
                    column.iter_mut().zip(axis).for_each(|(c, a)| *c -= part * a);
                }
            }
            let length = dot(&column, &column).sqrt().max(1e-300);
            column.iter_mut().for_each(|c| *c /= length);
            above.push(length);
            q.push(column);
            r.push(above);
        }
        let mut y: Vec<f64> = q.iter().map(|axis| dot(axis, b)).collect();
        for i in (0..y.len()).rev() {
            let later: f64 = (i + 1..y.len()).map(|k| r[k][i] * y[k]).sum();
            y[i] = (y[i] - later) / r[i][i];
        }
        y
    };
    let (mut some, mut y): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    let rest = |some: &[usize], y: &[f64]| {
        let mut rest = b.to_vec();
        for (&k, y) in some.iter().zip(y) {
            rest.iter_mut().zip(&columns[k]).for_each(|(r, c)| *r -= y * c);
        }
        rest
    };
    for _ in 0..6 * columns.len() {
        let left = rest(&some, &y);
        let gain = |k: &usize| dot(&columns[*k], &left) / dot(&columns[*k], &columns[*k]).sqrt().max(1e-300);
        let next = (0..columns.len())
            .filter(|k| !some.contains(k))
            .max_by(|a, b| gain(a).total_cmp(&gain(b)))
            .filter(|k| gain(k) > 1e-12);
        let Some(next) = next else { break };
        some.push(next);
        y.push(0.0);
        loop {
            let to = least(&some);
            let stop = (0..some.len()).filter(|&i| to[i] <= 0.0);
            let share = stop.map(|i| y[i] / (y[i] - to[i])).fold(1.0, f64::min);
            if (0..some.len()).all(|i| to[i] > 0.0) {
                y = to;
                break;
            }
            y.iter_mut().zip(&to).for_each(|(y, to)| *y += share * (to - *y));
            let kept: Vec<bool> = (0..some.len())
                .map(|i| y[i] > 1e-14 && !(to[i] <= 0.0 && share == 0.0 && i + 1 == some.len()))
                .collect();
            let mut flags = kept.iter();
            some.retain(|_| *flags.next().unwrap());
            let mut flags = kept.iter();
            y.retain(|_| *flags.next().unwrap());
            if some.is_empty() {
                break;
            }
        }
    }
    let left = rest(&some, &y);
    dot(&left, &left).sqrt()
}

/// Rows of a few entries around a point that meets them all; `tangled`, and others that say the opposite of a sum of some.
fn member(dice: &mut Dice, number: usize) -> (Rows, bool) {
    let n = 3 + dice.below(14);
    let inside: Vec<f64> = (0..n).map(|_| dice.between(-2.0, 2.0)).collect();
    let mut all = Rows { n, rows: vec![], senses: vec![], rhs: vec![], banded: dice.below(2) == 0 };
    let equations = dice.below(n.div_ceil(3));
    for k in 0..equations + 2 + dice.below(3 * n) {
        let mut row = vec![0.0; n];
        for _ in 0..1 + dice.below(4) {
            row[dice.below(n)] += [1.0, -1.0, dice.between(-3.0, 3.0)][dice.below(3)];
        }
        let value: f64 = row.iter().zip(&inside).map(|(a, x)| a * x).sum();
        let room = if dice.below(5) == 0 { 0.0 } else { dice.between(0.0, 1.0) };
        let (sense, rhs) = match (k < equations, dice.below(2)) {
            (true, _) => (Sense::Equal, value),
            (_, 0) => (Sense::AtLeast, value - room),
            _ => (Sense::AtMost, value + room),
        };
        all.rows.push(row);
        all.senses.push(sense);
        all.rhs.push(rhs);
    }
    let contradicting = number % 3 == 2;
    if contradicting {
        // Σ y a ≥ Σ y b follows from some rows, and another asks for less.
        let (mut row, mut least) = (vec![0.0; n], 0.0);
        for _ in 0..1 + dice.below(3) {
            let k = dice.below(all.rows.len());
            let sign = if all.senses[k] == Sense::AtMost { -1.0 } else { 1.0 };
            let y = sign * dice.between(0.3, 2.0);
            row.iter_mut().zip(&all.rows[k]).for_each(|(r, a)| *r += y * a);
            least += y * all.rhs[k];
        }
        all.rows.push(row);
        all.senses.push(Sense::AtMost);
        all.rhs.push(least - dice.between(0.05, 1.0));
    }
    (all, contradicting)
}

enum Found {
    Least(Vec<f64>, Vec<f64>),
    Contradiction(Vec<usize>),
    Refused(SolveError),
}

fn solve(solver: &dyn Solver, all: &Rows) -> Found {
    let system = all.system();
    let size = vec![1.0; all.rhs.len()];
    let program = Program { system: &system, rhs: &all.rhs, senses: &all.senses, size: &size };
    let active = match solver.program(&program) {
        Ok(Outcome::Active { rows, .. }) => rows,
        Ok(Outcome::Infeasible { rows }) => return Found::Contradiction(rows),
        Ok(other) => panic!("{other:?}"),
        Err(error) => return Found::Refused(error),
    };
    let mut kept: Vec<usize> = (0..all.rhs.len()).filter(|&r| all.senses[r] == Sense::Equal).collect();
    kept.extend(active);
    kept.sort_unstable();
    kept.dedup();
    let rhs: Vec<f64> = kept.iter().map(|&r| all.rhs[r]).collect();
    let mut factored = match solver.factor(&system.select(&kept)) {
        Ok(factored) => factored,
        Err(error) => return Found::Refused(error),
    };
    let (mut d, mut some) = (vec![0.0; all.n], vec![0.0; kept.len()]);
    factored.solve_into(&rhs, &mut d);
    factored.multipliers_into(&rhs, &mut some);
    let mut multipliers = vec![0.0; all.rhs.len()];
    kept.iter().zip(some).for_each(|(&row, m)| multipliers[row] = m);
    Found::Least(d, multipliers)
}

/// The conditions of Karush, Kuhn and Tucker: `d` is feasible, `W d = Σ λ a`, and what has room does not pull.
fn is_least(all: &Rows, d: &[f64], multipliers: &[f64], name: &str) {
    let size = d.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
    let pull = multipliers.iter().fold(size, |m, v| m.max(v.abs()));
    let mut gradient = all.metric(d);
    for (row, &multiplier) in multipliers.iter().enumerate() {
        let missing = all.rhs[row] - all.dot(row, d);
        let (violation, wrong) = match all.senses[row] {
            Sense::Equal => (missing.abs(), 0.0),
            Sense::AtLeast => (missing, -multiplier),
            Sense::AtMost => (-missing, multiplier),
        };
        assert!(violation <= 1e-10 * size, "{name}: row {row} is missed by {violation:e}");
        assert!(wrong <= 1e-9 * pull, "{name}: row {row} pulls the wrong way, {multiplier:e}");
        let idle = all.senses[row] == Sense::Equal || (missing * multiplier).abs() <= 1e-9 * size * pull;
        assert!(idle, "{name}: row {row} has room {missing:e} and pulls {multiplier:e}");
        gradient.iter_mut().zip(&all.rows[row]).for_each(|(g, a)| *g -= multiplier * a);
    }
    let worst = gradient.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(worst <= 1e-8 * pull, "{name}: W d is not Σ λ a, by {worst:e}");
}

#[test]
fn programs_are_solved_or_contradicted_by_every_solver() {
    let mut dice = Dice(0x1bad_b002_1bad_b002);
    let (mut least, mut contradicted, mut refused) = (0, 0, Vec::new());
    for number in 0..240 {
        let (all, contradicting) = member(&mut dice, number);
        let every: Vec<usize> = (0..all.rhs.len()).collect();
        assert_eq!(all.contradict(&every), contradicting, "{number}: the test's own judgement");
        let mut answers: Vec<(String, Vec<f64>)> = Vec::new();
        for solver in solvers() {
            let name = format!("{number}, {}, {} unknowns, {} rows", solver.name(), all.n, every.len());
            match solve(solver.as_ref(), &all) {
                Found::Least(d, multipliers) => {
                    assert!(!contradicting, "{name}: answered {d:?}");
                    is_least(&all, &d, &multipliers, &name);
                    answers.push((name, d));
                    least += 1;
                }
                Found::Contradiction(rows) => {
                    assert!(contradicting, "{name}: {rows:?} called a contradiction");
                    assert!(all.contradict(&rows), "{name}: {rows:?} can all hold");
                    for spared in &rows {
                        let others: Vec<usize> = rows.iter().copied().filter(|r| r != spared).collect();
                        assert!(!all.contradict(&others), "{name}: {spared} of {rows:?} can be spared");
                    }
                    contradicted += 1;
                }
                Found::Refused(error) => refused.push(format!("{name}: {error}")),
            }
        }
        for (name, d) in &answers {
            let (first, other) = &answers[0];
            let apart = d.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-8, "{name} and {first} differ by {apart:e}");
        }
    }
    println!(
        "{least} solved, {contradicted} contradicted, {} refused:\n{}",
        refused.len(),
        refused.join("\n")
    );
    assert!(least >= 700 && contradicted >= 350, "{least} solved, {contradicted} contradicted");
    assert!(refused.len() <= MOST_REFUSED, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// Of 1440; `adjoint` takes six equations.
const MOST_REFUSED: usize = 70;

/// The value of a curve at `u` by de Boor's algorithm, from its right.
fn value(curve: &Curve, u: f64) -> [f64; 3] {
    let (p, t) = (curve.degree(), curve.space().knots());
    let n = curve.points().len();
    let span = (p..n).rev().find(|&k| t[k] <= u && t[k] < t[k + 1]).unwrap();
    let mut d: Vec<[f64; 3]> = (0..=p).map(|j| curve.points()[span - p + j].coords.into()).collect();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let (low, high) = (t[span - p + j], t[span + 1 + j - r]);
            let share = (u - low) / (high - low);
            d[j] = [0, 1, 2].map(|k| (1.0 - share) * d[j - 1][k] + share * d[j][k]);
        }
    }
    d[p]
}

/// One thing asked, the test's own way.
struct Asked {
    u: f64,
    axis: usize,
    low: f64,
    high: f64,
    label: String,
}

#[test]
fn curves_stay_in_bounds_or_say_which_contradict_by_every_solver() {
    const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
    let mut dice = Dice(0xfeed_5eed_feed_5eed);
    let (mut met, mut named, mut refused) = (0, 0, Vec::new());
    for number in 0..120 {
        let degree = 1 + dice.below(5);
        let spans = 2 + dice.below(6);
        let breaks: Vec<f64> =
            (0..=spans).map(|k| k as f64 + if k > 0 { dice.between(0.0, 0.8) } else { 0.0 }).collect();
        let space = Space::clamped(degree, &breaks).unwrap();
        let count = space.len();
        let size = [1.0, 1e-6, 1e6][dice.below(3)];
        let points: Vec<Point> = (0..count)
            .map(|i| Point::new(i as f64, dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)) * size)
            .collect();
        let before = Curve::new(space, points).unwrap();
        // A curve of the same space that meets everything.
        let mut moved: Vec<Point> = before.points().to_vec();
        // The first stays, since it may be locked.
        for point in &mut moved[1..] {
            *point += Vector::new(dice.between(-0.3, 0.3), dice.between(-0.8, 0.8), 0.0) * size;
        }
        let reference = Curve::new(before.space().clone(), moved).unwrap();
        let (mut constraints, mut asked): (Vec<Constraint>, Vec<Asked>) = (Vec::new(), Vec::new());
        let mut ask = |constraint: Constraint, u: f64, axis: usize, low: f64, high: f64| {
            asked.push(Asked { u, axis, low, high, label: constraint.label() });
            constraints.push(constraint);
        };
        for _ in 0..3 + dice.below(20) {
            let (u, axis) = (dice.between(0.0, breaks[spans]), dice.below(2));
            let at = value(&reference, u)[axis];
            let room = dice.between(0.0, 0.3) * size;
            let on = || position(u).axis(AXES[axis]);
            match dice.below(5) {
                0 => ask(on().to(at), u, axis, at, at),
                1 | 2 => ask(on().at_least(at - room), u, axis, at - room, f64::INFINITY),
                _ => ask(on().at_most(at + room), u, axis, f64::NEG_INFINITY, at + room),
            }
        }
        // A contradiction: a place above what another bound, the very same place, or a locked vertex leaves it.
        let gap = dice.between(0.1, 1.0) * size;
        let u = dice.between(0.1, breaks[spans]);
        let mut lock = Vec::new();
        let (contradicting, mut must) = (number % 3, Vec::new());
        if contradicting == 1 {
            let z = value(&before, u)[2];
            let pair = [position(u).axis(Axis::Z).at_least(z + gap), position(u).axis(Axis::Z).at_most(z)];
            must.extend(pair.iter().map(Constraint::label));
            constraints.extend(pair);
        } else if contradicting == 2 {
            lock.push(0);
            let z = value(&before, 0.0)[2];
            let one = position(0.0).axis(Axis::Z).at_least(z + gap);
            must.push(one.label());
            constraints.push(one);
        }
        let mut answers: Vec<Curve> = Vec::new();
        for solver in solvers() {
            let name = format!("{number}, {}, degree {degree}", solver.name());
            let edit = Edit::new(&before).lock(lock.iter().copied());
            let edit = constraints.iter().fold(edit, |edit, c| edit.ask(c.clone()));
            match edit.solve_with(Arc::clone(&solver)) {
                Ok(edited) => {
                    assert!(must.is_empty(), "{name}: answered, with {must:?}: {}", edited.report());
                    for asked in &asked {
                        let at = value(edited.shape(), asked.u)[asked.axis];
                        let over = (asked.low - at).max(at - asked.high);
                        let whole = size * (1.0 + count as f64);
                        assert!(over <= 1e-12 * whole, "{name}: {} by {over:e}", asked.label);
                    }
                    answers.push(edited.shape().clone());
                    met += 1;
                }
                Err(error) => {
                    let text = error.to_string();
                    if must.is_empty() || !must.iter().all(|label| text.contains(label.as_str())) {
                        refused.push(format!("{name}: {text}"));
                        continue;
                    }
                    let innocent = asked.iter().find(|a| text.contains(&format!("\"{}\"", a.label)));
                    assert!(innocent.is_none(), "{name}: {} is named too: {text}", innocent.unwrap().label);
                    named += 1;
                }
            }
        }
        for other in answers.iter().skip(1) {
            let apart = answers[0].points().iter().zip(other.points()).map(|(a, b)| (a - b).amax());
            let apart = apart.fold(0.0, f64::max);
            assert!(apart <= 1e-8 * size, "{number}: solvers differ by {apart:e}");
        }
    }
    println!("{met} met, {named} named, {} refused:\n{}", refused.len(), refused.join("\n"));
    assert!(refused.iter().all(|r| r.contains("too many for the solver \"adjoint\"")), "{refused:#?}");
    assert!(met >= 200 && named >= 400, "{met} met, {named} named");
    assert!(refused.len() <= 8, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// What is not linear beside a bound: κ is as asked and the bound holds, or both are named.
#[test]
fn curvature_beside_bounds_by_every_solver() {
    let mut dice = Dice(0xc0de_cafe_c0de_cafe);
    let (mut met, mut refused) = (0, Vec::new());
    for number in 0..100 {
        let space = Space::clamped_uniform(3 + dice.below(3), 10).unwrap();
        let points: Vec<Point> = (0..10)
            .map(|i| {
                Point::new(
                    f64::from(i),
                    (0.7 * f64::from(i)).sin() + dice.between(-0.1, 0.1),
                    dice.between(-0.2, 0.2),
                )
            })
            .collect();
        let before = Curve::new(space, points).unwrap();
        let (a, b) = before.domain();
        let (u, v) = (dice.between(a, a + 0.4 * (b - a)), dice.between(a + 0.6 * (b - a), b));
        let factor = dice.between(0.6, 1.6);
        let up = value(&before, v)[1] + dice.between(0.05, 0.4);
        let kappa = |c: &Curve| {
            let (one, two) = (c.derivative(u, 1).unwrap(), c.derivative(u, 2).unwrap());
            one.cross(&two).norm() / one.norm().powi(3)
        };
        let clash = number % 4 == 3;
        for solver in solvers() {
            let name = format!("{number}, {}", solver.name());
            let mut edit = Edit::new(&before).ask(curvature(u).scale(factor));
            edit = edit.ask(derivative(u, 1).scale(dice.between(0.7, 1.4)));
            edit = edit.ask(position(v).axis(Axis::Y).at_least(up));
            if clash {
                edit = edit.ask(curvature(u).scale(factor + 0.5));
            }
            match edit.solve_with(solver) {
                Ok(edited) => {
                    assert!(!clash, "{name}: two curvatures at one place: {}", edited.report());
                    let (is, was) = (kappa(edited.shape()), kappa(&before));
                    assert!((is - factor * was).abs() <= 1e-9 * was, "{name}: {is} of {was} by {factor}");
                    assert!(value(edited.shape(), v)[1] >= up - 1e-11, "{name}");
                    met += 1;
                }
                Err(error) if clash && !error.to_string().contains("too many for the solver") => {
                    assert!(error.to_string().contains("\"curvature at "), "{name}: {error}");
                }
                Err(error) => refused.push(format!("{name}: {error}")),
            }
        }
    }
    println!("{met} met, {} refused:\n{}", refused.len(), refused.join("\n"));
    assert!(refused.iter().all(|r| r.contains("too many for the solver \"adjoint\"")), "{refused:#?}");
    assert!(
        met >= 350 && refused.len() <= 100,
        "{met} met, {} refused:\n{}",
        refused.len(),
        refused.join("\n")
    );
}
