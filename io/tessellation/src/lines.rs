//! Which parameter lines make the grid of a surface.

use loftsman_kernel::plugin::Fineness;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Error, Result};
use nalgebra::Vector4;

use crate::bezier::extraction;
use crate::bounds::{Bend, bend};
use crate::evaluate::Evaluator;
use crate::fineness::{Frame, Target, over_budget};
use crate::normals::unit_normal;

/// A stretch of one direction: within one span, divided evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) span: usize,
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) n: usize,
}

impl Stretch {
    /// The `k`-th of its `n + 1` parameters.
    pub(crate) fn at(&self, k: usize) -> f64 {
        if k == self.n { self.b } else { self.a + (self.b - self.a) * (k as f64 / self.n as f64) }
    }

    /// The same stretch in `parts` even parts, or as it is where doubles cannot divide it.
    fn split(self, parts: usize) -> Vec<Self> {
        let whole = Self { n: parts, ..self };
        let cuts: Vec<f64> = (0..=parts).map(|k| whole.at(k)).collect();
        if cuts.windows(2).any(|c| c[0] >= c[1]) {
            return vec![Self { n: 1, ..self }];
        }
        cuts.windows(2).map(|c| Self { a: c[0], b: c[1], n: 1, ..self }).collect()
    }
}

/// The stretches of both directions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lines {
    pub(crate) u: Vec<Stretch>,
    pub(crate) v: Vec<Stretch>,
}

/// A stretch that needs more lines than this is divided and bounded anew: the bounds of smaller patches are
/// sharper, and the lines follow the bend.
const EVEN: usize = 4;
/// How often stretches are divided before their number of lines is taken as it is.
const ROUNDS: usize = 12;
/// No more patches than this are bounded; beyond, bounds of larger patches are good enough.
const PATCHES: f64 = 1e6;

/// The lines that meet the target.
pub(crate) fn choose(
    surface: &Surface,
    frame: &Frame,
    target: &Target,
    fineness: &Fineness,
    budget: usize,
) -> Result<Lines> {
    let mut lines = Lines { u: spans(surface.u()), v: spans(surface.v()) };
    if surface.weights().is_some() {
        // The bounds of rational patches sharpen quickly when the patches get smaller.
        lines.u = lines.u.iter().flat_map(|s| s.split(4)).collect();
        lines.v = lines.v.iter().flat_map(|s| s.split(4)).collect();
    }
    let mut best: Option<(f64, Lines)> = None;
    for round in 0..=ROUNDS {
        let bends = bends(surface, frame, &lines);
        divide(&mut lines, &bends, target.chord);
        // Every round's lines meet the tolerance; rounding up may make finer stretches the worse choice.
        let cells = cells(&lines);
        if best.as_ref().is_none_or(|(least, _)| cells < *least) {
            best = Some((cells, lines.clone()));
        }
        // Halved, and halved again if need be, so that a loose first bound does not decide; very long ones in
        // larger steps.
        let parts = |n: usize| if n > EVEN { (n / 16).max(2) } else { 1 };
        let finer = |list: &[Stretch]| -> Vec<Stretch> {
            list.iter().flat_map(|s| if s.n > EVEN { s.split(parts(s.n)) } else { vec![*s] }).collect()
        };
        // Counted before they are made: a tolerance beyond reason must not cost memory before it is refused.
        let count = |list: &[Stretch]| list.iter().map(|s| parts(s.n) as f64).sum::<f64>();
        let (rows, columns) = (count(&lines.u), count(&lines.v));
        let unchanged = rows == lines.u.len() as f64 && columns == lines.v.len() as f64;
        if unchanged || round == ROUNDS || rows * columns > PATCHES {
            break;
        }
        let (u, v) = (finer(&lines.u), finer(&lines.v));
        lines = Lines { u, v };
    }
    let mut lines = best.map_or(lines, |(_, lines)| lines);
    within(&lines, fineness, budget)?;
    turn_slowly(surface, frame, &mut lines, target.angle, fineness, budget)?;
    Ok(lines)
}

