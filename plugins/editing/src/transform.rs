//! `transform`: an affine map of an object's points.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use nalgebra::{Matrix4, Rotation3, Unit};

/// The operation `transform`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Transform;

impl Operation for Transform {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only object", "the object to move"),
            Field::optional(
                "matrix",
                "4 rows of 4 numbers",
                "none",
                "the whole affine map; the last row is 0 0 0 1",
            ),
            Field::optional("scale", "number or [x, y, z]", "1", "scaled first, about the origin"),
            Field::optional(
                "rotate",
                "{ axis = [x, y, z], degrees, about = [x, y, z] }",
                "none",
                "then rotated",
            ),
            Field::optional("translate", "[x, y, z]", "none", "then translated"),
        ];
        Declaration { name: "transform", help: "move, turn or scale an object's points", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let name = object_name(scene, p, |g| !matches!(g, Geometry::Group), "object")?;
        let map = map(p)?;
        let object = scene.object(&name)?;
        let moved = object.geometry.transformed(&map)?;
        let animation = object.animation.clone();
        scene.replace(&name, moved)?;
        if let Some(mut animation) = animation {
            for point in animation.frames.iter_mut().flatten() {
                *point = loftsman_kernel::placement::transform_point(&map, point);
            }
            scene.object_mut(&name)?.animation = Some(animation);
        }
        Ok(StepReport { op: "transform".into(), object: Some(name), ..StepReport::default() })
    }
}

fn map(p: &Parameters) -> Result<Matrix4<f64>, ParameterError> {
    let parts = ["scale", "rotate", "translate"].into_iter().filter(|n| p.has(n)).count();
    if p.has("matrix") {
        if parts > 0 {
            return Err(p.error("matrix", "the matrix is the whole map: give it alone"));
        }
        return matrix(p);
    }
    if parts == 0 {
        return Err(p.error("", "give a matrix, or one of scale, rotate, translate"));
    }
    let mut map = Matrix4::identity();
    if p.has("scale") {
        let factors = match p.value("scale") {
            Some(v) if v.is_array() => p.vector("scale")?,
            _ => Vector::repeat(p.number("scale")?),
        };
        if factors.iter().any(|f| *f == 0.0) {
            return Err(p.error("scale", "a factor of 0 flattens the object: give another"));
        }
        map = Matrix4::new_nonuniform_scaling(&factors);
    }
    if p.has("rotate") {
        const FIELDS: [Field; 3] = [
            Field::required("axis", "[x, y, z]", "the axis"),
            Field::required("degrees", "number", "the angle, right-handed"),
            Field::optional("about", "[x, y, z]", "[0, 0, 0]", "a point of the axis"),
        ];
        let rotate = p.table("rotate")?;
        rotate.check(&FIELDS)?;
        let axis = Unit::try_new(rotate.vector("axis")?, 0.0)
            .ok_or_else(|| rotate.error("axis", "the zero vector is no axis: give a direction"))?;
        let about = if rotate.has("about") { rotate.vector("about")? } else { Vector::zeros() };
        let turn = Rotation3::from_axis_angle(&axis, rotate.number("degrees")?.to_radians()).to_homogeneous();
        map = Matrix4::new_translation(&about) * turn * Matrix4::new_translation(&-about) * map;
    }
    if p.has("translate") {
        map = Matrix4::new_translation(&p.vector("translate")?) * map;
    }
    Ok(map)
}

fn matrix(p: &Parameters) -> Result<Matrix4<f64>, ParameterError> {
    let wrong = || p.error("matrix", "4 rows of 4 finite numbers are needed");
    let rows = p.list("matrix")?;
    let numbers: Vec<f64> = rows
        .iter()
        .flat_map(|row| row.as_array().into_iter().flatten())
        .map(|v| v.as_f64().filter(|n| n.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    if rows.len() != 4 || rows.iter().any(|r| r.as_array().map(Vec::len) != Some(4)) {
        return Err(wrong());
    }
    if numbers[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(p.error("matrix", "the last row must be [0, 0, 0, 1]: only affine maps keep splines"));
    }
    Ok(Matrix4::from_row_slice(&numbers))
}
