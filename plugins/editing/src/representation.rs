//! Operations that change how a spline is represented, not its shape: `refine`, `elevate`; and `untrim`, which takes
//! a surface's loops away.

use loftsman_kernel::error::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::text::a;

use crate::problem::OBJECT;

pub(crate) const DIRECTION: Field =
    Field::optional("direction", "\"u\" | \"v\"", "u", "the direction, on a surface");

/// The curve or surface that a step names. What it is not is said before its other fields are looked at: a place of a trimmed surface, say, is no number.
pub(crate) fn spline(scene: &Scene, parameters: &Parameters) -> Result<String, OperationError> {
    let fits = |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Surface(_));
    let name = object_name(scene, parameters, fits, "curve or surface")?;
    match scene.object(&name)?.geometry() {
        geometry if fits(geometry) => Ok(name),
        other => Err(not_a_spline(&name, other).into()),
    }
}

pub(crate) fn direction(parameters: &Parameters) -> Result<Direction, ParameterError> {
    if !parameters.has("direction") {
        return Ok(Direction::U);
    }
    parameters.choice("direction", &[("u", Direction::U), ("v", Direction::V)])
}

pub(crate) fn not_a_spline(name: &str, geometry: &Geometry) -> Error {
    Error::Invalid(match geometry {
        Geometry::Trimmed(_) => {
            format!(
                "\"{name}\" is a trimmed surface, which this cannot be done to yet: \"untrim\" makes it a whole one"
            )
        }
        Geometry::Custom(custom) => {
            let kind = custom.kind();
            format!(
                "\"{name}\" is a shape of the kind \"{kind}\", which has no knots or degree to change: \
                 \"edit\" and \"drag\" move it"
            )
        }
        other => format!("\"{name}\" is {}", other.other_than("a curve or surface")),
    })
}

pub(crate) fn done(op: &str, object: String, note: String) -> StepReport {
    StepReport { op: op.into(), object: Some(object), notes: vec![note], ..StepReport::default() }
}

/// The operation `refine`: knots are inserted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Refine;

impl Operation for Refine {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECT,
            Field::required(
                "knots",
                "[number or { closest = [x, y, z] }, …]",
                "the knots to insert; repeat one to raise it",
            ),
            DIRECTION,
        ];
        Declaration { name: "refine", help: "insert knots; the shape does not change", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = spline(scene, p)?;
        let (knots, direction) = (p.numbers("knots")?, direction(p)?);
        scene.reshape(&name, |geometry| match geometry {
            Geometry::Curve(curve) => curve.insert_knots(&knots).map(Geometry::from),
            Geometry::Surface(surface) => surface.insert_knots(direction, &knots).map(Geometry::from),
            other => Err(not_a_spline(&name, other)),
        })?;
        let note = format!("{} control vertices", scene.object(&name)?.geometry().points().len());
        Ok(done("refine", name, note))
    }
}

/// The operation `elevate`: the degree is raised.
#[derive(Debug, Clone, Copy, Default)]
pub struct Elevate;

impl Operation for Elevate {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECT,
            Field::optional("by", "count", "1", "how many degrees"),
            Field::optional("direction", "\"u\" | \"v\"", "both", "the direction, on a surface"),
        ];
        Declaration { name: "elevate", help: "raise the degree; the shape does not change", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = spline(scene, p)?;
        let by = p.count_or("by", 1)?;
        let directions =
            if p.has("direction") { vec![direction(p)?] } else { vec![Direction::U, Direction::V] };
        scene.reshape(&name, |geometry| match geometry {
            Geometry::Curve(curve) => curve.elevate(by).map(Geometry::from),
            Geometry::Surface(surface) => directions
                .iter()
                .try_fold(surface.clone(), |surface, &direction| surface.elevate(direction, by))
                .map(Geometry::from),
            other => Err(not_a_spline(&name, other)),
        })?;
        let degree = match scene.object(&name)?.geometry() {
            Geometry::Surface(surface) => format!("{} × {}", surface.u().degree(), surface.v().degree()),
            _ => scene.curve(&name)?.degree().to_string(),
        };
        Ok(done("elevate", name, format!("degree {degree}")))
    }
}

/// The operation `untrim`: a trimmed surface becomes the whole surface that carries it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Untrim;

impl Operation for Untrim {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] =
            &[Field::optional("object", "text", "the only trimmed surface", "the trimmed surface")];
        Declaration { name: "untrim", help: "take the loops of a trimmed surface away", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = object_name(scene, p, |g| matches!(g, Geometry::Trimmed(_)), "trimmed surface")?;
        let Geometry::Trimmed(trimmed) = scene.object(&name)?.geometry() else {
            return Err(Error::Invalid(format!("\"{name}\" is no trimmed surface")).into());
        };
        let loops = trimmed.loops().count();
        scene.reshape(&name, |geometry| match geometry {
            Geometry::Trimmed(trimmed) => Ok(Geometry::from(trimmed.surface())),
            other => Err(Error::Invalid(format!("\"{name}\" is {}, no trimmed surface", a(&other.noun())))),
        })?;
        let plural = if loops == 1 { "" } else { "s" };
        Ok(done("untrim", name, format!("{loops} loop{plural} taken away")))
    }
}
