//! Where α is positive: α itself, and not its values, of which some may be negative where it is not.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{Accuracy, Functional, Linearity, Rows, Shapes};
use loftsman_kernel::shape::Side;
use loftsman_kernel::spline::{Direction, Space};
use loftsman_kernel::text::{counted, short};

use crate::error::{FineTuneError, Result};
use crate::lift::{Alpha, Place};

/// In how many parts each span is looked at: of α of one parameter, and of two.
const PARTS: [usize; 2] = [32, 8];
/// The part of a bound by which α may be below it, and by which it is above where it is said to be kept there.
pub(crate) const NEAR: f64 = 1e-5;
/// The part of its largest size up to which α touches zero: rounding.
const TOUCHES: f64 = 1e-12;
/// So often more places are held; each time α comes about as near to the bound as the square of what it was.
const TIMES: usize = 40;
/// So often a smallest value is looked for between its neighbours.
const CLOSER: usize = 4;

/// Whether α reaches zero, of its smallest and its largest value: to a few times rounding, which says nothing about its sign.
pub(crate) fn reaches_zero([least, most]: [f64; 2]) -> bool {
    least <= 16.0 * f64::EPSILON * least.abs().max(most.abs())
}

/// α stays at least this part of its smallest value that was asked (or of 1), where it would not be positive; and of its largest there, below which a bound is
/// rounding.
const LEAST: [f64; 2] = [1e-3, 1e-6];

