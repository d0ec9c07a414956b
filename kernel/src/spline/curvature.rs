//! Differential geometry at a point: curvature, torsion and Frenet frame of curves; normal, fundamental forms and
//! curvatures of surfaces.

use super::batch::unit_cross;
use super::{Curve, Surface};
use crate::Vector;
use crate::error::Result;
use crate::shape::{Derivative, Location, Shape};

/// What a curve does at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CurveFrame {
    /// `C'` vanishes: there is no tangent to measure against.
    Singular,
    /// The curve is straight there (`C''` is parallel to `C'` or zero): no normal, curvature 0.
    Straight {
        /// The unit tangent.
        tangent: Vector,
    },
    /// The curve bends.
    Bent {
        /// The unit tangent `T`.
        tangent: Vector,
        /// The unit normal `N`, towards the centre of curvature.
        normal: Vector,
        /// `T × N`.
        binormal: Vector,
        /// `κ = |C' × C''| / |C'|³`, one over length.
        curvature: f64,
        /// `τ = det(C', C'', C''') / |C' × C''|²`, one over length.
        torsion: f64,
    },
}

impl CurveFrame {
    /// The curvature vector `κ N`; none where the curve is singular.
    pub fn curvature_vector(&self) -> Option<Vector> {
        match *self {
            Self::Singular => None,
            Self::Straight { .. } => Some(Vector::zeros()),
            Self::Bent { normal, curvature, .. } => Some(normal * curvature),
        }
    }
}

/// The first and second fundamental forms of a surface at a point and what follows from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceCurvature {
    /// The unit normal, along `S_u × S_v`.
    pub normal: Vector,
    /// `E = S_u·S_u`, `F = S_u·S_v`, `G = S_v·S_v`.
    pub first: [f64; 3],
    /// `L = S_uu·n`, `M = S_uv·n`, `N = S_vv·n`.
    pub second: [f64; 3],
    /// The principal curvatures, the larger first; positive where the surface bends towards the normal.
    pub principal: [f64; 2],
    /// Their product.
    pub gaussian: f64,
    /// Their mean.
    pub mean: f64,
}

/// One number of a [`SurfaceCurvature`].
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurvatureMeasure {
    /// Half the sum of the principal curvatures.
    Mean,
    /// Their product.
    Gaussian,
    /// The larger one.
    Maximum,
    /// The smaller one.
    Minimum,
}

impl CurvatureMeasure {
    /// All of them, by what recipes call them.
    pub const WORDS: [(&'static str, Self); 4] = [
        ("mean", Self::Mean),
        ("gaussian", Self::Gaussian),
        ("maximum", Self::Maximum),
        ("minimum", Self::Minimum),
    ];

    /// Its value at a point.
    pub fn of(self, at: &SurfaceCurvature) -> f64 {
        match self {
            Self::Mean => at.mean,
            Self::Gaussian => at.gaussian,
            Self::Maximum => at.principal[0],
            Self::Minimum => at.principal[1],
        }
    }

    /// Its value at a point of something of a size, as far as it is more than rounding: 0 where, on the same thing of size 1, it is less
    /// than `10⁻¹⁰` of the larger of the principal curvatures and 1 (for the Gaussian one, of the square of the principal ones, or `10⁻²⁰`). To be painted: what
    /// is left of rounding on a cylinder would fill the whole map.
    pub fn beyond_rounding(self, at: &SurfaceCurvature, size: f64) -> f64 {
        const FLAT: f64 = 1e-10;
        let most = at.principal.iter().fold(0.0, |most: f64, one| most.max((one * size).abs()));
        let (value, flat) = match self {
            Self::Gaussian => (at.gaussian * size * size, FLAT * (most * most).max(FLAT)),
            _ => (self.of(at) * size, FLAT * most.max(1.0)),
        };
        if value.abs() < flat { 0.0 } else { self.of(at) }
    }

    /// In a sentence: `mean curvature`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean curvature",
            Self::Gaussian => "Gaussian curvature",
            Self::Maximum => "larger principal curvature",
            Self::Minimum => "smaller principal curvature",
        }
    }

    /// By which power of a length it is divided: 2 of the Gaussian one, else 1.
    pub fn power(self) -> i32 {
        if self == Self::Gaussian { 2 } else { 1 }
    }
}

/// The normal of a surface at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// The surface is regular: `S_u × S_v` made a unit vector.
    Regular(Vector),
    /// `S_u × S_v` vanishes, and this is the limit of the normals of the points around, as at a pole where a whole
    /// edge is one point.
    Limit(Vector),
    /// There is no normal: the surface is a line or a point there.
    None,
}

