//! `fine-tune` of the edges of meshes and polylines.

use loftsman_kernel::text::figure;
use std::collections::BTreeSet;

use loftsman_kernel::mesh::Layer;
use loftsman_kernel::plugin::{Field, OperationError, Parameters, StepReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::vertex_index;

use crate::Springs;

/// The edges of a mesh or a polyline scaled, and springs between its vertices.
pub(super) fn sprung(
    scene: &mut Scene,
    parameters: &Parameters,
    object: &str,
) -> Result<StepReport, OperationError> {
    const CURVES: [&str; 11] = [
        "alpha_u",
        "alpha_v",
        "direction",
        "ends",
        "range",
        "continuity",
        "through",
        "alpha_at",
        "constraints",
        "force",
        "solver",
    ];
    if let Some(name) = CURVES.into_iter().find(|name| parameters.has(name)) {
        return Err(parameters
            .error(name, "is for curves and surfaces: the edges of a mesh or a polyline are springs")
            .into());
    }
    let mut geometry = scene.object(object)?.geometry().clone();
    let (mut springs, count) = match &geometry {
        Geometry::Mesh(mesh) => (Springs::of_mesh(mesh), mesh.points().len()),
        Geometry::Polyline(line) => (Springs::of_polygon(line.points.len(), line.closed), line.points.len()),
        other => {
            let problem = format!("\"{object}\" is a {}: it has no edges to tune", other.kind());
            return Err(parameters.error("object", problem).into());
        }
    };
    match parameters.value("alpha") {
        Some(value) if value.is_array() => {
            const KNOWN: [Field; 2] = [
                Field::required("edge", "[vertex, vertex]", "the edge, by its ends, numbered from 0"),
                Field::required("value", "number", "what it is multiplied by"),
            ];
            let mut seen = BTreeSet::new();
            for table in parameters.tables("alpha")? {
                table.check(&KNOWN)?;
                let [a, b] = table.integers("edge")?[..] else {
                    return Err(table.error("edge", "two vertices [i, j] are needed").into());
                };
                let vertex = |v| vertex_index(v, count).map_err(|e| table.error("edge", e.to_string()));
                let (a, b) = (vertex(a)?, vertex(b)?);
                if !seen.insert([a.min(b), a.max(b)]) {
                    let problem = format!("the edge between {a} and {b} is named before: give it one value");
                    return Err(table.error("edge", problem).into());
                }
                springs
                    .scale([a, b], table.number("value")?)
                    .map_err(|e| table.error("edge", e.to_string()))?;
            }
        }
        _ => springs.scale_all(parameters.number("alpha")?),
    }
    for index in if parameters.has("lock") { parameters.integers("lock")? } else { Vec::new() } {
        let vertex = vertex_index(index, count).map_err(|e| parameters.error("lock", e.to_string()))?;
        springs.pin(vertex)?;
    }
    if parameters.flag("any_sign")? {
        springs.any_sign();
    }
    let sprung = springs.solve(geometry.points())?;
    match &mut geometry {
        Geometry::Mesh(mesh) => {
            mesh.points_mut().copy_from_slice(&sprung.points);
            mesh.normals = Layer::none();
            mesh.tangents = Layer::none();
        }
        Geometry::Polyline(line) => line.points = sprung.points,
        _ => {}
    }
    scene.replace(object, geometry)?;
    let strain = sprung.strain;
    Ok(StepReport {
        op: "fine-tune".into(),
        object: Some(object.into()),
        notes: vec![format!(
            "springs: the edges differ by {strain} of their lengths from what they are to be",
            strain = figure(strain)
        )],
        ..StepReport::default()
    })
}
