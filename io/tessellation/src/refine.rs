//! All cells of one patch, cut until every one meets the target.

use std::sync::atomic::{AtomicUsize, Ordering};

use smallvec::SmallVec;

use crate::cell::{Judge, Verdict};
use crate::fineness::Target;
use crate::patch::Patch;
use crate::topology::Poles;
use crate::tree::{Cell, Cut, Tree};

/// A cell that is not cut, with what was last found about it.
#[derive(Debug, Clone)]
struct Leaf {
    cell: Cell,
    /// The number of vertices around it when it was judged.
    seen: u32,
    error: Error,
    /// Where its triangles start, and how many it has.
    start: u32,
    count: u32,
}

impl Leaf {
    /// A cell of which nothing is known.
    fn new(cell: Cell) -> Self {
        Self { cell, seen: 0, error: Error::default(), start: 0, count: 0 }
    }
}

/// A certified distance in all states.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Error {
    /// The largest, as a length.
    pub(crate) length: f64,
    /// The largest, in the state's chord tolerances.
    pub(crate) share: f64,
}

impl Error {
    /// The larger of both, each way; NaN is larger than all.
    pub(crate) fn max(self, other: Self) -> Self {
        let larger = |a: f64, b: f64| if b.is_nan() { f64::INFINITY } else { a.max(b) };
        Self { length: larger(self.length, other.length), share: larger(self.share, other.share) }
    }
}

/// One as a rule.
pub(crate) type PerState<T> = SmallVec<[T; 1]>;

/// The cells of a patch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cells {
    /// That of the first state.
    pub(crate) tree: Tree,
    /// Those of further states: cut alike, their vertices lie elsewhere.
    pub(crate) others: Vec<Tree>,
    leaves: Vec<Leaf>,
    /// The triangles, leaf after leaf.
    triangles: Vec<[u32; 3]>,
    pub(crate) poles: Poles,
    /// Where the sides were cut when the cells last met the target, side after side; not of those that are one point.
    fractions: SmallVec<[f64; 12]>,
    /// Where those of each side end.
    ends: [usize; 4],
    /// The largest certified error then.
    error: Error,
    /// The patch in all states, until its cells are done.
    patches: PerState<Patch>,
}

/// Room to refine in, used again from patch to patch.
#[derive(Default)]
pub(crate) struct Room {
    judge: Judge,
    /// The cells before and after a pass over all of them.
    before: Vec<Leaf>,
    after: Vec<Leaf>,
    open: Vec<Leaf>,
    parts: Vec<Cell>,
    /// Triangles of leaves, and of some that are not any more.
    triangles: Vec<[u32; 3]>,
}

impl Room {
    /// As [`Judge::new`].
    pub(crate) fn new(strict: bool) -> Self {
        Self { judge: Judge::new(strict), ..Self::default() }
    }
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
    /// A patch, in all its states, as one cell.
    pub(crate) fn new(patches: PerState<Patch>, poles: Poles) -> Self {
        let mut trees = patches.iter().map(Tree::new);
        let (tree, cell) = trees.next().unwrap_or_else(|| Tree::new(&Patch::default()));
        let others = trees.map(|(tree, _)| tree).collect();
        Self {
            tree,
            others,
            leaves: vec![Leaf::new(cell)],
            triangles: Vec::new(),
            poles,
            fractions: SmallVec::new(),
            error: Error::default(),
            ends: [0; 4],
            patches,
        }
    }

    /// The patches of all states, which are not needed any more when all cells meet the target.
    pub(crate) fn finish(&mut self) {
        self.patches = PerState::new();
    }

    /// The trees of all states, with their patches.
    fn trees(&mut self) -> impl Iterator<Item = (&mut Tree, &Patch)> {
        std::iter::once(&mut self.tree).chain(&mut self.others).zip(&self.patches)
    }

    /// Where a side was cut when the cells last met the target.
    fn cuts_of(&self, side: usize) -> &[f64] {
        let start = if side == 0 { 0 } else { self.ends[side - 1] };
        &self.fractions[start..self.ends[side]]
    }

    /// The sides, but for those that are one point, and where they were cut when the cells last met the target.
    pub(crate) fn cuts(&self) -> impl Iterator<Item = (usize, &[f64])> {
        (0..4).filter(|&side| !self.poles.0[side]).map(|side| (side, self.cuts_of(side)))
    }