impl Normal {
    /// The unit vector, regular or limit.
    pub fn vector(self) -> Option<Vector> {
        match self {
            Self::Regular(n) | Self::Limit(n) => Some(n),
            Self::None => None,
        }
    }
}

impl SurfaceCurvature {
    /// Of any shape of two parameters at a place on it: the same from first and second derivatives; `None` where it has no tangent plane
    /// (`S_u × S_v` vanishes: over its domain one is below 1e-10 of the other, or they are parallel to 1e-10, which is rounding) or the shape has no
    /// second derivatives. Cost: five rows of the shape.
    ///
    /// # Errors
    /// When the shape has no such place.
    pub fn of(shape: &dyn Shape, at: Location) -> Result<Option<Self>> {
        shape.stencil(at, Derivative::POSITION)?;
        let by = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].map(|(u, v)| Derivative { u, v });
        let mut jet = [Vector::zeros(); 5];
        for (value, by) in jet.iter_mut().zip(by) {
            let Ok(found) = shape.value(at, by) else { return Ok(None) };
            *value = found;
        }
        let domain = match at {
            Location::Face(face, ..) => shape.face_domain(face),
            _ => shape.domain(),
        };
        let length = |k: usize| domain.get(k).map_or(1.0, |side| side.end - side.start);
        if !are_independent(jet[0] * length(0), jet[1] * length(1)) {
            return Ok(None);
        }
        Ok(unit_cross(&jet[0], &jet[1]).map(|normal| Self::with_normal(normal, jet)))
    }

    /// From the unit normal and `S_u`, `S_v`, `S_uu`, `S_uv`, `S_vv`, the first two of which are independent.
    fn with_normal(normal: Vector, [su, sv, suu, suv, svv]: [Vector; 5]) -> Self {
        let first = [su.dot(&su), su.dot(&sv), sv.dot(&sv)];
        let second = [suu.dot(&normal), suv.dot(&normal), svv.dot(&normal)];
        // In an orthonormal basis of the tangent plane the shape operator is a symmetric matrix, whose eigenvalues
        // do not suffer from H² - K losing all its digits at umbilics. x = S_u/|S_u|, S_v = c x + s y.
        let (e, s) = (su.norm(), su.cross(&sv).norm() / su.norm());
        let c = su.dot(&sv) / e;
        let xx = second[0] / e / e;
        let xy = (second[1] / e - c * xx) / s;
        let yy = (second[2] / s - 2.0 * c * xy - c * c * xx / s) / s;
        let (mean, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let principal = [mean + radius, mean - radius];
        let gaussian = xx * yy - xy * xy;
        Self { normal, first, second, principal, gaussian, mean }
    }
}

/// One of two steps over the domain is so small a part of the other, or the sine between them is so small, that it is rounding.
const VANISHING: f64 = 1e-10;

/// Whether two steps span a plane.
fn are_independent(a: Vector, b: Vector) -> bool {
    let (one, other) = (a.norm(), b.norm());
    let sine = || (a / one).cross(&(b / other)).norm();
    one.min(other) > VANISHING * one.max(other) && sine() > VANISHING
}

impl Curve {
    /// Tangent, normal, binormal, curvature and torsion at `u`. `O(p²)`.
    ///
    /// Derivatives below 1e-12 of what the control vertices around could give count as zero: they are rounding.
    ///
    /// # Errors
    /// When `u` is outside the domain.
    pub fn frame(&self, u: f64) -> Result<CurveFrame> {
        let mut d = [Vector::zeros(); 4];
        self.derivatives_into(u, &mut d)?;
        let (scale, second_scale) = self.derivative_scales(u)?;
        let [_, first, second, third] = d;
        let speed = first.norm();
        if speed <= 1e-12 * scale {
            return Ok(CurveFrame::Singular);
        }
        let tangent = first / speed;
        // The part of C'' across the tangent, by parameter of unit speed: dividing before multiplying keeps tiny
        // and huge curves in range.
        let bend = second / speed;
        let across = bend - tangent * tangent.dot(&bend);
        let turn = across.norm();
        if turn <= 1e-12 * bend.norm() || turn <= 1e-13 * second_scale / speed {
            return Ok(CurveFrame::Straight { tangent });
        }
        let normal = across / turn;
        let binormal = tangent.cross(&normal);
        // det(C', C'', C''') / |C' × C''|² = (C'''·B) / (|C'| · |C''_across|), with C''_across = turn · speed.
        let torsion = third.dot(&binormal) / speed / turn / speed;
        Ok(CurveFrame::Bent { tangent, normal, binormal, curvature: turn / speed, torsion })
    }

