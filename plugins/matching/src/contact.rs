//! Contact of two surfaces at one place: tangent planes and curvature across.

use loftsman_kernel::Vector;
use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::shape::{BoundaryEdge, Derivative, Location, Shape};

/// A tangent plane of which nothing is left but this part, of what its vectors' lengths allow, is none.
const FLAT: f64 = 1e-10;

/// What the surface that stands still is like at a place of its edge.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    /// Its unit normal.
    pub(crate) normal: Vector,
    /// Its first derivatives: along the edge, and across.
    tangents: [Vector; 2],
    /// The inverse of their Gram matrix: `[g₀₀, g₀₁, g₁₁]`.
    inverse: [f64; 3],
    /// Its second fundamental form for these: `n·S_ij`.
    form: [f64; 3],
    /// Outwards, square to the edge.
    outwards: Vector,
}

impl Frame {
    /// The surface at its edge's `u`.
    ///
    /// # Errors
    /// When it has no tangent plane there.
    pub(crate) fn new(shape: &dyn Shape, edge: &BoundaryEdge, u: f64) -> Result<Self> {
        let value = |derivative| shape.value(edge.at(u), derivative);
        let (x, y) = (value(edge.along(1))?, value(edge.across(1))?);
        let normal = x.cross(&y);
        let [xx, yy] = [x.norm(), y.norm()];
        // `NaN` is refused, too.
        if normal.norm().partial_cmp(&(FLAT * xx * yy)) != Some(std::cmp::Ordering::Greater) {
            let (name, u) = (&edge.name, Figure(u));
            return Err(Error::Invalid(format!(
                "the surface beside has no tangent plane at {u} of its edge {name} (a pole, or a corner of an edge): \
                 ask for continuity 0"
            )));
        }
        let normal = normal.normalize();
        let [second_x, second_y] = [value(edge.along(2))?, value(edge.across(2))?];
        let mixed = value(Derivative { u: 1, v: 1 })?;
        let (a, b, d) = (x.dot(&x), x.dot(&y), y.dot(&y));
        let determinant = a * d - b * b;
        let along = x / xx;
        let outwards = if edge.at_end { y } else { -y };
        Ok(Self {
            normal,
            tangents: [x, y],
            inverse: [d / determinant, -b / determinant, a / determinant],
            form: [normal.dot(&second_x), normal.dot(&mixed), normal.dot(&second_y)],
            outwards: outwards - along * along.dot(&outwards),
        })
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

    /// The largest of its curvatures across the edge, in the direction of `d`.
    pub(crate) fn curvature(&self, d: &Vector) -> f64 {
        let within = d - self.normal * self.normal.dot(d);
        self.second(d).0 / within.norm_squared()
    }

    /// The angle between the tangent planes of this surface and of one with these derivatives along its edge and inwards: 0
    /// where they are smooth, π where one lies folded back on the other. None where that one has no tangent plane.
    pub(crate) fn angle(&self, along: &Vector, inwards: &Vector) -> Option<f64> {
        let normal = along.cross(inwards);
        if normal.norm().partial_cmp(&(FLAT * along.norm() * inwards.norm()))
            != Some(std::cmp::Ordering::Greater)
        {
            return None;
        }
        let between = normal.cross(&self.normal).norm().atan2(normal.dot(&self.normal).abs());
        Some(if inwards.dot(&self.outwards) < 0.0 { std::f64::consts::PI - between } else { between })
    }
}

/// A place of the edge that moves, and what stands beside it there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contact {
    /// Where on the surface that moves.
    pub(crate) at: Location,
    /// Its derivatives across, of first and second order.
    pub(crate) across: [Derivative; 2],
    /// Its derivative along.
    pub(crate) along: Derivative,
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
    /// `n·S₁`, times the step.
    pub(crate) slope: f64,
    /// `n·S₂ - II(S₁)`, times the step squared.
    pub(crate) bend: f64,
    /// The angle between the surfaces.
    pub(crate) angle: Option<f64>,
    /// The difference of the curvatures across.
    pub(crate) curvature: f64,
    /// The curvature of the surface that stands still.
    pub(crate) beside: f64,
}

impl Contact {
    /// How the moving surface lies to the other one there.
    ///
    /// # Errors
    /// As for [`Shape::stencil`].
    pub(crate) fn measure(&self, shape: &dyn Shape) -> Result<Measured> {
        let [first, second] = [shape.value(self.at, self.across[0])?, shape.value(self.at, self.across[1])?];
        let along = shape.value(self.at, self.along)?;
        let frame = &self.frame;
        let slope = frame.normal.dot(&first);
        let bend = frame.normal.dot(&second) - frame.second(&first).0;
        let within = first - frame.normal * slope;
        Ok(Measured {
            slope: slope * self.step,
            bend: bend * self.step * self.step,
            angle: frame.angle(&along, &if self.at_end { -first } else { first }),
            curvature: bend / within.norm_squared(),
            beside: frame.curvature(&first),
        })
    }
}
