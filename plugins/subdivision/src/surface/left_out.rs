//! What the cells of a surface leave out round extraordinary vertices, bounded.

use std::collections::BTreeMap;

use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};

use super::local::Local;
use super::net::{hull_of, largest, net_of, slopes};
use super::pattern::{Pattern, Quadrant};
use super::template::{Near, Piece};
use super::{SubdivisionSurface, leaf};
use crate::cage::Cage;
use crate::error::{Result, SubdivisionError};

/// Bounds of what the cells of a surface leave out: quadrants of the last level round extraordinary vertices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeftOut {
    /// How many quadrants are left out.
    pub count: usize,
    /// An upper bound of their area: that of the cells is less than the surface's by no more than this.
    pub area: f64,
    /// An upper bound of what volumes are off by: that of the cells with the cones over the [holes](loftsman_kernel::shape::Cells::holes) differs
    /// from what is inside a closed surface by no more than this, wherever the origin is.
    pub volume: f64,
}

/// Levels that are looked at with the points as they are.
const OWN: u32 = 4;
/// Levels after which what is left is compared with what it was.
const APART: u32 = 6;

/// By how much of its squared diameter the area over a quadrant with like surroundings is bounded.
type Known = BTreeMap<Vec<u32>, f64>;

impl SubdivisionSurface {
    /// Bounds of what the [cells](loftsman_kernel::shape::Cells) leave out, and with them all integrals over the surface.
    ///
    /// A quadrant with an extraordinary vertex is three bicubic pieces and a smaller one, and so on. The area of a piece is at most the
    /// product of the longest differences of its net along `u` and `v`, which bound its derivatives. Four levels are summed like this; the
    /// rest is at most `a d² / (1 - γ²)`: of a neighbourhood with diameter `d` the rows of six further levels bound the area by `a d²`, and
    /// the diameter of what then remains by `γ d` (half the sum of the sizes of the difference of any two rows). So nothing is estimated;
    /// the bound is some times what is left out.
    ///
    /// Instead of the quadrants at a vertex volumes have the cones over the cells round them, with the limit `c` of the vertex as their apex. With
    /// `c` as origin, which is free where these and the quadrants together bound something, a cone has no volume
    /// `⅓ ∫∫ (S - c)·(S_u × S_v)`, and a quadrant at most a third of its area times the largest distance that a vertex of its neighbourhood has from
    /// `c`. Cost: some 20 µs a quadrant that is left out, and its limit.
    ///
    /// # Errors
    /// When a face has more than 2048 vertices in the faces round it.
    pub fn left_out(&self) -> Result<LeftOut> {
        let mut sum = LeftOut::default();
        let (mut known, mut kinds) = (Known::new(), BTreeMap::new());
        for face in 0..self.layout.faces.len() {
            let pattern = self.layout.pattern_of[face] as usize;
            if self.layout.left[pattern].is_empty() {
                continue;
            }
            let near = leaf::near(&self.cage, &self.layout, face)?;
            if !kinds.contains_key(near.key()) {
                let local = |&quadrant| self.layout.templates.local(&self.cage, &near, quadrant);
                let all = self.layout.left[pattern].iter().map(local).collect::<Result<Vec<_>>>()?;
                kinds.insert(near.key().to_vec(), all);
            }
            for (local, quadrant) in
                kinds.get(near.key()).into_iter().flatten().zip(&self.layout.left[pattern])
            {
                let apex = self.limit_at(face, *quadrant)?;
                let ring = hull_of(local, |k| self.cage.points()[near.base[k] as usize] - apex);
                let far = largest(ring.iter().map(Vector::norm));
                let area = self.area_left(local, &ring, &mut known)?;
                sum.count += 1;
                sum.area += area;
                sum.volume += far * area / 3.0;
            }
        }
        Ok(sum)
    }

    /// The limit of the corner of a face that a quadrant is at.
    fn limit_at(&self, face: usize, quadrant: Quadrant) -> Result<Point> {
        let end = |k: u64| if k == 0 { 0.0 } else { 1.0 };
        let at = Location::Face(face as u32, end(quadrant.i), end(quadrant.j));
        Ok(Point::from(self.value(at, Derivative::POSITION)?))
    }

