//! What a batch on a surface gives besides points.

use crate::{Point, Vector};

/// Point, first derivatives and unit normal of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The point.
    pub point: Point,
    /// The derivative by `u`.
    pub du: Vector,
    /// The derivative by `v`.
    pub dv: Vector,
    /// `du × dv` made a unit vector; zero where they are parallel or vanish (a pole, for one).
    pub normal: Vector,
}

/// Point and unit normal of a surface: half of a [`Sample`], at less than half the cost where memory is what bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedPoint {
    /// The point.
    pub point: Point,
    /// `du × dv` made a unit vector; zero where they are parallel or vanish (a pole, for one).
    pub normal: Vector,
}

const ORIGIN: Point = Point::new(0.0, 0.0, 0.0);
const ZERO: Vector = Vector::new(0.0, 0.0, 0.0);

impl Sample {
    /// A sample of zeros, to make room with.
    pub const ZERO: Self = Self { point: ORIGIN, du: ZERO, dv: ZERO, normal: ZERO };
}

impl OrientedPoint {
    /// Zeros, to make room with.
    pub const ZERO: Self = Self { point: ORIGIN, normal: ZERO };
}

/// What is made of the homogeneous point and its derivatives by `u` and `v` (`RATIONAL`: the last lane is their weight).
pub(super) trait Outcome: Send {
    /// Whether the derivatives are looked at.
    const SLOPES: bool;

    /// The outcome at one place.
    fn of<const RATIONAL: bool>(jet: &[[f64; 4]; 3]) -> Self;
}

impl Outcome for Point {
    const SLOPES: bool = false;

    #[inline(always)]
    fn of<const RATIONAL: bool>([[x, y, z, w], ..]: &[[f64; 4]; 3]) -> Self {
        if RATIONAL { Self::new(x / w, y / w, z / w) } else { Self::new(*x, *y, *z) }
    }
}

impl Outcome for OrientedPoint {
    const SLOPES: bool = true;

    #[inline(always)]
    fn of<const RATIONAL: bool>([a, au, av]: &[[f64; 4]; 3]) -> Self {
        let (mut point, mut du, mut dv) = (xyz(a), xyz(au), xyz(av));
        if RATIONAL {
            // The weight of a derivative's length is no matter of its direction.
            point *= 1.0 / a[3];
            (du, dv) = (du - point * au[3], dv - point * av[3]);
        }
        Self { point: point.into(), normal: direction(&du, &dv) }
    }
}

impl Outcome for Sample {
    const SLOPES: bool = true;

    #[inline(always)]
    fn of<const RATIONAL: bool>([a, au, av]: &[[f64; 4]; 3]) -> Self {
        let (mut point, mut du, mut dv) = (xyz(a), xyz(au), xyz(av));
        if RATIONAL {
            let over = 1.0 / a[3];
            point *= over;
            (du, dv) = ((du - point * au[3]) * over, (dv - point * av[3]) * over);
        }
        Self { point: point.into(), du, dv, normal: direction(&du, &dv) }
    }
}

#[inline(always)]
fn xyz(lanes: &[f64; 4]) -> Vector {
    Vector::new(lanes[0], lanes[1], lanes[2])
}

/// The direction of `a × b`, or zero. What is neither tiny, huge nor nearly parallel needs no care.
#[inline(always)]
fn direction(a: &Vector, b: &Vector) -> Vector {
    let cross = a.cross(b);
    let (squared, bound) = (cross.norm_squared(), a.norm_squared() * b.norm_squared());
    if squared > 1e-20 * bound && squared > 1e-280 && bound < 1e280 {
        return cross * (1.0 / squared.sqrt());
    }
    unit_cross(a, b).unwrap_or_default()
}

/// The direction of `a × b`, unless the two are parallel to rounding or one vanishes. Lengths are divided out first:
/// the product of two tiny (or huge) vectors would leave the range of numbers.
pub(crate) fn unit_cross(a: &Vector, b: &Vector) -> Option<Vector> {
    let (la, lb) = (a.amax(), b.amax());
    if !(la > 0.0 && lb > 0.0 && la.is_finite() && lb.is_finite()) {
        return None;
    }
    let cross = (a / la).cross(&(b / lb));
    let length = cross.norm();
    (length > 1e-14).then(|| cross / length)
}
