//! `fill`: what closed curves bound becomes a mesh.

use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{
    Context, Declaration, Operation, OperationError, Parameters, StepReport, object_names,
};
use loftsman_kernel::scene::Scene;

use super::{
    ANGLE, BRIDGE, Chords, MIN_ANGLE, NAME, OBJECTS, SIZE, TOLERANCE, fineness, finite, is_outline, like,
    refinement, result_name, tessellator, unrefined,
};
use crate::measure::area;
use crate::outline::outlines;
use loftsman_kernel::text::counted;

/// The operation `fill`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fill;

impl Operation for Fill {
    fn declaration(&self) -> Declaration {
        Declaration {
            name: "fill",
            help: "what closed planar curves bound becomes a mesh, inner curves its holes",
            fields: &[OBJECTS, BRIDGE, TOLERANCE, ANGLE, SIZE, MIN_ANGLE, NAME],
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        parameters: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        parameters.check(self.declaration().fields)?;
        let objects = object_names(scene, parameters, "objects", is_outline)?;
        let name = result_name(scene, parameters, &objects[0], "face")?;
        let outlines = outlines(scene, &objects, parameters.flag("bridge")?)?;
        let chords = Chords::of(&outlines, tessellator(context)?, &fineness(parameters)?)?;
        let filled = chords.fill(&refinement(parameters, false)?)?;
        let near = chords.near;
        let mut points = chords.points;
        points.extend(&filled.added);
        let corners = filled.triangles.iter().flatten().copied().collect();
        let starts = (0..=filled.triangles.len()).map(|f| 3 * f).collect();
        let uvs = points.iter().map(|p| filled.plane.flatten(p).map(|x| x + 0.5)).collect();
        let normals = vec![filled.plane.normal(); points.len()];
        let mut mesh = Mesh::from_parts(points, corners, starts)?;
        (mesh.normals, mesh.uvs) = (Layer::per_point(normals), Layer::per_point(uvs));
        let area = finite("the area", area(&mesh))?;
        let count = outlines.len();
        let mut notes = vec![format!(
            "\"{name}\": {}, {}",
            counted(mesh.face_count(), "triangle[|s]"),
            counted(count, "outline[|s]")
        )];
        notes.extend(unrefined(filled.refined));
        let mut report = StepReport {
            op: "fill".into(),
            object: Some(name.clone()),
            area: Some(area),
            notes,
            ..StepReport::default()
        };
        near.tell(&mut report, scene, &mesh, "curves");
        let object = like(scene, &objects[0], &name, mesh);
        scene.add(object)?;
        Ok(report)
    }
}
