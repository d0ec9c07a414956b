//! Objects of a scene.

use std::sync::Arc;

use nalgebra::Matrix4;

use super::animation::Animation;
use super::geometry::Geometry;

/// A named thing in a scene. Its geometry is shared with its copies until one of them is changed, so that a copy costs
/// nothing but its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    pub(super) name: String,
    /// What it is called where it comes from, if that is not its name: there others are called so too. Formats in which names
    /// may be equal write it; recipes and messages use the name.
    pub label: Option<String>,
    geometry: Arc<Geometry>,
    /// Red, green, blue, alpha, each 0 to 1.
    pub color: Option<[f64; 4]>,
    /// The layer it is on: one that the scene lists, or any other, which is seen and has no colour.
    pub layer: Option<String>,
    /// The name of the object it hangs under.
    pub parent: Option<String>,
    /// From its own coordinates to its parent's (or the scene's); affine.
    pub transform: Option<Matrix4<f64>>,
    /// Its frames, where it moves.
    pub animation: Option<Animation>,
    /// The names of its materials, among the scene's; a mesh's faces say which, others have the first.
    pub materials: Vec<String>,
    /// What a format said of it beyond all this, word for word, for the same format: `("gltf extras", "{…}")`.
    pub statements: Vec<(String, String)>,
}

impl Object {
    /// An object with a name and a geometry and nothing else.
    pub fn new(name: impl Into<String>, geometry: Geometry) -> Self {
        Self::sharing(name, Arc::new(geometry))
    }

    /// An object with a name that shares its geometry with whoever else holds it, and nothing else.
    pub fn sharing(name: impl Into<String>, geometry: Arc<Geometry>) -> Self {
        Self {
            name: name.into(),
            label: None,
            geometry,
            color: None,
            layer: None,
            parent: None,
            transform: None,
            animation: None,
            materials: Vec::new(),
            statements: Vec::new(),
        }
    }

    /// What it is.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// What it is, to be changed: a copy of its own where others share it, so that they stay as they are.
    pub fn geometry_mut(&mut self) -> &mut Geometry {
        Arc::make_mut(&mut self.geometry)
    }

    /// Makes it something else. Its animation stays as it is, unlike with [`Scene::replace`](super::Scene::replace).
    pub fn set_geometry(&mut self, geometry: impl Into<Geometry>) {
        self.geometry = Arc::new(geometry.into());
    }

    /// Its geometry as it is shared: objects that were copied from one another have the same ([`Arc::ptr_eq`]) until one
    /// of them is changed.
    pub fn shared_geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    /// A number that objects have in common while they share a geometry, and no others have: to do once what would be
    /// the same for all of them. Another one in each run, so that nothing that goes out may depend on it.
    pub fn geometry_id(&self) -> usize {
        Arc::as_ptr(&self.geometry).addr()
    }

    /// Makes it share a geometry with whoever else holds it.
    pub fn share_geometry(&mut self, geometry: Arc<Geometry>) {
        self.geometry = geometry;
    }

    /// What was said of it under this heading, first.
    pub fn statement(&self, heading: &str) -> Option<&str> {
        self.statements.iter().find(|(known, _)| known == heading).map(|(_, text)| text.as_str())
    }

    /// The same object under another name, which is its label too.
    #[must_use]
    pub fn renamed(&self, name: impl Into<String>) -> Self {
        let name = name.into();
        let label = self.label.clone().filter(|_| name == self.name);
        Self { name, label, ..self.clone() }
    }

    /// The same object, labelled `wanted` where its name had to be another one.
    #[must_use]
    pub fn labelled(self, wanted: &str) -> Self {
        let label = Some(wanted).filter(|wanted| !wanted.is_empty() && *wanted != self.name);
        Self { label: label.map(str::to_owned), ..self }
    }

    /// What it is called where names may be equal: its label, or its name.
    pub fn label(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.name)
    }

    /// Whether something of its own beside a colour says how it looks: materials, or the colours of a mesh.
    pub(super) fn has_look(&self) -> bool {
        !self.materials.is_empty()
            || matches!(self.geometry(), Geometry::Mesh(mesh) if !mesh.colors.is_empty())
    }

    /// Its name, unique in its scene, never empty there. [`Scene::rename`](super::Scene::rename) changes it.
    pub fn name(&self) -> &str {
        &self.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::mesh::Cloud;
    use crate::scene::{Scene, Unit, Up};

    #[test]
    fn copies_share_their_points_until_one_is_changed() {
        let mut scene = Scene::new();
        let points = vec![Point::new(1.0, 2.0, 3.0)];
        scene.add(Object::new("a", Cloud { points }.into())).unwrap();
        scene.add(scene.object("a").unwrap().renamed("b")).unwrap();
        let before = scene.clone();
        let shared = |x: &Scene, a: &str, y: &Scene, b: &str| {
            let (a, b) = (x.object(a).unwrap(), y.object(b).unwrap());
            let same = Arc::ptr_eq(a.shared_geometry(), b.shared_geometry());
            assert_eq!(a.geometry_id() == b.geometry_id(), same);
            same
        };
        assert!(shared(&scene, "a", &scene, "b") && shared(&scene, "a", &before, "a"));
        // Another unit: changed once, for both.
        let inches = scene.converted(Unit::Inch, Up::Y).unwrap().into_owned();
        assert!(shared(&inches, "a", &inches, "b") && !shared(&inches, "a", &scene, "a"));
        let Geometry::Cloud(cloud) = scene.object_mut("b").unwrap().geometry_mut() else { unreachable!() };
        cloud.points[0].x = 7.0;
        assert_eq!(scene.object("a").unwrap().geometry().points()[0].x, 1.0);
        assert_eq!(scene.object("b").unwrap().geometry().points()[0].x, 7.0);
        assert_eq!(before.object("b").unwrap().geometry().points()[0].x, 1.0);
        assert!(!shared(&scene, "a", &scene, "b") && shared(&scene, "a", &before, "b"));
    }

    #[test]
    fn many_objects_go_at_once_and_what_hung_under_them_moves_up() {
        let mut scene = Scene::new();
        let count = 50_000;
        for i in 0..count {
            let mut object = Object::new(format!("{i}"), Geometry::Group);
            object.parent = (i > 0).then(|| format!("{}", i - 1));
            scene.add(object).unwrap();
        }
        // Of a chain all but the first, one in the middle and the last.
        let kept = ["0", "1000", "49999"];
        let gone = scene.retain(|o| kept.contains(&o.name()));
        assert_eq!((gone.len(), gone[0].name()), (count - 3, "1"));
        let found: Vec<_> = scene.objects().iter().map(|o| (o.name(), o.parent.as_deref())).collect();
        assert_eq!(found, [("0", None), ("1000", Some("0")), ("49999", Some("1000"))]);
        assert_eq!(scene.position("49999"), Some(2));
        scene.check().unwrap();
        // What hangs in a circle that goes hangs nowhere.
        scene.object_mut("0").unwrap().parent = Some("1000".into());
        scene.retain(|o| o.name() == "49999");
        assert_eq!(scene.objects()[0].parent, None);
        assert!(scene.remove("nobody").is_err());
    }
}
