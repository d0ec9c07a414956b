//! The rows that a functional contributes: sparse, over all control vertices of a problem.

use std::any::Any;

use smallvec::SmallVec;

use super::shapes::Shapes;
use crate::Vector;
use crate::shape::Stencil;

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
    heads: Vec<Head>,
    vertices: Vec<usize>,
    coefficients: Vec<f64>,
    vectors: Vec<Vector>,
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
        write!(f, "{} room(s)", self.0.len())
    }
}

/// Where a functional puts its rows.
#[derive(Debug)]
pub struct Rows<'a> {
    store: &'a mut Store,
    offsets: SmallVec<[usize; 5]>,
}

impl Store {
    /// Where a functional of these shapes puts its rows; they come after those that are here already.
    pub fn rows(&mut self, shapes: &Shapes<'_>) -> Rows<'_> {
        Rows { store: self, offsets: (0..=shapes.len()).map(|i| shapes.offset(i)).collect() }
    }

    /// Forgets all blocks; the room for them stays.
    pub fn clear(&mut self) {
        self.heads.clear();
        self.vertices.clear();
        self.coefficients.clear();
        self.vectors.clear();
    }

    /// All blocks, in the order in which they were put here.
    pub fn equations(&self) -> impl Iterator<Item = Equation<'_>> {
        (0..self.blocks()).map(|i| self.block(i))
    }

    /// The number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.heads.len()
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
        let offset = self.offset(shape);
        self.open_alike();
        for (vertex, coefficient) in stencil.iter() {
            self.store.vertices.push(offset + vertex);
            self.store.coefficients.push(coefficient);
        }
    }

    /// Appends three equations for the difference of two stencils: `first - second`.
    pub fn difference(&mut self, first: (usize, &Stencil), second: (usize, &Stencil)) {
        let mut terms: Vec<(usize, f64)> = Vec::new();
        terms.extend(first.1.iter().map(|(v, c)| (self.offset(first.0) + v, c)));
        terms.extend(second.1.iter().map(|(v, c)| (self.offset(second.0) + v, -c)));
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
        if !matches!(self.store.heads.last(), Some(Head::Coupled { .. })) {
            self.equation();
        }
        let global = self.offset(shape) + vertex;
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
        if !matches!(self.store.heads.last(), Some(Head::Coupled { .. })) {
            self.equation();
        }
        let start = self.offset(shape) + first;
        self.store.vertices.extend(start..start + vectors.len());
        self.store.vectors.extend(vectors);
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
        match self.store.heads.last_mut() {
            Some(Head::Alike { constant, .. }) => *constant = value,
            Some(Head::Coupled { constant, .. }) => *constant = value.x,
            None => {}
        }
        self
    }

    /// Room to work in, for a functional that needs some: what was [given back](Self::give_back) last of this type to these
    /// rows' store, whatever is in it, else a new one. With it, linearizing again allocates nothing.
    #[must_use]
    pub fn room<T: Any + Default + Send + Sync>(&mut self) -> Box<T> {
        let rooms = &mut self.store.rooms.0;
        let known = rooms.iter().position(|room| room.is::<T>());
        let known = known.and_then(|at| rooms.swap_remove(at).downcast().ok());
        known.unwrap_or_default()
    }

    /// Keeps the room for the next linearization.
    pub fn give_back<T: Any + Send + Sync>(&mut self, room: Box<T>) {
        self.store.rooms.0.push(room);
    }

    /// The number of blocks so far.
    pub(crate) fn blocks(&self) -> usize {
        self.store.blocks()
    }

    fn open_alike(&mut self) {
        let (start, first) = (self.store.vertices.len(), self.store.coefficients.len());
        self.store.heads.push(Head::Alike { start, first, constant: Vector::zeros() });
    }

    fn offset(&self, shape: usize) -> usize {
        self.offsets.get(shape).copied().unwrap_or_else(|| self.offsets.last().copied().unwrap_or(0))
    }
}
