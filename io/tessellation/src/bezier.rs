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

/// Does something with room for a line of an order: the usual orders have code of their own, which keeps it in registers.
macro_rules! with_line {
    ($order:expr, $line:ident => $work:expr) => {
        match $order {
            2 => {
                let $line = &mut [[0.0; L]; 2];
                $work
            }
            3 => {
                let $line = &mut [[0.0; L]; 3];
                $work
            }
            4 => {
                let $line = &mut [[0.0; L]; 4];
                $work
            }
            order => {
                let $line = &mut [[0.0; L]; MAX_ORDER][..order];
                $work
            }
        }
    };
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
        if a > 0.0 || b < 1.0 {
            let lines = Lines::of(rows, columns, direction);
            with_line!(lines.order, line => lines.restrict(net, line, a, b));
        }
    }
}

/// Halves a Bézier net in a direction: it becomes what is before the middle, `upper`, of the same size, what is after.
pub(crate) fn halve<const L: usize>(
    net: &mut [[f64; L]],
    upper: &mut [[f64; L]],
    rows: usize,
    columns: usize,
    direction: usize,
) {
    let lines = Lines::of(rows, columns, direction);
    with_line!(lines.order, line => lines.halve(net, upper, line));
}

/// The lines of control points of a net in one direction.
#[derive(Clone, Copy)]
struct Lines {
    /// How many points a line has, and how far they are apart.
    order: usize,
    step: usize,
    /// How many lines there are, and how far they are apart.
    count: usize,
    next: usize,
}

impl Lines {
    /// Those along `u` or along `v`.
    fn of(rows: usize, columns: usize, direction: usize) -> Self {
        if direction == 0 {
            Self { order: rows, step: columns, count: columns, next: 1 }
        } else {
            Self { order: columns, step: 1, count: rows, next: columns }
        }
    }

    /// Where the points of each line start.
    fn starts(self) -> impl Iterator<Item = usize> {
        (0..self.count).map(move |k| k * self.next)
    }

    #[inline(always)]
    fn load<const L: usize>(self, net: &[[f64; L]], start: usize, line: &mut [[f64; L]]) {
        line.iter_mut().enumerate().for_each(|(k, point)| *point = net[start + k * self.step]);
    }

    #[inline(always)]
    fn store<const L: usize>(self, net: &mut [[f64; L]], start: usize, line: &[[f64; L]]) {
        line.iter().enumerate().for_each(|(k, point)| net[start + k * self.step] = *point);
    }

    /// What is after a parameter, and of that what is before another.
    #[inline(always)]
    fn restrict<const L: usize>(self, net: &mut [[f64; L]], line: &mut [[f64; L]], a: f64, b: f64) {
        let order = line.len();
        let back = 1.0 - (b - a) / (1.0 - a);
        for start in self.starts() {
            self.load(net, start, line);
            for r in 1..if a > 0.0 { order } else { 0 } {
                (0..order - r).for_each(|k| line[k] = mix(line[k], line[k + 1], a));
            }
            for r in 1..if b < 1.0 { order } else { 0 } {
                (r..order).rev().for_each(|k| line[k] = mix(line[k], line[k - 1], back));
            }
            self.store(net, start, line);
        }
    }

    /// What is after the middle stays in the line, what is before it is stored on the way.
    #[inline(always)]
    fn halve<const L: usize>(self, net: &mut [[f64; L]], upper: &mut [[f64; L]], line: &mut [[f64; L]]) {
        let order = line.len();
        for start in self.starts() {
            self.load(net, start, line);
            for r in 1..order {
                (0..order - r).for_each(|k| line[k] = mix(line[k], line[k + 1], 0.5));
                net[start + r * self.step] = line[0];
            }
            self.store(upper, start, line);
        }
    }
}

#[inline(always)]
fn mix<const L: usize>(from: [f64; L], to: [f64; L], share: f64) -> [f64; L] {
    std::array::from_fn(|lane| from[lane] + (to[lane] - from[lane]) * share)
}

/// The lesser of two numbers.
pub(crate) fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
pub(crate) fn more(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
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
    fn halves_of_a_net_are_what_it_is_restricted_to() {
        let net: Vec<[f64; 1]> = (0..20).map(|k| [f64::from(k * k % 17)]).collect();
        for (rows, columns) in [(4, 5), (10, 2), (20, 1)] {
            for direction in [0, 1] {
                let (mut lower, mut upper, mut expected) =
                    (net.clone(), net.clone(), [net.clone(), net.clone()]);
                halve(&mut lower, &mut upper, rows, columns, direction);
                let mut at = [[0.0, 0.0], [1.0, 1.0]];
                at[1][direction] = 0.5;
                restrict(&mut expected[0], rows, columns, at[0], at[1]);
                at = [[0.0, 0.0], [1.0, 1.0]];
                at[0][direction] = 0.5;
                restrict(&mut expected[1], rows, columns, at[0], at[1]);
                for (half, expected) in [lower, upper].iter().flatten().zip(expected.iter().flatten()) {
                    assert!((half[0] - expected[0]).abs() < 1e-13, "{rows} {columns} {direction}");
                }
            }
        }
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
