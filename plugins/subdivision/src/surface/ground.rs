//! What the pieces of a face are made of: the vertices round it or, where more than one of its corners is special, those that these are
//! refined to.
//!
//! Few faces of an irregular cage have the same surroundings, for these are as many as there are sets of valences. After a refinement
//! extraordinary vertices are alone, and the surroundings of a part depend on one of them: then there are as many as there are valences.

use std::sync::{Arc, OnceLock};

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, Vector};

use super::local::around;
use super::pattern::{Corner, Pattern, Quadrant};
use super::template::{Near, Piece};
use crate::cage::{Cage, decayed};
use crate::catmull_clark::limit_position;
use crate::catmull_clark::weights::{Rows, Weights};
use crate::error::{Result, SubdivisionError};
use crate::part::Said;
use crate::row::{Row, Sum, Sums};
use crate::topology::NONE;

/// A face of a cage with the faces round it, refined once.
#[derive(Debug)]
struct Refined {
    face: u32,
    /// The vertices of the cage that those of the coarse one are.
    base: Vec<u32>,
    coarse: Cage,
    /// Its points say nothing, and its faces round the rim are not what they are in the whole.
    fine: Cage,
    /// The vertices of the coarse cage, by the numbers that they have in the whole.
    ascending: Vec<u32>,
    /// The rows of the vertices of the fine cage over those of the coarse one, as far as they were asked for.
    rows: Vec<OnceLock<Row>>,
}

/// What the pieces of a face of a surface are made of.
#[derive(Debug)]
pub(super) struct Ground {
    refined: Option<Arc<Refined>>,
    /// The surroundings of the face, or those of the parts that it is refined to, as far as they belong to it.
    parts: Vec<Near>,
}

/// The points of the vertices that pieces are rows over, part after part.
pub(super) struct Points(Vec<Vec<Vector>>);

impl Ground {
    /// Of a face of the cage, or of its part at a corner ([`NONE`] for the whole). `last` is one of the same cage that may have to do with the
    /// same face. Cost: the corners of the faces round it.
    pub(super) fn new(
        cage: &Cage,
        pattern: &Pattern,
        face: u32,
        corner: u32,
        last: Option<&Self>,
    ) -> Result<Self> {
        let divided = corner != NONE;
        let special = pattern.corners.iter().filter(|&&corner| corner != Corner::default()).count();
        if cage.has_intervals() || (!divided && special < 2) {
            return Ok(Self { refined: None, parts: vec![Near::new(cage, face, corner)?] });
        }
        let known = last.and_then(|last| last.refined.clone()).filter(|refined| refined.face == face);
        let refined = match known {
            Some(refined) => refined,
            None => Arc::new(Refined::new(cage, face)?),
        };
        let parts = if divided {
            vec![refined.near(corner as usize, 0)?]
        } else {
            (0..4).map(|k| refined.near(k, (4 - k) % 4)).collect::<Result<_>>()?
        };
        Ok(Self { refined: Some(refined), parts })
    }

    /// The cage that the surroundings are parts of: that of the face itself, or one refined.
    pub(super) fn cage<'a>(&'a self, whole: &'a Cage) -> &'a Cage {
        self.refined.as_ref().map_or(whole, |refined| &refined.fine)
    }

    /// The part that a quadrant is in, and which quadrant of that it is; `None` where it is all of several parts.
    pub(super) fn part(&self, quadrant: Quadrant) -> Option<(usize, Quadrant)> {
        if self.parts.len() == 1 {
            return Some((0, quadrant));
        }
        let Quadrant { level, i, j } = quadrant;
        let level = level.checked_sub(1)?;
        let [a, b] = [i, j].map(|k| k >> level.min(63));
        let corner = match (a, b) {
            (0, 0) => 0,
            (_, 0) => 1,
            (0, _) => 3,
            _ => 2,
        };
        let within = |k: u64, part: u64| k - (part << level.min(63));
        Some((corner, Quadrant { level, i: within(i, a), j: within(j, b) }))
    }

    /// The surroundings of a part.
    pub(super) fn near(&self, part: usize) -> &Near {
        &self.parts[part]
    }

