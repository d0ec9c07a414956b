//! A handle whose parameter slides along with the motion (paper 4, §5).

use std::sync::Arc;

use super::{Handle, Session};
use crate::error::{Error, Result};
use crate::functional::{Functional, position};
use crate::problem::EditError;
use crate::problem::bound::{BoundConstraint, bind};
use crate::problem::constraint::{Constraint, Wanted};
use crate::problem::known::Known;
use crate::problem::{Problem, view};
use crate::shape::{Location, Shape};

/// The curve that a handle slides along, as it is, and where the handle is.
///
/// # Errors
/// When it cannot slide.
pub(super) fn begin(problem: &Problem, handle: &dyn Functional) -> Result<(Box<dyn Shape>, f64)> {
    let what = handle.describe();
    if handle.floats() {
        return Err(Error::Invalid(format!(
            "\"{what}\" floats, so that it need not slide: give its location with \"at\", or do not let it slide"
        )));
    }
    match handle.location().filter(|_| handle.is_vector()) {
        Some((shape, Location::Curve(u))) => Ok((problem.shapes().get(shape)?.boxed(), u)),
        _ => Err(Error::Invalid(format!("\"{what}\" cannot slide: only a position on a curve can"))),
    }
}

impl<S: Shape> Session<S> {
    /// Moves the handle's parameter to where the cursor's foot on the original curve is, and prepares there; nothing where it
    /// does not slide.
    pub(super) fn slide(&mut self, cursor: &[f64]) -> Result<(), EditError> {
        let Some(Handle { at, sliding: Some((original, u)), .. }) = &mut self.handle else { return Ok(()) };
        let cursor = crate::Vector::from_column_slice(&cursor[..3]);
        *u = foot(original.as_ref(), cursor, *u)?;
        let (at, moved) = (*at, position(*u));
        let BoundConstraint { constraint, id, .. } = &self.problem.bound[at];
        let (shape, id) = (constraint.functional.location().map_or(0, |(shape, _)| shape), *id);
        self.restore();
        let constraint = Constraint::new(Arc::new(moved.on(shape)), Wanted::Keep);
        self.problem.bound[at] = bind(&view(&self.problem.shapes), constraint, id, &mut Known::default())?;
        self.prepare_again()
    }
}

/// The parameter near `u` whose point on the curve is nearest to the cursor: Newton on `(C(u) - cursor)·C' = 0`, kept
/// within the domain, each step halved until the distance does not grow.
fn foot(curve: &dyn Shape, cursor: crate::Vector, start: f64) -> Result<f64> {
    let domain = curve.domain();
    let Some(interval) = domain.first() else { return Ok(start) };
    let clamp = |u: f64| if interval.periodic { u } else { u.max(interval.start).min(interval.end) };
    let distance = |u: f64| -> Result<f64> { Ok((curve.value(u.into(), 0.into())? - cursor).norm_squared()) };
    let mut u = clamp(start);
    let mut best = distance(u)?;
    for _ in 0..32 {
        let offset = curve.value(u.into(), 0.into())? - cursor;
        let (first, second) = (curve.value(u.into(), 1.into())?, curve.value(u.into(), 2.into())?);
        let slope = offset.dot(&first);
        let bend = first.norm_squared() + offset.dot(&second);
        // Where the bend is not that of a minimum, fall back to Gauss–Newton, which always descends.
        let bend = if bend > 0.1 * first.norm_squared() { bend } else { first.norm_squared() };
        if bend.is_nan() || bend <= 0.0 {
            break;
        }
        let mut step = -slope / bend;
        let mut moved = false;
        for _ in 0..20 {
            let next = clamp(u + step);
            let reached = distance(next)?;
            if reached < best {
                (u, best, moved) = (next, reached, true);
                break;
            }
            step *= 0.5;
        }
        if !moved || step.abs() <= 1e-14 * (interval.end - interval.start) {
            break;
        }
    }
    Ok(u)
}
