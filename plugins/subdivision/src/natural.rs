//! The characteristic map of an extraordinary point: the coordinates in which the surface round it is smooth.
//!
//! Round the point one refinement is a matrix. The eigenvector of its largest eigenvalue `λ` below one, which is a pair, puts the vertices into a plane so
//! that refining them is the same as making them smaller by `λ`; the surface of these vertices is the map `χ` from parameters to that plane,
//! with `χ(u/2, v/2) = λ χ(u, v)` (Reif 1995). By its coordinates the surface has a tangent plane at the point, and a finite thin-plate energy.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

use loftsman_kernel::shape::Chart;
use loftsman_kernel::spline::gram::gauss_legendre;

use crate::uniform::{cubic, quadratic};

/// A place of the plane, as a complex number.
type Place = [f64; 2];

/// Refinements after which the vertices that are further out are those of the eigenvector: at each their error is half of what it was at most.
const SETTLED: usize = 64;
/// Levels that parameters are looked for on.
const LEVELS: i32 = 60;

/// The characteristic map of a point with the same number of edges, or of sides, all round, over one of its faces, `(0, 0)` being the point. It is as large as
/// its parameters: the area of the face is one.
#[derive(Debug)]
pub(crate) struct Natural {
    /// The eigenvalue.
    scale: f64,
    /// The degree of the pieces.
    degree: usize,
    /// The vertices of the face on its first level, from -1 to 3 in each direction, of which each piece has its own.
    net: [[Place; 5]; 5],
}

fn add(a: Place, b: Place, by: f64) -> Place {
    [a[0] + by * b[0], a[1] + by * b[1]]
}

fn times(a: Place, b: Place) -> Place {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// What a net over one face holds at `(i, j)`, those beyond its sides being those of the faces beside it, turned.
struct Sector<'a> {
    net: &'a [[Place; 5]; 5],
    turn: Place,
    /// Where the vertex `(-1, j)` is in the net of the next face.
    beside: fn(usize) -> [usize; 2],
}

impl Sector<'_> {
    fn at(&self, i: i32, j: i32) -> Place {
        let [c, s] = self.turn;
        match (i, j) {
            (-1, j) => {
                let [a, b] = (self.beside)(j as usize);
                times([c, s], self.net[a][b])
            }
            (i, -1) => {
                let [b, a] = (self.beside)(i as usize);
                times([c, -s], self.net[a][b])
            }
            _ => self.net[i as usize][j as usize],
        }
    }
}

impl Natural {
    /// Of a vertex with `n` edges under Catmull-Clark subdivision, nothing being sharp. `None` for fewer than 3, of which the eigenvalues are
    /// no pair.
    ///
    /// The eigenvalue is `λ = (5 + cos φ + √((5 + cos φ)² - 16)) / 16` with `φ = 2π/n`, where edges end in `ω^k` and the corners across faces are
    /// `(ω^k + ω^(k+1)) / (4λ - 1)`.
    pub(crate) fn catmull_clark(n: usize) -> Option<Self> {
        let turn = turn_of(n)?;
        let x = 5.0 + turn[0];
        let scale = (x + (x * x - 16.0).max(0.0).sqrt()) / 16.0;
        let mut net = [[[0.0; 2]; 5]; 5];
        net[1][0] = [1.0, 0.0];
        net[0][1] = turn;
        net[1][1] = add([1.0, 0.0], turn, 1.0).map(|c| c / (4.0 * scale - 1.0));
        // Along the edge before a face run those of the face before it.
        let beside: fn(usize) -> [usize; 2] = |j| [j, 1];
        let mask = |x: i32| -> Vec<(i32, f64)> {
            match x.rem_euclid(2) {
                0 => vec![(x / 2 - 1, 0.125), (x / 2, 0.75), (x / 2 + 1, 0.125)],
                _ => vec![(x.div_euclid(2), 0.5), (x.div_euclid(2) + 1, 0.5)],
            }
        };
        Some(Self::settled(3, scale, net, turn, beside, mask, |_| [0.0; 2]))
    }

