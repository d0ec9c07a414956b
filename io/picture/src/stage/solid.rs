//! Breps as they are drawn, each cut once for all that shows it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use loftsman_kernel::brep::{Brep, Frame, SurfaceForm};
use loftsman_kernel::mesh::Layer;
use loftsman_kernel::plugin::{Chord, Fineness, TessellatedBrep, Tessellator};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::clip;
use loftsman_kernel::{Point, Result, Vector};

use super::crease::{bent_edge, creases};
use super::shell::{Edge, Kind, Side, Sides, Skin, pair};

/// How far triangles may be from the shape, as a part of the largest extent of the scene: a twentieth of a millimetre on a usual page.
const CHORD: f64 = 3e-4;
/// How much neighbouring chords may turn, in degrees.
pub(super) const ANGLE: f64 = 10.0;
/// A Brep in its own coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solid {
    pub(crate) points: Vec<Point>,
    /// At each point, of unit length; points are doubled where faces meet.
    pub(crate) normals: Vec<Vector>,
    pub(crate) skin: Arc<Skin>,
    /// Which faces are missing.
    pub(crate) remark: Option<String>,
}

impl Solid {
    fn of(brep: &Brep, fineness: &Fineness, by: &dyn Tessellator) -> Result<Self> {
        let mut cut = by.measured_brep(brep, fineness)?;
        cut.mesh.uvs = Layer::none();
        let (colors, slots) = cut.colors(brep);
        let remark = cut.remark(brep);
        let edges = edges(brep, &cut);
        let flat = cut.mesh.by_point()?.mesh;
        let normal = |p: usize| flat.normals.values().get(p).copied().unwrap_or_else(Vector::zeros);
        let triangles = flat.faces().map(|face| [face[0], face[1], face[2]]).collect();
        let normals = (0..flat.points().len()).map(normal).collect();
        let skin = Arc::new(Skin { triangles, colors, slots, edges });
        Ok(Self { points: flat.points().to_vec(), normals, skin, remark })
    }
}

/// The edges of a Brep that are drawn.
fn edges(brep: &Brep, cut: &TessellatedBrep) -> Vec<Edge> {
    let TessellatedBrep { mesh, edges, faces, .. } = cut;
    let segments = edges.iter().flat_map(|chain| chain.windows(2)).map(|s| pair(s[0], s[1]));
    let sides = Sides::new(mesh, segments);
    let mut drawn = Vec::new();
    for (number, chain) in edges.iter().enumerate() {
        let uses = brep.uses(number);
        let is_seam = matches!(uses, [one, other] if one.face == other.face);
        let is_within = matches!(uses, [one, other] if is_one(&brep.surface_form(one.face), &brep.surface_form(other.face)));
        if chain.len() < 2 {
            continue;
        }
        let beside: Vec<&[Side]> = chain.windows(2).map(|s| sides.at(s[0], s[1])).collect();
        // The surface closes there with a corner: to the eye it is an edge as any other.
        if is_seam && let Some(edge) = bent_edge(&sides, chain.clone()) {
            drawn.push(edge);
            continue;
        }
        if is_seam || is_within {
            // No edge of the shape, and yet it may turn away from the viewer just there.
            let both = |list: &&[Side]| match list {
                [(one, _), (other, _)] => Some([*one, *other]),
                _ => None,
            };
            if let Some(beside) = beside.iter().map(both).collect() {
                drawn.push(Edge { kind: Kind::Within, points: chain.clone(), beside });
            }
            continue;
        }
        let two = |list: &&[Side]| match list {
            [one, other] if faces[one.0 as usize] != faces[other.0 as usize] => {
                Some(([one.0, other.0], sides.is_smooth(one, other)))
            }
            _ => None,
        };
        let found: Option<Vec<_>> = beside.iter().map(two).collect();
        let (kind, beside) = match found {
            None => (Kind::Open, Vec::new()),
            Some(list) if list.iter().all(|(_, smooth)| *smooth) => {
                (Kind::Smooth, list.into_iter().map(|(beside, _)| beside).collect())
            }
            Some(_) => (Kind::Sharp, Vec::new()),
        };
        drawn.push(Edge { kind, points: chain.clone(), beside });
    }
    drawn.extend(creases(cut));
    drawn
}

