//! What an event hands out, checked: every prepared row, on the vertices as they will be, and the proportion of the way.

use std::collections::BTreeSet;

use smallvec::SmallVec;

use super::Numbers;
use super::assembly::Assembly;
use super::bound::BoundConstraint;
use super::conflict::quoted;
use super::constraint::Constraint;
use crate::functional::Accuracy;
use crate::measure::{Error, PROPORTION, ROUNDING, error_of};
use crate::solve::{Factored, Sense, SolveError, System, SystemMetric, Whitened};
use crate::{Point, Vector};

/// What is known of a system's rows at mouse down, to check them at every mouse move.
#[derive(Debug)]
pub(crate) struct Check {
    /// `Σ |coefficient|` of each row.
    rough: Numbers,
    /// `1 / ‖row‖`: the way that a change of its value by 1 alone would cost; zero for a row without a length.
    cost: Numbers,
    /// The largest coordinate of the vertices that move.
    pub(crate) reach: f64,
    measure: Measure,
    /// How long the adjustment is without the handle, and what each number of the handle adds by changing by 1.
    still: f64,
    response: Numbers,
    /// Whether no event can be out of proportion, wherever the handle goes.
    pub(crate) proportionate: bool,
}

/// Lengths in a metric.
#[derive(Debug)]
struct Lengths {
    metric: Box<Whitened>,
    /// `1 / ‖row‖` with the inverse metric.
    cost: Numbers,
}

/// How the length of an adjustment is measured.
#[derive(Debug)]
enum Measure {
    /// As it is.
    Plain,
    /// Not at all: the rows are so well conditioned that no adjustment can be out of proportion.
    Harmless,
    /// In a metric.
    Metric(Box<Lengths>),
    /// As it is, of what unknowns make of each row alone.
    Through(Numbers),
}

/// Below this condition of unit rows no adjustment is out of [`PROPORTION`]: it is at most as many times as long as those
/// that its equations alone would cost. Conditions are estimated, rarely below a third of what they are.
const HARMLESS: f64 = 1e4;

impl Measure {
    fn new(system: &System, factored: &dyn Factored) -> Result<Self, SolveError> {
        if matches!(system.metric(), SystemMetric::Least) {
            return Ok(Self::Plain);
        }
        if factored.diagnosis().condition < HARMLESS {
            return Ok(Self::Harmless);
        }
        Ok(match system.whitened()? {
            None => Self::Plain,
            Some(metric) if matches!(system.metric(), SystemMetric::Through(_)) => {
                Self::Through(ways(system.rows().width(), *metric))
            }
            Some(metric) => {
                let cost = reciprocals(&metric.rows);
                Self::Metric(Box::new(Lengths { metric, cost }))
            }
        })
    }

    /// What a change of each row's value by 1 costs, where that is `plain` without a metric; `None` where it does not matter.
    fn cost<'a>(&'a self, plain: &'a [f64]) -> Option<&'a [f64]> {
        match self {
            Self::Harmless => None,
            Self::Plain => Some(plain),
            Self::Metric(lengths) => Some(&lengths.cost),
            Self::Through(cost) => Some(cost),
        }
    }

    /// The length of an adjustment with so many sides; of none where it does not matter.
    fn length(&mut self, d: &[f64], sides: usize) -> f64 {
        match self {
            Self::Plain | Self::Through(_) => length(d),
            Self::Harmless => 0.0,
            Self::Metric(lengths) => lengths.metric.squared_length(d, sides).sqrt(),
        }
    }
}

/// The adjustment that a number of the handle asks for by changing by 1: of each vertex that moves, or of each of its numbers.
pub(crate) type Response = SmallVec<[f64; 4]>;

/// Vertices that an adjustment has moved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moved<'a> {
    /// Where they were.
    pub(crate) base: &'a [Point],
    /// The way that each really went, its coordinates being rounded.
    pub(crate) way: &'a [[f64; 3]],
    /// Whether all of it is finite.
    pub(crate) finite: bool,
}

impl<'a> Moved<'a> {
    /// From `base` by `d`; the way into `way`, which is as long.
    pub(crate) fn by(base: &'a [Point], d: &[f64], way: &'a mut [[f64; 3]]) -> Self {
        let mut sum = [0.0; 3];
        for ((base, d), way) in base.iter().zip(d.as_chunks().0).zip(&mut *way) {
            (_, *way) = step(base, d, &mut sum);
        }
        Self { base, way, finite: was_finite(&sum) }
    }

    /// The largest coordinate.
    fn reach(&self) -> f64 {
        let largest = |(p, way): (&Point, &[f64; 3])| (p.coords + Vector::from(*way)).amax();
        self.base.iter().zip(self.way).map(largest).fold(0.0, f64::max)
    }
}