    /// Whether there are only the parts of the face, and not itself.
    pub(super) fn is_parted(&self) -> bool {
        self.parts.len() > 1
    }

    /// The points of the vertices that pieces are rows over, of those of the cage.
    pub(super) fn points(&self, point: impl Fn(u32) -> Vector) -> Points {
        let Some(refined) = &self.refined else {
            return Points(
                self.parts.iter().map(|near| near.base.iter().map(|&v| point(v)).collect()).collect(),
            );
        };
        let around: Vec<Point> = refined.base.iter().map(|&v| Point::from(point(v))).collect();
        let topology = refined.coarse.topology();
        let mean = |face: usize| {
            let corners = topology.face(face);
            let sum = corners.iter().map(|&v| around[v as usize].coords).sum::<Vector>();
            Point::from(sum / corners.len() as f64)
        };
        let faces: Vec<Point> = (0..topology.face_count()).map(mean).collect();
        let weights = Weights::new(&refined.coarse);
        let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
        let fine = |&v: &u32| {
            let v = v as usize;
            let mut sum = Sums { points: &around, faces: &faces, sum: Vector::zeros() };
            if v >= vertices + edges {
                return faces[v - vertices - edges].coords;
            }
            match v.checked_sub(vertices) {
                Some(edge) => weights.edge(edge, &mut sum),
                None => weights.vertex(v, &mut sum),
            }
            sum.sum
        };
        Points(self.parts.iter().map(|near| near.base.iter().map(fine).collect()).collect())
    }

    /// The row, over the vertices of the cage, of the limit of the middle of the face, where it was refined; `None` where it was not.
    pub(super) fn middle(&self) -> Option<Result<Stencil>> {
        let refined = self.refined.as_ref()?;
        let topology = refined.coarse.topology();
        // The face is the first.
        let limit = limit_position(&refined.fine, topology.vertex_count() + topology.edge_count());
        Some(limit.map(|limit| refined.back(&limit)))
    }

    /// A row over the vertices that pieces of a part are rows over, as one over those of the cage.
    pub(super) fn back(&self, part: usize, stencil: &Stencil) -> Stencil {
        let base = &self.parts[part].base;
        let own: Stencil = stencil.iter().map(|(k, c)| (base[k] as usize, c)).collect();
        match &self.refined {
            Some(refined) => refined.back(&own),
            None => own,
        }
    }

    /// The vertices of the cage that a piece depends on, ascending, and how each counts in its net.
    pub(super) fn columns(&self, part: usize, piece: &Piece) -> (Vec<usize>, Vec<[f64; 16]>) {
        let base = &self.parts[part].base;
        let own = piece.places.iter().map(|&place| base[place as usize] as usize).zip(&piece.columns);
        let Some(refined) = &self.refined else {
            let mut all: Vec<(usize, &[f64; 16])> = own.collect();
            all.sort_unstable_by_key(|pair| pair.0);
            return all.into_iter().unzip();
        };
        let mut sums = vec![[0.0; 16]; refined.base.len()];
        let mut is_there = vec![false; refined.base.len()];
        for (vertex, column) in own {
            for &(v, share) in &refined.row(vertex).0 {
                is_there[v as usize] = true;
                sums[v as usize].iter_mut().zip(column).for_each(|(sum, c)| *sum += share * c);
            }
        }
        let used = refined.ascending.iter().filter(|&&v| is_there[v as usize]);
        used.map(|&v| (refined.base[v as usize] as usize, sums[v as usize])).unzip()
    }
}

impl Points {
    /// Those of a part.
    pub(super) fn of(&self, part: usize) -> &[Vector] {
        &self.0[part]
    }

    /// All of them: the face lies in their hull.
    pub(super) fn all(&self) -> impl Iterator<Item = Vector> {
        self.0.iter().flatten().copied()
    }
}

