//! What our own writer noted in a node's extras.

use loftsman_kernel::Error;
use loftsman_kernel::plugin::{Fate, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Animation, Geometry};

use super::file::parse;
use crate::extras::ExtrasFields;
use crate::words::EXTRAS;

/// What our writer noted about a node.
pub(super) fn own(path: &str, extras: &str, report: &mut ReadReport) -> Option<ExtrasFields> {
    #[derive(serde::Deserialize)]
    struct Extras {
        loftsman: String,
    }
    let text = serde_json::from_str::<Extras>(extras).ok()?.loftsman;
    match parse::<ExtrasFields>(&format!("{path}.extras.{EXTRAS}"), &text) {
        Ok(own) => Some(own),
        Err(error) => {
            report.count(Fate::LeftOut, "extras.loftsman that cannot be read: the mesh is taken instead");
            report.notes.push(error.to_string());
            None
        }
    }
}

/// The exact spline (or plug-in's shape) of a node and its exact frames, where its mesh, of that fingerprint, still
/// has the vertices that were written with it.
pub(super) fn exact(
    own: &ExtrasFields,
    shown: impl FnOnce() -> Option<String>,
    options: &ReadOptions<'_>,
    report: &mut ReadReport,
) -> Option<(Geometry, Option<Animation>)> {
    let exact = own.exact(options)?;
    // What was shown by nothing has no fingerprint.
    if own.shown_by.is_some() && own.shown_by != shown() {
        let reason = "exact spline whose mesh was changed since: the mesh is taken instead";
        report.count(Fate::LeftOut, reason);
        return None;
    }
    match exact {
        Ok(geometry) => {
            let count = geometry.points().len();
            let animation = own.animation.as_ref().and_then(|a| a.make(count));
            report.count(Fate::Kept, "");
            Some((geometry, animation))
        }
        Err(Error::UnknownKind { kind }) => {
            let kind = loftsman_kernel::text::clip(&kind);
            let reason =
                format!("shape of the kind \"{kind}\", whose plug-in is not here: the mesh is taken instead");
            report.count(Fate::LeftOut, &reason);
            None
        }
        Err(error) => {
            report.count(
                Fate::LeftOut,
                &format!("exact spline that cannot be: {error}; the mesh is taken instead"),
            );
            None
        }
    }
}
