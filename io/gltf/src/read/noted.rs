//! What our own writer noted in a node's extras.

use loftsman_kernel::Error;
use loftsman_kernel::placement::{Change, transform_point};
use loftsman_kernel::plugin::{Fate, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Animation, Geometry, Unit, Up};
use serde::Deserialize;

use super::file::parse;
use super::schema::Raw;
use crate::extras::ExtrasFields;
use crate::words::EXTRAS;

/// The unit and axis up of what nodes note.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frames {
    /// Of nodes that do not say theirs: what the file notes, or what glTF has.
    pub(super) of_file: (Unit, Up),
    /// In which the scene is read.
    pub(super) of_scene: (Unit, Up),
}

impl Frames {
    /// From the numbers that were noted of a node to those of the scene.
    pub(super) fn change(&self, own: &ExtrasFields) -> Change {
        let (unit, up) = self.of_file;
        Change::between((own.unit.unwrap_or(unit), own.up.unwrap_or(up)), self.of_scene)
    }
}

/// The unit and axis that all nodes note which note any: that of a file of ours that came through a program which keeps what
/// belongs to nodes and nothing else.
pub(super) fn common(nodes: &[Raw<'_>], report: &mut ReadReport) -> Option<(Unit, Up)> {
    #[derive(Deserialize)]
    struct Node {
        extras: Extras,
    }
    #[derive(Deserialize)]
    struct Extras {
        loftsman: String,
    }
    #[derive(Deserialize)]
    struct Frame {
        unit: Unit,
        up: Up,
    }
    let mut found = nodes.iter().filter_map(|node| {
        let text = serde_json::from_str::<Node>(node.get()).ok()?.extras.loftsman;
        serde_json::from_str::<Frame>(&text).ok().map(|frame| (frame.unit, frame.up))
    });
    let first = found.next()?;
    let Some(other) = found.find(|other| *other != first) else { return Some(first) };
    let told = |(unit, up): (Unit, Up)| format!("{} with {} up", unit.name(), up.name());
    report.notes.push(format!(
        "exact splines of the file were noted in {} and in {}: all is read in metres with y up, as glTF has it",
        told(first),
        told(other)
    ));
    None
}

/// What our writer noted about a node.
pub(super) fn own(path: &str, extras: &str, report: &mut ReadReport) -> Option<ExtrasFields> {
    #[derive(Deserialize)]
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

/// What stands in a file beside an exact spline.
pub(super) enum Beside {
    /// A mesh, of that fingerprint where there is one.
    Mesh(Option<String>),
    /// No mesh at all. What is changed has one: then there was nothing to show, or whoever passed the file on left it out, as
    /// Blender does with lines unless it is told otherwise.
    Nothing,
}

/// The exact spline (or plug-in's shape) of a node and its exact frames, changed to the scene's unit and axes, where its mesh
/// still has the vertices that were written with it.
pub(super) fn exact(
    own: &ExtrasFields,
    beside: Beside,
    change: &Change,
    options: &ReadOptions<'_>,
    report: &mut ReadReport,
) -> Option<(Geometry, Option<Animation>)> {
    let exact = own.exact(options)?;
    let instead = match beside {
        Beside::Mesh(_) => "the mesh is taken instead",
        Beside::Nothing => "nothing is there instead",
    };
    // What was shown by nothing has no fingerprint.
    if let (Beside::Mesh(shown), Some(noted)) = (&beside, &own.shown_by)
        && shown.as_ref() != Some(noted)
    {
        report.count(Fate::LeftOut, &format!("exact spline whose mesh was changed since: {instead}"));
        return None;
    }
    let map = change.map();
    let exact = if change.is_none() { exact } else { exact.and_then(|exact| exact.transformed(&map)) };
    match exact {
        Ok(geometry) => {
            let count = geometry.points().len();
            let mut animation = own.animation.as_ref().and_then(|a| a.make(count));
            if !change.is_none() {
                let frames = animation.iter_mut().flat_map(|animation| &mut animation.frames);
                frames.flatten().for_each(|p| *p = transform_point(&map, p));
            }
            report.count(Fate::Kept, "");
            Some((geometry, animation))
        }
        Err(Error::UnknownKind { kind }) => {
            let kind = loftsman_kernel::text::clip(&kind);
            let reason = format!("shape of the kind \"{kind}\", whose plug-in is not here: {instead}");
            report.count(Fate::LeftOut, &reason);
            None
        }
        Err(error) => {
            report.count(Fate::LeftOut, &format!("exact spline that cannot be: {error}; {instead}"));
            None
        }
    }
}
