//! Regular quads put together to rectangles: one B-spline surface each.

use std::collections::BTreeSet;

use loftsman_kernel::Point;
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;

use super::net::place;
use crate::error::Result;

/// A quad of a rectangle, and the corner of it that is the rectangle's first.
type Placed = (usize, usize);

/// Quads of one level with the nets of the uniform B-splines over them.
pub(crate) struct Quads<'a> {
    /// The degree in each direction.
    pub(crate) degree: usize,
    /// Of each quad its net, `degree + 1` vertices a side and `u` after `u`, seen from its first corner; nothing where it has none.
    pub(crate) nets: Vec<Option<Box<[Point]>>>,
    /// The quad beyond a side, which goes from the corner of the same number to the next, and the number that the side has there.
    pub(crate) beyond: &'a dyn Fn(usize, usize) -> Option<(usize, usize)>,
    /// Whether two vertices of nets are one.
    pub(crate) same: &'a dyn Fn(&Point, &Point) -> bool,
}

impl Quads<'_> {
    /// The quads that have a net, each once, as the largest rectangles found by going right and then up from those furthest left and down.
    /// Neighbours belong to one rectangle where their nets are the same in all vertices that they share: so a crease, in which
    /// each side is mirrored, is never inside. Cost: linear.
    pub(crate) fn surfaces(mut self) -> Result<Vec<Surface>> {
        let mut all = Vec::new();
        for face in 0..self.nets.len() {
            // The rectangle that begins furthest left and down from a quad need not reach back to it.
            while self.nets[face].is_some() {
                let first = self.first((face, 0));
                let rows = self.rows(first);
                all.push(self.surface(&rows)?);
                rows.iter().flatten().for_each(|&(face, _)| self.nets[face] = None);
            }
        }
        Ok(all)
    }

    /// The neighbour beyond a side of a placed quad (0 below, 1 right, 2 above, 3 left), where one surface goes on.
    fn beyond(&self, (face, turn): Placed, side: usize) -> Option<Placed> {
        let (next, corner) = (self.beyond)(face, (turn + side) % 4)?;
        // Its own side `side + 2` is the one that is shared.
        let other = (next, (corner + 6 - side) % 4);
        let (own, its) = (self.net((face, turn))?, self.net(other)?);
        let width = self.degree as isize + 1;
        let (di, dj) = [(0, -1), (1, 0), (0, 1), (-1, 0)][side];
        let shared = (0..width * width).all(|k| {
            let (i, j) = (k / width + di, k % width + dj);
            let inside = (0..width).contains(&i) && (0..width).contains(&j);
            !inside || (self.same)(own((width * i + j) as usize), its(k as usize))
        });
        shared.then_some(other)
    }

    /// The vertices of a quad's net by their places in it as it is turned.
    fn net<'s>(&'s self, (face, turn): Placed) -> Option<impl Fn(usize) -> &'s Point> {
        let net = self.nets.get(face)?.as_ref()?;
        Some(move |k| &net[place(k, self.degree + 1, turn)])
    }

    /// As far left as there is a way, and then down.
    fn first(&self, from: Placed) -> Placed {
        let mut at = from;
        for side in [3, 0] {
            let start = at;
            for _ in 0..self.nets.len() {
                match self.beyond(at, side) {
                    Some(next) if next.0 != start.0 => at = next,
                    _ => break,
                }
            }
        }
        at
    }

    /// Rows of quads, each to the right of the one before, row above row.
    fn rows(&self, first: Placed) -> Vec<Vec<Placed>> {
        let mut used = BTreeSet::from([first.0]);
        let mut row = vec![first];
        while let Some(next) = self.beyond(row[row.len() - 1], 1).filter(|next| used.insert(next.0)) {
            row.push(next);
        }
        let mut rows = vec![row];
        while let Some(row) = self.above(&rows[rows.len() - 1]) {
            if !row.iter().all(|(face, _)| used.insert(*face)) {
                break;
            }
            rows.push(row);
        }
        rows
    }

    /// The row above one, where all of it is there and hangs together.
    fn above(&self, row: &[Placed]) -> Option<Vec<Placed>> {
        let above: Vec<Placed> = row.iter().map(|&quad| self.beyond(quad, 2)).collect::<Option<_>>()?;
        let mut faces: Vec<usize> = above.iter().map(|(face, _)| *face).collect();
        faces.sort_unstable();
        let distinct = faces.windows(2).all(|pair| pair[0] != pair[1]);
        (distinct && above.windows(2).all(|pair| self.beyond(pair[0], 1) == Some(pair[1]))).then_some(above)
    }

    /// The surface over a rectangle: uniform, one unit a quad.
    fn surface(&self, rows: &[Vec<Placed>]) -> Result<Surface> {
        let (width, height) = (rows.first().map_or(0, Vec::len), rows.len());
        let (degree, side) = (self.degree, self.degree + 1);
        let mut points = vec![Point::origin(); (width + degree) * (height + degree)];
        for (b, row) in rows.iter().enumerate() {
            for (a, &placed) in row.iter().enumerate() {
                let Some(net) = self.net(placed) else { continue };
                for k in 0..side * side {
                    points[(a + k / side) * (height + degree) + b + k % side] = *net(k);
                }
            }
        }
        let space = |quads: usize| Space::floating_uniform(degree, quads + degree);
        Ok(Surface::new(space(width)?, space(height)?, points)?)
    }
}
