//! What the cells of a surface leave out round extraordinary points, bounded.

use std::borrow::Cow;
use std::collections::BTreeMap;

use loftsman_kernel::Vector;

use super::node::Node;
use super::{DooSabinSurface, kind};
use crate::LeftOut;
use crate::error::{Result, SubdivisionError};
use crate::surface::left_out::{Exact, Left, Sum};
use crate::surface::net::largest;
use crate::uniform::quadratic;

/// Levels that are looked at with the points as they are.
const OWN: u32 = 4;
/// Levels after which what is left is compared with what it was.
const APART: u32 = 6;
/// Rings of more vertices are compared with one row, and not each with each.
const LARGE: usize = 64;

/// The rows of a neighbourhood over its own vertices.
type Rows = Node<Vec<f64>>;

impl DooSabinSurface {
    /// Bounds of what the [cells](loftsman_kernel::shape::Cells) leave out, and with them all integrals over the surface.
    ///
    /// A quadrant at an extraordinary point is three biquadratic pieces and a smaller one, and so on. The area of a piece is at most the
    /// product of the longest differences of its net along `u` and `v`, which bound its derivatives. Four levels are summed like this; the
    /// rest is at most `a d² / (1 - γ²)`: of a neighbourhood with diameter `d` the rows of six further levels bound the area by `a d²`, and
    /// the diameter of what then remains by `γ d` (half the sum of the sizes of the difference of any two rows). So nothing is estimated;
    /// the bound is some times what is left out. Volumes have cones instead, with the extraordinary point as their apex, and are off by what the
    /// quadrants have from that point: the four levels exactly, the rest at most a third of its area times the largest distance, as for
    /// [`SubdivisionSurface::left_out`](crate::SubdivisionSurface::left_out). Cost: some 20 µs a quadrant that is left out.
    ///
    /// # Errors
    /// When the mesh is too large to be refined once.
    pub fn left_out(&self) -> Result<LeftOut> {
        let (mut sum, mut known, exact) = (Sum::default(), BTreeMap::new(), Exact::new(quadratic, 3));
        for (node, &half) in self.nodes()?.into_iter().zip(&self.layout.corners) {
            let kind = kind(&self.cage, half);
            for corner in [0, 2].into_iter().filter(|corner| kind & [1, 0, 2][*corner] != 0) {
                let mut node = node.clone();
                let apex = node.corner(corner).0;
                node.rings.iter_mut().flatten().for_each(|p| *p -= apex);
                for _ in 0..self.depth {
                    node = node.quarter_at(corner);
                }
                sum.add(left(node, corner, &mut known, &exact)?);
            }
        }
        Ok(sum.left_out())
    }
}

/// What there is over a quadrant, one corner of which is extraordinary, with points given from the limit there. `known`: by how much of its squared diameter it is bounded, by the
/// vertices round the point where these are all there is to it.
fn left(
    mut node: Node<Vector>,
    corner: usize,
    known: &mut BTreeMap<usize, f64>,
    exact: &Exact<3>,
) -> Result<Left> {
    let mut left = Left::default();
    for _ in 0..OWN {
        let quarters = node.quarters();
        for piece in beside(&quarters, corner) {
            let net = piece.net();
            let [u, v] = longest(|a, b| (*net[a] - *net[b]).norm());
            left.area += u * v;
            left.volume += exact.volume(&net.map(Cow::into_owned));
        }
        node = quarters[corner].clone();
    }
    let share = match known.get(&node.rings[corner].len()).filter(|_| node.rules.is_none()) {
        Some(share) => *share,
        None => {
            let share = share(&node, corner)?;
            known.insert(node.rings[corner].len(), share);
            share
        }
    };
    let all: Vec<Vector> = node.rings.iter().flatten().copied().collect();
    left.end(share, &all);
    Ok(left)
}

/// The three quarters that are pieces.
fn beside<T>(quarters: &[Node<T>; 4], corner: usize) -> impl Iterator<Item = &Node<T>> {
    (1..4).map(move |k| &quarters[(corner + k) % 4])
}

/// The longest differences of a net of 3 × 3 along `u` and `v`, by what two of its vertices differ.
fn longest(apart: impl Fn(usize, usize) -> f64) -> [f64; 2] {
    let along = |at: fn(usize, usize) -> usize| {
        let pairs = (0..2).flat_map(|i| (0..3).map(move |j| (at(i + 1, j), at(i, j))));
        largest(pairs.map(|(a, b)| apart(a, b)))
    };
    [along(|i, j| 3 * i + j), along(|i, j| 3 * j + i)]
}

/// By how much of its squared diameter the area over a quadrant with such surroundings is bounded, whatever its points are.
fn share(like: &Node<Vector>, corner: usize) -> Result<f64> {
    let mut node = identity(like, corner);
    let mut area = 0.0;
    for _ in 0..APART {
        let quarters = node.quarters();
        for piece in beside(&quarters, corner) {
            let net = piece.net();
            let [u, v] = longest(|a, b| 0.5 * apart(&net[a], &net[b]));
            area += u * v;
        }
        node = quarters[corner].clone();
    }
    let shrinks = spread(&node);
    if shrinks >= 1.0 {
        let problem =
            "has surroundings that do not grow smaller where they are refined: its area cannot be bounded"
                .to_owned();
        return Err(SubdivisionError::Face { face: 0, problem });
    }
    Ok(area / (1.0 - shrinks * shrinks))
}

/// A quadrant with the same surroundings as rows over the vertices round it: those of the face at the extraordinary corner, and five more.
fn identity(like: &Node<Vector>, corner: usize) -> Rows {
    let n = like.rings[corner].len();
    let row = |k: usize| -> Vec<f64> { (0..n + 5).map(|i| if i == k { 1.0 } else { 0.0 }).collect() };
    let [before, beyond, across, over, after] = [0, 1, 2, 3, 4].map(|k| n + k);
    let rings = [
        (0..n).collect(),
        vec![0, n - 1, before, beyond],
        vec![0, beyond, across, over],
        vec![0, over, after, 1],
    ];
    let mut rings = rings.map(|ring: Vec<usize>| ring.into_iter().map(row).collect());
    rings.rotate_right(corner);
    Node { rings, rules: like.rules.clone() }
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum()
}

/// By how much the diameter of the points of a neighbourhood is less than that of those that its rows are over, at least: points
/// `Σ a_i P_i` and `Σ b_i P_i` are no further apart than half of `Σ |a_i - b_i|` times the diameter, for both sum to one.
fn spread(node: &Rows) -> f64 {
    let all: Vec<&Vec<f64>> = node.rings.iter().flatten().collect();
    if all.len() > LARGE {
        return largest(all.iter().map(|row| apart(row, all[0])));
    }
    let pairs = all.iter().enumerate().flat_map(|(k, a)| all[..k].iter().map(move |b| 0.5 * apart(a, b)));
    largest(pairs)
}
