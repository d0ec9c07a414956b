//! What is handed out, measured afresh: the one place that says whether an answer holds.
//!
//! Nobody believes a solver. Whoever hands out shapes that were asked something (an edit, a fairing, a fit, a loft) asks the
//! functionals themselves, on these shapes, and has the answer judged here: each equation by the
//! [`Accuracy`](crate::functional::Accuracy) that it promises, rounding being that of numbers as large as those that went in.

use smallvec::SmallVec;

use crate::Point;
use crate::error::Result;
use crate::functional::{
    Equation, Functional, Linearity, Shapes, Store, linearize_of, rows_of, usable, value_of,
};
use crate::solve::Sense;

/// Linear equations hold to so many units in the last place of the numbers that they are made of. Sums of a few dozen terms
/// lose some units; a solver that squares the condition and need not correct its answer (below a hundred) loses that many.
pub const ROUNDING: f64 = 256.0 * f64::EPSILON;
/// Other equations are iterated, and hold to this share of the numbers that they are made of.
pub const ITERATED: f64 = 1e-12;
/// Coordinates of an answer count as its own rounding's size up to so many times the size of what went in: an adjustment
/// that is more out of proportion does not excuse what it misses by its own size.
pub const PROPORTION: f64 = 1e6;

/// What an equation's error is, and what its accuracy allows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Error {
    /// By how much the value misses its target, on the wrong side of it for an inequality.
    pub error: f64,
    /// What is allowed.
    pub allowed: f64,
}

impl Error {
    /// Whether it is allowed. What is not finite is not.
    pub fn holds(&self) -> bool {
        self.error.is_finite() && self.error <= self.allowed
    }

    /// The worse of two: that which exceeds what is allowed for it by the larger factor.
    #[must_use]
    pub fn or_worse(self, other: Self) -> Self {
        let excess = |e: &Self| if e.error == 0.0 { 0.0 } else { e.error / e.allowed };
        // Written so that NaN is the worst.
        if excess(&self).is_nan() || excess(&other) <= excess(&self) { self } else { other }
    }
}

/// What was found of one condition.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// The largest error of its equations, whatever is allowed for each: of the three of a vector, or the two or three of one thing, their length.
    pub error: f64,
    /// The equation that is worst beside what is allowed for it.
    pub worst: Error,
    /// The same between the places where it was imposed, for a condition that is meant along an edge.
    pub between: Option<Error>,
}

impl Measured {
    /// Whether the condition holds, between the places where it was imposed, too.
    pub fn holds(&self) -> bool {
        self.worst.holds() && self.between.is_none_or(|between| between.holds())
    }

    /// The error that speaks most against it.
    pub fn verdict(&self) -> Error {
        self.between.map_or(self.worst, |between| self.worst.or_worse(between))
    }
}

/// By how much a value misses its target that is `wanted` above it (below it, where negative).
pub fn error_of(sense: Sense, wanted: f64) -> f64 {
    match sense {
        Sense::Equal => wanted.abs(),
        // Not `max`, which would take NaN for zero.
        Sense::AtLeast if wanted <= 0.0 => 0.0,
        Sense::AtMost if wanted >= 0.0 => 0.0,
        Sense::AtLeast | Sense::AtMost => wanted.abs(),
    }
}

/// Measures one condition on shapes.
///
/// `target` has a number for each equation of the functional, of which those count that are `asked`; `reach` is the size of
/// what went in: the largest coordinate of the shapes before, or the way that a target asked for, if that is longer. An
/// equation `Σ c_i P_i` may miss by [`ROUNDING`] (a nonlinear one, with gradient `c`, by [`ITERATED`]) times
/// `Σ |c_i| s_i + |target|`, `s_i` being the largest coordinate of `P_i`, but no more than [`PROPORTION`] times the reach and
/// no less than the reach. What is promised within a tolerance is judged as a length where it is a vector: by the distance, not
/// by its coordinates. Costs what the functional's value and rows cost.
///
/// # Errors
/// When the functional cannot be asked of these shapes.
pub fn measure(
    shapes: &Shapes<'_>,
    functional: &dyn Functional,
    sense: Sense,
    target: &[f64],
    asked: &dyn Fn(usize) -> bool,
    reach: f64,
) -> Result<Measured> {
    measure_in(&mut Store::default(), shapes, functional, sense, target, asked, reach)
}

