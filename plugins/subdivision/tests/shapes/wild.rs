//! Random meshes, the same on every run.

use loftsman_kernel::Vector;

use super::plain::{Plain, ends};
use super::{cube, double_fan, grid, noise, tetrahedron};

/// Random numbers by a seed.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(1_000_003))
    }

    /// In `[-1, 1]`.
    pub(crate) fn number(&mut self) -> f64 {
        self.0 += 1;
        noise(self.0)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((0.5 * (self.number() + 1.0) * count as f64) as usize).min(count - 1)
    }

    pub(crate) fn vector(&mut self) -> Vector {
        Vector::from_fn(|_, _| self.number())
    }
}

/// Two polygons of `n` corners and the quads between.
pub(crate) fn prism(n: usize) -> Plain {
    let point = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * (k % n) as f64 / n as f64).sin_cos();
        Vector::new(cos, sin, if k < n { -0.6 } else { 0.6 })
    };
    let mut faces: Vec<Vec<usize>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    faces.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
    Plain { points: (0..2 * n).map(point).collect(), faces, ..Plain::default() }
}

/// Closed: a prism, a double fan, a cube, a tetrahedron; all numbers of sides from 3 to 8 come in turn.
fn base(seed: u64) -> Plain {
    let n = 3 + (seed / 4 % 6) as usize;
    match seed % 4 {
        0 => prism(n),
        1 => Plain::of(&double_fan(n, 0.05)),
        2 => Plain::of(&cube()),
        _ => Plain::of(&tetrahedron()),
    }
}

/// Without an edge between two faces, which become one.
fn merge(plain: &mut Plain, dice: &mut Dice) {
    let inner: Vec<_> = plain.edges().into_iter().filter(|(_, f)| f.len() == 2).collect();
    let (edge, faces) = inner[dice.below(inner.len())].clone();
    let from = |f: usize| {
        let face = &plain.faces[f];
        let k = (0..face.len()).find(|&k| ends(face[k], face[(k + 1) % face.len()]) == edge).unwrap();
        (1..face.len()).map(|j| face[(k + j) % face.len()]).collect::<Vec<_>>()
    };
    plain.faces[faces[0]] = [from(faces[0]), from(faces[1])].concat();
    plain.faces.remove(faces[1]);
}

pub(crate) fn change(plain: &mut Plain, dice: &mut Dice) {
    let face = dice.below(plain.faces.len());
    let corners = plain.faces[face].clone();
    let n = corners.len();
    match dice.below(3) {
        0 => {
            let middle = plain.middle(&corners) * 1.3;
            plain.points.push(middle);
            let tip = plain.points.len() - 1;
            plain.faces.remove(face);
            plain.faces.extend((0..n).map(|k| vec![tip, corners[k], corners[(k + 1) % n]]));
        }
        1 => merge(plain, dice),
        _ if n > 3 => {
            plain.faces[face] = corners[..3].to_vec();
            plain.faces.push([&corners[2..], &corners[..1]].concat());
        }
        _ => {}
    }
}

/// The numbers of edges at the vertices.
pub(crate) fn valences(plain: &Plain) -> Vec<usize> {
    let mut all = vec![0; plain.points.len()];
    plain.edges().keys().flatten().for_each(|&v| all[v] += 1);
    all
}

/// A closed mesh whose vertices have 3 to 8 edges each, smooth.
pub(crate) fn closed(seed: u64) -> Plain {
    let mut dice = Dice::new(seed);
    let mut plain = base(seed);
    for _ in 0..dice.below(7) {
        let mut changed = plain.clone();
        change(&mut changed, &mut dice);
        let fits = valences(&changed).iter().all(|n| (3..=8).contains(n));
        if fits && changed.cage().is_ok_and(|cage| cage.check_shape().is_ok()) {
            plain = changed;
        }
    }
    plain.points.iter_mut().for_each(|p| *p += dice.vector() * 0.1);
    plain
}

/// The same with creases and corners, for ever and for some levels.
pub(crate) fn sharpened(mut plain: Plain, seed: u64) -> Plain {
    let mut dice = Dice::new(seed + 5_000);
    let edges: Vec<[usize; 2]> = plain.edges().into_keys().collect();
    let sharpness = |dice: &mut Dice| match dice.below(3) {
        0 => f64::INFINITY,
        _ => 1.5 + 1.4 * dice.number(),
    };
    for _ in 0..=dice.below(4) {
        let s = sharpness(&mut dice);
        plain.creases.insert(edges[dice.below(edges.len())], s);
    }
    for _ in 0..dice.below(3) {
        let s = sharpness(&mut dice);
        let v = dice.below(plain.points.len());
        plain.corners.insert(v, s);
    }
    plain
}

/// The same without one or two of its faces.
pub(crate) fn opened(mut plain: Plain, seed: u64) -> Plain {
    let mut dice = Dice::new(seed + 9_000);
    plain.rounded = seed.is_multiple_of(2);
    for _ in 0..=dice.below(2) {
        let mut less = plain.clone();
        less.faces.remove(dice.below(plain.faces.len()));
        let used = less.faces.iter().flatten().collect::<std::collections::BTreeSet<_>>().len();
        if used == plain.points.len() && less.cage().is_ok() {
            plain = less;
        }
    }
    let edges = plain.edges();
    plain.creases.retain(|e, _| edges.contains_key(e));
    plain
}

/// An open sheet of quads, its vertices moved at random.
pub(crate) fn sheet(rows: usize, columns: usize, by: f64, dice: &mut Dice) -> Plain {
    let mut plain = Plain::of(&grid(rows, columns, [false, false], 0.0));
    plain.points.iter_mut().for_each(|p| *p += dice.vector() * by);
    plain
}
