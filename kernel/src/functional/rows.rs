//! The rows that a functional contributes: sparse, over all control vertices of a problem.

use std::any::Any;

use smallvec::SmallVec;

use super::shapes::Shapes;
use crate::Vector;
use crate::error::Result;
use crate::shape::Stencil;
use crate::text::counted;

/// One block of equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Equation<'a> {
    /// Three equations, x, y and z, that share one stencil: `Σ c_k P_k` with the constant vector beside it.
    Alike {
        /// Global vertex numbers, ascending.
        vertices: &'a [usize],
        /// The coefficient of each.
        coefficients: &'a [f64],
        /// The constant.
        constant: Vector,
    },
    /// One equation that may couple the axes: `Σ a_k·P_k + c`.
    Coupled {
        /// Global vertex numbers; one may repeat.
        vertices: &'a [usize],
        /// The vector of each.
        vectors: &'a [Vector],
        /// The constant.
        constant: f64,
    },
}

#[derive(Debug, Clone, Copy)]
enum Head {
    Alike { start: usize, first: usize, constant: Vector },
    Coupled { start: usize, first: usize, constant: f64 },
}

/// Keeps rows; reused between linearizations without allocating anew.
#[derive(Debug, Clone, Default)]
pub struct Store {
    // What one place of a cubic gives is kept in place.
    heads: SmallVec<[Head; 1]>,
    vertices: SmallVec<[usize; 4]>,
    coefficients: SmallVec<[f64; 4]>,
    vectors: Vec<Vector>,
    /// What was put here first that cannot be here.
    astray: Option<String>,
    rooms: Rooms,
}

/// What functionals work with, one of a type.
#[derive(Default)]
struct Rooms(Vec<Box<dyn Any + Send + Sync>>);

impl Clone for Rooms {
    /// Empty: what is in them says nothing about the rows.
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for Rooms {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&counted(self.0.len(), "room[|s]"))
    }
}

/// Where a functional puts its rows. A control vertex that is not there is remembered: [`rows_of`](super::rows_of) tells.
#[derive(Debug)]
pub struct Rows<'a> {
    store: &'a mut Store,
    shapes: &'a Shapes<'a>,
    /// The first block of the functional whose turn it is: it may not touch those before.
    floor: usize,
}

impl Store {
    /// Where a functional of these shapes puts its rows; they come after those that are here already.
    pub fn rows<'a>(&'a mut self, shapes: &'a Shapes<'_>) -> Rows<'a> {
        Rows { store: self, shapes, floor: 0 }
    }

    /// Forgets all blocks; the room for them stays.
    pub fn clear(&mut self) {
        self.heads.clear();
        self.vertices.clear();
        self.coefficients.clear();
        self.vectors.clear();
        self.astray = None;
    }

    /// All blocks, in the order in which they were put here.
    pub fn equations(&self) -> impl Iterator<Item = Equation<'_>> {
        (0..self.blocks()).map(|i| self.block(i))
    }

    /// The vertices of all blocks, one behind the other.
    pub(crate) fn touched(&self) -> &[usize] {
        &self.vertices
    }

    /// Whether all blocks treat the axes alike.
    pub(crate) fn is_alike(&self) -> bool {
        self.heads.iter().all(|head| matches!(head, Head::Alike { .. }))
    }

    /// The scalar equations from block `first` on.
    pub(crate) fn equations_from(&self, first: usize) -> usize {
        let width = |head: &Head| if matches!(head, Head::Alike { .. }) { 3 } else { 1 };
        self.heads[first..].iter().map(width).sum()
    }

    /// The number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.heads.len()
    }

    /// Makes room for so many blocks of equations alike, as large as those of a cubic.
    pub(crate) fn reserve(&mut self, blocks: usize) {
        self.heads.reserve(blocks);
        self.vertices.reserve(4 * blocks);
        self.coefficients.reserve(4 * blocks);
    }

    /// Block `i`.
    pub(crate) fn block(&self, i: usize) -> Equation<'_> {
        let end = |get: fn(&Head) -> usize| self.heads.get(i + 1).map(get);
        match self.heads[i] {
            Head::Alike { start, first, constant } => {
                let stop = end(|h| match *h {
                    Head::Alike { start, .. } | Head::Coupled { start, .. } => start,
                });
                let count = stop.unwrap_or(self.vertices.len()) - start;
                Equation::Alike {
                    vertices: &self.vertices[start..start + count],
                    coefficients: &self.coefficients[first..first + count],
                    constant,
                }
            }
            Head::Coupled { start, first, constant } => {
                let stop = end(|h| match *h {
                    Head::Alike { start, .. } | Head::Coupled { start, .. } => start,
                });
                let count = stop.unwrap_or(self.vertices.len()) - start;
                Equation::Coupled {
                    vertices: &self.vertices[start..start + count],
                    vectors: &self.vectors[first..first + count],
                    constant,
                }
            }
        }
    }

    /// The first coefficient or constant from block `first` on that is not finite, told.
    pub(super) fn unusable(&self, first: usize) -> Option<String> {
        let tell = |vertex: Option<&usize>, what: &dyn std::fmt::Debug| match vertex {
            Some(vertex) => format!(
                "has {what:?} for the coefficient of control vertex {vertex}: coefficients must be finite (are the shape's \
                 numbers too large to compute with?)"
            ),
            None => format!("has the constant {what:?}: constants must be finite"),
        };
        (first..self.blocks()).find_map(|i| match self.block(i) {
            Equation::Alike { vertices, coefficients, constant } => {
                // Zero times what is not finite is NaN, which stays in a sum.
                let sum = coefficients.iter().chain(&constant).fold(0.0, |sum, c| sum + c * 0.0);
                if sum == 0.0 {
                    return None;
                }
                let bad = coefficients.iter().position(|c| !c.is_finite());
                bad.map(|k| tell(vertices.get(k), &coefficients[k])).or_else(|| {
                    constant.iter().any(|c| !c.is_finite()).then(|| tell(None, &constant.as_slice()))
                })
            }
            Equation::Coupled { vertices, vectors, constant } => {
                let bad = vectors.iter().position(|v| !v.iter().all(|c| c.is_finite()));
                bad.map(|k| tell(vertices.get(k), &vectors[k].as_slice()))
                    .or_else(|| (!constant.is_finite()).then(|| tell(None, &constant)))
            }
        })
    }

    /// Rows times vertices plus constants, into `out`; what does not fit is left.
    pub fn evaluate(&self, shapes: &Shapes<'_>, out: &mut [f64]) {
        let mut slots = out.iter_mut();
        for i in 0..self.blocks() {
            match self.block(i) {
                Equation::Alike { vertices, coefficients, constant } => {
                    let sum = vertices
                        .iter()
                        .zip(coefficients)
                        .fold(constant, |sum, (&v, &c)| sum + shapes.vertex(v).coords * c);
                    for axis in 0..3 {
                        if let Some(slot) = slots.next() {
                            *slot = sum[axis];
                        }
                    }
                }
                Equation::Coupled { vertices, vectors, constant } => {
                    let sum = vertices
                        .iter()
                        .zip(vectors)
                        .fold(constant, |sum, (&v, a)| sum + a.dot(&shapes.vertex(v).coords));
                    if let Some(slot) = slots.next() {
                        *slot = sum;
                    }
                }
            }
        }
    }
}

