//! The part of a surface that loops bound, prepared for many questions: whether a place is in it, and which place of it is nearest.

mod border;
mod bounds;
mod outline;
mod tree;

use std::sync::OnceLock;

use super::closest::Closest;
use super::trimmed::ParameterCurve;
use super::{ParameterSide, Surface};
use crate::Point;
use crate::error::Result;
use border::Border;
use outline::Outline;

/// Chords of each span of a loop's curve: a quarter of a circle is a 10,000th of its radius from them.
const CHORDS: usize = 48;

/// The part of a surface that loops in its parameter plane bound: of a trimmed surface ([`Trimmed::part`](super::trimmed::Trimmed::part)) or of a face
/// ([`Brep::part`](crate::brep::Brep::part)).
///
/// Where the border of it is, is known to the chords that stand for its curves, 48 of each span.
pub struct Part {
    surface: Surface,
    outline: Outline,
    border: Vec<ParameterCurve>,
    /// Where the border is, once somebody asks.
    looks: OnceLock<Result<Border>>,
}

impl std::fmt::Debug for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Part")
            .field("surface", &self.surface)
            .field("border", &self.border)
            .finish_non_exhaustive()
    }
}

impl Part {
    /// Lines with the part on their left (none: all of the surface), and the curves of its border.
    pub(crate) fn new(
        surface: Surface,
        lines: &[Vec<[f64; 2]>],
        sides: [ParameterSide; 2],
        border: Vec<ParameterCurve>,
    ) -> Self {
        Self { surface, outline: Outline::new(lines, sides), border, looks: OnceLock::new() }
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The curves of its border, in the parameter plane.
    pub fn border(&self) -> &[ParameterCurve] {
        &self.border
    }

    /// Whether a place is in it: about `O(log chords)`.
    pub fn has(&self, at: [f64; 2]) -> bool {
        self.outline.has(at)
    }

    /// The parameters within the domain of a place that may be beyond an end at which the surface closes; elsewhere the nearest ones.
    pub fn wrapped(&self, at: [f64; 2]) -> [f64; 2] {
        let sides = self.outline.sides();
        [sides[0].wrapped(at[0]), sides[1].wrapped(at[1])]
    }

    /// The place of it that is nearest to a point: the nearest place of the surface where that is in it, else the nearest one of what is inside and of
    /// its border. One search or two, as [`Surface::closest`].
    ///
    /// # Errors
    /// When the point is not finite, or an evaluation overflows.
    pub fn closest(&self, point: Point) -> Result<Closest<(f64, f64)>> {
        let place = |found: Closest<(f64, f64)>| -> Result<Closest<(f64, f64)>> {
            let [u, v] = self.wrapped(found.at.into());
            let on = self.surface.point(u, v)?;
            Ok(Closest { at: (u, v), point: on, distance: (on - point).norm(), gap: found.gap })
        };
        let first = place(self.surface.closest(point)?)?;
        if self.has(first.at.into()) {
            return Ok(first);
        }
        let border = self.nearest_of_border(point)?;
        // Without a border all of it is inside.
        let Some((start, _)) = border else { return Ok(first) };
        place(self.surface.closest_kept(point, &self.outline, start)?)
    }

    /// A distance of the part from a point that is never less than the true one: that of the nearest place of the surface where that is in the part, which is the true
    /// one, else of the nearest place of the border. It costs a search of the surface and one of the border, where [`closest`](Self::closest) may look at
    /// ten thousand pieces.
    ///
    /// # Errors
    /// As for [`closest`](Self::closest).
    pub fn distance_at_most(&self, point: Point) -> Result<f64> {
        let foot = self.surface.closest_foot(point)?;
        if self.has(self.wrapped(foot.at.into())) {
            return Ok(foot.distance);
        }
        Ok(self.nearest_of_border(point)?.map_or(foot.distance, |(_, distance)| distance))
    }

    /// The place of the border that is nearest to a point, and how near. The first question takes an evaluation at 16 places of each span.
    fn nearest_of_border(&self, point: Point) -> Result<Option<((f64, f64), f64)>> {
        let sides = self.outline.sides();
        match self.looks.get_or_init(|| Border::new(&self.surface, sides, &self.border)) {
            Ok(border) => border.nearest(&self.surface, sides, &self.border, point),
            Err(error) => Err(error.clone()),
        }
    }
}

/// The chords of a curve in the parameter plane, added to a line: from its start to its end, or backwards.
pub(crate) fn follow(line: &mut Vec<[f64; 2]>, curve: &ParameterCurve, backwards: bool) -> Result<()> {
    let (from, to) = curve.range();
    let count = CHORDS * (curve.curve().space().breakpoints().len() - 1);
    for k in 0..=count {
        let share = k as f64 / count as f64;
        let share = if backwards { 1.0 - share } else { share };
        let at = curve.curve().point(if share >= 1.0 { to } else { from + (to - from) * share })?;
        line.push([at.x, at.y]);
    }
    Ok(())
}
