//! How large α is, and a change of it: `∫ α²`, `∫∫ α²`. And how well a curve was tuned.

use loftsman_kernel::Vector;
use loftsman_kernel::solve::Symmetric;
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Direction, Space};
use loftsman_kernel::text::short;

use crate::error::Result;
use crate::lift::Alpha;

/// Products of this degree and less stay below what is told.
pub(crate) const EXACT: usize = 10;
/// What is told where `D'` and `α C'` differ by more, as a part of the largest.
const TOLD: f64 = 1e-10;

/// How far the derivative of a tuned curve is from `α C'`, where that is more than rounding.
pub(crate) struct Inexact {
    /// As a part of the largest `|α C'|`.
    off: f64,
    at: f64,
    degree: usize,
}

impl Inexact {
    /// So far off at a place; `None` where that is no more than rounding.
    pub(crate) fn beyond(off: f64, at: f64, degree: usize) -> Option<Self> {
        (off > TOLD).then_some(Self { off, at, degree })
    }

    /// What there is to say of it.
    pub(crate) fn told(&self) -> String {
        format!(
            "its derivative is not α times the given one but {:.1e} of the largest off, near {}: products of degree {} lose digits; tune a curve of lower \
             degree",
            self.off, self.at, self.degree
        )
    }

    /// What there is to say where another representation of this degree keeps the digits.
    pub(crate) fn avoided(&self, degree: usize) -> String {
        format!(
            "in Bézier pieces of degree {degree}: with fewer knots its derivative would be {:.1e} of the largest off, near {}",
            self.off, self.at
        )
    }
}

/// Whether the derivative of a tuned curve is not `α C'` to 1e-10 of its largest: a product of high degree with knots within has coefficients
/// that grow and cancel. Measured by de Boor's algorithm at as many places in each span as the product has degrees; `O(n p³)` there, nothing for
/// products of degree 10 and less.
pub(crate) fn inexact(
    tuned: &Curve,
    derivative: &Function<Vector>,
    alpha: &Function<f64>,
) -> Result<Option<Inexact>> {
    let degree = derivative.space().degree() + alpha.space().degree();
    if degree <= EXACT {
        return Ok(None);
    }
    let (mut worst, mut at, mut size) = (0.0_f64, 0.0, 0.0_f64);
    for span in tuned.space().breakpoints().windows(2) {
        for k in 0..degree {
            let t = span[0] + (span[1] - span[0]) * ((k as f64 + 0.5) / degree as f64);
            let asked = derivative.value(t)? * alpha.value(t)?;
            let off = (tuned.derivative(t, 1)? - asked).norm();
            size = size.max(asked.norm());
            if off > worst {
                (worst, at) = (off, t);
            }
        }
    }
    Ok(Inexact::beyond(worst / size, at, degree))
}

/// The Gram matrix of a space: `∫ α²` of the values of α.
pub(crate) fn gram(space: &Space) -> Symmetric {
    Symmetric::from_entries(space.len(), space.gram(0))
}

/// `∫∫ α²` of the values of α.
pub(crate) fn mass(alpha: &Alpha) -> Result<Symmetric> {
    let along = gram(alpha.along());
    let Alpha::Net(net) = alpha else { return Ok(along) };
    let across = gram(net.space(Direction::V));
    let n = across.size();
    let mut entries = Vec::new();
    for i in 0..along.size() {
        for (j, a) in along.row(i).filter(|(j, _)| *j <= i) {
            for k in 0..n {
                let lower = across.row(k).map(|(l, b)| (i * n + k, j * n + l, a * b));
                entries.extend(lower.filter(|(row, column, _)| column <= row));
            }
        }
    }
    Ok(Symmetric::from_entries(along.size() * n, entries))
}

/// `(mean (Δα)²)^½` over the domain, of two in one space but for their ends, which may be clamped.
pub(crate) fn change(first: &Alpha, second: &Alpha) -> Result<f64> {
    if first.values() == second.values() {
        return Ok(0.0);
    }
    let (first, second) = (first.clone().clamped(true, true)?, second.clone().clamped(true, true)?);
    apart(&first, second.values())
}

