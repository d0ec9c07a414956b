//! Bézier control points of any stretch of a span, straight from the B-spline's own control points.

use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

/// The `(p + 1)²` matrix that gives the Bézier control points over `[a, b]` (within span `span`) from the `p + 1`
/// control points of that span: row `j` holds what control point `j` is made of.
///
/// Row `j` is the blossom of the B-spline at `a` (`p - j` times) and `b` (`j` times): Cox–de Boor's recurrence
/// with another argument in each degree (Ramshaw 1987). All arguments are within the span, so that every step is
/// a convex combination and nothing cancels. `O(p³)`.
pub(crate) fn extraction(space: &Space, span: usize, a: f64, b: f64, out: &mut Vec<[f64; MAX_ORDER]>) {
    let (p, t) = (space.degree(), space.flat());
    out.clear();
    for j in 0..=p {
        let mut row = [0.0; MAX_ORDER];
        row[0] = 1.0;
        for d in 1..=p {
            let x = if d <= j { b } else { a };
            let mut carry = 0.0;
            for i in 0..d {
                let (left, right) = (t[span + 1 + i - d], t[span + 1 + i]);
                let share = row[i] / (right - left);
                row[i] = carry + (right - x) * share;
                carry = (x - left) * share;
            }
            row[d] = carry;
        }
        out.push(row);
    }
}

/// Restricts a Bézier net of `rows × columns` (row after row along `u`), given over `[0, 1]²`, to a box within it.
///
/// De Casteljau, twice a direction: all steps are convex combinations. `O(rows columns (rows + columns))`.
pub(crate) fn restrict<const L: usize>(
    net: &mut [[f64; L]],
    rows: usize,
    columns: usize,
    low: [f64; 2],
    high: [f64; 2],
) {
    for (direction, (a, b)) in [(low[0], high[0]), (low[1], high[1])].into_iter().enumerate() {
        if a > 0.0 {
            part(net, rows, columns, direction, a, true);
        }
        if b < 1.0 {
            part(net, rows, columns, direction, (b - a) / (1.0 - a), false);
        }
    }
}

/// Keeps the part of a net after (or before) `at` of one direction.
fn part<const L: usize>(
    net: &mut [[f64; L]],
    rows: usize,
    columns: usize,
    direction: usize,
    at: f64,
    after: bool,
) {
    // Towards the end `k` ascends and takes from `k + 1`; towards the start the other way round.
    let share = if after { at } else { 1.0 - at };
    if direction == 0 {
        for r in 1..rows {
            for k in 0..rows - r {
                let to = if after { k } else { rows - 1 - k };
                let (head, tail) = net.split_at_mut((to + usize::from(after)) * columns);
                let (to, from) = if after {
                    (&mut head[to * columns..], &tail[..columns])
                } else {
                    (&mut tail[..columns], &head[(to - 1) * columns..])
                };
                to.iter_mut().zip(from).for_each(|(to, from)| mix(to, from, share));
            }
        }
    } else {
        for row in net.chunks_exact_mut(columns) {
            for r in 1..columns {
                if after {
                    for k in 0..columns - r {
                        let from = row[k + 1];
                        mix(&mut row[k], &from, share);
                    }
                } else {
                    for k in (r..columns).rev() {
                        let from = row[k - 1];
                        mix(&mut row[k], &from, share);
                    }
                }
            }
        }
    }
}

#[inline]
fn mix<const L: usize>(to: &mut [f64; L], from: &[f64; L], share: f64) {
    for lane in 0..L {
        to[lane] += (from[lane] - to[lane]) * share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_cubic_gives_the_known_matrix_and_halves_agree() {
        let space = Space::floating_uniform(3, 4).unwrap();
        let mut rows = Vec::new();
        extraction(&space, 3, 0.0, 1.0, &mut rows);
        let sixth = [[1.0, 4.0, 1.0, 0.0], [0.0, 4.0, 2.0, 0.0], [0.0, 2.0, 4.0, 0.0], [0.0, 1.0, 4.0, 1.0]];
        for (row, expected) in rows.iter().zip(sixth) {
            for (value, e) in row.iter().zip(expected) {
                assert!((value * 6.0 - e).abs() < 1e-15);
            }
        }
        let end = rows[3];
        extraction(&space, 3, 0.5, 1.0, &mut rows);
        assert_eq!(rows[3], end);
        let mut basis = [0.0; MAX_ORDER];
        space.basis_into(3, 0.5, 0, &mut basis);
        assert_eq!(rows[0], basis);
    }

    #[test]
    fn a_restricted_net_is_what_extraction_gives() {
        let space = Space::clamped_uniform(3, 4).unwrap();
        let mut rows = Vec::new();
        extraction(&space, 3, 0.25, 0.875, &mut rows);
        let mut net: Vec<[f64; 4]> =
            (0..4).map(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)))).collect();
        let mut across: Vec<_> = net.clone();
        restrict(&mut net, 4, 1, [0.25, 0.0], [0.875, 1.0]);
        restrict(&mut across, 1, 4, [0.0, 0.25], [1.0, 0.875]);
        assert_eq!(net, across);
        for (row, expected) in net.iter().zip(&rows) {
            for (value, e) in row.iter().zip(expected) {
                assert!((value - e).abs() < 1e-15, "{row:?} {expected:?}");
            }
        }
    }
}
