//! What of a Brep is not where it should be: edges off their surfaces, loops beside one another.

use loftsman_kernel::brep::{Brep, Edge, Flaw, Frame, Use};
use loftsman_kernel::text::{figure, short};
use loftsman_kernel::{Point, Result};

/// Edges that are off by more than this part of the size are told: no rounding of a writer, nor a curve that it fitted, comes to that.
const OFF: f64 = 1e-4;
/// So many edges are told one by one.
const TOLD: usize = 3;
/// Places of each knot span of an edge at which a loop is looked at.
const PLACES: usize = 16;

/// What is said of edges that are off their faces or vertices, the furthest first; `None` where none is.
pub(crate) fn off(brep: &Brep, number: u64, tolerance: f64) -> Result<Option<String>> {
    let mut flaws = brep.flaws(OFF * size(brep.vertices()))?;
    if flaws.is_empty() {
        return Ok(None);
    }
    flaws.sort_by(|a, b| b.distance().total_cmp(&a.distance()));
    let told: Vec<String> = flaws.iter().take(TOLD).map(Flaw::to_string).collect();
    let more = match flaws.len().saturating_sub(TOLD) {
        0 => String::new(),
        more => format!("; {more} more by less"),
    };
    let states = short(tolerance);
    Ok(Some(format!("#{number}: {}{more}; the file states {states}", told.join("; "))))
}

fn size(points: &[Point]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// What is said of loops of a plane face of which none is around all the others; `None` where one is.
pub(crate) fn beside(frame: &Frame, loops: &[Vec<Use>], edges: &[Edge]) -> Result<Option<String>> {
    if loops.len() < 2 {
        return Ok(None);
    }
    let mut polygons = Vec::with_capacity(loops.len());
    for chain in loops {
        polygons.push(polygon(frame, chain, edges)?);
    }
    let areas: Vec<f64> = polygons.iter().map(|polygon| area(polygon).abs()).collect();
    let largest = (0..areas.len()).max_by(|a, b| areas[*a].total_cmp(&areas[*b])).unwrap_or(0);
    let outside = |points: &[[f64; 2]]| points.iter().filter(|p| !is_around(&polygons[largest], **p)).count();
    // Loops may touch: what counts is where most of one is.
    let beside = (0..loops.len()).filter(|&k| k != largest && 2 * outside(&polygons[k]) > polygons[k].len());
    let areas: Vec<String> = beside.map(|k| figure(areas[k])).collect();
    Ok(match &areas[..] {
        [] => None,
        [one] => Some(format!(
            "a loop of it, around an area of {one}, lies outside the largest: no hole of that, it is kept as a part of the face"
        )),
        all => Some(format!(
            "{} loops of it, around areas of {}, lie outside the largest: no holes of that, they are kept as parts of the face",
            all.len(),
            all.join(", ")
        )),
    })
}

fn polygon(frame: &Frame, chain: &[Use], edges: &[Edge]) -> Result<Vec<[f64; 2]>> {
    let mut points = Vec::new();
    for one in chain {
        let Some(edge) = edges.get(one.edge) else { continue };
        let (from, to) = edge.range;
        let steps = PLACES * edge.curve.space().breakpoints().len().saturating_sub(1).max(1);
        for k in 0..steps {
            let share = k as f64 / steps as f64;
            let share = if one.reversed { 1.0 - share } else { share };
            let away = edge.curve.point(from + (to - from) * share)? - frame.origin;
            points.push([away.dot(&frame.x), away.dot(&frame.y())]);
        }
    }
    Ok(points)
}

fn area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0])).sum()
}

/// Whether a closed polygon goes around a place.
fn is_around(points: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = points.iter().cycle().skip(1);
    let crosses = |(p, q): &(&[f64; 2], &[f64; 2])| {
        (p[1] > y) != (q[1] > y) && x < p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1]))
    };
    points.iter().zip(next).filter(crosses).count() % 2 == 1
}
