//! The plane of a curve, and which of its sides is which.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix3, SymmetricEigen};

use super::OffsetOptions;
use crate::sense::signed_area;

/// What leaves the plane by less than this part of the size lies in it.
const FLAT: f64 = 1e-9;

/// A plane with a curve in it.
pub(super) struct Plane {
    /// Of length 1; a closed curve runs counterclockwise about it.
    pub(super) normal: Vector,
    /// The largest distance of a control vertex from their middle.
    pub(super) size: f64,
    /// Whether the curve ends where it starts.
    pub(super) closed: bool,
    /// The direction of a curve that is straight.
    pub(super) along: Option<Vector>,
    /// The direction in which control vertices vary most, from the first to the last of them that way.
    line: Option<Vector>,
    /// A point of it.
    middle: Vector,
    /// How far control vertices are from it at most.
    leaves: f64,
}

impl Plane {
    /// The plane in which all control vertices lie, to an `allowance` by their size: across the direction in which they vary least.
    pub(super) fn of(curve: &Curve, options: &OffsetOptions, allowance: &dyn Fn(f64) -> f64) -> Result<Self> {
        let points = curve.points();
        let largest = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if largest > 1e150 {
            return Err(Error::Invalid(
                "the curve is too large for its squares to be numbers: scale it down".into(),
            ));
        }
        let middle = points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64;
        let size = points.iter().map(|p| (p.coords - middle).norm()).fold(0.0, f64::max);
        if size <= 1e-14 * largest || size == 0.0 {
            return Err(Error::NoExtent("the curve is a point, which has no side to move to".into()));
        }
        let mut spread = Matrix3::zeros();
        for p in points {
            let d = (p.coords - middle) / size;
            spread += d * d.transpose();
        }
        let eigen = SymmetricEigen::new(spread);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let along: Vector = eigen.eigenvectors.column(order[2]).into();
        let wanted = options.normal.map(unit).transpose()?;
        let off = |normal: &Vector| {
            points.iter().map(|p| (p.coords - middle).dot(normal).abs()).fold(0.0, f64::max)
        };
        let straight = points.iter().all(|p| (p.coords - middle).cross(&along).norm() <= FLAT * size);
        let mut normal = if straight {
            let normal = wanted.ok_or_else(|| {
                Error::Invalid(
                    "the curve is straight and lies in many planes: say which by normal = [x, y, z]".into(),
                )
            })?;
            let across = normal - along * along.dot(&normal);
            across.try_normalize(1e-6).ok_or_else(|| {
                Error::Invalid("the normal points along the line: give one across it".into())
            })?
        } else {
            let own: Vector = eigen.eigenvectors.column(order[0]).into();
            // In directions of little spread an eigenvector is known to the root of rounding: the cross product is better.
            let own = refined(points, &middle, &own);
            let leaves = off(&own);
            if leaves > allowance(size).max(FLAT * size) {
                return Err(Error::Invalid(format!(
                    "the curve leaves its plane by {}: only planar curves have offsets",
                    options.found(leaves)
                )));
            }
            match wanted {
                Some(normal) if normal.cross(&own).norm() > 1e-6 => {
                    return Err(Error::Invalid(format!(
                        "the normal is no normal of the curve's plane: that is [{}, {}, {}], leave it out",
                        crate::fields::figure(own.x),
                        crate::fields::figure(own.y),
                        crate::fields::figure(own.z)
                    )));
                }
                Some(normal) => own * own.dot(&normal).signum(),
                None => own * own[own.iamax()].signum(),
            }
        };
        let (a, b) = curve.domain();
        let closed = curve.is_periodic() || (curve.point(a)? - curve.point(b)?).norm() <= 1e-12 * size;
        if closed && !straight && signed_area(curve, &Point::from(middle), &normal)? < -1e-9 * size * size {
            normal = -normal;
        }
        // From end to end it is known better.
        let place = |p: &&Point| (p.coords - middle).dot(&along);
        let first = points.iter().min_by(|a, b| place(a).total_cmp(&place(b)));
        let last = points.iter().max_by(|a, b| place(a).total_cmp(&place(b)));
        let whole = first.zip(last).and_then(|(first, last)| (last - first).try_normalize(0.0));
        let along = whole.filter(|_| straight);
        Ok(Self { normal, size, closed, along, line: whole, middle, leaves: off(&normal) })
    }

    /// The curve in the plane, and how far its vertices were from that; `None` where it lies there to rounding.
    pub(super) fn flattened(&self, curve: &Curve) -> Result<Option<(Curve, f64)>> {
        if self.leaves <= FLAT * self.size {
            return Ok(None);
        }
        let (space, mut points, weights) = curve.clone().into_parts();
        for point in &mut points {
            *point -= self.normal * (point.coords - self.middle).dot(&self.normal);
        }
        Ok(Some((Curve::build(space, points, weights)?, self.leaves)))
    }

    /// The curve on the line through the middle of its vertices along which they vary most, and how far they were from that at most; `None` where it is straight already.
    pub(super) fn straightened(&self, curve: &Curve) -> Result<Option<(Curve, f64)>> {
        let (None, Some(line)) = (self.along, self.line) else { return Ok(None) };
        let (space, mut points, weights) = curve.clone().into_parts();
        let mut leaves = 0.0_f64;
        for point in &mut points {
            let arm = point.coords - self.middle;
            let across = arm - line * line.dot(&arm);
            leaves = leaves.max(across.norm());
            *point -= across;
        }
        Ok(Some((Curve::build(space, points, weights)?, leaves)))
    }
}

fn unit(vector: Vector) -> Result<Vector> {
    let largest = vector.amax();
    if largest > 0.0 && vector.iter().all(|x| x.is_finite()) {
        return Ok((vector / largest).normalize());
    }
    Err(Error::Invalid("the normal has no direction: give three finite numbers that are not all 0".into()))
}

/// The normal of the triangle of the middle and two vertices that is largest, on the side of one nearly right.
fn refined(points: &[Point], middle: &Vector, near: &Vector) -> Vector {
    let far = |from: &dyn Fn(&Vector) -> f64| {
        points.iter().map(|p| p.coords - middle).max_by(|a, b| from(a).total_cmp(&from(b))).unwrap_or(*near)
    };
    let first = far(&|d| d.norm());
    let second = far(&|d| d.cross(&first).norm());
    let normal = first.cross(&second);
    normal.try_normalize(0.0).map_or(*near, |n| if n.dot(near) < 0.0 { -n } else { n })
}
