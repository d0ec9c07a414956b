//! What a shape promises of the holes that its cells leave.

use super::Verdict;
use super::shape::{apart, some};
use crate::error::Result;
use crate::shape::{Border, Cells, Derivative, Hole, Shape, Stencil};
use crate::spline::gram::gauss_legendre;

/// With the holes, where any are said, the cells cover the domain; each has a position at its apex, borders that follow one another
/// counterclockwise round it, and along each the shape is a polynomial of its degree. `whole` and `covered` are the sizes of the domain and
/// of the cells.
pub(super) fn holes(
    verdict: &mut Verdict,
    shape: &dyn Shape,
    cells: &dyn Cells,
    [whole, covered]: [f64; 2],
) -> Option<()> {
    let all = cells.holes();
    if all.is_empty() {
        return Some(());
    }
    let left: f64 = all.iter().map(Hole::size).sum();
    verdict.check((covered + left - whole).abs() <= 1e-9 * whole, || {
        format!("its cells have {covered} of parameters and the holes in them {left}, and its domain {whole}")
    });
    for hole in some(all) {
        let apex = shape.stencil(hole.at(hole.apex), Derivative::POSITION);
        verdict.take(apex, |e| format!("no point at the apex of {hole:?}: {e}"))?;
        verdict.check(hole.border.windows(2).all(|pair| pair[0].to == pair[1].from), || {
            format!("the border of {hole:?} is no chain")
        });
        let leans = |b: &Border| Hole { border: vec![*b], ..hole.clone() }.size() < 0.0;
        verdict.check(!hole.border.iter().any(leans), || {
            format!("the border of {hole:?} is not counterclockwise round its apex")
        });
        for border in &hole.border {
            let off = verdict
                .take(beyond(shape, &hole, border), |e| format!("no point on the border of {hole:?}: {e}"))?;
            verdict.check(off <= 1e-8, || {
                format!("along {border:?} of {hole:?} it is no polynomial of that degree: {off:.1e} off")
            });
        }
    }
    Some(())
}

/// By how much stencils along a border differ from the polynomials of its degree through as many as determine them.
fn beyond(shape: &dyn Shape, hole: &Hole, border: &Border) -> Result<f64> {
    let at = |t: f64| shape.stencil(hole.at(border.at(t)), Derivative::POSITION);
    let (nodes, _) = gauss_legendre(border.degree + 1);
    let mut worst = 0.0_f64;
    for x in [0.07, 0.31, 0.77] {
        let mut sum = Stencil::new();
        for (k, node) in nodes.iter().enumerate() {
            let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
            let weight: f64 = others.map(|(_, other)| (x - other) / (node - other)).product();
            at(*node)?.iter().for_each(|(v, c)| sum.add(v, c * weight));
        }
        worst = worst.max(apart(&at(x)?, &sum, 1.0));
    }
    Ok(worst)
}
