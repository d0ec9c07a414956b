//! Quads that are divided in four, each as far as it needs, and the points that they have in common.

use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use super::cut::Cut;
use super::places::Place;
use crate::topology::NONE;

/// A face of the surface or a part of one, with what a scheme knows it by.
pub(crate) struct Quad<T> {
    pub(crate) own: T,
    /// The numbers of its corners; [`NONE`] all but where it is no quad yet.
    pub(crate) corners: SmallVec<[u32; 4]>,
    /// Where on the surface it is; the number of the surface's first face on it where it is no quad yet.
    pub(crate) place: Result<Place, u32>,
    /// Its first child and their number, where it was refined, and the number of its middle.
    pub(crate) children: Option<(u32, u32, u32)>,
    /// Whether it is one of those that the surface consists of: not yet one of them, or no longer, where it is not.
    pub(crate) is_shown: bool,
    pub(crate) since: Since,
    pub(crate) level: u32,
}

/// Levels on which those that a face came from were near enough.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Since {
    pub(crate) proved: u32,
    pub(crate) found: u32,
}

/// The middle of an edge between two points.
#[derive(Clone, Copy)]
struct Middle {
    other: u32,
    name: u32,
    /// Whether a face at the edge is split, so that the point is in the mesh.
    is_there: bool,
}

/// All faces and points.
pub(crate) struct Quads<T> {
    pub(crate) all: Vec<Quad<T>>,
    /// Where the points are, in each state.
    pub(crate) points: Vec<Vec<Point>>,
    /// The normals of all, in the first state.
    pub(crate) normals: Vec<Option<Vector>>,
    /// The middles of edges, at the end with the smaller number.
    middles: Vec<SmallVec<[Middle; 4]>>,
}

impl<T> Quads<T> {
    /// None, of a surface in so many states.
    pub(crate) fn new(states: usize) -> Self {
        Self { all: Vec::new(), points: vec![Vec::new(); states], normals: Vec::new(), middles: Vec::new() }
    }

    /// A face of the surface, shown.
    pub(crate) fn add(&mut self, own: T, corners: SmallVec<[u32; 4]>, place: Result<Place, u32>) {
        let since = Since::default();
        self.all.push(Quad { own, corners, place, children: None, is_shown: true, since, level: 0 });
    }

    /// Gives a face its children, not shown yet: what each is known by, its corners, and its place.
    pub(crate) fn add_children(
        &mut self,
        node: usize,
        middle: u32,
        children: impl Iterator<Item = (T, SmallVec<[u32; 4]>, Place)>,
    ) {
        let (first, level) = (self.all.len(), self.all[node].level + 1);
        for (own, corners, place) in children {
            let since = Since::default();
            let place = Ok(place);
            self.all.push(Quad { own, corners, place, children: None, is_shown: false, since, level });
        }
        self.all[node].children = Some((first as u32, (self.all.len() - first) as u32, middle));
    }

    /// The number of a new point.
    pub(crate) fn name(&mut self) -> u32 {
        self.points.iter_mut().for_each(|points| points.push(Point::origin()));
        self.normals.push(None);
        self.middles.push(SmallVec::new());
        self.normals.len() as u32 - 1
    }

    /// The number of the middle of an edge, new where there is none.
    pub(crate) fn name_middle(&mut self, a: u32, b: u32) -> u32 {
        if let Some(middle) = self.middle(a, b) {
            return middle.name;
        }
        let name = self.name();
        self.middles[a.min(b) as usize].push(Middle { other: a.max(b), name, is_there: false });
        name
    }

    fn middle(&self, a: u32, b: u32) -> Option<&Middle> {
        let (a, b) = (a.min(b), a.max(b));
        self.middles[a as usize].iter().find(|m| m.other == b)
    }

    /// The middle of an edge, where it is in the mesh.
    pub(crate) fn shown_middle(&self, a: u32, b: u32) -> Option<u32> {
        self.middle(a, b).filter(|m| m.is_there).map(|m| m.name)
    }

    /// How a quad is cut.
    pub(crate) fn cut(&self, node: usize) -> Cut {
        let corners = &self.all[node].corners;
        Cut::new([0, 1, 2, 3].map(|k| self.shown_middle(corners[k], corners[(k + 1) % 4]).is_some()))
    }

    /// The numbers of a quad's corners, of the middles of its edges and of its own, as far as they are known, else [`NONE`].
    pub(crate) fn numbers(&self, node: usize) -> [u32; 9] {
        let corners = &self.all[node].corners;
        let mut all = [NONE; 9];
        all[..4].copy_from_slice(&corners[..4]);
        for k in 0..4 {
            all[4 + k] = self.middle(corners[k], corners[(k + 1) % 4]).map_or(NONE, |m| m.name);
        }
        all[8] = self.all[node].children.map_or(NONE, |(_, _, middle)| middle);
        all
    }

    /// Where numbered points are in a state; the origin where there is none.
    pub(crate) fn places(&self, state: usize, numbers: &[u32; 9]) -> [Point; 9] {
        let points = &self.points[state];
        numbers.map(|k| points.get(k as usize).copied().unwrap_or_default())
    }

    /// The faces that the surface consists of.
    pub(crate) fn shown(&self) -> impl Iterator<Item = usize> {
        (0..self.all.len()).filter(|&k| self.all[k].is_shown)
    }

    /// Puts the children of a face that was refined in its place.
    pub(crate) fn split(&mut self, node: usize, since: Since) {
        let Some((first, count, _)) = self.all[node].children else { return };
        self.all[node].is_shown = false;
        for child in &mut self.all[first as usize..(first + count) as usize] {
            (child.is_shown, child.since) = (true, since);
        }
        let corners = &self.all[node].corners;
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let (a, b) = (a.min(b), a.max(b));
            if let Some(middle) = self.middles[a as usize].iter_mut().find(|m| m.other == b) {
                middle.is_there = true;
            }
        }
    }
}
