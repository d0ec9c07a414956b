//! Parts of splines: cutting in two, cutting out, opening what is periodic. All parts are clamped.

use std::borrow::Cow;

use super::conversion::{Conversion, Direction};
use super::space::Space;
use super::{Curve, Surface};
use crate::error::{Error, Result};

impl Space {
    /// The conversion to the clamped space over the part `[a, b]` of the domain: knots `p + 1` times at both ends,
    /// and between them this space's own. `O(n + k p²)` for the `k` knots near the ends.
    ///
    /// The part of a periodic space may go on past its end, by at most one period in all; the new domain starts at
    /// `a` wrapped into the period.
    ///
    /// # Errors
    /// When `a < b` does not hold, either is not finite or outside the domain, or they are more than a period
    /// apart, or the space has degree 0.
    pub fn restricting(&self, a: f64, b: f64) -> Result<Conversion> {
        let (start, end) = self.domain();
        let from = self.locate_knot(a)?;
        if !self.is_periodic() {
            return Conversion::restricting(self, from, self.locate_knot(b)?);
        }
        if !b.is_finite() {
            return Err(Error::Outside { value: b, start, end });
        }
        // One period on from a knot must meet that knot's next copy to the last bit.
        let furthest = end + (from - start);
        let to = if a == from { b } else { from + (b - a) };
        let slack = 8.0 * f64::EPSILON * furthest.abs().max(a.abs()).max(b.abs());
        if to > furthest + slack {
            return Err(Error::Outside { value: b, start: a, end: a + (end - start) });
        }
        let to = if to >= furthest - slack { furthest } else { to };
        // From the end of the period on is from its start on.
        let (from, to) = if from == end { (start, (start + (to - end)).min(end)) } else { (from, to) };
        Conversion::restricting(self, from, to)
    }

    /// The conversion to the clamped space over the same domain; a periodic space is opened at its seam.
    ///
    /// # Errors
    /// When the space has degree 0.
    pub fn clamping(&self) -> Result<Conversion> {
        let (a, b) = self.domain();
        Conversion::restricting(self, a, b)
    }
}

impl Curve {
    /// The part from `a` to `b`, clamped, with its parameters as they were; see [`Space::restricting`].
    ///
    /// # Errors
    /// When `a < b` does not hold, either is not finite or outside the domain, or, on a periodic curve, they are
    /// more than a period apart.
    pub fn between(&self, a: f64, b: f64) -> Result<Self> {
        self.convert(&self.space().restricting(a, b)?)
    }

    /// The two parts before and after `u`, clamped; of a periodic curve, one: the whole, opened at `u` and going
    /// once round.
    ///
    /// ```
    /// use loftsman_kernel::{Point, spline::{Curve, Space}};
    /// let points = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect();
    /// let ring = Curve::new(Space::periodic_uniform(3, 6)?, points)?;
    /// let [open] = &ring.split(2.5)?[..] else { unreachable!() };
    /// assert_eq!(open.domain(), (2.5, 8.5));
    /// let parts = open.split(4.0)?;
    /// assert_eq!(parts[0].points().last(), parts[1].points().first());
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `u` is not finite, outside the domain, or at an end of an open curve.
    pub fn split(&self, u: f64) -> Result<Vec<Self>> {
        cuts(self.space(), u)?.iter().map(|conversion| self.convert(conversion)).collect()
    }

    /// The same curve with knots of full multiplicity at both ends, so that it starts and ends at control vertices.
    /// A periodic curve is opened at its seam.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn to_clamped(&self) -> Result<Self> {
        self.convert(&self.space().clamping()?)
    }

    /// Whether it is open and starts and ends at control vertices.
    pub fn is_clamped(&self) -> bool {
        !self.space().is_periodic() && self.space().is_clamped()
    }

    /// What becomes of it in formats that hold clamped splines only; `None` where it is one.
    pub fn change_when_clamped(&self) -> Option<&'static str> {
        (!self.is_clamped()).then(|| clamping_in_words(self.space().is_periodic()))
    }

    /// [Clamped](Self::to_clamped), for those who take no other knots: itself where it is.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn clamped(&self) -> Result<Cow<'_, Self>> {
        if self.is_clamped() { Ok(Cow::Borrowed(self)) } else { self.to_clamped().map(Cow::Owned) }
    }
}

impl Surface {
    /// The part from `a` to `b` in one direction, clamped there; see [`Curve::between`].
    ///
    /// # Errors
    /// As for [`Curve::between`].
    pub fn between(&self, direction: Direction, a: f64, b: f64) -> Result<Self> {
        self.convert(direction, &self.space(direction).restricting(a, b)?)
    }

    /// The two parts before and after a parameter of one direction, or one part, opened there, where that direction
    /// is periodic; see [`Curve::split`].
    ///
    /// # Errors
    /// As for [`Curve::split`].
    pub fn split(&self, direction: Direction, at: f64) -> Result<Vec<Self>> {
        cuts(self.space(direction), at)?
            .iter()
            .map(|conversion| self.convert(direction, conversion))
            .collect()
    }