fn spans(space: &Space) -> Vec<Stretch> {
    let flat = space.flat();
    space.spans().map(|span| Stretch { span, a: flat[span], b: flat[span + 1], n: 1 }).collect()
}

fn cells(lines: &Lines) -> f64 {
    let sum = |list: &[Stretch]| list.iter().map(|s| s.n as f64).sum::<f64>();
    sum(&lines.u) * sum(&lines.v)
}

/// Refuses lines whose cells are more than the budget.
fn within(lines: &Lines, fineness: &Fineness, budget: usize) -> Result<()> {
    let triangles = 2.0 * cells(lines);
    // The indices of a mesh are 32 bits wide.
    if triangles > budget as f64 || triangles > f64::from(u32::MAX) {
        return Err(over_budget(fineness, triangles, "triangles", budget));
    }
    Ok(())
}

/// Bounds on the second derivatives of every patch (stretch of `u` × stretch of `v`), row after row.
fn bends(surface: &Surface, frame: &Frame, lines: &Lines) -> Vec<Bend> {
    let (u, v) = (surface.u(), surface.v());
    let (p, q) = (u.degree(), v.degree());
    let columns = v.unrolled_len();
    let rational = surface.weights().is_some();
    let mut along_v: Vec<Vec<[f64; MAX_ORDER]>> = Vec::with_capacity(lines.v.len());
    for s in &lines.v {
        let mut rows = Vec::new();
        extraction(v, s.span, s.a, s.b, &mut rows);
        along_v.push(rows);
    }
    let mut rows = Vec::new();
    let mut strip = vec![Vector4::zeros(); (p + 1) * columns];
    let mut net = vec![Vector4::zeros(); (p + 1) * (q + 1)];
    let mut out = Vec::with_capacity(lines.u.len() * lines.v.len());
    for s in &lines.u {
        extraction(u, s.span, s.a, s.b, &mut rows);
        strip.fill(Vector4::zeros());
        for i in 0..=p {
            let row = u.vertex(s.span - p + i) * v.len();
            for column in 0..columns {
                let h = homogeneous(surface, frame, row + v.vertex(column));
                for (r, shares) in rows.iter().enumerate() {
                    strip[r * columns + column] += h * shares[i];
                }
            }
        }
        for (t, shares) in lines.v.iter().zip(&along_v) {
            for r in 0..=p {
                let row = &strip[r * columns + t.span - q..=r * columns + t.span];
                for (c, share) in shares.iter().enumerate() {
                    net[r * (q + 1) + c] =
                        row.iter().zip(share).fold(Vector4::zeros(), |sum, (h, f)| sum + h * *f);
                }
            }
            out.push(bend(&net, p + 1, q + 1, rational));
        }
    }
    out
}

fn homogeneous(surface: &Surface, frame: &Frame, vertex: usize) -> Vector4<f64> {
    let weight = surface.weights().map_or(1.0, |w| w[vertex]);
    let local = (surface.points()[vertex] - frame.centre) / frame.size;
    (local * weight).push(weight)
}

