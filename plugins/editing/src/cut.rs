//! Operations that run a spline the other way or cut it: `reverse`, `split`.

use loftsman_kernel::error::Error;
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
        scene.reshape(&name, |geometry| match geometry {
            Geometry::Curve(curve) => curve.reverse().map(Geometry::from),
            Geometry::Surface(surface) => surface.reverse(direction).map(Geometry::from),
            other => Err(not_a_spline(&name, other)),
        })?;
        Ok(done("reverse", name, "reversed".into()))
    }
}

/// The operation `split`: one object becomes two.
#[derive(Debug, Clone, Copy, Default)]
pub struct Split;

impl Operation for Split {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECT,
            Field::required("at", "number, or { closest = [x, y, z] }", "the parameter to split at"),
            DIRECTION,
        ];
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
        let pieces = |geometry: &Geometry| -> Result<Vec<Geometry>, Error> {
            match geometry {
                Geometry::Curve(curve) => Ok(curve.split(at)?.into_iter().map(Into::into).collect()),
                Geometry::Surface(surface) => {
                    Ok(surface.split(direction, at)?.into_iter().map(Into::into).collect())
                }
                other => Err(not_a_spline(&name, other)),
            }
        };
        let mut names = vec![name.clone()];
        let mut cut = scene.clone();
        for _ in 1..pieces(object.geometry())?.len() {
            let fresh = cut.unique_name(&name);
            let mut twin = Object::sharing(fresh.clone(), object.shared_geometry().clone());
            twin.color = object.color;
            twin.layer.clone_from(&object.layer);
            twin.parent.clone_from(&object.parent);
            twin.transform = object.transform;
            twin.materials.clone_from(&object.materials);
            twin.animation.clone_from(&object.animation);
            cut.add(twin)?;
            names.push(fresh);
        }
        for (number, piece) in names.iter().enumerate() {
            cut.reshape(piece, |geometry| {
                let missing = || Error::Invalid(format!("\"{name}\" has no piece {number}"));
                pieces(geometry)?.into_iter().nth(number).ok_or_else(missing)
            })?;
        }
        *scene = cut;
        Ok(done("split", name, format!("pieces: {}", names.join(", "))))
    }
}
