//! What bounds a face, laid out in the plane of its surface's parameters.
//!
//! The plane is one period wide where the surface closes. Chords lie between two nodes of it; those of loops end wherever they come
//! to a seam or a crease (see [`cut`](super::cut)), so that all of them are whole, and nothing depends on which way a loop winds around
//! the surface. A node on a seam has a copy on the other side that is the same point of space. Seams, creases and the sides that are
//! a pole become stretches between the nodes on them.

mod lines;

use std::collections::{BTreeMap, BTreeSet};

use super::carrier::Carrier;
use super::cut::Goal;

/// Nodes of one point that are nearer than this part of the domain are one: they are feet of one point, found from two sides.
const SAME: f64 = 1e-3;

/// A place in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    pub(crate) at: [f64; 2],
    /// The number of its point: those of the whole first, then those of the face.
    pub(crate) point: u32,
}

/// A chord of a loop, before its nodes are known: points and places of its ends, in the direction of the loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    pub(crate) points: [u32; 2],
    pub(crate) ends: [[f64; 2]; 2],
    /// The edge, and the number of the chord in it.
    pub(crate) edge: usize,
    pub(crate) part: usize,
}

/// A chord of a loop, with what is inside to its left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Border {
    pub(crate) ends: [u32; 2],
    pub(crate) edge: usize,
    pub(crate) part: usize,
}

/// All that triangles must follow.
#[derive(Debug)]
pub(crate) struct Arranged {
    pub(crate) nodes: Vec<Node>,
    pub(crate) borders: Vec<Border>,
    /// Stretches of seams, creases and poles, and what else is to be followed.
    pub(crate) stretches: Vec<[u32; 2]>,
    /// Of the stretches of seams, those on the low side and what they are on the high side.
    pub(crate) seams: Vec<[[u32; 2]; 2]>,
    /// Stretches along a pole.
    pub(crate) poles: Vec<[u32; 2]>,
    /// The parameters of the points of the face's own, by their numbers after those of the whole.
    pub(crate) own: Vec<[f64; 2]>,
    /// How far the faces bend along stretches.
    pub(crate) beside: f64,
}

/// Two chords in each other's way: each an edge and a part of it.
pub(crate) type Clash = Vec<(usize, usize)>;

struct Builder<'c> {
    carrier: &'c Carrier,
    goal: &'c Goal,
    nodes: Vec<Node>,
    known: BTreeMap<[u64; 2], u32>,
    by_point: BTreeMap<u32, Vec<u32>>,
    own: Vec<[f64; 2]>,
    first_own: u32,
    canonical: BTreeMap<[u64; 2], u32>,
    pole_points: [[Option<u32>; 2]; 2],
}

fn key(at: [f64; 2]) -> [u64; 2] {
    // One zero, not two.
    at.map(|x| (x + 0.0).to_bits())
}

impl Builder<'_> {
    /// The node of a point at a place: one that is there already, where one of the point is near.
    fn node(&mut self, at: [f64; 2], point: u32) -> Result<u32, ()> {
        if let Some(&node) = self.known.get(&key(at)) {
            return if self.nodes[node as usize].point == point { Ok(node) } else { Err(()) };
        }
        let mut at = at;
        if self.carrier.pole_at(at).is_none()
            && let Some(same) = self.by_point.get(&point)
        {
            // A node on the other side of a seam has the same place along it.
            let place = same.iter().find_map(|&node| {
                let other = self.nodes[node as usize].at;
                let mut place = other;
                for d in 0..2 {
                    let side = &self.carrier.sides[d];
                    let on = |x: f64| side.closed && (x == side.low || x == side.high);
                    if on(at[d]) && on(other[d]) {
                        place[d] = at[d];
                    } else if (other[d] - at[d]).abs() > SAME * side.length() {
                        return None;
                    }
                }
                Some(place)
            });
            at = place.unwrap_or(at);
            if let Some(&node) = self.known.get(&key(at)) {
                return if self.nodes[node as usize].point == point { Ok(node) } else { Err(()) };
            }
        }
        let number = self.nodes.len() as u32;
        self.nodes.push(Node { at, point });
        self.known.insert(key(at), number);
        self.by_point.entry(point).or_default().push(number);
        Ok(number)
    }

    /// The node at a place of a seam, crease or pole, of a point of its own unless there is one.
    fn own(&mut self, at: [f64; 2]) -> u32 {
        if let Some(&node) = self.known.get(&key(at)) {
            return node;
        }
        let point = match self.carrier.pole_at(at) {
            Some((d, end)) => self.pole_points[d][end].unwrap_or_else(|| {
                let point = self.first_own + self.own.len() as u32;
                self.own.push(at);
                self.pole_points[d][end] = Some(point);
                point
            }),
            None => {
                let same = [0, 1].map(|d: usize| self.carrier.sides[d].wrapped(at[d]));
                // A copy on the other side of a seam.
                let others = self.copies(same);
                let there = others.iter().find_map(|other| self.known.get(&key(*other)));
                match there {
                    Some(&node) => self.nodes[node as usize].point,
                    None => *self.canonical.entry(key(same)).or_insert_with(|| {
                        let point = self.first_own + self.own.len() as u32;
                        self.own.push(same);
                        point
                    }),
                }
            }
        };
        let number = self.nodes.len() as u32;
        self.nodes.push(Node { at, point });
        self.known.insert(key(at), number);
        number
    }

    /// A place and the same ones on the other sides of seams.
    fn copies(&self, at: [f64; 2]) -> Vec<[f64; 2]> {
        let mut all = vec![at];
        for d in 0..2 {
            let side = &self.carrier.sides[d];
            if side.closed && (at[d] == side.low || at[d] == side.high) {
                for k in 0..all.len() {
                    let mut copy = all[k];
                    copy[d] = if at[d] == side.low { side.high } else { side.low };
                    all.push(copy);
                }
            }
        }
        all
    }

    /// The ends of a leg within the plane: which side of a seam they are on is where the rest of it is, or, of what runs along the seam,
    /// where the face is, to its left.
    fn sided(&self, leg: &Leg, reversed: bool) -> Option<[[f64; 2]; 2]> {
        let mut ends = leg.ends;
        for d in 0..2 {
            let other = 1 - d;
            match [ends[0][d].is_nan(), ends[1][d].is_nan()] {
                [true, true] => return None,
                [true, false] => ends[0][d] = ends[1][d],
                [false, true] => ends[1][d] = ends[0][d],
                _ => {}
            }
            let side = &self.carrier.sides[d];
            if !side.closed {
                continue;
            }
            let on = ends.map(|end| end[d] == side.low || end[d] == side.high);
            if on == [true, true] {
                let along = &self.carrier.sides[other];
                let step = along.unwrapped(leg.ends[1][other], leg.ends[0][other]) - leg.ends[0][other];
                let mut step = step;
                if step.is_nan() {
                    step = ends[1][other] - ends[0][other];
                }
                // Along v the left is towards lower u; along u it is towards higher v.
                let high = (step > 0.0) == (d == 0) && step != 0.0;
                let at = if high != reversed { side.high } else { side.low };
                ends[0][d] = at;
                ends[1][d] = at;
            } else {
                for k in 0..2 {
                    if on[k] {
                        let rest = ends[1 - k][d];
                        ends[k][d] = if rest - side.low < side.high - rest { side.low } else { side.high };
                    }
                }
            }
        }
        Some(ends)
    }
}

