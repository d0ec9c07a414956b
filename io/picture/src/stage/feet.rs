//! How far points are from a plug-in's surface: the nearest of its triangles, and from there the nearest place on the surface itself.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Derivative, Location, Shape};

use super::laid::{Laid, parameters};
use super::ridge::Ridges;
use super::shell::Shell;

/// Triangles in a leaf.
const LEAF: usize = 4;
/// Steps from a triangle to the surface, at most.
const STEPS: usize = 12;
/// A step as long as this part of the distance would shorten it by rounding alone, and is none.
const ENOUGH: f64 = 1e-7;
/// How often a step is halved, at most, until it leads nearer.
const HALVED: i32 = 4;

/// A box of triangles.
struct Node {
    low: Vector,
    high: Vector,
    /// Its triangles in the order of the tree.
    range: (usize, usize),
    /// The second of its halves: the first is the node that follows. 0 of a leaf.
    second: usize,
}

/// A tree over the triangles of a surface. Making it takes `n log n`.
pub(crate) struct Feet<'a> {
    shell: &'a Shell,
    laid: &'a Laid,
    surface: &'a dyn Shape,
    order: Vec<usize>,
    nodes: Vec<Node>,
    ridges: Ridges,
}

/// The point of a triangle that is nearest to another, by its shares of the corners.
#[derive(Clone, Copy)]
struct Foot {
    triangle: usize,
    shares: [f64; 3],
    distance: f64,
}

impl<'a> Feet<'a> {
    /// Of faces that are laid over a surface; `None` of others.
    pub(crate) fn of(shell: &'a Shell) -> Option<Self> {
        let laid = shell.laid.as_ref()?;
        let order = (0..shell.skin.triangles.len()).collect();
        let ridges = Ridges::of(&shell.skin.triangles, &shell.points, |k| laid.origin(k));
        let mut feet = Self { shell, laid, surface: laid.surface()?, order, nodes: Vec::new(), ridges };
        feet.build(0, feet.order.len());
        Some(feet)
    }

    fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.shell.skin.triangles[triangle].map(|k| self.shell.points[k as usize])
    }

    fn build(&mut self, from: usize, to: usize) {
        let empty = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        let grown = |(low, high): (Vector, Vector), p: &Vector| (low.inf(p), high.sup(p));
        let middle = |corners: [Vector; 3]| (corners[0] + corners[1] + corners[2]) / 3.0;
        let (mut all, mut middles) = (empty, empty);
        for &triangle in &self.order[from..to] {
            let corners = self.corners(triangle);
            all = corners.iter().fold(all, grown);
            middles = grown(middles, &middle(corners));
        }
        let index = self.nodes.len();
        self.nodes.push(Node { low: all.0, high: all.1, range: (from, to), second: 0 });
        if to - from <= LEAF {
            return;
        }
        let axis = (middles.1 - middles.0).imax();
        let mut own: Vec<(f64, usize)> =
            self.order[from..to].iter().map(|&k| (middle(self.corners(k))[axis], k)).collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.order[from..to].iter_mut().zip(own).for_each(|(to, (_, k))| *to = k);
        let half = from + (to - from) / 2;
        self.build(from, half);
        self.nodes[index].second = self.nodes.len();
        self.build(half, to);
    }

    /// How far a point is from the surface, negative on the side away from its normal (at what is sharp, from the mean of those round it); `None` where
    /// it has no triangle.
    pub(crate) fn distance(&self, p: &Vector) -> Option<f64> {
        let foot = self.nearest(p)?;
        let (at, away) = self.on_surface(p, &foot).unzip();
        let [a, b, c] = self.corners(foot.triangle);
        let flat = (b - a).cross(&(c - a));
        let on_triangle = a * foot.shares[0] + b * foot.shares[1] + c * foot.shares[2];
        let normal = at.and_then(|at| self.laid.normal(at, &flat)).unwrap_or(flat);
        let away: Vector = away.unwrap_or(p - on_triangle);
        let own = self.shell.skin.triangles[foot.triangle].map(|k| self.laid.origin(k));
        let side = match self.ridges.normal(own, foot.shares) {
            Some(normal) => normal.dot(&(p - on_triangle)),
            None => normal.dot(&away),
        };
        Some(if side < 0.0 { -away.norm() } else { away.norm() })
    }

    /// The nearest of all triangles.
    fn nearest(&self, p: &Vector) -> Option<Foot> {
        let mut best: Option<Foot> = None;
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index) else { continue };
            let outside = |node: &Node| (node.low - p).sup(&(p - node.high)).sup(&Vector::zeros()).norm();
            if best.is_some_and(|best| outside(node) >= best.distance) {
                continue;
            }
            if node.second == 0 {
                for &triangle in &self.order[node.range.0..node.range.1] {
                    let corners = self.corners(triangle);
                    let shares = shares(p, corners);
                    let [a, b, c] = corners;
                    let distance = (p - a * shares[0] - b * shares[1] - c * shares[2]).norm();
                    if best.is_none_or(|best| distance < best.distance) {
                        best = Some(Foot { triangle, shares, distance });
                    }
                }
                continue;
            }
            // The nearer half is looked at first.
            let [mut near, mut far] = [index + 1, node.second];
            if outside(&self.nodes[far]) < outside(&self.nodes[near]) {
                (near, far) = (far, near);
            }
            stack.extend([far, near]);
        }
        best
    }

    /// From a triangle to the nearest place of the surface on the same face, by Gauss and Newton's steps, each halved until it is one; and the
    /// way from there. `None` where the surface has no place there.
    fn on_surface(&self, p: &Vector, foot: &Foot) -> Option<(Location, Vector)> {
        let start = self.laid.within(&self.laid.corners[foot.triangle], foot.shares)?;
        let value = |at: Location, by: [usize; 2]| {
            let found = self.surface.value(at, Derivative::from(by)).ok();
            found.filter(|value| value.iter().all(|c| c.is_finite()))
        };
        let mut at = start;
        let mut away = p - value(at, [0, 0])?;
        for _ in 0..STEPS {
            let (Some(u), Some(v)) = (value(at, [1, 0]), value(at, [0, 1])) else { break };
            let Some(step) = step(&u, &v, &away) else { break };
            if (u * step[0] + v * step[1]).norm() <= ENOUGH * away.norm() {
                break;
            }
            let (_, uv) = parameters(at)?;
            let nearer = (0..=HALVED).find_map(|k| {
                let part = 0.5_f64.powi(k);
                let next = self.laid.clamped(at, [uv[0] + part * step[0], uv[1] + part * step[1]]);
                let way = p - value(next, [0, 0])?;
                (way.norm() < away.norm()).then_some((next, way))
            });
            let Some(nearer) = nearer else { break };
            (at, away) = nearer;
        }
        Some((at, away))
    }
}

