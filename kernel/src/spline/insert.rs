//! Knot insertion: more control vertices for the same shape.

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, Result};

impl Space {
    /// The conversion to the space with more knots: each of `knots` once more, in any order, repeated ones as often
    /// as they come. A periodic space stays periodic; knots beyond its period are wrapped into it.
    ///
    /// Boehm's knot insertion for all new knots at once. `O((n + m) r² + m log m)` for `m` new knots, at most
    /// `r ≤ p` of them within one basis function's support. Vertices away from the new knots keep their bits.
    ///
    /// # Errors
    /// When a knot is not finite or outside the domain, or would then be repeated more than `p` times.
    pub fn inserting(&self, knots: &[f64]) -> Result<Conversion> {
        self.inserting_up_to(self.degree(), knots)
    }

    /// As [`inserting`](Self::inserting), up to `allowed` copies of a knot: `p + 1` only prepare an open space for
    /// shapes that are torn there.
    pub(super) fn inserting_up_to(&self, allowed: usize, knots: &[f64]) -> Result<Conversion> {
        let mut new = knots.iter().map(|&u| self.locate_knot(u)).collect::<Result<Vec<f64>>>()?;
        new.sort_by(f64::total_cmp);
        let p = self.degree();
        let old = self.knots();
        // Knots of an open space before and after the domain's own stay outside of all new ones.
        let (start, end) = if self.is_periodic() { (1, self.len()) } else { (p + 1, self.len()) };
        let mut merged = Vec::with_capacity(old.len() + new.len());
        merged.extend_from_slice(&old[..start]);
        let mut rest = new.as_slice();
        for &knot in &old[start..end] {
            let (before, after) = rest.split_at(rest.partition_point(|&u| u < knot));
            merged.extend_from_slice(before);
            merged.push(knot);
            rest = after;
        }
        merged.extend_from_slice(rest);
        merged.extend_from_slice(&old[end..]);
        let to = if self.is_periodic() { Self::periodic(p, merged)? } else { Self::open(p, merged)? };
        for u in new {
            let multiplicity = to.multiplicity(u);
            if multiplicity > allowed {
                return Err(Error::Multiplicity { value: u, multiplicity, degree: p, allowed });
            }
        }
        Conversion::refining(self, to)
    }
}

impl Curve {
    /// The same curve with more knots; see [`Space::inserting`].
    ///
    /// ```
    /// use loftsman_kernel::{Point, spline::{Curve, Space}};
    /// let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i), 0.0)).collect();
    /// let curve = Curve::new(Space::clamped_uniform(3, 6)?, points)?;
    /// let finer = curve.insert_knots(&[0.5, 1.25, 1.25])?;
    /// assert_eq!(finer.points().len(), 9);
    /// assert!((finer.point(0.7)? - curve.point(0.7)?).norm() < 1e-14);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When a knot is not finite or outside the domain, or would then be repeated more than `p` times.
    pub fn insert_knots(&self, knots: &[f64]) -> Result<Self> {
        self.convert(&self.space().inserting(knots)?)
    }
}

impl Surface {
    /// The same surface with more knots in one direction; see [`Space::inserting`].
    ///
    /// # Errors
    /// When a knot is not finite or outside the domain, or would then be repeated more than `p` times.
    pub fn insert_knots(&self, direction: Direction, knots: &[f64]) -> Result<Self> {
        self.convert(direction, &self.space(direction).inserting(knots)?)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, assert_same_surface, line_of};
    use super::*;

    proptest! {
        #[test]
        fn inserted_knots_change_nothing(
            curve in any_curve(),
            shares in prop::collection::vec((0.0..=1.0_f64, 1_usize..4), 1..12),
        ) {
            let (a, b) = curve.domain();
            let mut space = curve.space().clone();
            let mut new = Vec::new();
            for (share, times) in shares {
                // Half of the new knots lie on old ones, as far as there is room.
                let u = (a + share * (b - a)).clamp(a, b);
                let u = if times == 1 { u } else { u.round().clamp(a, b) };
                let knots = vec![u; times];
                if let Ok(conversion) = space.inserting(&knots) {
                    space = conversion.to().clone();
                    new.extend(knots);
                }
            }
            let finer = curve.insert_knots(&new).unwrap();
            prop_assert_eq!(finer.space().len(), curve.space().len() + new.len());
            prop_assert_eq!(finer.is_periodic(), curve.is_periodic());
            prop_assert_eq!(finer.domain(), curve.domain());
            assert_same_curve(&curve, &finer, 1e-12);
            let conversion = curve.space().inserting(&new).unwrap();
            for k in 0..conversion.to().len() {
                let sum: f64 = conversion.row(k).map(|(_, c)| c).sum();
                prop_assert!((sum - 1.0).abs() < 1e-14 && conversion.row(k).all(|(_, c)| c >= 0.0));
            }
        }

        #[test]
        fn surfaces_in_either_direction(surface in any_surface(), s in 0.0..1.0_f64, t in 0.0..1.0_f64) {
            for direction in [Direction::U, Direction::V] {
                let (a, b) = surface.space(direction).domain();
                let new = [a + s * (b - a), a + t * (b - a)];
                let finer = surface.insert_knots(direction, &new).unwrap();
                assert_same_surface(&surface, &finer, 1e-12);
            }
        }
    }

    #[test]
    fn what_cannot_be_inserted_is_refused() {
        let curve = line_of(3, 8);
        assert!(matches!(curve.insert_knots(&[f64::NAN]), Err(Error::Outside { .. })));
        assert!(matches!(curve.insert_knots(&[-1.0]), Err(Error::Outside { .. })));
        assert!(matches!(curve.insert_knots(&[0.0]), Err(Error::Multiplicity { .. })));
        assert!(matches!(curve.insert_knots(&[2.0; 3]), Err(Error::Multiplicity { allowed: 3, .. })));
        assert_eq!(curve.insert_knots(&[]).unwrap(), curve);
        let flat = Space::open(0, vec![0.0, 1.0, 2.0]).unwrap();
        assert!(matches!(flat.inserting(&[]), Err(Error::Degree { degree: 0 })));
    }

    #[test]
    fn untouched_vertices_keep_their_bits() {
        let curve = line_of(3, 1000);
        let finer = curve.insert_knots(&[500.5]).unwrap();
        assert_eq!(finer.points()[..501], curve.points()[..501]);
        assert_eq!(finer.points()[504..], curve.points()[503..]);
    }

    #[test]
    fn a_knot_inserted_into_the_smallest_periodic_spaces() {
        for (degree, vertices) in [(1, 2), (2, 2), (3, 2), (5, 2), (25, 2), (7, 3)] {
            let space = Space::periodic_uniform(degree, vertices).unwrap();
            let points = (0..vertices).map(|i| crate::Point::new(i as f64, (i * i) as f64, 1.0)).collect();
            let curve = Curve::new(space, points).unwrap();
            for new in [vec![0.3], vec![0.3, 0.3, 1.7], vec![0.0], vec![vertices as f64]] {
                if degree >= 3 || new.len() == 1 && new[0] == 0.3 {
                    let finer = curve.insert_knots(&new).unwrap();
                    assert_same_curve(&curve, &finer, 1e-13);
                }
            }
        }
    }
}
