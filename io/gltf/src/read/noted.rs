//! What our own writer noted in a node's extras.

use loftsman_kernel::plugin::{Fate, ReadReport};
use loftsman_kernel::scene::{Animation, Geometry};

use super::file::{File, parse};
use crate::extras::{Own, fingerprint};
use crate::words::EXTRAS;

/// An exact spline and its exact frames.
pub(super) struct Exact {
    pub(super) geometry: Geometry,
    pub(super) animation: Option<Animation>,
}

/// What our writer noted about a node.
pub(super) fn own(file: &File<'_>, path: &str, extras: &str, report: &mut ReadReport) -> Option<Own> {
    #[derive(serde::Deserialize)]
    struct Extras {
        loftsman: String,
    }
    let text = serde_json::from_str::<Extras>(extras).ok()?.loftsman;
    match parse::<Own>(file.name, &format!("{path}.extras.{EXTRAS}"), &text) {
        Ok(own) => Some(own),
        Err(error) => {
            report.count(Fate::LeftOut, "extras.loftsman that cannot be read: the mesh is taken instead");
            report.notes.push(error.to_string());
            None
        }
    }
}

/// The exact spline of a node, where its mesh still has the vertices that were written with it.
pub(super) fn exact(own: &Own, shown: Option<&Geometry>, report: &mut ReadReport) -> Option<Exact> {
    let spline = own.spline()?;
    let positions =
        |g: &Geometry| fingerprint(g.points().iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]));
    // What was shown by nothing has no fingerprint.
    if own.shown_by.is_some() && own.shown_by != shown.map(positions) {
        let reason = "exact spline whose mesh was changed since: the mesh is taken instead";
        report.count(Fate::LeftOut, reason);
        return None;
    }
    match spline {
        Ok(geometry) => {
            let count = geometry.points().len();
            let animation = own.animation.as_ref().and_then(|a| a.make(count));
            report.count(Fate::Kept, "");
            Some(Exact { geometry, animation })
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
