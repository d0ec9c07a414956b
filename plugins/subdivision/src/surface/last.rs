//! The last pieces at an extraordinary vertex: one Bézier patch each, and how near it is.

use std::collections::BTreeMap;

use loftsman_kernel::Vector;

use super::left_out::first_of;
use super::net::{Net, bezier, cut, hull_of, largest, net_of, turned};
use super::pattern::Quadrant;
use super::template::{Near, Templates};
use crate::cage::Cage;
use crate::catmull_clark::limit_stencils;
use crate::error::Result;
use crate::topology::Topology;

/// Levels that are compared, at most.
const LEVELS: u32 = 40;

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
        let start = self.position;
        // What the second point would have to be, less the first, for the curve to pass through the middle.
        let through = (middle * 8.0 - start * 4.0 - far[0] * 3.0 - far[1]) / 3.0;
        let step = match self.along.get(&edge).map(|t| (t, t.norm_squared())) {
            Some((t, size)) if size > 0.0 && through.dot(t) > 0.0 => t * (through.dot(t) / size),
            _ => through,
        };
        [start, start + step, far[0], far[1]]
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
        let quad = Quad { templates, cage, near };
        let Some(patch) = quad.patch(corner, edges(cage.topology(), face, at), &mut sides)? else {
            return Ok(None);
        };
        match quad.apart(&patch, tolerance)? {
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

    /// The Bézier points of the surface over a regular quadrant.
    fn piece(&self, quadrant: Quadrant) -> Result<Option<Net>> {
        let piece = self.templates.piece(self.cage, &self.near, quadrant)?;
        Ok(piece.map(|piece| bezier(&net_of(&piece, |k| self.point(k)))))
    }

    /// The Bézier points of the surface at a corner of a quadrant of the first level, and how many times the quad is as large: where the
    /// quadrant is no piece, those of its part there.
    fn at_corner(&self, quadrant: Quadrant, corner: usize) -> Result<Option<(Net, f64)>> {
        if let Some(net) = self.piece(quadrant)? {
            return Ok(Some((net, 2.0)));
        }
        Ok(self.piece(quadrant.parts()[corner])?.map(|net| (net, 4.0)))
    }

    /// The patch; sides that a neighbour has had are its.
    fn patch(
        &self,
        corner: &Corner,
        edges: [u32; 2],
        sides: &mut BTreeMap<u32, [Vector; 4]>,
    ) -> Result<Option<Net>> {
        let [_, one, two, three] = Quadrant::WHOLE.parts();
        let mut all = [Vector::zeros(); 16];
        // Each regular corner, seen from there: position, slopes and twist of the quadrant, which is half as large or less.
        for (turn, quadrant) in [(1, one), (2, two), (3, three)] {
            let Some((piece, times)) = self.at_corner(quadrant, turn)? else { return Ok(None) };
            let own = turned(&piece, turn);
            let (a, b, c, d) = (own[0], own[4], own[1], own[5]);
            let (u, v) = (a + (b - a) * times, a + (c - a) * times);
            let seen = [(0, a), (4, u), (1, v), (5, u + v - a + (d - b - c + a) * (times * times))];
            let mut other = turned(&all, turn);
            seen.into_iter().for_each(|(k, p)| other[k] = p);
            all = turned(&other, 4 - turn);
        }
        let (Some((one, _)), Some((two, _)), Some((three, _))) =
            (self.at_corner(one, 0)?, self.at_corner(two, 0)?, self.at_corner(three, 0)?)
        else {
            return Ok(None);
        };
        // Along u from the corner, and along v: what is known of either side are its last two points.
        let along_u =
            *sides.entry(edges[0]).or_insert_with(|| corner.side(edges[0], one[0], [all[8], all[12]]));
        let along_v =
            *sides.entry(edges[1]).or_insert_with(|| corner.side(edges[1], three[0], [all[2], all[3]]));
        for k in 0..4 {
            (all[4 * k], all[k]) = (along_u[k], along_v[k]);
        }
        // The last point so that the middle is the surface's.
        let weights = [1.0, 3.0, 3.0, 1.0];
        let others = (0..16).filter(|k| *k != 5);
        let sum = others.fold(Vector::zeros(), |sum, k| sum + all[k] * (weights[k / 4] * weights[k % 4]));
        all[5] = (two[0] * 64.0 - sum) / 9.0;
        Ok(Some(all))
    }

    /// A bound of the distance of points of equal parameters; `None` where that is more than the tolerance.
    fn apart(&self, patch: &Net, tolerance: f64) -> Result<Option<f64>> {
        let size = largest(patch.iter().map(Vector::amax));
        let mut most = 64.0 * f64::EPSILON * size;
        for level in 1..=LEVELS {
            let part = 0.5_f64.powi(level as i32);
            let mut rest = first_of(level - 1).parts()[1..].to_vec();
            while let Some(quadrant) = rest.pop() {
                let piece = match self.piece(quadrant)? {
                    Some(piece) => piece,
                    None if quadrant.level == level => {
                        rest.extend(quadrant.parts());
                        continue;
                    }
                    None => return Ok(None),
                };
                let part = 0.5_f64.powi(quadrant.level as i32);
                let side = |k: u64| [k as f64 * part, (k + 1) as f64 * part];
                let own = cut(patch, side(quadrant.i), side(quadrant.j));
                let apart = piece.iter().zip(&own).map(|(a, b)| (a - b).norm());
                most = most.max(largest(apart));
            }
            if most > tolerance {
                return Ok(None);
            }
            let local = self.templates.local(self.cage, &self.near, first_of(level))?;
            let hull = hull_of(&local, |k| self.point(k));
            let own = cut(patch, [0.0, part], [0.0, part]);
            let pairs = hull.iter().flat_map(|a| own.iter().map(move |b| (a - b).norm()));
            let rest = largest(pairs);
            if rest <= most || (level == LEVELS && rest <= tolerance) {
                return Ok(Some(most.max(rest)));
            }
        }
        Ok(None)
    }
}
