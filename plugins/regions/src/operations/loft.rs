//! `loft`: closed sections become a solid.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_names,
};
use loftsman_kernel::scene::{Object, Scene};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::extrude::add_all;
use super::{
    ANGLE, BRIDGE, MIN_ANGLE, NAME, Near, SIZE, TOLERANCE, fineness, finite, is_outline, like, refinement,
    result_name, tessellator, unrefined,
};
use crate::cap::{boundary_loops, cap};
use crate::error::RegionError;
use crate::loft::Lofted;
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
                "closed curves or polylines, two at least, in their order (\"frame*\" is all whose names begin so, in the scene's); which way they run and where they start does not matter",
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
        let objects = object_names(scene, parameters, "sections", is_outline)?;
        let name = result_name(scene, parameters, &objects[0], "loft")?;
        let caps = !parameters.has("caps") || parameters.flag("caps")?;
        let bridge = parameters.flag("bridge")?;
        // One by one: open curves must not be joined across sections.
        let mut sections: Vec<Curve> = Vec::with_capacity(objects.len());
        for object in &objects {
            sections
                .extend(outlines(scene, std::slice::from_ref(object), bridge)?.into_iter().map(|o| o.curve));
        }
        if caps && sections.len() > 1 && in_one_plane(&sections) {
            return Err(parameters
                .error(
                    "sections",
                    format!(
                        "\"{}\" and all others lie in one plane: the solid would have no volume; move them apart, or \
                         say caps = false",
                        objects[0]
                    ),
                )
                .into());
        }
        let degree = parameters.count_or("degree", 3)?;
        let lofted = crate::loft::loft(&sections, degree)?;
        let surface = lofted.surface.clone();
        let found = tessellator(context)?.measured_surface(&surface, &fineness(parameters)?)?;
        let near = Near::default().and(found.error, found.tolerance);
        let mut mesh = found.mesh;
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
            if !boundary_loops(&mesh, &objects[0])?.is_empty() {
                return Err(RegionError::Sections(
                    "the caps do not close the loft: give other sections at its ends, or caps = false".into(),
                )
                .into());
            }
            let mut enclosed = volume(&mesh);
            if enclosed < 0.0 {
                mesh.turn_inside_out();
                enclosed = -enclosed;
            }
            // What a tenfold rounding of a flat one adds up to is no volume.
            let rounding = 10.0 * f64::EPSILON * area(&mesh) * extent(&mesh);
            if !(enclosed > rounding && enclosed.is_finite()) {
                return Err(RegionError::Sections(format!(
                    "the loft bounds a volume of {enclosed:e}, which numbers cannot tell from none: move the sections \
                     apart, or say caps = false"
                ))
                .into());
            }
            volume_of = Some(enclosed);
        }
        let mut notes = vec![format!(
            "\"{name}\": {} faces through {} sections{}",
            mesh.face_count(),
            sections.len(),
            if caps { ", closed" } else { "" }
        )];
        if parameters.has("degree") && degree > surface.v().degree() {
            notes.push(format!("degree {}: {} sections give no more", surface.v().degree(), sections.len()));
        }
        notes.extend(changes(&lofted, &objects));
        notes.extend(unrefined(refined));
        let area = finite("the area", area(&mesh))?;
        let mut report = StepReport {
            op: "loft".into(),
            object: Some(name.clone()),
            area: Some(area),
            volume: volume_of,
            ..StepReport::default()
        };
        near.tell(&mut report, scene, &mesh, "exact surface");
        let mut added = vec![like(scene, &objects[0], &name, mesh)];
        if parameters.flag("surface")? {
            let exact = format!("{name} surface");
            notes.push(format!("\"{exact}\": exact surface"));
            added.push(Object::new(exact, surface.into()));
        }
        add_all(scene, added)?;
        report.notes.splice(0..0, notes);
        Ok(report)
    }
}

/// What was done to the sections, and where the loft is narrow.
fn changes<'a>(lofted: &'a Lofted, objects: &'a [String]) -> impl Iterator<Item = String> + 'a {
    let turned = lofted.sections.iter().zip(objects).filter_map(|(change, name)| {
        let start = format!(
            "starts {:.1} % further round, where it faces the start of the section before it",
            100.0 * change.turned
        );
        match (change.reversed, change.turned > 0.0) {
            (false, false) => None,
            (true, false) => {
                Some(format!("\"{name}\" runs the other way now, as the section before it does"))
            }
            (false, true) => Some(format!("\"{name}\" {start}")),
            (true, true) => {
                Some(format!("\"{name}\" runs the other way now, as the section before it does, and {start}"))
            }
        }
    });
    let narrow = lofted.narrow.map(|narrow| {
        let (before, next) = (&objects[narrow.after], &objects[narrow.after + 1]);
        format!(
            "between \"{before}\" and \"{next}\" it narrows to {:.2} of the smaller one's area: add a section there",
            narrow.share
        )
    });
    turned.chain(narrow)
}

/// Whether all vertices of all sections lie in the plane of the first one, to 1e-9 of their size.
fn in_one_plane(sections: &[Curve]) -> bool {
    let points = || sections.iter().flat_map(Curve::points);
    let Some(first) = sections.first() else { return false };
    let Some(origin) = first.points().first() else { return false };
    let size = points().fold(0.0_f64, |m, p| m.max((p - origin).amax()));
    let noise = points().fold(0.0_f64, |m, p| m.max(p.coords.amax())) * 16.0 * f64::EPSILON;
    // The widest triangle of the first section: it spans the plane whatever signs areas add up to.
    let arm = |p: &Point| (p - origin) / size;
    let far = first
        .points()
        .iter()
        .map(arm)
        .fold(Vector::zeros(), |far, a| if a.norm() > far.norm() { a } else { far });
    let across = first.points().iter().map(|p| far.cross(&arm(p)));
    let widest = across.fold(Vector::zeros(), |most, a| if a.norm() > most.norm() { a } else { most });
    let Some(normal) = widest.try_normalize(1e-12) else { return false };
    points().all(|p| arm(p).dot(&normal).abs() * size <= 1e-9 * size + noise)
}

/// The largest coordinate of a mesh, seen from its first point.
fn extent(mesh: &Mesh) -> f64 {
    let origin = mesh.points().first().copied().unwrap_or_default();
    mesh.points().iter().fold(0.0, |m, p| m.max((p - origin).amax()))
}
