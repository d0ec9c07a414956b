//! The fit that the fields of a step ask for.

use loftsman_kernel::Error;
use loftsman_kernel::edit::Constraint;
use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::functional::ShapeNames;
use loftsman_kernel::plugin::{
    Context, OperationError, ParameterError, Parameters, constraint_from, functional_from,
};

use crate::corner::Corners;
use crate::fit::{Fit, Target};
use crate::parameters::Parametrization;

/// The tolerance where none is given, as a share of the points' size.
pub(super) const DEFAULT_RELATIVE: f64 = 1e-4;

pub(super) fn degree_of(parameters: &Parameters) -> Result<usize, ParameterError> {
    let degree = parameters.count_or("degree", 3)?;
    if (1..=MAX_DEGREE).contains(&degree) {
        return Ok(degree);
    }
    Err(parameters.error("degree", format!("is from 1 to {MAX_DEGREE}, not {degree}")))
}

pub(super) fn parametrization(parameters: &Parameters) -> Result<Parametrization, ParameterError> {
    if !parameters.has("parameters") {
        return Ok(Parametrization::default());
    }
    if parameters.text("parameters").is_err() {
        return Ok(Parametrization::Given(parameters.numbers("parameters")?));
    }
    let known = [("chord", 0_u8), ("centripetal", 1), ("uniform", 2)];
    Ok(match parameters.choice("parameters", &known)? {
        1 => Parametrization::Centripetal,
        2 => Parametrization::Uniform,
        _ => Parametrization::ChordLength,
    })
}

pub(super) fn corners_of(parameters: &Parameters) -> Result<Corners, ParameterError> {
    if !parameters.has("corners") {
        return Ok(Corners::None);
    }
    if parameters.text("corners").is_ok() {
        return parameters.choice("corners", &[("auto", Corners::Auto)]);
    }
    let degrees = parameters.number("corners")?;
    if degrees > 0.0 && degrees < 180.0 {
        return Ok(Corners::Angle(degrees.to_radians()));
    }
    Err(parameters.error("corners", "is a turn in degrees between 0 and 180, or \"auto\""))
}

/// The fit that the fields ask for.
pub(super) fn fit_of(
    closed: bool,
    object: &str,
    parameters: &Parameters,
    context: &Context<'_>,
) -> Result<Fit, OperationError> {
    if parameters.has("merge") {
        let problem = "is for interpolation only: least squares takes coincident points as they are";
        return Err(parameters.error("merge", problem).into());
    }
    let mut fit = Fit::new(degree_of(parameters)?, target_of(parameters)?);
    if let Target::Vertices(vertices) | Target::AtMost { vertices, .. } = fit.target {
        let least = if closed { 2 } else { fit.degree + 1 };
        if vertices < least {
            let shape = if closed {
                "a closed curve".to_owned()
            } else {
                format!("a curve of degree {}", fit.degree)
            };
            return Err(parameters
                .error("vertices", format!("{shape} has {least} or more, not {vertices}"))
                .into());
        }
    }
    fit.closed = closed;
    fit.parameters = parametrization(parameters)?;
    fit.corrections = parameters.count_or("corrections", fit.corrections)?;
    if parameters.has("ends") {
        fit.keep_ends = parameters.choice("ends", &[("keep", true), ("free", false)])?;
    }
    if parameters.has("weights") {
        fit.weights = Some(parameters.numbers("weights")?);
    }
    fit.corners = corners_of(parameters)?;
    fit.regularization = parameters.number_or("regularization", 0.0)?;
    if parameters.has("smooth") {
        fit.smooth = parameters.flag("smooth")?;
    }
    fit.best_effort = parameters.flag("best_effort")?;
    for table in parameters.tables("constraints")? {
        fit.constraints.push(constraint_of(&table, object, context)?);
    }
    Ok(fit)
}

pub(super) fn target_of(parameters: &Parameters) -> Result<Target, OperationError> {
    let vertices = if parameters.has("vertices") { Some(parameters.count("vertices")?) } else { None };
    let absolute = if parameters.has("tolerance") { Some(parameters.number("tolerance")?) } else { None };
    if absolute.is_some() && parameters.has("relative_tolerance") {
        let problem = "stands beside \"tolerance\"; give one of them";
        return Err(parameters.error("relative_tolerance", problem).into());
    }
    let relative = parameters.number_or("relative_tolerance", DEFAULT_RELATIVE)?;
    Ok(match (absolute, vertices) {
        (Some(tolerance), Some(vertices)) => Target::AtMost { tolerance, vertices },
        (Some(tolerance), None) => Target::Tolerance(tolerance),
        (None, Some(_)) if parameters.has("relative_tolerance") => {
            let problem = "limits a \"tolerance\" in document units; give that one, or no vertices";
            return Err(parameters.error("vertices", problem).into());
        }
        (None, Some(vertices)) => Target::Vertices(vertices),
        (None, None) => Target::Relative(relative),
    })
}

/// A constraint of the recipe: the functional's own fields, and the value it must have.
pub(super) fn constraint_of(
    table: &Parameters,
    object: &str,
    context: &Context<'_>,
) -> Result<Constraint, OperationError> {
    for word in ["at_least", "at_most"] {
        if table.has(word) {
            let problem =
                "a fit takes equations only, with \"to\": fit first, then edit the curve with this bound";
            return Err(table.error(word, problem).into());
        }
    }
    for word in ["by", "scale", "keep"] {
        if table.has(word) {
            let problem = "needs a shape that is there already; a fit can only be told a value, with \"to\"";
            return Err(table.error(word, problem).into());
        }
    }
    let mut names = OnlyItself { object };
    // "says nothing: give one of" would name words that a fit does not take.
    if !table.has("to")
        && !functional_from(context.registry, &table.without(&["axis"]), &mut names)?.is_condition()
    {
        return Err(table.error("to", "is missing: say which value it should have with `to`").into());
    }
    Ok(constraint_from(context.registry, table, &mut names)?)
}

/// A fit has one shape: the curve that it makes.
pub(super) struct OnlyItself<'a> {
    object: &'a str,
}

impl ShapeNames for OnlyItself<'_> {
    fn shape(&mut self, object: &str) -> loftsman_kernel::Result<usize> {
        if object == self.object {
            return Ok(0);
        }
        Err(Error::Invalid(format!(
            "a fit holds constraints on \"{}\" only, not on \"{object}\"",
            self.object
        )))
    }
}
