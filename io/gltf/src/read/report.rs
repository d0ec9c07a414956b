//! Counting what is left out, and keeping what other programs noted.

use loftsman_kernel::plugin::{Fate, ReadReport};
use serde_json::Value;

use super::file::clip;
use super::schema::{Extensions, Present, Raw, Root};

/// The largest text of another program that is kept: as a tree it takes many times the memory.
pub(super) const LARGEST: usize = 1 << 20;

/// Counts data of other programs where nothing keeps it.
pub(super) fn extras(extras: Option<Raw<'_>>, of: &str, report: &mut ReadReport) {
    if extras.is_some() {
        report.count(Fate::LeftOut, &format!("extras of a {of}: data of other programs"));
    }
}

/// Keeps data of other programs as a statement; fields that are `own` are read elsewhere.
pub(super) fn keep(
    extras: Option<Raw<'_>>,
    of: &str,
    own: &[&str],
    key: &str,
    statements: &mut Vec<(String, String)>,
    report: &mut ReadReport,
) {
    let Some(text) = extras.map(|extras| extras.get()) else { return };
    if text.len() > LARGEST && !own.iter().any(|key| text.contains(&format!("\"{key}\""))) {
        report.count(Fate::LeftOut, &format!("extras of a {of}, larger than a megabyte"));
        return;
    }
    let text = match serde_json::from_str::<Value>(text) {
        Ok(Value::Object(mut fields)) => {
            let before = fields.len();
            fields.retain(|key, _| !own.contains(&key.as_str()));
            if fields.is_empty() && before > 0 {
                return;
            }
            Value::Object(fields).to_string()
        }
        Ok(value) => value.to_string(),
        Err(_) => {
            report.count(Fate::LeftOut, &format!("extras of a {of} that cannot be read"));
            return;
        }
    };
    if text.len() > LARGEST {
        report.count(Fate::LeftOut, &format!("extras of a {of}, larger than a megabyte"));
        return;
    }
    statements.push((key.to_owned(), text));
    report.count(Fate::Kept, "");
}

/// Counts extensions.
pub(super) fn extensions(extensions: Option<&Extensions<'_>>, of: &str, report: &mut ReadReport) {
    for name in extensions.into_iter().flat_map(|e| e.keys()) {
        report.count(Fate::LeftOut, &format!("extension {} of a {of}", clip(name)));
    }
}

/// Counts data of other programs about the parts of the file that a scene does not have.
pub(super) fn inner(root: &Root<'_>, report: &mut ReadReport) {
    fn count<T>(list: &[T], extras: impl Fn(&T) -> Present) -> usize {
        list.iter().filter(|entry| extras(entry).0).count()
    }
    for (of, found) in [
        ("a texture", count(&root.textures, |t| t.extras)),
        ("a sampler", count(&root.samplers, |s| s.extras)),
        ("an accessor", count(&root.accessors, |a| a.extras)),
        ("a bufferView", count(&root.buffer_views, |v| v.extras)),
        ("a buffer", count(&root.buffers, |b| b.extras)),
    ] {
        report.count_many(Fate::LeftOut, &format!("extras of {of}: data of other programs"), found);
    }
}
