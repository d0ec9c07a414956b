//! How far a face of a surface is from triangles between points of it, certified.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::distance::from_triangle;

use super::cut::Cut;
use super::net::{Net, beyond_all, largest};
use super::pattern::Quadrant;

/// A neighbourhood that is no further from a triangle than this part of the chord is not looked into.
const ENOUGH: f64 = 0.02;
/// Levels that are looked into, at most. Neighbourhoods shrink by a third and more a level, so that this is beyond rounding.
const LEVELS: u32 = 56;

/// A face and the triangles that are to be near it.
pub(crate) struct Apart<'a> {
    cut: Cut,
    /// Its corners, the middles of edges and of itself; of middles that its cut does not have any.
    at: [Point; 9],
    chord: f64,
    /// All triangles round it, and its own.
    round: &'a dyn Fn() -> Vec<[Point; 3]>,
    /// Whether it took these.
    pub(super) from_others: bool,
}

/// What there is of a surface over a quadrant.
pub(crate) enum Over {
    /// One patch, by its Bézier points.
    Patch(Box<Net>),
    /// Points in whose convex hull it lies.
    Hull(Vec<Point>),
}

impl<'a> Apart<'a> {
    pub(super) fn new(cut: Cut, at: [Point; 9], chord: f64, round: &'a dyn Fn() -> Vec<[Point; 3]>) -> Self {
        Self { cut, at, chord, round, from_others: false }
    }

    /// A bound of the distance that a patch over a quadrant of the face has from its triangles or, where that is more than the chord, from all
    /// triangles round it and its own. More than the chord where that cannot be told.
    pub(crate) fn of_patch(&mut self, patch: &Net, quadrant: Quadrant) -> f64 {
        let own = self.cut.beyond(patch, quadrant, &self.at, self.chord);
        if own <= self.chord {
            return own;
        }
        self.from_others = true;
        beyond_all(patch, &(self.round)(), self.chord, 0)
    }

    /// The same of a face that is no patch, from what there is over its quadrants: what lies in a hull is near one triangle where all of the hull is.
    /// `whole` is the face, `parts` what is over the four quadrants of one, as `look` sees it. Cost: that of the quadrants.
    pub(crate) fn of_parts<P>(
        &mut self,
        whole: &P,
        parts: impl Fn(Quadrant, &P) -> [P; 4],
        look: impl Fn(Quadrant, &P) -> Result<Over>,
    ) -> Result<f64> {
        let triangles: Vec<[Point; 3]> =
            self.cut.triangles().iter().map(|t| t.map(|k| self.at[usize::from(k)])).collect();
        let divided = |quadrant: Quadrant, part: &P| quadrant.parts().into_iter().zip(parts(quadrant, part));
        let mut rest: Vec<(Quadrant, P)> = divided(Quadrant::WHOLE, whole).collect();
        let mut most = 0.0_f64;
        while let Some((quadrant, part)) = rest.pop() {
            if most > self.chord {
                break;
            }
            match look(quadrant, &part)? {
                Over::Patch(patch) => most = most.max(self.of_patch(&patch, quadrant)),
                Over::Hull(hull) => {
                    let from = |t: &[Point; 3]| largest(hull.iter().map(|q| from_triangle(q, t)));
                    let bound = triangles.iter().map(from).fold(f64::INFINITY, f64::min);
                    if bound <= most.max(ENOUGH * self.chord) || quadrant.level >= LEVELS {
                        most = most.max(bound);
                    } else {
                        rest.extend(divided(quadrant, &part));
                    }
                }
            }
        }
        Ok(most)
    }
}
