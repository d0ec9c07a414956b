//! Shapes of plug-ins.

use std::io;

use loftsman_kernel::plugin::CustomShape;
use loftsman_kernel::text::clip;

use super::layout::Layout;
use loftsman_kernel::text::counted;

/// Writes a shape: its kind and the fields that this has, or what a document said of it. What it went out as.
pub(super) fn write(custom: &CustomShape, out: &mut Layout<'_>) -> io::Result<String> {
    if let Some(text) = custom.text() {
        out.verbatim(text)?;
        return Ok(format!("shape of the kind \"{}\", word for word", clip(custom.kind())));
    }
    out.open_table()?;
    out.key("kind")?;
    out.text(custom.kind())?;
    let fields = custom.fields().map_err(|defect| io::Error::other(defect.to_string()))?;
    for (name, value) in fields.into_map() {
        out.key(&name)?;
        out.value(&value)?;
    }
    out.close_table()?;
    Ok(format!("{} of {}", custom.kind(), counted(custom.points().len(), "vert[ex|ices]")))
}
