//! Surfaces evaluated by the book, sharing nothing with the kernel: the recurrence of Cox and de Boor as it is written, and the
//! quotient rule.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Space, Surface};

/// `N_i,d(u)` at `[d][i]` for all degrees up to `p`, the last span closed at its end.
fn table(t: &[f64], p: usize, u: f64, end: f64) -> Vec<Vec<f64>> {
    let inside = |i: usize| if u == end { t[i] < end && t[i + 1] == end } else { t[i] <= u && u < t[i + 1] };
    let mut table = vec![(0..t.len() - 1).map(|i| f64::from(u8::from(inside(i)))).collect::<Vec<_>>()];
    for d in 1..=p {
        let lower = &table[d - 1];
        let part =
            |above: f64, below: f64, n: f64| if below == 0.0 || n == 0.0 { 0.0 } else { above / below * n };
        let raised = (0..t.len() - 1 - d).map(|i| {
            part(u - t[i], t[i + d] - t[i], lower[i])
                + part(t[i + d + 1] - u, t[i + d + 1] - t[i + 1], lower[i + 1])
        });
        table.push(raised.collect());
    }
    table
}

fn derivative(t: &[f64], table: &[Vec<f64>], i: usize, p: usize, order: usize) -> f64 {
    if order == 0 {
        return table[p][i];
    }
    if p == 0 {
        return 0.0;
    }
    let part = |i: usize| {
        let width = t[i + p] - t[i];
        if width == 0.0 { 0.0 } else { p as f64 / width * derivative(t, table, i, p - 1, order - 1) }
    };
    part(i) - part(i + 1)
}

/// Every basis function's derivative at `u`, summed for each control vertex.
pub(crate) fn row(space: &Space, u: f64, order: usize) -> Vec<f64> {
    let (p, n) = (space.degree(), space.len());
    let mut row = vec![0.0; n];
    if !space.is_periodic() {
        let t = space.knots();
        let table = table(t, p, u, t[n]);
        for (i, r) in row.iter_mut().enumerate() {
            *r = derivative(t, &table, i, p, order);
        }
        return row;
    }
    let knots = space.knots();
    let period = knots[n] - knots[0];
    let u = if u == knots[n] { knots[0] } else { u };
    let knot = |k: isize| knots[k.rem_euclid(n as isize) as usize] + period * k.div_euclid(n as isize) as f64;
    let t: Vec<f64> = (-(p as isize)..=(n + p) as isize).map(knot).collect();
    let table = table(&t, p, u, f64::NAN);
    for i in 0..n + p {
        row[(i + n * p - p) % n] += derivative(&t, &table, i, p, order);
    }
    row
}

/// Derivatives of orders `0 ..= most` across an edge, at the parameter `t` along it.
pub(crate) fn across(surface: &Surface, edge: &str, t: f64, most: usize) -> Vec<Vector> {
    let (along, over) =
        if edge.starts_with('u') { (surface.v(), surface.u()) } else { (surface.u(), surface.v()) };
    let (start, end) = over.domain();
    let fixed = if edge.ends_with('1') { end } else { start };
    let here = row(along, t, 0);
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for k in 0..=most {
        let (mut a, mut w) = (Vector::zeros(), 0.0);
        for (i, c) in row(over, fixed, k).into_iter().enumerate() {
            for (j, n) in here.iter().enumerate().filter(|_| c != 0.0) {
                let at = if edge.starts_with('u') { i * along.len() + j } else { j * over.len() + i };
                let weight = surface.weights().map_or(1.0, |w| w[at]);
                a += surface.points()[at].coords * (c * n * weight);
                w += c * n * weight;
            }
        }
        above.push(a);
        below.push(if surface.weights().is_none() { f64::from(u8::from(k == 0)) } else { w });
    }
    let mut found: Vec<Vector> = Vec::new();
    for k in 0..=most {
        let choose = |j: usize| [1.0, if k == 2 && j == 1 { 2.0 } else { 1.0 }][usize::from(j > 0)];
        let lower = (1..=k).fold(Vector::zeros(), |sum, j| sum + found[k - j] * (choose(j) * below[j]));
        found.push((above[k] - lower) / below[0]);
    }
    found
}

/// How large the numbers are that a derivative across an edge is a sum of.
pub(crate) fn size(surface: &Surface, edge: &str, order: usize) -> f64 {
    let over = if edge.starts_with('u') { surface.u() } else { surface.v() };
    let (start, end) = over.domain();
    let fixed = if edge.ends_with('1') { end } else { start };
    let largest = surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    largest * row(over, fixed, order).iter().map(|c| c.abs()).sum::<f64>()
}
