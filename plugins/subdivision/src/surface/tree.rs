//! Faces of a cage, refined as far as each needs.
//!
//! A face is refined with nothing but the faces round it, for what it becomes depends on nothing else. Faces that are refined together
//! are a batch: a cage of their own, in which the faces on the rim are there for the sake of the others only.

use std::collections::HashMap;

use loftsman_kernel::error::Result;
use loftsman_kernel::{Point, Vector};

use super::apart::{Apart, Over};
use super::facing::Scheme;
use super::ground::Ground;
use super::net::{Net, bezier, bezier_of, hull_of};
use super::pattern::{Pattern, Quadrant};
use super::places::Place;
use super::quads::Quads;
use super::refused;
use super::regular;
use super::template::Templates;
use crate::cage::Cage;
use crate::catmull_clark::{limit_frames_of, refine, side_normals};
use crate::part::Part;
use crate::topology::NONE;

/// Faces that were refined together, in each state.
struct Batch {
    cages: Vec<Cage>,
    /// The number of each vertex among all points; [`NONE`] on the rim.
    names: Vec<u32>,
    /// The unit normal of each vertex that has a number, in each state.
    normals: Vec<Vec<Option<Vector>>>,
    /// The unit normals of corners of faces, by their half-edges, where a vertex has more than one; in the first state.
    sides: HashMap<u32, Option<Vector>>,
}

/// A face of a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    batch: u32,
    face: u32,
}

/// All that was refined.
pub(super) struct Batches {
    all: Vec<Batch>,
    templates: Templates,
}

impl Batches {
    /// The faces that are shown, of the same cage in several states. `first` is the number of the surface's first face on each.
    pub(super) fn new(cages: Vec<Cage>, first: &[u32]) -> Result<(Self, Quads<Own>)> {
        let count = cages[0].points().len();
        let mut quads = Quads::new(cages.len());
        let names: Vec<u32> = (0..count).map(|_| quads.name()).collect();
        let cage = &cages[0];
        for face in (0..cage.topology().face_count()).filter(|&face| !cage.is_hole(face)) {
            let corners = cage.topology().face(face);
            let place = if corners.len() == 4 { Ok(Place::whole(first[face])) } else { Err(first[face]) };
            quads.add(Own { batch: 0, face: face as u32 }, corners.into(), place);
        }
        let mut batches = Self { all: Vec::new(), templates: Templates::default() };
        batches.add(&mut quads, cages, names, 0..count as u32)?;
        Ok((batches, quads))
    }

    /// Adds cages; the limits of the vertices that are numbered from `fresh` on are put down.
    fn add(
        &mut self,
        quads: &mut Quads<Own>,
        cages: Vec<Cage>,
        names: Vec<u32>,
        fresh: std::ops::Range<u32>,
    ) -> Result<()> {
        let named: Vec<u32> = (0..names.len() as u32).filter(|&v| names[v as usize] != NONE).collect();
        let mut normals = vec![vec![None; names.len()]; cages.len()];
        for (state, cage) in cages.iter().enumerate() {
            let frames = limit_frames_of(cage, &named).map_err(refused)?;
            for (&v, frame) in named.iter().zip(frames) {
                let name = names[v as usize] as usize;
                let normal = frame.normal();
                normals[state][v as usize] = normal;
                if fresh.contains(&(name as u32)) {
                    quads.points[state][name] = frame.point;
                    if state == 0 {
                        quads.normals[name] = normal;
                    }
                }
            }
        }
        let sides = side_normals(&cages[0], &named).map_err(refused)?.into_iter().collect();
        self.all.push(Batch { cages, names, normals, sides });
        Ok(())
    }

