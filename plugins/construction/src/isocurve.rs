//! `isocurve`: curves of surfaces, exactly.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Direction;

use crate::fields::{NAME, figure, free_name, like, made};

/// The operation `isocurve`: [`Surface::isocurve`](loftsman_kernel::spline::Surface::isocurve).
#[derive(Debug, Clone, Copy, Default)]
pub struct Isocurve;

impl Operation for Isocurve {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only surface", "the surface"),
            Field::optional(
                "u",
                "number, { closest = [x, y, z] }, or a list of these",
                "u, v or at is needed",
                "where u stands still",
            ),
            Field::optional(
                "v",
                "number, { closest = [x, y, z] }, or a list of these",
                "u, v or at is needed",
                "where v stands still",
            ),
            Field::optional(
                "at",
                "[u, v] or { closest = [x, y, z] }, with direction also a number",
                "u, v or at is needed",
                "a place that the curves go through: both, or the one along which the direction's parameter stands still",
            ),
            Field::optional("direction", "\"u\" | \"v\"", "both", "with at: which parameter stands still"),
            NAME,
        ];
        Declaration {
            name: "isocurve",
            help: "add the curves on a surface along which u or v stands still, exactly; reports their lengths",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let source = object_name(scene, p, |g| matches!(g, Geometry::Surface(_)), "surface")?;
        if let Geometry::Trimmed(_) = scene.object(&source)?.geometry() {
            let problem = format!(
                "\"{source}\" is a trimmed surface: have the whole of what carries it by `untrim` first, or its border by `edge`"
            );
            return Err(p.error("object", problem).into());
        }
        let surface = scene.surface(&source).map_err(|e| p.error("object", e.to_string()))?.clone();
        let mut changed = scene.clone();
        let (mut first, mut notes) = (None, Vec::new());
        let through = through(p)?;
        let wanted = [("u", Direction::U, places(p, "u")?), ("v", Direction::V, places(p, "v")?)];
        let count =
            wanted.iter().map(|(.., list)| list.len()).sum::<usize>() + through.iter().flatten().count();
        if count == 0 {
            return Err(p.error("", "say where: u or v = number, or [number, …], or at = [u, v]").into());
        }
        for ((name, direction, list), through) in wanted.into_iter().zip(through) {
            let fields = list.into_iter().map(|at| (name, at)).chain(through.map(|at| ("at", at)));
            for (field, at) in fields {
                let curve = surface.isocurve(direction, at).map_err(|e| p.error(field, e.to_string()))?;
                let space = surface.space(direction);
                let (start, end) = space.domain();
                // A place beyond the domain of what is periodic has another within.
                let asked = at;
                let at = if space.is_periodic() && !(start..=end).contains(&at) {
                    let within = start + (at - start).rem_euclid(end - start);
                    notes.push(format!(
                        "{name} = {} is outside the domain from {} to {}, which goes round: that is {name} = {}",
                        figure(asked),
                        figure(start),
                        figure(end),
                        figure(within)
                    ));
                    within
                } else {
                    at
                };
                let wanted = format!("{source} {name} = {}", figure(at));
                let name = match p.has("name") {
                    true if count > 1 => changed.unique_name(p.text("name")?),
                    // A number behind the name would be read as the parameter.
                    _ if !p.has("name") && changed.get(&wanted).is_some() => numbered(&changed, &wanted),
                    _ => free_name(&changed, p, &wanted)?,
                };
                let object = like(scene, &source, &name, curve.into());
                changed.add(object)?;
                first.get_or_insert(name);
            }
        }
        *scene = changed;
        Ok(made("isocurve", first.unwrap_or_default(), notes))
    }
}

/// The parameters of u and of v that stand still along curves through the place `at`.
fn through(p: &Parameters) -> Result<[Option<f64>; 2], ParameterError> {
    let direction =
        if p.has("direction") { Some(p.choice("direction", &[("u", 0), ("v", 1)])?) } else { None };
    match (p.has("at"), direction) {
        (false, None) => Ok([None, None]),
        (false, Some(_)) => {
            Err(p.error("direction", "it goes with at = number: where that parameter stands still"))
        }
        (true, Some(direction)) => {
            let at = p.number("at")?;
            Ok(if direction == 0 { [Some(at), None] } else { [None, Some(at)] })
        }
        (true, None) if p.value("at").is_some_and(|value| value.is_object()) => {
            Err(p.error("at", "a place of a surface is [u, v] or { closest = [x, y, z] }"))
        }
        (true, None) => match p.numbers("at")?[..] {
            [u, v] => Ok([Some(u), Some(v)]),
            _ => Err(p.error("at", "a place of a surface is [u, v]; with a direction one number")),
        },
    }
}

/// A number or several; none where the field is left out.
fn places(p: &Parameters, field: &str) -> Result<Vec<f64>, ParameterError> {
    match p.value(field) {
        None => Ok(Vec::new()),
        Some(value) if value.is_array() => p.numbers(field),
        Some(_) => Ok(vec![p.number(field)?]),
    }
}

/// The first of `wanted (2)`, `wanted (3)` and so on that no object has.
fn numbered(scene: &Scene, wanted: &str) -> String {
    let mut names = (2_u64..).map(|number| format!("{wanted} ({number})"));
    names.find(|name| scene.get(name).is_none()).unwrap_or_else(|| scene.unique_name(wanted))
}
