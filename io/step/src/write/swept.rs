//! Curves that are extruded or turned: surfaces as what they are.

use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::spline::{Curve, Direction, Surface};
use loftsman_kernel::{Point, Result, Vector};

use super::print::{Printer, real};

/// How far directions that are to be one may be apart, and points from the curve that they are to be on, as parts of their size.
const NEAR: f64 = 1e-9;

/// A curve that is swept: as which entity, and whether that runs along the spline.
struct Profile {
    number: u64,
    along: bool,
}

/// Places at which a surface is looked at, as shares of its domain.
const PLACES: [(f64, f64); 3] = [(0.37, 0.41), (0.61, 0.53), (0.13, 0.29)];

impl Printer {
    /// A swept surface as what it is, and whether its normal in the file is that of the spline; `None` where it is not what its form says.
    pub(super) fn swept(&mut self, surface: &Surface, form: &SurfaceForm) -> Result<Option<(u64, bool)>> {
        match form {
            SurfaceForm::Extrusion { along, profile } => self.extrusion(surface, *along, profile),
            SurfaceForm::Revolution { frame, profile } => self.revolution(surface, frame, profile),
            _ => Ok(None),
        }
    }

    fn extrusion(
        &mut self,
        surface: &Surface,
        along: Vector,
        form: &CurveForm,
    ) -> Result<Option<(u64, bool)>> {
        let length = along.norm();
        let Some(upwards) = runs_with(surface, Direction::V, |_| along)? else { return Ok(None) };
        if !(1e-150..1e150).contains(&length) {
            return Ok(None);
        }
        // The curve where `v` is 0, which need not be in the domain.
        let start = surface.v().domain().0;
        let (space, points, weights) = surface.isocurve(Direction::V, start)?.into_parts();
        let back = along * if upwards { start } else { 0.0 };
        let base = Curve::build(space, points.iter().map(|p| p - back).collect(), weights)?;
        let Some(profile) = self.profile(&base, form, Some(along))? else { return Ok(None) };
        let direction = self.direction(&along);
        let vector = self.put(&format!("VECTOR('',#{direction},{})", real(length)));
        let number = self.put(&format!("SURFACE_OF_LINEAR_EXTRUSION('',#{},#{vector})", profile.number));
        Ok(Some((number, profile.along == upwards)))
    }

    fn revolution(
        &mut self,
        surface: &Surface,
        frame: &Frame,
        form: &CurveForm,
    ) -> Result<Option<(u64, bool)>> {
        let around = |p: Point| frame.z.cross(&(p - frame.origin));
        let Some(turns) = runs_with(surface, Direction::U, around)? else { return Ok(None) };
        let base = surface.isocurve(Direction::U, surface.u().domain().0)?;
        let Some(profile) = self.profile(&base, form, None)? else { return Ok(None) };
        let (origin, axis) = (self.point(&frame.origin), self.direction(&frame.z));
        let placement = self.put(&format!("AXIS1_PLACEMENT('',#{origin},#{axis})"));
        let number = self.put(&format!("SURFACE_OF_REVOLUTION('',#{},#{placement})", profile.number));
        Ok(Some((number, profile.along == turns)))
    }

