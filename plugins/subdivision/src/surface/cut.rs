//! How a face of four corners is cut into triangles, so that there is no gap to neighbours that are refined further.

use loftsman_kernel::Point;
use smallvec::SmallVec;

use super::net::{self, Net};
use super::pattern::Quadrant;

/// The triangles of a face, in terms of its corners (0 to 3), the middles of the edges that follow them (4 to 7) and its middle (8).
pub(super) type Triples = SmallVec<[[u8; 3]; 8]>;

/// The middle of a face, as the number of a place.
pub(super) const CENTRE: u8 = 8;

/// The triangles of a quad between the diagonal from its first corner.
const HALVES: [[u8; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// Which edges of a face have their middle in the mesh, for that of a neighbour is refined: two triangles where none has, else a fan from
/// the face's own middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Cut {
    middles: [bool; 4],
}

impl Cut {
    pub(super) fn new(middles: [bool; 4]) -> Self {
        Self { middles }
    }

    /// Whether it is a fan.
    pub(super) fn is_fan(self) -> bool {
        self.middles.contains(&true)
    }

    /// All triangles, counterclockwise.
    pub(super) fn triangles(self) -> Triples {
        if !self.is_fan() {
            return HALVES.into_iter().collect();
        }
        let sides = (0..4_u8).flat_map(|k| {
            let next = (k + 1) % 4;
            let parts: SmallVec<[[u8; 3]; 2]> = if self.middles[usize::from(k)] {
                [[k, 4 + k, CENTRE], [4 + k, next, CENTRE]].into_iter().collect()
            } else {
                [[k, next, CENTRE]].into_iter().collect()
            };
            parts
        });
        sides.collect()
    }

    /// The triangle of a fan on the half of an edge (from corner `edge`) that is at a corner.
    fn side(self, edge: usize, corner: usize) -> [u8; 3] {
        let (edge, next) = (edge as u8, (edge as u8 + 1) % 4);
        match (self.middles[usize::from(edge)], usize::from(edge) == corner) {
            (false, _) => [edge, next, CENTRE],
            (true, true) => [edge, 4 + edge, CENTRE],
            (true, false) => [4 + edge, next, CENTRE],
        }
    }

    /// The triangles that the two halves of a quadrant are to be near, and how the quadrant is turned so that these are the halves below and
    /// above its diagonal; `None` for the whole of a face that is a fan.
    fn targets(self, quadrant: Quadrant) -> Option<(usize, [[u8; 3]; 2])> {
        let Quadrant { level, i, j } = quadrant;
        let (turn, [x, y], own) = if self.is_fan() {
            let half = 1_u64 << level.checked_sub(1)?.min(62);
            let corner = [[0, 3], [1, 2]][usize::from(i >= half)][usize::from(j >= half)];
            let (i, j) = (i % half, j % half);
            let (back_i, back_j) = (half - 1 - i, half - 1 - j);
            let place = [[i, j], [j, back_i], [back_i, back_j], [back_j, i]][corner];
            (corner, place, [self.side(corner, corner), self.side((corner + 3) % 4, corner)])
        } else {
            (0, [i, j], HALVES)
        };
        Some((
            turn,
            match x.cmp(&y) {
                std::cmp::Ordering::Greater => [own[0]; 2],
                std::cmp::Ordering::Less => [own[1]; 2],
                std::cmp::Ordering::Equal => own,
            },
        ))
    }

    /// A bound of the distance that the part of the surface over a quadrant, given by its Bézier points, has from the triangles that it
    /// belongs to. `at` are the face's corners and middles.
    pub(super) fn beyond(self, patch: &Net, quadrant: Quadrant, at: &[Point; 9], enough: f64) -> f64 {
        let Some((turn, targets)) = self.targets(quadrant) else {
            let parts = quadrant.parts().into_iter().enumerate().map(|(corner, part)| {
                let [u, v] = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]][corner];
                self.beyond(&net::cut(patch, [u, u + 0.5], [v, v + 0.5]), part, at, enough)
            });
            return net::largest(parts);
        };
        let [below, above] = targets.map(|t| t.map(|k| at[usize::from(k)]));
        net::beyond(&net::turned(patch, turn), [&below, &above], enough)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every part of a flat face lies on the triangles that it is said to belong to, however it is cut, and all of the face is covered once.
    #[test]
    fn parts_lie_on_their_triangles() {
        let place = |k: u8| -> Point {
            let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let [x, y] = match k {
                0..=3 => corner[usize::from(k)],
                CENTRE => [0.5, 0.5],
                _ => {
                    let [a, b] = [corner[usize::from(k - 4)], corner[usize::from(k - 3) % 4]];
                    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
                }
            };
            Point::new(x, y, 0.0)
        };
        let at: [Point; 9] = std::array::from_fn(|k| place(k as u8));
        for mask in 0..16_u8 {
            let cut = Cut::new([0, 1, 2, 3].map(|k| mask >> k & 1 == 1));
            let area = |t: &[u8; 3]| {
                let [a, b, c] = t.map(|k| at[usize::from(k)]);
                0.5 * (b - a).cross(&(c - a)).z
            };
            let areas: Vec<f64> = cut.triangles().iter().map(area).collect();
            assert!(areas.iter().all(|a| *a > 0.0) && (areas.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            for level in 0..4_u32 {
                let count = 1_u64 << level;
                for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                    let net: Net = std::array::from_fn(|k| {
                        let [x, y] = [(k / 4, i), (k % 4, j)]
                            .map(|(k, at)| (at as f64 + k as f64 / 3.0) / count as f64);
                        loftsman_kernel::Vector::new(x, y, 0.0)
                    });
                    let off = cut.beyond(&net, Quadrant { level, i, j }, &at, 1.0);
                    assert!(off < 1e-12, "{mask} {level} {i} {j}: {off:e}");
                }
            }
        }
    }
}
