//! Shapes of kinds that nobody here knows.

use std::collections::BTreeMap;

use loftsman_kernel::scene::{Definition, Geometry, Scene};
use loftsman_kernel::text::clip;
use loftsman_kernel::text::counted;

/// What to say of shapes whose plug-ins are not here, a note a kind.
pub(crate) fn unknown(scene: &Scene) -> Vec<String> {
    let defined = scene.definitions().iter().flat_map(Definition::objects);
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for object in defined.chain(scene.objects()) {
        if let Geometry::Custom(custom) = object.geometry()
            && custom.shape_kind().is_none()
        {
            *kinds.entry(custom.kind()).or_default() += 1;
        }
    }
    let note = |(kind, count): (&str, usize)| {
        let kind = clip(kind);
        let (shapes, are) = (counted(count, "shape[|s]"), if count == 1 { "is" } else { "are" });
        format!("{shapes} of the kind \"{kind}\", whose plug-in is not here, {are} kept word for word")
    };
    kinds.into_iter().map(note).collect()
}