/// Where a vertex arrives, and the way that it really goes, its coordinates being rounded. Zero times what is not finite is NaN,
/// and NaN stays in a sum: `sum` tells afterwards whether all was [finite](was_finite).
#[inline]
pub(crate) fn step(base: &Point, d: &[f64; 3], sum: &mut [f64; 3]) -> (Point, [f64; 3]) {
    let p = [base.x + d[0], base.y + d[1], base.z + d[2]];
    let way = [p[0] - base.x, p[1] - base.y, p[2] - base.z];
    (0..3).for_each(|k| sum[k] += way[k] * 0.0);
    (Point::from(p), way)
}

/// Whether every [step] that added to a sum led to finite numbers.
#[inline]
pub(crate) fn was_finite(sum: &[f64; 3]) -> bool {
    sum[0] + sum[1] + sum[2] == 0.0
}

/// Why an adjustment is not handed out.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Miss {
    /// It leads out of the numbers.
    Overflow,
    /// It misses this row.
    Row(usize, Error),
}

/// An adjustment that is out of proportion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Excess {
    pub(crate) length: f64,
    /// How many times as long it is as the adjustments together that each equation alone would cost.
    pub(crate) times: f64,
}

/// An adjustment so many times as long as what its equations ask one by one is worth a word.
pub(crate) const NOTABLE: f64 = 1e4;

impl Excess {
    /// What is not finite overflows, which the rows tell.
    fn of(length: f64, alone: f64, most: f64) -> Option<Self> {
        (length > most * alone && length < f64::INFINITY).then(|| Self { length, times: length / alone })
    }
}

fn reciprocals(rows: &crate::solve::SparseRows) -> Numbers {
    let cost = |row| {
        let norm = rows.norm(row);
        if norm > 0.0 { (1.0 / norm).min(f64::MAX) } else { 0.0 }
    };
    let mut costs = Numbers::from_elem(0.0, rows.len());
    costs.iter_mut().enumerate().for_each(|(row, c)| *c = cost(row));
    costs
}

/// How far the vertices go for each row alone, for a change of its value by 1: `‖T e‖ / ‖e‖²` of its row `e` in the coordinates
/// of the metric. Zero for a row that the unknowns do not reach.
fn ways(columns: usize, mut metric: Whitened) -> Numbers {
    let (mut e, mut d) = (vec![0.0; metric.rows.width()], vec![0.0; columns]);
    let mut costs = Numbers::from_elem(0.0, metric.rows.len());
    let rows = std::sync::Arc::clone(&metric.rows);
    for (row, cost) in costs.iter_mut().enumerate() {
        rows.iter_row(row).for_each(|(column, value)| e[column] = value);
        metric.finish(&e, &mut d, 1);
        rows.iter_row(row).for_each(|(column, _)| e[column] = 0.0);
        let norm = rows.norm(row);
        *cost = if norm > 0.0 { (length(&d) / norm / norm).min(f64::MAX) } else { 0.0 };
    }
    costs
}

impl Check {
    /// For the rows of a system, whose columns' vertices stand at `base`, and what factored it (or its equations).
    ///
    /// # Errors
    /// When the metric is not positive definite.
    pub(crate) fn new(system: &System, factored: &dyn Factored, base: &[Point]) -> Result<Self, SolveError> {
        let rows = system.rows();
        let mut rough = Numbers::from_elem(0.0, rows.len());
        for (row, rough) in rough.iter_mut().enumerate() {
            *rough = rows.row(row).1.iter().map(|v| v.abs()).sum();
        }
        Ok(Self {
            rough,
            cost: reciprocals(rows),
            reach: base.iter().fold(0.0, |m, p| p.coords.amax().max(m)),
            measure: Measure::new(system, factored)?,
            still: f64::INFINITY,
            response: Numbers::new(),
            proportionate: false,
        })
    }

    /// Remembers how long the adjustments are that events are made of: so an event need not measure a length that is
    /// bounded by theirs. `still`: without the handle, where that is any. `rows`: those of the handle.
    pub(crate) fn of_events(
        &mut self,
        sides: usize,
        still: Option<&[f64]>,
        response: &[Response],
        rows: impl Iterator<Item = usize>,
    ) {
        self.still = still.map_or(0.0, |still| self.measure.length(still, sides));
        // A response is that of one coordinate: a column of one side.
        self.response = response.iter().map(|r| self.measure.length(r, 1)).collect();
        self.proportionate = match self.measure.cost(&self.cost) {
            None => true,
            Some(cost) => {
                let most = |row: usize| PROPORTION * cost[row];
                self.still == 0.0 && self.response.iter().zip(rows).all(|(length, row)| *length <= most(row))
            }
        };
    }

