//! The ends as the paper keeps them: the whole tuned curve turned, scaled and moved.

use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use nalgebra::Rotation3;

use crate::error::{FineTuneError, Result};
use crate::turn::least_turn;

/// A similarity: `x ↦ to + scale · R (x - from)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Similarity {
    from: Point,
    to: Point,
    turn: Rotation3<f64>,
    pub(crate) scale: f64,
}

impl Similarity {
    /// The one that takes a pair of points to another, by the rotation of least angle.
    fn between([a, b]: [Point; 2], [c, d]: [Point; 2], which: &'static str) -> Result<Self> {
        let (from, to) = (b - a, d - c);
        let size = [a, b, c, d].iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let none = |v: &Vector| v.norm() <= 1e-12 * size;
        for (v, whose) in [(&from, "tuned"), (&to, "given")] {
            if none(v) {
                return Err(FineTuneError::Closed { which, whose });
            }
        }
        Ok(Self { from: a, to: c, turn: least_turn(&from, &to), scale: to.norm() / from.norm() })
    }

    fn apply(&self, p: &Point) -> Point {
        self.to + self.turn * (p - self.from) * self.scale
    }
}

/// The tuned curve with `fixed` control vertices at either end as the given curve has them, in the same space, and the rest brought
/// there by the similarity that takes the innermost of them to where they should be (paper 5, §2.1: one for the end points, two for
/// tangents, three for curvatures). Also by what it is scaled, and its angle in radians.
pub(crate) fn matched(tuned: &Curve, given: &Curve, fixed: usize) -> Result<(Curve, f64, f64)> {
    let (points, wanted) = (tuned.points(), given.points());
    let n = points.len();
    if n < 2 * fixed || wanted.len() != n {
        return Err(FineTuneError::Contradiction(format!(
            "{n} control vertices of the tuned curve are too few to keep {fixed} at either end: insert knots first, or keep less"
        )));
    }
    let size = wanted.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    if (wanted[0] - wanted[n - 1]).norm() <= 1e-12 * size {
        return Err(FineTuneError::Closed { which: "ends", whose: "given" });
    }
    const WHICH: [&str; 3] =
        ["ends", "second control points from the ends", "third control points from the ends"];
    let (first, last) = (fixed - 1, n - fixed);
    let which = WHICH.get(first).copied().unwrap_or("ends");
    let similarity =
        Similarity::between([points[first], points[last]], [wanted[first], wanted[last]], which)?;
    let mut moved: Vec<Point> = points.iter().map(|p| similarity.apply(p)).collect();
    moved[..fixed].copy_from_slice(&wanted[..fixed]);
    moved[n - fixed..].copy_from_slice(&wanted[n - fixed..]);
    Ok((Curve::new(tuned.space().clone(), moved)?, similarity.scale, similarity.turn.angle()))
}
