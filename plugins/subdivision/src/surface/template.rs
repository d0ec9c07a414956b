//! What faces with the same surroundings have in common: the pieces that they consist of, as rows over the vertices round them.
//!
//! Rows follow from how faces hang together and from sharpness, not from where vertices are; a mesh has many faces and few kinds of
//! surroundings. What is refined for one is there for all.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use super::local::{Local, around};
use super::net::bezier;
use super::pattern::Quadrant;
use crate::cage::Cage;
use crate::catmull_clark::weights::beyond_of;
use crate::error::Result;
use crate::part::Part;
use crate::topology::NONE;

/// Numbers that are kept, at most: 64 MB. What would be more takes the place of all.
const MOST: usize = 1 << 23;
/// A neighbourhood or a piece of more numbers than these is not kept, so that few do not take the place of all: those of a point of some 350 edges and more.
const LARGEST: usize = MOST / 16;

/// The surroundings of a face of the surface.
#[derive(Debug)]
pub(super) struct Near {
    /// The vertices of the cage that its rows are over.
    pub(super) base: Vec<u32>,
    part: Part,
    /// Whether it is the part of a face, no quad, at a corner.
    divided: bool,
    /// What is beyond the edges of its part, with knot intervals.
    beyond: Vec<[f64; 2]>,
    key: Vec<u32>,
}

/// A bicubic piece: which vertices of the surroundings it depends on, how each counts in its net of 16, and how in its Bézier points.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) places: Vec<u32>,
    pub(super) columns: Vec<[f64; 16]>,
    pub(super) bezier: Vec<[f64; 16]>,
}

/// What faces with the same surroundings have in common, as far as it was asked for.
#[derive(Debug, Default)]
pub(super) struct Template {
    locals: RwLock<BTreeMap<Quadrant, Arc<Local>>>,
    pieces: RwLock<BTreeMap<Quadrant, Arc<Piece>>>,
}

/// Templates by what their surroundings are. What comes out does not depend on what is kept, nor on who asks first.
#[derive(Debug, Default)]
pub(super) struct Templates {
    all: RwLock<BTreeMap<Vec<u32>, Arc<Template>>>,
    /// How many numbers they hold, about.
    numbers: AtomicUsize,
}

impl Near {
    /// Of a face of the cage, or of its part at a corner ([`NONE`] for the whole). Cost: the corners of the faces round it.
    pub(super) fn new(cage: &Cage, face: u32, corner: u32) -> Result<Self> {
        let divided = corner != NONE;
        let part = around(cage.topology(), face as usize, if divided { corner as usize } else { 0 })?;
        Ok(Self::of(cage, part, divided, |e| beyond_of(cage, e)))
    }

    /// Of a face of the cage, seen from one of its corners.
    pub(super) fn from_corner(cage: &Cage, face: usize, corner: usize) -> Result<Self> {
        let part = around(cage.topology(), face, corner)?;
        Ok(Self::of(cage, part, false, |e| beyond_of(cage, e)))
    }

    /// Of the face of a neighbourhood, seen from one of its corners.
    pub(super) fn of_local(local: &Local, corner: usize) -> Result<Self> {
        let part = around(local.cage().topology(), 0, corner)?;
        Ok(Self::of(local.cage(), part, false, |e| local.beyond(e)))
    }

    fn of(cage: &Cage, part: Part, divided: bool, beyond: impl Fn(usize) -> [f64; 2]) -> Self {
        let beyond = if cage.has_intervals() { part.beyond(cage.topology(), beyond) } else { Vec::new() };
        let mut key = part.key(cage, &beyond);
        key.push(u32::from(divided));
        Self { base: part.kept.clone(), part, divided, beyond, key }
    }

    /// What the surroundings are, as numbers: faces for which these are equal have the same rows.
    pub(super) fn key(&self) -> &[u32] {
        &self.key
    }

    /// The face of the surface as it is before any place on it is looked for.
    pub(super) fn root(&self, cage: &Cage) -> Result<Local> {
        let local = Local::new(cage, &self.part, &self.beyond)?;
        if self.divided { local.refined(0, 0) } else { Ok(local) }
    }
}

