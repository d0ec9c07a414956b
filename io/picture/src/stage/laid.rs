//! Triangles of a plug-in's surface that know where on it they are: their normals, the borders of its faces and the values at its places.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::CustomShape;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::curvature::SurfaceCurvature;
use loftsman_kernel::{Result, Vector, parallel};

use super::shell::{Edge, Kind, Shell, Sides, Skin, pair};
use crate::chain::linked;

/// What has no value at a corner of triangles has those so far into each of them, as a part of the way to the side beyond.
const BESIDE: f64 = 0.25;

/// Inside a triangle and yet as good as at its corner, by the same measure.
const INSIDE: f64 = 1.0 / 64.0;

/// What triangles are laid over.
#[derive(Debug, Clone)]
pub(crate) struct Laid {
    /// The surface, on the stage.
    pub(super) shape: CustomShape,
    /// Of each triangle the places of its corners.
    pub(super) corners: Vec<[u32; 3]>,
    /// Places on the surface. A point has one on each face that it is on.
    pub(super) places: Vec<Location>,
    /// For each point the first of those that are doubled from one.
    pub(super) origins: Vec<u32>,
    /// How many sides of faces all smooth edges consist of, each counted for the face on one side.
    pub(crate) sides: usize,
}

impl Laid {
    /// Triangles of a surface as they are drawn: `corners` says where each of their corners is. `None` where they say nothing.
    ///
    /// # Errors
    /// When the mesh is broken, or the shape of a plug-in that is not here.
    pub(crate) fn shell(shape: CustomShape, mut mesh: Mesh, corners: &[Location]) -> Result<Option<Shell>> {
        let count = mesh.starts().len().saturating_sub(1);
        let on_surface = |at: &Location| parameters(*at).is_some();
        if count == 0
            || corners.len() != 3 * count
            || mesh.corners().len() != 3 * count
            || !corners.iter().all(on_surface)
        {
            return Ok(None);
        }
        (mesh.uvs, mesh.colors, mesh.tangents, mesh.more_uvs) =
            (Layer::none(), Layer::none(), Layer::none(), Vec::new());
        let (edges, sides) = borders(shape.shape()?, &mesh, corners);
        let flat = mesh.by_point()?;
        let of_old = 0..mesh.points().len() as u32;
        let origins: Vec<u32> = of_old.chain(flat.doubled.iter().copied()).collect();
        let triangles: Vec<[u32; 3]> = flat.mesh.faces().map(|face| [face[0], face[1], face[2]]).collect();
        let (mut known, mut places) = (HashMap::new(), Vec::new());
        let place = |(at, point): (&Location, u32)| {
            let (face, [u, v]) = parameters(*at).unwrap_or_default();
            *known.entry((point, face, u.to_bits(), v.to_bits())).or_insert_with(|| {
                places.push(*at);
                places.len() as u32 - 1
            })
        };
        let all: Vec<u32> = corners.iter().zip(triangles.iter().flatten().copied()).map(place).collect();
        let corners: Vec<[u32; 3]> = all.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        let points = flat.mesh.points().iter().map(|p| p.coords).collect::<Vec<_>>();
        let given = |p: usize| flat.mesh.normals.values().get(p).copied().unwrap_or_else(Vector::zeros);
        let mut normals: Vec<Vector> = (0..points.len()).map(given).collect();
        let laid = Self { shape, corners, places, origins, sides };
        if laid.shape.shape()?.faces().is_none() {
            // One patch has one normal everywhere; a surface of many is asked for those of its creases by its plug-in.
            for (triangle, own) in triangles.iter().zip(&laid.corners) {
                for (&point, &place) in triangle.iter().zip(own) {
                    let normal = &mut normals[point as usize];
                    *normal = laid.normal(laid.places[place as usize], normal).unwrap_or(*normal);
                }
            }
        }
        let slots = vec![0; triangles.len()];
        let skin = Arc::new(Skin { triangles, colors: vec![None], slots, edges });
        Ok(Some(Shell { skin, points, normals, laid: Some(laid) }))
    }

