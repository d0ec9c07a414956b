//! Limit masks: left eigenvectors of the matrix that refines the ring of a vertex, on quads, with nothing sharp but infinitely.

use std::f64::consts::{PI, TAU};

use super::ring::{Few, Limit, Mask, Sharpness};

/// Rows at the end of a crease are sought by so many multiplications at most. Usual valences need some hundred; with hundreds of edges
/// the tangent along the crease is then right to a few digits only.
const MOST_STEPS: usize = 4000;

/// The row of the limit position of a vertex with `n` edges: interior `(n², 4, 1) / (n (n + 5))` (Halstead, Kass and DeRose 1993), on a
/// crease `(1, 4, 1) / 6`, a corner itself. A dart, for which no formula is as short, by multiplication until nothing changes.
pub(super) fn position(limit: Limit, edges: usize, faces: usize) -> Mask {
    let mut mask = Mask::zero(edges, faces);
    match limit {
        Limit::Smooth | Limit::Dart(_) => {
            let n = edges as f64;
            let total = n * (n + 5.0);
            mask.vertex = n / (n + 5.0);
            mask.edges.fill(4.0 / total);
            mask.faces.fill(1.0 / total);
            if let Limit::Dart(edge) = limit {
                let sharpness = dart(edges, edge);
                repeat(&mut mask, |mask| {
                    let mut next = mask.back(&sharpness).across();
                    next.scale(1.0 / next.sum());
                    next
                });
            }
        }
        Limit::Crease(ends) => {
            mask.vertex = 2.0 / 3.0;
            ends.iter().for_each(|&end| mask.edges[end] = 1.0 / 6.0);
        }
        Limit::Corner => mask.vertex = 1.0,
    }
    mask
}

/// The number of sides on which the surface at a vertex has tangents of its own.
pub(super) fn sectors(limit: Limit, edges: usize, faces: usize) -> usize {
    match limit {
        Limit::Smooth | Limit::Dart(_) => 1,
        Limit::Crease(_) => 1 + usize::from(edges == faces),
        Limit::Corner => faces,
    }
}

/// The rows of two tangents, the second to the left of the first seen from outside.
///
/// Interior: cosines and sines round the vertex, `e_i = cos iθ`, `q_i = (e_i + e_{i+1}) / (4 (4λ - 1))`, `θ = 2π/n`, with the sub-dominant
/// eigenvalue `λ = (5 + cos θ + √((1 + cos θ)(9 + cos θ))) / 16`; with valence 2, where all eigenvalues but one are a quarter, across
/// its edges and its faces. Crease: half the difference of its two ends, and across a sector of `k` faces sines with `θ = π/k`. Corner:
/// along the two edges of a face. A dart: along its edge, and sines about it.
pub(super) fn tangents(limit: Limit, edges: usize, faces: usize, sector: usize) -> [Mask; 2] {
    let mut masks = [Mask::zero(edges, faces), Mask::zero(edges, faces)];
    match limit {
        Limit::Smooth if edges == 2 => {
            (masks[0].edges[0], masks[0].edges[1]) = (1.0, -1.0);
            (masks[1].faces[0], masks[1].faces[1]) = (1.0, -1.0);
        }
        Limit::Smooth => masks = [wave(edges, 0, 0.25), wave(edges, 0, 0.0)],
        Limit::Dart(edge) => masks = [along_dart(edges, edge), wave(edges, edge, 0.0)],
        Limit::Crease([a, b]) => {
            let (from, to) = if sector == 0 { (a, b) } else { (b, a) };
            (masks[0].edges[from], masks[0].edges[to]) = (0.5, -0.5);
            let count = (to + edges - from) % edges;
            masks[1] = across(edges, faces, from, count);
        }
        Limit::Corner => {
            for (mask, edge) in masks.iter_mut().zip([sector, (sector + 1) % edges]) {
                (mask.vertex, mask.edges[edge]) = (-1.0, 1.0);
            }
        }
    }
    masks
}

