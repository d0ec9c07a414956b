//! What other programs call operations: for those who look for one by the name that they know.

use loftsman_kernel::plugin::Registry;

/// A name elsewhere, and the operation.
const NAMES: [(&str, &str); 59] = [
    ("append", "merge"),
    ("approximate", "fit"),
    ("array", "copy"),
    ("bisect", "section"),
    ("blend", "match"),
    ("brepbuilderapi_makeface", "fill"),
    ("brepoffsetapi_thrusections", "loft"),
    ("brepprimapi_makeprism", "extrude"),
    ("brepprimapi_makerevol", "revolve"),
    ("clip", "section"),
    ("contour", "section"),
    ("cross-section", "section"),
    ("cut", "section"),
    ("densify", "refine"),
    ("divide", "sample"),
    ("dupborder", "edge"),
    ("dupedge", "edge"),
    ("duplicate", "copy"),
    ("duplicateedge", "edge"),
    ("extract", "isocurve"),
    ("extractedge", "edge"),
    ("extractisocurve", "isocurve"),
    ("extrudecrv", "extrude"),
    ("flip", "reverse"),
    ("import", "merge"),
    ("insert", "refine"),
    ("inset", "offset"),
    ("interpcrv", "fit"),
    ("interpolate", "fit"),
    ("isoline", "isocurve"),
    ("isoparm", "isocurve"),
    ("knit", "sew"),
    ("lathe", "revolve"),
    ("loftsrf", "loft"),
    ("makeface", "fill"),
    ("mirror", "symmetrize"),
    ("move", "transform"),
    ("patch", "fill"),
    ("pipe", "tube"),
    ("planarsrf", "fill"),
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
    ("stitch", "sew"),
    ("subdivide", "refine"),
    ("sweep1", "sweep"),
    ("thicken", "offset"),
    ("thrusections", "loft"),
    ("translate", "transform"),
    ("triangulate", "tessellate"),
];

const OF_SOLIDS: &str = "solids are read, edited, cut, sewn of faces and written, but none is made of others or rounded, and no surface is mended: that is for a CAD program, before or after";
const OF_MESHES: &str = "meshes are edited with the points and faces that they have: other ones are for Blender or MeshLab, before or after";
const OF_LOOPS: &str =
    "trimmed surfaces keep the loops that they come with, or none (untrim); a curve is cut in two by split";
const OF_PARTS: &str = "nothing here takes a group or a solid apart: section, edge and tessellate add what they make beside it; untrim gives the surfaces that carry trimmed ones";
const OF_EXTENDING: &str = "curves and surfaces are not prolonged: move an end or an edge by edit, or have it meet another shape by match";
const OF_CAGES: &str =
    "space is not bent as a whole: transform moves, turns and scales, and edit moves a shape by places on it";
const OF_PROJECTING: &str = "nothing is projected onto surfaces: section and intersect give curves on them";
const OF_NETWORKS: &str = "surfaces through a network of curves are not offered: loft takes sections, sweep a curve and a path, and edit with edges that are kept on curves does the rest";
const OF_DIMENSIONS: &str = "drawings have no dimensions: `info` and the report tell lengths, areas and distances, and the labels of a picture parameters";
const OF_CAPS: &str =
    "loft and extrude close what they make by themselves; fill makes a face of a closed curve";

/// What other programs do and no operation here, with what to do instead.
const ABSENT: [(&str, &str); 44] = [
    ("bevel", OF_SOLIDS),
    ("boolean", OF_SOLIDS),
    ("booleandifference", OF_SOLIDS),
    ("booleanintersection", OF_SOLIDS),
    ("booleanunion", OF_SOLIDS),
    ("brepalgoapi_common", OF_SOLIDS),
    ("brepalgoapi_cut", OF_SOLIDS),
    ("brepalgoapi_fuse", OF_SOLIDS),
    ("brepfilletapi_makechamfer", OF_SOLIDS),
    ("brepfilletapi_makefillet", OF_SOLIDS),
    ("cap", OF_CAPS),
    ("chamfer", OF_SOLIDS),
    ("common", OF_SOLIDS),
    ("coons", OF_NETWORKS),
    ("curvenetwork", OF_NETWORKS),
    ("decimate", OF_MESHES),
    ("difference", OF_SOLIDS),
    ("dimension", OF_DIMENSIONS),
    ("edgesrf", OF_NETWORKS),
    ("explode", OF_PARTS),
    ("extend", OF_EXTENDING),
    ("fillet", OF_SOLIDS),
    ("filletedge", OF_SOLIDS),
    ("flow", OF_CAGES),
    ("fuse", OF_SOLIDS),
    ("gordon", OF_NETWORKS),
    ("heal", OF_SOLIDS),
    ("lattice", OF_CAGES),
    ("network", OF_NETWORKS),
    ("networksrf", OF_NETWORKS),
    ("project", OF_PROJECTING),
    ("pull", OF_PROJECTING),
    ("pullback", OF_PROJECTING),
    ("remesh", OF_MESHES),
    ("round", OF_SOLIDS),
    ("shell", OF_SOLIDS),
    ("subtract", OF_SOLIDS),
    ("taper", OF_CAGES),
    ("trim", OF_LOOPS),
    ("twist", OF_CAGES),
    ("union", OF_SOLIDS),
    ("voxel", OF_MESHES),
    ("warp", OF_CAGES),
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
