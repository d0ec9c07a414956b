//! Faces that are there twice.

use std::collections::BTreeMap;

use loftsman_kernel::brep::{Brep, Parts};
use loftsman_kernel::error::Result;
use loftsman_kernel::spline::part::Part;
use loftsman_kernel::{Point, Vector};

/// A face is looked at in places of grids of so many rows, the next one where the one before has no place inside.
const GRIDS: [usize; 3] = [6, 24, 96];
/// And in no more places than so many.
const PLACES: usize = 12;

/// A face by itself.
fn alone(parts: &Parts, face: usize) -> Result<Brep> {
    let mut own = Parts::default();
    let (mut edges, mut vertices) = (BTreeMap::new(), BTreeMap::new());
    let mut vertex = |own: &mut Parts, old: usize| {
        *vertices.entry(old).or_insert_with(|| {
            own.vertices.push(parts.vertices[old]);
            own.vertices.len() - 1
        })
    };
    let mut alone = parts.faces[face].clone();
    for one in alone.loops.iter_mut().flatten() {
        one.edge = match edges.get(&one.edge) {
            Some(known) => *known,
            None => {
                let mut edge = parts.edges[one.edge].clone();
                edge.ends = edge.ends.map(|end| vertex(&mut own, end));
                own.edges.push(edge);
                edges.insert(one.edge, own.edges.len() - 1);
                own.edges.len() - 1
            }
        };
    }
    for point in &mut alone.points {
        *point = vertex(&mut own, *point);
    }
    own.faces.push(alone);
    Brep::new(own)
}

/// Points inside a face.
fn places(part: &Part) -> Result<Vec<Point>> {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for curve in part.border() {
        let (a, b) = curve.curve().hull_bounds();
        (low, high) = (low.inf(&a.coords), high.sup(&b.coords));
    }
    let mut all = Vec::new();
    for count in GRIDS {
        let step = (count * count).div_ceil(2 * PLACES).max(1);
        for k in (0..count * count).step_by(step) {
            // Off the lines along which loops run.
            let share = [k / count, k % count].map(|k| (k as f64 + 0.437) / count as f64);
            let at = [0, 1].map(|d: usize| low[d] + (high[d] - low[d]) * share[d]);
            if part.has(at) {
                let [u, v] = part.wrapped(at);
                all.push(part.surface().point(u, v)?);
            }
        }
        if !all.is_empty() {
            break;
        }
    }
    all.truncate(PLACES);
    Ok(all)
}

/// Whether the places of a face lie on another one.
fn lies_on(one: &[Point], other: &Part, near: f64) -> Result<bool> {
    for place in one {
        if other.distance_at_most(*place)? > near {
            return Ok(false);
        }
    }
    Ok(!one.is_empty())
}

/// Leaves out each face that has the vertices of an earlier one and lies within the tolerance of that wherever it is looked at; how many. Only faces with the same
/// vertices are compared: `O(n log n)` where few have.
pub(super) fn drop(parts: &mut Parts, near: f64) -> Result<usize> {
    let mut alike: BTreeMap<Vec<[usize; 2]>, Vec<usize>> = BTreeMap::new();
    for (number, face) in parts.faces.iter().enumerate() {
        let mut ends: Vec<[usize; 2]> =
            face.loops.iter().flatten().map(|one| parts.edges[one.edge].ends).collect();
        ends.iter_mut().for_each(|ends| ends.sort_unstable());
        ends.sort_unstable();
        if !ends.is_empty() {
            alike.entry(ends).or_default().push(number);
        }
    }
    let mut twice = vec![false; parts.faces.len()];
    for faces in alike.values().filter(|faces| faces.len() > 1) {
        let mut known: Vec<(Part, Vec<Point>)> = Vec::new();
        for &face in faces {
            let part = alone(parts, face)?.part(0)?;
            let own = places(&part)?;
            let mut is_there = false;
            for (other, others) in &known {
                is_there = lies_on(&own, other, near)? && lies_on(others, &part, near)?;
                if is_there {
                    break;
                }
            }
            if is_there {
                twice[face] = true;
            } else {
                known.push((part, own));
            }
        }
    }
    let mut number = 0;
    parts.faces.retain(|_| {
        number += 1;
        !twice[number - 1]
    });
    Ok(twice.into_iter().filter(|twice| *twice).count())
}
