//! Contact of two surfaces at one place: tangent planes, and normal curvatures square to the edge.

use std::any::Any;

use loftsman_kernel::Vector;
use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::shape::{BoundaryEdge, Derivative, Location, Shape};
use loftsman_kernel::spline::Surface;

/// A tangent plane of which nothing is left but this part, of what its vectors' lengths allow, is none.
const FLAT: f64 = 1e-10;

/// Derivatives by the parameters along an edge and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Partials {
    along_u: bool,
}

impl Partials {
    pub(crate) fn new(edge: &BoundaryEdge) -> Self {
        Self { along_u: edge.along_u }
    }

    pub(crate) fn of(self, along: usize, across: usize) -> Derivative {
        let (u, v) = if self.along_u { (along, across) } else { (across, along) };
        Derivative { u, v }
    }
}

/// First and second derivatives of a surface at a place of its edge, `t` running along it and `s` across.
#[derive(Debug, Clone, Copy)]
struct Jet {
    /// `S_t`, `S_s`.
    first: [Vector; 2],
    /// `S_tt`, `S_ts`, `S_ss`.
    second: [Vector; 3],
}

impl Jet {
    /// # Errors
    /// As for [`Shape::stencil`].
    fn new(shape: &dyn Shape, at: Location, by: Partials) -> Result<Self> {
        let any: &dyn Any = shape;
        // A surface gives them all at once.
        if let (Some(surface), Location::Surface(u, v)) = (any.downcast_ref::<Surface>(), at) {
            let mut all = [Vector::zeros(); 9];
            surface.derivatives_into(u, v, [2, 2], &mut all)?;
            let value = |along, across| {
                let by = by.of(along, across);
                all[3 * by.u + by.v]
            };
            return Ok(Self {
                first: [value(1, 0), value(0, 1)],
                second: [value(2, 0), value(1, 1), value(0, 2)],
            });
        }
        let value = |along, across| shape.value(at, by.of(along, across));
        Ok(Self { first: [value(1, 0)?, value(0, 1)?], second: [value(2, 0)?, value(1, 1)?, value(0, 2)?] })
    }

    /// How much of the way along the edge is in the way across: `a` of `d = S_s - a S_t`, which is square to the edge; 0 where the
    /// edge stands still.
    fn skew(&self) -> f64 {
        let skew = self.first[0].dot(&self.first[1]) / self.first[0].norm_squared();
        if skew.is_finite() { skew } else { 0.0 }
    }

    /// `d = S_s - a S_t`.
    fn square(&self) -> Vector {
        self.first[1] - self.first[0] * self.skew()
    }

    /// The unit normal; none where there is no tangent plane.
    fn normal(&self) -> Option<Vector> {
        let [along, across] = &self.first;
        let normal = along.cross(across);
        // `NaN` is none, too.
        let enough = FLAT * along.norm() * across.norm();
        let is_one = normal.norm().partial_cmp(&enough) == Some(std::cmp::Ordering::Greater);
        is_one.then(|| normal.normalize())
    }

    /// The second fundamental form of a normal for `d`: `n·(S_ss - 2a S_ts + a² S_tt)`.
    fn bend(&self, normal: &Vector) -> f64 {
        let (a, [tt, ts, ss]) = (self.skew(), self.second.map(|second| normal.dot(&second)));
        ss - 2.0 * a * ts + a * a * tt
    }

    /// The normal curvature square to the edge.
    fn curvature(&self, normal: &Vector) -> f64 {
        self.bend(normal) / self.square().norm_squared()
    }

    /// The larger of the sizes of the principal curvatures.
    fn largest(&self, normal: &Vector) -> f64 {
        let ([x, y], [tt, ts, ss]) = (&self.first, self.second.map(|second| normal.dot(&second)));
        let (e, f, g) = (x.norm_squared(), x.dot(y), y.norm_squared());
        let determinant = e * g - f * f;
        let mean = (e * ss - 2.0 * f * ts + g * tt) / (2.0 * determinant);
        let gauss = (tt * ss - ts * ts) / determinant;
        mean.abs() + (mean * mean - gauss).max(0.0).sqrt()
    }
}

/// What the surface that stands still is like at a place of its edge.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    /// Its unit normal.
    pub(crate) normal: Vector,
    /// Its normal curvature square to the edge.
    pub(crate) curvature: f64,
    /// The largest of its normal curvatures in all directions, without sign.
    pub(crate) largest: f64,
    /// Outwards, square to the edge.
    outwards: Vector,
    /// Its first derivatives: along the edge, and across.
    tangents: [Vector; 2],
    /// The inverse of their Gram matrix: `[g₀₀, g₀₁, g₁₁]`.
    inverse: [f64; 3],
    /// Its second fundamental form for these.
    form: [f64; 3],
}