    /// Of a face with `n` sides, or a vertex with `n` edges, under Doo-Sabin subdivision. `λ = ½`, the corners of the face being `ω^k`. `None` for fewer than 3.
    pub(crate) fn doo_sabin(n: usize) -> Option<Self> {
        let turn = turn_of(n)?;
        let mut net = [[[0.0; 2]; 5]; 5];
        net[0][0] = [1.0, 0.0];
        let beside: fn(usize) -> [usize; 2] = |j| [j, 0];
        let mask = |x: i32| -> Vec<(i32, f64)> {
            let i = x.div_euclid(2);
            vec![(i, 0.75), (if x.rem_euclid(2) == 0 { i - 1 } else { i + 1 }, 0.25)]
        };
        Some(Self::settled(2, 0.5, net, turn, beside, mask, |first| first.map(|c| 0.5 * c)))
    }

    /// The net of the eigenvector from what is known of it nearest to the point: what is further out is refined until it is the same but for the scale.
    fn settled(
        degree: usize,
        scale: f64,
        mut net: [[Place; 5]; 5],
        turn: Place,
        beside: fn(usize) -> [usize; 2],
        mask: impl Fn(i32) -> Vec<(i32, f64)>,
        first: impl Fn(Place) -> Place,
    ) -> Self {
        // The vertices of one level that those of the next as far out are made of, and two more there.
        let known = degree as i32 - 1;
        let refined = |net: &[[Place; 5]; 5]| {
            let sector = Sector { net, turn, beside };
            let mut finer = [[[0.0; 2]; 5]; 5];
            for i in 0..=known + 1 {
                for j in 0..=known + 1 {
                    if (i, j) == (0, 0) {
                        finer[0][0] = first(net[0][0]);
                        continue;
                    }
                    let mut sum = [0.0; 2];
                    for (a, x) in mask(i) {
                        for &(b, y) in &mask(j) {
                            sum = add(sum, sector.at(a, b), x * y);
                        }
                    }
                    finer[i as usize][j as usize] = sum;
                }
            }
            finer
        };
        for _ in 0..SETTLED {
            let finer = refined(&net);
            for i in 0..=known as usize {
                for j in 0..=known as usize {
                    net[i][j] = finer[i][j].map(|c| c / scale);
                }
            }
        }
        let finer = refined(&net);
        // From -1 on.
        let sector = Sector { net: &finer, turn, beside };
        let shifted = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                if (i, j) == (0, 0) { [0.0; 2] } else { sector.at(i as i32 - 1, j as i32 - 1) }
            })
        });
        let mut natural = Self { scale, degree, net: shifted };
        let size = natural.area().sqrt();
        natural.net.iter_mut().flatten().for_each(|place| *place = place.map(|c| c / size));
        natural
    }

    /// The area of the face in the plane: three quarters of its parameters, and `λ²` of that from level to level.
    fn area(&self) -> f64 {
        let (nodes, weights) = gauss_legendre(self.degree);
        let mut sum = 0.0;
        for (a, b) in [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5)] {
            for (x, w) in nodes.iter().zip(&weights) {
                for (y, z) in nodes.iter().zip(&weights) {
                    if let Some(chart) = self.chart(a + 0.5 * x, b + 0.5 * y) {
                        sum += 0.25 * w * z * chart.area();
                    }
                }
            }
        }
        sum / (1.0 - self.scale * self.scale)
    }

    /// The derivatives of the map at a place of the face; `None` at the point itself.
    pub(crate) fn chart(&self, u: f64, v: f64) -> Option<Chart> {
        let (mut x, mut y, mut level) = (u, v, 0);
        while x.max(y) < 0.5 {
            if level == LEVELS {
                return None;
            }
            (x, y, level) = (2.0 * x, 2.0 * y, level + 1);
        }
        // On the first level a piece is as wide as one.
        let piece = |x: f64| if x < 0.5 { (0, 2.0 * x) } else { (1, 2.0 * x - 1.0) };
        let ((i, s), (j, t)) = (piece(x), piece(y));
        let value = |by: [usize; 2]| {
            let (along_u, along_v) = (basis(self.degree, s, by[0]), basis(self.degree, t, by[1]));
            let mut sum = [0.0; 2];
            for (a, x) in along_u.iter().enumerate().take(self.degree + 1) {
                for (b, y) in along_v.iter().enumerate().take(self.degree + 1) {
                    sum = add(sum, self.net[i + a][j + b], x * y);
                }
            }
            // Lengths are λ as large from level to level, and parameters half as large; twice on the first level.
            let order = (by[0] + by[1]) as i32;
            let scale = self.scale.powi(level) * 2.0_f64.powi(order * (level + 1));
            sum.map(|c| c * scale)
        };
        Some(Chart {
            first: [value([1, 0]), value([0, 1])],
            second: [value([2, 0]), value([1, 1]), value([0, 2])],
        })
    }
}

