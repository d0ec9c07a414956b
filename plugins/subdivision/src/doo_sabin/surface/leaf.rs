//! The biquadratic piece that holds a place of a face.

use std::sync::{Arc, Mutex};

use loftsman_kernel::shape::{Derivative, Stencil};

use super::node::Node;
use crate::error::Result;
use crate::surface::pattern::Quadrant;
use crate::uniform::quadratic;

/// The surroundings of a face: the vertices of the cage that it depends on, ascending, and its neighbourhood as rows over these.
#[derive(Debug)]
pub(super) struct Near {
    pub(super) base: Vec<usize>,
    pub(super) node: Node<Vec<f64>>,
}

/// A biquadratic piece of a face: the vertices of the cage that it depends on, ascending, and how each counts in its net.
#[derive(Debug)]
pub(super) struct Leaf {
    quadrant: Quadrant,
    pub(super) vertices: Vec<usize>,
    columns: Vec<[f64; 9]>,
}

impl Leaf {
    fn new(quadrant: Quadrant, base: &[usize], piece: &Node<Vec<f64>>) -> Self {
        let net = piece.net();
        let (mut vertices, mut columns) = (Vec::new(), Vec::new());
        for (at, &vertex) in base.iter().enumerate() {
            let column: [f64; 9] = std::array::from_fn(|k| net[k][at]);
            if column.iter().any(|c| *c != 0.0) {
                vertices.push(vertex);
                columns.push(column);
            }
        }
        Self { quadrant, vertices, columns }
    }

    /// The row of a derivative at a place of the face.
    pub(super) fn stencil(&self, [u, v]: [f64; 2], by: Derivative) -> Stencil {
        let count = 2.0_f64.powi(self.quadrant.level as i32);
        let local = |x: f64, k: u64| (x * count - k as f64).clamp(0.0, 1.0);
        let along_u = quadratic(local(u, self.quadrant.i), by.u);
        let along_v = quadratic(local(v, self.quadrant.j), by.v);
        let scale = count.powi((by.u + by.v) as i32);
        let rows = self.vertices.iter().zip(&self.columns).map(|(&vertex, column)| {
            let of = |i: usize| (0..3).map(|j| along_v[j] * column[3 * i + j]).sum::<f64>();
            (vertex, scale * (0..3).map(|i| along_u[i] * of(i)).sum::<f64>())
        });
        rows.filter(|(_, c)| *c != 0.0).collect()
    }
}

/// A face that was asked for last.
#[derive(Debug)]
struct Last {
    face: usize,
    near: Arc<Near>,
    leaf: Option<Arc<Leaf>>,
}

/// The faces that were asked for last. What comes out does not depend on what was kept.
#[derive(Debug, Default)]
pub(super) struct Kept([Mutex<Option<Last>>; 16]);

impl Kept {
    fn of(&self, face: usize) -> &Mutex<Option<Last>> {
        &self.0[face % self.0.len()]
    }

    /// The surroundings of a face, made where they are not known.
    pub(super) fn near(&self, face: usize, make: impl Fn() -> Result<Near>) -> Result<Arc<Near>> {
        if let Ok(last) = self.of(face).try_lock()
            && let Some(last) = last.as_ref().filter(|last| last.face == face)
        {
            return Ok(Arc::clone(&last.near));
        }
        let near = Arc::new(make()?);
        if let Ok(mut last) = self.of(face).try_lock() {
            *last = Some(Last { face, near: Arc::clone(&near), leaf: None });
        }
        Ok(near)
    }

    /// The piece that holds a place, on the face's level `most` at the latest; `None` where it is not regular there.
    pub(super) fn leaf(
        &self,
        face: usize,
        near: &Arc<Near>,
        [u, v]: [f64; 2],
        most: u32,
    ) -> Option<Arc<Leaf>> {
        let holds = |leaf: &Leaf| Quadrant::holding(leaf.quadrant.level, u, v) == leaf.quadrant;
        if let Ok(last) = self.of(face).try_lock()
            && let Some(Last { face: known, leaf: Some(leaf), .. }) = &*last
            && *known == face
            && holds(leaf)
        {
            return Some(Arc::clone(leaf));
        }
        let (piece, _, level) = near.node.piece((u, v), most)?;
        let leaf = Arc::new(Leaf::new(Quadrant::holding(level, u, v), &near.base, &piece));
        if let Ok(mut last) = self.of(face).try_lock() {
            *last = Some(Last { face, near: Arc::clone(near), leaf: Some(Arc::clone(&leaf)) });
        }
        Some(leaf)
    }
}
