//! What is shown more than once: geometries that objects share, and colours of single occurrences.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::item::Items;
use super::style::Carrier;
use super::{Component, Product};

/// What objects have in common that go out as occurrences of one product: a geometry that they share, a colour, materials and a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Key<'s> {
    geometry: usize,
    color: Option<[u64; 4]>,
    materials: &'s [String],
    layer: Option<&'s str>,
}

impl<'s> Key<'s> {
    pub(super) fn of(scene: &Scene, object: &'s Object) -> Self {
        let color = scene.color_of(object).map(|color| color.map(f64::to_bits));
        let (materials, layer) = (&object.materials[..], object.layer.as_deref());
        Self { geometry: object.geometry_id(), color, materials, layer }
    }
}

/// The geometries that go out once for several objects, of the scene and of its definitions; nothing is written of them yet.
/// O(objects).
pub(super) fn shared<T>(scene: &Scene) -> HashMap<Key<'_>, Option<T>> {
    let mut counts: HashMap<Key<'_>, usize> = HashMap::new();
    let in_definitions = scene.definitions().iter().flat_map(|definition| definition.objects());
    for object in scene.objects().iter().chain(in_definitions) {
        if !matches!(object.geometry(), Geometry::Group | Geometry::Instance(_)) {
            *counts.entry(Key::of(scene, object)).or_default() += 1;
        }
    }
    counts.into_iter().filter(|(_, count)| *count > 1).map(|(key, _)| (key, None)).collect()
}

/// What in a product has no colour: its own items, and what is in components that have none either; each once.
pub(super) fn plain(items: Option<&Items>, components: &[Component<'_>]) -> Rc<[(u64, Carrier)]> {
    let own = items.filter(|items| !items.has_color);
    let own = own.into_iter().flat_map(|items| items.colored.iter().map(|&item| (item, items.carrier)));
    let uncolored: Vec<&Product> =
        components.iter().filter(|component| component.color.is_none()).map(|c| &c.product).collect();
    if let ([only], None) = (&uncolored[..], items) {
        return Rc::clone(&only.plain);
    }
    let mut known = HashSet::new();
    let below = uncolored.into_iter().flat_map(|product| product.plain.iter().copied());
    own.chain(below).filter(|(item, _)| known.insert(*item)).collect()
}

/// What comes back changed of an occurrence's colour, which goes to what has none.
pub(super) fn told(plain: &[(u64, Carrier)], color: [f64; 4]) -> Option<&'static str> {
    if plain.is_empty() {
        return Some("its colour is left out: all that it shows has colours of its own");
    }
    let opaque = color[3] < 1.0 && plain.iter().any(|(_, carrier)| *carrier != Carrier::Surface);
    opaque.then_some("opaque: curves and points have no transparency")
}
