//! The bicubic piece that holds a place of a face.

use std::sync::Arc;

use loftsman_kernel::shape::{Derivative, Stencil};

use super::ground::Ground;
use super::layout::Layout;
use super::pattern::{Pattern, Quadrant};
use super::regular::{self, Row};
use super::template::Near;
use crate::cage::Cage;
use crate::catmull_clark::limit_position;
use crate::error::Result;
use crate::frame::LimitStencils;
use crate::topology::NONE;
use crate::uniform::cubic;

/// A bicubic piece of a face: the vertices of the cage that it depends on, ascending, and how each counts in its net.
#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) quadrant: Quadrant,
    pub(super) vertices: Vec<usize>,
    columns: Vec<[f64; 16]>,
}

/// A face that was asked for last.
#[derive(Debug)]
pub(super) struct Last {
    face: usize,
    ground: Option<Arc<Ground>>,
    leaf: Option<Arc<Leaf>>,
}

impl Leaf {
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
        let vertices = base.into_iter().map(|v| v as usize).collect();
        Self { quadrant: Quadrant::WHOLE, vertices, columns }
    }

    fn columns(&self) -> impl Iterator<Item = (usize, &[f64; 16])> {
        self.vertices.iter().copied().zip(&self.columns)
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

/// What the pieces of a face of the surface are made of; what was asked for last is kept.
pub(super) fn ground(cage: &Cage, layout: &Layout, face: usize) -> Result<Arc<Ground>> {
    if let Ok(last) = layout.last(face).try_lock()
        && let Some(Last { ground: Some(ground), .. }) = last.as_ref().filter(|last| last.face == face)
    {
        return Ok(Arc::clone(ground));
    }
    let [of, corner] = layout.faces[face];
    Ground::new(cage, layout.pattern(face), of, corner, None).map(Arc::new)
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
    let [of, corner] = layout.faces[face];
    let pattern = layout.pattern(face);
    if corner == NONE
        && pattern.is_regular(Quadrant::WHOLE)
        && let Some(net) = regular::net(cage, of as usize)
    {
        let leaf = Some(Arc::new(Leaf::of_net(&net)));
        keep(layout, Last { face, ground: None, leaf: leaf.clone() });
        return Ok(leaf);
    }
    let ground = ground(cage, layout, face)?;
    let leaf = find(cage, layout, pattern, &ground, (u, v), most)?.map(Arc::new);
    keep(layout, Last { face, ground: Some(ground), leaf: leaf.clone() });
    Ok(leaf)
}

fn keep(layout: &Layout, last: Last) {
    if let Ok(mut kept) = layout.last(last.face).try_lock() {
        *kept = Some(last);
    }
}

/// The limit of an extraordinary corner of a face, as a row over the vertices of the cage.
pub(super) fn position(cage: &Cage, layout: &Layout, face: usize, corner: usize) -> Result<Stencil> {
    let [of, part] = layout.faces[face];
    let at = if part == NONE { corner } else { part as usize };
    // Of a part the middle is extraordinary, too.
    if part != NONE
        && corner == 2
        && let Some(middle) = ground(cage, layout, face)?.middle()
    {
        return middle;
    }
    limit_position(cage, cage.topology().face(of as usize)[at] as usize)
}

/// The limit of an extraordinary corner of a face, as rows over the vertices of the cage: its point, and its tangents along `u` and `v` of the face.
pub(super) fn limit(cage: &Cage, layout: &Layout, face: usize, corner: usize) -> Result<LimitStencils> {
    let ground = ground(cage, layout, face)?;
    if ground.is_parted() {
        let near = Near::new(cage, layout.faces[face][0], NONE)?;
        let back = |s: &Stencil| s.iter().map(|(k, c)| (near.base[k] as usize, c)).collect();
        return Ok(near.root(cage)?.limit(corner)?.map(back));
    }
    let local = layout.templates.local(ground.cage(cage), ground.near(0), Quadrant::WHOLE)?;
    Ok(local.limit(corner)?.map(|s| ground.back(0, s)))
}

fn find(
    cage: &Cage,
    layout: &Layout,
    pattern: &Pattern,
    ground: &Ground,
    (u, v): (f64, f64),
    most: u32,
) -> Result<Option<Leaf>> {
    for level in 0..=most {
        let quadrant = Quadrant::holding(level, u, v);
        if pattern.is_regular(quadrant)
            && let Some((part, within)) = ground.part(quadrant)
            && let Some(piece) = layout.templates.piece(ground.cage(cage), ground.near(part), within)?
        {
            let (vertices, columns) = ground.columns(part, &piece);
            return Ok(Some(Leaf { quadrant, vertices, columns }));
        }
    }
    Ok(None)
}
