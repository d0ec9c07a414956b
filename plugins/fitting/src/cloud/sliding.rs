//! How far a surface slides along itself.

use loftsman_kernel::{Point, Vector};

use super::patches::Patches;
use super::rows::Rows;

/// How far a surface is off along itself where it should be, as a part of the distance of its control vertices.
const SPREAD: f64 = 0.1;
/// Places that are looked at, at most but for one a patch.
const PLACES: usize = 1000;

/// How far a surface slides along itself from where it was given, in the mean of the squares: `Σ a |P (S - S₀)|²` at places `S₀` of it with the parts `a` of its
/// area, `P` what is tangent to it there.
///
/// No foot sees how a surface lies within itself, nor where it ends beyond its points. As it slides nothing changes but by noise, in which it so finds more to
/// follow the more it is crumpled. So this is beside the points' mean square, with the weight of places that are given as well as to the part [`SPREAD`] of the distance
/// of its `n` control vertices (a prior of this deviation, `SPREAD² A / n` of the area `A`, for each): `n² σ² / (N SPREAD² A)` for `N` points with
/// noise `σ²`. Points beyond its border move it all the same, as far as they say; without noise there is none of it.
#[derive(Debug)]
pub(super) struct Sliding {
    rows: Rows,
    normals: Vec<Vector>,
    begun: Vec<Vector>,
    shares: Vec<f64>,
    area: f64,
    vertices: usize,
}

impl Sliding {
    /// Of a surface with these control vertices; `origin` is where positions are measured from. Nothing of curves, and of what has no area.
    pub(super) fn new(patches: &Patches, vertices: &[Point], origin: Point) -> Option<Self> {
        if patches.is_curve() {
            return None;
        }
        let middles = patches.middles(vertices);
        let (mut rows, mut normals, mut begun, mut shares) = (Rows::default(), vec![], vec![], vec![]);
        for k in (0..middles.len()).step_by(patches.step(PLACES)) {
            let [place, across] = middles[k];
            if let Some(normal) = across.try_normalize(0.0) {
                patches.push_middle(k, &mut rows);
                normals.push(normal);
                begun.push(place - origin.coords);
                shares.push(across.norm());
            }
        }
        let sum: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= sum);
        let area = patches.measure(vertices);
        let usable = sum > 0.0 && sum.is_finite() && area > 0.0 && area.is_finite();
        usable.then_some(Self { rows, normals, begun, shares, area, vertices: vertices.len() })
    }

    /// The weight beside the mean of the squared distances of so many points with noise of this variance.
    pub(super) fn weight(&self, noise: f64, points: usize) -> f64 {
        let vertices = self.vertices as f64;
        noise * vertices * vertices / (points as f64 * SPREAD * SPREAD * self.area)
    }

    /// What of the way of a place is along the surface.
    fn along(&self, place: usize, way: Vector) -> Vector {
        let normal = self.normals[place];
        way - normal * normal.dot(&way)
    }

    /// The mean square at vertices `x` relative to the origin.
    pub(super) fn value(&self, x: &[Vector]) -> f64 {
        let slid = |k: usize| self.along(k, self.rows.sum(k, x) - self.begun[k]).norm_squared();
        (0..self.rows.len()).map(|k| self.shares[k] * slid(k)).sum()
    }

    /// Adds `by` half the gradient of the mean square at vertices `x` relative to the origin.
    pub(super) fn gradient(&self, by: f64, x: &[Vector], out: &mut [Vector]) {
        for k in 0..self.rows.len() {
            let slid = self.along(k, self.rows.sum(k, x) - self.begun[k]);
            self.rows.spread(k, slid * (by * self.shares[k]), out);
        }
    }

    /// Adds `by` half its second derivative times an adjustment.
    pub(super) fn multiply(&self, by: f64, d: &[Vector], out: &mut [Vector]) {
        for k in 0..self.rows.len() {
            let slid = self.along(k, self.rows.sum(k, d));
            self.rows.spread(k, slid * (by * self.shares[k]), out);
        }
    }

    /// Rows whose squares, with these shares, are no less than that in any direction.
    pub(super) fn rows(&self) -> (&Rows, &[f64]) {
        (&self.rows, &self.shares)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use loftsman_kernel::spline::{Space, Surface};

    use super::*;

    /// A plane that moves up has not slid, one that moves along itself has; derivatives are those of differences.
    #[test]
    fn only_ways_along_the_surface_count() {
        let space = || Space::clamped_uniform(2, 4).unwrap();
        let net = |bump: f64| -> Vec<Point> {
            let height = |k: usize| bump * (k as f64).sin();
            (0..16).map(|k| Point::new((k / 4) as f64, (k % 4) as f64, height(k))).collect()
        };
        for bump in [0.0, 0.7] {
            let surface = Surface::new(space(), space(), net(bump)).unwrap();
            let patches = Patches::new(&surface).unwrap();
            let origin = Point::new(1.0, -2.0, 0.5);
            let sliding = Sliding::new(&patches, surface.points(), origin).unwrap();
            let moved =
                |by: Vector| -> Vec<Vector> { surface.points().iter().map(|p| p - origin + by).collect() };
            assert!(sliding.value(&moved(Vector::zeros())) < 1e-28);
            if bump == 0.0 {
                assert!((sliding.area - 9.0).abs() < 1e-12);
                assert!(sliding.value(&moved(Vector::z() * 0.3)) < 1e-28);
                assert!((sliding.value(&moved(Vector::new(0.3, 0.4, 0.3))) - 0.25).abs() < 1e-14);
            }
            let x: Vec<Vector> = moved(Vector::new(0.1, 0.2, -0.3)).iter().map(|p| p * 1.2).collect();
            let way: Vec<Vector> =
                (0..16).map(|k| Vector::new((2.0 * k as f64).cos(), 0.3, (k as f64).sin())).collect();
            let at = |h: f64| -> Vec<Vector> { x.iter().zip(&way).map(|(x, d)| x + d * h).collect() };
            let [mut gradient, mut product] = [vec![Vector::zeros(); 16], vec![Vector::zeros(); 16]];
            sliding.gradient(2.0, &x, &mut gradient);
            sliding.multiply(2.0, &way, &mut product);
            let dot = |a: &[Vector]| a.iter().zip(&way).map(|(a, b)| a.dot(b)).sum::<f64>();
            let (up, here, down) = (sliding.value(&at(1e-3)), sliding.value(&x), sliding.value(&at(-1e-3)));
            assert!(((up - down) / 2e-3 - dot(&gradient)).abs() < 1e-9 * (1.0 + dot(&gradient).abs()));
            assert!(
                ((up - 2.0 * here + down) / 1e-6 - dot(&product)).abs() < 1e-6 * (1.0 + dot(&product).abs())
            );
        }
    }
}
