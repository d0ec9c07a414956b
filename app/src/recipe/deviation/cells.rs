//! Shapes that consist of cells, from place to place of the same parameters, which bounds how far one is from the other: where the nearest place is nobody
//! knows of them.

use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::{Cell, CellNet, CellSide, Cells, Derivative, Shape};
use loftsman_kernel::{Point, Vector};

use super::distance;

/// Where two are compared in each of their cells, as shares of its sides.
const IN_CELLS: [f64; 3] = [0.0, 0.5, 1.0];
/// The most places, where they are evaluated by stencils, and by nets of points, which cost a tenth and less.
const BY_STENCILS: usize = 200_000;
const BY_NETS: usize = 2_000_000;
/// Cells of which the nets are kept at a time.
const RUN: usize = 512;

/// The largest distance between places of the same parameters: of every cell its corners, the middles of its sides and its own. `None` where the cells are not the
/// same, or there are very many.
pub(super) fn of_shapes(before: &dyn Shape, after: &dyn Shape) -> Option<f64> {
    let (old, new) = (before.cells()?, after.cells()?);
    if old.count() != new.count() {
        return None;
    }
    let places = new.count().saturating_mul(IN_CELLS.len().pow(2));
    let origin = before.control_vertices().first().copied().unwrap_or_default();
    let says_nets = |cells: &dyn Cells| cells.nets(0..0, &origin, &mut |_| {}).is_some();
    if says_nets(old) && says_nets(new) {
        return (places <= BY_NETS).then(|| by_nets(old, new, &origin))?;
    }
    (places <= BY_STENCILS).then(|| by_stencils(before, after))?
}

fn by_stencils(before: &dyn Shape, after: &dyn Shape) -> Option<f64> {
    let (old, new) = (before.cells()?, after.cells()?);
    let mut most = 0.0_f64;
    for index in 0..new.count() {
        let (Some(was), Some(cell)) = (old.cell(index), new.cell(index)) else { continue };
        if (was.face, was.sides.len()) != (cell.face, cell.sides.len()) {
            return None;
        }
        for u in IN_CELLS {
            for v in IN_CELLS {
                let place = |shape: &dyn Shape, cell: &Cell| {
                    Shapes::one(shape).value(0, cell.at([u, v]), Derivative::default()).ok()
                };
                let (a, b) = (place(before, &was)?, place(after, &cell)?);
                most = most.max(distance(&a.into(), &b.into()));
            }
        }
    }
    Some(most).filter(|most| most.is_finite())
}

fn by_nets(old: &dyn Cells, new: &dyn Cells, origin: &Point) -> Option<f64> {
    let mut most = 0.0_f64;
    for start in (0..new.count()).step_by(RUN) {
        let numbers = start..new.count().min(start + RUN);
        let mut were = Vec::with_capacity(numbers.len());
        old.nets(numbers.clone(), origin, &mut |net| were.push((net.number, net.face, places(&net))))?
            .ok()?;
        let (mut were, mut alike) = (were.into_iter(), true);
        let compare = &mut |net: CellNet<'_>| match were.next() {
            Some((number, face, was)) if (number, face) == (net.number, net.face) => {
                let ways = was.into_iter().zip(places(&net));
                most = ways.fold(most, |most, (a, b)| most.max(distance(&a.into(), &b.into())));
            }
            _ => alike = false,
        };
        new.nets(numbers, origin, compare)?.ok()?;
        if !alike || were.next().is_some() {
            return None;
        }
    }
    Some(most).filter(|most| most.is_finite())
}

/// The points at the nine places, from Bézier points.
fn places(net: &CellNet<'_>) -> [Vector; 9] {
    let middle = |points: &mut Vec<Vector>| {
        while points.len() > 1 {
            *points = points.windows(2).map(|pair| (pair[0] + pair[1]) * 0.5).collect();
        }
        points.first().copied().unwrap_or_default()
    };
    let [rows, columns] = net.sides.map(|CellSide { degree, .. }| degree + 1);
    let at = |i: usize, j: usize| net.points.get(i * columns + j).copied().unwrap_or_default();
    // Of each row its first point, its middle and its last; then of these the same across.
    let across: [Vec<Vector>; 3] = std::array::from_fn(|k| {
        let one = |i: usize| match k {
            0 => at(i, 0),
            1 => middle(&mut (0..columns).map(|j| at(i, j)).collect()),
            _ => at(i, columns - 1),
        };
        (0..rows).map(one).collect()
    });
    std::array::from_fn(|k| match (k / 3, &across[k % 3]) {
        (0, line) => line[0],
        (1, line) => middle(&mut line.clone()),
        (_, line) => line[rows - 1],
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_subdivision::doo_sabin::DooSabinSurface;
    use loftsman_subdivision::{Cage, SubdivisionSurface};

    use super::*;

    /// A prism of three rings of so many points, some of which are pulled out.
    fn prism(sides: usize, pull: f64) -> Cage {
        let at = |k: usize| {
            let angle = std::f64::consts::TAU * (k % sides) as f64 / sides as f64;
            let out = 1.0 + if k.is_multiple_of(5) { pull } else { 0.0 };
            Point::new(out * angle.cos(), out * angle.sin(), (k / sides) as f64)
        };
        let ring = |from: usize| (from..from + sides).collect::<Vec<usize>>();
        let mut faces = vec![ring(0).into_iter().rev().collect(), ring(2 * sides)];
        for k in 0..2 * sides {
            let next = k - k % sides + (k + 1) % sides;
            faces.push(vec![k, next, next + sides, k + sides]);
        }
        Cage::new((0..3 * sides).map(at).collect(), &faces).unwrap()
    }

    /// What nets say is what stencils say, of both schemes and faces of few and many corners.
    #[test]
    fn nets_say_what_stencils_say() {
        for (sides, pull) in [(3, 0.5), (4, -0.25), (7, 1e-6), (24, 10.0)] {
            let [before, after] = [0.0, pull].map(|pull| prism(sides, pull));
            let smooth = [&before, &after].map(|cage| SubdivisionSurface::new(cage.clone()).unwrap());
            let dual = [&before, &after].map(|cage| DooSabinSurface::new(cage.clone()).unwrap());
            let pairs: [[&dyn Shape; 2]; 2] = [[&smooth[0], &smooth[1]], [&dual[0], &dual[1]]];
            for [before, after] in pairs {
                let [nets, stencils] =
                    [of_shapes(before, after), by_stencils(before, after)].map(Option::unwrap);
                assert!(
                    nets > 0.1 * pull.abs() && (nets - stencils).abs() <= 1e-13 * sides as f64,
                    "{sides}: {nets} {stencils}"
                );
                assert_eq!(of_shapes(before, before), Some(0.0));
            }
            assert_eq!(of_shapes(&smooth[0], &dual[0]), None);
        }
    }
}