/// The eigenvalue of the first waves round a vertex, or between two creases, by the cosine of the angle between two edges; and from it
/// the weight of the vertices across by the sum of those beside them.
fn across_weight(cos: f64) -> (f64, f64) {
    let lambda = (5.0 + cos + ((1.0 + cos) * (9.0 + cos)).sqrt()) / 16.0;
    (lambda, 0.25 / (4.0 * lambda - 1.0))
}

/// `sin(2π ((i - from)/n + phase))` on the edges of a vertex, and what belongs to it on the faces.
fn wave(n: usize, from: usize, phase: f64) -> Mask {
    let mut mask = Mask::zero(n, n);
    // Wound to less than a turn in whole numbers, so that the first wave is zero to rounding where it is.
    for (i, weight) in mask.edges.iter_mut().enumerate() {
        *weight = (TAU * (((i + n - from) % n) as f64 / n as f64 + phase)).sin();
    }
    // With two edges these are zero, and so are their sums.
    let (_, factor) = if n == 2 { (0.25, 0.0) } else { across_weight((TAU / n as f64).cos()) };
    for i in 0..n {
        mask.faces[i] = factor * (mask.edges[i] + mask.edges[(i + 1) % n]);
    }
    if n == 2 {
        let first = from % 2;
        (mask.faces[first], mask.faces[1 - first]) = (1.0, -1.0);
        mask.edges.fill(0.0);
    }
    mask
}

/// The tangent across a crease, of the sector of `count` faces from edge `from` on.
fn across(edges: usize, faces: usize, from: usize, count: usize) -> Mask {
    let mut mask = Mask::zero(edges, faces);
    let to = (from + count) % edges;
    if count < 2 {
        // All eigenvalues but those along the crease are a quarter, and what remains is how the crease bends.
        (mask.vertex, mask.edges[from], mask.edges[to]) = (-2.0, 1.0, 1.0);
        return mask;
    }
    let theta = PI / count as f64;
    let (lambda, factor) = across_weight(theta.cos());
    let sine = |i: usize| if i == 0 || i == count { 0.0 } else { (theta * i as f64).sin() };
    let (mut sum, mut of_faces) = (0.0, 0.0);
    for i in 0..count {
        let face = factor * (sine(i) + sine(i + 1));
        mask.faces[(from + i) % faces] = face;
        mask.edges[(from + i) % edges] = sine(i);
        sum += sine(i);
        of_faces += face;
    }
    // What is left of the eigenvector: its ends and its middle, from two equations whose determinant is (λ - 1)(λ - 1/4).
    let right = [sine(1) / 16.0 + factor * sine(1) / 4.0, 0.375 * sum + 0.25 * of_faces];
    let determinant = (lambda - 1.0) * (lambda - 0.25);
    let end = ((lambda - 0.75) * right[0] + right[1] / 8.0) / determinant;
    mask.vertex = ((lambda - 0.5) * right[1] + right[0]) / determinant;
    (mask.edges[from], mask.edges[to]) = (end, end);
    mask
}

/// A vertex with one infinitely sharp edge.
fn dart(edges: usize, edge: usize) -> Sharpness {
    let mut sharp = Few::from_elem(0.0, edges);
    sharp[edge] = f64::INFINITY;
    Sharpness { vertex: 0.0, edges: sharp }
}

