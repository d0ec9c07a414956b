//! What the cells of a surface leave out round extraordinary vertices, bounded.

use std::collections::BTreeMap;

use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::{Point, Vector};

use super::SubdivisionSurface;
use super::ground::Ground;
use super::local::Local;
use super::net::{hull_of, largest, net_of, slopes};
use super::pattern::{Pattern, Quadrant};
use super::template::{Near, Piece};
use crate::cage::Cage;
use crate::error::{Result, SubdivisionError};
use crate::uniform::cubic;

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
const OWN: u32 = 6;
/// Levels after which what is left is compared with what it was.
const APART: u32 = 6;

/// What a quadrant has that is left out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Left {
    /// A bound of its area.
    pub(crate) area: f64,
    /// The volume `⅓ ∫∫ S·(S_u × S_v)` of its first levels, from its extraordinary point.
    pub(crate) volume: f64,
    /// A bound of the size of what the others have of it.
    rest: f64,
}

impl Left {
    /// With what remains in the hull of these points, whose area is bounded by a share of its squared diameter.
    pub(crate) fn end(&mut self, share: f64, hull: &[Vector]) {
        let area = share * diameter_squared(hull);
        self.area += area;
        self.rest += largest(hull.iter().map(Vector::norm)) * area / 3.0;
    }
}

/// What all quadrants have that are left out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    count: usize,
    all: Left,
}

impl Sum {
    pub(crate) fn add(&mut self, one: Left) {
        self.count += 1;
        self.all.area += one.area;
        self.all.volume += one.volume;
        self.all.rest += one.rest;
    }

    pub(crate) fn left_out(self) -> LeftOut {
        let Self { count, all: Left { area, volume, rest } } = self;
        LeftOut { count, area, volume: largest(std::iter::once(volume.abs() + rest)) }
    }
}

/// What volumes of pieces with uniform knots are taken by: as many Gauss points in each direction as are exact for their degree, `N - 1`.
pub(crate) struct Exact<const N: usize> {
    /// Of each point the values of the functions, their derivatives, and its weight.
    nodes: Vec<([[f64; N]; 2], f64)>,
}

impl<const N: usize> Exact<N> {
    pub(crate) fn new(basis: impl Fn(f64, usize) -> [f64; N], count: usize) -> Self {
        let (nodes, weights) = gauss_legendre(count);
        let both = nodes.iter().map(|&x| [basis(x, 0), basis(x, 1)]);
        Self { nodes: both.zip(weights).collect() }
    }

    /// The volume `⅓ ∫∫ S·(S_u × S_v)` of a piece.
    pub(crate) fn volume(&self, net: &[Vector]) -> f64 {
        let mut sum = 0.0;
        for (along_u, by_u) in &self.nodes {
            // Positions and derivatives by u of the vertices along v.
            let line = |row: &[f64; N]| -> [Vector; N] {
                std::array::from_fn(|j| (0..N).fold(Vector::zeros(), |sum, i| sum + net[N * i + j] * row[i]))
            };
            let [values, slopes] = [line(&along_u[0]), line(&along_u[1])];
            for (along_v, by_v) in &self.nodes {
                let at = |line: &[Vector; N], row: &[f64; N]| {
                    line.iter().zip(row).fold(Vector::zeros(), |sum, (p, c)| sum + p * *c)
                };
                let (point, su) = (at(&values, &along_v[0]), at(&slopes, &along_v[0]));
                sum += by_u * by_v * point.dot(&su.cross(&at(&values, &along_v[1])));
            }
        }
        sum / 3.0
    }
}

/// What all quadrants have in common.
struct Known {
    /// By how much of its squared diameter the area over a quadrant with like surroundings is bounded.
    shares: BTreeMap<Vec<u32>, f64>,
    exact: Exact<4>,
}