    /// What `|C'|` and `|C''|` could be around `u`: `p` times the spread of the span's control vertices over the
    /// span's length, and `2p` times that over it again. What is far below is rounding.
    fn derivative_scales(&self, u: f64) -> Result<(f64, f64)> {
        let (space, p) = (self.space(), self.degree());
        let span = space.span(space.locate(u)?);
        let origin = self.points()[space.vertex(span - p)];
        let spread =
            (1..=p).map(|j| (self.points()[space.vertex(span - p + j)] - origin).norm()).fold(0.0, f64::max);
        let length = space.flat()[span + 1] - space.flat()[span];
        let first = p as f64 * spread / length;
        Ok((first, 2.0 * p as f64 * first / length))
    }
}

impl Surface {
    /// The unit normal at `(u, v)`; at a pole the limit of the normals around it, from second derivatives: near a
    /// place with `S_v = 0`, a step `du` inwards has `S_v ≈ S_uv du`, so the normal tends to `S_u × S_uv`.
    ///
    /// # Errors
    /// When a parameter is outside the domain.
    pub fn normal(&self, u: f64, v: f64) -> Result<Normal> {
        let mut jet = [Vector::zeros(); 4];
        self.derivatives_into(u, v, [1, 1], &mut jet)?;
        let [_, sv, su, mixed] = jet;
        Ok(self.normal_from((u, v), su, sv, mixed))
    }

    fn normal_from(&self, (u, v): (f64, f64), su: Vector, sv: Vector, mixed: Vector) -> Normal {
        let (lu, lv) = (self.u().length(), self.v().length());
        // Lengths of the steps over the whole domain: comparable numbers for both directions.
        let (a, b) = (su * lu, sv * lv);
        let large = a.amax().max(b.amax());
        let vanishes = |d: &Vector| d.amax() <= 1e-12 * large;
        if !vanishes(&a) && !vanishes(&b) {
            return unit_cross(&su, &sv).map_or(Normal::None, Normal::Regular);
        }
        // Inwards is forwards, except from the end of a domain.
        let inwards = |t: f64, (start, end): (f64, f64)| if t - start <= end - t { 1.0 } else { -1.0 };
        let limit = match (vanishes(&a), vanishes(&b)) {
            (false, true) => unit_cross(&su, &(mixed * inwards(u, self.u().domain()))),
            (true, false) => unit_cross(&(mixed * inwards(v, self.v().domain())), &sv),
            _ => None,
        };
        limit.map_or(Normal::None, Normal::Limit)
    }

