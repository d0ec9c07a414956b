//! What other programs call operations: for those who look for one by the name that they know.

use loftsman_kernel::plugin::Registry;

/// A name elsewhere, and the operation.
const NAMES: [(&str, &str); 32] = [
    ("append", "merge"),
    ("approximate", "fit"),
    ("bisect", "section"),
    ("blend", "match"),
    ("clip", "section"),
    ("contour", "section"),
    ("cross-section", "section"),
    ("cut", "section"),
    ("densify", "refine"),
    ("divide", "sample"),
    ("duplicate", "copy"),
    ("extract", "isocurve"),
    ("import", "merge"),
    ("insert", "refine"),
    ("interpolate", "fit"),
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
    ("slice", "section"),
    ("smooth", "fair"),
    ("spin", "revolve"),
    ("subdivide", "refine"),
    ("thicken", "offset"),
    ("translate", "transform"),
    ("triangulate", "tessellate"),
];

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
        assert!(NAMES.is_sorted());
        assert_eq!(called("slice", &Registry::new()), None);
    }
}
