//! The numbers of a material and of steps: their fields, what is asked of each, and what follows where one is not said.

use loftsman_kernel::plugin::{OperationError, ParameterError, Parameters};
use loftsman_kernel::shape::Shape;

use crate::body::Material;
use crate::error::{DynamicsError, check, check_damping, check_mass, check_rest, check_time};
use crate::measure;

/// How much heavier than itself what a rope carries would have to be to stretch it to twice its length.
const STIFF: f64 = 200.0;
/// How fast motion dies away where nothing is said of it: a swing loses two fifths of its speed in a second, so that a first try comes to rest.
pub(super) const AIR: f64 = 0.5;

/// The numbers of a material: their fields, and what is asked of each.
type Checked = (&'static str, fn(f64) -> Result<f64, DynamicsError>);
const NUMBERS: [Checked; 7] = [
    ("stiffness", |value| check("the stiffness", value, false)),
    ("mass", |value| check_mass("the mass", value)),
    ("shear", |value| check("the shear stiffness", value, true)),
    ("bending", |value| check("the bending stiffness", value, true)),
    ("damping", |value| check_damping("the damping", value)),
    ("viscosity", |value| check("the viscosity", value, true)),
    ("rest", check_rest),
];
/// And of steps.
pub(super) const STEPS: [Checked; 3] = [
    ("epsilon", |value| check("epsilon", value, false)),
    ("step", |value| check_time("the step", value)),
    ("draw", |value| check_time("the time in which constraints are drawn in", value)),
];

/// Looks at those of the fields that are there.
pub(super) fn check_all(parameters: &Parameters, all: &[Checked]) -> Result<(), ParameterError> {
    for (field, checked) in all {
        if parameters.has(field)
            && let Err(error) = checked(parameters.number(field)?)
        {
            return Err(parameters.error(field, error.to_string()));
        }
    }
    Ok(())
}

pub(super) fn material(parameters: &Parameters, other: Material) -> Result<Material, ParameterError> {
    let number = |name: &str, or: f64| if parameters.has(name) { parameters.number(name) } else { Ok(or) };
    let stiffness = number("stiffness", other.stiffness)?;
    if stiffness <= 0.0 {
        let problem = format!("a stiffness of {stiffness} keeps nothing together: give more than 0");
        return Err(parameters.error("stiffness", problem));
    }
    // At its place in the recipe, and with 0 only where it means something.
    check_all(parameters, &NUMBERS)?;
    let shear = if parameters.has("shear") {
        parameters.number("shear")?
    } else if parameters.has("stiffness") {
        0.5 * stiffness
    } else {
        other.shear
    };
    Ok(Material {
        mass: number("mass", other.mass)?,
        stiffness,
        shear,
        rest: number("rest", other.rest)?,
        bending: number("bending", other.bending)?,
        damping: number("damping", other.damping)?,
        viscosity: number("viscosity", other.viscosity)?,
    })
}

/// What is not said of its stiffness follows from its weight: that of its own length, of a surface by its width, the root of its area.
pub(super) fn stiffened(
    mut material: Material,
    shape: &dyn Shape,
    fall: f64,
) -> Result<Material, OperationError> {
    if material.stiffness.is_nan() {
        material.stiffness = STIFF * material.mass * fall * reach(shape)?;
    }
    if material.shear.is_nan() {
        material.shear = 0.5 * material.stiffness;
    }
    Ok(material)
}

/// The arc length of a curve, the root of the area of a surface: of the shape itself, whatever its control vertices, and however it lies.
pub(super) fn reach(shape: &dyn Shape) -> Result<f64, OperationError> {
    let all = measure::whole(shape)?;
    Ok(if shape.domain().len() == 1 { all } else { all.sqrt() })
}
