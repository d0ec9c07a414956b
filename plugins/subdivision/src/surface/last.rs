//! The last pieces at an extraordinary vertex: one Bézier patch each, and how near it is.

use std::collections::BTreeMap;

use loftsman_kernel::Vector;

use super::fill::{self, Surrounded};
use super::left_out::first_of;
use super::net::{Net, bezier_of, hull_of};
use super::pattern::Quadrant;
use super::template::{Near, Templates};
use crate::cage::Cage;
use crate::catmull_clark::limit_stencils;
use crate::error::Result;
use crate::topology::Topology;

/// The limit of an extraordinary vertex.
pub(super) struct Corner {
    position: Vector,
    /// The directions along its edges, by their number; none where it is not smooth.
    along: BTreeMap<u32, Vector>,
}

impl Corner {
    pub(super) fn new(cage: &Cage, vertex: usize) -> Result<Self> {
        let limit = limit_stencils(cage, vertex, 0)?;
        let [a, b] = limit.tangents.map(|t| t.apply(cage.points()));
        let topology = cage.topology();
        let edges: Vec<u32> = topology.vertex_edges(vertex).collect();
        let smooth = !cage.has_intervals()
            && edges.len() > 2
            && cage.vertex_sharpness(vertex) <= 0.0
            && edges.iter().all(|&e| cage.sharpness(e as usize) <= 0.0);
        let mut along = BTreeMap::new();
        if smooth {
            for (k, &edge) in edges.iter().enumerate() {
                // The first wave is along edge 0; the others are turned from it.
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / edges.len() as f64).sin_cos();
                along.insert(edge, a * cos + b * sin);
            }
        }
        Ok(Self { position: limit.position.apply(cage.points()), along })
    }

    /// The Bézier points of the side along an edge: of `far`, its last two are known, and of the surface its middle.
    fn side(&self, edge: u32, middle: Vector, far: [Vector; 2]) -> [Vector; 4] {
        fill::side(self.position, self.along.get(&edge), middle, far)
    }
}

/// The patches over the quads of a vertex, each given with the corner where that is, from this corner on and counterclockwise; and a bound
/// of their distance from the surface. `None` where that is more than the tolerance.
pub(super) fn fan(
    templates: &Templates,
    cage: &Cage,
    corner: &Corner,
    quads: &[(usize, usize)],
    tolerance: f64,
) -> Result<Option<(Vec<Net>, f64)>> {
    let mut sides = BTreeMap::new();
    let (mut patches, mut most) = (Vec::with_capacity(quads.len()), 0.0_f64);
    for &(face, at) in quads {
        let near = Near::from_corner(cage, face, at)?;
        let mut quad = Quad { templates, cage, near };
        let Some(patch) = quad.patch(corner, edges(cage.topology(), face, at), &mut sides)? else {
            return Ok(None);
        };
        match fill::apart(&patch, tolerance, &mut quad)? {
            Some(apart) => most = most.max(apart),
            None => return Ok(None),
        }
        patches.push(patch);
    }
    Ok(Some((patches, most)))
}

/// The edges from a corner of a quad: the one that follows, and the one before.
fn edges(topology: &Topology, face: usize, corner: usize) -> [u32; 2] {
    let all = topology.face_edges(face);
    [all[corner], all[(corner + 3) % 4]]
}

/// A quad with one extraordinary corner, its first.
struct Quad<'a> {
    templates: &'a Templates,
    cage: &'a Cage,
    near: Near,
}

impl Quad<'_> {
    fn point(&self, k: usize) -> Vector {
        self.cage.points()[self.near.base[k] as usize].coords
    }

    /// The Bézier points of the surface at a corner of a quadrant of the first level, and how many times the quad is as large: where the
    /// quadrant is no piece, those of its part there.
    fn at_corner(&mut self, quadrant: Quadrant, corner: usize) -> Result<Option<(Net, f64)>> {
        if let Some(net) = self.piece(quadrant)? {
            return Ok(Some((net, 2.0)));
        }
        Ok(self.piece(quadrant.parts()[corner])?.map(|net| (net, 4.0)))
    }

    /// The patch; sides that a neighbour has had are its.
    fn patch(
        &mut self,
        corner: &Corner,
        edges: [u32; 2],
        sides: &mut BTreeMap<u32, [Vector; 4]>,
    ) -> Result<Option<Net>> {
        let parts = Quadrant::WHOLE.parts();
        let mut regular = [([Vector::zeros(); 16], 1.0); 3];
        let mut middles = [Vector::zeros(); 3];
        for k in 1..4 {
            let (Some(far), Some((near, _))) = (self.at_corner(parts[k], k)?, self.at_corner(parts[k], 0)?)
            else {
                return Ok(None);
            };
            (regular[k - 1], middles[k - 1]) = (far, near[0]);
        }
        let mut all = fill::around(&regular);
        // Along u from the corner, and along v: what is known of either side are its last two points.
        let along_u =
            *sides.entry(edges[0]).or_insert_with(|| corner.side(edges[0], middles[0], [all[8], all[12]]));
        let along_v =
            *sides.entry(edges[1]).or_insert_with(|| corner.side(edges[1], middles[2], [all[2], all[3]]));
        fill::close(&mut all, along_u, along_v, middles[1]);
        Ok(Some(all))
    }
}

impl Surrounded for Quad<'_> {
    fn piece(&mut self, quadrant: Quadrant) -> Result<Option<Net>> {
        let piece = self.templates.piece(self.cage, &self.near, quadrant)?;
        Ok(piece.map(|piece| bezier_of(&piece, |k| self.point(k))))
    }

    fn hull(&mut self, level: u32) -> Result<Vec<Vector>> {
        let local = self.templates.local(self.cage, &self.near, first_of(level))?;
        Ok(hull_of(&local, |k| self.point(k)))
    }
}
