//! One cage from another.

use std::f64::consts::TAU;

use loftsman_kernel::shape::Stencil;
use loftsman_kernel::{Point, Vector, parallel};

use crate::cage::{Cage, present};
use crate::eigen::Matrix;
use crate::error::Result;
use crate::leading::Leading;
use crate::row::Row;
use crate::topology::{NONE, Topology};

/// The cage refined once. Corner `h` of the cage becomes vertex `h`; faces are, in this order, one for each face (with its number),
/// one for each inner edge in order, one for each inner vertex in order that has more than two edges.
///
/// Doo and Sabin (1978): a corner becomes `(n + 5)/(4n)` of itself and `(3 + 2 cos(2π j/n))/(4n)` of the corner `j` places on. With end
/// intervals, Sederberg, Zheng, Sewell and Sabin (1998, section 3): `(P_i + V)/2 + c_i/(4 T) Σ_j (1 + 2 cos(2π (i-j)/n)) (P_j - P_i)` with
/// `V = Σ w_i P_i / T`, `w_i` the product of the intervals of the two neighbours towards `P_i`, `T = Σ w_i`, and `c_i` that of its own
/// two in the face; intervals are halved. Where `T` is zero, the zeros are one small number that goes to zero, so that a vertex without an
/// interval is a double knot, and two of them beside each other a triple one. A hole's own face is a hole. Cost: linear.
///
/// # Errors
/// When 32 bits cannot count what would be there.
pub fn refine(cage: &Cage) -> Result<Cage> {
    let old = cage.topology();
    let points = parallel::map(old.face_count(), |face| of_face(cage, face)).concat();
    // Made without a check of coordinates: as everywhere, those of a cage near the largest number may overflow.
    let topology = dual(old)?;
    let mut child = Cage::from_topology(vec![Point::origin(); points.len()], topology.into())?;
    child.points = points;
    child.boundary = cage.boundary;
    if cage.holes.contains(&true) {
        child.holes = cage.holes.clone();
    }
    if cage.has_end_intervals() {
        child.end_intervals = refined_intervals(cage, child.topology());
    }
    Ok(child)
}

/// A vertex for each corner, and a face for each face, inner edge and inner vertex of more than two edges.
pub(super) fn dual(old: &Topology) -> Result<Topology> {
    let (mut corners, mut starts): (Vec<u32>, Vec<usize>) =
        (Vec::with_capacity(4 * old.corner_count()), vec![0]);
    for face in 0..old.face_count() {
        corners.extend(old.face_corners(face).map(|h| h as u32));
        starts.push(corners.len());
    }
    for edge in 0..old.edge_count() {
        let [one, other] = old.halves(edge);
        if other != NONE {
            corners.extend([old.next(one), one, old.next(other), other]);
            starts.push(corners.len());
        }
    }
    for vertex in 0..old.vertex_count() {
        if !old.is_boundary_vertex(vertex) && old.around(vertex).nth(2).is_some() {
            corners.extend(old.around(vertex));
            starts.push(corners.len());
        }
    }
    Topology::new(old.corner_count(), corners, &starts)
}

/// The cage refined so many times; those between are not kept.
///
/// # Errors
/// As for [`refine`].
pub fn refine_times(cage: &Cage, times: usize) -> Result<Cage> {
    let mut finest = cage.clone();
    for _ in 0..times {
        finest = refine(&finest)?;
    }
    Ok(finest)
}

/// The vertices of the cage that vertex `corner` of the refined cage is made of, and how much of each. Cost: the size of the face.
///
/// # Errors
/// When there is no such corner.
pub fn stencil(cage: &Cage, corner: usize) -> Result<Stencil> {
    let topology = cage.topology();
    present("corner", corner, topology.corner_count())?;
    let face = topology.face_of(corner as u32) as usize;
    let mut row = Row::default();
    let weights = weights(cage, face);
    let vertices = topology.face(face);
    let of =
        corner_row(weights.as_ref(), corner - topology.face_corners(face).start, &cosines(vertices.len()));
    vertices.iter().zip(of).for_each(|(&vertex, (_, weight))| row.add(vertex, weight));
    Ok(row.into_stencil())
}