/// [`measure`] with room for rows, for many conditions one after the other.
pub(crate) fn measure_in(
    store: &mut Store,
    shapes: &Shapes<'_>,
    functional: &dyn Functional,
    sense: Sense,
    target: &[f64],
    asked: &dyn Fn(usize) -> bool,
    reach: f64,
) -> Result<Measured> {
    let (error, worst) = equations(store, shapes, functional, sense, target, asked, reach)?;
    let between = match functional.witness(shapes)? {
        None => None,
        Some(witness) => {
            let zero = vec![0.0; witness.equations()];
            Some(equations(store, shapes, witness.as_ref(), Sense::Equal, &zero, &|_| true, reach)?.1)
        }
    };
    Ok(Measured { error, worst, between })
}

/// Measures one place that a shape should pass: `found` where it does, `wanted` where it should; `reach` as in [`measure`], and
/// `vertices` the largest coordinate of the shape's control vertices. What [`measure`] allows a position, for thousands of them.
pub fn place(found: &Point, wanted: &Point, vertices: f64, reach: f64) -> Error {
    let size = vertices.min(PROPORTION * reach).max(reach);
    (0..3).fold(Error::default(), |worst, axis| {
        let error = (found[axis] - wanted[axis]).abs();
        worst.or_worse(Error { error, allowed: ROUNDING * (size + wanted[axis].abs()) })
    })
}