/// The bound of α where the one asked for has this smallest value, and the answer without a bound these.
pub(crate) fn bound(asked: f64, [least, most]: [f64; 2]) -> f64 {
    f64::max(LEAST[0] * asked.clamp(0.0, 1.0), LEAST[1] * least.abs().max(most.abs()))
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

/// One parameter at which α is looked at.
#[derive(Clone, Copy)]
struct Look {
    at: f64,
    side: Side,
    /// Where its span starts and ends.
    span: (f64, f64),
}

/// Each span from its start to its end.
fn looks(space: &Space, parts: usize) -> Vec<Look> {
    let breaks = space.breakpoints();
    let spans = breaks.windows(2).map(|pair| (pair[0], pair[1]));
    let each = |span: (f64, f64)| {
        let at = move |k: usize| span.0 + (span.1 - span.0) * (k as f64 / parts as f64);
        let look = move |k: usize| match k {
            k if k == parts => Look { at: span.1, side: Side::Left, span },
            k => Look { at: at(k), side: Side::Right, span },
        };
        (0..=parts).map(look)
    };
    spans.flat_map(each).collect()
}

/// The smallest values of α, each smaller than what is beside it, and where they are: those below a bound. `O(n p)`, of a net `O(n p²)`.
fn minima(alpha: &Alpha, below: f64) -> Result<Vec<(f64, Place)>> {
    let (along, across) = match alpha {
        Alpha::Line(line) => (looks(line.space(), PARTS[0]), Vec::new()),
        Alpha::Net(net) => {
            (looks(net.space(Direction::U), PARTS[1]), looks(net.space(Direction::V), PARTS[1]))
        }
    };
    let width = across.len().max(1);
    let place = |k: usize| -> Place {
        let (u, v) = (along[k / width], across.get(k % width));
        ((u.at, v.map_or(0.0, |v| v.at)), [u.side, v.map_or(Side::Right, |v| v.side)])
    };
    let values = (0..along.len() * width).map(|k| alpha.at(&place(k))).collect::<Result<Vec<f64>>>()?;
    let mut found = Vec::new();
    for (k, &value) in values.iter().enumerate() {
        let (i, j) = (k / width, k % width);
        // Of equal ones beside each other the first.
        let is_least = (i.saturating_sub(1)..along.len().min(i + 2))
            .flat_map(|i| (j.saturating_sub(1)..width.min(j + 2)).map(move |j| i * width + j))
            .all(|other| other == k || value < values[other] || value == values[other] && k < other);
        if is_least {
            // Where spans meet, in each of them.
            let mut best = (place(k), value);
            for i in beside(&along, i) {
                for j in beside(&across, j) {
                    let k = i * width + j;
                    let near = closer(alpha, (place(k), values[k]), along[i], across.get(j).copied())?;
                    best = if near.1 < best.1 { near } else { best };
                }
            }
            if best.1 < below {
                found.push((best.1, best.0));
            }
        }
    }
    Ok(found)
}

/// The looks at one parameter: of two spans where they meet.
fn beside(all: &[Look], i: usize) -> impl Iterator<Item = usize> {
    let is_here = move |k: &usize| *k == i || all.get(*k).zip(all.get(i)).is_some_and(|(a, b)| a.at == b.at);
    (i.saturating_sub(1)..(i + 2).min(all.len().max(1))).filter(is_here)
}

/// A smaller value between the neighbours of one that was looked at, by parabolas in one parameter after the other.
fn closer(alpha: &Alpha, start: (Place, f64), u: Look, v: Option<Look>) -> Result<(Place, f64)> {
    let mut best = start;
    let reach = |look: &Look, parts: usize| (look.span.1 - look.span.0) / parts as f64;
    let parts = PARTS[usize::from(v.is_some())];
    let mut steps = [reach(&u, parts), v.as_ref().map_or(0.0, |v| reach(v, parts))];
    for _ in 0..CLOSER {
        for (parameter, look) in [Some(u), v].into_iter().enumerate() {
            let Some(look) = look else { continue };
            let (step, (place, middle)) = (steps[parameter], best);
            let moved = |at: f64| {
                let mut to = place;
                if parameter == 0 {
                    to.0.0 = at;
                } else {
                    to.0.1 = at;
                }
                to
            };
            let own = if parameter == 0 { place.0.0 } else { place.0.1 };
            steps[parameter] = step / 8.0;
            // Where a span ends, the middle is between.
            let (low, high) = ((own - step).max(look.span.0), (own + step).min(look.span.1));
            let is_end = own <= low || own >= high;
            let center = if is_end { 0.5 * (low + high) } else { own };
            let value = |at: f64| if at == own { Ok(middle) } else { alpha.at(&moved(at)) };
            let (before, between, after) = (value(low)?, value(center)?, value(high)?);
            // The parabola through the three.
            let (left, right) = ((between - before) / (center - low), (after - between) / (high - center));
            let bend = (right - left) / (high - low);
            let at = 0.5 * (low + center - left / bend);
            if bend > 0.0 && (low..=high).contains(&at) {
                let value = alpha.at(&moved(at))?;
                if value < middle {
                    best = (moved(at), value);
                }
            }
        }
    }
    Ok(best)
}

/// What `solve` finds with α at least `bound` at some places, where it is so everywhere (but for a hundred-thousandth of the bound): α's smallest values are held, one
/// time after the other, from those of `first` on. It is the answer with α bounded everywhere, and where there is none with some places held
/// there is none at all.
///
/// # Errors
/// Those of `solve`.
pub(crate) fn bounded<T>(
    first: &Alpha,
    bound: f64,
    mut solve: impl FnMut(&[Place]) -> Result<T>,
    values: impl Fn(&T) -> Vec<f64>,
) -> Result<T> {
    let mut held: Vec<Place> = lowest(first, bound)?;
    for _ in 1..TIMES {
        let found = solve(&held)?;
        let low = lowest(&first.with(values(&found))?, bound)?;
        let before = held.len();
        held.extend(low.iter().filter(|place| !held.contains(place)).copied().collect::<Vec<_>>());
        if held.len() == before {
            return Ok(found);
        }
    }
    solve(&held)
}

/// The places of the smallest values that are below a bound.
fn lowest(alpha: &Alpha, bound: f64) -> Result<Vec<Place>> {
    Ok(minima(alpha, bound * (1.0 - NEAR))?.into_iter().map(|(_, place)| place).collect())
}

/// What there is to say of a bound that holds α: where.
pub(crate) fn told(alpha: &Alpha, bound: f64, ends: &str) -> Result<String> {
    let held = minima(alpha, bound * (1.0 + NEAR))?;
    let some: Vec<String> = held.iter().take(3).map(|(_, place)| alpha.name(place)).collect();
    let more = held.len().saturating_sub(some.len());
    let more = if more > 0 { format!(" and {}", counted(more, "place[|s] more")) } else { String::new() };
    Ok(format!(
        "without a bound alpha would not be positive: it is kept at {} near {}{more}, where the curvature grows by its reciprocal; ask for an alpha nearer \
         to what the {ends} allow",
        short(bound),
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
    let found = minima(alpha, f64::INFINITY)?.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let near = found.map_or_else(String::new, |(_, place)| alpha.name(&place));
    let value = match alpha {
        Alpha::Line(_) => format!("value {index}"),
        Alpha::Net(_) => format!("value [{}, {}]", index / alpha.columns(), index % alpha.columns()),
    };
    Err(FineTuneError::NotPositive { value: low, at: format!("{near} ({value})") })
}

impl Alpha {
    /// Its value at a place.
    fn at(&self, place: &Place) -> Result<f64> {
        let values = self.values();
        Ok(self.row(*place)?.into_iter().map(|(k, c)| c * values[k]).sum())
    }

    /// A place, for people.
    fn name(&self, ((u, v), _): &Place) -> String {
        match self {
            Self::Line(_) => short(*u),
            Self::Net(_) => format!("({}, {})", short(*u), short(*v)),
        }
    }
}
