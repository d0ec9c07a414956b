//! `extrude`: a region moved along a vector becomes a solid.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_names,
};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::figure;

use super::{
    ANGLE, BRIDGE, Chords, MIN_ANGLE, NAME, Near, OBJECTS, SIZE, TOLERANCE, fineness, finite, is_outline,
    like, refinement, result_name, tessellator, unrefined,
};
use crate::cap::{Capped, boundary_loops, cap, together};
use crate::fill::Refinement;
use crate::measure::{area, volume};
use crate::outline::outlines;

/// What is thinner than this part of its outlines is no solid: its two sides would be welded.
const THINNEST: f64 = 2e-11;

/// The operation `extrude`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extrude;

impl Operation for Extrude {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            OBJECTS,
            Field::required("by", "[x, y, z]", "the way that the region goes"),
            BRIDGE,
            TOLERANCE,
            ANGLE,
            SIZE,
            MIN_ANGLE,
            Field::optional("surfaces", "true | false", "false", "add the walls as exact surfaces, too"),
            NAME,
        ];
        Declaration {
            name: "extrude",
            help: "what closed planar curves bound, moved along a vector, becomes a closed mesh; reports its volume",
            fields: FIELDS,
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
        let by = parameters.vector("by")?;
        let name = result_name(scene, parameters, &objects[0], "solid")?;
        let tessellator = tessellator(context)?;
        let (fineness, refinement) = (fineness(parameters)?, refinement(parameters, true)?);
        let mut outlines = outlines(scene, &objects, parameters.flag("bridge")?)?;
        let size = outlines
            .iter()
            .map(|o| o.curve.bounds())
            .fold(0.0_f64, |m, (low, high)| m.max((high - low).amax()));
        if by.amax() < THINNEST * size {
            return Err(parameters
                .error(
                    "by",
                    format!(
                        "{:e} is nothing beside outlines of size {size}: give a longer vector",
                        by.norm(),
                        size = figure(size)
                    ),
                )
                .into());
        }
        let region = Chords::of(&outlines, tessellator, &fineness)?.fill(&Refinement::default())?;
        let normal = region.plane.normal();
        let height = by.dot(&normal);
        // Over its largest coordinate: no square overflows.
        let slope = (by / by.amax()).dot(&normal).abs();
        if slope.is_nan() || slope <= 1e-9 || !height.is_finite() {
            let problem = format!(
                "{:?} lies in the plane of \"{}\": the solid would have no volume; point out of the plane",
                by.as_slice(),
                objects[0]
            );
            return Err(parameters.error("by", problem).into());
        }
        // Walls face outward where the region lies to the left of the curve, seen against the way.
        for (outline, &left) in outlines.iter_mut().zip(&region.left) {
            if left != (height > 0.0) {
                outline.curve = outline.curve.reverse()?;
            }
        }
        let walls: Vec<Surface> =
            outlines.iter().map(|o| Surface::extrusion(&o.curve, by)).collect::<Result<_, _>>()?;
        let mut near = Near::default();
        let mut meshes = Vec::with_capacity(walls.len());
        for wall in &walls {
            let found = tessellator.measured_surface(wall, &fineness)?;
            near = near.and(found.error, found.tolerance);
            meshes.push(found.mesh);
        }
        let mesh = together(&meshes)?;
        let loops = boundary_loops(&mesh, &objects[0])?;
        let base = outlines[0].curve.points()[0];
        let is_top = |ring: &[u32]| {
            ring.first().is_some_and(|&i| (mesh.points()[i as usize] - base).dot(&normal) / height > 0.5)
        };
        let (top, bottom): (Vec<&[u32]>, Vec<&[u32]>) =
            loops.iter().map(Vec::as_slice).partition(|ring| is_top(ring));
        let Capped { mesh: solid, refined } = cap(&mesh, &[("bottom", bottom), ("top", top)], &refinement)?;
        let mut notes = vec![format!("\"{name}\": {} faces, closed", solid.face_count())];
        notes.extend(unrefined(refined));
        let (area, volume) = (finite("the area", area(&solid))?, finite("the volume", volume(&solid))?);
        let mut report = StepReport {
            op: "extrude".into(),
            object: Some(name.clone()),
            area: Some(area),
            volume: Some(volume),
            ..StepReport::default()
        };
        near.tell(&mut report, scene, &solid, "exact walls");
        let mut added = vec![like(scene, &objects[0], &name, solid)];
        if parameters.flag("surfaces")? {
            for (wall, outline) in walls.into_iter().zip(&outlines) {
                let wall_name = format!("{} wall", outline.name);
                notes.push(format!("\"{wall_name}\": exact surface"));
                added.push(Object::new(wall_name, wall.into()));
            }
        }
        add_all(scene, added)?;
        report.notes.splice(0..0, notes);
        Ok(report)
    }
}

/// Adds objects, or none of them.
pub(super) fn add_all(scene: &mut Scene, objects: Vec<Object>) -> Result<(), OperationError> {
    let mut added: Vec<String> = Vec::with_capacity(objects.len());
    for object in objects {
        let name = object.name().to_owned();
        if let Err(e) = scene.add(object) {
            for name in added.iter().rev() {
                scene.remove(name)?;
            }
            return Err(e.into());
        }
        added.push(name);
    }
    Ok(())
}
