//! What the cells of a surface leave out.

use super::Location;

/// A part of a surface that its [cells](super::Cells) leave out, for there it has infinitely many: beside a place that is the corner of none.
///
/// Its border in the parameter plane of its face is a chain of straight pieces, counterclockwise round the part and away from the
/// [apex](Self::apex): it begins where the part's first side, which starts at the apex, meets the cells beyond it, and it ends where its last
/// side does. So with the cones from the point at the apex over the borders of all holes the cells make a surface without a gap: cones of
/// neighbours meet in a line from that point, and where one reaches further than its neighbour the rest of their common side is a part of its
/// border. At the end of the surface, or where the neighbour has no hole, all of the side is; such a cone is a sliver between the side and its
/// chord.
///
/// ```
/// use loftsman_kernel::shape::{Border, Hole};
///
/// let piece = |from, to| Border { from, to, degree: 3 };
/// let border = vec![piece([0.25, 0.0], [0.25, 0.25]), piece([0.25, 0.25], [0.0, 0.25])];
/// let hole = Hole { face: Some(7), apex: [0.0, 0.0], border };
/// assert_eq!(hole.size(), 0.0625);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Hole {
    /// The face that it is on, of a surface of many.
    pub face: Option<u32>,
    /// Where the cones have their apex, in the parameters of the face: the surface has a position there.
    pub apex: [f64; 2],
    /// The pieces of the border, each from where the last one ended.
    pub border: Vec<Border>,
}

/// A straight piece of the border of a [`Hole`], along which the surface is one polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Border {
    /// Where it starts.
    pub from: [f64; 2],
    /// Where it ends.
    pub to: [f64; 2],
    /// The degree along it.
    pub degree: usize,
}

impl Hole {
    /// The location at some parameters of its face.
    pub fn at(&self, [u, v]: [f64; 2]) -> Location {
        self.face.map_or(Location::Surface(u, v), |face| Location::Face(face, u, v))
    }

    /// The area of the parameters between its apex and its border. `O(n)`.
    pub fn size(&self) -> f64 {
        let [u, v] = self.apex;
        let area = |b: &Border| (b.from[0] - u) * (b.to[1] - v) - (b.from[1] - v) * (b.to[0] - u);
        self.border.iter().map(|border| 0.5 * area(border)).sum()
    }
}

impl Border {
    /// The parameters at a share of it: 0 at its start, 1 at its end.
    pub fn at(&self, share: f64) -> [f64; 2] {
        [0, 1].map(|k| self.from[k] + (self.to[k] - self.from[k]) * share)
    }
}
