//! `subdivide` of a subdivision surface: its cage as a mesh, as it is or refined.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{OperationError, Parameters};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::text::counted;

use super::{by_doo_sabin, check_size, put_at};
use crate::own::Own;
use crate::used::used;
use crate::{Cage, Result, catmull_clark};

/// The mesh of the surface's cage, refined so many times by its own scheme, and what there is to say of it.
pub(super) fn meshed(
    parameters: &Parameters,
    own: &Own<'_>,
    levels: usize,
) -> std::result::Result<(Geometry, String), OperationError> {
    const OF_MESHES: [&str; 10] = [
        "scheme",
        "surface",
        "creases",
        "corners",
        "weld",
        "holes",
        "boundary",
        "intervals",
        "alpha",
        "lock",
    ];
    if let Some(name) = OF_MESHES.into_iter().find(|name| parameters.has(name)) {
        let problem = "is for meshes, and this is a subdivision surface, whose cage has its own: give levels (0 is the cage itself), or limit";
        return Err(parameters.error(name, problem).into());
    }
    let cage = own.cage();
    let corners = cage.topology().corner_count() as f64;
    check_size(parameters, levels, corners * 4.0_f64.powf(levels as f64 - 1.0), "faces")?;
    let limit = parameters.flag("limit")?;
    let mesh = match own {
        Own::CatmullClark(_) => by_catmull_clark(cage, levels, limit)?,
        Own::DooSabin(_) => by_doo_sabin(cage, levels, limit)?,
    };
    let mesh = used(mesh)?;
    let what = if levels == 0 { "its cage" } else { "its cage refined" };
    let note = format!(
        "{what} as a mesh of {} and {}{}{}",
        counted(mesh.points().len(), "point[|s]"),
        counted(mesh.face_count(), "face[|s]"),
        if limit { ", where the surface comes to" } else { "" },
        left_out(cage)
    );
    Ok((mesh.into(), note))
}

fn by_catmull_clark(cage: &Cage, levels: usize, limit: bool) -> Result<Mesh> {
    let fine = catmull_clark::refine_times(cage, levels)?;
    let mut mesh = fine.to_mesh()?;
    if limit {
        let frames = catmull_clark::limit_frames(&fine)?;
        put_at(&mut mesh, &frames);
        mesh.normals = catmull_clark::limit_normals(&fine, &frames)?;
    }
    Ok(mesh)
}

/// What of a cage a mesh has no place for.
fn left_out(cage: &Cage) -> String {
    let sharp = |all: &[f64]| all.iter().any(|s| *s > 0.0);
    let named = [
        (sharp(&cage.creases), "creases"),
        (sharp(&cage.corners), "corners"),
        (cage.holes.contains(&true), "holes (not there now)"),
        (cage.has_intervals() || cage.has_end_intervals(), "knot intervals"),
    ];
    let named: Vec<&str> = named.into_iter().filter(|(is, _)| *is).map(|(_, name)| name).collect();
    if named.is_empty() {
        return String::new();
    }
    format!("; left out, for which a mesh has no place: {}", named.join(", "))
}