    /// A curve as what it is: a conic with ends, unless it closes. Of one that is extruded the conic may be anywhere `along` the vector.
    fn profile(&mut self, base: &Curve, form: &CurveForm, along: Option<Vector>) -> Result<Option<Profile>> {
        let conic = match form {
            CurveForm::Circle { frame, radius } => {
                Some(Conic { frame, radii: [*radius; 2], kind: Kind::Round })
            }
            CurveForm::Ellipse { frame, radii } => Some(Conic { frame, radii: *radii, kind: Kind::Round }),
            CurveForm::Parabola { frame, focal } => {
                Some(Conic { frame, radii: [*focal, 2.0 * focal], kind: Kind::Parabola })
            }
            CurveForm::Hyperbola { frame, radii } => {
                Some(Conic { frame, radii: *radii, kind: Kind::Hyperbola })
            }
            CurveForm::Line | CurveForm::Spline => None,
        };
        let Some(conic) = conic else {
            let plain = base.clamped()?;
            return Ok(Some(Profile { number: self.curve(plain.as_ref()), along: true }));
        };
        let (start, end) = base.domain();
        let middle = 0.5 * (start + end);
        let mut ends = [0.0; 3];
        for (t, end) in [start, middle, end].into_iter().zip(&mut ends) {
            let Some(found) = conic.parameter(base.point(t)?, along) else { return Ok(None) };
            *end = found;
        }
        let [a, mid, b] = ends;
        let slope = base.derivative(middle, 1)?;
        let runs = conic.tangent(mid).dot(&slope) > 0.0;
        let (placement, [x, y]) = (self.frame(conic.frame), conic.radii);
        let number = self.put(&match form {
            CurveForm::Circle { radius, .. } => format!("CIRCLE('',#{placement},{})", real(*radius)),
            CurveForm::Ellipse { .. } => format!("ELLIPSE('',#{placement},{},{})", real(x), real(y)),
            CurveForm::Parabola { focal, .. } => format!("PARABOLA('',#{placement},{})", real(*focal)),
            _ => format!("HYPERBOLA('',#{placement},{},{})", real(x), real(y)),
        });
        let (first, last) = (base.point(start)?, base.point(end)?);
        let size = base.points().iter().map(|p| (p - first).amax()).fold(0.0, f64::max);
        if conic.kind == Kind::Round && (last - first).amax() <= NEAR * size {
            return Ok(Some(Profile { number, along: runs }));
        }
        // An extruded parabola has no ends but those of its faces.
        if along.is_some() && conic.kind != Kind::Round {
            return Ok(Some(Profile { number, along: runs }));
        }
        let number =
            self.part(number, [first, last], [a, b], runs, matches!(form, CurveForm::Parabola { .. }));
        // With its sense the trimmed curve runs as the spline does.
        Ok(Some(Profile { number, along: true }))
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Round,
    Parabola,
    Hyperbola,
}

/// A conic by its parameter: of a parabola `radii` are by what `t²` and `t` are multiplied.
struct Conic<'f> {
    frame: &'f Frame,
    radii: [f64; 2],
    kind: Kind,
}

impl Conic<'_> {
    fn both(&self, t: f64) -> [f64; 2] {
        match self.kind {
            Kind::Round => [t.cos(), t.sin()],
            Kind::Parabola => [t * t, t],
            Kind::Hyperbola => [t.cosh(), t.sinh()],
        }
    }

    fn point(&self, t: f64) -> Point {
        let [x, y] = self.both(t);
        self.frame.origin + self.frame.x * (self.radii[0] * x) + self.frame.y() * (self.radii[1] * y)
    }

    fn tangent(&self, t: f64) -> Vector {
        let [x, y] = match self.kind {
            Kind::Round => [-t.sin(), t.cos()],
            Kind::Parabola => [2.0 * t, 1.0],
            Kind::Hyperbola => [t.sinh(), t.cosh()],
        };
        self.frame.x * (self.radii[0] * x) + self.frame.y() * (self.radii[1] * y)
    }

    /// Where on it a point is, brought to its plane along a vector; `None` where it is not on it.
    fn parameter(&self, p: Point, along: Option<Vector>) -> Option<f64> {
        let frame = self.frame;
        let height = (p - frame.origin).dot(&frame.z);
        let p = match along {
            Some(along) => p - along * (height / along.dot(&frame.z)),
            None => p,
        };
        let d = p - frame.origin;
        let (x, y) = (d.dot(&frame.x) / self.radii[0], d.dot(&frame.y()) / self.radii[1]);
        let t = match self.kind {
            Kind::Round => y.atan2(x),
            Kind::Parabola => y,
            Kind::Hyperbola => y.asinh(),
        };
        let off = (self.point(t) - p).norm();
        (off <= NEAR * (d.norm() + self.radii[0] + self.radii[1])).then_some(t)
    }
}

/// Whether a surface runs in a direction as a field of vectors points, or against it; `None` where it does neither everywhere that was looked.
fn runs_with(
    surface: &Surface,
    direction: Direction,
    field: impl Fn(Point) -> Vector,
) -> Result<Option<bool>> {
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let order = match direction {
        Direction::U => (1, 0),
        Direction::V => (0, 1),
    };
    let mut found = None;
    for (s, t) in PLACES {
        let (u, v) = (a + s * (b - a), c + t * (d - c));
        let own = surface.derivative(u, v, order.0, order.1)?;
        let vector = field(surface.point(u, v)?);
        let (Some(own), Some(vector)) = (own.try_normalize(0.0), vector.try_normalize(0.0)) else {
            return Ok(None);
        };
        let with = own.dot(&vector) > 0.0;
        if own.cross(&vector).norm() > NEAR || found.is_some_and(|known| known != with) {
            return Ok(None);
        }
        found = Some(with);
    }
    Ok(found)
}
