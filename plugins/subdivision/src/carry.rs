//! What belongs to a mesh's faces and corners, carried on to the faces of its refinement.

use loftsman_kernel::mesh::{FaceGroup, Layer, Mesh, NONE};

/// Materials, smoothing groups, named groups and texture coordinates of a mesh whose faces become one quad a corner at each level
/// (Catmull and Clark's): child face `h` is corner `h` of its parent. Texture coordinates are carried on bilinearly, face by face.
pub(crate) struct Carried {
    /// Of each face of the present level: the face of the mesh that it lies in.
    faces: Vec<u32>,
    /// Texture coordinates of each corner of the present level, in as many sets as the mesh has.
    uvs: Vec<Vec<Option<[f64; 2]>>>,
    /// Where the faces of the present level start among its corners.
    starts: Vec<usize>,
}

impl Carried {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let sets = std::iter::once(&mesh.uvs).chain(&mesh.more_uvs);
        let of = |layer: &Layer<[f64; 2]>| -> Vec<Option<[f64; 2]>> {
            let value = |at: u32| layer.values().get(at as usize).copied().filter(|_| at != NONE);
            match layer.corners() {
                Some(corners) => corners.iter().map(|at| value(*at)).collect(),
                None => mesh.corners().iter().map(|at| value(*at)).collect(),
            }
        };
        Self {
            faces: (0..mesh.face_count() as u32).collect(),
            uvs: sets.filter(|layer| !layer.is_empty()).map(of).collect(),
            starts: mesh.starts().to_vec(),
        }
    }

    /// On to the next level.
    pub(crate) fn refine(&mut self) {
        let sizes = self.starts.windows(2).map(|pair| pair[1] - pair[0]);
        let faces = self.faces.iter().zip(sizes).flat_map(|(face, size)| std::iter::repeat_n(*face, size));
        self.faces = faces.collect();
        for set in &mut self.uvs {
            let mut next = Vec::with_capacity(4 * set.len());
            for pair in self.starts.windows(2) {
                let face = &set[pair[0]..pair[1]];
                let n = face.len();
                let mean = |at: &[usize]| -> Option<[f64; 2]> {
                    let all = at.iter().map(|k| face[*k]).collect::<Option<Vec<_>>>()?;
                    let sum = all.iter().fold([0.0, 0.0], |s, uv| [s[0] + uv[0], s[1] + uv[1]]);
                    Some(sum.map(|c| c / at.len() as f64))
                };
                let middle = mean(&(0..n).collect::<Vec<_>>());
                for k in 0..n {
                    next.extend([face[k], mean(&[k, (k + 1) % n]), middle, mean(&[(k + n - 1) % n, k])]);
                }
            }
            *set = next;
        }
        self.starts = (0..=self.faces.len()).map(|f| 4 * f).collect();
    }

    /// Gives a mesh of the present level what belongs to it. `kept` says for each face of the level whether the mesh has it.
    pub(crate) fn give(&self, from: &Mesh, kept: &[bool], to: &mut Mesh) {
        let faces: Vec<u32> =
            self.faces.iter().zip(kept).filter(|(_, kept)| **kept).map(|(f, _)| *f).collect();
        let each = |of: &[u32]| faces.iter().filter_map(|f| of.get(*f as usize).copied()).collect::<Vec<_>>();
        to.materials = each(&from.materials);
        to.smoothing = each(&from.smoothing);
        for group in &from.groups {
            let has = |f: &u32| group.faces.binary_search(f).is_ok();
            let own = faces.iter().enumerate().filter(|(_, f)| has(f)).map(|(at, _)| at as u32);
            to.groups.push(FaceGroup { name: group.name.clone(), faces: own.collect() });
        }
        let mut sets = self.uvs.iter().map(|set| {
            let corners = self.starts.windows(2).zip(kept).filter(|(_, kept)| **kept);
            let corners = corners.flat_map(|(pair, _)| &set[pair[0]..pair[1]]);
            let (mut values, mut at) = (Vec::new(), Vec::new());
            for uv in corners {
                at.push(uv.map_or(NONE, |_| values.len() as u32));
                values.extend(*uv);
            }
            Layer::per_corner(values, at)
        });
        if !from.uvs.is_empty() {
            to.uvs = sets.next().unwrap_or_default();
        }
        to.more_uvs = sets.collect();
    }
}

/// What belongs to the faces and corners of a mesh that `what` it becomes has no place for, for a report: nothing where there is nothing.
pub(crate) fn left_behind(mesh: &Mesh, what: &str) -> String {
    let several = mesh.materials.iter().any(|material| Some(material) != mesh.materials.first());
    let named = [
        (several, "materials of single faces (all have the first now)"),
        (!mesh.groups.is_empty(), "groups"),
        (!(mesh.uvs.is_empty() && mesh.more_uvs.is_empty()), "texture coordinates"),
        (!mesh.colors.is_empty(), "colours"),
    ];
    let named: Vec<&str> = named.into_iter().filter(|(is, _)| *is).map(|(_, name)| name).collect();
    if named.is_empty() {
        return String::new();
    }
    format!("; left out, for which {what} has no place: {}", named.join(", "))
}
