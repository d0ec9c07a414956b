//! A surface that is no tensor-product spline, to test with.

use std::ops::Range;

use smallvec::{SmallVec, smallvec};

use crate::error::{Error, Result};
use crate::shape::{
    BoundaryEdge, Cell, CellNet, CellSide, Cells, Derivative, Domain, Edges, Interval, Location, Neighbours,
    Shape, Side, Sides, Stencil,
};
use crate::{Point, Vector};

/// Three biquadratic Bézier patches over `[0, 2] × [0, 1]`: one on the left half, two on the right, above one another. Where the
/// one meets the two, the edge of the one is subdivided, so that the surface has no gap; the control vertices in the middle of
/// that edge are therefore none of its own. It is continuous, and no grid, and says all that a shape can say but how to be
/// refined: what works on it asks for no more than the interface has.
///
/// Its 19 control vertices are those of the left patch, nine, row after row along `u`; then for each of the two rows to the
/// right of the common edge five along `v`.
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    points: Vec<Point>,
}

/// The patches: intervals of `u` and of `v`.
const BOXES: [[(f64, f64); 2]; 3] =
    [[(0.0, 1.0), (0.0, 1.0)], [(1.0, 2.0), (0.0, 0.5)], [(1.0, 2.0), (0.5, 1.0)]];

/// The common edge of the left patch in terms of itself as the two on the right have it: three rows for the lower, three for the
/// upper one.
const HANGING: [[[f64; 3]; 3]; 2] = [
    [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.25, 0.5, 0.25]],
    [[0.25, 0.5, 0.25], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]],
];

impl Patches {
    /// The surface `(x, y, z)(u, v)`, given by its blossom: the value of a biquadratic polynomial at two arguments in `u` and two
    /// in `v` (for `u v` the product of the means of both).
    pub fn of_blossom(blossom: impl Fn([f64; 2], [f64; 2]) -> Point) -> Self {
        let pair = |(a, b): (f64, f64), k: usize| [[a, a], [a, b], [b, b]][k];
        let left = (0..9).map(|at| blossom(pair((0.0, 1.0), at / 3), pair((0.0, 1.0), at % 3)));
        let right = (0..10).map(|at| {
            let v = if at % 5 < 3 { pair((0.0, 0.5), at % 5) } else { pair((0.5, 1.0), at % 5 - 2) };
            blossom(pair((1.0, 2.0), at / 5 + 1), v)
        });
        Self { points: left.chain(right).collect() }
    }

    /// The flat one, `(u, v, 0)`.
    pub fn flat() -> Self {
        Self::of_blossom(|u, v| Point::new(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]), 0.0))
    }

    /// The patch that a place is in, from a side in each parameter.
    fn patch(u: f64, v: f64, sides: Sides) -> usize {
        let beyond = |x: f64, at: f64, side: Side| x > at || x == at && side == Side::Right;
        if !beyond(u, 1.0, sides.u) { 0 } else { 1 + usize::from(beyond(v, 0.5, sides.v)) }
    }

    /// Control vertex `(i, j)` of a patch in terms of the surface's own.
    fn vertex(patch: usize, i: usize, j: usize) -> SmallVec<[(usize, f64); 3]> {
        match (patch, i) {
            (0, _) => smallvec![(3 * i + j, 1.0)],
            (_, 0) => (0..3).map(|k| (6 + k, HANGING[patch - 1][j][k])).collect(),
            _ => smallvec![(9 + 5 * (i - 1) + 2 * (patch - 1) + j, 1.0)],
        }
    }
}

/// The quadratic Bernstein functions' derivative of an order on an interval.
fn bernstein(t: f64, (a, b): (f64, f64), order: usize) -> [f64; 3] {
    let (h, x) = (b - a, (t - a) / (b - a));
    let y = 1.0 - x;
    match order {
        0 => [y * y, 2.0 * x * y, x * x],
        1 => [-2.0 * y / h, 2.0 * (y - x) / h, 2.0 * x / h],
        2 => [2.0 / (h * h), -4.0 / (h * h), 2.0 / (h * h)],
        _ => [0.0; 3],
    }
}

