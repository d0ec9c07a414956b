//! `loft`: closed sections become a solid.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport,
};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::Curve;

use super::extrude::add_all;
use super::{
    ANGLE, BRIDGE, MIN_ANGLE, NAME, SIZE, TOLERANCE, fineness, like, refinement, result_name, tessellator,
    texts, unrefined,
};
use crate::cap::{boundary_loops, cap};
use crate::error::RegionError;
use crate::measure::{area, volume};
use crate::outline::outlines;

/// The operation `loft`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loft;

impl Operation for Loft {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required(
                "sections",
                "[text, …]",
                "closed curves or polylines, two at least, in their order",
            ),
            Field::optional(
                "degree",
                "1 to 25",
                "3, or less with few sections",
                "the degree from section to section",
            ),
            Field::optional(
                "caps",
                "true | false",
                "true",
                "close the ends, whose sections must be planar then; a solid's volume is reported",
            ),
            Field::optional("surface", "true | false", "false", "add the exact surface, too"),
            BRIDGE,
            TOLERANCE,
            ANGLE,
            SIZE,
            MIN_ANGLE,
            NAME,
        ];
        Declaration {
            name: "loft",
            help: "a surface through closed sections, with caps at its ends, becomes a closed mesh",
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
        let objects = texts(parameters, "sections")?;
        let name = result_name(scene, parameters, &objects[0], "loft")?;
        let caps = !parameters.has("caps") || parameters.flag("caps")?;
        let bridge = parameters.flag("bridge")?;
        // One by one: open curves must not be joined across sections.
        let mut sections: Vec<Curve> = Vec::with_capacity(objects.len());
        for object in &objects {
            sections
                .extend(outlines(scene, std::slice::from_ref(object), bridge)?.into_iter().map(|o| o.curve));
        }
        let surface = crate::loft::loft(&sections, parameters.count_or("degree", 3)?)?;
        let mut mesh = tessellator(context)?.surface(&surface, &fineness(parameters)?)?;
        let (mut volume_of, mut refined) = (None, true);
        if caps {
            let loops = boundary_loops(&mesh, &objects[0])?;
            let [first, last] = loops.as_slice() else {
                return Err(RegionError::Sections(format!(
                    "the loft has {} open ends, where caps need two: give sections that bound an area, or caps = false",
                    loops.len()
                ))
                .into());
            };
            // The surface's v starts at the first section.
            let start = surface.point(surface.u().domain().0, surface.v().domain().0)?;
            let near = |ring: &[u32]| {
                let distances = ring.iter().map(|&i| (mesh.points()[i as usize] - start).norm_squared());
                distances.fold(f64::INFINITY, f64::min)
            };
            let swapped = near(first) > near(last);
            let (first, last) = if swapped { (last, first) } else { (first, last) };
            let capped =
                cap(&mesh, &[("start", vec![first]), ("end", vec![last])], &refinement(parameters, true)?)?;
            (mesh, refined) = (capped.mesh, capped.refined);
            let mut enclosed = volume(&mesh);
            if enclosed < 0.0 {
                mesh.turn_inside_out();
                enclosed = -enclosed;
            }
            volume_of = Some(enclosed);
        }
        let mut notes = vec![format!(
            "\"{name}\": {} faces through {} sections{}",
            mesh.face_count(),
            sections.len(),
            if caps { ", closed" } else { "" }
        )];
        notes.extend(unrefined(refined));
        let area = area(&mesh);
        let mut added = vec![like(scene, &objects[0], &name, mesh)];
        if parameters.flag("surface")? {
            let exact = format!("{name} surface");
            notes.push(format!("\"{exact}\": exact surface"));
            added.push(Object::new(exact, surface.into()));
        }
        add_all(scene, added)?;
        Ok(StepReport {
            op: "loft".into(),
            object: Some(name),
            area: Some(area),
            volume: volume_of,
            notes,
            ..StepReport::default()
        })
    }
}
