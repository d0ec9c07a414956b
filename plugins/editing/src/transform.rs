//! `transform`: an affine map of an object's points.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::{Point, Vector};
use nalgebra::{Matrix3, Matrix4, Rotation3, Unit};

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
        if let Geometry::Instance(_) = object.geometry() {
            // It has no points: its transform takes the map in.
            let moved = object.transform.unwrap_or_else(Matrix4::identity) * map;
            if !moved.iter().all(|x| x.is_finite()) {
                let problem =
                    format!("\"{name}\" would leave the numbers there are: scale or move it by less");
                return Err(p.error("", problem).into());
            }
            scene.object_mut(&name)?.transform = Some(moved);
            return Ok(StepReport { op: "transform".into(), object: Some(name), ..StepReport::default() });
        }
        let moved = object.geometry().transformed(&map)?;
        if extent(object.geometry().points()) > 0.0 && extent(moved.points()) == 0.0 {
            let problem = format!(
                "all points of \"{name}\" would come to lie in one place, since numbers of that size cannot tell them \
                 apart: scale or move it by less"
            );
            return Err(p.error("", problem).into());
        }
        // A mesh's faces are turned with it; a surface's normal is what its parameters say.
        let turned = match (object.geometry(), &moved) {
            (Geometry::Surface(_), Geometry::Surface(_)) => is_mirror(&map),
            _ => false,
        };
        let animation = object.animation.clone();
        let mut moved_frames = None;
        if let Some(mut animation) = animation {
            for (frame, points) in animation.frames.iter_mut().enumerate() {
                for point in points {
                    *point = loftsman_kernel::placement::transform_point(&map, point);
                    if !point.iter().all(|c| c.is_finite()) {
                        let problem = format!(
                            "frame {frame} of \"{name}\" would leave the numbers there are: scale by less"
                        );
                        return Err(p.error("", problem).into());
                    }
                }
            }
            moved_frames = Some(animation);
        }
        scene.replace(&name, moved)?;
        scene.object_mut(&name)?.animation = moved_frames;
        let note = "it is a mirror image, so that its normals point to the other side of it: `reverse` turns them back";
        let notes = turned.then(|| note.to_owned()).into_iter().collect();
        Ok(StepReport { op: "transform".into(), object: Some(name), notes, ..StepReport::default() })
    }
}

/// Whether a map makes a right hand a left one.
fn is_mirror(map: &Matrix4<f64>) -> bool {
    // Row by row over its largest number: the sign is the same, and products neither overflow nor vanish.
    let mut linear: Matrix3<f64> = map.fixed_view::<3, 3>(0, 0).into_owned();
    for mut row in linear.row_iter_mut() {
        let largest = row.amax();
        if largest > 0.0 {
            row /= largest;
        }
    }
    linear.determinant() < 0.0
}

/// The longest side of the box of points; infinite where it overflows.
fn extent(points: &[Point]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).amax()
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
        // Over its largest coordinate first: its length does not matter, whatever that is.
        let axis = rotate.vector("axis")?;
        let axis = Unit::try_new(axis / axis.amax(), 0.0)
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
    let map = Matrix4::from_row_slice(&numbers);
    if flattens(&map.fixed_view::<3, 3>(0, 0).into_owned()) {
        return Err(p.error(
            "matrix",
            "its three columns lie in one plane (or are zero): it flattens the object; give columns that span space",
        ));
    }
    Ok(map)
}

/// Whether a linear map takes space to a plane, a line or a point, to rounding of its entries.
///
/// Rows, then columns, are brought to a largest entry of 1 first: a map that scales the axes differently, however much,
/// flattens nothing.
fn flattens(map: &Matrix3<f64>) -> bool {
    let mut map = *map;
    for _ in 0..2 {
        for mut row in map.row_iter_mut() {
            let largest = row.amax();
            if largest == 0.0 {
                return true;
            }
            row.iter_mut().for_each(|x| *x /= largest);
        }
        map.transpose_mut();
    }
    map.determinant().abs() <= 16.0 * f64::EPSILON
}