fn equations(
    store: &mut Store,
    shapes: &Shapes<'_>,
    functional: &dyn Functional,
    sense: Sense,
    target: &[f64],
    asked: &dyn Fn(usize) -> bool,
    reach: f64,
) -> Result<(f64, Error)> {
    let count = functional.equations();
    let mut value: SmallVec<[f64; 3]> = SmallVec::from_elem(0.0, count);
    store.clear();
    let linear = functional.linearity() == Linearity::Linear;
    if linear {
        // Of a linear one both are made of the same.
        linearize_of(functional, shapes, &mut store.rows(shapes), &mut value)?;
        usable(functional, store, 0)?;
    } else {
        value_of(functional, shapes, &mut value)?;
        rows_of(functional, shapes, &mut store.rows(shapes))?;
    }
    let unit = if linear { ROUNDING } else { ITERATED };
    let own = functional.accuracy().tolerance();
    let size = |v: usize| shapes.vertex(v).coords.amax().min(PROPORTION * reach).max(reach);
    let (mut largest, mut worst) = (0.0_f64, Error::default());
    let mut keep = |told: f64, found: Error| {
        largest = if largest.is_nan() || told <= largest { largest } else { told };
        worst = worst.or_worse(found);
    };
    let look = |equation: usize, sum: f64, keep: &mut dyn FnMut(f64, Error)| {
        let (Some(target), Some(value)) = (target.get(equation), value.get(equation)) else { return };
        if asked(equation) {
            let error = error_of(sense, target - value);
            keep(error, Error { error, allowed: own + unit * (sum + target.abs()) });
        }
    };
    let (mut equation, mut coupled) = (0, 0);
    for block in store.equations() {
        match block {
            Equation::Alike { vertices, coefficients, .. } => {
                let sum: f64 = vertices.iter().zip(coefficients).map(|(&v, c)| c.abs() * size(v)).sum();
                let axes = equation..equation + 3;
                if sense == Sense::Equal && axes.clone().all(asked) {
                    let both = axes.clone().map(|e| target.get(e).copied().zip(value.get(e).copied()));
                    let off = both.flatten().map(|(target, value)| (target - value, target));
                    let (error, target) = off
                        .fold((0.0_f64, 0.0), |(error, size): (f64, f64), (off, target)| {
                            (error.hypot(off), size.max(target.abs()))
                        });
                    if own > 0.0 {
                        keep(error, Error { error, allowed: own + unit * (sum + target) });
                        equation += 3;
                        continue;
                    }
                    // Told is the distance, and judged is each coordinate.
                    keep(error, Error::default());
                }
                axes.for_each(|axis| look(axis, sum, &mut keep));
                equation += 3;
            }
            Equation::Coupled { vertices, vectors, .. } => {
                let sum: f64 = vertices.iter().zip(vectors).map(|(&v, a)| a.lp_norm(1) * size(v)).sum();
                look(equation, sum, &mut keep);
                (equation, coupled) = (equation + 1, coupled + 1);
            }
        }
    }
    // The two or three numbers of one thing (how far a derivative is beside a direction) are told as one length, too.
    let of_one = coupled == count && (2..=3).contains(&count) && own == 0.0;
    if of_one && sense == Sense::Equal && (0..count).all(asked) {
        let off = target.iter().zip(&value).map(|(target, value)| target - value);
        keep(off.fold(0.0, f64::hypot), Error::default());
    }
    Ok((largest, worst))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::functional::{position, vertex};
    use crate::spline::{Curve, Space};

    fn line(size: f64) -> Curve {
        let points = (0..6).map(|i| Point::new(f64::from(i) * size, 0.0, 0.0)).collect();
        Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap()
    }

    #[test]
    fn an_error_is_judged_by_the_size_of_what_went_in() {
        for size in [1e-9, 1.0, 1e9] {
            let curve = line(size);
            let shapes = Shapes::one(&curve);
            let place = curve.point(1.0).unwrap().coords;
            let look = |by: f64| {
                let target = place + Vector::new(0.0, by * size, 0.0);
                let measured =
                    measure(&shapes, &position(1.0), Sense::Equal, target.as_slice(), &|_| true, 5.0 * size);
                measured.unwrap()
            };
            assert!(look(0.0).holds() && look(1e-15).holds());
            assert!(!look(1e-12).holds() && (look(1e-12).error / size / 1e-12 - 1.0).abs() < 1e-9);
            assert!(!look(f64::NAN).holds() && !look(f64::INFINITY).holds());
        }
    }

    #[test]
    fn a_place_is_judged_as_a_position_is() {
        let curve = line(3.0);
        let (found, reach) = (curve.point(1.0).unwrap(), 15.0);
        for by in [0.0, 1e-15, 1e-13, 1e-12, 1e-6, f64::NAN, f64::INFINITY] {
            let wanted = found + Vector::new(by, 0.0, -by);
            let target = wanted.coords;
            let all = |_| true;
            let shapes = Shapes::one(&curve);
            let slow =
                measure(&shapes, &position(1.0), Sense::Equal, target.as_slice(), &all, reach).unwrap();
            assert_eq!(place(&found, &wanted, reach, reach).holds(), slow.holds(), "{by}");
        }
    }

    #[test]
    fn a_vertex_out_of_proportion_does_not_excuse_what_it_misses() {
        let mut points = line(1.0).points().to_vec();
        points[3].y = 1e14;
        let curve = Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap();
        let look = |by: f64, reach: f64| {
            let target = [3.0, 1e14 + by, 0.0];
            let asked = |axis| axis == 1;
            measure(&Shapes::one(&curve), &vertex(3), Sense::Equal, &target, &asked, reach).unwrap()
        };
        // Where 1e14 went in, one unit is rounding; where it came out of 5 by itself, its target says the rest.
        assert!(look(0.25, 1e14).holds());
        let target_alone = ROUNDING * 1e14;
        assert!(look(0.25, 5.0).worst.allowed < target_alone + 2.0 * ROUNDING * PROPORTION * 5.0);
    }

    #[test]
    fn inequalities_miss_on_one_side_only_and_nan_is_worst() {
        assert_eq!((error_of(Sense::AtLeast, 2.0), error_of(Sense::AtLeast, -2.0)), (2.0, 0.0));
        assert_eq!((error_of(Sense::AtMost, 2.0), error_of(Sense::AtMost, -2.0)), (0.0, 2.0));
        for sense in [Sense::Equal, Sense::AtLeast, Sense::AtMost] {
            assert!(error_of(sense, f64::NAN).is_nan());
        }
        let fine = Error { error: 1e-16, allowed: 1e-14 };
        let nan = Error { error: f64::NAN, allowed: 1e-14 };
        assert!(fine.or_worse(nan).error.is_nan() && nan.or_worse(fine).error.is_nan());
        assert_eq!(Error::default().or_worse(fine), fine);
    }
}