    /// Cuts a side so that there are vertices at these dyadic fractions of it, which are all that it has.
    pub(crate) fn cut_side(&mut self, side: usize, fractions: &[f64]) {
        if fractions != self.cuts_of(side) {
            self.trees().for_each(|(tree, patch)| {
                fractions.iter().for_each(|&at| tree.cut_side(patch, side, at));
            });
        }
    }

    /// Keeps cells from cutting a side any further.
    pub(crate) fn fix(&mut self, side: usize) {
        self.trees().for_each(|(tree, _)| tree.fix(side));
    }

    /// Cuts cells until every one meets the target with the vertices now around it; false where the budget is spent.
    ///
    /// A cut adds vertices to the neighbours' edges, so cells are judged again until nothing changes.
    pub(crate) fn refine(&mut self, targets: &[Target], room: &mut Room, budget: &Budget) -> bool {
        let Room { judge, before, after, open, parts, triangles } = room;
        judge.start();
        before.clear();
        open.clear();
        triangles.clear();
        before.append(&mut self.leaves);
        triangles.append(&mut self.triangles);
        let mut again = true;
        while again {
            again = false;
            after.clear();
            for leaf in before.drain(..) {
                if self.tree.around(&leaf.cell) as u32 == leaf.seen {
                    after.push(leaf);
                    continue;
                }
                open.push(leaf);
                while let Some(mut leaf) = open.pop() {
                    let around = judge.look(&self.tree, &leaf.cell) as u32;
                    budget.give(leaf.count as usize);
                    match self.verdict(targets, judge, &leaf.cell) {
                        Ok(error) => {
                            let start = triangles.len();
                            triangles.extend(judge.triangles());
                            let count = triangles.len() - start;
                            if !budget.take(count) {
                                return false;
                            }
                            leaf = Leaf {
                                seen: around,
                                error,
                                start: start as u32,
                                count: count as u32,
                                ..leaf
                            };
                            after.push(leaf);
                        }
                        Err(how) => {
                            again = true;
                            for (tree, patch) in self.trees() {
                                parts.clear();
                                tree.cut(patch, &leaf.cell, how, parts);
                            }
                            if !take(&budget.cells, parts.len() - 1) {
                                return false;
                            }
                            open.extend(parts.drain(..).rev().map(Leaf::new));
                        }
                    }
                }
            }
            std::mem::swap(before, after);
        }
        self.keep(before, triangles);
        // While cells and tree are at hand.
        self.error = self.leaves.iter().map(|leaf| leaf.error).fold(Error::default(), Error::max);
        self.fractions.clear();
        for side in 0..4 {
            if !self.poles.0[side] {
                self.tree.fractions(side, &mut self.fractions);
            }
            self.ends[side] = self.fractions.len();
        }
        true
    }

    /// Takes over the leaves with those of the triangles that are theirs.
    fn keep(&mut self, leaves: &mut Vec<Leaf>, triangles: &[[u32; 3]]) {
        self.triangles.reserve_exact(leaves.iter().map(|leaf| leaf.count as usize).sum());
        for leaf in leaves.iter_mut() {
            let (start, count) = (leaf.start as usize, leaf.count as usize);
            leaf.start = self.triangles.len() as u32;
            self.triangles.extend_from_slice(&triangles[start..start + count]);
        }
        self.leaves.reserve_exact(leaves.len());
        self.leaves.append(leaves);
    }

    /// The error of a cell whose triangles do in all states, or how it is to be cut.
    fn verdict(&self, targets: &[Target], judge: &mut Judge, cell: &Cell) -> Result<Error, Cut> {
        let mut worst = Error::default();
        let trees = std::iter::once(&self.tree).chain(&self.others);
        for (k, (tree, (patch, target))) in trees.zip(self.patches.iter().zip(targets)).enumerate() {
            let verdict = if k == 0 {
                judge.judge(tree, patch, &self.poles, target, cell)
            } else {
                judge.check(tree, patch, &self.poles, target, cell)
            };
            match verdict {
                Verdict::Cut(how) => return Err(how),
                Verdict::Meets { error } => {
                    worst = worst.max(Error { length: error * target.size, share: error / target.chord });
                }
            }
        }
        Ok(worst)
    }

    /// The largest certified error.
    pub(crate) fn error(&self) -> Error {
        self.error
    }

    /// The triangles of all cells.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
}
