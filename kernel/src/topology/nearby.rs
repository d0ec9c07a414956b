//! What stands near a place: things by where they are, so that one that is there already is found.

use std::collections::BTreeMap;

use crate::{Point, Vector};

/// Cells are so many times as wide as what is near: few places are near a wall.
const WIDE: f64 = 16.0;

/// Things by their places, which are one where they are within a length of one another.
#[derive(Debug)]
pub(crate) struct Nearby<T> {
    low: Point,
    near: f64,
    cells: BTreeMap<[i64; 3], Vec<T>>,
}

impl<T> Nearby<T> {
    /// Nothing yet; `low` is below all places.
    pub(crate) fn new(low: Point, near: f64) -> Self {
        Self { low, near, cells: BTreeMap::new() }
    }

    /// The first of what was put within the length of a place (and of some of what lies around) that `is` it. Amortised `O(log n)`.
    pub(crate) fn find(&self, place: &Point, is: impl Fn(&T) -> bool) -> Option<&T> {
        let (below, above) = (self.cell(place, -self.near), self.cell(place, self.near));
        (0..8).find_map(|corner| {
            let key = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { below[axis] } else { above[axis] });
            self.cells.get(&key)?.iter().find(|thing| is(thing))
        })
    }

    /// Puts something at a place.
    pub(crate) fn put(&mut self, place: &Point, thing: T) {
        self.cells.entry(self.cell(place, 0.0)).or_default().push(thing);
    }

    fn cell(&self, place: &Point, shift: f64) -> [i64; 3] {
        let from: Vector = place - self.low;
        [0, 1, 2].map(|axis| ((from[axis] + shift) / (WIDE * self.near)).floor() as i64)
    }
}
