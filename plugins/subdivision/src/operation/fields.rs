//! What fields say of the edges, vertices and faces of a mesh.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{OperationError, ParameterError, Parameters};

use crate::said::Once;
use crate::{BoundaryRule, Cage, SubdivisionError};

/// The mesh as a control cage, with what the fields say of its edges, vertices and faces. Intervals belong to edges, or, where it is not to be
/// `smooth` as Catmull and Clark's, to their ends.
pub(super) fn cage(parameters: &Parameters, mesh: &Mesh, smooth: bool) -> Result<Cage, OperationError> {
    const RULES: [(&str, BoundaryRule); 2] =
        [("edge-and-corner", BoundaryRule::EdgeAndCorner), ("edge-only", BoundaryRule::EdgeOnly)];
    let mut cage = Cage::from_mesh(mesh)?;
    cage.check_shape()?;
    if parameters.has("boundary") {
        cage = cage.with_boundary(parameters.choice("boundary", &RULES)?);
    }
    let said = |error: SubdivisionError, name: &str| parameters.error(name, error.to_string());
    let mut once = Once::new("sharpness");
    for (k, [from, to, sharpness]) in lists(parameters, "creases")?.into_iter().enumerate() {
        let name = format!("creases[{k}]");
        let (from, to) = (index(parameters, &name, from)?, index(parameters, &name, to)?);
        once.say(&[from, to], sharpness).map_err(|error| said(error, &name))?;
        cage = cage.with_crease(from, to, sharpness).map_err(|error| said(error, &name))?;
    }
    for (k, [vertex, sharpness]) in lists(parameters, "corners")?.into_iter().enumerate() {
        let name = format!("corners[{k}]");
        let vertex = index(parameters, &name, vertex)?;
        once.say(&[vertex], sharpness).map_err(|error| said(error, &name))?;
        cage = cage.with_corner(vertex, sharpness).map_err(|error| said(error, &name))?;
    }
    let mut once = Once::new("interval");
    for (k, [from, to, interval]) in lists(parameters, "intervals")?.into_iter().enumerate() {
        let name = format!("intervals[{k}]");
        let (from, to) = (index(parameters, &name, from)?, index(parameters, &name, to)?);
        if smooth {
            once.say(&[from, to], interval).map_err(|error| said(error, &name))?;
            cage = cage.with_interval(from, to, interval).map_err(|error| said(error, &name))?;
        } else {
            once.say_towards(from, to, interval).map_err(|error| said(error, &name))?;
            cage = cage.with_end_interval(from, to, interval).map_err(|error| said(error, &name))?;
        }
    }
    if parameters.has("holes") {
        for face in parameters.numbers("holes")? {
            let face = index(parameters, "holes", face)?;
            cage = cage.with_hole(face).map_err(|error| said(error, "holes"))?;
        }
        if (0..mesh.face_count()).all(|face| cage.is_hole(face)) {
            let problem = format!(
                "all {} faces are holes, so that nothing would be left: leave one",
                mesh.face_count()
            );
            return Err(parameters.error("holes", problem).into());
        }
    }
    Ok(cage)
}

/// A field of lists of `N` numbers.
fn lists<const N: usize>(parameters: &Parameters, name: &str) -> Result<Vec<[f64; N]>, ParameterError> {
    if !parameters.has(name) {
        return Ok(Vec::new());
    }
    let numbers = |(k, list): (usize, &serde_json::Value)| {
        let all = list
            .as_array()
            .and_then(|list| list.iter().map(serde_json::Value::as_f64).collect::<Option<Vec<_>>>());
        let fits = all.and_then(|all| <[f64; N]>::try_from(all).ok());
        fits.ok_or_else(|| {
            parameters.error(&format!("{name}[{k}]"), format!("a list of {N} numbers is needed"))
        })
    };
    parameters.list(name)?.iter().enumerate().map(numbers).collect()
}

/// A number of a vertex or face.
pub(super) fn index(parameters: &Parameters, name: &str, value: f64) -> Result<usize, ParameterError> {
    if value >= 0.0 && value.fract() == 0.0 && value < 4e9 {
        return Ok(value as usize);
    }
    Err(parameters.error(name, format!("{value} is no number of a vertex or face: these are 0, 1, 2, …")))
}
