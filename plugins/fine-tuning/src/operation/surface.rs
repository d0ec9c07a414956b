//! `fine-tune` of surfaces.

use std::sync::Arc;

use loftsman_kernel::plugin::{OperationError, ParameterError, Parameters, StepReport};
use loftsman_kernel::solve::Solver;
use loftsman_kernel::spline::algebra::{Field as Net, Function};
use loftsman_kernel::spline::{Direction, Surface};

use super::{continuity, ends, function};
use crate::{FineTuneSurface, Scaling, SurfaceReport, surface_alpha_of, surface_alpha_spaces};

/// The tuned surface, and what is told of it.
pub(super) fn tuned(
    parameters: &Parameters,
    surface: &Surface,
    solver: Arc<dyn Solver>,
) -> Result<(Surface, StepReport), OperationError> {
    const CURVES: [&str; 4] = ["through", "alpha_at", "constraints", "lock"];
    if let Some(name) = CURVES.into_iter().find(|name| parameters.has(name)) {
        return Err(parameters.error(name, "is not for surfaces").into());
    }
    let mut tune =
        FineTuneSurface::new(surface, scaling(parameters, surface)?).ends(ends(parameters)?).solver(solver);
    for (direction, (a, b)) in region(parameters)? {
        tune = tune.between(direction, a, b);
    }
    if parameters.has("continuity") {
        tune = tune.continuity(continuity(parameters)?);
    }
    if parameters.flag("any_sign")? {
        tune = tune.any_sign();
    }
    let tuned = tune.solve()?;
    let report = report(surface, tuned.surface(), tuned.report());
    Ok((tuned.into_surface(), report))
}

fn report(before: &Surface, after: &Surface, tuned: &SurfaceReport) -> StepReport {
    let mut notes = vec![format!(
        "degrees {} × {} → {} × {}",
        before.u().degree(),
        before.v().degree(),
        after.u().degree(),
        after.v().degree()
    )];
    for (k, name) in ["u", "v"].into_iter().enumerate() {
        let [least, most] = tuned.alpha[k];
        if least != 1.0 || most != 1.0 {
            let change = tuned.change[k];
            notes.push(format!(
                "alpha along {name} {least:.4} to {most:.4}, changed by {change:.2e} in the mean"
            ));
        }
        if tuned.scale[k] != 1.0 {
            notes.push(format!("scaled by {:.6} to keep its ends along {name}", tuned.scale[k]));
        }
    }
    notes.extend(
        tuned
            .residual
            .map(|r| format!("the derivatives differ by {r:.2e} of their lengths from what they are to be")),
    );
    notes.extend(tuned.notes.iter().cloned());
    let solved: Vec<_> = tuned.solved.iter().flatten().collect();
    let [first, ..] = solved[..] else { return StepReport { notes, ..StepReport::default() } };
    StepReport {
        solver: Some(first.solver.clone()),
        equations: Some(solved.iter().map(|s| s.equations).sum()),
        rank: Some(solved.iter().map(|s| s.rank).sum()),
        residual: Some(solved.iter().fold(0.0, |m, s| s.residual.max(m))),
        condition: Some(solved.iter().fold(1.0, |m, s| s.condition.max(m))),
        iterations: Some(solved.iter().map(|s| s.iterations).sum()),
        notes,
        ..StepReport::default()
    }
}