impl Frame {
    /// The surface at its edge's `u`.
    ///
    /// # Errors
    /// When it has no tangent plane there.
    pub(crate) fn new(shape: &dyn Shape, edge: &BoundaryEdge, u: f64) -> Result<Self> {
        let jet = Jet::new(shape, edge.at(u), Partials::new(edge))?;
        let Some(normal) = jet.normal() else {
            let (name, u) = (edge.called(), Figure(u));
            return Err(Error::Invalid(format!(
                "the surface beside has no tangent plane at {u} of its {name} (a pole, or a corner of an edge): \
                 ask for continuity 0"
            )));
        };
        let (curvature, largest) = (jet.curvature(&normal), jet.largest(&normal));
        let outwards = if edge.at_end { jet.square() } else { -jet.square() };
        let [x, y] = jet.first;
        let (a, b, d) = (x.dot(&x), x.dot(&y), y.dot(&y));
        let determinant = a * d - b * b;
        let inverse = [d / determinant, -b / determinant, a / determinant];
        let form = jet.second.map(|second| normal.dot(&second));
        Ok(Self { normal, curvature, largest, outwards, tangents: jet.first, inverse, form })
    }

    /// The second fundamental form of the part of `d` in the tangent plane, and half its gradient by `d`.
    pub(crate) fn second(&self, d: &Vector) -> (f64, Vector) {
        let times = |m: &[f64; 3], [p, q]: [f64; 2]| [m[0] * p + m[1] * q, m[1] * p + m[2] * q];
        let [x, y] = &self.tangents;
        let c = times(&self.inverse, [x.dot(d), y.dot(d)]);
        let form = times(&self.form, c);
        let [p, q] = times(&self.inverse, form);
        (c[0] * form[0] + c[1] * form[1], x * p + y * q)
    }

    /// The angle between the tangent planes of this surface and of one with this normal, whose inside lies in a direction: 0
    /// where they are smooth, π where one lies folded back on the other.
    fn angle(&self, normal: &Vector, inwards: &Vector) -> f64 {
        let between = normal.cross(&self.normal).norm().atan2(normal.dot(&self.normal).abs());
        if inwards.dot(&self.outwards) < 0.0 { std::f64::consts::PI - between } else { between }
    }
}

/// A place of the edge that moves, and what stands beside it there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contact {
    /// Where on the surface that moves.
    pub(crate) at: Location,
    /// Its derivatives.
    pub(crate) by: Partials,
    /// Whether its inside lies at smaller parameters.
    pub(crate) at_end: bool,
    /// A parameter step that makes derivatives lengths.
    pub(crate) step: f64,
    /// What stands beside.
    pub(crate) frame: Frame,
}

/// A contact measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    /// `n·S_s`, times the step.
    pub(crate) slope: f64,
    /// `n·S_ss - II(S_s, S_s)`, times the step squared.
    pub(crate) bend: f64,
    /// The angle between the surfaces; π where the surface that moves has no tangent plane.
    pub(crate) angle: f64,
    /// The difference of the normal curvatures square to the edge, each surface's own; infinite where one has none.
    pub(crate) curvature: f64,
}

impl Contact {
    /// How fast the moving surface leaves its edge, square to it: `|d|`.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn across(&self, shape: &dyn Shape) -> Result<f64> {
        Ok(Jet::new(shape, self.at, self.by)?.square().norm())
    }

    /// The direction, square to the edge, in which the derivative across points where the moving surface goes on from the other one, and the length of that one's own.
    pub(crate) fn lead(&self) -> (Vector, f64) {
        let speed = self.frame.outwards.norm();
        let direction = self.frame.outwards / speed;
        // Where the surface's inside lies at smaller parameters, its derivative points out of it.
        (if self.at_end { -direction } else { direction }, speed)
    }

    /// The same place beside another place of the surface that stands still.
    pub(crate) fn beside(&self, frame: Frame) -> Self {
        Self { frame, ..self.clone() }
    }

    /// How the moving surface lies to the other one there.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn measure(&self, shape: &dyn Shape) -> Result<Measured> {
        let (jet, frame) = (Jet::new(shape, self.at, self.by)?, &self.frame);
        let bend = frame.normal.dot(&jet.second[2]) - frame.second(&jet.first[1]).0;
        let (angle, curvature) = match jet.normal() {
            // Where a surface leaves the edge in no direction, it is nothing but wrong.
            None => (std::f64::consts::PI, f64::INFINITY),
            Some(own) => {
                let same_side = if own.dot(&frame.normal) < 0.0 { -own } else { own };
                let inwards = if self.at_end { -jet.first[1] } else { jet.first[1] };
                (frame.angle(&own, &inwards), jet.curvature(&same_side) - frame.curvature)
            }
        };
        Ok(Measured {
            slope: frame.normal.dot(&jet.first[1]) * self.step,
            bend: bend * self.step * self.step,
            angle,
            curvature,
        })
    }
}