/// `1 + 2 cos(2πk/n)` for each `k` below `n`.
fn cosines(n: usize) -> Vec<f64> {
    (0..n).map(|k| 1.0 + 2.0 * (TAU * k as f64 / n as f64).cos()).collect()
}

/// How much of each corner of a face the new point of one is made of, none left out; `waves` are those of its number of corners.
fn corner_row(weights: Option<&Weights>, at: usize, waves: &[f64]) -> Vec<(u32, f64)> {
    let n = waves.len();
    let entry = |j: usize| {
        let itself = if j == at { 1.0 } else { 0.0 };
        let wave = waves[(at + n - j) % n];
        let middle = weights.map_or(1.0 / n as f64, |w| w.middle[j]);
        0.5 * (itself + middle) + share(weights, at, n) * (wave - n as f64 * itself)
    };
    (0..n).map(|j| (j as u32, entry(j))).collect()
}

/// The rows of all corners of a face.
pub(super) fn matrix(cage: &Cage, face: usize) -> Matrix {
    let n = cage.topology().face(face).len();
    let weights = weights(cage, face);
    let waves = cosines(n);
    (0..n).map(|at| corner_row(weights.as_ref(), at, &waves)).collect()
}

/// What intervals make of a face.
pub(super) struct Weights {
    /// The weight of each corner in the middle.
    middle: Vec<f64>,
    /// How much of the wave each corner has, `c_i / (4 T)`.
    wave: Vec<f64>,
}

impl Weights {
    /// Of a face whose corners have these intervals, along the edge that follows and along the one before. `None` where a corner would have
    /// more of the wave than there is a number for: of five sides and more, where zeros leave `T` smaller than `c_i` beyond measure.
    pub(super) fn new(own: &[[f64; 2]]) -> Option<Self> {
        let n = own.len();
        let towards = |i: usize| [own[(i + n - 1) % n][0], own[(i + 1) % n][1]];
        let total: f64 = (0..n).map(|i| towards(i)[0] * towards(i)[1]).sum();
        if total > 0.0 {
            return Some(Self {
                middle: (0..n).map(|i| towards(i)[0] * towards(i)[1] / total).collect(),
                wave: own.iter().map(|[a, b]| a * b / (4.0 * total)).collect(),
            });
        }
        let product = |[a, b]: [f64; 2]| Leading::new(a, 1.0) * Leading::new(b, 1.0);
        let middle: Vec<Leading> = (0..n).map(|i| product(towards(i))).collect();
        let own: Vec<Leading> = own.iter().map(|own| product(*own)).collect();
        let wave = Leading::over(&own, &middle)?;
        Some(Self { middle: Leading::shares(&middle), wave: wave.into_iter().map(|c| 0.25 * c).collect() })
    }

    /// The rows of all corners.
    pub(super) fn matrix(&self) -> Matrix {
        let n = self.middle.len();
        let waves = cosines(n);
        (0..n).map(|at| corner_row(Some(self), at, &waves)).collect()
    }
}

/// How much of the wave a corner has: `1/(4n)` of a uniform face.
fn share(weights: Option<&Weights>, corner: usize, n: usize) -> f64 {
    weights.map_or(0.25 / n as f64, |w| w.wave[corner])
}

/// The intervals that the vertex of a corner has along the edge that follows, and along the one before.
pub(super) fn intervals(cage: &Cage, half: u32) -> [f64; 2] {
    let topology = cage.topology();
    let at_start = |half: u32, start: bool| {
        let edge = topology.edge_of(half) as usize;
        cage.end_interval(edge)[usize::from((topology.halves(edge)[0] == half) != start)]
    };
    [at_start(half, true), at_start(topology.previous(half), false)]
}

/// Faces of which the limits are in one place, two by two: those at the edge between two vertices without an interval across it, on either side.
pub(crate) fn double_knots(cage: &Cage) -> Vec<[usize; 2]> {
    let topology = cage.topology();
    let mut all = Vec::new();
    for edge in 0..topology.edge_count() {
        let [one, other] = topology.halves(edge);
        if other == NONE {
            continue;
        }
        // Away from the edge: in the face of each half-edge at its start, and at its end.
        let away = |h: u32| [intervals(cage, h)[1], intervals(cage, topology.next(h))[0]];
        if [one, other].into_iter().flat_map(away).all(|d| d <= 0.0) {
            all.push([one, other].map(|h| topology.face_of(h) as usize));
        }
    }
    all
}

