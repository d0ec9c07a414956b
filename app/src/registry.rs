//! Everything that comes with Loftsman, registered.

use std::sync::OnceLock;

use loftsman_kernel::plugin::{Plugin, Registry};

/// Everything that comes with Loftsman. To have more, register it in a copy:
///
/// ```
/// use loftsman::kernel::plugin::{Plugin, Registry};
///
/// let mut registry = loftsman::registry().clone();
/// registry.add(&loftsman::native::Plugin);        // or a plug-in of your own
/// assert_eq!(registry.formats().len(), loftsman::registry().formats().len());
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct BuiltIn;

impl Plugin for BuiltIn {
    fn register(&self, registry: &mut Registry) {
        registry.add(&loftsman_construction::Construction);
        registry.add(&loftsman_dynamics::Dynamics);
        registry.add(&loftsman_editing::Editing);
        registry.add(&loftsman_fairing::Fairing);
        registry.add(&loftsman_fine_tuning::FineTuning);
        registry.add(&loftsman_fitting::Fitting);
        registry.add(&loftsman_area_volume::AreaVolume);
        registry.add(&loftsman_intersection::Intersection);
        registry.add(&loftsman_matching::MatchingPlugin);
        registry.operation(crate::recipe::Merge);
        registry.add(&loftsman_regions::Regions);
        registry.add(&loftsman_subdivision::Subdivision);
        #[cfg(feature = "interior-point")]
        registry.add(&loftsman_interior_point::InteriorPoint);
        registry.add(&loftsman_tessellation::Tessellation);
        registry.add(&loftsman_gltf::Plugin);
        registry.add(&loftsman_native::Plugin);
        registry.add(&loftsman_obj::Plugin);
        registry.add(&loftsman_points::Plugin);
        #[cfg(feature = "iges")]
        registry.add(&loftsman_iges::Plugin);
        #[cfg(feature = "step")]
        registry.add(&loftsman_step::Plugin);
    }
}

/// All built-in formats, operations, kinds of constraint and solvers, and the tessellator.
pub fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| {
        let mut registry = Registry::new();
        registry.add(&BuiltIn);
        registry
    })
}
