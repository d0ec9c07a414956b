//! The way to a bicubic piece: refined where a place is, until the face that holds it is regular.

use std::sync::Arc;

use loftsman_kernel::shape::{Derivative, Stencil};

use super::layout::Layout;
use super::local::Local;
use super::pattern::Quadrant;
use super::regular::{self, Row};
use crate::cage::Cage;
use crate::error::Result;
use crate::topology::NONE;

/// Neighbourhoods of more vertices than these are not kept on the way, so that they do not fill the memory.
const KEPT: usize = 256;
/// Faces whose ways are kept, and pieces of each: who goes from face to face and back (feet of points, integrals) finds them again.
const FACES: usize = 8;
const PIECES: usize = 64;

/// A bicubic piece: the vertices of the cage that it depends on, and how each counts in its net.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) quadrant: Quadrant,
    pub(super) vertices: Vec<usize>,
    columns: Vec<[f64; 16]>,
}

/// Neighbourhoods refined one after another towards a place of a face, and the pieces they came to, the last one at the end.
#[derive(Debug)]
pub(super) struct Path {
    face: usize,
    levels: Vec<(Quadrant, Arc<Local>)>,
    leaves: Vec<Arc<Leaf>>,
}

impl Leaf {
    /// A whole face, from the rows of its net over the vertices of the cage.
    fn of_net(net: &[Row; 16]) -> Self {
        let mut vertices: Vec<usize> =
            net.iter().flat_map(|row| row.iter().map(|&(v, _)| v as usize)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut columns = vec![[0.0; 16]; vertices.len()];
        for (place, row) in net.iter().enumerate() {
            for &(v, c) in row {
                if let Ok(at) = vertices.binary_search(&(v as usize)) {
                    columns[at][place] += c;
                }
            }
        }
        Self { quadrant: Quadrant::WHOLE, vertices, columns }
    }

    /// The row of a derivative at a place of the face.
    pub(super) fn stencil(&self, u: f64, v: f64, by: Derivative) -> Stencil {
        let count = (1u64 << self.quadrant.level) as f64;
        let local = |x: f64, k: u64| (x * count - k as f64).clamp(0.0, 1.0);
        let (along_u, along_v) =
            (basis(local(u, self.quadrant.i), by.u), basis(local(v, self.quadrant.j), by.v));
        let scale = count.powi((by.u + by.v) as i32);
        let rows = self.vertices.iter().zip(&self.columns).map(|(&vertex, column)| {
            let of = |i: usize| (0..4).map(|j| along_v[j] * column[4 * i + j]).sum::<f64>();
            (vertex, scale * (0..4).map(|i| along_u[i] * of(i)).sum::<f64>())
        });
        rows.filter(|(_, c)| *c != 0.0).collect()
    }

    /// The four coefficients, as rows, of the cubic that a derivative `across` a side is along it (side `k` runs from corner `k`; the
    /// cubic by growing parameter), and the largest weight that goes into it.
    pub(super) fn strip(&self, side: usize, order: usize) -> ([Stencil; 4], f64) {
        let weights = basis(if matches!(side, 1 | 2) { 1.0 } else { 0.0 }, order);
        let rows = std::array::from_fn(|k| {
            let place = |j: usize| if side.is_multiple_of(2) { 4 * k + j } else { 4 * j + k };
            let columns = self.vertices.iter().zip(&self.columns);
            let all = columns.map(|(&v, c)| (v, (0..4).map(|j| weights[j] * c[place(j)]).sum::<f64>()));
            all.filter(|(_, c)| *c != 0.0).collect()
        });
        (rows, weights.iter().fold(0.0, |m: f64, w| m.max(w.abs())))
    }
}

/// The four uniform cubic B-splines over `[0, 1]`, or their derivatives.
fn basis(x: f64, order: usize) -> [f64; 4] {
    let y = 1.0 - x;
    match order {
        0 => [
            y * y * y / 6.0,
            (4.0 - 3.0 * x * x * (1.0 + y)) / 6.0,
            (4.0 - 3.0 * y * y * (1.0 + x)) / 6.0,
            x * x * x / 6.0,
        ],
        1 => [-0.5 * y * y, 0.5 * x * (3.0 * x - 4.0), -0.5 * y * (3.0 * y - 4.0), 0.5 * x * x],
        2 => [y, 3.0 * x - 2.0, 3.0 * y - 2.0, x],
        3 => [-1.0, 3.0, -3.0, 1.0],
        _ => [0.0; 4],
    }
}

/// A face of the surface as it is before any place on it is looked for.
pub(super) fn root(cage: &Cage, layout: &Layout, face: usize) -> Result<Local> {
    let [of, corner] = layout.faces[face];
    let local = Local::new(cage, of as usize)?;
    if corner == NONE { Ok(local) } else { local.refined(corner as usize, 0) }
}

/// The piece that holds a place, on the face's level `most` at the latest; `None` where it is not regular there. The way is kept for
/// the next who asks; what comes out does not depend on what was kept.
pub(super) fn leaf(
    cage: &Cage,
    layout: &Layout,
    face: usize,
    (u, v): (f64, f64),
    most: u32,
) -> Result<Option<Arc<Leaf>>> {
    let kept = layout.last.try_lock().ok().and_then(|mut last| {
        let at = last.iter().rposition(|path| path.face == face)?;
        Some(last.remove(at))
    });
    let mut path = kept.unwrap_or_else(|| Path { face, levels: Vec::new(), leaves: Vec::new() });
    let found = path.find(cage, layout, (u, v), most)?;
    if let Ok(mut last) = layout.last.try_lock() {
        if last.len() >= FACES {
            last.remove(0);
        }
        last.push(path);
    }
    Ok(found)
}

impl Path {
    fn find(
        &mut self,
        cage: &Cage,
        layout: &Layout,
        (u, v): (f64, f64),
        most: u32,
    ) -> Result<Option<Arc<Leaf>>> {
        let holds = |leaf: &Arc<Leaf>| Quadrant::holding(leaf.quadrant.level, u, v) == leaf.quadrant;
        if let Some(at) = self.leaves.iter().rposition(holds) {
            let leaf = self.leaves.remove(at);
            return Ok(Some(self.keep(leaf)));
        }
        let pattern = layout.pattern(self.face);
        let [of, corner] = layout.faces[self.face];
        if corner == NONE
            && pattern.is_regular(Quadrant::WHOLE)
            && let Some(net) = regular::net(cage, of as usize)
        {
            return Ok(Some(self.keep(Arc::new(Leaf::of_net(&net)))));
        }
        let mut parent: Option<Arc<Local>> = None;
        for level in 0..=most {
            let quadrant = Quadrant::holding(level, u, v);
            let at = level as usize;
            let known = self.levels.get(at).filter(|(known, _)| *known == quadrant);
            let local = match (known, parent) {
                (Some((_, local)), _) => Arc::clone(local),
                (None, parent) => {
                    self.levels.truncate(at);
                    let local = match parent {
                        None => root(cage, layout, self.face)?,
                        Some(parent) => {
                            let corner = match (quadrant.i % 2, quadrant.j % 2) {
                                (0, 0) => 0,
                                (1, 0) => 1,
                                (1, _) => 2,
                                _ => 3,
                            };
                            parent.refined(corner, (4 - corner) % 4)?
                        }
                    };
                    let local = Arc::new(local);
                    if local.width() <= KEPT {
                        self.levels.push((quadrant, Arc::clone(&local)));
                    }
                    local
                }
            };
            if pattern.is_regular(quadrant)
                && let Some((vertices, columns)) = local.net()
            {
                return Ok(Some(self.keep(Arc::new(Leaf { quadrant, vertices, columns }))));
            }
            parent = Some(local);
        }
        Ok(None)
    }

    /// Remembers a piece as the last one.
    fn keep(&mut self, leaf: Arc<Leaf>) -> Arc<Leaf> {
        let room = if leaf.vertices.len() <= KEPT { PIECES } else { 1 };
        if self.leaves.len() >= room {
            self.leaves.drain(..=self.leaves.len() - room);
        }
        self.leaves.push(Arc::clone(&leaf));
        leaf
    }
}
