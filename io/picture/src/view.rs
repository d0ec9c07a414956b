//! From where a scene is seen.

use loftsman_kernel::scene::Up;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix3;

use crate::error::PictureError;

/// From where a scene is seen. "Up" is the scene's up axis. All but [`Perspective`](Self::Perspective) are parallel
/// projections with one scale.
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
    /// From the front, a little right and above, by an eye at a distance: what is near is larger. There is no one
    /// scale, so no scale bar.
    Perspective,
    /// From a direction, given as the vector from the scene towards the viewer.
    From(Vector),
}

/// The distance of the eye of a perspective view from the middle of the scene, in units of the stage; the corners of
/// its box are at most √3 away.
const EYE: f64 = 5.0;

/// From the stage to the picture's plane: a parallel or a central projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lens {
    /// The distance of the eye, on the axis towards the viewer; `None` where it is infinite.
    eye: Option<f64>,
}

impl Lens {
    /// Parallel rays.
    pub(crate) const PARALLEL: Self = Self { eye: None };

    /// Across, up, and depth towards the viewer. Lines stay lines and planes planes, also in the depth: with an eye
    /// at `e` the map is `e (x, y, z) / (e - z)`.
    pub(crate) fn flat(self, p: &Vector) -> Vector {
        match self.eye {
            None => *p,
            Some(eye) => p * (eye / (eye - p.z).max(1e-3)),
        }
    }

    /// The derivative of [`flat`](Self::flat) at `p` along `v`.
    pub(crate) fn shift(self, p: &Vector, v: &Vector) -> Vector {
        match self.eye {
            None => *v,
            Some(eye) => {
                let left = (eye - p.z).max(1e-3);
                (v + p * (v.z / left)) * (eye / left)
            }
        }
    }

    /// The direction from a point of the stage towards the viewer, of any length.
    pub(crate) fn toward(self, p: &Vector) -> Vector {
        match self.eye {
            None => Vector::z(),
            Some(eye) => Vector::z() * eye - p,
        }
    }

    /// Whether lengths in the picture's plane have one scale.
    pub(crate) fn is_parallel(self) -> bool {
        self.eye.is_none()
    }
}

/// An orthonormal frame: right and up on the page, and towards the viewer; right × up = toward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) right: Vector,
    pub(crate) up: Vector,
    pub(crate) toward: Vector,
    pub(crate) lens: Lens,
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
        Self { right: up.cross(&toward), up, toward, lens: Lens::PARALLEL }
    }
}

/// The front view: x right, z up in a z-up scene, and the same turned for the other axes.
fn front(up: Up) -> Frame {
    let turn = Up::Z.turn(up);
    let (right, up, toward) = (turn * Vector::x(), turn * Vector::z(), turn * -Vector::y());
    Frame { right, up, toward, lens: Lens::PARALLEL }
}

impl View {
    /// From where it is, in words; `None` where that is as it comes.
    pub(crate) fn words(self) -> Option<&'static str> {
        match self {
            Self::Front => Some("from the front"),
            Self::Top => Some("from above"),
            Self::Right => Some("from the right"),
            Self::Isometric => Some("isometric"),
            Self::Perspective => Some("in perspective"),
            Self::From(_) | Self::Automatic => None,
        }
    }

    /// The frame of the view for a scene with this up axis and these points (any size: they are near 1 here).
    pub(crate) fn frame(self, up: Up, points: &[Point]) -> Result<Frame, PictureError> {
        let front = front(up);
        Ok(match self {
            Self::Front => front,
            Self::Top => Frame { up: -front.toward, toward: front.up, ..front },
            Self::Right => Frame { right: -front.toward, toward: front.right, ..front },
            Self::Isometric => isometric(front),
            Self::Perspective => {
                let toward = front.toward + front.right * 0.6 + front.up * 0.55;
                Frame { lens: Lens { eye: Some(EYE) }, ..Frame::looking(toward, front.up, front.right) }
            }
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
            let named = [View::Front, View::Top, View::Right, View::Isometric, View::Perspective];
            for view in named.into_iter().chain([View::From(Vector::z()), odd]) {
                let f = view.frame(up, &[]).unwrap();
                assert!((f.right.cross(&f.up) - f.toward).norm() < 1e-14, "{view:?} {up:?}");
                assert!((f.up.norm() - 1.0).abs() < 1e-14 && f.right.dot(&f.up).abs() < 1e-14);
            }
        }
        assert!(View::From(Vector::zeros()).frame(Up::Z, &[]).is_err());
    }

    #[test]
    fn an_eye_keeps_lines_straight_and_its_derivative_is_right() {
        let lens = Lens { eye: Some(EYE) };
        let (a, b) = (Vector::new(0.3, -0.5, 1.0), Vector::new(-1.0, 0.8, -0.7));
        let [p, q, r] = [a, b, a * 0.3 + b * 0.7].map(|p| lens.flat(&p));
        assert!((q - p).cross(&(r - p)).norm() < 1e-14);
        let (h, v) = (1e-6, Vector::new(0.2, 0.4, -0.9));
        let numeric = (lens.flat(&(a + v * h)) - lens.flat(&(a - v * h))) / (2.0 * h);
        assert!((numeric - lens.shift(&a, &v)).norm() < 1e-9);
        assert_eq!(Lens::PARALLEL.flat(&a), a);
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
