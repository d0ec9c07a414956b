//! Limit rows against ten explicit levels of refinement, at the rates that eigenvalues say.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use crate::shapes::levels::explicit;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::limit_stencils;
use loftsman_subdivision::{Cage, LimitFrame};

/// How a vertex comes to its limit once all finite sharpness is gone.
enum Rate {
    /// Smooth, with so many edges.
    Smooth(usize),
    /// On a crease or the boundary, or a corner: as a cubic curve does, or at once.
    Curve,
    /// At the end of a crease, where no formula is as short.
    Dart,
}

fn rate(cage: &Cage, vertex: usize) -> Rate {
    let topology = cage.topology();
    let sharp = |e: u32| topology.is_boundary_edge(e as usize) || cage.crease(e as usize) >= 10.0;
    let count = topology.vertex_edges(vertex).filter(|&e| sharp(e)).count();
    match count {
        _ if cage.corner(vertex) >= 10.0 || count > 1 => Rate::Curve,
        1 => Rate::Dart,
        _ => Rate::Smooth(topology.valence(vertex)),
    }
}

/// The eigenvalues below one of what is the same all round a vertex: `μ² - (3/4 - 7/4n) μ + (1 - 3/n)/16 = 0`.
fn constant(n: usize) -> [f64; 2] {
    let n = n as f64;
    let (sum, product) = (0.75 - 1.75 / n, (1.0 - 3.0 / n) / 16.0);
    let root = (sum * sum - 4.0 * product).max(0.0).sqrt();
    let [a, b] = [(sum + root) / 2.0, (sum - root) / 2.0];
    // With two edges the larger one is negative.
    if a.abs() > b.abs() { [a, b] } else { [b, a] }
}

/// The larger and the smaller eigenvalue of the waves `m` times round a vertex of `n` edges.
fn wave(n: usize, m: usize) -> [f64; 2] {
    let cos = (std::f64::consts::TAU * m as f64 / n as f64).cos();
    let root = ((1.0 + cos) * (9.0 + cos)).max(0.0).sqrt();
    [(5.0 + cos + root) / 16.0, (5.0 + cos - root) / 16.0]
}

/// Levels until nothing finite is sharp.
fn decay(cage: &Cage) -> usize {
    let edges = (0..cage.topology().edge_count()).map(|e| cage.crease(e));
    let all = edges.chain((0..cage.points().len()).map(|v| cage.corner(v)));
    all.filter(|s| *s < 10.0).fold(0.0, |m: f64, s| m.max(s.ceil())) as usize
}

/// What is left after ten levels goes with the largest eigenvalue `μ` of the point's own (`4^-10`, 1e-6, where four edges meet or on a
/// crease); without it, by `V₁₀ + μ/(1-μ) (V₁₀ - V₉)`, with the next one (`16^-10`, 1e-12; on a crease there is none).
#[test]
fn positions_are_those_of_ten_levels() {
    let mut count = [0; 3];
    for (name, cage) in crate::shapes::all() {
        let levels = 10 + decay(&cage);
        for v in [0, 1, 4].into_iter().filter(|&v| v < cage.points().len()) {
            let limit = Point::from(limit_stencils(&cage, v, 0).unwrap().position.apply(cage.points()));
            let nine = explicit(&cage, v, levels - 1).points()[0];
            let ten = explicit(&cage, v, levels).points()[0];
            let [before, after] = [nine, ten].map(|p| (p - limit).norm());
            let context = format!("{name}, vertex {v}: {before:e} {after:e}");
            let [large, small, kind] = match rate(&cage, v) {
                Rate::Smooth(n) => [constant(n)[0], constant(n)[1].abs(), 0.0],
                Rate::Curve => [0.25, 0.0, 1.0],
                Rate::Dart => [0.8, 0.8, 2.0],
            };
            count[kind as usize] += 1;
            assert!(after <= 4.0 * large.abs().powi(10) + 4e-15, "{context}");
            if kind < 2.0 {
                assert!(after <= 1.05 * large.abs() * before + 4e-15, "{context}, rate {large}");
                let without = ten + (ten - nine) * (large / (1.0 - large));
                let off = (without - limit).norm();
                assert!(off <= 10.0 * small.powi(10) + 4e-15, "{context}, {off:e}");
            }
        }
    }
    assert!(count[0] > 200 && count[1] > 150 && count[2] > 10, "{count:?}");
}

/// The largest sine between the tangent plane and an edge of the vertex.
fn lifted(cage: &Cage, normal: Vector) -> f64 {
    let topology = cage.topology();
    let edge = |e: u32| {
        let [a, b] = topology.edge(e as usize).unwrap();
        cage.points()[(a + b) as usize] - cage.points()[0]
    };
    topology.vertex_edges(0).map(|e| edge(e).normalize().dot(&normal).abs()).fold(0.0, f64::max)
}

/// The edges of a smooth vertex come to lie in the tangent plane as the third eigenvalue goes to nothing beside the first two.
#[test]
fn tangent_planes_are_those_of_ten_levels() {
    let mut count = 0;
    for (name, cage) in crate::shapes::all() {
        let start = decay(&cage);
        for v in [0, 1, 4].into_iter().filter(|&v| v < cage.points().len()) {
            let Rate::Smooth(n) = rate(&cage, v) else { continue };
            if n < 3 {
                continue;
            }
            let rows = limit_stencils(&cage, v, 0).unwrap();
            let tangents = rows.tangents.map(|t| t.apply(cage.points()));
            let Some(normal) = (LimitFrame { point: Point::origin(), tangents }).normal() else { continue };
            let third = if n == 3 { wave(3, 1)[1] } else { wave(n, 2)[0] };
            let ratio = third.max(constant(n)[0]) / wave(n, 1)[0];
            let [five, ten] = [5, 10].map(|k| lifted(&explicit(&cage, v, start + k), normal));
            assert!(
                ten <= 1.3 * ratio.powi(5) * five + 1e-9,
                "{name}, vertex {v}: {five:e} {ten:e}, rate {ratio}"
            );
            assert!(ten <= 40.0 * ratio.powi(10), "{name}, vertex {v}: {ten:e}, rate {ratio}");
            count += 1;
        }
    }
    assert!(count > 150, "{count}");
}