    /// A bound of the area over the face of a neighbourhood, one corner of which is extraordinary.
    fn area_left(&self, local: &Local, ring: &[Vector], known: &mut Known) -> Result<f64> {
        let cage = local.cage();
        let corner = Pattern::of_quad(cage, 0).corners.iter().position(|c| c.extraordinary).unwrap_or(0);
        let near = Near::of_local(local, corner)?;
        let point = |k: usize| ring[near.base[k] as usize];
        let mut area = 0.0;
        for level in 1..=OWN {
            for piece in self.beside(cage, &near, level)? {
                let [u, v] = slopes(&net_of(&piece, point));
                area += u * v;
            }
        }
        let last = self.layout.templates.local(cage, &near, first_of(OWN))?;
        let rest = hull_of(&last, point);
        let share = match known.get(near.key()) {
            Some(share) => *share,
            None => {
                let share = self.share(&last)?;
                known.insert(near.key().to_vec(), share);
                share
            }
        };
        Ok(area + share * diameter_squared(&rest))
    }

    /// By how much of its squared diameter the area over the face of a neighbourhood is bounded, whatever its points are.
    fn share(&self, local: &Local) -> Result<f64> {
        let cage = local.cage();
        let near = Near::of_local(local, 0)?;
        let last = self.layout.templates.local(cage, &near, first_of(APART))?;
        let shrinks = spread(&last);
        if Near::of_local(&last, 0)?.key() != near.key() || shrinks >= 1.0 {
            let problem =
                "has surroundings that do not become alike where it is refined: its area cannot be bounded"
                    .to_owned();
            return Err(SubdivisionError::Face { face: 0, problem });
        }
        let mut area = 0.0;
        for level in 1..=APART {
            for piece in self.beside(cage, &near, level)? {
                let [u, v] = slopes_of_rows(&piece);
                area += u * v;
            }
        }
        Ok(area / (1.0 - shrinks * shrinks))
    }

    /// The three pieces of a level beside the quadrant of the first corner; of one that is none on this level its parts.
    fn beside(&self, cage: &Cage, near: &Near, level: u32) -> Result<Vec<std::sync::Arc<Piece>>> {
        let mut all = Vec::with_capacity(3);
        let mut rest: Vec<Quadrant> = first_of(level - 1).parts()[1..].to_vec();
        while let Some(quadrant) = rest.pop() {
            match self.layout.templates.piece(cage, near, quadrant)? {
                Some(piece) => all.push(piece),
                None if quadrant.level < level + 4 => rest.extend(quadrant.parts()),
                None => {
                    let problem =
                        "has surroundings that do not become regular where they are refined: its area cannot be bounded"
                            .to_owned();
                    return Err(SubdivisionError::Face { face: 0, problem });
                }
            }
        }
        Ok(all)
    }
}

/// The quadrant of a level at the first corner.
pub(crate) fn first_of(level: u32) -> Quadrant {
    Quadrant { level, i: 0, j: 0 }
}

pub(crate) fn diameter_squared(points: &[Vector]) -> f64 {
    let pairs =
        points.iter().enumerate().flat_map(|(k, a)| points[..k].iter().map(move |b| (a - b).norm_squared()));
    largest(pairs)
}

/// By how much the diameter of the points of a neighbourhood is less than that of those that its rows are over, at least: points
/// `Σ a_i P_i` and `Σ b_i P_i` are no further apart than half of `Σ |a_i - b_i|` times the diameter, for both sum to one.
fn spread(local: &Local) -> f64 {
    let count = local.cage().points().len();
    let mut most: f64 = 0.0;
    for a in 0..count {
        for b in 0..a {
            let apart = local.row(a).iter().zip(local.row(b)).map(|(a, b)| (a - b).abs()).sum::<f64>();
            most = most.max(0.5 * apart);
        }
    }
    most
}

/// Bounds of first derivatives, as shares of the diameter of the points that a piece's rows are over.
fn slopes_of_rows(piece: &Piece) -> [f64; 2] {
    let longest = |at: fn(usize, usize) -> usize| {
        let pairs = (0..3).flat_map(|i| (0..4).map(move |j| (at(i + 1, j), at(i, j))));
        pairs
            .map(|(a, b)| 0.5 * piece.columns.iter().map(|c| (c[a] - c[b]).abs()).sum::<f64>())
            .fold(0.0, f64::max)
    };
    [longest(|i, j| 4 * i + j), longest(|i, j| 4 * j + i)]
}
