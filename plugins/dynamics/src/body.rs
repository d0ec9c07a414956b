//! What moves: a shape and what it is made of.

use loftsman_kernel::Point;
use loftsman_kernel::shape::{Interval, Shape};

use crate::error::{Result, check, check_damping, check_mass, check_rest};

/// What a rope or a sheet is made of. Units are those of the document for lengths, seconds, and any unit of mass: forces are in
/// mass · length / s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Mass a unit of length of a curve, a unit of area of a surface, as the shape is at the start.
    pub mass: f64,
    /// `EA`: the force that would stretch a curve to twice its length at rest; of a surface the same a unit of width at rest, in each direction.
    pub stiffness: f64,
    /// Of a surface: the force a unit of width at rest for a shear by an angle of 1.
    pub shear: f64,
    /// What its length at rest is of its length at the start, of a surface its width as well: it is stretched and bent as what was made so
    /// many times as large.
    pub rest: f64,
    /// `EI`: the moment for a curvature of 1; of a surface a unit of width at rest. The shape is straight by nature.
    pub bending: f64,
    /// How fast motion dies away, in 1/s: the air.
    pub damping: f64,
    /// The force that resists a rate of stretching of 1/s: friction within.
    pub viscosity: f64,
}

impl Default for Material {
    /// A mass of 1, a stiffness of 1000, half of it in shear; nothing else.
    fn default() -> Self {
        Self {
            mass: 1.0,
            stiffness: 1000.0,
            shear: 500.0,
            rest: 1.0,
            bending: 0.0,
            damping: 0.0,
            viscosity: 0.0,
        }
    }
}

impl Material {
    pub(crate) fn check(&self) -> Result<()> {
        check_mass("the mass", self.mass)?;
        check("the stiffness", self.stiffness, true)?;
        check("the shear stiffness", self.shear, true)?;
        check_rest(self.rest)?;
        check("the bending stiffness", self.bending, true)?;
        check_damping("the damping", self.damping)?;
        check("the viscosity", self.viscosity, true)?;
        Ok(())
    }
}

/// A shape that moves, or stands still for others to slide on.
#[derive(Debug, Clone)]
pub struct Body {
    pub(crate) name: String,
    pub(crate) shape: Box<dyn Shape>,
    pub(crate) material: Material,
    pub(crate) still: bool,
    pub(crate) velocities: Option<Vec<loftsman_kernel::Vector>>,
    /// Whether its ends are kept together, though its knots do not close it.
    pub(crate) closed: bool,
    /// How many conditions keep it together and smooth where its knots do not, each of which takes as much freedom as a control vertex has.
    pub(crate) kept: usize,
    /// Whether its stiffness follows from its weight, because none was given.
    pub(crate) by_weight: bool,
}

impl Body {
    /// A shape of the default [`Material`], at rest. What can be integrated over ([`Shape::cells`]) can move: curves, surfaces, Catmull–Rom
    /// curves, subdivision surfaces.
    pub fn new<S: Shape + Clone>(shape: &S) -> Self {
        Self {
            name: "shape".into(),
            shape: shape.clone().into_box(),
            material: Material::default(),
            still: false,
            velocities: None,
            closed: false,
            kept: 0,
            by_weight: false,
        }
    }

    /// What it is called in reports and messages.
    #[must_use]
    pub fn called(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// What it is made of.
    #[must_use]
    pub fn material(mut self, material: Material) -> Self {
        self.material = material;
        self
    }

    /// [`Material::mass`].
    #[must_use]
    pub fn mass(mut self, mass: f64) -> Self {
        self.material.mass = mass;
        self
    }

    /// [`Material::stiffness`], and half of it as [`Material::shear`].
    #[must_use]
    pub fn stiffness(mut self, stiffness: f64) -> Self {
        (self.material.stiffness, self.material.shear) = (stiffness, 0.5 * stiffness);
        self
    }

    /// [`Material::rest`].
    #[must_use]
    pub fn rest(mut self, rest: f64) -> Self {
        self.material.rest = rest;
        self
    }

    /// [`Material::bending`].
    #[must_use]
    pub fn bending(mut self, bending: f64) -> Self {
        self.material.bending = bending;
        self
    }

    /// [`Material::damping`].
    #[must_use]
    pub fn damping(mut self, damping: f64) -> Self {
        self.material.damping = damping;
        self
    }

    /// [`Material::viscosity`].
    #[must_use]
    pub fn viscosity(mut self, viscosity: f64) -> Self {
        self.material.viscosity = viscosity;
        self
    }

    /// Its stiffness is such as to carry its weight, because none was given.
    #[must_use]
    pub(crate) fn stiff_by_weight(mut self, by_weight: bool) -> Self {
        self.by_weight = by_weight;
        self
    }

    /// It stands still: a wire or a wall for others to slide on.
    #[must_use]
    pub fn still(mut self) -> Self {
        self.still = true;
        self
    }

    /// The velocities of its control vertices at the start.
    #[must_use]
    pub fn moving(mut self, velocities: Vec<loftsman_kernel::Vector>) -> Self {
        self.velocities = Some(velocities);
        self
    }

    /// Where a parameter may be: round and round where the shape is closed, by its knots or because its ends are kept together.
    pub(crate) fn interval(&self, axis: usize) -> Option<Interval> {
        let own = self.shape.domain().get(axis).copied()?;
        Some(Interval { periodic: own.periodic || self.closed, ..own })
    }

    /// The largest extent of its control vertices along an axis.
    pub(crate) fn size(&self) -> f64 {
        extent(self.shape.control_vertices())
    }
}

/// The largest extent along an axis.
pub(crate) fn extent(points: &[Point]) -> f64 {
    let (low, high) =
        points.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(mut low, mut high), p| {
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
            (low, high)
        });
    (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
}