    /// The first row that vertices miss by more than rounding and its tolerance explain, if any; before that, whether they are anywhere.
    /// `right` are the wanted changes, `size` the sizes of the numbers they come from, an entry for each row and side.
    /// Allocates nothing.
    pub(crate) fn missed(
        &self,
        system: &System,
        asked: impl Fn(usize) -> Asked,
        (right, size): (&[f64], &[f64]),
        moved: &Moved<'_>,
    ) -> Option<Miss> {
        if !moved.finite {
            return Some(Miss::Overflow);
        }
        let all = match system.sides() {
            3 => self.all_hold::<3>(system, right, size, moved.way.as_flattened()),
            _ => self.all_hold::<1>(system, right, size, moved.way.as_flattened()),
        };
        if all { None } else { self.first_missed(system, asked, (right, size), moved) }
    }

    /// Whether all rows hold as equations, at the least size that there is: mostly they do, and the question is settled.
    fn all_hold<const S: usize>(&self, system: &System, right: &[f64], size: &[f64], way: &[f64]) -> bool {
        let way = way.as_chunks::<S>().0;
        let sides = right.as_chunks::<S>().0.iter().zip(size.as_chunks::<S>().0);
        let mut all = true;
        for ((columns, values), ((right, size), rough)) in system.rows().iter().zip(sides.zip(&self.rough)) {
            let mut missing = *right;
            for (&column, value) in columns.iter().zip(values) {
                let way = &way[column as usize];
                (0..S).for_each(|s| missing[s] -= value * way[s]);
            }
            for s in 0..S {
                let allowed = ROUNDING * (size[s] + right[s].abs() + rough * self.reach);
                all &= missing[s].abs() <= allowed.min(f64::MAX);
            }
        }
        all
    }

    /// The first row that does not hold at the size that the adjustment gives the numbers.
    #[cold]
    fn first_missed(
        &self,
        system: &System,
        asked: impl Fn(usize) -> Asked,
        (right, size): (&[f64], &[f64]),
        moved: &Moved<'_>,
    ) -> Option<Miss> {
        let largest = moved.reach();
        let wanted = self.cost.iter().zip(right.chunks_exact(system.sides()));
        let alone = wanted.fold(0.0_f64, |m, (cost, b)| b.iter().fold(m, |m, b| m.max(cost * b.abs())));
        let reach = self.reach + alone;
        let reach = largest.min(PROPORTION * reach).max(reach);
        match system.sides() {
            3 => self.look::<3>(system, asked, (right, size), moved, reach),
            _ => self.look::<1>(system, asked, (right, size), moved, reach),
        }
    }

    fn look<const S: usize>(
        &self,
        system: &System,
        asked: impl Fn(usize) -> Asked,
        (right, size): (&[f64], &[f64]),
        moved: &Moved<'_>,
        reach: f64,
    ) -> Option<Miss> {
        let way = moved.way.as_flattened().as_chunks::<S>().0;
        let sides = right.as_chunks::<S>().0.iter().zip(size.as_chunks::<S>().0);
        for (row, ((right, size), rough)) in sides.zip(&self.rough).enumerate() {
            let (columns, values) = system.rows().row(row);
            let mut sum = [0.0; S];
            for (&column, value) in columns.iter().zip(values) {
                let way = &way[column as usize];
                (0..S).for_each(|s| sum[s] += value * way[s]);
            }
            for s in 0..S {
                let (sense, tolerance) = asked(row);
                let error = error_of(sense, right[s] - sum[s]);
                let allowed = ROUNDING * (size[s] + right[s].abs() + rough * reach) + tolerance;
                let found = Error { error, allowed };
                if !found.holds() {
                    return Some(Miss::Row(row, found));
                }
            }
        }
        None
    }

    /// Whether an adjustment is out of proportion to what its equations would cost, each alone: `‖d‖_W` is more than
    /// [`PROPORTION`] times `Σ |b_k| / ‖f_k‖_(W⁻¹)`, in which no scale enters. (A change `b_k` counts as no less than the
    /// rounding of the numbers that it comes from.) `handle` are the entries of the handle's numbers, where the adjustment is
    /// one of its responses: then the length is known to be no more than a sum, and to be allowed no less than what these
    /// entries allow, which mostly settles the question.
    pub(crate) fn excess(
        &mut self,
        sides: usize,
        right: (&[f64], &[f64]),
        d: &[f64],
        handle: impl Iterator<Item = usize>,
    ) -> Option<Excess> {
        let cost = self.measure.cost(&self.cost)?;
        let response = &self.response[..];
        let (mut most, mut least) = (self.still, 0.0);
        for (k, entry) in handle.enumerate() {
            let change = right.0[entry].abs();
            let column = if sides == 3 { k / 3 } else { k };
            most += change * response.get(column).copied().unwrap_or(f64::INFINITY);
            least += change * cost[entry / sides];
        }
        if most <= PROPORTION * least {
            return None;
        }
        let alone = alone(cost, sides, right);
        Excess::of(self.measure.length(d, sides), alone, PROPORTION)
    }
}

