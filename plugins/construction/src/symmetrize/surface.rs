//! Surfaces made symmetric: as all curves along them, or from one half.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::spline::{Curve, Direction, Surface};

use super::{
    CLOSED, Half, IN_PLANE, Mirror, SAMPLES, Symmetric, averaged, corners, crossing, crossings, missing,
    start, symmetric_space,
};
use crate::fields::{figure, long};

/// A surface made symmetric about a plane, run backwards in a direction in the mirror: with `Half::Both` the mean of itself and its
/// mirror image, as [`symmetrize`](super::symmetrize()) of all curves along it (begun, where it is closed, where the one in its middle is begun best); else one half and its mirror image. A half ends where the surface cuts the
/// plane along a line of that parameter, exactly, or it is all of a surface that begins or ends there.
///
/// # Errors
/// When half of what is periodic in the direction is asked for: it has no place to begin at. When half of the surface is asked for and it meets the plane along no line
/// of the parameter, or along several.
pub fn symmetrize_surface(
    surface: &Surface,
    mirror: &Mirror,
    direction: Direction,
    half: Half,
) -> Result<Symmetric<Surface>> {
    if half != Half::Both {
        has_side(surface, mirror, half)?;
    }
    let is_periodic = surface.space(direction).is_periodic();
    if is_periodic && half != Half::Both {
        let name = if direction == Direction::U { "u" } else { "v" };
        return Err(Error::Invalid(format!(
            "the surface is periodic in {name} and has no ends there, one of which a half could begin at: split it in {name}, which opens it, where the plane cuts it, or take the mean of both halves"
        )));
    }
    let open = surface.convert(direction, &surface.space(direction).clamping()?)?;
    let open = match half {
        Half::Both => start::begun(&open, mirror, direction)?,
        Half::Front => return halved(&open, mirror, direction, 1.0),
        Half::Back => return halved(&open, mirror, direction, -1.0),
    };
    let common = symmetric_space(open.space(direction))?;
    let fine = open.insert_knots(direction, &missing(open.space(direction), &common))?;
    let image = fine.reverse(direction)?;
    let image_points: Vec<Point> = image.points().iter().map(|p| mirror.image(p)).collect();
    let (points, weights, moved) =
        averaged((fine.points(), fine.weights()), (&image_points, image.weights()));
    let shape = Surface::build(
        if direction == Direction::U { common.clone() } else { fine.u().clone() },
        if direction == Direction::V { common } else { fine.v().clone() },
        points,
        weights,
    )?;
    let (first, last) = ends(&fine, direction);
    let reach = fine.points().iter().map(|p| long(&(p - fine.points()[0]))).fold(0.0, f64::max);
    let closed = first.zip(last).all(|(p, q)| long(&(p - q)) <= CLOSED * reach);
    let corners = corners::of_surface(&shape, &fine, direction, closed)?;
    if !is_periodic {
        return Ok(Symmetric { shape, moved: Some(moved), corners });
    }
    let size = shape.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let shape = shape.to_periodic(direction, 1e-14 * size)?.shape;
    Ok(Symmetric { shape, moved: Some(moved), corners })
}

/// [`symmetrize_surface`] in the direction, one of those that can be, in which less of it moves; of a half, the first that the plane cuts rightly.
///
/// # Errors
/// As for [`symmetrize_surface`], where neither direction can be: what is wrong with the first.
pub fn symmetrize_surface_best(
    surface: &Surface,
    mirror: &Mirror,
    half: Half,
) -> Result<(Symmetric<Surface>, Direction)> {
    let [u, v] = [Direction::U, Direction::V].map(|way| symmetrize_surface(surface, mirror, way, half));
    match (u, v) {
        (Ok(u), Ok(v)) if v.moved < u.moved => Ok((v, Direction::V)),
        (Ok(u), _) => Ok((u, Direction::U)),
        (Err(_), Ok(v)) => Ok((v, Direction::V)),
        (Err(error), Err(_)) => Err(error),
    }
}

/// The first and the last points of the net in a direction.
fn ends(
    surface: &Surface,
    direction: Direction,
) -> (impl Iterator<Item = &Point>, impl Iterator<Item = &Point>) {
    let (rows, columns) = (surface.u().len(), surface.v().len());
    let (last, step, count) = match direction {
        Direction::U => ((rows - 1) * columns, 1, columns),
        Direction::V => (columns - 1, columns, rows),
    };
    let points = surface.points();
    (points.iter().step_by(step).take(count), points[last..].iter().step_by(step).take(count))
}

/// An error where nothing of a surface is on the side that is kept: whatever the direction.
fn has_side(surface: &Surface, mirror: &Mirror, half: Half) -> Result<()> {
    let side = if half == Half::Front { 1.0 } else { -1.0 };
    let points = surface.points();
    let reach = points.iter().map(|p| long(&(p - points[0]))).fold(0.0, f64::max);
    if points.iter().any(|p| mirror.height(p) * side > IN_PLANE * reach) {
        Ok(())
    } else {
        Err(nothing(side))
    }
}

fn nothing(side: f64) -> Error {
    let side = if side > 0.0 { "in front of" } else { "behind" };
    Error::Invalid(format!("nothing of the surface is {side} the plane: keep the other half"))
}

