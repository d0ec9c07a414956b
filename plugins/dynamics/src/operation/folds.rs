//! What a model does that a rope or sheet would not: folds within a span, bending that shrinks, mass that is not quite where the area is.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::shape::{Cell, Derivative, Location, Shape};
use loftsman_kernel::text::{figure, short};

use super::material::reach;
use crate::body::{Material, extent};
use crate::simulation::Simulation;

/// Curves of more pieces than this are not looked at.
const MOST: usize = 10_000;
/// Places more than twice the degree at which each span is looked at.
const MORE: usize = 6;
/// Where a curve that turns back has less than this share of its speed at rest it is pushed together there by what nothing within its span sees.
const SLOW: f64 = 0.25;
/// The place of the least speed is found by so many cuts in three.
const CUTS: usize = 60;
/// `bending` beyond this share of stiffness times the square of the length shortens what is curved, and so does any that draws what stays curved together by half of that or more.
const STRONG: f64 = 0.1;
const SHORTER: f64 = 2e-3;
/// What of a mass may be missing by more than this share is told.
const MISSING: f64 = 1e-7;
/// The centre of mass is off where it is so by more than this share of the size.
const OFF: f64 = 1e-4;

/// The first derivative of a curve at a share of a span.
fn tangent(shape: &dyn Shape, cell: &Cell, share: f64) -> Result<Vector, OperationError> {
    let Location::Curve(u) = cell.at([share, 0.0]) else { return Ok(Vector::zeros()) };
    Ok(shape.stencil(Location::Curve(u), Derivative::from(1))?.apply(shape.control_vertices()))
}

/// That a curve turns back within a small part of a span, by more than a right angle and where it is pushed together to less than a quarter of its length at rest: neither its
/// bending nor its stretch, summed up at a few places of each span, sees that as it is.
pub(super) fn folded(
    name: &str,
    simulation: &Simulation,
    body: usize,
) -> Result<Option<String>, OperationError> {
    let shape = simulation.shape(body)?;
    let Some(cells) = shape.cells().filter(|cells| shape.domain().len() == 1 && cells.count() <= MOST) else {
        return Ok(None);
    };
    let start = simulation.start_of(body)?;
    let Material { bending, rest, .. } = simulation.material(body)?;
    let (mut found, mut more) = (None::<(f64, f64)>, 0_usize);
    for cell in &cells.checked(shape)? {
        let count = 2 * cell.sides.first().map_or(1, |side| side.degree) + MORE;
        let share = |i: usize| i as f64 / count as f64;
        let inner: Vec<Vector> =
            (1..count).map(|i| tangent(shape, cell, share(i))).collect::<Result<_, _>>()?;
        let mut last = 0.0;
        for (i, pair) in inner.windows(3).enumerate() {
            // One that was found lies in the next window, too.
            if pair[0].dot(&pair[2]) >= 0.0 || share(i + 1) < last {
                continue;
            }
            let (mut low, mut high) = (share(i + 1), share(i + 3));
            for _ in 0..CUTS {
                let third = (high - low) / 3.0;
                let speeds = [low + third, high - third].map(|at| tangent(shape, cell, at).map(|t| t.norm()));
                let [a, b] = speeds;
                if a? < b? { high -= third } else { low += third }
            }
            let at = 0.5 * (low + high);
            let speeds = [tangent(shape, cell, at)?.norm(), tangent(start.as_ref(), cell, at)?.norm()];
            if speeds[0] > SLOW * rest * speeds[1] {
                continue;
            }
            last = share(i + 3);
            more += usize::from(found.is_some());
            if let Location::Curve(u) = cell.at([at, 0.0]) {
                found = found.or(Some((u, speeds[0] / (rest * speeds[1]))));
            }
        }
    }
    let Some((at, speed)) = found else { return Ok(None) };
    let others = if more > 0 { format!(" and at {more} more places") } else { String::new() };
    let advice = if bending > 0.0 {
        "`bending` does not see that as it is; give it more control vertices there (operation refine), or less `bending`"
    } else {
        "what is summed up of its stretch does not see that as it is; give it a degree more (operation elevate), more control vertices there (operation refine), or some `bending`"
    };
    Ok(Some(format!(
        "{name:?} turns back at {}{others}, within a span, where it is pushed together to {} % of its length at rest: {advice}",
        figure(at),
        short(100.0 * speed)
    )))
}

/// That a curve shrinks for its bending: the energy of bending counts second derivatives by the length at rest, which of what is shorter are smaller.
pub(super) fn shrunk(
    name: &str,
    simulation: &Simulation,
    body: usize,
) -> Result<Option<String>, OperationError> {
    let shape = simulation.shape(body)?;
    let Material { bending, stiffness, rest, .. } = simulation.material(body)?;
    if bending == 0.0 || shape.domain().len() != 1 {
        return Ok(None);
    }
    let length = rest * reach(simulation.start_of(body)?.as_ref())?;
    let shorter = 1.0 - reach(shape)? / length;
    if shorter <= SHORTER {
        return Ok(None);
    }
    let strength = bending / (stiffness * length * length);
    if strength > STRONG {
        return Ok(Some(format!(
            "{name:?} is {} % shorter than at rest, and its `bending` is {} times its `stiffness` times the square of its length: so strong bending shrinks what is curved \
             rather than straightening it; give more stiffness (for less than 0.1 times), or less bending",
            short(100.0 * shorter),
            short(strength)
        )));
    }
    // Bending falls as the square of the length: it draws with the force `2 E_b` a length.
    let drawn = 2.0 * simulation.energy_of_bending(body)? / (stiffness * reach(shape)?);
    // More than that is other forces' work.
    Ok((drawn > 0.5 * shorter).then(|| {
        format!(
            "{name:?} is {} % shorter than at rest: its `bending` draws it together, by about {} % (twice its energy over stiffness and length: it bends, or its control vertices are \
             unevenly spaced for its knots); give more stiffness, less bending, or a curve of degree 3 or more with evenly spaced control vertices (fit, fair)",
            short(100.0 * shorter),
            short(100.0 * drawn)
        )
    }))
}

/// That the mass of a body is not known to the last, and that of a surface is not quite where its area is.
pub(super) fn mass(name: &str, simulation: &Simulation, body: usize) -> Result<Vec<String>, OperationError> {
    let missing = simulation.missing_mass(body)?;
    let missing = (missing > MISSING).then(|| {
        format!(
            "the mass of {name:?} is summed up to {} of it: the shape is creased within its cells, where its parameters do not run along the crease",
            short(missing)
        )
    });
    Ok(missing.into_iter().chain(off_centre(name, simulation, body)?).collect())
}

fn off_centre(name: &str, simulation: &Simulation, body: usize) -> Result<Option<String>, OperationError> {
    let off = simulation.off_centre(body)?;
    let size = extent(simulation.start_of(body)?.control_vertices());
    Ok((off > OFF * size).then(|| {
        format!(
            "the mass of {name:?} is spread as the product of its two directions: all of it is there, but its centre lies {} from that of its area, {} % of its size",
            figure(off),
            short(100.0 * off / size)
        )
    }))
}