/// The step in the tangent plane that comes nearest to a way; `None` where there is no such plane.
fn step(u: &Vector, v: &Vector, way: &Vector) -> Option<[f64; 2]> {
    let [e, f, g] = [u.dot(u), u.dot(v), v.dot(v)];
    let area = e * g - f * f;
    let [a, b] = [u.dot(way), v.dot(way)];
    let step = [(g * a - f * b) / area, (e * b - f * a) / area];
    (area > 1e-14 * e * g && step.iter().all(|x| x.is_finite())).then_some(step)
}

/// The shares of the corners that the nearest point of a triangle has (Ericson 2005, 5.1.5); of one without area those on a side of it.
fn shares(p: &Vector, [a, b, c]: [Vector; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(&ac);
    let square = normal.norm_squared();
    if square > 0.0 {
        let within = [
            (c - b).cross(&(p - b)).dot(&normal),
            (a - c).cross(&(p - c)).dot(&normal),
            ab.cross(&(p - a)).dot(&normal),
        ];
        if within.iter().all(|share| *share >= 0.0) {
            return within.map(|share| share / square);
        }
    }
    let on = |from: &Vector, to: &Vector| {
        let along = to - from;
        let length = along.norm_squared();
        if length > 0.0 { ((p - from).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 }
    };
    let [x, y, z] = [on(&a, &b), on(&b, &c), on(&c, &a)];
    let sides = [[1.0 - x, x, 0.0], [0.0, 1.0 - y, y], [z, 0.0, 1.0 - z]];
    let far = |s: &[f64; 3]| (p - a * s[0] - b * s[1] - c * s[2]).norm();
    sides.into_iter().fold(sides[0], |best, side| if far(&side) < far(&best) { side } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_is_inside_on_a_side_or_a_corner() {
        let triangle = [Vector::zeros(), Vector::x() * 2.0, Vector::y() * 2.0];
        for (p, expected) in [
            (Vector::new(0.5, 0.5, 3.0), [0.5, 0.25, 0.25]),
            (Vector::new(1.0, -1.0, 0.0), [0.5, 0.5, 0.0]),
            (Vector::new(2.0, 2.0, 1.0), [0.0, 0.5, 0.5]),
            (Vector::new(-1.0, -2.0, 0.0), [1.0, 0.0, 0.0]),
        ] {
            let found = shares(&p, triangle);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{p}: {found:?}");
        }
        // Without an area it is on the longest side, without a length at the point.
        let flat = [Vector::zeros(), Vector::x(), Vector::x() * 4.0];
        let [a, b, c] = shares(&Vector::new(3.0, 1.0, 0.0), flat);
        assert!((a + b + c - 1.0).abs() < 1e-15 && (b + 4.0 * c - 3.0).abs() < 1e-15);
        assert_eq!(shares(&Vector::x(), [Vector::y(); 3]), [1.0, 0.0, 0.0]);
    }
}
