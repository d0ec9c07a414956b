//! Branches that are parameter lines.
//!
//! Where the plane meets a surface along a line on which one parameter stands still, the section is an isocurve, which is a spline of the surface's own
//! degree, knots and weights: a circle of a surface of revolution, a rib of a loft. An isocurve lies in a plane exactly when all of its control vertices do,
//! which is asked for to rounding; then it takes the place of the branch that was drawn.

use loftsman_kernel::spline::{Curve, Direction, Surface};

use super::{ALONG, PLACES, SectionCurve, places_along};
use crate::error::Result;
use crate::intersections::Plane;

/// Units in the last place that a few sums leave, of what went into them.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// How near, as a part of the domain, the end of a branch is to the surface's own.
const END: f64 = 1e-7;
/// The most of Newton's steps to the parameter.
const STEPS: usize = 20;

/// A surface and a plane, and the sizes to measure by.
pub(super) struct Lines<'a> {
    surface: &'a Surface,
    plane: &'a Plane,
    /// The largest coordinate that a distance from the plane is made of.
    size: f64,
    tolerance: f64,
}

impl<'a> Lines<'a> {
    pub(super) fn new(surface: &'a Surface, plane: &'a Plane, tolerance: f64) -> Self {
        let (low, high) = surface.hull_bounds();
        let size = [low, high, plane.point()].iter().fold(0.0_f64, |most, p| most.max(p.coords.amax()));
        Self { surface, plane, size, tolerance }
    }

    /// Puts isocurves in the place of the branches that they are. `O(p n)` a branch, and a few closest points.
    pub(super) fn replace(&self, branches: &mut [SectionCurve]) -> Result<()> {
        for branch in branches {
            for direction in [Direction::U, Direction::V] {
                if let Some(exact) = self.isocurve(branch, direction)? {
                    *branch = exact;
                    break;
                }
            }
        }
        Ok(())
    }

    fn isocurve(&self, branch: &SectionCurve, direction: Direction) -> Result<Option<SectionCurve>> {
        let d = usize::from(direction == Direction::V);
        let Some(&start) = branch.parameters.get(branch.parameters.len() / 2) else { return Ok(None) };
        let space = self.surface.space(direction);
        // Where a surface has a fold, or leaves the plane at no angle, the line is at a knot if at all.
        let knots = space.breakpoints();
        let after = knots.partition_point(|knot| *knot < start[d]);
        let beside = [after.saturating_sub(1), after].map(|k| knots.get(k).copied());
        for at in beside.into_iter().flatten().chain(self.newton(start, d)?) {
            if self.runs_along(branch, d, at)?
                && let Some(found) = self.at(branch, direction, at)?
            {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// The parameter near to a place at which the surface is in the plane, the other one held.
    fn newton(&self, start: [f64; 2], d: usize) -> Result<Option<f64>> {
        let space = if d == 0 { self.surface.u() } else { self.surface.v() };
        let (low, high) = space.domain();
        let mut at = start;
        for _ in 0..STEPS {
            let height = self.plane.distance(&self.surface.point(at[0], at[1])?);
            let slope = self.plane.normal().dot(&self.surface.derivative(at[0], at[1], 1 - d, d)?);
            let next = (at[d] - height / slope).clamp(low, high);
            if !next.is_finite() {
                return Ok(None);
            }
            let step = (next - at[d]).abs();
            at[d] = next;
            if step <= f64::EPSILON * next.abs() {
                break;
            }
        }
        Ok(Some(at[d]))
    }

    /// Whether all ends of a branch's spans are where the surface is with one parameter at this value.
    fn runs_along(&self, branch: &SectionCurve, d: usize, at: f64) -> Result<bool> {
        for own in &branch.parameters {
            let mut moved = *own;
            moved[d] = at;
            let [p, q] = [self.surface.point(own[0], own[1])?, self.surface.point(moved[0], moved[1])?];
            let far = (p - q).norm();
            if far.is_nan() || far > ALONG * self.tolerance {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The isocurve, where it is in the plane and all of the branch.
    fn at(&self, branch: &SectionCurve, direction: Direction, at: f64) -> Result<Option<SectionCurve>> {
        let d = usize::from(direction == Direction::V);
        let mut curve = self.surface.isocurve(direction, at)?;
        let height = curve.points().iter().map(|p| self.plane.distance(p).abs()).fold(0.0, f64::max);
        // A parameter is known to rounding, too, and so is what the surface rises with it.
        let middle = branch.parameters[branch.parameters.len() / 2];
        let rise = self.surface.derivative(middle[0], middle[1], 1 - d, d)?.norm() * at.abs();
        let room = ROUNDING * (self.size + rise);
        if height.is_nan() || height > room {
            return Ok(None);
        }
        let (low, high) = curve.domain();
        if branch.closed {
            // Loops are periodic, with a knot where the surface has its seam.
            if !curve.is_periodic() {
                match curve.to_periodic(room) {
                    Ok(closed) if closed.deviation <= room => curve = closed.shape,
                    _ => return Ok(None),
                }
            }
        } else {
            let near = END * (high - low);
            let ends = [branch.parameters.first(), branch.parameters.last()].map(|p| p.map(|p| p[1 - d]));
            let [Some(a), Some(b)] = ends else { return Ok(None) };
            if curve.is_periodic() || a.min(b) > low + near || a.max(b) < high - near {
                return Ok(None);
            }
        }
        if places_along(&branch.curve, &[&curve], ALONG * self.tolerance)? < PLACES {
            return Ok(None);
        }
        let parameters =
            curve.space().breakpoints().into_iter().map(|t| if d == 0 { [at, t] } else { [t, at] });
        Ok(Some(SectionCurve {
            closed: branch.closed,
            distance: height,
            parameters: parameters.collect(),
            isocurve: Some((direction, at)),
            curve,
        }))
    }
}

/// Whether a curve is a spline as branches are drawn: cubic, without weights.
pub(super) fn is_drawn(curve: &Curve) -> bool {
    curve.degree() == 3 && curve.weights().is_none()
}
