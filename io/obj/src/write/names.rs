//! Names that cannot stand in a file as they are: an end of a line, a number sign behind a blank, blanks around.

use std::collections::BTreeSet;

use loftsman_kernel::named::Named;
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene};
use loftsman_kernel::text::{a, clip, counted};

use super::print;

/// How many are named; others are counted.
const NAMED: usize = 3;

/// A line each for names of objects, of materials and of groups of faces that are written otherwise than they are. `O(names)`.
pub(crate) fn changed(scene: &Scene) -> Vec<String> {
    let of_definitions = scene.definitions().iter().flat_map(Definition::objects);
    let objects: Vec<&Object> = scene.objects().iter().chain(of_definitions).collect();
    let is_written = |o: &&&Object| !matches!(o.geometry(), Geometry::Group | Geometry::Instance(_));
    let groups: BTreeSet<&str> = objects
        .iter()
        .filter_map(|o| if let Geometry::Mesh(mesh) = o.geometry() { Some(&mesh.groups) } else { None })
        .flat_map(|groups| groups.iter().map(|group| group.name.as_str()))
        .collect();
    [
        line("object", objects.iter().filter(is_written).map(|o| o.name()), print::name),
        line("material", scene.materials.iter().map(Named::name), print::name),
        line("group", groups.into_iter(), print::group),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn line<'n>(of: &str, names: impl Iterator<Item = &'n str>, written: fn(&str) -> String) -> Option<String> {
    let changed: Vec<(&str, String)> =
        names.map(|name| (name, written(name))).filter(|(name, written)| name != written).collect();
    let few = changed.iter().take(NAMED);
    let mut few: Vec<String> =
        few.map(|(name, written)| format!("\"{}\" as \"{}\"", clip(name), clip(written))).collect();
    if changed.len() > NAMED {
        few.push("…".to_owned());
    }
    let count = counted(
        changed.len(),
        &format!("name[|s] of [{}|{of}s] cannot stand in OBJ and [is|are] changed", a(of)),
    );
    (!changed.is_empty()).then(|| format!("{count}: {}", few.join(", ")))
}