/// The half of a surface on one side of the plane (that of the normal where `side` is 1), and its mirror image.
fn halved(open: &Surface, mirror: &Mirror, direction: Direction, side: f64) -> Result<Symmetric<Surface>> {
    let name = if direction == Direction::U { "u" } else { "v" };
    let reach = open.points().iter().map(|p| long(&(p - open.points()[0]))).fold(0.0, f64::max);
    let (cut, line) = plane_line(open, mirror, direction, name, IN_PLANE * reach)?;
    let (a, b) = open.space(direction).domain();
    let parts = if a < cut && cut < b { open.split(direction, cut)? } else { vec![open.clone()] };
    // How the original turns where it is cut.
    let was = match &parts[..] {
        [before, after] => corners::turns_along(before, after, direction)?,
        _ => Vec::new(),
    };
    let mut kept = None;
    for part in parts {
        let (c, d) = part.space(direction).domain();
        if mirror.height(&line.point(0.5 * c + 0.5 * d)?) * side > 0.0 {
            kept = Some(part);
        }
    }
    let kept = kept.ok_or_else(|| nothing(side))?;
    let (c, d) = kept.space(direction).domain();
    let begins_there = (c - cut).abs() < (d - cut).abs();
    // What is in the plane to rounding is in it.
    let (u, v, mut points, weights) = kept.into_parts();
    let (rows, columns) = (u.len(), v.len());
    let (count, others) = if direction == Direction::U { (rows, columns) } else { (columns, rows) };
    let at = if begins_there { 0 } else { count - 1 };
    for other in 0..others {
        let k = if direction == Direction::U { at * columns + other } else { other * columns + at };
        let height = mirror.height(&points[k]);
        points[k] -= mirror.normal * height;
    }
    let kept = Surface::build(u, v, points, weights)?;
    let (u, v, points, weights) = kept.reverse(direction)?.into_parts();
    let image = Surface::build(u, v, points.iter().map(|p| mirror.image(p)).collect(), weights)?;
    let largest = kept.points().iter().map(|p| p.coords.amax()).fold(reach, f64::max);
    let (first, second) = if begins_there { (&image, &kept) } else { (&kept, &image) };
    let corners = corners::along(first, second, direction, &was)?.into_iter().collect();
    let mut shape = first.join(direction, second, 1e-12 * largest)?.shape;
    // It begins at the parameter at which the surface began, as a curve does.
    let (begin, over) = shape.space(direction).domain();
    if begin != a {
        shape = shape.reparametrise(direction, a, a + (over - begin))?;
    }
    Ok(Symmetric { shape, moved: None, corners })
}

/// Where, of the other parameter, there is a line along the direction that meets the plane, among some. `O(n)` for each.
fn met_elsewhere(open: &Surface, mirror: &Mirror, direction: Direction, near: f64) -> Result<Option<f64>> {
    let space = open.space(direction.other());
    let (low, high) = space.domain();
    let places = SAMPLES * space.spans().count();
    for k in 0..=places {
        let at = (low + (high - low) * k as f64 / places as f64).min(high);
        let line = open.isocurve(direction.other(), at)?;
        let (a, b) = line.domain();
        let touches = |end: f64| -> Result<bool> { Ok(mirror.height(&line.point(end)?).abs() <= near) };
        if touches(a)? || touches(b)? || !crossings(&line, mirror)?.is_empty() {
            return Ok(Some(at));
        }
    }
    Ok(None)
}

/// Where a parameter's line lies in the plane, and the line of the other parameter on which that was looked for.
fn plane_line(
    open: &Surface,
    mirror: &Mirror,
    direction: Direction,
    name: &str,
    near: f64,
) -> Result<(f64, Curve)> {
    let (low, high) = open.space(direction.other()).domain();
    let line = open.isocurve(direction.other(), 0.5 * low + 0.5 * high)?;
    let (a, b) = line.domain();
    let mut cuts = Vec::new();
    for end in [a, b] {
        if mirror.height(&line.point(end)?).abs() <= near {
            cuts.push(end);
        }
    }
    let breaks = open.space(direction).breakpoints();
    let slack = IN_PLANE * (b - a);
    for at in crossings(&line, mirror)? {
        // A knot to rounding is the knot.
        let at = breaks.iter().copied().find(|k| (k - at).abs() <= slack).unwrap_or(at);
        if !cuts.contains(&at) {
            cuts.push(at);
        }
    }
    let [cut] = cuts[..] else {
        if cuts.is_empty()
            && let Some(at) = met_elsewhere(open, mirror, direction, near)?
        {
            let other = if direction == Direction::U { "v" } else { "u" };
            return Err(Error::Invalid(format!(
                "along {name} the surface meets the plane on a part of its lines only: on that at {other} = {} it does, on that at {other} = {} not; \
                 to keep one half, it is to meet it once on each: name the other direction, move the plane, or take the mean of both halves",
                figure(at),
                figure(0.5 * low + 0.5 * high)
            )));
        }
        let way_out = match cuts.len() {
            0 => "move the plane, or the surface",
            _ => "split it, and keep a part that meets the plane once, or take the mean of both halves",
        };
        return Err(Error::Invalid(format!(
            "along {name} the surface {}: to keep one half, it is to meet it once; {way_out}",
            crossing("meets the plane", cuts.len())
        )));
    };
    let across = open.isocurve(direction, cut)?;
    let (c, d) = across.domain();
    let mut worst = (0.0, Point::origin());
    for k in 0..=SAMPLES * across.space().spans().count() {
        let t = c + (d - c) * k as f64 / (SAMPLES * across.space().spans().count()) as f64;
        let point = across.point(t.min(d))?;
        let height = mirror.height(&point).abs();
        if height > worst.0 {
            worst = (height, point);
        }
    }
    if worst.0 > near {
        let [x, y, z] = [worst.1.x, worst.1.y, worst.1.z].map(figure);
        return Err(Error::Invalid(format!(
            "the plane cuts the surface along no line of {name}: where {name} = {}, the surface is {} from it at ({x}, {y}, {z}); \
             name the other direction, move the plane, or take the mean of both halves",
            figure(cut),
            figure(worst.0)
        )));
    }
    Ok((cut, line))
}