impl SubdivisionSurface {
    /// Bounds of what the [cells](loftsman_kernel::shape::Cells) leave out, and with them all integrals over the surface.
    ///
    /// A quadrant with an extraordinary vertex is three bicubic pieces and a smaller one, and so on. The area of a piece is at most the
    /// product of the longest differences of its net along `u` and `v`, which bound its derivatives. Six levels are summed like this; the
    /// rest is at most `a d² / (1 - γ²)`: of a neighbourhood with diameter `d` the rows of six further levels bound the area by `a d²`, and
    /// the diameter of what then remains by `γ d` (half the sum of the sizes of the difference of any two rows). So nothing is estimated;
    /// the bound is some times what is left out.
    ///
    /// Instead of the quadrants at a vertex volumes have the cones over the cells round them, with the limit `c` of the vertex as their apex. With
    /// `c` as origin, which is free where these and the quadrants together bound something, a cone has no volume
    /// `⅓ ∫∫ (S - c)·(S_u × S_v)`: what volumes are off by is that of the quadrants. The pieces of the six levels are integrated exactly; the rest
    /// has at most a third of its area times the largest distance that a vertex of its neighbourhood has from `c`. Cost: some tens of microseconds
    /// a quadrant that is left out, of which its limit is a part.
    ///
    /// # Errors
    /// When a face has more than 2048 vertices in the faces round it.
    pub fn left_out(&self) -> Result<LeftOut> {
        let mut sum = Sum::default();
        let (mut known, mut last) = (Known { shares: BTreeMap::new(), exact: Exact::new(cubic, 5) }, None);
        for (face, &[of, corner]) in self.layout.faces.iter().enumerate() {
            let left = &self.layout.left[self.layout.pattern_of[face] as usize];
            if left.is_empty() {
                continue;
            }
            let own = Ground::new(&self.cage, self.layout.pattern(face), of, corner, last.as_ref())?;
            for &quadrant in left {
                // What is left out is less than a face, so that it is in one of its parts.
                let Some((part, within)) = own.part(quadrant) else { continue };
                let local = self.layout.templates.local(own.cage(&self.cage), own.near(part), within)?;
                let apex = self.limit_at(face, quadrant)?;
                let points = own.points(|v| self.cage.points()[v as usize] - apex);
                let ring = hull_of(&local, |k| points.of(part)[k]);
                sum.add(self.left(&local, &ring, &mut known)?);
            }
            last = Some(own);
        }
        Ok(sum.left_out())
    }

    /// The limit of the corner of a face that a quadrant is at.
    fn limit_at(&self, face: usize, quadrant: Quadrant) -> Result<Point> {
        let end = |k: u64| if k == 0 { 0.0 } else { 1.0 };
        let at = Location::Face(face as u32, end(quadrant.i), end(quadrant.j));
        Ok(Point::from(self.value(at, Derivative::POSITION)?))
    }

    /// What there is over the face of a neighbourhood, one corner of which is extraordinary: its points are given from the limit there.
    fn left(&self, local: &Local, ring: &[Vector], known: &mut Known) -> Result<Left> {
        let cage = local.cage();
        let corner = Pattern::of_quad(cage, 0).corners.iter().position(|c| c.extraordinary).unwrap_or(0);
        let near = Near::of_local(local, corner)?;
        let point = |k: usize| ring[near.base[k] as usize];
        let mut left = Left::default();
        for level in 1..=OWN {
            for piece in self.beside(cage, &near, level)? {
                let net = net_of(&piece, point);
                let [u, v] = slopes(&net);
                left.area += u * v;
                left.volume += known.exact.volume(&net);
            }
        }
        let last = self.layout.templates.local(cage, &near, first_of(OWN))?;
        let rest = hull_of(&last, point);
        let share = match known.shares.get(near.key()) {
            Some(share) => *share,
            None => {
                let share = self.share(&last)?;
                known.shares.insert(near.key().to_vec(), share);
                share
            }
        };
        left.end(share, &rest);
        Ok(left)
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