    /// The first of the points that are doubled from the same one as a point.
    pub(super) fn origin(&self, point: u32) -> u32 {
        self.origins.get(point as usize).copied().unwrap_or(point)
    }

    /// Whether it is a surface of many faces.
    pub(crate) fn has_faces(&self) -> bool {
        self.places.first().is_some_and(|at| at.is_on_face())
    }

    /// The surface; `None` for none.
    pub(crate) fn surface(&self) -> Option<&dyn Shape> {
        self.shape.shape().ok()
    }

    /// Its curvature at a place; `None` where it has none, as at a pole.
    pub(crate) fn curvature(&self, at: Location) -> Option<SurfaceCurvature> {
        SurfaceCurvature::of(self.surface()?, at).ok().flatten()
    }

    /// Gives each triangle places of its own, a little inside, where second derivatives jump within faces: between pieces of degree 2, which begin
    /// and end where corners of triangles are, so that a value there is that of one of them or another.
    pub(crate) fn part(&mut self) {
        let first = self.surface().and_then(Shape::cells).and_then(|cells| cells.iter().next());
        if !first.is_some_and(|cell| cell.sides.iter().any(|side| side.degree < 3)) {
            return;
        }
        let own = |corners: &[u32; 3]| {
            [0, 1, 2].map(|k| {
                let mut shares = [0.5 * INSIDE; 3];
                shares[k] = 1.0 - INSIDE;
                self.within(corners, shares).unwrap_or(self.places[corners[k] as usize])
            })
        };
        self.places = self.corners.iter().flat_map(own).collect();
        self.corners = (0..self.corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    }

    /// The unit normal at a place, on the side of another vector; `None` where the surface has none.
    pub(super) fn normal(&self, at: Location, side: &Vector) -> Option<Vector> {
        let shape = self.surface()?;
        let along = |by: [usize; 2]| shape.value(at, Derivative::from(by)).ok()?.try_normalize(0.0);
        let normal = along([1, 0])?.cross(&along([0, 1])?).try_normalize(1e-9)?;
        Some(if normal.dot(side) < 0.0 { -normal } else { normal })
    }

    /// The values of a function of places ([`Shell::painted_at`]). Where it has none, as at an extraordinary vertex, it is the mean of those just
    /// beside, in all triangles at the point; where there are none either, that of its neighbours; and 0 where there is none at all.
    /// Beside them, at how many points it has none.
    pub(crate) fn values(
        &self,
        skin: &Skin,
        value: impl Fn(Location) -> Option<f64> + Sync,
    ) -> (Vec<f64>, usize) {
        let mut found = parallel::map(self.places.len(), |k| value(self.places[k]));
        let mut without = BTreeSet::new();
        let mut beside: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
        for (triangle, own) in skin.triangles.iter().zip(&self.corners) {
            for k in (0..3).filter(|&k| found[own[k] as usize].is_none()) {
                let mut shares = [0.5 * BESIDE; 3];
                shares[k] = 1.0 - BESIDE;
                without.insert(self.origin(triangle[k]));
                if let Some(value) = self.within(own, shares).and_then(&value) {
                    let (sum, count) = beside.entry(triangle[k]).or_default();
                    (*sum, *count) = (*sum + value, *count + 1.0);
                }
            }
        }
        for (triangle, own) in skin.triangles.iter().zip(&self.corners) {
            for (point, place) in triangle.iter().zip(own) {
                let value = &mut found[*place as usize];
                *value = value.or_else(|| beside.get(point).map(|(sum, count)| sum / count));
            }
        }
        self.spread(&mut found);
        (found.into_iter().map(|value| value.unwrap_or(0.0)).collect(), without.len())
    }

    /// The values of a function of points, at each place of a shell that is laid so.
    pub(crate) fn values_of_points(
        &self,
        shell: &Shell,
        value: impl Fn(&Vector) -> Option<f64> + Sync,
    ) -> Vec<f64> {
        let of_points = parallel::map(shell.points.len(), |k| value(&shell.points[k]));
        let mut found = vec![None; self.places.len()];
        for (triangle, own) in shell.skin.triangles.iter().zip(&self.corners) {
            for (point, place) in triangle.iter().zip(own) {
                found[*place as usize] = of_points[*point as usize];
            }
        }
        self.spread(&mut found);
        found.into_iter().map(|value| value.unwrap_or(0.0)).collect()
    }

    /// Values at places as often as they are there to see: as many as there are places, each for the same area. Triangles are small where the
    /// surface bends.
    pub(crate) fn by_area(shell: &Shell, values: &[f64]) -> Vec<f64> {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|k| shell.points[k as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let unit = shell.skin.triangles.iter().map(area).sum::<f64>() / values.len() as f64;
        let mut found = Vec::with_capacity(values.len());
        let mut open = 0.0;
        for (number, triangle) in shell.skin.triangles.iter().enumerate() {
            open += area(triangle);
            while open >= unit && found.len() < values.len() {
                let corner = shell.painted_at(number)[found.len() % 3];
                found.extend(values.get(corner));
                open -= unit;
            }
        }
        found
    }

    /// Gives places without a value the mean of those of their triangles that have one, from one to the next.
    fn spread(&self, values: &mut [Option<f64>]) {
        while values.iter().any(Option::is_none) {
            let mut sums: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
            for own in &self.corners {
                let known = || own.iter().filter_map(|&k| values[k as usize]);
                for &k in own.iter().filter(|&&k| values[k as usize].is_none()) {
                    let (sum, count) = sums.entry(k).or_default();
                    (*sum, *count) = (*sum + known().sum::<f64>(), *count + known().count() as f64);
                }
            }
            let before = values.iter().flatten().count();
            for (k, (sum, count)) in sums {
                values[k as usize] = (count > 0.0).then(|| sum / count);
            }
            if values.iter().flatten().count() == before {
                return;
            }
        }
    }

    /// The place within a triangle that has these shares of its corners; `None` where these are not on one face.
    pub(super) fn within(&self, corners: &[u32; 3], shares: [f64; 3]) -> Option<Location> {
        let place = |k: usize| self.places[corners[k] as usize];
        let (_, at) = parameters(Location::mean(&[0, 1, 2].map(|k| (place(k), shares[k])))?)?;
        Some(self.clamped(place(0), at))
    }

    /// The place with these parameters on the face of another, or the nearest in its domain.
    pub(super) fn clamped(&self, on: Location, at: [f64; 2]) -> Location {
        let domain = self.surface().and_then(|shape| domain(shape, on));
        let [u, v] = [0, 1].map(|k| match domain {
            Some(domain) => at[k].clamp(domain[k][0], domain[k][1]),
            None => at[k],
        });
        match on {
            Location::Face(face, ..) => Location::Face(face, u, v),
            _ => Location::Surface(u, v),
        }
    }
}

/// The face of a place, 0 where there is one only, and its parameters; `None` of what is on no surface.
pub(super) fn parameters(at: Location) -> Option<(u32, [f64; 2])> {
    match at {
        Location::Face(face, u, v) => Some((face, [u, v])),
        Location::Surface(u, v) => Some((0, [u, v])),
        _ => None,
    }
}

/// From where to where both parameters of the face of a place go.
fn domain(shape: &dyn Shape, at: Location) -> Option<[[f64; 2]; 2]> {
    let all = match at {
        Location::Face(face, ..) => shape.face_domain(face),
        _ => shape.domain(),
    };
    match all[..] {
        [u, v] => Some([u, v].map(|side| [side.start, side.end])),
        _ => None,
    }
}

/// On which side of its face two places are, of four; of a direction that closes none is one.
fn side(shape: &dyn Shape, one: Location, other: Location) -> Option<(u32, u8)> {
    let (face, a) = parameters(one)?;
    let (_, b) = parameters(other)?;
    let all = if one.is_on_face() { shape.face_domain(face) } else { shape.domain() };
    for (k, direction) in all.iter().enumerate().take(2).filter(|(_, direction)| !direction.periodic) {
        for (end, at) in [direction.start, direction.end].into_iter().enumerate() {
            if a[k] == at && b[k] == at {
                return Some((face, (2 * k + end) as u8));
            }
        }
    }
    None
}

/// The borders of the faces, as edges, and how many sides of faces the smooth ones consist of.
fn borders(shape: &dyn Shape, mesh: &Mesh, corners: &[Location]) -> (Vec<Edge>, usize) {
    let mut found: Vec<((u32, u32), (u32, u8))> = Vec::new();
    for (points, at) in mesh.corners().chunks_exact(3).zip(corners.chunks_exact(3)) {
        for k in 0..3 {
            let next = (k + 1) % 3;
            let of = side(shape, at[k], at[next]);
            found.extend(of.map(|side| (pair(points[k], points[next]), side)));
        }
    }
    found.sort_unstable();
    let sides = Sides::new(mesh, found.iter().map(|(pair, _)| *pair));
    let kinds = [Kind::Smooth, Kind::Sharp, Kind::Open];
    let mut segments: [Vec<(usize, usize)>; 3] = Default::default();
    let mut smooth = Vec::new();
    for run in found.chunk_by(|a, b| a.0 == b.0) {
        let (a, b) = run[0].0;
        let kind = match sides.at(a, b) {
            [one, other] if sides.is_smooth(one, other) => 0,
            [_, _] => 1,
            _ => 2,
        };
        segments[kind].push((a as usize, b as usize));
        if kind == 0 {
            smooth.push(run[0].1);
        }
    }
    smooth.sort_unstable();
    smooth.dedup();
    let chains = |(kind, segments): (Kind, &Vec<(usize, usize)>)| {
        let chains = linked(segments).into_iter();
        chains
            .map(|chain| chain.into_iter().map(|k| k as u32).collect())
            .map(|points| Edge { kind, points, beside: Vec::new() })
            .collect::<Vec<_>>()
    };
    (kinds.into_iter().zip(&segments).flat_map(chains).collect(), smooth.len())
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::plugin::{Chord, Drawn, Fineness};
    use loftsman_subdivision::doo_sabin::DooSabinSurface;
    use loftsman_subdivision::{Cage, SubdivisionSurface};

    use super::super::finer::finer;
    use super::*;

    fn laid(shape: CustomShape) -> Laid {
        let found = shape.tessellate(&Fineness { chord: Chord::Relative(1e-2), angle: 1.0 }).unwrap();
        let Drawn::Mesh(mesh) = found.drawn else { panic!("a surface") };
        let shell = Laid::shell(shape, mesh, &found.corners).unwrap().unwrap();
        finer(&shell).unwrap().laid.unwrap()
    }

    /// At how many corners of triangles the mean curvature is another a little further inside: it jumps there. Those that have none at a corner are left
    /// out, for round an extraordinary point it goes on and on.
    fn jumps(laid: &Laid) -> usize {
        let mean = |at: Location| laid.curvature(at).map(|found| found.mean);
        let at_corner = |own: &[u32; 3], k: usize| {
            let inside = [0, 1, 2].map(|j| if j == k { 0.96 } else { 0.02 });
            let [one, other] = [laid.places[own[k] as usize], laid.within(own, inside)?].map(mean);
            Some((one? - other?).abs() > 0.1 * one?.abs())
        };
        let jumps = laid.corners.iter().map(|own| [0, 1, 2].map(|k| at_corner(own, k)));
        jumps.filter(|at| at.iter().all(Option::is_some)).flatten().filter(|jump| *jump == Some(true)).count()
    }

    #[test]
    fn each_triangle_has_the_curvature_of_its_own_piece() {
        let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cage = || Cage::new((0..8).map(corner).collect(), &faces).unwrap();
        let mut biquadratic = laid(DooSabinSurface::new(cage()).unwrap().into());
        let before = jumps(&biquadratic);
        biquadratic.part();
        let after = jumps(&biquadratic);
        assert!(before > 100 && after * 20 < before, "{before} {after}");
        // Bicubic pieces go on smoothly, and keep the places that they share.
        let mut bicubic = laid(SubdivisionSurface::new(cage()).unwrap().into());
        let places = bicubic.places.clone();
        bicubic.part();
        assert_eq!(bicubic.places, places);
    }
}
