//! The foot of a point on a surface, searched from a place nearby.

use super::Surface;
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// Steps before the search stops with what it has.
const STEPS: usize = 60;

/// A closest point among those around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Its parameters.
    pub at: (f64, f64),
    /// The point there.
    pub point: Point,
    /// Its distance.
    pub distance: f64,
}

impl Surface {
    /// A point of the surface that is closest to `point` among those around it, reached downhill from `start`: for one point after
    /// another along a curve, where [`closest`](Self::closest) searches all of the surface. Parameters stay in the domain; in a periodic direction
    /// they run on, so that points along a curve have parameters without a jump.
    ///
    /// Gauss and Newton's steps `(JᵀJ + μI) d = Jᵀ(Q - S)`, `μ` by Levenberg and Marquardt: quadratic where the point is on the surface, slower
    /// the further it is off; a few evaluations of `O(pq)`. What is found may be a closest point among its neighbours only.
    ///
    /// # Errors
    /// When the point or the start is not finite.
    pub fn foot(&self, point: Point, start: (f64, f64)) -> Result<Foot> {
        self.foot_within(point, start, 0.0)
    }

    /// The point of the whole surface that is closest to `point`, to rounding: the [foot](Self::foot) from the certified closest place, where that is nearer still.
    ///
    /// # Errors
    /// When the point is not finite, or the distance is no number.
    pub fn closest_foot(&self, point: Point) -> Result<Foot> {
        let found = self.closest(point)?;
        let known = Foot { at: found.at, point: found.point, distance: found.distance };
        Ok(self.foot(point, found.at).ok().filter(|foot| foot.distance <= known.distance).unwrap_or(known))
    }

    /// As [`foot`](Self::foot), but any place as near as `enough` will do.
    pub(crate) fn foot_within(&self, point: Point, start: (f64, f64), enough: f64) -> Result<Foot> {
        if !(point.iter().all(|c| c.is_finite()) && start.0.is_finite() && start.1.is_finite()) {
            return Err(Error::Invalid("the point or the place to start from is not finite".into()));
        }
        let sides = [self.u(), self.v()].map(|s| (s.domain(), s.is_periodic()));
        let inside = |k: usize, t: f64| {
            let ((a, b), periodic) = sides[k];
            if periodic { t } else { t.clamp(a, b) }
        };
        let mut at = [inside(0, start.0), inside(1, start.1)];
        let mut d = [Vector::zeros(); 4];
        self.derivatives_into(at[0], at[1], [1, 1], &mut d)?;
        let mut away = point.coords - d[0];
        // Parameters of unlike lengths are measured by how far they move the point.
        let mut damping = 1e-12;
        for _ in 0..STEPS {
            if away.norm() <= enough {
                break;
            }
            let (su, sv) = (d[2], d[1]);
            let (mut a, b, mut c) = (su.dot(&su), su.dot(&sv), sv.dot(&sv));
            let (mut g, mut h) = (su.dot(&away), sv.dot(&away));
            // A parameter at its limit that would have to leave the domain stays there.
            let stuck = |k: usize, g: f64| {
                let ((low, high), periodic) = sides[k];
                !periodic && ((at[k] <= low && g < 0.0) || (at[k] >= high && g > 0.0))
            };
            let held = [stuck(0, g), stuck(1, h)];
            if held[0] {
                (a, g) = (0.0, 0.0);
            }
            if held[1] {
                (c, h) = (0.0, 0.0);
            }
            let b = if held[0] || held[1] { 0.0 } else { b };
            let step = |damping: f64| {
                let floor = f64::MIN_POSITIVE;
                let (m, n) = (a * (1.0 + damping) + floor, c * (1.0 + damping) + floor);
                // Scaled to a unit diagonal, so that the sizes of parameters do not matter.
                let (p, q) = (m.sqrt(), n.sqrt());
                let r = b / p / q;
                let (g, h) = (g / p, h / q);
                let det = 1.0 - r * r;
                if det > 1e-14 {
                    [(g - r * h) / det / p, (h - r * g) / det / q]
                } else {
                    [0.5 * g / p, 0.5 * h / q]
                }
            };
            let mut moved = false;
            while damping < 1e8 {
                let [du, dv] = step(damping);
                let next = [inside(0, at[0] + du), inside(1, at[1] + dv)];
                if next == at || !(next[0].is_finite() && next[1].is_finite()) {
                    break;
                }
                let mut there = [Vector::zeros(); 4];
                self.derivatives_into(next[0], next[1], [1, 1], &mut there)?;
                let further = point.coords - there[0];
                if further.norm_squared() < away.norm_squared() {
                    (at, d, away, moved) = (next, there, further, true);
                    damping = (damping * 0.1).max(1e-12);
                    break;
                }
                damping = (damping * 10.0).max(1e-6);
            }
            if !moved {
                break;
            }
        }
        Ok(Foot { at: (at[0], at[1]), point: Point::from(d[0]), distance: away.norm() })
    }

