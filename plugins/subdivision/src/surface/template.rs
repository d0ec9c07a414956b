//! What faces with the same surroundings have in common: the pieces that they consist of, as rows over the vertices round them.
//!
//! Rows follow from how faces hang together and from sharpness, not from where vertices are; a mesh has many faces and few kinds of
//! surroundings. What is refined for one is there for all.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::local::{Local, around};
use super::pattern::Quadrant;
use crate::cage::Cage;
use crate::catmull_clark::weights::beyond_of;
use crate::error::Result;
use crate::part::Part;
use crate::topology::NONE;

/// Pieces over more vertices than these are not kept, so that they do not fill the memory.
const WIDEST: usize = 256;
/// Numbers that are kept, at most: 64 MB. What would be more takes the place of all.
const MOST: usize = 1 << 23;

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

/// A bicubic piece: which vertices of the surroundings it depends on, and how each counts in its net of 16.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) places: Vec<u32>,
    pub(super) columns: Vec<[f64; 16]>,
}

/// The pieces of all faces with the same surroundings.
#[derive(Debug)]
struct Template {
    /// Neighbourhoods refined one after another towards the last that was asked for, from the face itself on.
    path: Vec<(Quadrant, Arc<Local>)>,
    pieces: BTreeMap<Quadrant, Arc<Piece>>,
}

/// Templates by what their surroundings are. What comes out does not depend on what is kept.
#[derive(Debug, Default)]
pub(super) struct Templates(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    all: BTreeMap<Vec<u32>, Template>,
    numbers: usize,
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
    /// The pieces over quadrants of a face, in their order, as [`piece`](Self::piece) has them one by one.
    pub(super) fn pieces(
        &self,
        cage: &Cage,
        near: &Near,
        quadrants: &[Quadrant],
    ) -> Result<Vec<Option<Arc<Piece>>>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept.all.get(&near.key).and_then(|template| {
            let piece = |quadrant| template.pieces.get(quadrant).map(|piece| Some(Arc::clone(piece)));
            quadrants.iter().map(piece).collect()
        });
        match known {
            Some(pieces) => Ok(pieces),
            None => quadrants.iter().map(|&quadrant| kept.piece(cage, near, quadrant)).collect(),
        }
    }

    /// The piece over a quadrant of a face; `None` where it is not regular. Cost: a look-up where faces like it were asked for it, else
    /// a refinement for each level that it does not share with the last.
    pub(super) fn piece(&self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Option<Arc<Piece>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).piece(cage, near, quadrant)
    }

    /// The neighbourhood of a quadrant of a face. Cost: a refinement for each level that it does not share with the last.
    pub(super) fn local(&self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Arc<Local>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).local(cage, near, quadrant)
    }
}

impl Kept {
    fn piece(&mut self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Option<Arc<Piece>>> {
        let known = self.all.get(&near.key).and_then(|template| template.pieces.get(&quadrant));
        if let Some(piece) = known {
            return Ok(Some(Arc::clone(piece)));
        }
        let local = self.local(cage, near, quadrant)?;
        let Some(net) = local.net() else { return Ok(None) };
        let used = net.into_iter().enumerate().filter(|(_, column)| column.iter().any(|&c| c != 0.0));
        let (places, columns) = used.map(|(k, column)| (k as u32, column)).unzip();
        let piece = Arc::new(Piece { places, columns });
        self.keep(near, quadrant, &piece);
        Ok(Some(piece))
    }

    fn local(&mut self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Arc<Local>> {
        let template = self
            .all
            .entry(near.key.clone())
            .or_insert_with(|| Template { path: Vec::new(), pieces: BTreeMap::new() });
        template.local(cage, near, quadrant)
    }

    fn keep(&mut self, near: &Near, quadrant: Quadrant, piece: &Arc<Piece>) {
        if piece.places.len() > WIDEST {
            return;
        }
        let more = 17 * piece.places.len();
        if self.numbers + more > MOST {
            self.all.values_mut().for_each(|template| template.pieces.clear());
            self.numbers = 0;
        }
        if let Some(template) = self.all.get_mut(&near.key) {
            template.pieces.insert(quadrant, Arc::clone(piece));
            self.numbers += more;
        }
    }
}

impl Template {
    fn local(&mut self, cage: &Cage, near: &Near, quadrant: Quadrant) -> Result<Arc<Local>> {
        if let Some((known, local)) = self.path.get(quadrant.level as usize)
            && *known == quadrant
        {
            return Ok(Arc::clone(local));
        }
        // The way down, from the whole.
        let mut way = vec![(quadrant, 0)];
        while let Some((parent, corner)) = way[way.len() - 1].0.parent() {
            let last = way.len() - 1;
            way[last].1 = corner;
            way.push((parent, 0));
        }
        way.reverse();
        let same = self.path.iter().zip(&way).take_while(|(a, b)| a.0 == b.0).count();
        self.path.truncate(same);
        let mut local = self.path.last().map(|(_, local)| Arc::clone(local));
        for &(quadrant, corner) in &way[same..] {
            let next = match &local {
                None => near.root(cage)?,
                Some(parent) => parent.refined(corner, (4 - corner) % 4)?,
            };
            let next = Arc::new(next);
            // A wide neighbourhood is kept no longer than it is needed, and so is what follows it.
            if next.width() <= WIDEST {
                self.path.push((quadrant, Arc::clone(&next)));
            }
            local = Some(next);
        }
        match local {
            Some(local) => Ok(local),
            None => near.root(cage).map(Arc::new),
        }
    }
}
