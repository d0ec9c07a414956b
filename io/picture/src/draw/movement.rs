//! Arrows from each control vertex before to where it is now.

use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::{Direction, Space};
use loftsman_kernel::{Point, Vector};

use crate::draw::mark::arrow;
use crate::sheet::{Layer, Sample, Sheet};
use crate::stage::Stage;
use crate::stage::body::Body;
use crate::text;

/// The most arrows of an object.
const MOST: usize = 2000;

/// Draws the arrows of all objects that have changed; says where there are none, and why. Those too short to see are left out.
pub(crate) fn draw(sheet: &mut Sheet, stage: &Stage<'_>) {
    let color = sheet.theme.accent().mixed(sheet.theme.paper(), 0.25).hex();
    let mut out = String::new();
    for old in &stage.old {
        let Some(new) = stage.new.iter().find(|new| new.object.name() == old.object.name()) else { continue };
        let (Some(from), Some(to)) = (old.net(), new.net()) else { continue };
        let name = || text::clipped(new.object.name(), 30);
        if to.len() > MOST {
            sheet.caption.note(format!(
                "{}: no arrows, its {} control vertices are too many",
                name(),
                to.len()
            ));
            continue;
        }
        let refined = (from.len() != to.len()).then(|| refined(old, new, from));
        let from = match &refined {
            None => from,
            Some(Some(refined)) => refined,
            Some(None) => {
                let (before, now) = (from.len(), to.len());
                sheet.caption.note(format!(
                    "{}: no arrows, its {before} control vertices before are not refined to the {now} now",
                    name()
                ));
                continue;
            }
        };
        for (from, to) in from.iter().zip(to) {
            let (from, to) = (sheet.spot(from), sheet.spot(to));
            if (to[0] - from[0]).hypot(to[1] - from[1]) >= 0.25 {
                sheet.ink.segment(from, to, 4);
                out.push_str(&arrow(from, to, color.clone(), 0.22));
            }
        }
    }
    if !out.is_empty() {
        sheet.put(Layer::Nets, &out);
        sheet.caption.explain_once(Sample::Movement, "control vertex moved");
    }
}

/// The control vertices of the state before with the knots of the state now; `None` where its knots are not among them.
///
/// The way to the stage is affine, and knots are inserted by affine combinations: it does not matter which comes first.
fn refined(old: &Body<'_>, new: &Body<'_>, net: &[Vector]) -> Option<Vec<Vector>> {
    let staged = net.iter().map(|v| Point::from(*v)).collect();
    let (old, new) = (old.object.geometry().with_points(staged).ok()?, new.object.geometry());
    let (points, spaces) = match (&old, new) {
        (Geometry::Curve(old), Geometry::Curve(new)) => {
            let refined = old.insert_knots(&missing(old.space(), new.space())?).ok()?;
            (refined.points().to_vec(), refined.space() == new.space())
        }
        (Geometry::Surface(old), Geometry::Surface(new)) => {
            let mut refined = old.clone();
            for direction in [Direction::U, Direction::V] {
                let knots = missing(old.space(direction), new.space(direction))?;
                refined = refined.insert_knots(direction, &knots).ok()?;
            }
            let same = refined.u() == new.u() && refined.v() == new.v();
            (refined.points().to_vec(), same)
        }
        _ => return None,
    };
    spaces.then(|| points.iter().map(|p| p.coords).collect())
}

/// The knots within the domain that `old` lacks to be `new`; `None` where it is no question of knots alone.
fn missing(old: &Space, new: &Space) -> Option<Vec<f64>> {
    if (old.degree(), old.is_periodic(), old.domain()) != (new.degree(), new.is_periodic(), new.domain()) {
        return None;
    }
    let mut knots = Vec::new();
    let (_, end) = new.domain();
    for knot in new.breakpoints() {
        // The end of a period is its start again, and the ends of an open one do not gain knots.
        if knot == end {
            continue;
        }
        let more = new.multiplicity(knot).checked_sub(old.multiplicity(knot))?;
        knots.extend(std::iter::repeat_n(knot, more));
    }
    Some(knots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::scene::Object;
    use loftsman_kernel::spline::{Curve, Surface};

    fn body<'a>(object: &'a Object, turn: impl Fn(&Point) -> Vector) -> Body<'a> {
        let points = object.geometry().points().iter().map(turn).collect();
        Body::of(object, 0, None, points, |n| *n).unwrap()
    }

    /// What comes of knots inserted before the way to the stage and of the same after it.
    fn agrees(old: Geometry, new: Geometry) {
        let turn = |p: &Point| Vector::new(2.0 * p.y - p.z + 3.0, p.x - 1.0, 0.5 * p.z);
        let (old, new) = (Object::new("o", old), Object::new("o", new));
        let (before, now) = (body(&old, turn), body(&new, turn));
        let found = refined(&before, &now, before.net().unwrap()).unwrap();
        let expected = now.net().unwrap();
        assert_eq!(found.len(), expected.len());
        let worst = found.iter().zip(expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).amax()));
        assert!(worst < 1e-12, "{worst}");
    }

    #[test]
    fn the_shape_before_gets_the_knots_of_the_shape_now() {
        for degree in 1..=7 {
            for space in [
                Space::clamped_uniform(degree, degree + 4).unwrap(),
                Space::floating_uniform(degree, degree + 4).unwrap(),
                Space::periodic_uniform(degree, degree + 4).unwrap(),
            ] {
                let count = space.len();
                let points: Vec<_> =
                    (0..count).map(|k| Point::new(k as f64, (k as f64).sin(), (k * k % 7) as f64)).collect();
                let (a, b) = space.domain();
                let at = |t: f64| a + (b - a) * t;
                let more = vec![at(0.3137); degree];
                for weights in [None, Some((0..count).map(|k| 1.0 + 0.5 * (k as f64).cos()).collect())] {
                    let curve = Curve::build(space.clone(), points.clone(), weights).unwrap();
                    for knots in [&[at(0.1531)][..], &[at(0.5219), at(0.7717)], &more] {
                        agrees((&curve).into(), curve.insert_knots(knots).unwrap().into());
                    }
                }
                let grid = (0..count * count)
                    .map(|k| Point::new((k % count) as f64, (k / count) as f64, (k as f64).sin()))
                    .collect();
                let surface = Surface::new(space.clone(), space.clone(), grid).unwrap();
                let finer = surface.insert_knots(Direction::U, &[at(0.4113)]).unwrap();
                agrees(surface.into(), finer.insert_knots(Direction::V, &more[..1]).unwrap().into());
            }
        }
    }

    #[test]
    fn other_knots_are_not_refined() {
        let curve = |space: Space| {
            let points = (0..space.len()).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
            Object::new("o", Curve::new(space, points).unwrap().into())
        };
        let old = curve(Space::clamped(2, &[0.0, 1.0, 3.0]).unwrap());
        for space in [
            Space::clamped(2, &[0.0, 1.5, 2.0, 3.0]).unwrap(),
            Space::clamped(3, &[0.0, 1.0, 3.0]).unwrap(),
            Space::clamped(2, &[0.0, 1.0, 2.0, 4.0]).unwrap(),
        ] {
            let new = curve(space);
            let (before, now) = (body(&old, |p| p.coords), body(&new, |p| p.coords));
            assert_eq!(refined(&before, &now, before.net().unwrap()), None);
        }
    }
}
