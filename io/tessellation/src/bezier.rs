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
}
