//! Where α is positive: α itself, and not its values, of which some may be negative where it is not.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{Accuracy, Functional, Linearity, Rows, Shapes};
use loftsman_kernel::text::{counted, short};

use crate::error::{FineTuneError, Result};
use crate::lift::{Alpha, Place};
use crate::lowest::lowest;

/// The part of a span within which two places are near each other, and the part of their distance at which others are held with a new one.
const NEARBY: f64 = 0.125;
const CLOSER: f64 = 0.125;
/// The part of a bound (or of what could be one) by which α may be below it, and by which it is above where it is said to be kept there.
const NEAR: f64 = 1e-5;
/// The part of its largest size up to which α touches zero: rounding.
const TOUCHES: f64 = 1e-12;
/// So often more places are held; each time α comes about as near to the bound as the square of what it was.
const TIMES: usize = 40;

/// Whether α reaches zero, of its smallest and its largest value: to a few times rounding, which says nothing about its sign.
pub(crate) fn reaches_zero([least, most]: [f64; 2]) -> bool {
    least <= 16.0 * f64::EPSILON * least.abs().max(most.abs())
}

/// α stays at least this part of its smallest value that was asked (or of 1), where it would not be positive; and of its largest there, below which a bound is
/// rounding: but not more than the last, for an α of 1 is there where nothing but ends is asked for.
const LEAST: [f64; 3] = [1e-3, 1e-6, 0.1];

/// A bound of α, and how far α may be from it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bound {
    pub(crate) at_least: f64,
    pub(crate) near: f64,
}

/// The bound of α where the one asked for has this smallest value, and the answer without a bound these.
pub(crate) fn bound(asked: f64, [least, most]: [f64; 2]) -> Bound {
    let rounding = LEAST[1] * least.abs().max(most.abs());
    let at_least = f64::max(LEAST[0] * asked.clamp(0.0, 1.0), rounding.min(LEAST[2]));
    Bound { at_least, near: NEAR * at_least.max(rounding) }
}

/// What a bound of α is called.
pub(crate) const POSITIVE: &str = "alpha is positive";

/// A sum of α's values, the shape 1, that has to be above a bound; as accurately as the bound is.
#[derive(Debug, Clone)]
pub(crate) struct Above {
    pub(crate) terms: Vec<(usize, f64)>,
    pub(crate) accuracy: f64,
}

impl Functional for Above {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> loftsman_kernel::error::Result<()> {
        rows.equation();
        for (value, factor) in &self.terms {
            rows.term(1, *value, Vector::x() * *factor);
        }
        Ok(())
    }

    /// The values that it is of: two are the same where these are.
    fn describe(&self) -> String {
        format!("α of {:?}", self.terms)
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy::Within(self.accuracy)
    }
}

/// What `solve` finds with α at least `bound` at some places, where it is so everywhere (but for a hundred-thousandth of the bound): α's smallest values are held, one
/// time after the other, from those of `first` on. It is the answer with α bounded everywhere, and where there is none with some places held
/// there is none at all.
///
/// # Errors
/// Those of `solve`.
pub(crate) fn bounded<T>(
    first: &Alpha,
    bound: Bound,
    mut solve: impl FnMut(&[Place]) -> Result<T>,
    values: impl Fn(&T) -> Vec<f64>,
) -> Result<T> {
    let mut held: Vec<Place> = below(first, bound)?;
    for _ in 1..TIMES {
        let found = solve(&held)?;
        let low = below(&first.with(values(&found))?, bound)?;
        let new: Vec<Place> = low.into_iter().filter(|place| !held.contains(place)).collect();
        if new.is_empty() {
            return Ok(found);
        }
        let more = beside(first, &new, &held);
        held.extend(new.into_iter().chain(more));
    }
    solve(&held)
}

/// Places on both sides of those of a line that are new, where one that is held is nearby: what comes below the bound next is between these, an eighth as far
/// apart, and not between the old ones.
fn beside(alpha: &Alpha, new: &[Place], held: &[Place]) -> Vec<Place> {
    let Alpha::Line(line) = alpha else { return Vec::new() };
    let breaks = line.space().breakpoints();
    let mut known: Vec<f64> = held.iter().map(|((at, _), _)| *at).collect();
    known.sort_by(f64::total_cmp);
    let mut all = Vec::new();
    for ((at, _), sides) in new {
        let next = known.partition_point(|t| t < at);
        let around = known.iter().take(next + 1).skip(next.saturating_sub(1));
        let nearest = around.map(|t| (t - at).abs()).fold(f64::INFINITY, f64::min);
        let next = breaks.partition_point(|t| t <= at).clamp(1, breaks.len() - 1);
        let (from, to) = (breaks[next - 1], breaks[next]);
        if nearest > 0.0 && nearest < NEARBY * (to - from) {
            let each = [at - CLOSER * nearest, at + CLOSER * nearest].into_iter();
            all.extend(each.filter(|at| from < *at && *at < to).map(|at| ((at, 0.0), *sides)));
        }
    }
    all
}

/// The places of the smallest values that are below a bound.
fn below(alpha: &Alpha, bound: Bound) -> Result<Vec<Place>> {
    Ok(lowest(alpha, bound.at_least - bound.near)?.into_iter().map(|(_, place)| place).collect())
}

/// What there is to say of a bound that holds α: where.
pub(crate) fn told(alpha: &Alpha, bound: Bound, ends: &str) -> Result<String> {
    let held = lowest(alpha, bound.at_least + bound.near)?;
    let some: Vec<String> = held.iter().take(3).map(|(_, place)| alpha.name(place)).collect();
    let more = held.len().saturating_sub(some.len());
    let more = if more > 0 { format!(" and {}", counted(more, "place[|s] more")) } else { String::new() };
    Ok(format!(
        "without a bound alpha would not be positive: it is kept at {} near {}{more}, where the curvature grows by its reciprocal; ask for an alpha nearer \
         to what the {ends} allow",
        short(bound.at_least),
        some.join(", ")
    ))
}

/// Refuses α that is not positive everywhere. Its values need not be.
///
/// # Errors
/// Naming the smallest value of α, where that is, and the value that it comes from.
pub(crate) fn check_positive(alpha: &Alpha) -> Result<()> {
    let least = alpha.values().iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    let Some((index, _)) = least.filter(|(_, value)| **value <= 0.0) else { return Ok(()) };
    let [low, high] = alpha.extremes()?;
    if low > TOUCHES * low.abs().max(high.abs()) {
        return Ok(());
    }
    let found = lowest(alpha, f64::INFINITY)?.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let near = found.map_or_else(String::new, |(_, place)| alpha.name(&place));
    let value = match alpha {
        Alpha::Line(_) => format!("value {index}"),
        Alpha::Net(_) => format!("value [{}, {}]", index / alpha.columns(), index % alpha.columns()),
    };
    Err(FineTuneError::NotPositive { value: low, at: format!("{near} ({value})") })
}

impl Alpha {
    /// A place, for people.
    fn name(&self, ((u, v), _): &Place) -> String {
        match self {
            Self::Line(_) => short(*u),
            Self::Net(_) => format!("({}, {})", short(*u), short(*v)),
        }
    }
}