impl Shape for Patches {
    fn control_vertices(&self) -> &[Point] {
        &self.points
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.points
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.stencil_on(at, derivative, Sides::default())
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        let (u, v) = at.on_surface()?;
        for (value, end) in [(u, 2.0), (v, 1.0)] {
            if !(0.0..=end).contains(&value) {
                return Err(Error::Outside { value, start: 0.0, end });
            }
        }
        let patch = Self::patch(u, v, sides);
        let [us, vs] = BOXES[patch];
        let (along, across) = (bernstein(u, us, derivative.u), bernstein(v, vs, derivative.v));
        let mut stencil = Stencil::new();
        for (i, a) in along.iter().enumerate() {
            for (j, b) in across.iter().enumerate() {
                Self::vertex(patch, i, j).into_iter().for_each(|(vertex, c)| stencil.add(vertex, a * b * c));
            }
        }
        Ok(stencil)
    }

    fn domain(&self) -> Domain {
        let side = |end: f64| Interval { start: 0.0, end, periodic: false };
        smallvec![side(2.0), side(1.0)]
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn edges(&self) -> Option<&dyn Edges> {
        Some(self)
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        Some(self)
    }
}

impl Cells for Patches {
    fn count(&self) -> usize {
        BOXES.len()
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let sides =
            BOXES.get(index)?.iter().map(|&(start, end)| CellSide { start, end, degree: 2 }).collect();
        let all = (0..9).flat_map(|at| Self::vertex(index, at / 3, at % 3)).filter(|(_, c)| *c != 0.0);
        let mut vertices: SmallVec<[usize; 16]> = all.map(|(vertex, _)| vertex).collect();
        vertices.sort_unstable();
        vertices.dedup();
        Some(Cell { face: None, sides, rational: false, vertices })
    }

    fn nets(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Option<Result<()>> {
        for number in numbers.start..numbers.end.min(BOXES.len()) {
            let sides = BOXES[number].map(|(start, end)| CellSide { start, end, degree: 2 });
            let point = |(vertex, c): (usize, f64)| (self.points[vertex] - origin) * c;
            let sum = |at: usize| Self::vertex(number, at / 3, at % 3).into_iter().map(point).sum::<Vector>();
            let points: [Vector; 9] = std::array::from_fn(sum);
            each(CellNet { number, face: None, sides, points: &points });
        }
        Some(Ok(()))
    }
}

impl Edges for Patches {
    fn count(&self) -> usize {
        4
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        let (name, along_u, fixed, at_end) = [
            ("u0", false, 0.0, false),
            ("u1", false, 2.0, true),
            ("v0", true, 0.0, false),
            ("v1", true, 1.0, true),
        ]
        .get(index)
        .copied()?;
        let end = if along_u { 2.0 } else { 1.0 };
        Some(BoundaryEdge {
            name: name.into(),
            face: None,
            along_u,
            start: 0.0,
            end,
            periodic: false,
            fixed,
            at_end,
        })
    }
}

impl Neighbours for Patches {
    /// Along the edges of the patches' nets; across the common edge those with a part in one another's patch edge.
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let mut all = SmallVec::new();
        let mut link = |a: &[(usize, f64)], b: &[(usize, f64)]| {
            for (&(a, x), &(b, y)) in a.iter().flat_map(|a| b.iter().map(move |b| (a, b))) {
                if x != 0.0 && y != 0.0 && a != b && (a == vertex || b == vertex) {
                    all.push(a + b - vertex);
                }
            }
        };
        for patch in 0..BOXES.len() {
            let at = |i: usize, j: usize| Self::vertex(patch, i, j);
            for (i, j) in (0..3).flat_map(|i| (0..2).map(move |j| (i, j))) {
                link(&at(i, j), &at(i, j + 1));
                link(&at(j, i), &at(j + 1, i));
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }
}
