//! Curves in the parameter plane of a surface, interpolated piece by piece: each piece is a Bézier curve of degree seven through Chebyshev's
//! extremal places, halved until it is near enough to what it stands for.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Dyn, LU};

use crate::Point;
use crate::error::{Error, Result};
use crate::space::Space;
use crate::spline::{Curve, binomial};

/// The degree of each piece: where what it stands for is smooth, halving it divides the error by 256.
pub const DEGREE: usize = 7;

/// Bézier points of one piece in the parameter plane.
pub type Net = [[f64; 2]; DEGREE + 1];

/// How far pieces are halved, and how many there may be.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Halvings of the part between two breaks.
    pub depth: u32,
    /// Pieces of the curve.
    pub pieces: usize,
}

/// Interpolation by a Bézier piece, made once for all pieces of a curve.
#[derive(Debug, Clone)]
pub struct Interpolation {
    nodes: [f64; DEGREE + 1],
    bernstein: LU<f64, Dyn, Dyn>,
}

impl Interpolation {
    /// Chebyshev's extremal places `½ − ½ cos(kπ/7)`, and the values `B_k(x_i)` of the Bernstein polynomials there, factored.
    #[must_use]
    pub fn new() -> Self {
        let nodes: [f64; DEGREE + 1] =
            std::array::from_fn(|k| 0.5 - 0.5 * (PI * k as f64 / DEGREE as f64).cos());
        let value =
            |k: usize, x: f64| binomial(DEGREE, k) * x.powi(k as i32) * (1.0 - x).powi((DEGREE - k) as i32);
        let bernstein = DMatrix::from_fn(nodes.len(), nodes.len(), |i, k| value(k, nodes[i])).lu();
        Self { nodes, bernstein }
    }

    /// The places in `[0, 1]`, ascending, that a piece goes through: both ends and six between.
    #[must_use]
    pub fn nodes(&self) -> [f64; DEGREE + 1] {
        self.nodes
    }

    /// The places halfway between [`nodes`](Self::nodes), where the interpolation is worst.
    pub fn between(&self) -> impl Iterator<Item = f64> + use<> {
        let nodes = self.nodes;
        (1..nodes.len()).map(move |k| 0.5 * (nodes[k - 1] + nodes[k]))
    }

    /// The Bézier points of the piece that goes through these places of the plane at the [nodes](Self::nodes); its ends to the bit, so that pieces meet.
    ///
    /// # Errors
    /// When a place is not finite.
    pub fn through(&self, places: &Net) -> Result<Net> {
        let right = DMatrix::from_fn(DEGREE + 1, 2, |k, d| places[k][d]);
        let solved = self.bernstein.solve(&right).filter(|x| x.iter().all(|x| x.is_finite()));
        let Some(solved) = solved else {
            return Err(Error::Invalid("its places could not be interpolated".into()));
        };
        let mut net: Net = std::array::from_fn(|k| [solved[(k, 0)], solved[(k, 1)]]);
        (net[0], net[DEGREE]) = (places[0], places[DEGREE]);
        Ok(net)
    }

    /// The curve of pieces over `breaks`, each of which is as `piece` makes it of its part `[a, b]`: its Bézier points, and whether they are near enough; what is not is
    /// halved. `None` where a piece is none (`piece` has none), or is not near enough within the limits.
    ///
    /// Knots have the breaks' own parameter and multiplicity seven, so that the curve is continuous; `O(pieces)` calls.
    ///
    /// # Errors
    /// Those of `piece`; when there are fewer than two breaks, or they don't ascend.
    pub fn curve(
        &self,
        breaks: &[f64],
        limits: Limits,
        mut piece: impl FnMut(&Self, f64, f64) -> Result<Option<(Net, bool)>>,
    ) -> Result<Option<Curve>> {
        let mut knots = vec![breaks.first().copied().unwrap_or(f64::NAN); DEGREE + 1];
        let mut points: Vec<Point> = Vec::new();
        for pair in breaks.windows(2) {
            let mut open = vec![(0_u32, pair[0], pair[1])];
            while let Some((depth, a, b)) = open.pop() {
                let Some((net, good)) = piece(self, a, b)? else { return Ok(None) };
                if good {
                    let from = usize::from(!points.is_empty());
                    points.extend(net[from..].iter().map(|p| Point::new(p[0], p[1], 0.0)));
                    knots.extend([b; DEGREE]);
                    continue;
                }
                if depth == limits.depth || points.len() + open.len() * DEGREE > limits.pieces * DEGREE {
                    return Ok(None);
                }
                let middle = 0.5 * (a + b);
                open.extend([(depth + 1, middle, b), (depth + 1, a, middle)]);
            }
        }
        knots.extend(knots.last().copied());
        Curve::new(Space::open(DEGREE, knots)?, points).map(Some)
    }
}

