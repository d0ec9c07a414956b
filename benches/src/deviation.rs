//! How far a mesh is from the surface it stands for, whoever made it.

use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Vector};

/// A triangle's corners and their parameters on the surface.
pub type Triangle = [(Point, [f64; 2]); 3];

/// Where triangles are looked at: the middles of their edges and seven places inside.
const PLACES: [[f64; 3]; 10] = {
    const T: f64 = 1.0 / 3.0;
    [
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
        [T, T, T],
        [0.6, 0.2, 0.2],
        [0.2, 0.6, 0.2],
        [0.2, 0.2, 0.6],
        [0.4, 0.4, 0.2],
        [0.2, 0.4, 0.4],
        [0.4, 0.2, 0.4],
    ]
};

/// The largest distance to the surface of ten places of every triangle: four steps of Gauss and Newton from the
/// parameters between those of the corners (on a domain of `[0, 1]²`).
pub fn deviation(surface: &Surface, triangles: impl Iterator<Item = Triangle>) -> f64 {
    let mut worst = 0.0_f64;
    for triangle in triangles {
        for place in PLACES {
            let (mut point, mut at) = (Vector::zeros(), [0.0; 2]);
            for ((corner, uv), share) in triangle.iter().zip(place) {
                point += corner.coords * share;
                at = [at[0] + share * uv[0], at[1] + share * uv[1]];
            }
            worst = worst.max(distance(surface, point, at));
        }
    }
    worst
}

fn distance(surface: &Surface, point: Vector, mut at: [f64; 2]) -> f64 {
    let (mut best, mut jet) = (f64::INFINITY, [Vector::zeros(); 4]);
    for _ in 0..4 {
        if surface.derivatives_into(at[0], at[1], [1, 1], &mut jet).is_err() {
            return f64::INFINITY;
        }
        let [here, sv, su, _] = jet;
        let away = point - here;
        best = best.min(away.norm());
        let (a, b, c, e, f) = (su.dot(&su), su.dot(&sv), sv.dot(&sv), su.dot(&away), sv.dot(&away));
        let step = [(c * e - b * f) / (a * c - b * b), (a * f - b * e) / (a * c - b * b)];
        for (at, step) in at.iter_mut().zip(step) {
            *at = (*at + if step.is_finite() { step } else { 0.0 }).clamp(0.0, 1.0);
        }
    }
    best
}
