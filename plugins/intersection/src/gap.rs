//! How near shapes come that do not meet.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Surface};

use crate::error::Result;
use crate::intersections::Options;
use crate::meeting::Pair;
use crate::net::{Frame, Piece, Range};
use crate::pair::setting;
use crate::pieces::{Below, Pieces};

/// So near to what can be no less a distance is the least.
const ENOUGH: f64 = 1e-4;
/// The most pairs of parts that are looked at.
const PAIRS: usize = 4_000;

/// The least distance between two shapes, as far as it was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The distance of the nearest places that were found.
    pub distance: f64,
    /// The first shape's point there.
    pub point: Point,
    /// Whether it was shown that no places are nearer by more than a part of 1e-4.
    pub least: bool,
}

/// How near two curves come: the pairs of their pieces are looked at in the order of the distances of their boxes, and halved until nothing left can be nearer
/// than what is found. At most 4,000 pairs are looked at.
///
/// # Errors
/// When the shapes are too large for numbers.
pub fn gap_of_curves(a: &Curve, b: &Curve) -> Result<Option<Gap>> {
    let (frame, _) = setting(&[a.hull_bounds(), b.hull_bounds()], &Options::default())?;
    Ok(gap(&Pieces::of_curve(a, &frame)?, &Pieces::of_curve(b, &frame)?, &frame))
}

/// How near a curve and a surface come: as [`gap_of_curves`].
///
/// # Errors
/// As for [`gap_of_curves`].
pub fn gap_of_curve_and_surface(a: &Curve, b: &Surface) -> Result<Option<Gap>> {
    let (frame, _) = setting(&[a.hull_bounds(), b.hull_bounds()], &Options::default())?;
    Ok(gap(&Pieces::of_curve(a, &frame)?, &Pieces::of_surface(b, &frame)?, &frame))
}

enum Open {
    /// Nodes of both trees.
    Nodes(usize, usize),
    Parts(Box<(Piece, Piece)>),
}

/// What is left to look at, the nearest first, and of those as near that which came first.
#[derive(Default)]
struct Queue {
    order: BinaryHeap<Reverse<(u64, usize)>>,
    all: Vec<Option<Open>>,
}

impl Queue {
    fn push(&mut self, bounds: [&[Range; 3]; 2], open: Open) {
        let [a, b] = bounds;
        let square: f64 =
            (0..3).map(|k| (a[k].low - b[k].high).max(b[k].low - a[k].high).max(0.0).powi(2)).sum();
        // Numbers that are not negative are ordered as their bits are.
        self.order.push(Reverse((square.sqrt().to_bits(), self.all.len())));
        self.all.push(Some(open));
    }

    fn pop(&mut self) -> Option<(f64, Open)> {
        let Reverse((bound, number)) = self.order.pop()?;
        Some((f64::from_bits(bound), self.all.get_mut(number)?.take()?))
    }
}

fn gap(a: &Pieces, b: &Pieces, frame: &Frame) -> Option<Gap> {
    let mut queue = Queue::default();
    let (first, second) = (a.nodes.len().checked_sub(1)?, b.nodes.len().checked_sub(1)?);
    queue.push([&a.nodes[first].bounds, &b.nodes[second].bounds], Open::Nodes(first, second));
    let mut best: Option<Gap> = None;
    let (mut looked, mut least) = (0, true);
    while let Some((bound, open)) = queue.pop() {
        if best.is_some_and(|best| bound >= best.distance * (1.0 - ENOUGH)) {
            break;
        }
        let (p, q) = match open {
            Open::Nodes(x, y) => {
                let (under, over) = (&a.nodes[x], &b.nodes[y]);
                let pairs: Vec<(usize, usize)> = match (under.below, over.below) {
                    (Below::Piece(i), Below::Piece(j)) => {
                        let parts = Open::Parts(Box::new((a.pieces[i].clone(), b.pieces[j].clone())));
                        queue.push([&under.bounds, &over.bounds], parts);
                        continue;
                    }
                    (Below::Nodes(i, j), Below::Piece(_)) => vec![(i, y), (j, y)],
                    (Below::Piece(_), Below::Nodes(i, j)) => vec![(x, i), (x, j)],
                    (Below::Nodes(i, j), Below::Nodes(k, l)) => vec![(i, k), (i, l), (j, k), (j, l)],
                };
                for (x, y) in pairs {
                    queue.push([&a.nodes[x].bounds, &b.nodes[y].bounds], Open::Nodes(x, y));
                }
                continue;
            }
            Open::Parts(parts) => *parts,
        };
        looked += 1;
        if looked > PAIRS {
            least = false;
            break;
        }
        let pair = Pair { a: &p, b: &q };
        let spot = pair.nearest([0.5; 3], 0);
        if best.is_none_or(|best| spot.distance < best.distance) {
            let point = Point::from(p.jet([spot.at[0], 0.0]).point);
            best = Some(Gap { distance: spot.distance, point, least: true });
        }
        let lengths = [p.run(0), q.run(0), if q.parameters() == 2 { q.run(1) } else { 0.0 }];
        let splits = [p.splits(0), q.splits(0), q.parameters() == 2 && q.splits(1)];
        let widest = (0..3).filter(|&k| splits[k]).max_by(|&x, &y| lengths[x].total_cmp(&lengths[y]));
        match widest {
            Some(0) => {
                for half in p.halves(0) {
                    queue.push([&half.bounds(), &q.bounds()], Open::Parts(Box::new((half, q.clone()))));
                }
            }
            Some(k) => {
                for half in q.halves(k - 1) {
                    queue.push([&p.bounds(), &half.bounds()], Open::Parts(Box::new((p.clone(), half))));
                }
            }
            None => {}
        }
    }
    best.map(|best| Gap {
        distance: best.distance * frame.size,
        point: frame.center + best.point.coords * frame.size,
        least,
    })
}
