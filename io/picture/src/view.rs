//! From where a scene is seen.

use loftsman_kernel::scene::Up;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix3;

use crate::error::PictureError;

/// From where a scene is seen; parallel projection, equal scale on all axes. "Up" is the scene's up axis.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// A planar scene square on, anything else isometrically. The default.
    #[default]
    Automatic,
    /// From the front: x right, z up (for z-up scenes).
    Front,
    /// From above: x right, y up (for z-up scenes).
    Top,
    /// From the right: y right, z up (for z-up scenes).
    Right,
    /// From the front, right and above alike.
    Isometric,
    /// From a direction, given as the vector from the scene towards the viewer.
    From(Vector),
}

/// An orthonormal frame: right and up on the page, and towards the viewer; right × up = toward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) right: Vector,
    pub(crate) up: Vector,
    pub(crate) toward: Vector,
}

impl Frame {
    /// A direction of the scene in page coordinates: right, up, towards the viewer.
    pub(crate) fn turn(&self, v: &Vector) -> Vector {
        Vector::new(self.right.dot(v), self.up.dot(v), self.toward.dot(v))
    }

    /// The frame that looks against `toward` with `up` upwards on the page; where both are parallel, `spare` is
    /// upwards instead.
    fn looking(toward: Vector, up: Vector, spare: Vector) -> Self {
        let toward = toward.normalize();
        let upright = |v: Vector| v - toward * toward.dot(&v);
        let mut upward = upright(up);
        if upward.norm() < 1e-6 {
            upward = upright(spare);
        }
        let up = upward.normalize();
        Self { right: up.cross(&toward), up, toward }
    }
}

/// The front view: x right, z up in a z-up scene, and the same turned for the other axes.
fn front(up: Up) -> Frame {
    let turn = Up::Z.turn(up);
    Frame { right: turn * Vector::x(), up: turn * Vector::z(), toward: turn * -Vector::y() }
}

impl View {
    /// The frame of the view for a scene with this up axis and these points (any size: they are near 1 here).
    pub(crate) fn frame(self, up: Up, points: &[Point]) -> Result<Frame, PictureError> {
        let front = front(up);
        Ok(match self {
            Self::Front => front,
            Self::Top => Frame { right: front.right, up: -front.toward, toward: front.up },
            Self::Right => Frame { right: -front.toward, up: front.up, toward: front.right },
            Self::Isometric => isometric(front),
            Self::From(direction) => {
                let size = direction.amax();
                if !(size > 0.0 && size.is_finite()) {
                    return Err(PictureError::Option {
                        what: "the viewing direction",
                        found: format!("[{}, {}, {}]", direction.x, direction.y, direction.z),
                        needed: "a finite vector that is not zero",
                    });
                }
                Frame::looking(direction / size, front.up, -front.toward)
            }
            Self::Automatic => match normal(points, front) {
                Some(normal) => Frame::looking(normal, front.up, -front.toward),
                None => isometric(front),
            },
        })
    }
}

fn isometric(front: Frame) -> Frame {
    Frame::looking(front.right + front.toward + front.up, front.up, front.right)
}

/// The normal of the plane that all points are in, turned to the side of the front or of above; of all normals
/// of a straight line the one that shows most like a common view. `None` where the points fill space.
fn normal(points: &[Point], front: Frame) -> Option<Vector> {
    let count = points.len() as f64;
    let mean = points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords / count);
    let covariance = points.iter().fold(Matrix3::zeros(), |sum, p| {
        let d = p.coords - mean;
        sum + d * d.transpose() / count
    });
    let largest = covariance.trace();
    // Squares of lengths: 1e-12 is a millionth of the size, far above rounding and far below a pixel.
    let flat = |n: &Vector| n.dot(&(covariance * n)) <= 1e-12 * largest;
    if let Some(view) = [front.up, front.toward, front.right].into_iter().find(flat) {
        return Some(view);
    }
    let eigen = covariance.symmetric_eigen();
    let n: Vector = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
    if !flat(&n) {
        return None;
    }
    let side = n.dot(&(front.up + front.toward * 0.9 + front.right * 0.8));
    Some(if side < 0.0 { -n } else { n })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        let odd = View::From(Vector::new(1e200, -3e199, 0.0));
        for up in [Up::X, Up::Y, Up::Z] {
            for view in [View::Front, View::Top, View::Right, View::Isometric, View::From(Vector::z()), odd] {
                let f = view.frame(up, &[]).unwrap();
                assert!((f.right.cross(&f.up) - f.toward).norm() < 1e-14, "{view:?} {up:?}");
                assert!((f.up.norm() - 1.0).abs() < 1e-14 && f.right.dot(&f.up).abs() < 1e-14);
            }
        }
        assert!(View::From(Vector::zeros()).frame(Up::Z, &[]).is_err());
    }

    #[test]
    fn planar_scenes_are_seen_square_on() {
        let corner = |u: f64, v: f64| Point::from(Vector::new(1.0, 1.0, 0.0) * u + Vector::z() * v);
        let slanted = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 2.0)];
        let f = View::Automatic.frame(Up::Z, &slanted).unwrap();
        assert!((f.up - Vector::z()).norm() < 1e-9 && f.toward.dot(&Vector::new(1.0, 1.0, 0.0)).abs() < 1e-9);
        let flat = [Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        let f = View::Automatic.frame(Up::Z, &flat).unwrap();
        assert_eq!((f.right, f.up), (Vector::x(), Vector::y()));
        let space = [flat[0], flat[1], flat[2], Point::new(0.0, 0.0, 1.0)];
        let isometric = View::Isometric.frame(Up::Z, &[]).unwrap();
        assert_eq!(View::Automatic.frame(Up::Z, &space).unwrap(), isometric);
    }
}