    /// Where on the surface the control vertex nearest to a point has most influence, or about there: to start [downhill](Self::foot) from.
    pub(crate) fn seed(&self, point: Point) -> (f64, f64) {
        let to = |vertex: &Point| (vertex - point).norm_squared();
        let nearest = self.points().iter().enumerate().min_by(|a, b| to(a.1).total_cmp(&to(b.1)));
        let vertex = nearest.map_or(0, |(k, _)| k);
        let (u, v) = (self.u(), self.v());
        (u.greville(vertex / v.len()), v.greville(vertex % v.len()))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::super::Curve;
    use super::*;

    fn sphere() -> Surface {
        let meridian = Curve::elliptic_arc(Point::origin(), -Vector::z(), Vector::x(), 0.0, PI).unwrap();
        Surface::revolution(&meridian, Point::origin(), Vector::z(), TAU).unwrap()
    }

    #[test]
    fn feet_are_found_from_far_and_near() {
        for surface in [sphere(), sphere().to_periodic(super::super::Direction::U, 1e-12).unwrap().shape] {
            for k in 0..200 {
                let t = f64::from(k);
                let direction = Vector::new(t.sin(), (1.7 * t).cos(), (0.6 * t).sin()).normalize();
                let (point, expected) = (Point::from(direction * 1.5), Point::from(direction));
                let whole = surface.closest(point).unwrap();
                let near = (whole.at.0 + 0.3 * (t * 3.0).sin(), whole.at.1 + 0.3 * (t * 5.0).cos());
                let foot = surface.foot(point, near).unwrap();
                // Off the surface the steps are not quadratic; across the seam of a clamped surface there is no way.
                if surface.u().is_periodic() || (near.0 - whole.at.0).abs() < whole.at.0.min(TAU - whole.at.0)
                {
                    assert!((foot.point - expected).norm() < 1e-6, "{k}: {foot:?} {whole:?}");
                }
                let foot = surface.foot(expected, near).unwrap();
                if surface.u().is_periodic() {
                    assert!(foot.distance < 1e-14, "{k}: {foot:?}");
                }
            }
        }
    }

    #[test]
    fn parameters_of_unlike_size_do_not_matter() {
        let space = |length: f64| super::super::Space::clamped(1, &[0.0, length]).unwrap();
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
        for (u, v) in [(1e-9, 1e9), (1e9, 1e-9), (1.0, 1.0)] {
            let flat = Surface::new(space(u), space(v), corners.to_vec()).unwrap();
            let foot = flat.foot(Point::new(0.3, 0.8, 2.0), (0.9 * u, 0.1 * v)).unwrap();
            assert!((foot.at.0 / u - 0.3).abs() + (foot.at.1 / v - 0.8).abs() < 1e-9, "{foot:?}");
            assert!((foot.distance - 2.0).abs() < 1e-12);
            let beyond = flat.foot(Point::new(-3.0, 0.8, 0.0), (0.9 * u, 0.1 * v)).unwrap();
            assert!(beyond.at.0 == 0.0 && (beyond.at.1 / v - 0.8).abs() < 1e-9, "{beyond:?}");
        }
        let nowhere = sphere().foot(Point::new(f64::NAN, 0.0, 0.0), (0.0, 0.0));
        assert!(nowhere.is_err());
    }
}
