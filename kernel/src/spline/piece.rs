//! Single polynomial pieces as bare Bézier nets of `L` numbers a vertex: what branch-and-bound searches cut up.
//!
//! Everything here is convex combination: no coefficient leaves the hull of those it is made of.

use super::space::Space;

/// Bézier vertices of a span by blossoming: vertex `j` is the blossom at `p - j` times the start and `j` times the
/// end (Ramshaw 1987). `O(p³)`.
pub(super) fn bezier<const L: usize>(space: &Space, span: usize, vertices: &[[f64; L]]) -> Vec<[f64; L]> {
    let (p, t) = (space.degree(), space.flat());
    let (a, b) = (t[span], t[span + 1]);
    (0..=p)
        .map(|j| {
            let mut d = vertices.to_vec();
            for r in 1..=p {
                let at = if r <= p - j { a } else { b };
                for i in (r..=p).rev() {
                    let (low, high) = (t[span - p + i], t[span + 1 + i - r]);
                    let share = (at - low) / (high - low);
                    for lane in 0..L {
                        d[i][lane] = (1.0 - share) * d[i - 1][lane] + share * d[i][lane];
                    }
                }
            }
            d[p]
        })
        .collect()
}

/// Bézier net, row after row, of a patch: of the spans `spans` of the two spaces.
pub(super) fn bezier_patch<const L: usize>(
    u: &Space,
    v: &Space,
    spans: (usize, usize),
    net: Vec<[f64; L]>,
) -> Vec<[f64; L]> {
    let columns = v.degree() + 1;
    let mut net: Vec<_> = net.chunks(columns).flat_map(|row| bezier(v, spans.1, row)).collect();
    for j in 0..columns {
        let column: Vec<_> = net.iter().skip(j).step_by(columns).copied().collect();
        for (i, value) in bezier(u, spans.0, &column).into_iter().enumerate() {
            net[i * columns + j] = value;
        }
    }
    net
}

/// Both halves of a Bézier net of `rows` rows, cut across them (de Casteljau).
pub(super) fn halves<const L: usize>(net: &[[f64; L]], rows: usize, columns: usize) -> [Vec<[f64; L]>; 2] {
    let mut left = net.to_vec();
    let mut right = net.to_vec();
    for r in 1..rows {
        // `right` holds step r - 1 in its first rows - r + 1 rows; its last used row is final.
        for i in 0..rows - r {
            for j in 0..columns {
                for lane in 0..L {
                    right[i * columns + j][lane] =
                        0.5 * right[i * columns + j][lane] + 0.5 * right[(i + 1) * columns + j][lane];
                }
            }
        }
        left[r * columns..(r + 1) * columns].copy_from_slice(&right[..columns]);
    }
    [left, right]
}

/// Both halves of a Bézier net, every row cut in two.
pub(super) fn halves_of_rows<const L: usize>(net: &[[f64; L]], columns: usize) -> [Vec<[f64; L]>; 2] {
    let mut both = [Vec::with_capacity(net.len()), Vec::with_capacity(net.len())];
    for row in net.chunks(columns) {
        for (all, half) in both.iter_mut().zip(halves(row, columns, 1)) {
            all.extend(half);
        }
    }
    both
}
