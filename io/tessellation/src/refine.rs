//! All cells of one patch, cut until every one meets the target.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::cell::{Judge, Poles, Verdict};
use crate::fineness::Target;
use crate::patch::Patch;
use crate::tree::{Cell, Tree};

/// A cell that is not cut, with what was last found about it.
#[derive(Debug, Clone)]
struct Leaf {
    cell: Cell,
    /// The number of vertices around it when it was judged.
    seen: u32,
    error: f64,
    triangles: Triangles,
}

/// Two triangles as a rule.
type Triangles = smallvec::SmallVec<[[u32; 3]; 2]>;

/// The cells of a patch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cells {
    pub(crate) tree: Tree,
    leaves: Vec<Leaf>,
    pub(crate) poles: Poles,
}

/// Counts the triangles and the cells of all patches; the work ends where there are more than allowed. (Cells are cut
/// before there are triangles of them.)
pub(crate) struct Budget {
    triangles: AtomicUsize,
    cells: AtomicUsize,
}

impl Budget {
    pub(crate) fn new(triangles: usize) -> Self {
        Self { triangles: AtomicUsize::new(triangles), cells: AtomicUsize::new(triangles) }
    }

    /// Takes so many triangles; false where there are none left.
    fn take(&self, triangles: usize) -> bool {
        take(&self.triangles, triangles)
    }

    fn give(&self, triangles: usize) {
        self.triangles.fetch_add(triangles, Ordering::Relaxed);
    }
}

fn take(left: &AtomicUsize, count: usize) -> bool {
    left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(count)).is_ok()
}

impl Cells {
    /// A patch as one cell.
    pub(crate) fn new(patch: &Patch, poles: Poles) -> Self {
        let (tree, cell) = Tree::new(patch);
        let leaf = Leaf { cell, seen: 0, error: 0.0, triangles: Triangles::new() };
        Self { tree, leaves: vec![leaf], poles }
    }

    /// Cuts cells until every one meets the target with the vertices now around it; false where the budget is spent.
    ///
    /// A cut adds vertices to the neighbours' edges, so cells are judged again until nothing changes.
    pub(crate) fn refine(
        &mut self,
        patch: &Patch,
        target: &Target,
        judge: &mut Judge,
        budget: &Budget,
    ) -> bool {
        let mut again = true;
        let (mut open, mut parts) = (Vec::new(), Vec::new());
        while again {
            again = false;
            let mut done = Vec::with_capacity(self.leaves.len());
            for leaf in std::mem::take(&mut self.leaves) {
                open.push(leaf);
                while let Some(mut leaf) = open.pop() {
                    let around = judge.look(&self.tree, &leaf.cell) as u32;
                    if around == leaf.seen {
                        done.push(leaf);
                        continue;
                    }
                    budget.give(leaf.triangles.len());
                    leaf.triangles.clear();
                    match judge.judge(&self.tree, patch, &self.poles, target, &leaf.cell) {
                        Verdict::Meets { error } => {
                            leaf.triangles.extend_from_slice(&judge.triangles);
                            if !budget.take(leaf.triangles.len()) {
                                return false;
                            }
                            (leaf.seen, leaf.error) = (around, error);
                            done.push(leaf);
                        }
                        Verdict::Cut(how) => {
                            again = true;
                            parts.clear();
                            self.tree.cut(patch, &leaf.cell, how, &mut parts);
                            if !take(&budget.cells, parts.len() - 1) {
                                return false;
                            }
                            open.extend(parts.drain(..).rev().map(|cell| Leaf {
                                cell,
                                seen: 0,
                                error: 0.0,
                                triangles: Triangles::new(),
                            }));
                        }
                    }
                }
            }
            self.leaves = done;
        }
        true
    }

    /// The largest certified error.
    pub(crate) fn error(&self) -> f64 {
        self.leaves.iter().map(|leaf| leaf.error).fold(0.0, f64::max)
    }

    /// The triangles of all cells.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = &[u32; 3]> {
        self.leaves.iter().flat_map(|leaf| &leaf.triangles)
    }

    /// The fractions of a side's inner vertices, ascending.
    pub(crate) fn fractions(&self, side: usize) -> Vec<f64> {
        let chain = self.tree.side(side);
        chain[1..chain.len() - 1].iter().map(|&v| self.tree.vertices[v as usize].at[side % 2]).collect()
    }
}
