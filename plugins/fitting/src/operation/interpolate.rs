//! Interpolation, and what to do where it does not follow its points.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{OperationError, Parameters, StepReport};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::text::{short, without_rounding};

use super::asked::{degree_of, parametrization};
use crate::error::FitError;
use crate::interpolation::{Duplicates, Ends, Interpolation};
use crate::parameters::Parametrization;

/// Interpolation, and what there is to say about it.
pub(super) fn interpolate(
    points: &[Point],
    closed: bool,
    parameters: &Parameters,
    unit: Unit,
) -> Result<(loftsman_kernel::spline::Curve, StepReport), OperationError> {
    const LEAST_SQUARES: [&str; 10] = [
        "corners",
        "tolerance",
        "relative_tolerance",
        "vertices",
        "corrections",
        "weights",
        "constraints",
        "regularization",
        "smooth",
        "best_effort",
    ];
    if let Some(field) = LEAST_SQUARES.into_iter().find(|f| parameters.has(f)) {
        let problem = "has no meaning where every point is interpolated; leave it or \"interpolate\" out";
        return Err(parameters.error(field, problem).into());
    }
    let ends = if parameters.has("ends") {
        let words =
            [("averaged", Ends::Averaged), ("not-a-knot", Ends::NotAKnot), ("natural", Ends::Natural)];
        let choices: Vec<(&str, usize)> = words.iter().enumerate().map(|(i, (word, _))| (*word, i)).collect();
        let choice = parameters.choice("ends", &choices)?;
        words.into_iter().nth(choice).map(|(_, ends)| ends).unwrap_or_default()
    } else {
        Ends::default()
    };
    let interpolation = Interpolation {
        degree: degree_of(parameters)?,
        closed,
        parameters: parametrization(parameters)?,
        ends,
        duplicates: if parameters.flag("merge")? { Duplicates::Merge } else { Duplicates::Refuse },
    };
    let (through, instead) = match interpolation.curve(points) {
        // Nobody asked for these parameters.
        Err(FitError::Astray { astray, .. }) if !parameters.has("parameters") => (
            centripetal(&interpolation)
                .curve(points)
                .map_err(|error| calmed(error, &interpolation, points, true))?,
            Some(format!("centripetal parameters: by chord length the curve {astray}")),
        ),
        other => {
            let any = !parameters.has("parameters");
            (other.map_err(|error| calmed(error, &interpolation, points, any))?, None)
        }
    };
    let size = points.iter().fold(0.0_f64, |most, p| most.max(p.coords.amax()));
    let miss = match without_rounding(through.residual, size) {
        0.0 => String::new(),
        miss => format!(", to {}", unit.quantity(miss, 1)),
    };
    let mut notes = vec![format!(
        "{} control vertices through {} points{miss}",
        through.curve.points().len(),
        points.len() - through.merged.len()
    )];
    notes.extend(instead);
    if !through.merged.is_empty() {
        notes.push(format!(
            "{} coincident points merged (first: {})",
            through.merged.len(),
            through.merged[0]
        ));
    }
    let report = StepReport {
        residual: Some(through.residual),
        condition: Some(through.condition),
        iterations: Some(1),
        notes,
        leading: 1,
        ..StepReport::default()
    };
    Ok((through.curve, report))
}

pub(super) fn centripetal(interpolation: &Interpolation) -> Interpolation {
    Interpolation { parameters: Parametrization::Centripetal, ..interpolation.clone() }
}

/// What to do where an interpolation does not follow its points: the highest degree below at which it does, tried, with the same parameters or, where
/// `any` will do, with centripetal ones.
pub(super) fn calmed(
    error: FitError,
    interpolation: &Interpolation,
    points: &[Point],
    any: bool,
) -> FitError {
    let what = match &error {
        FitError::Astray { astray, .. } => format!("the curve {astray}: it goes astray between the points"),
        FitError::IllConditioned { condition, .. } => {
            format!("the equations are singular to working precision (condition {})", short(*condition))
        }
        _ => return error,
    };
    let follows = |degree: &usize| {
        let lower = Interpolation { degree: *degree, ..interpolation.clone() };
        lower.curve(points).is_ok() || any && centripetal(&lower).curve(points).is_ok()
    };
    match (1..interpolation.degree).rev().find(follows) {
        Some(degree) => FitError::Request(format!(
            "{what}; degree = {degree} follows the points, or fit to a tolerance (without \"interpolate\")"
        )),
        None => error,
    }
}
