//! `fine-tune` of surfaces.

use std::sync::Arc;

use loftsman_kernel::plugin::{Field, OperationError, ParameterError, Parameters, StepReport};
use loftsman_kernel::solve::Solver;
use loftsman_kernel::spline::algebra::{Field as Net, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::text::figure;

use super::{alpha_there, check_solved, continuity, ends_of_both, function, places, short, space};
use crate::{Ends, FineTuneSurface, Scaling, SurfaceReport, surface_alpha_of, surface_alpha_spaces};

/// The tuned surface, and what is told of it.
pub(super) fn tuned(
    parameters: &Parameters,
    surface: &Surface,
    solver: Arc<dyn Solver>,
) -> Result<(Surface, StepReport), OperationError> {
    const CURVES: [(&str, &str); 3] = [
        (
            "through",
            "is not for surfaces: bring points of the tuned surface to where they should be in a step of its own (edit)",
        ),
        (
            "constraints",
            "is not for surfaces: hold alpha where it matters (alpha_at), or constrain the tuned surface in a step of its own (edit)",
        ),
        ("lock", "is for meshes and polylines: of a surface tune a part (range), and nothing else changes"),
    ];
    if let Some((name, problem)) = CURVES.into_iter().find(|(name, _)| parameters.has(name)) {
        return Err(parameters.error(name, problem).into());
    }
    let ends = ends_of_both(parameters)?;
    let solved = if ends.contains(&Ends::Exact) { Ends::Exact } else { ends[0] };
    check_solved(parameters, solved)?;
    let scaling = scaling(parameters, surface)?;
    let mut tune = FineTuneSurface::new(surface, scaling.clone());
    tune = tune.ends_along(Direction::U, ends[0]).ends_along(Direction::V, ends[1]);
    for place in places(parameters, "alpha_at")? {
        let direction = match &scaling {
            Scaling::Directional { u: Some(_), v: None } => Direction::U,
            Scaling::Directional { u: None, v: Some(_) } => Direction::V,
            Scaling::Along { direction, .. } => *direction,
            _ => {
                let problem = "is for an alpha of one direction, which can be changed to have a value somewhere: tune one after the other";
                return Err(parameters.error("alpha_at", problem).into());
            }
        };
        let [u, v] = place.numbers("at")?[..] else {
            return Err(place.error("at", "a place [u, v] on the surface is needed").into());
        };
        tune = tune.alpha_at(direction, (u, v), alpha_there(parameters, &place)?);
    }
    for (direction, (a, b)) in region(parameters)? {
        tune = tune.between(direction, a, b);
    }
    if parameters.has("continuity") {
        tune = tune.continuity(continuity(parameters)?);
    }
    if parameters.flag("any_sign")? {
        tune = tune.any_sign();
    }
    let tuned = tune.solve_with(solver)?;
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
            let change = figure(tuned.change[k]);
            notes.push(format!(
                "alpha along {name} {} to {}, changed by {change} in the mean",
                short(least),
                short(most)
            ));
        }
        if tuned.scale[k] != 1.0 {
            notes.push(format!("scaled by {} to keep its ends along {name}", short(tuned.scale[k])));
        }
    }
    notes.extend(tuned.residual.map(|r| {
        format!("the derivatives differ by {r} of their lengths from what they are to be", r = figure(r))
    }));
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
    let line = |name: &str, space: &Space| -> Result<Option<Function<f64>>, OperationError> {
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
            Some(value) if value.is_object() => Some(function(&parameters.table(name)?)?),
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

/// Whether functions of a space jump inside their domain, or where it closes.
fn jumps(space: &Space) -> bool {
    let breaks = space.breakpoints();
    let outer = usize::from(!space.is_periodic());
    let inner = breaks.get(outer..breaks.len().saturating_sub(1)).unwrap_or_default();
    inner.iter().any(|t| space.multiplicity(*t) > space.degree())
}

/// α(u, v): one number, rows of values along `u`, each along `v`, on the derivatives' own knots, or a spline function of two parameters.
fn net(parameters: &Parameters, surface: &Surface, [u, v]: [&Space; 2]) -> Result<Net<f64>, OperationError> {
    if parameters.value("alpha").is_some_and(|value| value.is_object()) {
        return net_function(&parameters.table("alpha")?);
    }
    let Some(rows) = parameters.value("alpha").and_then(|value| value.as_array()) else {
        let value = parameters.number("alpha")?;
        // Across its direction a number must not jump where the derivative does: there the surface's own knots are for it.
        let along = parameters.value("direction").and_then(|word| word.as_str());
        let across = |space: &Space, own: &Space, is_along: bool| {
            if is_along || !jumps(space) { space.clone() } else { own.clone() }
        };
        let u = across(u, surface.u(), along != Some("v"));
        let v = across(v, surface.v(), along != Some("u"));
        let count = u.len() * v.len();
        return Ok(Net::new(u, v, vec![value; count])?);
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

/// A spline function of two parameters by its degrees, knots and rows of values.
fn net_function(table: &Parameters) -> Result<Net<f64>, OperationError> {
    const KNOWN: [Field; 3] = [
        Field::required("degree", "[p, q]", ""),
        Field::required("knots", "[[knot, …], [knot, …]]", ""),
        Field::required("values", "[[value, …], …]", ""),
    ];
    table.check(&KNOWN)?;
    let lists = |name: &str| -> Result<Vec<Vec<f64>>, ParameterError> {
        let all = table.list(name)?.iter().map(|row| row.as_array()?.iter().map(|x| x.as_f64()).collect());
        all.collect::<Option<_>>().ok_or_else(|| table.error(name, "lists of numbers are needed"))
    };
    let &[p, q] = &table.integers("degree")?[..] else {
        return Err(table.error("degree", "two degrees [p, q] are needed").into());
    };
    let [p, q] = [p, q].map(|degree| usize::try_from(degree).unwrap_or(usize::MAX));
    let rows = lists("values")?;
    let columns = rows.first().map_or(0, Vec::len);
    if let Some(k) = rows.iter().position(|row| row.len() != columns) {
        let problem = format!("row {k} has {} values, and the first {columns}", rows[k].len());
        return Err(table.error("values", problem).into());
    }
    let Ok([of_u, of_v]) = <[Vec<f64>; 2]>::try_from(lists("knots")?) else {
        return Err(table.error("knots", "those along u and those along v are needed").into());
    };
    let of =
        |degree, knots, count| space(degree, knots, count).map_err(|problem| table.error("knots", problem));
    let (u, v) = (of(p, of_u, rows.len())?, of(q, of_v, columns)?);
    Net::new(u, v, rows.concat()).map_err(|error| table.error("values", error.to_string()).into())
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
