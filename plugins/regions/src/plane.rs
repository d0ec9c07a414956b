//! The plane that outlines lie in.

use loftsman_kernel::{Point, Vector};

use crate::error::{RegionError, Result};

/// How far a point may be from the plane, as a share of the size of all: files print six digits or more.
const FLAT: f64 = 1e-6;

/// A plane with axes of its own, and a length that makes numbers in it about 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    origin: Point,
    x: Vector,
    y: Vector,
    normal: Vector,
    size: f64,
}

impl Plane {
    /// The plane of closed rings of points, its normal such that the ring of largest area runs counterclockwise.
    /// `rings` give each ring's name and the indices of its points. `O(points)`.
    ///
    /// The normal is that of the widest triangle with a corner at the largest ring's first point and one at the point
    /// farthest from it: it stands whatever the signs of areas add up to. The x axis follows the world's (or its y
    /// axis, where the plane faces that way), so that pictures and texture coordinates stay upright.
    ///
    /// # Errors
    /// When all points lie on a line, or one is off the plane by more than a millionth of the size.
    pub fn of(points: &[Point], rings: &[(&str, &[u32])]) -> Result<Self> {
        let at = |i: u32| points[i as usize];
        let first = rings.first().map_or("", |r| r.0).to_owned();
        let mut all = rings.iter().flat_map(|(_, ring)| ring.iter().map(|&i| at(i)));
        let Some(start) = all.next() else { return Err(RegionError::NoArea { object: first }) };
        let (low, high) = all.fold((start, start), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let size = (high - low).amax();
        let origin = low + (high - low) * 0.5;
        let local = |i: u32| (at(i) - origin) / size;
        // The ring whose points reach widest: an area of whatever sign cannot vanish there unless it has none.
        let mut widest = (0.0, Vector::zeros(), 0, start);
        for (r, (_, ring)) in rings.iter().enumerate() {
            let Some(&base) = ring.first() else { continue };
            let arm = |i: u32| local(i) - local(base);
            let far = ring.iter().copied().fold(base, |best, i| {
                if arm(i).norm_squared() > arm(best).norm_squared() { i } else { best }
            });
            for &i in *ring {
                let cross = arm(far).cross(&arm(i));
                if cross.norm_squared() > widest.0 {
                    widest = (cross.norm_squared(), cross, r, at(base));
                }
            }
        }
        let object = rings.get(widest.2).map_or("", |r| r.0).to_owned();
        // Thinner than rounding of the coordinates can tell from a line: no plane.
        let noise = 64.0 * f64::EPSILON * (1.0 + low.coords.amax().max(high.coords.amax()) / size);
        let Some(mut normal) = widest.1.try_normalize(noise) else {
            return Err(RegionError::NoArea { object: first });
        };
        let area = |ring: &[u32]| -> f64 {
            let wrap = ring.iter().copied().zip(ring.iter().copied().cycle().skip(1));
            wrap.map(|(a, b)| local(a).cross(&local(b)).dot(&normal)).sum()
        };
        let largest = rings
            .iter()
            .map(|(_, ring)| area(ring))
            .fold(0.0, |m: f64, a| if a.abs() > m.abs() { a } else { m });
        if largest < 0.0 {
            normal = -normal;
        }
        // The box's middle, brought into the plane.
        let origin = origin + normal * normal.dot(&(widest.3 - origin));
        let upright = if normal.x.abs() > 0.9 { Vector::y() } else { Vector::x() };
        let x = (upright - normal * normal.dot(&upright)).normalize();
        let plane = Self { origin, x, y: normal.cross(&x), normal, size };
        for (name, ring) in rings {
            let distance = ring.iter().map(|&i| (at(i) - origin).dot(&normal).abs()).fold(0.0, f64::max);
            if distance > FLAT * size + noise * size {
                return Err(RegionError::NotPlanar { object: (*name).to_owned(), distance });
            }
        }
        if !size.is_finite() {
            return Err(RegionError::NoArea { object });
        }
        Ok(plane)
    }

    /// Its unit normal.
    pub fn normal(&self) -> Vector {
        self.normal
    }

    /// The longest side of the box of all points: what one unit in the plane is.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Coordinates in the plane, in units of its [`size`](Self::size).
    pub fn flatten(&self, p: &Point) -> [f64; 2] {
        let arm = (p - self.origin) / self.size;
        [arm.dot(&self.x), arm.dot(&self.y)]
    }

    /// The point of such coordinates.
    pub fn lift(&self, [x, y]: [f64; 2]) -> Point {
        self.origin + (self.x * x + self.y * y) * self.size
    }
}