/// Whether two forms are the same set of points, to what files write of them.
fn is_one(one: &SurfaceForm, other: &SurfaceForm) -> bool {
    use SurfaceForm as Form;
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-6 * size.abs();
    // How far the second frame's origin is along the first one's axis and off it, where both axes are one way or opposite.
    let axis = |one: &Frame, other: &Frame| {
        let along = one.z.dot(&(other.origin - one.origin));
        let off = (other.origin - one.origin - one.z * along).norm();
        (one.z.cross(&other.z).norm() <= 1e-6).then(|| (along, off, one.z.dot(&other.z).signum()))
    };
    match (one, other) {
        (Form::Plane { frame }, Form::Plane { frame: other }) => {
            let away = frame.z.dot(&(other.origin - frame.origin));
            let far = (other.origin - frame.origin).norm();
            frame.z.cross(&other.z).norm() <= 1e-6 && away.abs() <= 1e-6 * far
        }
        (Form::Cylinder { frame, radius }, Form::Cylinder { frame: other, radius: r }) => {
            near(*radius, *r, *radius) && axis(frame, other).is_some_and(|(_, off, _)| off <= 1e-6 * radius)
        }
        (Form::Cone { frame, radius, angle }, Form::Cone { frame: other, radius: r, angle: a }) => {
            near(*angle, *a, 1.0)
                && axis(frame, other).is_some_and(|(along, off, way)| {
                    let here = radius + along * angle.tan();
                    way > 0.0 && off <= 1e-6 * radius.max(*r) && near(here, *r, radius.max(*r))
                })
        }
        (Form::Sphere { frame, radius }, Form::Sphere { frame: other, radius: r }) => {
            near(*radius, *r, *radius) && (frame.origin - other.origin).norm() <= 1e-6 * radius
        }
        (Form::Torus { frame, major, minor }, Form::Torus { frame: other, major: m, minor: n }) => {
            near(*major, *m, *major)
                && near(*minor, *n, *minor)
                && axis(frame, other)
                    .is_some_and(|(along, off, _)| along.abs() <= 1e-6 * major && off <= 1e-6 * major)
        }
        _ => false,
    }
}

/// The Breps of all scenes that a picture shows, each cut once, whoever shows it.
#[derive(Debug, Default)]
pub(crate) struct Solids(HashMap<usize, std::result::Result<Arc<Solid>, String>>);

impl Solids {
    /// Cuts all Breps, as finely as the largest of their places in the first scene needs.
    ///
    /// # Errors
    /// When a hierarchy is broken.
    pub(crate) fn of(scenes: &[&Scene], tessellator: Option<&dyn Tessellator>) -> Result<Self> {
        let mut all: BTreeMap<usize, (&Brep, f64, usize)> = BTreeMap::new();
        let mut range: Option<(Point, Point)> = None;
        let mut order = 0;
        let mut number: HashMap<usize, usize> = HashMap::new();
        for scene in scenes {
            for (object, map) in scene.objects().iter().zip(scene.world_transforms()?) {
                // By how much lengths may grow.
                let stretch = map.map_or(1.0, |map| map.fixed_view::<3, 3>(0, 0).norm());
                let points = match object.geometry() {
                    Geometry::Brep(brep) => {
                        let at = *number.entry(object.geometry_id()).or_insert_with(|| {
                            order += 1;
                            order
                        });
                        let entry = all.entry(at).or_insert((brep, 0.0, object.geometry_id()));
                        entry.1 = entry.1.max(stretch);
                        brep.vertices()
                    }
                    other => other.points(),
                };
                for p in points {
                    let p = map.as_ref().map_or(*p, |map| map.transform_point(p));
                    let (low, high) = range.unwrap_or((p, p));
                    range = Some((low.inf(&p), high.sup(&p)));
                }
            }
        }
        let extent = range.map_or(0.0, |(low, high)| (high - low).amax());
        let mut solids = HashMap::new();
        for (_, (brep, stretch, id)) in all {
            // A closed face has no vertices, or one.
            let length = CHORD * extent / stretch;
            let is_length = brep.vertices().len() > 1 && length.is_finite() && length > 0.0;
            let chord = if is_length { Chord::Absolute(length) } else { Chord::Relative(CHORD) };
            let fineness = Fineness { chord, angle: ANGLE.to_radians() };
            let made = match tessellator {
                None => Err("it needs a tessellator, and none was given".to_owned()),
                Some(by) => Solid::of(brep, &fineness, by).map(Arc::new).map_err(|e| clip(&e.to_string())),
            };
            solids.insert(id, made);
        }
        Ok(Self(solids))
    }

    /// That of the geometry of this [number](loftsman_kernel::scene::Object::geometry_id), or why there is none; `None` where it is no Brep.
    pub(crate) fn get(&self, geometry: usize) -> Option<&std::result::Result<Arc<Solid>, String>> {
        self.0.get(&geometry)
    }
}
