//! Whether an area is one, or what rounding makes of none.

use loftsman_kernel::Point;
use loftsman_kernel::shape::{Cell, Derivative, Share};
use loftsman_kernel::text::short;

use crate::members::Member;

/// Times the sizes of the surface and of the box of its control vertices: an area below that is what rounding of these may make of none.
const NOTHING: f64 = 1e3 * f64::EPSILON;

/// The shares of each side of a cell at which the surface is looked at.
const SHARES: [f64; 4] = [0.0, 0.3, 0.7, 1.0];

/// What there is of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Left {
    /// More than rounding can be.
    Area,
    /// Nothing: a line or a point, to rounding.
    Nothing,
    /// As much as rounding, for the control vertices are so many times as far apart as the surface is large.
    Rounding(f64),
}

impl Left {
    /// Of an area that was measured. A surface of the size `s` whose control vertices are `S` apart is known to about `ε S`, and its area to `ε S s`.
    pub(super) fn of(area: f64, surface: &Member<'_>, counted: &[(Cell, Share)]) -> Self {
        // Most are more than that, and nothing else is looked at.
        let all = longest(surface.points().iter().copied());
        if area > NOTHING * all * all {
            return Self::Area;
        }
        let far = extent(surface, counted);
        if area <= NOTHING * far * far {
            let size = seen(surface, counted);
            if area <= NOTHING * size * size || size == 0.0 {
                return Self::Nothing;
            }
            if area <= NOTHING * far * size {
                return Self::Rounding(far / size);
            }
        }
        Self::Area
    }
}

/// Why an area cannot be told where rounding is as much, and what to do.
pub(super) fn too_far(times: f64) -> String {
    format!(
        "its control vertices are {} times as far apart as it is large, so that their rounding is as much as its area; move them less far, or make its knots more even",
        short(times)
    )
}

fn cells<'a>(surface: &'a Member<'_>, counted: &'a [(Cell, Share)]) -> Box<dyn Iterator<Item = Cell> + 'a> {
    if counted.is_empty() {
        Box::new(surface.cells.iter())
    } else {
        Box::new(counted.iter().map(|(cell, _)| cell.clone()))
    }
}

/// The longest side of the box of the vertices that act in a surface's domain.
fn extent(surface: &Member<'_>, counted: &[(Cell, Share)]) -> f64 {
    let vertices = cells(surface, counted).flat_map(|cell| cell.vertices);
    longest(vertices.filter_map(|v| surface.points().get(v).copied()))
}

/// The longest side of the box of some points of the surface, of each cell.
fn seen(surface: &Member<'_>, counted: &[(Cell, Share)]) -> f64 {
    let places = cells(surface, counted).flat_map(|cell| {
        SHARES
            .into_iter()
            .flat_map(move |u| SHARES.map(|v| [u, v]))
            .map(move |at| cell.at(at))
            .collect::<Vec<_>>()
    });
    longest(places.filter_map(|at| Some(Point::from(surface.shape.value(at, Derivative::POSITION).ok()?))))
}

fn longest(points: impl Iterator<Item = Point>) -> f64 {
    let empty = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    let (low, high) = points.fold(empty, |(low, high), p| (low.inf(&p), high.sup(&p)));
    (high - low).amax()
}
