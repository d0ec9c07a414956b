//! Counting what is left out.

use std::collections::BTreeMap;

use loftsman_kernel::plugin::{Fate, ReadReport};

use serde::de::IgnoredAny;

use super::file::clip;
use super::schema::{Extensions, Raw};
use crate::words::EXTRAS;

/// Counts data of other programs. Ours is read elsewhere; names of morph targets only number them.
pub(super) fn extras(extras: Option<Raw<'_>>, of: &str, report: &mut ReadReport) {
    let Some(extras) = extras else { return };
    let fields: Option<BTreeMap<String, IgnoredAny>> = serde_json::from_str(extras.get()).ok();
    if fields.is_none_or(|fields| fields.keys().any(|key| key != EXTRAS && key != "targetNames")) {
        report.count(Fate::LeftOut, &format!("extras of a {of}: data of other programs"));
    }
}

/// Counts extensions.
pub(super) fn extensions(extensions: Option<&Extensions<'_>>, of: &str, report: &mut ReadReport) {
    for name in extensions.into_iter().flat_map(|e| e.keys()) {
        report.count(Fate::LeftOut, &format!("extension {} of a {of}", clip(name)));
    }
}
