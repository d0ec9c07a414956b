//! Matrices (124), points (116), directions (123).

use loftsman_kernel::brep::Frame;
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use super::entity::{At, Got, Problem, Reader, deeper};

impl Reader<'_, '_> {
    /// Where the directory places an entity: its matrix, in that one's own, and so on; none where it stays.
    pub(crate) fn placed(&self, place: usize) -> Got<Option<Matrix4<f64>>> {
        let mut map: Option<Matrix4<f64>> = None;
        let (mut at, mut depth) = (place, 0);
        loop {
            let number = self.file.entry(at).matrix;
            if number == 0 {
                return Ok(map);
            }
            depth = deeper(at, depth)?;
            let Some(next) = self.file.place(i64::from(number).abs()) else {
                let text = format!("its matrix is D{number}, which is not in the file");
                return Err(Problem::new(at, text));
            };
            let own = self.matrix(next)?;
            map = Some(map.map_or(own, |map| own * map));
            at = next;
        }
    }

    /// A matrix by itself.
    pub(crate) fn matrix(&self, place: usize) -> Got<Matrix4<f64>> {
        let entity = self.of(place, &[124], "a matrix (124)")?;
        let mut map = Matrix4::identity();
        for row in 0..3 {
            for column in 0..4 {
                map[(row, column)] = entity.real(1 + 4 * row + column)?;
            }
        }
        Ok(map)
    }

    /// A point in the coordinates of who names it.
    pub(crate) fn point(&self, place: usize) -> Got<Point> {
        let entity = self.of(place, &[116], "a point (116)")?;
        let point = Point::from(entity.triple(1)?);
        finite(self.placed(place)?.map_or(point, |map| transform_point(&map, &point)), place)
    }

    /// A direction.
    pub(crate) fn direction(&self, place: usize) -> Got<Vector> {
        let entity = self.of(place, &[123], "a direction (123)")?;
        let direction = Vector::from(entity.triple(1)?);
        let turned = self.placed(place)?.map_or(direction, |map| linear(&map, &direction));
        if turned.amax() > 0.0 && turned.amax().is_finite() {
            return Ok(turned);
        }
        Err(Problem::new(place, "its direction has no length: give one that is not zero"))
    }
}

/// A vector under a map.
pub(crate) fn linear(map: &Matrix4<f64>, v: &Vector) -> Vector {
    map.fixed_view::<3, 3>(0, 0) * v
}

/// A point whose coordinates can be computed with.
pub(crate) fn finite(point: Point, place: usize) -> Got<Point> {
    if point.iter().all(|c| c.is_finite()) {
        return Ok(point);
    }
    Err(Problem::new(place, "a coordinate overflows"))
}

/// A frame under a map; none where that does not keep angles and lengths.
pub(crate) fn moved_frame(frame: &Frame, map: &Matrix4<f64>) -> Option<Frame> {
    let (x, y, z) = (linear(map, &frame.x), linear(map, &frame.y()), linear(map, &frame.z));
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9;
    let units = [x, y, z].iter().all(|axis| near(axis.norm_squared(), 1.0));
    let square = near(x.dot(&y), 0.0) && near(y.dot(&z), 0.0) && near(z.dot(&x), 0.0);
    // A mirror turns `y` round: the same circle or cylinder, seen from behind.
    let z = if x.cross(&y).dot(&z) < 0.0 { -z } else { z };
    if units && square { Frame::new(transform_point(map, &frame.origin), z, x) } else { None }
}

/// A curve under a map.
pub(crate) fn moved_curve(curve: Curve, map: &Matrix4<f64>, place: usize) -> Got<Curve> {
    let (space, points, weights) = curve.into_parts();
    Curve::build(space, points.iter().map(|p| transform_point(map, p)).collect(), weights).at(place)
}

/// A surface under a map.
pub(crate) fn moved_surface(surface: Surface, map: &Matrix4<f64>, place: usize) -> Got<Surface> {
    let (u, v, points, weights) = surface.into_parts();
    Surface::build(u, v, points.iter().map(|p| transform_point(map, p)).collect(), weights).at(place)
}

/// A point under an affine map.
pub(crate) fn transform_point(map: &Matrix4<f64>, p: &Point) -> Point {
    let row = |i: usize| map[(i, 0)] * p.x + map[(i, 1)] * p.y + map[(i, 2)] * p.z + map[(i, 3)];
    Point::new(row(0), row(1), row(2))
}
