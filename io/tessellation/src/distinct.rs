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
}

impl<T: Copy> Distinct<T> {
    /// For so many points.
    pub(crate) fn new(points: usize) -> Self {
        let (next, values) = (Vec::with_capacity(points), Vec::with_capacity(points));
        Self { head: vec![NONE; points], next, values, single: true }
    }

    /// The index of a value that the point has already (of the last few), or of this one from now on.
    pub(crate) fn find(&mut self, point: u32, value: T, same: impl Fn(&T, &T) -> bool) -> u32 {
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
        self.single &= head == NONE;
        let index = self.values.len() as u32;
        self.values.push(value);
        self.next.push(head);
        self.head[point as usize] = index;
        index
    }

    /// The layer: by point where every point has one value, else by corner. `kept` are the points of the mesh.
    pub(crate) fn into_layer(self, corners: Vec<u32>, kept: &[u32]) -> Layer<T> {
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