/// The tangent along the edge of a dart: the largest eigenvalue among rows that are symmetric about it and sum to zero.
fn along_dart(n: usize, edge: usize) -> Mask {
    let sharpness = dart(n, edge);
    let mut mask = Mask::zero(n, n);
    for i in 0..n {
        mask.edges[(edge + i) % n] = (TAU * i as f64 / n as f64).cos();
    }
    mask.vertex -= mask.sum();
    repeat(&mut mask, |mask| {
        let mut next = mask.back(&sharpness).across();
        // What rounding brings in of the other eigenvectors is taken out again: the odd ones, and the constant one.
        for i in 1..n {
            let (a, b) = ((edge + i) % n, (edge + n - i) % n);
            (next.edges[a], next.edges[b]) =
                (0.5 * (next.edges[a] + next.edges[b]), 0.5 * (next.edges[a] + next.edges[b]));
        }
        for i in 0..n {
            let (a, b) = ((edge + i) % n, (edge + 2 * n - 1 - i) % n);
            (next.faces[a], next.faces[b]) =
                (0.5 * (next.faces[a] + next.faces[b]), 0.5 * (next.faces[a] + next.faces[b]));
        }
        next.vertex -= next.sum();
        let largest = next.distance(&Mask::zero(n, n));
        next.scale(if largest > 0.0 { 1.0 / largest } else { 0.0 });
        next
    });
    mask
}

/// Repeats a step until it changes nothing but rounding: little, and no longer less and less.
fn repeat(mask: &mut Mask, step: impl Fn(&Mask) -> Mask) {
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let next = step(mask);
        let change = next.distance(mask);
        *mask = next;
        if change <= 0.0 || (change < 1e-14 && change >= last) {
            break;
        }
        last = change;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How far a row is from being an eigenvector: what a refinement adds that is not along it.
    fn residual(mask: &Mask, sharpness: &Sharpness) -> f64 {
        let mut next = mask.back(sharpness).across();
        let dot = |a: &Mask, b: &Mask| {
            let sum = |a: &Few, b: &Few| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            a.vertex * b.vertex + sum(&a.edges, &b.edges) + sum(&a.faces, &b.faces)
        };
        let along = dot(&next, mask) / dot(mask, mask);
        next.scale(1.0 / along);
        next.distance(mask) / dot(mask, mask).sqrt()
    }

    #[test]
    fn rows_are_eigenvectors() {
        for n in (2..13).chain([40, 100]) {
            let smooth = Sharpness { vertex: 0.0, edges: Few::from_elem(0.0, n) };
            let mut creased = smooth.clone();
            let k = n / 2;
            (creased.edges[1], creased.edges[(1 + k) % n]) = (f64::INFINITY, f64::INFINITY);
            let mut open = Sharpness { vertex: 0.0, edges: Few::from_elem(0.0, n + 1) };
            (open.edges[0], open.edges[n]) = (f64::INFINITY, f64::INFINITY);
            let cases = [
                (Limit::Smooth, smooth, n, n),
                (Limit::Crease([1, 1 + k]), creased, n, n),
                (Limit::Crease([0, n]), open, n + 1, n),
                (Limit::Dart(1), dart(n, 1), n, n),
            ];
            for (limit, sharpness, edges, faces) in cases {
                if (limit == Limit::Crease([1, 1 + k]) || matches!(limit, Limit::Dart(_))) && n < 3 {
                    continue;
                }
                let off = residual(&position(limit, edges, faces), &sharpness);
                assert!(off < 2e-15, "{limit:?} of {n}: position {off:e}");
                for sector in 0..sectors(limit, edges, faces) {
                    let rows = tangents(limit, edges, faces, sector);
                    for (which, row) in rows.iter().enumerate() {
                        assert!(row.sum().abs() < 1e-13, "{limit:?} of {n}");
                        // Where a crease has one face on a side, what is taken is no eigenvector but what grows along one.
                        let alone = which == 1 && (faces < edges && n == 1 || n < 4 && faces == edges);
                        let off = residual(row, &sharpness);
                        let most = match limit {
                            Limit::Dart(_) if n > 50 => 1e-6,
                            Limit::Dart(_) => 1e-9,
                            _ => 1e-13,
                        };
                        assert!(off < most || alone, "{limit:?} of {n}, {sector} {which}: {off:e}");
                    }
                }
            }
        }
    }
}