impl Templates {
    /// That of a face's surroundings. Cost: a look-up.
    pub(super) fn of(&self, near: &Near) -> Arc<Template> {
        let known = read(&self.all).get(&near.key).map(Arc::clone);
        known.unwrap_or_else(|| {
            self.add(near.key.len());
            Arc::clone(write(&self.all).entry(near.key.clone()).or_default())
        })
    }

    /// How many there are.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        read(&self.all).len()
    }

    /// The pieces over quadrants of a face, in their order, as [`piece`](Self::piece) has them one by one.
    pub(super) fn pieces(
        &self,
        cage: &Cage,
        near: &Near,
        quadrants: impl Iterator<Item = Quadrant> + Clone,
    ) -> Result<Vec<Option<Arc<Piece>>>> {
        let template = self.of(near);
        let known = {
            let kept = read(&template.pieces);
            let piece = |quadrant| kept.get(&quadrant).map(|piece| Some(Arc::clone(piece)));
            quadrants.clone().map(piece).collect()
        };
        match known {
            Some(pieces) => Ok(pieces),
            None => quadrants.map(|quadrant| self.piece_of(&template, cage, near, quadrant)).collect(),
        }
    }

    /// The piece over a quadrant of a face; `None` where it is not regular. Cost: a look-up where faces like it were asked for it, else
    /// a refinement for each level that none of them was asked for.
    pub(super) fn piece(&self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Option<Arc<Piece>>> {
        self.piece_of(&self.of(near), cage, near, quadrant)
    }

    /// The neighbourhood of a quadrant of a face. Cost: a refinement for each level that faces like it were not asked for.
    pub(super) fn local(&self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Arc<Local>> {
        let template = self.of(near);
        let local = self.local_of(&template, cage, near, quadrant)?;
        self.keep(&template, quadrant, &local);
        Ok(local)
    }

    fn piece_of(
        &self,
        template: &Template,
        cage: &Cage,
        near: &Near,
        quadrant: Quadrant,
    ) -> Result<Option<Arc<Piece>>> {
        if let Some(piece) = read(&template.pieces).get(&quadrant) {
            return Ok(Some(Arc::clone(piece)));
        }
        let local = self.local_of(template, cage, near, quadrant)?;
        let Some(net) = local.net() else { return Ok(None) };
        let used = net.into_iter().enumerate().filter(|(_, column)| column.iter().any(|&c| c != 0.0));
        let (places, columns): (_, Vec<_>) = used.map(|(k, column)| (k as u32, column)).unzip();
        let bezier = columns.iter().map(bezier).collect();
        let piece = Arc::new(Piece { places, columns, bezier });
        let numbers = 33 * piece.places.len();
        if numbers <= LARGEST {
            write(&template.pieces).insert(quadrant, Arc::clone(&piece));
            self.add(numbers);
        }
        Ok(Some(piece))
    }

    /// The neighbourhood of a quadrant; those of what it is a part of are kept, for others are parts of these, too.
    fn local_of(
        &self,
        template: &Template,
        cage: &Cage,
        near: &Near,
        quadrant: Quadrant,
    ) -> Result<Arc<Local>> {
        // The way up, to one that is there.
        let (mut way, mut at) = (Vec::new(), quadrant);
        let mut local = loop {
            if let Some(known) = read(&template.locals).get(&at) {
                break Arc::clone(known);
            }
            let Some((parent, corner)) = at.parent() else { break Arc::new(near.root(cage)?) };
            way.push((at, corner));
            at = parent;
        };
        while let Some((next, corner)) = way.pop() {
            self.keep(template, at, &local);
            local = Arc::new(local.refined(corner, (4 - corner) % 4)?);
            at = next;
        }
        Ok(local)
    }

    fn keep(&self, template: &Template, quadrant: Quadrant, local: &Arc<Local>) {
        if local.numbers() <= LARGEST && !read(&template.locals).contains_key(&quadrant) {
            write(&template.locals).insert(quadrant, Arc::clone(local));
            self.add(local.numbers());
        }
    }

    /// Counts what is kept, and lets all of it go where that is too much.
    fn add(&self, more: usize) {
        if self.numbers.fetch_add(more, Ordering::Relaxed) + more > MOST {
            write(&self.all).clear();
            self.numbers.store(0, Ordering::Relaxed);
        }
    }
}

fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}
