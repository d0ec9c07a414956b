//! One way of matching: with the surface's own knots, or with those of the other edge as well.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::plugin::{Context, OperationError};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Direction, Surface};
use loftsman_kernel::topology::EdgeCurve;

use super::asked::Asked;
use super::made::Made;
use super::remedy::{Refused, Why};
use super::{MOST, TOLERANCE};
use crate::beside::{Begun, Beside, edge_of};
use crate::deviation::{Deviation, Limits};

/// So many control vertices along the edge are tried with a surface's own knots alone before those of the other edge are, with continuity 2.
pub(super) const ENOUGH: usize = 64;

/// What is matched.
pub(super) struct Case<'a> {
    pub(super) surface: &'a Surface,
    pub(super) other: &'a dyn Shape,
    pub(super) along: Direction,
    /// Whether the edge is where the parameter across ends.
    pub(super) at_end: bool,
    /// How the other edge runs beside this one, and where it begins.
    pub(super) begun: Begun,
    /// The larger edge's size.
    pub(super) size: f64,
    /// The allowed distance.
    pub(super) distance: f64,
    pub(super) before: Deviation,
    /// Whether the surface lay on the other, folded back, before.
    pub(super) lay_on: bool,
}

/// Control vertices along the edge of all surfaces that were tried, and how many there may be.
pub(super) struct Work {
    pub(super) called: &'static str,
    pub(super) done: usize,
    pub(super) most: usize,
}

impl Work {
    /// As much again as was done, and so much in any case, for another way.
    pub(super) fn as_much_again(&self) -> Self {
        const LEAST: usize = 1024;
        Self { called: self.called, done: 0, most: (2 * self.done).max(LEAST) }
    }
}

impl Asked {
    /// With the surface's own knots first, and those of the other edge where they are not enough.
    pub(super) fn attempt(
        &self,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let shapes = Shapes::new([surface as &dyn Shape, other]);
        let edge = edge_of(&shapes, &On::default(), self.edge, "match")?;
        let there = edge_of(&shapes, &self.other, self.other_edge, "match")?;
        let size = edge.spread().max(there.spread());
        let distance = self.limits.distance.unwrap_or(TOLERANCE * size);
        let limits = Limits { distance: Some(distance), ..self.limits };
        let along = if edge.edge.along_u { Direction::U } else { Direction::V };
        let begun = Beside::new(edge.clone(), &there.curve, !self.free)?.begins();
        let profile = self.matching(limits).begun(begun).profile(&shapes)?;
        let case = Case {
            surface,
            other,
            along,
            at_end: edge.edge.at_end,
            begun,
            size,
            distance,
            before: Deviation::worst(&profile).without_rounding(size),
            lay_on: self.continuity > 0 && Deviation::lies_on(&profile, &limits),
        };
        if Deviation::folded(&profile) && self.continuity > 1 && !self.led {
            // With tangent planes alone, by linear equations, it is there still, if it is with curvature, which costs many times as much.
            let planes = Self { continuity: 1, ..self.clone() };
            if let Ok(Err(refused)) = planes.attempt(surface, other, context, work)
                && matches!(refused.why, Why::LayOn | Why::Folds)
            {
                return Ok(Err(refused));
            }
        }
        let start = self.with_rows(surface, along.other())?;
        if !self.refine {
            return self.from(start, usize::MAX, &case, context, work);
        }
        let (refined, exact) = as_the_other(&start, along, edge, &there, begun)?
            .map_or((None, false), |found| (Some(found.0), found.1));
        match refined {
            None => self.from(start, usize::MAX, &case, context, work),
            Some(refined) if exact => self.from(refined, usize::MAX, &case, context, work),
            Some(refined) => {
                // With curvature each round is work by the square: its own knots are tried as long as they are not many more than those of both.
                // A closed edge that begins between the other's knots has no use for these.
                let together = self.continuity > 1 && !(self.free && self.starts_between(surface, other)?);
                let as_many =
                    if together { (2 * refined.space(along).len()).max(ENOUGH) } else { usize::MAX };
                let first = match self.from(start, as_many, &case, context, work)? {
                    Ok(made) => return Ok(Ok(made)),
                    // How many would be needed was not asked for all that may be.
                    Err(refused) if as_many < usize::MAX && matches!(refused.why, Why::Needs { .. }) => {
                        Refused { why: Why::Limits, ..refused }
                    }
                    Err(refused) => refused,
                };
                // With other weights it is not that curve, but bends and has corners where that does.
                match self.from(refined, usize::MAX, &case, context, work) {
                    Ok(Err(refused)) => Ok(Err(if refused.worst.is_some() { refused } else { first })),
                    Ok(made) => Ok(made),
                    Err(_) => {
                        // Whoever asked may have had enough; all else says no more than what was refused first.
                        context.observer.proceed(work.called, 0, 0)?;
                        Ok(Err(first))
                    }
                }
            }
        }
    }
}

/// The surface raised and refined along its edge so that its space there has the knots and the degree of the other edge, and whether it holds that then, which
/// other weights keep it from; `None` where it does already, or where spaces do not go together.
pub(super) fn as_the_other(
    surface: &Surface,
    along: Direction,
    edge: EdgeCurve,
    there: &EdgeCurve,
    begun: Begun,
) -> Result<Option<(Surface, bool)>, Error> {
    let beside = Beside::begun(edge, &there.curve, begun)?;
    if beside.exactly()?.is_ok() {
        return Ok(None);
    }
    let Ok(common) = surface.space(along).common(beside.curve.space()) else { return Ok(None) };
    if common.first.last().is_some_and(|step| step.to().len() > MOST[2]) {
        return Ok(None);
    }
    let mut refined = surface.clone();
    for step in &common.first {
        refined = refined.convert(along, step)?;
    }
    let shapes = [&refined as &dyn Shape];
    let index = beside.edge.edge.name.clone();
    let shape = shapes[0];
    let number = loftsman_kernel::shape::edges_of(shape, "match")?.iter().position(|e| e.name == index);
    let Some(number) = number else { return Ok(None) };
    let alike = Beside::begun(EdgeCurve::of(shape, number, "match")?, &there.curve, begun)?;
    let exact = alike.exactly()?.is_ok();
    Ok((exact || !common.first.is_empty()).then_some((refined, exact)))
}
