//! Operations that run a spline the other way or cut it: `reverse`, `split`.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};

use crate::problem::OBJECT;
use crate::representation::{DIRECTION, direction, done, not_a_spline, spline};

/// The operation `reverse`: the parameter runs the other way.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reverse;

impl Operation for Reverse {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[OBJECT, DIRECTION];
        Declaration { name: "reverse", help: "let the parameter run the other way", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = spline(scene, p)?;
        let direction = direction(p)?;
        let reversed: Geometry = match &scene.object(&name)?.geometry {
            Geometry::Curve(curve) => curve.reverse()?.into(),
            Geometry::Surface(surface) => surface.reverse(direction)?.into(),
            other => return Err(not_a_spline(&name, other).into()),
        };
        scene.replace(&name, reversed)?;
        Ok(done("reverse", name, "reversed".into()))
    }
}

/// The operation `split`: one object becomes two.
#[derive(Debug, Clone, Copy, Default)]
pub struct Split;

impl Operation for Split {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] =
            &[OBJECT, Field::required("at", "number", "the parameter to split at"), DIRECTION];
        Declaration {
            name: "split",
            help: "cut in two at a parameter (a periodic shape is opened)",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = spline(scene, p)?;
        let (at, direction) = (p.number("at")?, direction(p)?);
        let object = scene.object(&name)?.clone();
        let pieces: Vec<Geometry> = match &object.geometry {
            Geometry::Curve(curve) => curve.split(at)?.into_iter().map(Into::into).collect(),
            Geometry::Surface(surface) => surface.split(direction, at)?.into_iter().map(Into::into).collect(),
            other => return Err(not_a_spline(&name, other).into()),
        };
        let mut names = Vec::new();
        for (number, piece) in pieces.into_iter().enumerate() {
            if number == 0 {
                scene.replace(&name, piece)?;
                names.push(name.clone());
                continue;
            }
            let fresh = scene.unique_name(&name);
            names.push(fresh.clone());
            let mut twin = Object::new(fresh, piece);
            twin.color = object.color;
            twin.layer.clone_from(&object.layer);
            twin.parent.clone_from(&object.parent);
            twin.transform = object.transform;
            scene.add(twin)?;
        }
        Ok(done("split", name, format!("pieces: {}", names.join(", "))))
    }
}
