//! What is left out, or cut, and why.

use loftsman_kernel::Error;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::Written;

/// Why something could not be cut.
pub(super) fn untold(error: &Error) -> String {
    match error {
        Error::NoExtent(problem) => problem.clone(),
        error => format!("it could not be tessellated: {error}"),
    }
}

/// Says that larger faces are cut.
pub(super) fn cut(mesh: &Mesh, report: &mut Written) {
    if mesh.faces().any(|f| f.len() > 3) {
        report.change("glTF has triangles only: larger faces were cut");
    }
}

/// Why a mesh is left out of which all faces are cut away.
pub(super) const UNSEEN: &str = "it has nothing that could be seen";