/// The same for a system that is solved once, and any proportion: what is more than `most` (at least [`HARMLESS`]) times as long.
///
/// # Errors
/// When the metric is not positive definite.
pub(crate) fn excess(
    system: &System,
    factored: &dyn Factored,
    right: (&[f64], &[f64]),
    d: &[f64],
    most: f64,
) -> Result<Option<Excess>, SolveError> {
    let sides = system.sides();
    let mut measure = Measure::new(system, factored)?;
    let plain = if let Measure::Plain = measure { reciprocals(system.rows()) } else { Numbers::new() };
    let Some(cost) = measure.cost(&plain) else { return Ok(None) };
    let alone = alone(cost, sides, right);
    Ok(Excess::of(measure.length(d, sides), alone, most))
}

/// `Σ |b_k| / ‖f_k‖`.
fn alone(cost: &[f64], sides: usize, (right, size): (&[f64], &[f64])) -> f64 {
    let each = cost.iter().zip(right.chunks_exact(sides).zip(size.chunks_exact(sides)));
    let term = |b: &f64, size: &f64| b.abs().max(f64::EPSILON * size);
    each.map(|(cost, (right, size))| cost * right.iter().zip(size).map(|(b, s)| term(b, s)).sum::<f64>())
        .sum()
}

/// The Euclidean length, safe from overflow and underflow.
fn length(d: &[f64]) -> f64 {
    // In eight sums, which need not wait for one another.
    let (eights, rest) = d.as_chunks::<8>();
    let mut sums = [0.0_f64; 8];
    for eight in eights {
        sums.iter_mut().zip(eight).for_each(|(sum, v)| *sum += v * v);
    }
    let squares = sums.iter().sum::<f64>() + rest.iter().map(|v| v * v).sum::<f64>();
    if squares > 1e-280 && squares < f64::INFINITY {
        return squares.sqrt();
    }
    let largest = d.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * d.iter().map(|v| (v / largest) * (v / largest)).sum::<f64>().sqrt()
}

/// On which side of its right-hand side a row has to be, and within what, beside rounding.
pub(crate) type Asked = (Sense, f64);

/// The error for an adjustment out of proportion.
#[cold]
pub(crate) fn near_conflict(
    bound: &[BoundConstraint],
    assembly: &Assembly,
    factored: &mut dyn Factored,
    right: &[f64],
    excess: Excess,
) -> SolveError {
    SolveError::NearConflict {
        constraints: fighting(bound, assembly, factored, right),
        condition: factored.diagnosis().condition,
        length: excess.length,
        times: excess.times,
    }
}

/// The constraints that fight each other: those whose multipliers, times the lengths of their rows, are within a hundredth of
/// the largest.
#[cold]
pub(crate) fn fighting(
    bound: &[BoundConstraint],
    assembly: &Assembly,
    factored: &mut dyn Factored,
    right: &[f64],
) -> Vec<String> {
    let (rows, sides) = (assembly.system.rows(), assembly.system.sides());
    let mut multipliers = vec![0.0; rows.len() * sides];
    factored.multipliers_into(right, &mut multipliers);
    let force = |row: usize| {
        let own = &multipliers[row * sides..(row + 1) * sides];
        rows.norm(row) * own.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
    };
    let largest = (0..rows.len()).map(force).fold(0.0, f64::max);
    let fighting = (0..rows.len()).filter(|&row| force(row) >= 0.01 * largest);
    let names: BTreeSet<usize> = fighting.map(|row| assembly.constraint_of(row)).collect();
    names.iter().map(|&k| quoted(&bound[k].constraint.label())).collect()
}

/// The error for an answer that misses a constraint.
#[cold]
pub(crate) fn missed_by(solver: &str, constraint: &Constraint, error: Error) -> SolveError {
    if let Accuracy::Within(tolerance) = constraint.functional().accuracy() {
        return SolveError::OutOfTolerance {
            constraint: quoted(&constraint.label()),
            error: error.error,
            tolerance,
        };
    }
    let advice = match solver {
        "householder-qr" => {
            "ask for less at once, or release one of the constraints that nearly contradict it"
        }
        _ => "use the solver \"householder-qr\", or release one of the constraints that nearly contradict it",
    };
    SolveError::Missed {
        constraint: quoted(&constraint.label()),
        error: error.error,
        allowed: error.allowed,
        solver: solver.to_owned(),
        advice,
    }
}