/// Sets every stretch's `n` so that each cell meets the chord tolerance:
/// `(M_uu / n_u² + 2 M_uv / (n_u n_v) + M_vv / n_v²) / 8 ≤ tol`.
///
/// The twist is shared out by `2 M_uv / (n_u n_v) ≤ M_uv (κ / n_u² + 1 / (κ n_v²))`, and the tolerance between
/// both directions by `θ`; of a fixed list of `κ` and `θ` the pair that needs the fewest cells is taken.
fn divide(lines: &mut Lines, bends: &[Bend], tolerance: f64) {
    let columns = lines.v.len();
    let mut best: Option<(f64, f64, f64)> = None;
    let counts = |kappa: f64, theta: f64| {
        let (mut u, mut v) = (vec![0.0_f64; lines.u.len()], vec![0.0_f64; columns]);
        for (index, m) in bends.iter().enumerate() {
            let (i, j) = (index / columns, index % columns);
            u[i] = u[i].max(m.uu + kappa * m.uv);
            v[j] = v[j].max(m.vv + m.uv / kappa);
        }
        let need = |m: &f64, share: f64| (m / (8.0 * share * tolerance)).sqrt().ceil().max(1.0);
        let u: Vec<f64> = u.iter().map(|m| need(m, theta)).collect();
        let v: Vec<f64> = v.iter().map(|m| need(m, 1.0 - theta)).collect();
        (u, v)
    };
    for kappa in [0.0625, 0.25, 0.5, 1.0, 2.0, 4.0, 16.0] {
        for theta in [0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99] {
            let (u, v) = counts(kappa, theta);
            let cells = u.iter().sum::<f64>() * v.iter().sum::<f64>();
            if best.is_none_or(|(least, ..)| cells < least) {
                best = Some((cells, kappa, theta));
            }
        }
    }
    let Some((_, kappa, theta)) = best else { return };
    let (u, v) = counts(kappa, theta);
    // A number too large for the budget anyway must only stay too large.
    let whole = |n: f64| n.min(1e15) as usize;
    lines.u.iter_mut().zip(u).for_each(|(s, n)| s.n = whole(n));
    lines.v.iter_mut().zip(v).for_each(|(s, n)| s.n = whole(n));
}

/// Adds lines until the normals at neighbouring vertices differ by no more than `angle`, measured there.
fn turn_slowly(
    surface: &Surface,
    frame: &Frame,
    lines: &mut Lines,
    angle: f64,
    fineness: &Fineness,
    budget: usize,
) -> Result<()> {
    let evaluator = Evaluator::new(surface, frame);
    for _ in 0..4 {
        let (mut grow_u, mut grow_v) = (vec![1.0_f64; lines.u.len()], vec![1.0_f64; lines.v.len()]);
        // The turn over a step shrinks with it.
        let more = |turn: f64| turn / angle * (1.0 - 1e-9);
        let mut row = evaluator.row();
        let mut current = Vec::new();
        let mut before: Vec<Option<loftsman_kernel::Vector>> = Vec::new();
        for (i, s) in lines.u.iter().enumerate() {
            for k in 0..=s.n {
                evaluator.prepare(s.span, s.at(k), &mut row);
                current.clear();
                for (j, t) in lines.v.iter().enumerate() {
                    let mut last = None;
                    for l in 0..=t.n {
                        let normal = unit_normal(&evaluator.at(&row, t.span, t.at(l)));
                        if let (true, Some(a), Some(b)) = (l > 0, last, normal) {
                            let a: loftsman_kernel::Vector = a;
                            grow_v[j] = grow_v[j].max(more(a.angle(&b)));
                        }
                        last = normal;
                        current.push(normal);
                    }
                }
                if k > 0 {
                    let turns = before.iter().zip(&current).filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
                    for (a, b) in turns {
                        grow_u[i] = grow_u[i].max(more(a.angle(b)));
                    }
                }
                std::mem::swap(&mut before, &mut current);
            }
        }
        let mut changed = false;
        for (s, factor) in lines.u.iter_mut().zip(grow_u).chain(lines.v.iter_mut().zip(grow_v)) {
            if factor > 1.0 {
                s.n = (s.n as f64 * factor).ceil().min(1e15) as usize;
                changed = true;
            }
        }
        within(lines, fineness, budget)?;
        if !changed {
            return Ok(());
        }
    }
    Ok(())
}

/// The error for a surface whose grid could not be numbered.
pub(crate) fn too_many(points: usize) -> Error {
    Error::Invalid(format!("a mesh of {points} points is too large: choose a coarser tolerance"))
}
