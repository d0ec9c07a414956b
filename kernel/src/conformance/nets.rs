//! What a shape promises of the nets of its cells.

use super::shape::some;
use super::{Lcg, Verdict};
use crate::Vector;
use crate::error::Result;
use crate::shape::{Cell, CellNet, CellSide, Cells, Derivative, Shape};

/// A net that was said, kept.
struct Kept {
    number: usize,
    face: Option<u32>,
    sides: [CellSide; 2],
    points: Vec<Vector>,
}

/// Where nets are said, each number that has a cell has one, in order and alike whatever the range; its face and sides are the cell's, and it is
/// the Bézier patch that the shape's stencils are there, taken from the origin.
pub(super) fn nets(
    verdict: &mut Verdict,
    shape: &dyn Shape,
    cells: &dyn Cells,
    random: &mut Lcg,
) -> Option<()> {
    let all = shape.control_vertices();
    let origin = all.first().copied().unwrap_or_default();
    let size = all.iter().map(|p| (p - origin).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let mut said = Vec::new();
    let mut each = |net: CellNet<'_>| {
        let CellNet { number, face, sides, points } = net;
        said.push(Kept { number, face, sides, points: points.to_vec() });
    };
    // The last one with a few numbers that are none.
    let Some(made) = cells.nets(0..cells.count() + 3, &origin, &mut each) else {
        return Some(());
    };
    verdict.take(made, |e| format!("its cells have no nets: {e}"))?;
    let numbers: Vec<usize> = (0..cells.count()).filter(|&k| cells.cell(k).is_some()).collect();
    verdict.check(said.iter().map(|net| net.number).eq(numbers), || {
        "it says not one net for each of its cells, in their order".into()
    });
    for net in some(said) {
        let Some(cell) = cells.cell(net.number) else { continue };
        let number = net.number;
        let like = cell.face == net.face && cell.sides[..] == net.sides && !cell.rational;
        let [p, q] = net.sides.map(|side| side.degree);
        verdict.check(like && net.points.len() == (p + 1) * (q + 1), || {
            format!(
                "the net of cell {number} has the sides {:?} and {} points, and the cell is {cell:?}",
                net.sides,
                net.points.len()
            )
        });
        let mut again = Vec::new();
        let made = cells.nets(number..number + 1, &origin, &mut |net| again.extend_from_slice(net.points));
        verdict.check(made.is_some_and(|made| made.is_ok()) && again == net.points, || {
            format!("the net of cell {number} is another when it is asked for by itself")
        });
        for _ in 0..3 {
            let shares = [0.5 + 0.5 * random.next(), 0.5 + 0.5 * random.next()];
            let there = verdict
                .take(from(shape, &cell, shares, &origin), |e| format!("no point in {cell:?}: {e}"))?;
            let off = (value(&net.points, [p, q], shares) - there).norm() / size;
            verdict.check(off <= 1e-10, || {
                format!("the net of cell {number} is not the shape there: {off:.1e} of its size off")
            });
        }
    }
    Some(())
}

/// A point of a shape, from an origin.
fn from(shape: &dyn Shape, cell: &Cell, shares: [f64; 2], origin: &crate::Point) -> Result<Vector> {
    let row = shape.stencil(cell.at(shares), Derivative::POSITION)?;
    Ok(row.iter().map(|(v, c)| (shape.control_vertices()[v] - origin) * c).sum())
}

/// A point of a Bézier patch, by de Casteljau.
fn value(net: &[Vector], [p, q]: [usize; 2], [u, v]: [f64; 2]) -> Vector {
    let mut points = net.to_vec();
    let mut line = |from: usize, step: usize, degree: usize, t: f64| {
        for level in (0..degree).rev() {
            for k in 0..=level {
                let [at, next] = [from + k * step, from + (k + 1) * step];
                points[at] = points[at] * (1.0 - t) + points[next] * t;
            }
        }
    };
    (0..=p).for_each(|i| line(i * (q + 1), 1, q, v));
    line(0, q + 1, p, u);
    points.first().copied().unwrap_or_default()
}
