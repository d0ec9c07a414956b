//! The bicubic piece that holds a place of a face.

use std::sync::Arc;

use loftsman_kernel::shape::{Derivative, Stencil};

use super::layout::Layout;
use super::local::Local;
use super::pattern::Quadrant;
use super::regular::{self, Row};
use super::template::{Near, Piece};
use crate::cage::Cage;
use crate::error::Result;
use crate::topology::NONE;
use crate::uniform::cubic;

/// A bicubic piece of a face: the vertices of the cage that it depends on, ascending, and how each counts in its net.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) quadrant: Quadrant,
    pub(super) vertices: Vec<usize>,
    /// The place of each vertex among those of the piece.
    order: Vec<u32>,
    piece: Arc<Piece>,
}

/// A face that was asked for last.
#[derive(Debug)]
pub(super) struct Last {
    face: usize,
    near: Arc<Near>,
    leaf: Option<Arc<Leaf>>,
}

impl Leaf {
    fn new(quadrant: Quadrant, piece: Arc<Piece>, base: &[u32]) -> Self {
        let vertex = |k: u32| base[piece.places[k as usize] as usize] as usize;
        let mut order: Vec<u32> = (0..piece.places.len() as u32).collect();
        order.sort_unstable_by_key(|&k| vertex(k));
        let vertices = order.iter().map(|&k| vertex(k)).collect();
        Self { quadrant, vertices, order, piece }
    }

    /// A whole face, from the rows of its net over the vertices of the cage.
    fn of_net(net: &[Row; 16]) -> Self {
        let mut base: Vec<u32> = net.iter().flat_map(|row| row.iter().map(|&(v, _)| v)).collect();
        base.sort_unstable();
        base.dedup();
        let mut columns = vec![[0.0; 16]; base.len()];
        for (place, row) in net.iter().enumerate() {
            for &(v, c) in row {
                if let Ok(at) = base.binary_search(&v) {
                    columns[at][place] += c;
                }
            }
        }
        let places = (0..base.len() as u32).collect();
        Self::new(Quadrant::WHOLE, Arc::new(Piece { places, columns }), &base)
    }

    fn columns(&self) -> impl Iterator<Item = (usize, &[f64; 16])> {
        self.vertices.iter().zip(&self.order).map(|(&v, &k)| (v, &self.piece.columns[k as usize]))
    }

    /// The row of a derivative at a place of the face.
    pub(super) fn stencil(&self, u: f64, v: f64, by: Derivative) -> Stencil {
        let count = (1u64 << self.quadrant.level) as f64;
        let local = |x: f64, k: u64| (x * count - k as f64).clamp(0.0, 1.0);
        let (along_u, along_v) =
            (cubic(local(u, self.quadrant.i), by.u), cubic(local(v, self.quadrant.j), by.v));
        let scale = count.powi((by.u + by.v) as i32);
        let rows = self.columns().map(|(vertex, column)| {
            let of = |i: usize| (0..4).map(|j| along_v[j] * column[4 * i + j]).sum::<f64>();
            (vertex, scale * (0..4).map(|i| along_u[i] * of(i)).sum::<f64>())
        });
        rows.filter(|(_, c)| *c != 0.0).collect()
    }

    /// The four coefficients, as rows, of the cubic that a derivative `across` a side is along it (side `k` runs from corner `k`; the
    /// cubic by growing parameter), and the largest weight that goes into it.
    pub(super) fn strip(&self, side: usize, order: usize) -> ([Stencil; 4], f64) {
        let weights = cubic(if matches!(side, 1 | 2) { 1.0 } else { 0.0 }, order);
        let rows = std::array::from_fn(|k| {
            let place = |j: usize| if side.is_multiple_of(2) { 4 * k + j } else { 4 * j + k };
            let all = self.columns().map(|(v, c)| (v, (0..4).map(|j| weights[j] * c[place(j)]).sum::<f64>()));
            all.filter(|(_, c)| *c != 0.0).collect()
        });
        (rows, weights.iter().fold(0.0, |m: f64, w| m.max(w.abs())))
    }
}

/// The surroundings of a face of the surface; those asked for last are kept.
pub(super) fn near(cage: &Cage, layout: &Layout, face: usize) -> Result<Arc<Near>> {
    if let Ok(last) = layout.last(face).try_lock()
        && let Some(last) = last.as_ref().filter(|last| last.face == face)
    {
        return Ok(Arc::clone(&last.near));
    }
    let [of, corner] = layout.faces[face];
    Near::new(cage, of, corner).map(Arc::new)
}

/// A face of the surface as it is before any place on it is looked for, and the vertices that its rows are over.
pub(super) fn root(cage: &Cage, layout: &Layout, face: usize) -> Result<(Arc<Local>, Arc<Near>)> {
    let near = near(cage, layout, face)?;
    let local = layout.templates.local(cage, &near, Quadrant::WHOLE)?;
    Ok((local, near))
}

/// The piece that holds a place, on the face's level `most` at the latest; `None` where it is not regular there. The last is kept for the
/// next who asks; what comes out does not depend on what was kept.
pub(super) fn leaf(
    cage: &Cage,
    layout: &Layout,
    face: usize,
    (u, v): (f64, f64),
    most: u32,
) -> Result<Option<Arc<Leaf>>> {
    if let Ok(last) = layout.last(face).try_lock()
        && let Some(Last { face: known, leaf: Some(leaf), .. }) = &*last
        && *known == face
        && Quadrant::holding(leaf.quadrant.level, u, v) == leaf.quadrant
    {
        return Ok(Some(Arc::clone(leaf)));
    }
    let near = near(cage, layout, face)?;
    let leaf = find(cage, layout, face, &near, (u, v), most)?.map(Arc::new);
    if let Ok(mut last) = layout.last(face).try_lock() {
        *last = Some(Last { face, near, leaf: leaf.clone() });
    }
    Ok(leaf)
}

fn find(
    cage: &Cage,
    layout: &Layout,
    face: usize,
    near: &Near,
    (u, v): (f64, f64),
    most: u32,
) -> Result<Option<Leaf>> {
    let pattern = layout.pattern(face);
    let [of, corner] = layout.faces[face];
    if corner == NONE
        && pattern.is_regular(Quadrant::WHOLE)
        && let Some(net) = regular::net(cage, of as usize)
    {
        return Ok(Some(Leaf::of_net(&net)));
    }
    for level in 0..=most {
        let quadrant = Quadrant::holding(level, u, v);
        if pattern.is_regular(quadrant)
            && let Some(piece) = layout.templates.piece(cage, near, quadrant)?
        {
            return Ok(Some(Leaf::new(quadrant, piece, &near.base)));
        }
    }
    Ok(None)
}