impl Rows<'_> {
    /// Appends three equations (x, y, z) that share the stencil of shape `shape`.
    pub fn alike(&mut self, shape: usize, stencil: &Stencil) {
        self.open_alike();
        if let (Some(own), Some(&last)) = (self.shapes.range(shape), stencil.vertices().last())
            && last < own.len()
        {
            // Vertices ascend: all are there.
            let first = self.store.vertices.len();
            self.store.vertices.extend_from_slice(stencil.vertices());
            self.store.vertices[first..].iter_mut().for_each(|vertex| *vertex += own.start);
            self.store.coefficients.extend_from_slice(stencil.coefficients());
            return;
        }
        for (vertex, coefficient) in stencil.iter() {
            let global = self.global(shape, vertex);
            self.store.vertices.push(global);
            self.store.coefficients.push(coefficient);
        }
    }

    /// The same with the value of the stencil, three numbers.
    pub(super) fn linearize_alike(
        &mut self,
        shape: usize,
        stencil: &Stencil,
        value: &mut [f64],
    ) -> Result<()> {
        self.alike(shape, stencil);
        value.copy_from_slice(stencil.apply(self.shapes.get(shape)?.control_vertices()).as_slice());
        Ok(())
    }

    /// Appends three equations for the difference of two stencils: `first - second`.
    pub fn difference(&mut self, first: (usize, &Stencil), second: (usize, &Stencil)) {
        let mut terms: Vec<(usize, f64)> = Vec::new();
        terms.extend(first.1.iter().map(|(v, c)| (self.global(first.0, v), c)));
        terms.extend(second.1.iter().map(|(v, c)| (self.global(second.0, v), -c)));
        let merged: Stencil = terms.into_iter().collect();
        self.open_alike();
        for (vertex, coefficient) in merged.iter() {
            self.store.vertices.push(vertex);
            self.store.coefficients.push(coefficient);
        }
    }

    /// Opens one equation that may couple the axes; [`term`](Self::term) fills it.
    pub fn equation(&mut self) -> &mut Self {
        let (start, first) = (self.store.vertices.len(), self.store.vectors.len());
        self.store.heads.push(Head::Coupled { start, first, constant: 0.0 });
        self
    }

    /// Adds `vector · P` of a control vertex to the equation opened last.
    pub fn term(&mut self, shape: usize, vertex: usize, vector: Vector) -> &mut Self {
        self.open_coupled();
        let global = self.global(shape, vertex);
        self.store.vertices.push(global);
        self.store.vectors.push(vector);
        self
    }

    /// Adds a vector for each of a run of control vertices, from `first` on, to the equation opened last.
    pub fn terms(
        &mut self,
        shape: usize,
        first: usize,
        vectors: impl ExactSizeIterator<Item = Vector>,
    ) -> &mut Self {
        self.open_coupled();
        let (length, before) = (vectors.len(), self.store.vectors.len());
        let Some(last) = length.checked_sub(1) else { return self };
        let last = self.global(shape, first.saturating_add(last));
        let start = self.global(shape, first);
        if last == NOWHERE || start == NOWHERE {
            return self.term(shape, NOWHERE, Vector::zeros());
        }
        self.store.vertices.extend(start..=last);
        self.store.vectors.extend(vectors);
        // An iterator that does not keep its word about its length.
        if self.store.vectors.len() != before + length {
            self.store.vectors.resize(before + length, Vector::zeros());
            self.lost(|| format!("announces {length} terms and gives another number of them"));
        }
        self
    }

    /// Adds `direction · Σ c_i P_i` to the equation opened last.
    pub fn along(&mut self, shape: usize, stencil: &Stencil, direction: Vector) -> &mut Self {
        for (vertex, coefficient) in stencil.iter() {
            self.term(shape, vertex, direction * coefficient);
        }
        self
    }

    /// Sets the constant of the block opened last: of the one equation, or (the vector) of the three.
    pub fn constant(&mut self, value: Vector) -> &mut Self {
        if self.store.heads.len() <= self.floor {
            self.lost(|| "gives a constant before it has opened an equation".into());
            return self;
        }
        match self.store.heads.last_mut() {
            Some(Head::Alike { constant, .. }) => *constant = value,
            Some(Head::Coupled { constant, .. }) => *constant = value.x,
            None => {}
        }
        self
    }

    /// Scratch memory, for a functional that needs some: what was [returned](Self::return_scratch) last of this type to these
    /// rows' store, whatever is in it, else a new one. With it, linearizing again allocates nothing.
    #[must_use]
    pub fn scratch<T: Any + Default + Send + Sync>(&mut self) -> Box<T> {
        let rooms = &mut self.store.rooms.0;
        let known = rooms.iter().position(|room| room.is::<T>());
        let known = known.and_then(|at| rooms.swap_remove(at).downcast().ok());
        known.unwrap_or_default()
    }

    /// Keeps the scratch memory for the next linearization.
    pub fn return_scratch<T: Any + Send + Sync>(&mut self, scratch: Box<T>) {
        self.store.rooms.0.push(scratch);
    }

    /// All that was put here, by whomever.
    pub(super) fn store(&self) -> &Store {
        self.store
    }

    /// The number of blocks so far.
    pub(crate) fn blocks(&self) -> usize {
        self.store.blocks()
    }

    /// The turn of another functional, which may not touch the blocks so far; their number.
    pub(super) fn begin(&mut self) -> usize {
        self.store.astray = None;
        self.floor = self.blocks();
        self.floor
    }

    /// What was put here that cannot be here, first of all.
    pub(super) fn astray(&self) -> Option<&str> {
        self.store.astray.as_deref()
    }

    /// The scalar equations from block `first` on.
    pub(super) fn scalar_equations(&self, first: usize) -> usize {
        self.store.equations_from(first)
    }

    fn open_alike(&mut self) {
        let (start, first) = (self.store.vertices.len(), self.store.coefficients.len());
        self.store.heads.push(Head::Alike { start, first, constant: Vector::zeros() });
    }

    /// An equation that may couple the axes, if the last one is not one of this functional.
    fn open_coupled(&mut self) {
        let own = self.store.heads.len() > self.floor;
        if !(own && matches!(self.store.heads.last(), Some(Head::Coupled { .. }))) {
            self.equation();
        }
    }

    /// The number of a control vertex, counted through all shapes; [`NOWHERE`] where there is none, which is remembered.
    fn global(&mut self, shape: usize, vertex: usize) -> usize {
        match self.shapes.range(shape) {
            Some(own) if vertex < own.len() => own.start + vertex,
            Some(own) => {
                let count = own.len();
                self.lost(|| {
                    let named = if vertex == NOWHERE { String::new() } else { format!(" {vertex}") };
                    format!(
                        "names a control vertex{named} of shape {shape} that is not there: it has {count}, numbered from 0"
                    )
                });
                NOWHERE
            }
            None => {
                let count = self.shapes.len();
                self.lost(|| {
                    format!("names shape {shape}, but there are {count} in the problem, numbered from 0")
                });
                NOWHERE
            }
        }
    }

    fn lost(&mut self, what: impl FnOnce() -> String) {
        if self.store.astray.is_none() {
            self.store.astray = Some(what());
        }
    }
}

/// A control vertex that is not there; its coefficients count for nothing.
const NOWHERE: usize = usize::MAX;
