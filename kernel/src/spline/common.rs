//! One space for two shapes, so that they can be joined, blended or compared vertex by vertex.

use super::Curve;
use super::conversion::Conversion;
use super::space::{Space, periodic_knot};
use crate::error::Result;

/// The conversions, one after the other, that bring each of two spaces to a space that both have in common.
#[derive(Debug, Clone)]
pub struct Common {
    /// For the first space.
    pub first: Vec<Conversion>,
    /// For the second space.
    pub second: Vec<Conversion>,
}

impl Space {
    /// How this space and another become the same: the higher degree of the two, this space's domain, and all knots
    /// of both. Both are clamped on the way unless both are periodic.
    ///
    /// Knots of the other space that come to lie within rounding (8 ulp of the domain's largest number) of one of
    /// this space's are taken to be that knot: a span so short would be made of nothing but rounding errors.
    ///
    /// # Errors
    /// When a space has degree 0, or the other's knots cannot be told apart in this domain.
    pub fn common(&self, other: &Self) -> Result<Common> {
        let mut way = [Way::new(self), Way::new(other)];
        let closed = self.is_periodic() && other.is_periodic();
        let degree = self.degree().max(other.degree());
        for way in &mut way {
            if !closed && !way.space.is_clamped() {
                way.step(way.space.clamping()?);
            }
            while way.space.degree() < degree {
                way.step(way.space.elevating()?);
            }
        }
        if closed {
            for way in &mut way {
                let copies = way.space.knots().iter().take_while(|&&k| k == way.space.domain().0).count();
                if copies > 1 {
                    way.step(way.space.turning(copies - 1)?);
                }
            }
        }
        let [first, second] = &mut way;
        let (a, b) = first.space.domain();
        if second.space.domain() != (a, b) {
            second.step(second.space.reparametrising(a, b)?);
        }
        let slack = 8.0 * f64::EPSILON * a.abs().max(b.abs());
        if let Some(snapping) = second.space.snapping(&first.space, slack)? {
            second.step(snapping);
        }
        let missing = (missing(&first.space, &second.space), missing(&second.space, &first.space));
        for (way, missing) in way.iter_mut().zip([missing.0, missing.1]) {
            if !missing.is_empty() {
                way.step(way.space.inserting_up_to(degree + 1, &missing)?);
            }
        }
        let [first, second] = way;
        Ok(Common { first: first.steps, second: second.steps })
    }

    /// The conversion of a periodic space to the one whose period starts `by` knots, and vertices, later. Where the
    /// first `by + 1` knots coincide, it is the same period with those copies counted at its end.
    pub(super) fn turning(&self, by: usize) -> Result<Conversion> {
        let knots = (by..=by + self.len()).map(|k| periodic_knot(self.knots(), k as isize)).collect();
        Conversion::reordering(self, Self::periodic(self.degree(), knots)?, |k| k + by)
    }

    /// The conversion to the space whose knots lie exactly on another's where they are nearly there; nothing if they
    /// do already.
    fn snapping(&self, other: &Self, slack: f64) -> Result<Option<Conversion>> {
        let targets = other.breakpoints();
        let nearest = |&k: &f64| {
            let at = targets.partition_point(|&t| t < k - slack);
            targets.get(at).filter(|&&t| t <= k + slack).copied().unwrap_or(k)
        };
        let knots: Vec<f64> = self.knots().iter().map(nearest).collect();
        if knots == self.knots() {
            return Ok(None);
        }
        let p = self.degree();
        let to = if self.is_periodic() { Self::periodic(p, knots)? } else { Self::open(p, knots)? };
        Conversion::reordering(self, to, |k| k).map(Some)
    }
}

/// The knots that `space` lacks to have all of `other`'s, both over the same domain.
fn missing(space: &Space, other: &Space) -> Vec<f64> {
    let wanted = other.breakpoints();
    // The start of a period is its end once more: copies of the seam are counted there.
    let within = if space.is_periodic() { &wanted[1..] } else { &wanted[1..wanted.len() - 1] };
    within
        .iter()
        .flat_map(|&t| std::iter::repeat_n(t, other.multiplicity(t).saturating_sub(space.multiplicity(t))))
        .collect()
}

/// Steps from space to space.
struct Way {
    space: Space,
    steps: Vec<Conversion>,
}

impl Way {
    fn new(space: &Space) -> Self {
        Self { space: space.clone(), steps: Vec::new() }
    }

    fn step(&mut self, conversion: Conversion) {
        self.space = conversion.to().clone();
        self.steps.push(conversion);
    }
}

impl Curve {
    /// This curve and another in one space, neither of them changed but for the other's parameters; see
    /// [`Space::common`].
    ///
    /// # Errors
    /// When the other's knots cannot be told apart in this curve's domain.
    pub fn in_common_space(&self, other: &Self) -> Result<(Self, Self)> {
        let common = self.space().common(other.space())?;
        let convert = |curve: &Self, steps: &[Conversion]| {
            steps.iter().try_fold(curve.clone(), |curve, step| curve.convert(step))
        };
        Ok((convert(self, &common.first)?, convert(other, &common.second)?))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, assert_same_curve, is_torn};

    proptest! {
        #[test]
        fn two_curves_in_one_space(first in any_curve(), second in any_curve()) {
            prop_assume!(!is_torn(second.space()));
            let (a, b) = first.in_common_space(&second).unwrap();
            prop_assert_eq!(a.space(), b.space());
            prop_assert_eq!(a.domain(), first.domain());
            prop_assert_eq!(a.is_periodic(), first.is_periodic() && second.is_periodic());
            assert_same_curve(&first, &a, 1e-12);
            let (start, end) = first.domain();
            assert_same_curve(&second.reparametrise(start, end).unwrap(), &b, 1e-11);
        }
    }
}
