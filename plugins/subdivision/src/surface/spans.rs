//! Knot intervals round a face: whether they are those of a tensor-product spline, and its net as one with uniform knots.

use smallvec::{SmallVec, smallvec};

use super::regular::Row;
use crate::cage::Cage;
use crate::topology::Topology;

/// Intervals that differ by no more than this part are the same.
const SAME: f64 = 1e-13;

/// What is known of the five spans of a cubic line: the face's own in the middle, two on either side.
#[derive(Debug, Default)]
pub(super) struct Spans {
    found: [Option<f64>; 5],
    differ: bool,
}

impl Spans {
    fn say(&mut self, place: usize, interval: f64) {
        match self.found[place] {
            None => self.found[place] = Some(interval),
            Some(known) => self.differ |= !same(known, interval),
        }
    }

    /// The spans, where all that was said of each agrees. Those of which nothing was said are mirrored beyond a crease or boundary.
    fn all(&self) -> Option<[f64; 5]> {
        let [a, b, c, d, e] = self.found;
        let c = c?;
        let (b, d) = (b.unwrap_or(c), d.unwrap_or(c));
        (!self.differ).then_some([a.unwrap_or(d), b, c, d, e.unwrap_or(b)])
    }
}

/// Whether two intervals are equal but for rounding.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.max(b)
}

/// The spans round a face along `u` and along `v`.
#[derive(Debug, Default)]
pub(super) struct Around([Spans; 2]);

impl Around {
    /// Takes in the edges of a quad: from its corner at a half-edge, at a place of the net, the directions of its four edges.
    pub(super) fn quad(
        &mut self,
        cage: &Cage,
        half: u32,
        mut at: [isize; 2],
        directions: [[isize; 2]; 4],
        beyond: &dyn Fn(usize) -> [f64; 2],
    ) {
        let topology = cage.topology();
        let mut half = half;
        for step in directions {
            let axis = usize::from(step[0] == 0);
            let to = [at[0] + step[0], at[1] + step[1]];
            let edge = topology.edge_of(half) as usize;
            let low = at[axis].min(to[axis]);
            let [start, end] = ends(topology, half, beyond(edge));
            let (below, above) = if step[axis] > 0 { (start, end) } else { (end, start) };
            // Places of the net are 0 to 3; span 0 is what is before it.
            if (0..3).contains(&low) {
                let low = low as usize;
                self.0[axis].say(low + 1, cage.interval(edge));
                self.0[axis].say(low, 0.5 * below);
                self.0[axis].say(low + 2, 0.5 * above);
            }
            (at, half) = (to, topology.next(half));
        }
    }

    /// The net over the face of a spline with these spans, as one with uniform knots.
    pub(super) fn uniform(&self, net: [Row; 16]) -> Option<[Row; 16]> {
        let [u, v] = [self.0[0].all()?, self.0[1].all()?];
        let even = |d: &[f64; 5]| d[0] > 0.0 && d.iter().all(|x| *x == d[0]);
        if even(&u) && even(&v) {
            return Some(net);
        }
        let [u, v] = [matrix(&u), matrix(&v)];
        Some(std::array::from_fn(|k| {
            let mut all: Row = smallvec![];
            for (place, row) in net.iter().enumerate() {
                let by = u[k / 4][place / 4] * v[k % 4][place % 4];
                if by != 0.0 {
                    row.iter().for_each(|&(vertex, c)| add(&mut all, vertex, by * c));
                }
            }
            all
        }))
    }
}

fn add(row: &mut SmallVec<[(u32, f64); 4]>, vertex: u32, by: f64) {
    match row.iter_mut().find(|(v, _)| *v == vertex) {
        Some((_, c)) => *c += by,
        None => row.push((vertex, by)),
    }
}

fn ends(topology: &Topology, half: u32, [a, b]: [f64; 2]) -> [f64; 2] {
    if topology.halves(topology.edge_of(half) as usize)[0] == half { [a, b] } else { [b, a] }
}