    /// Fundamental forms and curvatures at `(u, v)`; `None` where the surface has no tangent plane of its own
    /// (`S_u × S_v` vanishes, to the same rounding as in [`SurfaceCurvature::of`]).
    ///
    /// # Errors
    /// When a parameter is outside the domain.
    pub fn curvature(&self, u: f64, v: f64) -> Result<Option<SurfaceCurvature>> {
        let mut jet = [Vector::zeros(); 9];
        self.derivatives_into(u, v, [2, 2], &mut jet)?;
        let [_, sv, svv, su, suv, _, suu, ..] = jet;
        let Normal::Regular(normal) = self.normal_from((u, v), su, sv, suv) else { return Ok(None) };
        if !are_independent(su * self.u().length(), sv * self.v().length()) {
            return Ok(None);
        }
        Ok(Some(SurfaceCurvature::with_normal(normal, [su, sv, suu, suv, svv])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::spline::Space;

    #[test]
    fn a_twisted_cubic_has_the_curvatures_of_the_book() {
        // (t, t², t³) as Bézier: κ = 2, τ = 3 at t = 0.
        for size in [1e-9, 1.0, 1e9] {
            let points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 1.0, 0.0), (3.0, 3.0, 3.0)]
                .map(|(x, y, z)| Point::from(Vector::new(x, y, z) * (size / 3.0)));
            let curve = Curve::bezier(points.to_vec()).unwrap();
            let CurveFrame::Bent { normal, binormal, curvature, torsion, .. } = curve.frame(0.0).unwrap()
            else {
                panic!("bent")
            };
            assert!((normal - Vector::y()).norm() < 1e-14 && (binormal - Vector::z()).norm() < 1e-14);
            assert!((curvature * size - 2.0).abs() < 1e-12 && (torsion * size - 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn straight_and_singular_places_are_told() {
        let line = Curve::bezier((0..4).map(|i| Point::new(f64::from(i), 2.0, 1.0)).collect()).unwrap();
        assert_eq!(line.frame(0.3).unwrap(), CurveFrame::Straight { tangent: Vector::x() });
        let cusp = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
        let cusp = Curve::bezier(cusp.map(|(x, y)| Point::new(x, y, 0.0)).to_vec()).unwrap();
        assert_eq!(cusp.frame(0.5).unwrap(), CurveFrame::Singular);
        let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap();
        assert_eq!(point.frame(0.5).unwrap(), CurveFrame::Singular);
    }

    /// An eighth of a sphere: rational biquadratic, the edge `v = 1` a pole.
    fn octant(radius: f64) -> Surface {
        let space = || Space::clamped(2, &[0.0, 1.0]).unwrap();
        let (w, mut points, mut weights) = (0.5_f64.sqrt(), Vec::new(), Vec::new());
        for ((x, y), a) in [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().zip([1.0, w, 1.0]) {
            for ((r, z), b) in [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].into_iter().zip([1.0, w, 1.0]) {
                points.push(Point::from(Vector::new(x * r, y * r, z) * radius));
                weights.push(a * b);
            }
        }
        Surface::rational(space(), space(), points, weights).unwrap()
    }

    /// Through the interface of shapes it is the same.
    #[test]
    fn a_shape_has_the_curvature_of_its_surface() {
        for radius in [1e-9, 1.0, 1e9] {
            let sphere = octant(radius);
            for (u, v) in [(0.0, 0.0), (0.3, 0.2), (0.9, 0.8)] {
                let one = sphere.curvature(u, v).unwrap().unwrap();
                let other = SurfaceCurvature::of(&sphere, Location::Surface(u, v)).unwrap().unwrap();
                assert!((one.mean - other.mean).abs() * radius < 1e-12, "{} {}", one.mean, other.mean);
                assert!((one.gaussian - other.gaussian).abs() * radius * radius < 1e-12);
            }
            assert!(SurfaceCurvature::of(&sphere, Location::Surface(0.5, 1.5)).is_err());
            assert_eq!(SurfaceCurvature::of(&sphere, Location::Surface(0.5, 1.0)).unwrap(), None);
        }
    }

    /// At a pole that is one to rounding only, and at a corner of 180 degrees, there is none; a strip of any proportions has its own.
    #[test]
    fn what_vanishes_to_rounding_gives_no_curvature() {
        let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
        let patch = |corners: [[f64; 3]; 4]| {
            Surface::new(line(), line(), corners.map(|[x, y, z]| Point::new(x, y, z)).to_vec()).unwrap()
        };
        let pole = patch([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1e-17, 1e-17], [1.0, 1.0, 0.0]]);
        let flat = patch([[0.0, 0.0, 0.0], [1.0, 1e-16, 0.0], [-1.0, 1e-16, 1e-17], [0.0, 1.0, 1.0]]);
        for surface in [pole, flat] {
            let at = Location::Surface(0.0, 0.0);
            assert_eq!(SurfaceCurvature::of(&surface, at).unwrap(), None);
            assert_eq!(surface.curvature(0.0, 0.0).unwrap(), None);
            let inside = SurfaceCurvature::of(&surface, Location::Surface(0.5, 0.5)).unwrap().unwrap();
            // Both lie in a plane.
            assert!(inside.gaussian.abs() < 1e-9, "{}", inside.gaussian);
        }
        let long = Space::clamped(1, &[0.0, 1e12]).unwrap();
        let net = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
        let net = net.into_iter().map(|[x, y, z]| Point::new(x, y, z)).collect();
        let strip = Surface::new(long, line(), net).unwrap();
        let found = SurfaceCurvature::of(&strip, Location::Surface(0.0, 0.0)).unwrap().unwrap();
        assert!((found.gaussian + 1.0).abs() < 1e-12, "{}", found.gaussian);
    }

    #[test]
    fn a_sphere_bends_alike_everywhere_and_has_a_normal_at_its_pole() {
        for radius in [1e-9, 1.0, 1e9] {
            let sphere = octant(radius);
            for (u, v) in [(0.0, 0.0), (0.3, 0.2), (0.9, 0.8)] {
                let found = sphere.curvature(u, v).unwrap().unwrap();
                let outwards = sphere.point(u, v).unwrap().coords / radius;
                assert!((found.normal - outwards).norm() < 1e-12);
                for k in found.principal {
                    assert!((k * radius + 1.0).abs() < 1e-11, "{k}");
                }
                assert!((found.gaussian * radius * radius - 1.0).abs() < 1e-11);
            }
            let Normal::Limit(pole) = sphere.normal(0.4, 1.0).unwrap() else { panic!("a pole") };
            assert!((pole - Vector::z()).norm() < 1e-12);
            assert!(sphere.curvature(0.4, 1.0).unwrap().is_none());
        }
    }
}
