//! What is told of a fit.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{ConstraintReport, StepReport};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::text::{figure, without_rounding};

use crate::corner::Doubt;
use crate::fit::FittedCurve;

pub(super) fn report_of(fitted: &FittedCurve, points: &[Point], unit: Unit) -> StepReport {
    let length = |x: f64| unit.quantity(x, 1);
    // Errors that are rounding at the size of the curve are none.
    let error = |x: f64| length(without_rounding(x, fitted.length));
    let vertices = fitted.curve.points().len();
    let place = points.get(fitted.farthest).map(|p| format!(" {}", place(p))).unwrap_or_default();
    let mut notes = vec![format!(
        "largest distance from the points {}, at point {}{place}; root mean square at their parameters {}; {vertices} control vertices for {} points",
        error(fitted.distance),
        fitted.farthest,
        error(fitted.rms_error),
        points.len()
    )];
    match fitted.tolerance {
        Some(tolerance) if !fitted.met => {
            notes.push(format!("best effort: the tolerance {} is not met", length(tolerance)));
        }
        Some(tolerance) => notes.push(format!("the tolerance {} is met", length(tolerance))),
        None => {}
    }
    let leading = notes.len();
    notes.push(format!(
        "length {}, the polygon of the points {}",
        length(fitted.length),
        length(fitted.polygon_length)
    ));
    if fitted.interpolated {
        notes.push(if fitted.tolerance.is_some() {
            "nothing less than interpolation met the tolerance".into()
        } else {
            "as many control vertices as points: interpolated".into()
        });
    }
    notes.extend(fitted.remarks.iter().cloned());
    if !fitted.corners.is_empty() {
        let first: Vec<String> = fitted.corners.iter().take(8).map(ToString::to_string).collect();
        let more = if fitted.corners.len() > 8 { ", …" } else { "" };
        let (count, plural) = (fitted.corners.len(), if fitted.corners.len() == 1 { "" } else { "s" });
        notes.push(format!("{count} corner{plural}, at point{plural} {}{more}", first.join(", ")));
    }
    if let Some(scatter) = &fitted.scatter {
        notes.push(format!(
            "the points scatter by about {}: corners are where curves near {} points on either side turn by more than 60°",
            length(scatter.deviation),
            scatter.points
        ));
        notes.extend(scatter.doubtful.iter().take(MANY).map(doubt));
    }
    if fitted.closing_point_dropped {
        notes.push("the last point repeats the first and was left out of the closed curve".into());
    }
    let kept = &fitted.kept;
    let constraint = |(name, residual): &(String, f64)| ConstraintReport {
        between: None,
        name: name.clone().into(),
        residual: *residual,
        ..ConstraintReport::default()
    };
    StepReport {
        residual: Some(kept.residuals.iter().fold(0.0, |m, (_, r)| r.max(m))),
        condition: Some(fitted.condition),
        iterations: Some(fitted.iterations),
        redundant: kept.redundant.clone(),
        constraints: kept.residuals.iter().map(constraint).collect(),
        notes,
        leading,
        ..StepReport::default()
    }
}

/// Of places in doubt so many are told.
const MANY: usize = 8;

fn doubt(doubt: &Doubt) -> String {
    let taken = if doubt.taken { "the corner" } else { "whether there is none" };
    format!(
        "{taken} at point {} is doubtful: the points turn by {:.0}° ± {:.0}°",
        doubt.point,
        doubt.turn.to_degrees(),
        doubt.give.to_degrees()
    )
}

/// `(0.5, 0, 1)`: what is rounding beside the largest coordinate is 0.
pub(crate) fn place(point: &Point) -> String {
    let size = point.coords.amax();
    let told: Vec<String> = point.iter().map(|&x| figure(without_rounding(x, size))).collect();
    format!("({})", told.join(", "))
}
