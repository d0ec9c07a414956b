//! Where a curve closes or runs smoothly by where its control vertices are, and not by its knots: what keeps that in a motion.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Functional, Linearity, Rows, Shapes};
use loftsman_kernel::shape::{Derivative, Location, Shape, Side};
use loftsman_kernel::text::figure;

use crate::body::{Body, extent};
use crate::constraint::Hold;

/// Ends closer than this share of the size meet.
pub(crate) const MEETS: f64 = 1e-9;
/// The cosine of 1e-4: where both sides are as parallel as that a curve is meant to be smooth.
const SMOOTH: f64 = 1.0 - 0.5e-8;
/// A curve of more pieces than this keeps its ends together, but its pieces are not kept smooth: equations of knots are all solved at once.
const MOST: usize = 64;

/// `C⁽ᵏ⁾₊ = r C⁽ᵏ⁾₋`: what is the same on both sides of a knot, or where both ends meet.
#[derive(Debug, Clone)]
struct Seam {
    body: usize,
    before: f64,
    after: f64,
    order: usize,
    ratio: f64,
    name: String,
}

impl Functional for Seam {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    /// Of the shape's present knots: it may be given more.
    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let shape = shapes.get(self.body)?;
        let side = |u: f64, side: Side| {
            shape.stencil_on(Location::Curve(u), Derivative::from(self.order), side.into())
        };
        let mut both = side(self.after, Side::Right)?;
        let before = side(self.before, Side::Left)?;
        before.iter().for_each(|(vertex, coefficient)| both.add(vertex, -self.ratio * coefficient));
        rows.alike(self.body, &both);
        Ok(())
    }

    fn describe(&self) -> String {
        self.name.clone()
    }

    fn location(&self) -> Option<(usize, Location)> {
        Some((self.body, Location::Curve(self.after)))
    }

    fn is_vector(&self) -> bool {
        true
    }
}

/// The derivative on one side of a place.
fn derivative(shape: &dyn Shape, u: f64, side: Side) -> Option<Vector> {
    let stencil = shape.stencil_on(Location::Curve(u), Derivative::from(1), side.into()).ok()?;
    Some(stencil.apply(shape.control_vertices()))
}

/// The cosine of the angle between the curve's way to one place and its way on from another (or the same).
pub(crate) fn turn(shape: &dyn Shape, before: f64, after: f64) -> Option<f64> {
    let [a, b] = [derivative(shape, before, Side::Left)?, derivative(shape, after, Side::Right)?];
    Some(a.try_normalize(0.0)?.dot(&b.try_normalize(0.0)?))
}

/// The ends of a curve that is not periodic, and the distance between them.
pub(crate) fn gap(shape: &dyn Shape) -> Option<(f64, f64, f64)> {
    let [side] = shape.domain()[..] else { return None };
    if side.periodic {
        return None;
    }
    let at = |u: f64| shape.stencil(Location::Curve(u), Derivative::POSITION).ok();
    let points = shape.control_vertices();
    Some((side.start, side.end, (at(side.end)?.apply(points) - at(side.start)?.apply(points)).norm()))
}

/// What keeps a curve closed where its ends meet, and smooth there and at knots at which it may fold but does not; and whether its ends are kept together. Nothing at the
/// ends where others hold both.
pub(crate) fn kept(body: &Body, index: usize, others: &[Hold]) -> (bool, Vec<Hold>) {
    let shape = body.shape.as_ref();
    let none = (false, Vec::new());
    if body.still || shape.domain().len() != 1 {
        return none;
    }
    let Some(splines) = shape.cells().and_then(|cells| cells.splines()) else { return none };
    let (degree, size) = (splines.u.degree(), extent(shape.control_vertices()));
    let hold = |before: f64, after: f64, order: usize, name: String| {
        let speed = |u: f64, side: Side| derivative(shape, u, side).map_or(0.0, |way| way.norm());
        let ratio = if order == 0 { 1.0 } else { speed(after, Side::Right) / speed(before, Side::Left) };
        Hold::of_all(Arc::new(Seam { body: index, before, after, order, ratio, name }))
    };
    let smooth = |before: f64, after: f64| turn(shape, before, after).is_some_and(|turn| turn >= SMOOTH);
    let mut found = Vec::new();
    let held = |end: f64| others.iter().any(|other| other.fixes(index, end));
    let ends = gap(shape).filter(|(start, end, gap)| *gap <= MEETS * size && !(held(*start) && held(*end)));
    if let Some((start, end, _)) = ends {
        found.push(hold(end, start, 0, format!("the ends of {:?} together", body.name)));
        if degree > 1 && smooth(end, start) {
            found.push(hold(end, start, 1, format!("the ends of {:?} smooth", body.name)));
        }
    }
    let (start, end) = splines.u.domain();
    let loose: Vec<f64> = splines
        .u
        .breakpoints()
        .into_iter()
        .filter(|u| *u > start && *u < end && splines.u.multiplicity(*u) >= degree)
        .collect();
    if loose.len() > MOST {
        return (ends.is_some(), found);
    }
    for u in loose {
        let apart = || {
            let side =
                |side: Side| shape.stencil_on(Location::Curve(u), Derivative::POSITION, side.into()).ok();
            let points = shape.control_vertices();
            Some((side(Side::Left)?.apply(points) - side(Side::Right)?.apply(points)).norm())
        };
        let pieces = splines.u.multiplicity(u) > degree;
        if pieces && apart().is_none_or(|apart| apart > MEETS * size) {
            continue;
        }
        if pieces {
            found.push(hold(u, u, 0, format!("the pieces of {:?} at {} together", body.name, figure(u))));
        }
        if degree > 1 && smooth(u, u) {
            found.push(hold(u, u, 1, format!("{:?} smooth at {}", body.name, figure(u))));
        }
    }
    (ends.is_some(), found)
}
