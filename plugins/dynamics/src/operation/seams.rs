//! What closes or runs smoothly in a shape by where its control vertices are, and not by its knots: nothing holds that in a motion.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Derivative, Location, Shape, Side};
use loftsman_kernel::text::figure;

use crate::body::extent;

/// Ends closer than this share of the size meet.
const MEETS: f64 = 1e-9;
/// Ends farther apart than this share of the size are seen to be.
const APART: f64 = 1e-6;
/// The cosines of 1° and of 5°: tangents within the first are one, beyond the second there is a fold.
const SMOOTH: f64 = 0.999_847_695;
const FOLDED: f64 = 0.996_194_698;
/// Curves of more pieces than this are not looked at.
const MOST: usize = 10_000;

/// Of a curve, whether its ends meet though its knots do not close it, and the knots at which it runs smoothly though they would let it fold.
#[derive(Debug, Default)]
pub(super) struct Seams {
    meets: bool,
    knots: Vec<f64>,
}

/// The direction on one side of a place, where there is one.
fn tangent(shape: &dyn Shape, u: f64, side: Side) -> Option<Vector> {
    let stencil = shape.stencil_on(Location::Curve(u), Derivative::from(1), side.into()).ok()?;
    stencil.apply(shape.control_vertices()).try_normalize(0.0)
}

/// The cosine of the angle at a knot.
fn turn(shape: &dyn Shape, u: f64) -> Option<f64> {
    Some(tangent(shape, u, Side::Left)?.dot(&tangent(shape, u, Side::Right)?))
}

/// The distance between the ends of a curve that is not periodic, and where they are.
fn gap(shape: &dyn Shape) -> Option<f64> {
    let [side] = shape.domain()[..] else { return None };
    if side.periodic {
        return None;
    }
    let at = |u: f64| shape.stencil(Location::Curve(u), Derivative::POSITION).ok();
    let points = shape.control_vertices();
    Some((at(side.end)?.apply(points) - at(side.start)?.apply(points)).norm())
}

impl Seams {
    /// Those of a curve as it is; none of other shapes.
    pub(super) fn of(shape: &dyn Shape) -> Self {
        let Some(cells) = shape.cells().filter(|cells| shape.domain().len() == 1 && cells.count() <= MOST)
        else {
            return Self::default();
        };
        let size = extent(shape.control_vertices());
        let starts = cells.iter().filter_map(|cell| cell.sides.first().map(|side| side.start));
        Self {
            meets: gap(shape).is_some_and(|gap| gap <= MEETS * size),
            knots: starts.filter(|&u| turn(shape, u).is_some_and(|cosine| cosine >= SMOOTH)).collect(),
        }
    }

    /// What of it is no more, in words; corners that were `made` are no loss.
    pub(super) fn lost(&self, name: &str, shape: &dyn Shape, made: &[f64]) -> Option<String> {
        let size = extent(shape.control_vertices());
        if let Some(gap) = gap(shape).filter(|gap| self.meets && *gap > APART * size) {
            return Some(format!(
                "{name:?} has come open: its ends, which met, are {} apart, as nothing held them together; make it `periodic`, or hold it by \
                 {{ kind = \"closed\", keep = true }}",
                figure(gap)
            ));
        }
        let folded = |u: &&f64| !made.contains(u) && turn(shape, **u).is_some_and(|cosine| cosine < FOLDED);
        let count = self.knots.iter().filter(folded).count();
        let first = self.knots.iter().find(folded)?;
        let more = if count > 1 { format!(" and at {} more knots", count - 1) } else { String::new() };
        Some(format!(
            "{name:?} has folded at {}{more}, where its knots let it and `bending` does not act: fit a curve whose knots are simple to it",
            figure(*first)
        ))
    }
}