impl Refined {
    fn new(cage: &Cage, face: u32) -> Result<Self> {
        let topology = cage.topology();
        let part = around(topology, face as usize, 0)?;
        let said = Said { crease: &|e| cage.crease(e), corner: &|v| cage.corner(v), interval: None };
        let coarse = part.cage(topology, &said, cage.boundary())?;
        let split = coarse.topology().split()?;
        let points = vec![Point::origin(); split.vertex_count()];
        let creases = if coarse.creases.is_empty() {
            Vec::new()
        } else {
            coarse.creases.iter().flat_map(|&s| [decayed(s); 2]).collect()
        };
        let fine = Cage {
            points,
            creases,
            corners: coarse.corners.iter().map(|&s| decayed(s)).collect(),
            holes: Vec::new(),
            intervals: Vec::new(),
            end_intervals: Vec::new(),
            boundary: cage.boundary(),
            topology: split.into(),
        };
        let base = part.kept;
        let mut ascending: Vec<u32> = (0..base.len() as u32).collect();
        ascending.sort_unstable_by_key(|&v| base[v as usize]);
        let rows = fine.points.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { face, base, coarse, fine, ascending, rows })
    }

    /// The row, over the vertices of the coarse cage, of a vertex of the fine one.
    fn row(&self, vertex: usize) -> &Row {
        self.rows[vertex].get_or_init(|| {
            let topology = self.coarse.topology();
            let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
            let weights = Weights::new(&self.coarse);
            let mut rows = Rows { weights: &weights, row: Row::default(), factor: 1.0 };
            if vertex < vertices {
                weights.vertex(vertex, &mut rows);
            } else if vertex < vertices + edges {
                weights.edge(vertex - vertices, &mut rows);
            } else {
                rows.face((vertex - vertices - edges) as u32, 1.0);
            }
            rows.row.tidy();
            rows.row
        })
    }

    /// A row over the vertices of the fine cage as one over those of the whole.
    fn back(&self, stencil: &Stencil) -> Stencil {
        let vertex = |v: u32| self.base[v as usize] as usize;
        let terms =
            stencil.iter().flat_map(|(k, c)| self.row(k).0.iter().map(move |&(v, d)| (vertex(v), c * d)));
        terms.collect()
    }

    /// The surroundings of the part at a corner of the face, whose first corner is number `start` of corner, edge that follows, middle, edge before.
    fn near(&self, corner: usize, start: usize) -> Result<Near> {
        let near =
            Near::from_corner(&self.fine, self.coarse.topology().face_corners(0).start + corner, start);
        near.map_err(|error| match error {
            SubdivisionError::Face { problem, .. } => {
                SubdivisionError::Face { face: self.face as usize, problem }
            }
            other => other,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use std::collections::BTreeSet;

    use loftsman_kernel::shape::{Cells, Derivative, Location, Shape};

    use super::*;
    use crate::SubdivisionSurface;

    /// A triangulated sphere whose vertices have all valences: a divided octahedron, edges of which were turned here and there.
    fn irregular(turned: usize) -> Cage {
        let mut points: Vec<Vector> = Vec::new();
        let mut faces: Vec<[usize; 3]> = Vec::new();
        let count = 8;
        let place = |points: &mut Vec<Vector>, p: Vector| {
            let p = p.normalize();
            points.iter().position(|q| (p - q).norm() < 1e-9).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            })
        };
        for octant in 0..8 {
            let sign = |k: usize| if octant >> k & 1 == 0 { 1.0 } else { -1.0 };
            let mut at = |i: usize, j: usize| {
                let [x, y, z] = [i, j, count - i - j].map(|k| k as f64);
                place(&mut points, Vector::new(sign(0) * x, sign(1) * y, sign(2) * z))
            };
            for (i, j) in (0..count).flat_map(|i| (0..count - i).map(move |j| (i, j))) {
                faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < count {
                    faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
        for face in &mut faces {
            let [a, b, c] = face.map(|v| points[v]);
            if (b - a).cross(&(c - a)).dot(&a) < 0.0 {
                face.swap(1, 2);
            }
        }
        let mut seed = 1_u64;
        for _ in 0..turned {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (one, k) = ((seed >> 33) as usize % faces.len(), (seed >> 20) as usize % 3);
            let [a, b, c] = [0, 1, 2].map(|i| faces[one][(k + i) % 3]);
            let Some(other) = faces.iter().position(|f| (0..3).any(|i| f[i] == b && f[(i + 1) % 3] == a))
            else {
                continue;
            };
            let d = faces[other].into_iter().find(|v| ![a, b].contains(v)).unwrap();
            let valence = |v: usize| faces.iter().filter(|f| f.contains(&v)).count();
            let joined = faces.iter().any(|f| f.contains(&c) && f.contains(&d));
            if !joined && valence(a) > 3 && valence(b) > 3 {
                (faces[one], faces[other]) = ([c, a, d], [d, b, c]);
            }
        }
        Cage::new(points.into_iter().map(Point::from).collect(), &faces).unwrap()
    }

    /// Nets by their numbers, asked for run by run.
    fn nets(
        surface: &SubdivisionSurface,
        runs: impl Iterator<Item = std::ops::Range<usize>>,
    ) -> Vec<Vec<Vector>> {
        let mut all = vec![Vec::new(); Cells::count(surface)];
        for run in runs {
            let each = &mut |net: loftsman_kernel::shape::CellNet<'_>| all[net.number] = net.points.to_vec();
            surface.nets(run, &Point::origin(), each).unwrap().unwrap();
        }
        all
    }

    /// Few kinds of surroundings are refined, however many faces there are that differ in theirs: one for each valence. What comes of them are the
    /// bicubic pieces that rows say, and the same bits whoever asks first.
    #[test]
    fn parts_of_irregular_faces_have_few_kinds_of_surroundings() {
        let cage = irregular(2000);
        let topology = cage.topology();
        let (mut whole, mut parts) = (BTreeSet::new(), BTreeSet::new());
        for face in 0..topology.face_count() as u32 {
            for corner in 0..3 {
                whole.insert(Near::new(&cage, face, corner).unwrap().key().to_vec());
                let pattern =
                    Pattern::of_part(&cage, topology.face_corners(face as usize).start as u32 + corner);
                let ground = Ground::new(&cage, &pattern, face, corner, None).unwrap();
                parts.insert(ground.near(0).key().to_vec());
            }
        }
        let valences: BTreeSet<usize> =
            (0..topology.vertex_count()).map(|v| topology.vertex_faces(v).count()).collect();
        assert!(whole.len() > 1000 && parts.len() == valences.len(), "{} {}", whole.len(), parts.len());

        let (one, other) =
            (SubdivisionSurface::new(cage.clone()).unwrap(), SubdivisionSurface::new(cage).unwrap());
        let count = Cells::count(&one);
        let run = |k: usize| k * 512..((k + 1) * 512).min(count);
        let all = nets(&one, (0..count.div_ceil(512)).map(run));
        assert!(all == nets(&other, (0..count.div_ceil(512)).rev().map(run)));
        assert_eq!(one.layout.templates.count(), valences.len());
        for (number, net) in all.iter().enumerate().step_by(97) {
            let cell = one.cell(number).unwrap();
            let at = |side: usize, end: bool| {
                let side = &cell.sides[side];
                if end { side.end } else { side.start }
            };
            for (k, [u, v]) in
                [(0, [false, false]), (3, [false, true]), (12, [true, false]), (15, [true, true])]
            {
                let place = Location::Face(cell.face.unwrap(), at(0, u), at(1, v));
                let off = (one.value(place, Derivative::POSITION).unwrap() - net[k]).norm();
                assert!(off < 1e-14, "{number} {k}: {off:e}");
            }
        }
    }

    /// A quad with several special corners is looked at in its parts, and one with a single one as it is.
    #[test]
    fn quads_are_parted_where_corners_differ() {
        let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cube = Cage::new((0..8).map(corner).collect(), &faces).unwrap();
        let ground = |cage: &Cage| Ground::new(cage, &Pattern::of_quad(cage, 0), 0, NONE, None).unwrap();
        let own = ground(&cube);
        assert!(own.is_parted() && own.part(Quadrant::WHOLE).is_none());
        for (place, part, within) in [([0, 3], 3, [0, 1]), ([2, 1], 1, [0, 1]), ([3, 3], 2, [1, 1])] {
            let [i, j] = place;
            let found = own.part(Quadrant { level: 2, i, j }).unwrap();
            assert_eq!(found, (part, Quadrant { level: 1, i: within[0], j: within[1] }));
        }
        assert!(!ground(&crate::catmull_clark::refine(&cube).unwrap()).is_parted());
    }
}