impl Default for Interpolation {
    fn default() -> Self {
        Self::new()
    }
}

/// A piece at a place of `[0, 1]`, by de Casteljau's algorithm.
#[must_use]
pub fn at(net: &Net, x: f64) -> [f64; 2] {
    let mut points = *net;
    for k in (1..net.len()).rev() {
        for i in 0..k {
            points[i] = [0, 1].map(|d: usize| points[i][d] + (points[i + 1][d] - points[i][d]) * x);
        }
    }
    points[0]
}

/// Breaks in order without what rounding set apart: those that are not farther than `least` behind another are one with it, and the last stays the end.
#[must_use]
pub fn apart(mut breaks: Vec<f64>, least: f64) -> Vec<f64> {
    breaks.sort_by(f64::total_cmp);
    let end = breaks.last().copied();
    let mut kept: Vec<f64> = Vec::with_capacity(breaks.len());
    for t in breaks {
        if kept.last().is_none_or(|last| t - last > least) {
            kept.push(t);
        }
    }
    if let (Some(last), Some(end)) = (kept.last_mut(), end) {
        *last = end;
    }
    kept
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;

    #[test]
    fn a_polynomial_of_degree_seven_comes_back() {
        let own: Net = std::array::from_fn(|k| [(k * k) as f64 - 3.0, (2.0 + k as f64).sin() * 1e3]);
        let made = Interpolation::new();
        let net = made.through(&made.nodes().map(|x| at(&own, x))).unwrap();
        for (a, b) in net.iter().zip(&own) {
            assert!((a[0] - b[0]).abs() < 1e-12 * 50.0 && (a[1] - b[1]).abs() < 1e-12 * 1e3, "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_circle_is_halved_until_it_is_near_and_breaks_stay() {
        let circle = |t: f64| [t.cos(), t.sin()];
        let made = Interpolation::new();
        let limits = Limits { depth: 10, pieces: 100 };
        let mut calls = 0;
        let curve = made.curve(&[-1.0, 0.5, 4.0], limits, |made, a, b| {
            calls += 1;
            let net = made.through(&made.nodes().map(|x| circle(a + (b - a) * x)))?;
            let off = made.between().map(|x| {
                let ([x, y], [c, s]) = (at(&net, x), circle(a + (b - a) * x));
                (x - c).hypot(y - s)
            });
            Ok(Some((net, off.fold(0.0, f64::max) < 1e-10)))
        });
        let curve = curve.unwrap().unwrap();
        assert!(curve.space().breakpoints().contains(&0.5) && calls > curve.space().breakpoints().len());
        for k in 0..=500 {
            let t = -1.0 + 5.0 * f64::from(k) / 500.0;
            let (p, [c, s]) = (curve.point(t).unwrap(), circle(t));
            assert!((p.x - c).hypot(p.y - s) < 1e-9, "{t}");
        }
    }

    #[test]
    fn what_comes_near_nowhere_is_none_within_the_limits() {
        let made = Interpolation::new();
        let mut calls = 0;
        let found = made.curve(&[0.0, 1.0], Limits { depth: 40, pieces: 50 }, |_, _, _| {
            calls += 1;
            Ok(Some(([[0.0; 2]; DEGREE + 1], false)))
        });
        assert!(found.unwrap().is_none() && calls <= 100, "{calls}");
        assert!(
            made.curve(&[0.0, 1.0], Limits { depth: 4, pieces: 50 }, |_, _, _| Ok(None)).unwrap().is_none()
        );
        assert!(made.curve(&[], Limits { depth: 4, pieces: 50 }, |_, _, _| Ok(None)).is_err());
        assert!(made.through(&[[f64::NAN; 2]; DEGREE + 1]).is_err());
    }

    #[test]
    fn breaks_that_rounding_set_apart_are_one() {
        assert_eq!(apart(vec![1.0, 0.0, 1e-12, 0.5, 1.0 - 1e-12], 1e-9), [0.0, 0.5, 1.0]);
        assert_eq!(apart(vec![], 1e-9), [0.0; 0]);
    }
}
