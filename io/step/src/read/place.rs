//! Points, directions and placements, in the scene's unit.

use loftsman_kernel::brep::Frame;
use loftsman_kernel::{Point, Vector};

use super::entity::{Got, Problem, entity, real};
use crate::part21::{Entity, File};

/// Sizes whose squares are numbers.
const SQUARES: std::ops::RangeInclusive<f64> = 1e-150..=1e150;

/// How the numbers of a representation are meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Units {
    /// Its lengths to those of the scene.
    pub(crate) scale: f64,
    /// Its angles to radians.
    pub(crate) angle: f64,
    /// How exact it says it is, in the scene's unit; 0 where it says nothing.
    pub(crate) tolerance: f64,
}

impl Default for Units {
    fn default() -> Self {
        Self { scale: 1.0, angle: 1.0, tolerance: 0.0 }
    }
}

/// A file with the units of what is read of it.
#[derive(Clone, Copy)]
pub(crate) struct Space<'r, 'f> {
    pub(crate) file: &'r File<'f>,
    pub(crate) units: Units,
}

impl<'f> Space<'_, 'f> {
    pub(crate) fn entity(&self, number: u64) -> Got<Entity<'f>> {
        entity(self.file, number)
    }

    /// A length in the scene's unit.
    pub(crate) fn length(&self, number: f64) -> f64 {
        number * self.units.scale
    }

    /// The coordinates of a point or a direction.
    pub(crate) fn coordinates<const N: usize>(&self, number: u64, kind: &str) -> Got<[f64; N]> {
        let entity = self.entity(number)?;
        let args = entity.of(kind)?;
        let values = args.list(1)?;
        if values.len() != N {
            let found = values.len();
            return Err(Problem::new(number, format!("{found} coordinates where {N} are needed")));
        }
        let mut out = [0.0; N];
        for (out, value) in out.iter_mut().zip(values) {
            *out = real(value).ok_or_else(|| {
                Problem::new(number, format!("{} where a coordinate is needed", value.what()))
            })?;
        }
        Ok(out)
    }

    /// A point.
    pub(crate) fn point(&self, number: u64) -> Got<Point> {
        let p = self.coordinates::<3>(number, "CARTESIAN_POINT")?;
        let scaled = Point::from(p.map(|c| self.length(c)));
        if scaled.iter().all(|c| c.is_finite()) {
            return Ok(scaled);
        }
        Err(Problem::new(number, "a coordinate overflows in the unit of the scene"))
    }

    /// Points.
    pub(crate) fn points(&self, numbers: &[u64]) -> Got<Vec<Point>> {
        numbers.iter().map(|&number| self.point(number)).collect()
    }

    /// A direction, of any length whose square is a number.
    pub(crate) fn direction(&self, number: u64) -> Got<Vector> {
        let given = Vector::from(self.coordinates::<3>(number, "DIRECTION")?);
        let largest = given.amax();
        // Its length says nothing; squares of it must neither overflow nor vanish.
        Ok(if largest > 0.0 && !SQUARES.contains(&largest) { given / largest } else { given })
    }

    /// A vector: a direction of unit length times a length.
    pub(crate) fn vector(&self, number: u64) -> Got<Vector> {
        let entity = self.entity(number)?;
        let args = entity.of("VECTOR")?;
        let direction = self.direction(args.reference(1)?)?;
        let unit = direction.try_normalize(0.0).ok_or_else(|| no_direction(number))?;
        let vector = unit * self.length(args.real(2)?);
        if vector.iter().all(|c| c.is_finite()) && vector != Vector::zeros() {
            return Ok(vector);
        }
        Err(no_direction(number))
    }

    /// An AXIS2_PLACEMENT_3D: a place, its axis (`z` where none is given) and where `x` points.
    pub(crate) fn frame(&self, number: u64) -> Got<Frame> {
        let entity = self.entity(number)?;
        let args = entity.of("AXIS2_PLACEMENT_3D")?;
        let origin = self.point(args.reference(1)?)?;
        let direction = |index: usize, usual: Vector| match args.optional(index)? {
            Some(number) => self.direction(number),
            None => Ok(usual),
        };
        let z = direction(2, Vector::z())?;
        let x = direction(3, Vector::x())?;
        // Axes that are as they should be stay to the bit.
        let near = |a: f64, b: f64| (a - b).abs() <= 8.0 * f64::EPSILON;
        if near(z.norm_squared(), 1.0) && near(x.norm_squared(), 1.0) && near(x.dot(&z), 0.0) {
            return Ok(Frame { origin, x, z });
        }
        Frame::new(origin, z, x).ok_or_else(|| no_direction(number))
    }

    /// An AXIS1_PLACEMENT: a place and a unit direction.
    pub(crate) fn axis(&self, number: u64) -> Got<(Point, Vector)> {
        let entity = self.entity(number)?;
        let args = entity.of("AXIS1_PLACEMENT")?;
        let origin = self.point(args.reference(1)?)?;
        let direction = match args.optional(2)? {
            Some(number) => self.direction(number)?,
            None => Vector::z(),
        };
        Ok((origin, direction.try_normalize(0.0).ok_or_else(|| no_direction(number))?))
    }
}

fn no_direction(number: u64) -> Problem {
    Problem::new(number, "its direction has no length: give one that is not zero")
}
