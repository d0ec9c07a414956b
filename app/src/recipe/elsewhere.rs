//! What other programs call operations: for those who look for one by the name that they know.

use loftsman_kernel::plugin::Registry;

/// A name elsewhere, and the operation.
const NAMES: [(&str, &str); 41] = [
    ("append", "merge"),
    ("approximate", "fit"),
    ("array", "copy"),
    ("bisect", "section"),
    ("blend", "match"),
    ("clip", "section"),
    ("contour", "section"),
    ("cross-section", "section"),
    ("cut", "section"),
    ("densify", "refine"),
    ("divide", "sample"),
    ("dupedge", "edge"),
    ("duplicate", "copy"),
    ("extract", "isocurve"),
    ("extractisocurve", "isocurve"),
    ("import", "merge"),
    ("insert", "refine"),
    ("interpolate", "fit"),
    ("isoline", "isocurve"),
    ("isoparm", "isocurve"),
    ("lathe", "revolve"),
    ("mirror", "symmetrize"),
    ("move", "transform"),
    ("patch", "fill"),
    ("pipe", "tube"),
    ("rail", "sweep"),
    ("rebuild", "fit"),
    ("reduce", "simplify"),
    ("rotate", "transform"),
    ("scale", "transform"),
    ("screw", "revolve"),
    ("shrinkwrap", "fit-shape"),
    ("skin", "loft"),
    ("slice", "section"),
    ("smooth", "fair"),
    ("solidify", "offset"),
    ("spin", "revolve"),
    ("subdivide", "refine"),
    ("thicken", "offset"),
    ("translate", "transform"),
    ("triangulate", "tessellate"),
];

const OF_SOLIDS: &str = "solids are read, edited, cut and written, but none is made of others, rounded or healed: that is for a CAD program, before or after";
const OF_MESHES: &str = "meshes are edited with the points and faces that they have: other ones are for Blender or MeshLab, before or after";
const OF_LOOPS: &str =
    "trimmed surfaces keep the loops that they come with, or none (untrim); a curve is cut in two by split";

/// What other programs do and no operation here, with what to do instead.
const ABSENT: [(&str, &str); 20] = [
    ("bevel", OF_SOLIDS),
    ("boolean", OF_SOLIDS),
    ("booleandifference", OF_SOLIDS),
    ("booleanunion", OF_SOLIDS),
    ("chamfer", OF_SOLIDS),
    ("common", OF_SOLIDS),
    ("decimate", OF_MESHES),
    ("difference", OF_SOLIDS),
    ("fillet", OF_SOLIDS),
    ("fuse", OF_SOLIDS),
    ("heal", OF_SOLIDS),
    ("remesh", OF_MESHES),
    ("round", OF_SOLIDS),
    ("sew", OF_SOLIDS),
    ("shell", OF_SOLIDS),
    ("subtract", OF_SOLIDS),
    ("trim", OF_LOOPS),
    ("union", OF_SOLIDS),
    ("voxel", OF_MESHES),
    ("weld", OF_MESHES),
];

/// Why there is no operation of this name, and what to do instead, where it is one that others have.
pub(crate) fn absent(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    ABSENT.iter().find(|(other, _)| *other == name).map(|(_, why)| *why)
}

/// The operation that other programs call so, where it is registered.
pub(crate) fn called(name: &str, registry: &Registry) -> Option<&'static str> {
    called_among(name, registry.operations().iter().map(|o| o.declaration().name))
}

/// The same, where it is among these operations.
pub(crate) fn called_among<'a>(
    name: &str,
    mut operations: impl Iterator<Item = &'a str>,
) -> Option<&'static str> {
    let name = name.to_lowercase();
    let (_, ours) = NAMES.iter().find(|(other, _)| *other == name)?;
    operations.any(|operation| operation == *ours).then_some(ours)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No name stands for what is an operation itself, and each stands for one that there is.
    #[test]
    fn names_of_others_lead_to_ours() {
        let mut registry = Registry::new();
        registry.add(&loftsman_construction::Construction).add(&loftsman_editing::Editing);
        registry.add(&loftsman_fairing::Fairing).add(&loftsman_fitting::Fitting);
        registry.add(&loftsman_intersection::Intersection).add(&loftsman_matching::MatchingPlugin);
        registry.add(&loftsman_regions::Regions).operation(crate::recipe::merge::Merge);
        let registry = &registry;
        let ours: Vec<&str> = registry.operations().iter().map(|o| o.declaration().name).collect();
        for (other, _) in NAMES {
            assert!(!ours.contains(&other), "{other}");
            assert!(called(other, registry).is_some_and(|name| ours.contains(&name)), "{other}");
        }
        assert_eq!((called("Slice", registry), called("edit", registry)), (Some("section"), None));
        for (other, _) in ABSENT {
            assert!(!ours.contains(&other) && called(other, registry).is_none(), "{other}");
        }
        assert!(NAMES.is_sorted() && ABSENT.is_sorted());
        assert_eq!((absent("Fillet"), absent("edit")), (Some(OF_SOLIDS), None));
        assert_eq!(called("slice", &Registry::new()), None);
    }
}
