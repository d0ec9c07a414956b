//! `patches`: a subdivision surface becomes bicubic splines, in recipes.

use loftsman_kernel::error::Error;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::text::{a, counted};

use crate::own::{Own, surface};

/// The operation `patches`: [`SubdivisionSurface::patches`](crate::SubdivisionSurface::patches) and
/// [`DooSabinSurface::patches`](crate::doo_sabin::DooSabinSurface::patches) as objects.
#[derive(Debug, Clone, Copy, Default)]
pub struct ToPatches;

/// The tolerance as a part of the surface's size, where none is given: that of `tessellate`.
const PART: f64 = 1e-3;

impl Operation for ToPatches {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only subdivision surface", "the object"),
            Field::optional(
                "tolerance",
                "length",
                "1/1000 of its size",
                "largest distance from the surface, round extraordinary points",
            ),
        ];
        Declaration {
            name: "patches",
            help: "a subdivision surface becomes a group of spline surfaces",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = object_name(scene, parameters, |g| surface(g).is_some(), "subdivision surface")?;
        let object = scene.object(&name)?.clone();
        let Some(own) = surface(object.geometry()) else {
            let problem =
                format!("\"{name}\" is {}, not a subdivision surface", a(&object.geometry().noun()));
            return Err(parameters.error("object", problem).into());
        };
        let tolerance =
            if parameters.has("tolerance") { parameters.number("tolerance")? } else { PART * own.size()? };
        let named = |e: String| Error::Invalid(format!("\"{name}\" cannot be made of patches: {e}"));
        let patches = own.patches(tolerance).map_err(|e| match parameters.has("tolerance") {
            true => parameters.error("tolerance", e.to_string()).into(),
            false => OperationError::from(named(e.to_string())),
        })?;
        let count = patches.surfaces.len();
        let longer = scene.standing(&name)?.most();
        let placed = in_own_coordinates(scene, &name, parameters, &[], &["tolerance"])?;
        let mut made = scene.clone();
        made.replace(&name, Geometry::Group)?;
        for patch in patches.surfaces {
            let mut part = Object::new(made.unique_name(&name), patch.into());
            (part.color, part.parent) = (object.color, Some(name.clone()));
            part.layer.clone_from(&object.layer);
            part.materials.clone_from(&object.materials);
            made.add(part)?;
        }
        *scene = made;
        let near = scene.unit.quantity(longer * patches.deviation, 1);
        let told = match (&own, count - patches.exact) {
            (Own::CatmullClark(_), 0) => counted(count, "bicubic surface[|s], [|all ]exact"),
            (Own::CatmullClark(_), last) => {
                let all = counted(count, "bicubic surface[|s]");
                format!("{all}, {} exactly, {last} within {near}", patches.exact)
            }
            (Own::DooSabin(_), 0) => counted(count, "biquadratic surface[|s], [|all ]exact"),
            (Own::DooSabin(_), last) => {
                let all = counted(count, "surface[|s]");
                format!("{all}, {} biquadratic exactly, {last} bicubic within {near}", patches.exact)
            }
        };
        Ok(StepReport {
            op: "patches".into(),
            object: Some(name),
            notes: std::iter::once(told).chain(placed).collect(),
            ..StepReport::default()
        })
    }
}