/// `alpha_u` and `alpha_v`, or `alpha` with a `direction`.
fn scaling(parameters: &Parameters, surface: &Surface) -> Result<Scaling, OperationError> {
    const WORDS: [(&str, Option<Direction>); 3] =
        [("u", Some(Direction::U)), ("v", Some(Direction::V)), ("both", None)];
    let [u, v] = surface_alpha_spaces(surface)?;
    let line = |name: &str,
                space: &loftsman_kernel::spline::Space|
     -> Result<Option<Function<f64>>, OperationError> {
        let wrong = |problem: String| parameters.error(name, problem);
        Ok(match parameters.value(name) {
            None => None,
            Some(value) if value.is_array() => {
                let values = parameters.numbers(name)?;
                let (found, needed) = (values.len(), space.len());
                if found != needed {
                    return Err(wrong(format!(
                        "{found} values where the derivative's own knots have {needed}"
                    ))
                    .into());
                }
                Some(Function::new(space.clone(), values)?)
            }
            Some(value) if value.is_object() => {
                Some(function(&parameters.table(name)?).map_err(|error| wrong(error.to_string()))?)
            }
            Some(_) => Some(Function::constant(space.clone(), parameters.number(name)?)?),
        })
    };
    let (along_u, along_v) = (line("alpha_u", &u)?, line("alpha_v", &v)?);
    if along_u.is_some() || along_v.is_some() {
        if let Some(name) = ["alpha", "direction"].into_iter().find(|name| parameters.has(name)) {
            return Err(parameters
                .error(name, "stands beside alpha_u or alpha_v: give these, or alpha with a direction")
                .into());
        }
        return Ok(Scaling::Directional { u: along_u, v: along_v });
    }
    if !parameters.has("alpha") {
        let problem = "a surface is tuned by alpha_u, alpha_v or both, or by alpha with direction = \"u\", \"v\" or \"both\"";
        return Err(parameters.error("", problem).into());
    }
    let net = net(parameters, surface, [&u, &v])?;
    if !parameters.has("direction") {
        let problem = "alpha of a surface needs a direction: \"u\", \"v\", or \"both\" for least squares";
        return Err(parameters.error("direction", problem).into());
    }
    Ok(match parameters.choice("direction", &WORDS)? {
        Some(direction) => Scaling::along(direction, net),
        None => Scaling::both(net),
    })
}

/// α(u, v): one number, or rows of values along `u`, each along `v`, on the derivatives' own knots.
fn net(
    parameters: &Parameters,
    surface: &Surface,
    [u, v]: [&loftsman_kernel::spline::Space; 2],
) -> Result<Net<f64>, OperationError> {
    let Some(rows) = parameters.value("alpha").and_then(|value| value.as_array()) else {
        let value = parameters.number("alpha")?;
        return Ok(Net::new(u.clone(), v.clone(), vec![value; u.len() * v.len()])?);
    };
    let mut values = Vec::with_capacity(u.len() * v.len());
    for (k, row) in rows.iter().enumerate() {
        let own: Option<Vec<f64>> =
            row.as_array().and_then(|row| row.iter().map(|number| number.as_f64()).collect());
        match own {
            Some(own) if own.len() == v.len() => values.extend(own),
            found => {
                let found =
                    found.map_or("no list of numbers".to_owned(), |own| format!("{} values", own.len()));
                let problem = format!("{found} where a row of {} is needed (along v)", v.len());
                return Err(parameters.error(&format!("alpha[{k}]"), problem).into());
            }
        }
    }
    surface_alpha_of(surface, values).map_err(|error| parameters.error("alpha", error.to_string()).into())
}

/// The part of one direction that is tuned.
type Part = (Direction, (f64, f64));

/// `[[u₀, u₁], [v₀, v₁]]`, of which either may be empty.
fn region(parameters: &Parameters) -> Result<Vec<Part>, ParameterError> {
    if !parameters.has("range") {
        return Ok(Vec::new());
    }
    let wrong = || {
        parameters.error(
            "range",
            "of a surface is [[u0, u1], [v0, v1]]; an empty list is the whole of that direction",
        )
    };
    let [u, v] = parameters.list("range")? else { return Err(wrong()) };
    let mut all = Vec::new();
    for (direction, value) in [(Direction::U, u), (Direction::V, v)] {
        let numbers: Option<Vec<f64>> =
            value.as_array().and_then(|v| v.iter().map(|number| number.as_f64()).collect());
        match numbers.ok_or_else(wrong)?[..] {
            [] => {}
            [from, to] => all.push((direction, (from, to))),
            _ => return Err(wrong()),
        }
    }
    Ok(all)
}