/// What is laid out.
pub(crate) struct Layout<'l> {
    pub(crate) legs: &'l [Leg],
    /// Chords to be followed that bound nothing.
    pub(crate) followed: &'l [Leg],
    pub(crate) reversed: bool,
    /// Whether different edges that coincide bound nothing, where what they bound lies on both of their sides.
    pub(crate) merges: bool,
    /// How many points the whole has.
    pub(crate) first_own: u32,
    /// Points alone in the face, and where they are.
    pub(crate) lone: &'l [([f64; 2], u32)],
}

/// Lays out a face.
///
/// # Errors
/// The chords in each other's way.
pub(crate) fn arrange(carrier: &Carrier, layout: &Layout<'_>, goal: &Goal) -> Result<Arranged, Clash> {
    let &Layout { legs, followed, reversed, merges, first_own, lone } = layout;
    let mut all = Builder {
        carrier,
        goal,
        nodes: Vec::new(),
        known: BTreeMap::new(),
        by_point: BTreeMap::new(),
        own: Vec::new(),
        first_own,
        canonical: BTreeMap::new(),
        pole_points: [[None; 2]; 2],
    };
    let mut borders: BTreeMap<[u32; 2], Border> = BTreeMap::new();
    let mut stretches: BTreeSet<[u32; 2]> = BTreeSet::new();
    let mut clash = Vec::new();
    for leg in legs {
        let Some(ends) = all.sided(leg, reversed) else { continue };
        let mut nodes = [0; 2];
        let mut met = true;
        for k in 0..2 {
            match all.node(ends[k], leg.points[k]) {
                Ok(node) => nodes[k] = node,
                Err(()) => met = false,
            }
            if let Some((d, end)) = carrier.pole_at(ends[k]) {
                all.pole_points[d][end] = Some(leg.points[k]);
            }
        }
        if !met {
            clash.push((leg.edge, leg.part));
            continue;
        }
        if nodes[0] == nodes[1] {
            continue;
        }
        let pair = [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])];
        let own = if reversed { [nodes[1], nodes[0]] } else { nodes };
        let border = Border { ends: own, edge: leg.edge, part: leg.part };
        if let Some(other) = borders.remove(&pair) {
            // There and back: a slit, with the face on both sides.
            if other.ends != border.ends && (merges || other.edge == border.edge) {
                stretches.insert(pair);
            } else {
                clash.extend([(other.edge, other.part), (leg.edge, leg.part)]);
            }
        } else {
            borders.insert(pair, border);
        }
    }
    for &(at, point) in lone {
        match carrier.pole_at(at) {
            Some((d, end)) => all.pole_points[d][end] = Some(all.pole_points[d][end].unwrap_or(point)),
            None => _ = all.node(at, point),
        }
    }
    for leg in followed {
        let Some(ends) = all.sided(leg, reversed) else { continue };
        if let [Ok(a), Ok(b)] = [0, 1].map(|k: usize| all.node(ends[k], leg.points[k]))
            && a != b
            && !borders.contains_key(&[a.min(b), a.max(b)])
        {
            stretches.insert([a.min(b), a.max(b)]);
        }
    }
    if !clash.is_empty() {
        return Err(clash);
    }
    let mut arranged = lines::lines(&mut all, &borders, &mut stretches);
    arranged.nodes = all.nodes;
    arranged.own = all.own;
    arranged.borders = borders.into_values().collect();
    arranged.stretches = stretches.into_iter().collect();
    Ok(arranged)
}
