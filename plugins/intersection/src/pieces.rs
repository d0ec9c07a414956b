//! The Bézier pieces of a shape, and the tree of their boxes.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Surface};

use crate::error::Result;
use crate::net::{Four, Frame, Piece, Range};

/// The pieces of a shape in a frame, and a balanced tree of boxes over them.
#[derive(Debug)]
pub(crate) struct Pieces {
    pub(crate) pieces: Vec<Piece>,
    pub(crate) nodes: Vec<Node>,
}

#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) bounds: [Range; 3],
    /// Two nodes, or one piece.
    pub(crate) below: Below,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Below {
    Nodes(usize, usize),
    Piece(usize),
}

fn net(points: &[Point], weights: Option<&[f64]>, frame: &Frame) -> Vec<Four> {
    // The largest weight is 1: no product overflows.
    let largest = weights.map_or(1.0, |w| w.iter().copied().fold(0.0, f64::max));
    let weight = |i: usize| weights.map_or(1.0, |w| (w[i] / largest).max(1e-150));
    points.iter().enumerate().map(|(i, p)| frame.homogeneous(p, weight(i))).collect()
}

impl Pieces {
    pub(crate) fn of_curve(curve: &Curve, frame: &Frame) -> Result<Self> {
        let pieces = curve.bezier_segments()?.into_iter().map(|s| {
            let (a, b) = s.domain();
            Piece {
                low: [a, 0.0],
                high: [b, 0.0],
                orders: [s.degree() + 1, 1],
                net: net(s.points(), s.weights(), frame),
            }
        });
        Ok(Self::new(pieces.collect()))
    }

    pub(crate) fn of_surface(surface: &Surface, frame: &Frame) -> Result<Self> {
        let pieces = surface.bezier_patches()?.into_iter().map(|s| {
            let ((a, b), (c, d)) = (s.u().domain(), s.v().domain());
            Piece {
                low: [a, c],
                high: [b, d],
                orders: [s.u().degree() + 1, s.v().degree() + 1],
                net: net(s.points(), s.weights(), frame),
            }
        });
        Ok(Self::new(pieces.collect()))
    }

    pub(crate) fn new(pieces: Vec<Piece>) -> Self {
        let bounds: Vec<[Range; 3]> = pieces.iter().map(Piece::bounds).collect();
        let mut nodes = Vec::with_capacity(2 * pieces.len());
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        build(&mut nodes, &bounds, &mut order);
        Self { pieces, nodes }
    }

    /// The pairs of pieces whose boxes are within `gap` of one another, in order. Both trees are walked together.
    pub(crate) fn near(&self, other: &Self, gap: f64) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        let mut open = vec![(self.nodes.len() - 1, other.nodes.len() - 1)];
        while let Some((a, b)) = open.pop() {
            let (na, nb) = (&self.nodes[a], &other.nodes[b]);
            if apart(&na.bounds, &nb.bounds) > gap {
                continue;
            }
            match (na.below, nb.below) {
                (Below::Piece(i), Below::Piece(j)) => found.push((i, j)),
                (Below::Nodes(x, y), Below::Piece(_)) => open.extend([(x, b), (y, b)]),
                (Below::Piece(_), Below::Nodes(x, y)) => open.extend([(a, x), (a, y)]),
                (Below::Nodes(x, y), Below::Nodes(z, w)) => {
                    if spread(&na.bounds) >= spread(&nb.bounds) {
                        open.extend([(x, b), (y, b)]);
                    } else {
                        open.extend([(a, z), (a, w)]);
                    }
                }
            }
        }
        found.sort_unstable();
        found
    }
}

/// Appends the tree of these pieces; its root is the last node.
fn build(nodes: &mut Vec<Node>, bounds: &[[Range; 3]], order: &mut [usize]) {
    let mut around = [Range::EMPTY; 3];
    for &i in order.iter() {
        for k in 0..3 {
            around[k].add(bounds[i][k].low);
            around[k].add(bounds[i][k].high);
        }
    }
    if let [only] = *order {
        nodes.push(Node { bounds: around, below: Below::Piece(only) });
        return;
    }
    let axis = (0..3)
        .max_by(|&a, &b| (around[a].high - around[a].low).total_cmp(&(around[b].high - around[b].low)))
        .unwrap_or(0);
    let middle = order.len() / 2;
    let key = |i: usize| bounds[i][axis].low + bounds[i][axis].high;
    order.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    let (left, right) = order.split_at_mut(middle);
    build(nodes, bounds, left);
    let first = nodes.len() - 1;
    build(nodes, bounds, right);
    let second = nodes.len() - 1;
    nodes.push(Node { bounds: around, below: Below::Nodes(first, second) });
}

/// The largest gap between two boxes along an axis; negative where they overlap.
pub(crate) fn apart(a: &[Range; 3], b: &[Range; 3]) -> f64 {
    (0..3).map(|k| (a[k].low - b[k].high).max(b[k].low - a[k].high)).fold(f64::NEG_INFINITY, f64::max)
}

fn spread(bounds: &[Range; 3]) -> f64 {
    bounds.iter().map(|r| r.high - r.low).sum()
}