/// The same from 1 to α: how much is asked for.
pub(crate) fn asked(alpha: &Alpha) -> Result<f64> {
    let alpha = alpha.clone().clamped(true, true)?;
    apart(&alpha, &vec![1.0; alpha.values().len()])
}

fn apart(first: &Alpha, values: &[f64]) -> Result<f64> {
    let across = if let Alpha::Net(net) = first { net.space(Direction::V).length() } else { 1.0 };
    Ok(mean(&mass(first)?, first.values(), values, first.along().length() * across))
}

/// What there is to say where α was changed by so much from one that was asked for so far from 1; whether it is held somewhere, and its smallest and largest
/// value now.
pub(crate) fn undone(change: f64, asked: f64, held: bool, [least, most]: [f64; 2]) -> Option<String> {
    if !(asked > 1e-9 && change > 0.5 * asked) {
        return None;
    }
    if !held && most - least <= 1e-9 * least.abs().max(most.abs()) {
        return Some(format!(
            "of what was asked a factor of {} is left and nothing else, so that the ends stay: alpha has too few values for more; give it more knots, or tune a \
             longer range",
            short(most)
        ));
    }
    Some(if held {
        "alpha is what was asked where it is held; elsewhere more than half of it is undone so that the ends stay: give alpha more knots, or tune a longer range"
            .to_owned()
    } else {
        "more than half of what was asked is undone so that the ends stay: give alpha more knots, tune a longer range, or hold it where it matters (alpha_at)"
            .to_owned()
    })
}

/// The values nearest to those asked for, in `∫∫ (Δα)²`, of which all but the free ones are 1: what these have to be changes its neighbours. By conjugate
/// gradients on the Gram matrix of the free ones, divided by its diagonal, to rounding; `O(n)` a step.
pub(crate) fn nearest_with_ones(mass: &Symmetric, asked: &[f64], free: &[usize]) -> Vec<f64> {
    let mut values = vec![1.0; asked.len()];
    free.iter().for_each(|k| values[*k] = asked[*k]);
    let way: Vec<f64> = values.iter().zip(asked).map(|(to, from)| to - from).collect();
    let mut image = vec![0.0; way.len()];
    mass.multiply(&way, 1, &mut image);
    let own = mass.select(free);
    let scale: Vec<f64> = (0..free.len()).map(|k| own.entry(k, k)).collect();
    let mut rest: Vec<f64> = free.iter().map(|k| -image[*k]).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scaled = |rest: &[f64]| rest.iter().zip(&scale).map(|(r, s)| r / s).collect::<Vec<f64>>();
    let (mut found, mut next) = (vec![0.0; free.len()], scaled(&rest));
    let mut size = dot(&rest, &next);
    let enough = size * f64::EPSILON * f64::EPSILON;
    for _ in 0..4 * free.len() {
        let mut image = vec![0.0; free.len()];
        own.multiply(&next, 1, &mut image);
        let step = size / dot(&next, &image);
        if !(size > enough && step.is_finite()) {
            break;
        }
        found.iter_mut().zip(&next).for_each(|(x, n)| *x += step * n);
        rest.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
        let again = scaled(&rest);
        let grown = dot(&rest, &again);
        next.iter_mut().zip(&again).for_each(|(n, a)| *n = a + grown / size * *n);
        size = grown;
    }
    free.iter().zip(&found).for_each(|(k, by)| values[*k] += by);
    values
}

/// `((y - x)ᵀ M (y - x) / measure)^½`.
pub(crate) fn mean(mass: &Symmetric, x: &[f64], y: &[f64], measure: f64) -> f64 {
    let way: Vec<f64> = y.iter().zip(x).map(|(y, x)| y - x).collect();
    let mut image = vec![0.0; way.len()];
    mass.multiply(&way, 1, &mut image);
    let square: f64 = way.iter().zip(&image).map(|(a, b)| a * b).sum();
    (square.max(0.0) / measure).sqrt()
}
