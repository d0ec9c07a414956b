//! Parts of cells, and what was found of each.

use std::cmp::Ordering;

use loftsman_kernel::shape::Location;

/// A part of a cell: its interval in each direction.
#[derive(Clone, Copy)]
pub(super) struct Part {
    /// The number of the patch that it is on, and its span in each direction, where the surface is a tensor-product spline there.
    pub(super) spans: Option<(usize, [usize; 2])>,
    /// The number of its cell, where cells have nets.
    pub(super) cell: usize,
    /// The face that it is on, of a surface of many.
    pub(super) face: Option<u32>,
    pub(super) u: (f64, f64),
    pub(super) v: (f64, f64),
    /// Which of the counted cells this is, where only a part of it counts, and how much finer than at first it is looked at (a power of two): by rules of
    /// more points, then on more parts.
    pub(super) share: Option<(usize, usize)>,
    /// How often it has been halved in each direction.
    pub(super) halved: [u16; 2],
}

impl Part {
    /// A whole box of parameters.
    pub(super) fn whole(face: Option<u32>, u: (f64, f64), v: (f64, f64)) -> Self {
        Self { spans: None, cell: 0, face, u, v, share: None, halved: [0; 2] }
    }

    /// A place of it.
    pub(super) fn at(&self, u: f64, v: f64) -> Location {
        self.face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
    }
}

/// A part with its area, by the better rule, and the difference of both; in the heap the part with most is the greatest.
#[derive(Clone, Copy)]
pub(super) struct Judged {
    pub(super) part: Part,
    pub(super) fine: f64,
    pub(super) error: f64,
    /// Across which direction to halve it.
    pub(super) across_u: bool,
    pub(super) order: usize,
    /// Whether it cannot be halved any more.
    pub(super) settled: bool,
}

impl PartialEq for Judged {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Judged {}

impl PartialOrd for Judged {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Judged {
    /// Of equal ones the first made, so that the answer is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        let open = other.settled.cmp(&self.settled);
        open.then(self.error.total_cmp(&other.error)).then(other.order.cmp(&self.order))
    }
}