    /// The same surface, clamped in both directions.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn to_clamped(&self) -> Result<Self> {
        self.convert(Direction::U, &self.u().clamping()?)?.convert(Direction::V, &self.v().clamping()?)
    }

    /// Whether it is open in both directions, and its borders are rows of control vertices.
    pub fn is_clamped(&self) -> bool {
        [self.u(), self.v()].iter().all(|space| !space.is_periodic() && space.is_clamped())
    }

    /// What becomes of it in formats that hold clamped splines only; `None` where it is one.
    pub fn change_when_clamped(&self) -> Option<&'static str> {
        let opened = self.u().is_periodic() || self.v().is_periodic();
        (!self.is_clamped()).then(|| clamping_in_words(opened))
    }

    /// [Clamped](Self::to_clamped), for those who take no other knots: itself where it is.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub fn clamped(&self) -> Result<Cow<'_, Self>> {
        if self.is_clamped() { Ok(Cow::Borrowed(self)) } else { self.to_clamped().map(Cow::Owned) }
    }
}

fn clamping_in_words(opened: bool) -> &'static str {
    if opened {
        "opened at its seam and clamped, the same shape"
    } else {
        "clamped at its ends, the same shape"
    }
}

/// The conversions to the parts of a space that is cut at a parameter.
fn cuts(space: &Space, at: f64) -> Result<Vec<Conversion>> {
    let (a, b) = space.domain();
    let at = space.locate_knot(at)?;
    if space.is_periodic() {
        return Ok(vec![space.restricting(at, at + space.length())?]);
    }
    if at == a || at == b {
        return Err(Error::Invalid(format!(
            "{at} is an end of the domain [{a}, {b}]: nothing is left to cut off there, choose a location inside"
        )));
    }
    Ok(vec![Conversion::restricting(space, a, at)?, Conversion::restricting(space, at, b)?])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, assert_same_curve, assert_same_surface, line_of};
    use super::*;
    use crate::Point;

    proptest! {
        #[test]
        fn parts_are_the_same_curve(curve in any_curve(), s in 0.02..0.95_f64, whole in any::<bool>()) {
            let (a, b) = curve.domain();
            let u = if whole { (a + s * (b - a)).round() } else { a + s * (b - a) };
            prop_assume!(u > a && u < b && curve.space().multiplicity(u) <= curve.degree());
            let parts = curve.split(u).unwrap();
            for part in &parts {
                prop_assert!(part.space().is_clamped());
                assert_same_curve(&curve, part, 1e-12);
            }
            if curve.is_periodic() {
                prop_assert_eq!(parts.len(), 1);
                prop_assert!((parts[0].space().length() - curve.space().length()).abs() < 1e-13);
                let (first, last) = (parts[0].points().first().unwrap(), parts[0].points().last().unwrap());
                prop_assert!((first - last).norm() < 1e-12 * 10.0);
            } else {
                prop_assert_eq!((parts[0].domain(), parts[1].domain()), ((a, u), (u, b)));
            }
        }

        #[test]
        fn a_part_across_the_seam(curve in any_curve(), s in 0.0..=1.0_f64, t in 0.05..=1.0_f64, turns in -2..3_i8) {
            prop_assume!(curve.is_periodic());
            let (a, b) = curve.domain();
            let from = a + s * (b - a) + f64::from(turns) * (b - a);
            let part = curve.between(from, from + t * (b - a)).unwrap();
            assert_same_curve(&curve, &part, 1e-12);
            let start = curve.point(from).unwrap();
            prop_assert!((part.point(part.domain().0).unwrap() - start).norm() < 1e-11 * 10.0);
        }

        #[test]
        fn clamping_changes_no_surface(surface in any_surface(), s in 0.1..0.9_f64) {
            assert_same_surface(&surface, &surface.to_clamped().unwrap(), 1e-12);
            for direction in [Direction::U, Direction::V] {
                let (a, b) = surface.space(direction).domain();
                for part in surface.split(direction, a + s * (b - a)).unwrap() {
                    assert_same_surface(&surface, &part, 1e-12);
                }
            }
        }
    }

    #[test]
    fn clamped_curves_stay_as_they_are() {
        let curve = line_of(3, 9);
        assert_eq!(curve.to_clamped().unwrap(), curve);
    }

    #[test]
    fn torn_curves_come_apart_at_the_tear() {
        let space = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]).unwrap();
        let points: Vec<Point> = (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i), 0.0)).collect();
        let torn = Curve::new(space, points.clone()).unwrap();
        for curve in [torn.clone(), torn.bezier_form().unwrap()] {
            let parts = curve.split(1.0).unwrap();
            assert_eq!((parts[0].points(), parts[1].points()), (&points[..3], &points[3..]));
        }
        let raised = torn.elevate(2).unwrap().split(1.0).unwrap();
        assert_eq!(raised[0].points().last(), Some(&points[2]));
        assert_eq!(raised[1].points().first(), Some(&points[3]));
    }

    #[test]
    fn parts_that_cannot_be_are_refused() {
        let curve = line_of(3, 9);
        assert!(matches!(curve.between(2.0, 1.0), Err(Error::KnotOrder { .. } | Error::EmptyDomain { .. })));
        assert!(curve.between(1.0, 1.0).is_err());
        assert!(curve.between(f64::NAN, 1.0).is_err());
        assert!(curve.between(1.0, f64::INFINITY).is_err());
        assert!(curve.between(1.0, 7.0).is_err());
        assert!(curve.split(0.0).is_err() && curve.split(6.0).is_err());
        let points = (0..4).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let ring = Curve::new(Space::periodic_uniform(3, 4).unwrap(), points).unwrap();
        assert!(ring.change_when_clamped().is_some_and(|change| change.starts_with("opened at its seam")));
        assert!(ring.between(1.0, 5.5).is_err());
        assert!(ring.between(1.0, f64::NAN).is_err());
        assert!(ring.between(1.0, f64::NEG_INFINITY).is_err());
        assert_eq!(ring.between(4.0, 8.0).unwrap().domain(), (0.0, 4.0));
    }
}