/// The maps of a surface's extraordinary points, each made when it is asked for first.
#[derive(Debug)]
pub(crate) struct Naturals {
    of: fn(usize) -> Option<Natural>,
    known: Mutex<BTreeMap<usize, Option<Arc<Natural>>>>,
}

impl Naturals {
    /// Those of a scheme.
    pub(crate) fn new(of: fn(usize) -> Option<Natural>) -> Self {
        Self { of, known: Mutex::default() }
    }

    /// The derivatives of the map of a point with `n` edges or sides, at a place of one of its faces that is seen from its corner `corner`; as
    /// far as `reach` from there, where the map is as large as the parameters.
    pub(crate) fn chart(&self, n: usize, corner: usize, [u, v]: [f64; 2], reach: f64) -> Option<Chart> {
        let natural = match self.known.lock() {
            Ok(mut known) => known.entry(n).or_insert_with(|| (self.of)(n).map(Arc::new)).clone(),
            Err(_) => (self.of)(n).map(Arc::new),
        }?;
        let [a, b] = seen_from(corner, [u, v]);
        let chart = natural.chart(a / reach, b / reach)?;
        let ([by_a, by_b], [aa, ab, bb]) = (chart.first, chart.second.map(|x| x.map(|c| c / reach)));
        let back = |x: [f64; 2]| x.map(|c| -c);
        Some(match corner {
            0 => Chart { first: [by_a, by_b], second: [aa, ab, bb] },
            1 => Chart { first: [back(by_b), by_a], second: [bb, back(ab), aa] },
            2 => Chart { first: [back(by_a), back(by_b)], second: [aa, ab, bb] },
            _ => Chart { first: [by_b, back(by_a)], second: [bb, back(ab), aa] },
        })
    }
}

/// A place of a face as it is seen from a corner, which becomes `(0, 0)`, `u` running along the side that follows.
pub(crate) fn seen_from(corner: usize, [u, v]: [f64; 2]) -> [f64; 2] {
    match corner {
        0 => [u, v],
        1 => [v, 1.0 - u],
        2 => [1.0 - u, 1.0 - v],
        _ => [1.0 - v, u],
    }
}

/// `ω = e^(2πi/n)`.
fn turn_of(n: usize) -> Option<Place> {
    let (sin, cos) = (TAU / n as f64).sin_cos();
    (n > 2).then_some([cos, sin])
}

/// The uniform B-splines of degree 2 or 3 over a span, or their derivatives; of degree 2 the last is none.
fn basis(degree: usize, x: f64, order: usize) -> [f64; 4] {
    if degree == 3 {
        return cubic(x, order);
    }
    let [a, b, c] = quadratic(x, order);
    [a, b, c, 0.0]
}
