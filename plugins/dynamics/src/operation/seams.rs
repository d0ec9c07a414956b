//! What closes or runs smoothly in a shape by where its control vertices are, and not by its knots: what of that a motion loses is told.

use loftsman_kernel::shape::Shape;
use loftsman_kernel::text::figure;

use crate::body::extent;
use crate::seam::{MEETS, gap, turn};

use super::creases::Creases;

/// Ends farther apart than this share of the size are seen to be.
pub(super) const APART: f64 = 1e-6;
/// The cosines of 1° and of 5°: tangents within the first are one, beyond the second there is a fold.
pub(super) const SMOOTH: f64 = 0.999_847_695;
pub(super) const FOLDED: f64 = 0.996_194_698;
/// Curves of more pieces than this are not looked at.
const MOST: usize = 10_000;

/// What closes or runs smoothly, of a curve or of a surface.
#[derive(Debug, Default)]
pub(super) struct Seams {
    curve: CurveSeams,
    surface: Creases,
}

impl Seams {
    /// Those of a shape as it is.
    pub(super) fn of(shape: &dyn Shape) -> Self {
        Self { curve: CurveSeams::of(shape), surface: Creases::of(shape) }
    }

    /// What of it is no more, in words; corners that were `made` are no loss.
    pub(super) fn lost(&self, name: &str, shape: &dyn Shape, made: &[f64]) -> Option<String> {
        self.curve.lost(name, shape, made).or_else(|| self.surface.lost(name, shape))
    }
}

/// Of a curve, whether its ends meet though its knots do not close it, and the knots at which it runs smoothly though they would let it fold.
#[derive(Debug, Default)]
struct CurveSeams {
    meets: bool,
    knots: Vec<f64>,
}

impl CurveSeams {
    /// Those of a curve as it is; none of other shapes.
    fn of(shape: &dyn Shape) -> Self {
        let Some(cells) = shape.cells().filter(|cells| shape.domain().len() == 1 && cells.count() <= MOST)
        else {
            return Self::default();
        };
        let size = extent(shape.control_vertices());
        let starts = cells.iter().filter_map(|cell| cell.sides.first().map(|side| side.start));
        Self {
            meets: gap(shape).is_some_and(|(.., gap)| gap <= MEETS * size),
            knots: starts.filter(|&u| turn(shape, u, u).is_some_and(|cosine| cosine >= SMOOTH)).collect(),
        }
    }

    /// What of it is no more, in words; corners that were `made` are no loss.
    fn lost(&self, name: &str, shape: &dyn Shape, made: &[f64]) -> Option<String> {
        let size = extent(shape.control_vertices());
        if let Some((.., gap)) = gap(shape).filter(|(.., gap)| self.meets && *gap > APART * size) {
            return Some(format!(
                "{name:?} has come open: its ends, which met, are {} apart, as each is held by itself; hold one of them, and the other goes with it",
                figure(gap)
            ));
        }
        let folded =
            |u: &&f64| !made.contains(u) && turn(shape, **u, **u).is_some_and(|cosine| cosine < FOLDED);
        let count = self.knots.iter().filter(folded).count();
        let first = self.knots.iter().find(folded)?;
        let more = if count > 1 { format!(" and at {} more knots", count - 1) } else { String::new() };
        Some(format!(
            "{name:?} has folded at {}{more}, where its knots let it and `bending` does not act: fit a curve whose knots are simple to it",
            figure(*first)
        ))
    }
}