/// The four vertices of a cubic with uniform knots that is, over the middle span, the one with these spans: first the Bézier points by
/// blossoming, then back.
fn matrix(spans: &[f64; 5]) -> [[f64; 4]; 4] {
    let [a, b, c, d, e] = *spans;
    let part = |x: f64, rest: f64| if x + rest > 0.0 { x / (x + rest) } else { 0.5 };
    // From one end: the second Bézier point, and the first by the point that a knot inserted twice gives.
    let end = |a: f64, b: f64, c: f64, d: f64| {
        let near = part(b, c + d);
        let second = [0.0, 1.0 - near, near, 0.0];
        let before = part(a + b, c);
        let (back, forth) = (1.0 - part(b, c), part(b, c));
        let first = [back * (1.0 - before), back * before + forth * second[1], forth * second[2], 0.0];
        [first, second]
    };
    let [first, second] = end(a, b, c, d);
    let [mut last, mut third] = end(e, d, c, b);
    last.reverse();
    third.reverse();
    const BACK: [[f64; 4]; 4] =
        [[6.0, -7.0, 2.0, 0.0], [0.0, 2.0, -1.0, 0.0], [0.0, -1.0, 2.0, 0.0], [0.0, 2.0, -7.0, 6.0]];
    let bezier = [first, second, third, last];
    BACK.map(|row| {
        std::array::from_fn(|k| row.iter().zip(&bezier).map(|(weight, point)| weight * point[k]).sum())
    })
}

/// Whether opposite edges of a face have the same interval, so that its parts are parts of tensor-product splines: of a quad both
/// pairs, of another face every edge and the next but one.
fn is_even(cage: &Cage, face: usize) -> bool {
    let edges = cage.topology().face_edges(face);
    let d = |k: usize| cage.interval(edges[k % edges.len()] as usize);
    (0..edges.len()).all(|k| same(d(k), d(k + 2)))
}

/// The first edge without an interval that is not as a double knot of a tensor-product spline is: across a line that goes on with intervals
/// through inner vertices of four quads, or along the boundary through vertices of two, with nothing else sharp there. Elsewhere weights vanish, and
/// there are no pieces.
pub(super) fn vanishing_edge(cage: &Cage) -> Option<usize> {
    let topology = cage.topology();
    let fits = |edge: usize, vertex: usize| {
        let edges: SmallVec<[u32; 12]> = topology.vertex_edges(vertex).collect();
        let quad = |f: u32| topology.face_corners(f as usize).len() == 4;
        let Some(own) = edges.iter().position(|&e| e as usize == edge) else { return false };
        let on_boundary = topology.is_boundary_vertex(vertex);
        // The one that goes on: of four that across, on the boundary the last for the first.
        let (count, next) = if on_boundary { (3, 2 - own.min(2)) } else { (4, (own + 2) % 4) };
        let inside = |e: &&u32| !topology.is_boundary_edge(**e as usize);
        edges.len() == count
            && topology.is_boundary_edge(edge) == on_boundary
            && topology.vertex_faces(vertex).all(quad)
            && cage.vertex_sharpness(vertex) <= 0.0
            && edges.iter().filter(inside).all(|&e| cage.sharpness(e as usize) <= 0.0)
            && cage.interval(edges[next] as usize) > 0.0
    };
    let vanishes = |&edge: &usize| cage.interval(edge) <= 0.0;
    let wrong = |&edge: &usize| !topology.ends(edge).iter().all(|&v| fits(edge, v as usize));
    cage.has_intervals().then(|| (0..topology.edge_count()).filter(vanishes).find(wrong)).flatten()
}

/// The first face of a cage whose opposite edges have different intervals.
pub(super) fn uneven_face(cage: &Cage) -> Option<usize> {
    if !cage.has_intervals() {
        return None;
    }
    (0..cage.topology().face_count()).find(|&face| !is_even(cage, face))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the recursion of de Boor and Cox.
    fn spline(spans: &[f64; 5], p: [f64; 4], t: f64) -> f64 {
        let knots: Vec<f64> = std::iter::once(0.0)
            .chain(spans.iter().scan(0.0, |at, d| {
                *at += d;
                Some(*at)
            }))
            .collect();
        let x = knots[2] + t * spans[2];
        let mut p = p;
        for level in 1..=3 {
            for k in (level..4).rev() {
                let (from, to) = (knots[k - 1], knots[k + 3 - level]);
                let at = (x - from) / (to - from);
                p[k] = p[k - 1] * (1.0 - at) + p[k] * at;
            }
        }
        p[3]
    }

    #[test]
    fn a_cubic_with_uniform_knots_is_the_same_cubic() {
        for spans in
            [[1.0, 2.0, 0.7, 3.0, 0.1], [0.0, 2.0, 0.7, 0.0, 0.1], [1.0; 5], [1e-9, 1.0, 2.0, 1e9, 1.0]]
        {
            let p = [0.3, -1.2, 2.5, 0.9];
            let own = matrix(&spans).map(|row| row.iter().zip(p).map(|(c, x)| c * x).sum::<f64>());
            for k in 0..=8 {
                let t = f64::from(k) / 8.0;
                let (off, wanted) = (spline(&[1.0; 5], own, t), spline(&spans, p, t));
                assert!((off - wanted).abs() < 1e-13, "{spans:?}, {t}: {off} {wanted}");
            }
        }
    }
}
