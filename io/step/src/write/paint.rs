//! The colours that objects and faces of meshes show: of their materials the base colour, which is all that STEP has of them.

use loftsman_kernel::material::Alpha;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::scene::{Geometry, Object, Scene};

/// How an object is coloured.
#[derive(Debug, Default)]
pub(crate) struct Paint {
    /// All of it, but for faces that have colours of their own: the colour of its material, where it has one, else its own, or its layer's.
    pub(crate) all: Option<[f64; 4]>,
    /// The base colours of its materials; `None` of one that there is not.
    slots: Vec<Option<[f64; 4]>>,
}

/// Faces of a mesh that go out as one.
#[derive(Debug)]
pub(crate) struct Group {
    /// Their colour, where it is not that of all.
    pub(crate) color: Option<[f64; 4]>,
    pub(crate) faces: Vec<usize>,
}

impl Paint {
    /// The colours of an object. A material that is said to be opaque is, whatever its alpha.
    pub(crate) fn of(scene: &Scene, object: &Object) -> Self {
        let color = |name: &String| {
            let material = scene.materials.get(name)?;
            let [r, g, b, alpha] = material.base_color;
            let alpha = if material.alpha == Alpha::Opaque { 1.0 } else { alpha };
            Some([r, g, b, alpha]).filter(|color| color.iter().all(|c| c.is_finite()))
        };
        let slots: Vec<Option<[f64; 4]>> = object.materials.iter().map(color).collect();
        let first = match object.geometry() {
            Geometry::Mesh(mesh) => mesh.materials.first().map_or(0, |slot| *slot as usize),
            _ => 0,
        };
        let all = slots.get(first).copied().flatten().or_else(|| scene.color_of(object));
        Self { all, slots }
    }

    /// The faces of a mesh by their colours, in the order of the first face of each. `O(faces)`, for few colours.
    pub(crate) fn groups(&self, mesh: &Mesh) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        // The last is that of faces whose material is not there.
        let mut of_slot: Vec<Option<usize>> = vec![None; self.slots.len() + 1];
        for face in 0..mesh.face_count() {
            let slot = mesh.materials.get(face).map_or(0, |slot| *slot as usize).min(of_slot.len() - 1);
            let group = *of_slot[slot].get_or_insert_with(|| {
                let color = self.slots.get(slot).copied().flatten();
                groups.iter().position(|group| group.color == color).unwrap_or_else(|| {
                    groups.push(Group { color, faces: Vec::new() });
                    groups.len() - 1
                })
            });
            groups[group].faces.push(face);
        }
        if let [only] = &mut groups[..]
            && only.color == self.all
        {
            only.color = None;
        }
        groups
    }
}