/// The weights of a face by intervals; `None` where it is uniform.
fn weights(cage: &Cage, face: usize) -> Option<Weights> {
    if !cage.has_end_intervals() {
        return None;
    }
    let own: Vec<[f64; 2]> = cage.topology().face_corners(face).map(|h| intervals(cage, h as u32)).collect();
    Weights::new(&own)
}

/// The new points of a face's corners.
fn of_face(cage: &Cage, face: usize) -> Vec<Point> {
    let sums = FaceSums::new(cage, face, &Point::origin());
    (0..cage.topology().face(face).len()).map(|corner| sums.corner(corner).into()).collect()
}

/// What the new points of a face's corners are made of. `Σ_j cos(2π (i-j)/n) P_j` is taken apart into a sum of cosines and one of sines, so that
/// all of them together cost no more than the size of the face.
pub(super) struct FaceSums<'c> {
    cage: &'c Cage,
    vertices: &'c [u32],
    origin: Point,
    weights: Option<Weights>,
    /// Where all new points are half drawn to.
    middle: Vector,
    waves: [Vector; 3],
}

impl<'c> FaceSums<'c> {
    /// Of points that are taken from an origin. Cost: the size of the face.
    pub(super) fn new(cage: &'c Cage, face: usize, origin: &Point) -> Self {
        let vertices = cage.topology().face(face);
        let waves = waves(cage, face, origin);
        let weights = weights(cage, face);
        let middle = weights.as_ref().map_or(waves[0], |w| {
            let terms = vertices.iter().zip(&w.middle);
            terms.fold(Vector::zeros(), |sum, (&v, &c)| sum + (cage.points()[v as usize] - origin) * c)
        });
        Self { cage, vertices, origin: *origin, weights, middle, waves }
    }

    /// The new point of a corner, less the origin. Cost: that of a sine.
    pub(super) fn corner(&self, at: usize) -> Vector {
        let count = self.vertices.len();
        let [centre, cosines, sines] = self.waves;
        let (sin, cos) = (TAU * at as f64 / count as f64).sin_cos();
        let own = self.cage.points()[self.vertices[at] as usize] - self.origin;
        let wave = (centre - own) * count as f64 + (cosines * cos + sines * sin) * 2.0;
        (own + self.middle) * 0.5 + wave * share(self.weights.as_ref(), at, count)
    }
}

/// The middle of a face, and the sums of its vertices by cosines and sines round it, of points that are taken from an origin.
pub(super) fn waves(cage: &Cage, face: usize, origin: &Point) -> [Vector; 3] {
    let vertices = cage.topology().face(face);
    let n = vertices.len() as f64;
    let mut sums = [Vector::zeros(); 3];
    let at = |v: u32| cage.points()[v as usize] - origin;
    sums[0] = vertices.iter().fold(sums[0], |sum, &v| sum + at(v)) / n;
    for (i, &v) in vertices.iter().enumerate() {
        let (sin, cos) = (TAU * i as f64 / n).sin_cos();
        // From the middle, so that nothing is lost far from the origin.
        let arm = at(v) - sums[0];
        sums[1] += arm * cos;
        sums[2] += arm * sin;
    }
    sums
}

/// The end intervals of the refined cage: half those of the vertex that a corner comes from, in the same direction.
fn refined_intervals(cage: &Cage, child: &Topology) -> Vec<[f64; 2]> {
    let old = cage.topology();
    parallel::map(child.edge_count(), |edge| {
        let [a, b] = child.ends(edge);
        // Of each end: whether the edge runs in the direction of the edge that follows its corner, or of the one before.
        let along = old.next(a) == b;
        let back = old.next(b) == a;
        let over = old.twin(a) != NONE && old.next(old.twin(a)) == b;
        let directions = if !along && (back || over) { [1, 0] } else { [0, 1] };
        [intervals(cage, a)[directions[0]] / 2.0, intervals(cage, b)[directions[1]] / 2.0]
    })
}
