//! What the operations share: fields, names, and how what they make joins the scene.

use std::f64::consts::TAU;

use loftsman_kernel::error::{Error, Figure};
use loftsman_kernel::plugin::{Field, OperationError, ParameterError, Parameters, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Standing};
use loftsman_kernel::spline::Curve;
pub(crate) use loftsman_kernel::text::measured as figure;
use loftsman_kernel::{Point, Vector};

pub(crate) const NAME: Field =
    Field::optional("name", "text", "after what it is", "the name of what is made");

/// A vector that has a direction, or a default.
pub(crate) fn direction(p: &Parameters, field: &str, default: Vector) -> Result<Vector, ParameterError> {
    if !p.has(field) {
        return Ok(default);
    }
    let vector = p.vector(field)?;
    if vector == Vector::zeros() {
        return Err(p.error(field, "[0, 0, 0] has no direction: give a vector that is not zero"));
    }
    Ok(vector)
}

/// A point, or the origin.
pub(crate) fn point_or_origin(p: &Parameters, field: &str) -> Result<Point, ParameterError> {
    if p.has(field) { p.point(field) } else { Ok(Point::origin()) }
}

/// How long a vector is, where its squares may overflow or vanish.
pub(crate) fn long(vector: &Vector) -> f64 {
    vector.x.hypot(vector.y).hypot(vector.z)
}

/// A length above 0.
pub(crate) fn length(p: &Parameters, field: &str) -> Result<f64, ParameterError> {
    let length = p.number(field)?;
    if length > 0.0 {
        return Ok(length);
    }
    Err(p.error(field, format!("{} is no length: give a number above 0", Figure(length))))
}

/// An angle that is a turn, in radians: as many degrees as `field` says, or a full turn.
pub(crate) fn turn(p: &Parameters, field: &str) -> Result<f64, ParameterError> {
    let degrees = p.number_or(field, 360.0)?;
    if degrees == 0.0 || degrees.abs() > 360.0 {
        let problem = format!(
            "{} degrees cannot be turned: give an angle that is not 0, from -360 to 360",
            Figure(degrees)
        );
        return Err(p.error(field, problem));
    }
    // A full turn closes to the last bit.
    Ok(if degrees.abs() == 360.0 { TAU.copysign(degrees) } else { degrees.to_radians() })
}

/// The name of what is made: as asked for, where it is free, or `wanted` with a number where that is taken.
pub(crate) fn free_name(scene: &Scene, p: &Parameters, wanted: &str) -> Result<String, ParameterError> {
    if !p.has("name") {
        return Ok(scene.unique_name(wanted));
    }
    let name = p.text("name")?;
    if name.is_empty() {
        return Err(p.error("name", "is empty: give a name, or leave the field out"));
    }
    if scene.get(name).is_some() {
        return Err(p.error("name", format!("there is an object \"{name}\" already: choose another name")));
    }
    Ok(name.to_owned())
}

/// What is made of an object stands where that stands, in its colour and on its layer.
pub(crate) fn like(scene: &Scene, source: &str, name: &str, geometry: Geometry) -> Object {
    let mut object = Object::new(name, geometry);
    if let Some(source) = scene.get(source) {
        object.color = source.color;
        object.layer.clone_from(&source.layer);
        object.parent.clone_from(&source.parent);
        object.transform = source.transform;
        object.materials.clone_from(&source.materials);
    }
    object
}

/// What a step that made one thing reports.
pub(crate) fn made(op: &str, name: String, notes: Vec<String>) -> StepReport {
    StepReport { op: op.into(), object: Some(name), notes, ..StepReport::default() }
}

/// An error that speaks of an object.
pub(crate) fn named(name: &str) -> impl Fn(Error) -> OperationError {
    let name = name.to_owned();
    move |error| Error::Invalid(format!("\"{name}\": {error}")).into()
}

/// A curve as it stands in the scene.
pub(crate) fn seen(curve: &Curve, standing: &Standing) -> Result<Curve, Error> {
    match standing.seen(&curve.clone().into())?.into_owned() {
        Geometry::Curve(curve) => Ok(curve),
        other => Err(Error::Invalid(format!("it is {} where it stands", other.kind()))),
    }
}