    fn refine_batch(&mut self, quads: &mut Quads<Own>, batch: usize, nodes: &[usize]) -> Result<()> {
        let (cages, names) = (&self.all[batch].cages, &self.all[batch].names);
        let topology = cages[0].topology();
        let mut faces: Vec<usize> = nodes.iter().map(|&k| quads.all[k].own.face as usize).collect();
        // Where most are refined, all are: that is plain arithmetic.
        let (before, names) = if 2 * faces.len() > topology.face_count() {
            (cages.clone(), names.clone())
        } else {
            let part = Part::to_refine(&cages[0], &faces);
            let first = part.to_cage(&cages[0]).map_err(refused)?;
            let moved = cages.iter().map(|cage| Cage {
                points: part.kept.iter().map(|&v| cage.points()[v as usize]).collect(),
                ..first.clone()
            });
            let names = part.kept.iter().map(|&v| names[v as usize]).collect();
            let all = moved.collect();
            faces = (0..faces.len()).collect();
            (all, names)
        };
        let old = before[0].shared_topology();
        let (vertices, edges) = (old.vertex_count(), old.edge_count());
        let mut names_after = vec![NONE; vertices + edges + old.face_count()];
        let start = quads.normals.len() as u32;
        let batch = self.all.len() as u32;
        for (&node, &face) in nodes.iter().zip(&faces) {
            let corners = old.face(face);
            let count = corners.len();
            for (k, (&v, &edge)) in corners.iter().zip(old.face_edges(face)).enumerate() {
                names_after[v as usize] = names[v as usize];
                let [a, b] = [v, corners[(k + 1) % count]].map(|v| names[v as usize]);
                names_after[vertices + edge as usize] = quads.name_middle(a, b);
            }
            let middle = quads.name();
            names_after[vertices + edges + face] = middle;
            let (place, start) = (quads.all[node].place, old.face_corners(face).start);
            let middle_of = |k: usize| names_after[vertices + old.face_edges(face)[k] as usize];
            let children = (0..count).map(|corner| {
                let own = Own { batch, face: (start + corner) as u32 };
                let name = names[corners[corner] as usize];
                let corners = [name, middle_of(corner), middle, middle_of((corner + count - 1) % count)];
                let place = match place {
                    Ok(place) => Place::child(Some(place), NONE, corner),
                    Err(first) => Place::child(None, first, corner),
                };
                (own, corners.into(), place)
            });
            quads.add_children(node, middle, children);
        }
        let after = before.iter().map(refine).collect::<std::result::Result<Vec<_>, _>>().map_err(refused)?;
        let end = quads.normals.len() as u32;
        self.add(quads, after, names_after, start..end)
    }
}

impl Scheme for Batches {
    type Own = Own;
    /// Round vertices that are sharp to a finite degree bounds are coarse.
    const FOR_PROOF: u32 = 4;

    fn refine(&mut self, quads: &mut Quads<Own>, nodes: &[usize]) -> Result<()> {
        let mut wanted: Vec<(u32, usize)> = nodes.iter().map(|&k| (quads.all[k].own.batch, k)).collect();
        wanted.sort_unstable();
        for run in wanted.chunk_by(|a, b| a.0 == b.0) {
            let own: Vec<usize> = run.iter().map(|(_, node)| *node).collect();
            self.refine_batch(quads, run[0].0 as usize, &own)?;
        }
        Ok(())
    }

    fn apart(&self, own: Own, state: usize, apart: &mut Apart<'_>) -> Result<f64> {
        let (cage, face) = (&self.all[own.batch as usize].cages[state], own.face as usize);
        if let Some(rows) = regular::net(cage, face) {
            let point = |v: u32| cage.points()[v as usize].coords;
            let net: Net =
                rows.map(|row| row.iter().fold(Vector::zeros(), |sum, &(v, c)| sum + point(v) * c));
            return Ok(apart.of_patch(&bezier(&net), Quadrant::WHOLE));
        }
        let pattern = Pattern::of_quad(cage, face);
        let own = Ground::new(cage, &pattern, face as u32, NONE, None).map_err(refused)?;
        let (points, small) = (own.points(|v| cage.points()[v as usize].coords), own.cage(cage));
        let look = |quadrant, _: &()| {
            let Some((part, within)) = own.part(quadrant) else {
                return Ok(Over::Hull(points.all().map(Point::from).collect()));
            };
            let (near, point) = (own.near(part), |k: usize| points.of(part)[k]);
            if pattern.is_regular(quadrant)
                && let Some(piece) = self.templates.piece(small, near, within).map_err(refused)?
            {
                return Ok(Over::Patch(Box::new(bezier_of(&piece, point))));
            }
            let local = self.templates.local(small, near, within).map_err(refused)?;
            Ok(Over::Hull(hull_of(&local, point).into_iter().map(Point::from).collect()))
        };
        apart.of_parts(&(), |_, ()| [(); 4], look)
    }

    fn side_normal(&self, own: Own, corner: usize) -> Option<Vector> {
        let Batch { cages, sides, .. } = &self.all[own.batch as usize];
        let half = cages[0].topology().face_corners(own.face as usize).start + corner;
        sides.get(&(half as u32)).copied().flatten()
    }

    fn normals(&self, own: Own, state: usize) -> [Option<Vector>; 4] {
        let Batch { cages, normals, .. } = &self.all[own.batch as usize];
        let (cage, topology) = (&cages[0], cages[0].topology());
        let corners = topology.face(own.face as usize);
        let is_sharp = |v: usize| {
            cage.vertex_sharpness(v) > 0.0 || topology.vertex_edges(v).any(|e| cage.crease(e as usize) > 0.0)
        };
        [0, 1, 2, 3].map(|k| {
            let v = corners[k] as usize;
            normals[state][v].filter(|_| !is_sharp(v))
        })
    }
}
