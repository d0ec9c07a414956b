//! The different values that one point has at its corners.

use loftsman_kernel::mesh::{Layer, NONE};

/// How many of a point's values are looked at: at a seam there are two, at the apex of a cone as many as faces.
const LOOK: usize = 8;

/// Values by point, each once.
#[derive(Debug)]
pub(crate) struct Distinct<T> {
    head: Vec<u32>,
    next: Vec<u32>,
    values: Vec<T>,
    /// Whether no point has more than one.
    single: bool,
    /// The values of the corners, which are the first of their points as long as nobody needs to tell them apart: then none
    /// are kept.
    corners: Option<Vec<u32>>,
}

impl<T: Copy> Distinct<T> {
    /// For so many points.
    pub(crate) fn new(points: usize) -> Self {
        let (next, values) = (Vec::with_capacity(points), Vec::with_capacity(points));
        Self { head: vec![NONE; points], next, values, single: true, corners: None }
    }

    /// The index of a value that the point has already (of the last few), or of this one from now on. `before` are the points
    /// of the corners that have values.
    pub(crate) fn find(
        &mut self,
        point: u32,
        value: T,
        before: &[u32],
        same: impl Fn(&T, &T) -> bool,
    ) -> u32 {
        let head = self.head[point as usize];
        let mut at = head;
        for _ in 0..LOOK {
            if at == NONE {
                break;
            }
            if same(&self.values[at as usize], &value) {
                return at;
            }
            at = self.next[at as usize];
        }
        if head != NONE {
            self.single = false;
            self.tell_apart(before);
        }
        let index = self.values.len() as u32;
        self.values.push(value);
        self.next.push(head);
        self.head[point as usize] = index;
        index
    }

    /// Keeps the values of corners from now on. Up to here every corner has the only one of its point.
    fn tell_apart(&mut self, before: &[u32]) -> &mut Vec<u32> {
        let head = &self.head;
        self.corners.get_or_insert_with(|| before.iter().map(|&point| head[point as usize]).collect())
    }

    /// Gives the next corner a value that has been found for its point.
    pub(crate) fn add_corner(&mut self, value: u32) {
        if let Some(corners) = &mut self.corners {
            corners.push(value);
        }
    }

    /// Gives the next corner none. `before` as in [`find`](Self::find).
    pub(crate) fn add_corner_without(&mut self, before: &[u32]) {
        self.tell_apart(before).push(NONE);
    }

    /// Gives values to the corners that have none, by their points, which are those of all corners.
    pub(crate) fn fill(
        &mut self,
        points: &[u32],
        value: impl Fn(u32) -> T,
        same: impl Fn(&T, &T) -> bool + Copy,
    ) {
        let mut corners = self.corners.take().unwrap_or_default();
        for (of, &point) in corners.iter_mut().zip(points).filter(|(of, _)| **of == NONE) {
            *of = self.find(point, value(point), &[], same);
        }
        self.corners = Some(corners);
    }

    /// Whether some corners have none.
    pub(crate) fn lacks(&self) -> bool {
        self.corners.as_ref().is_some_and(|corners| corners.contains(&NONE))
    }

    /// The layer: by point where every point has one value, else by corner. `kept` are the points of the mesh.
    pub(crate) fn into_layer(self, kept: &[u32]) -> Layer<T> {
        let corners = self.corners.unwrap_or_default();
        if !self.single {
            return Layer::per_corner(self.values, corners);
        }
        let of = |&point: &u32| self.values.get(self.head[point as usize] as usize).copied();
        match kept.iter().map(of).collect() {
            Some(values) => Layer::per_point(values),
            None => Layer::per_corner(self.values, corners),
        }
    }
}
