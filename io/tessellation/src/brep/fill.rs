//! Triangles inside a face: points where the surface bends, then more wherever a triangle is not yet certified.

use std::collections::{BTreeSet, HashMap};

use loftsman_kernel::mesh::distance::from_segment;
use loftsman_kernel::{Error, Point, Result, Vector};

use super::bounds::Spread;
use super::carrier::Carrier;
use super::cut::{BESIDE, Goal};
use super::plane::Plane;

/// Rounds of refinement at most.
const ROUNDS: usize = 60;
/// Refinement makes at most so many triangles of each that a face starts with, and so many more: first points are placed where the surface bends, so
/// that few are missing. What needs more comes no nearer by halving.
const GROWTH: usize = 64;
const GROWTH_OF_FEW: usize = 200_000;
/// A corner's normal that leans further from the triangle's than this (as a cosine) says that the surface may turn over in it.
const UPRIGHT: f64 = 0.5;
/// How much of the tolerance first cells use: the rest is for how triangles lie in them.
const FIRST: f64 = 0.8;
/// How often a triangle is quartered to be certified.
const DEPTH: u32 = 2;
/// A triangle is a line where a corner is no farther from the side across it than this part of the tolerance.
const THIN: f64 = 1e-3;
/// What runs around a pole by less than this part of the direction is a line to it.
const AROUND: f64 = 1e-9;
/// A bound that is this many times too large is not worth to be sharpened.
const FAR: f64 = 4.0;

/// The triangles of a face, and the largest distance of each from the surface.
pub(crate) struct Filled {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) error: f64,
}

/// Refines a face until all of its triangles are certified.
///
/// # Errors
/// When there are too many, or they cannot be certified, or the borders do not say what is inside.
pub(crate) fn fill(plane: &mut Plane<'_>, goal: &Goal) -> Result<Filled> {
    let carrier = plane.carrier;
    let mut inside = plane.labels()?;
    if !carrier.flat {
        let places = first(plane, &inside, goal)?;
        for at in plane.inside(&inside, &places) {
            plane.add(at);
        }
    }
    // Of triangles that are near enough already, how near: most stay from round to round.
    let mut done: HashMap<[u32; 3], f64> = HashMap::new();
    let mut most = usize::MAX;
    for round in 0.. {
        if round > 0 || !carrier.flat {
            inside = plane.labels()?;
        }
        let triangles = plane.triangles(&inside);
        if triangles.len() > goal.budget {
            return Err(Error::Invalid(format!(
                "it needs more than {} triangles: choose a coarser tolerance or angle",
                goal.budget
            )));
        }
        if round == 0 {
            most = triangles.len().saturating_mul(GROWTH).saturating_add(GROWTH_OF_FEW);
        }
        if triangles.len() > most {
            return Err(Error::Invalid(format!(
                "it is too singular to be cut: {most} triangles bring it no nearer than fewer did: choose a coarser tolerance or angle"
            )));
        }
        let mut error = 0.0_f64;
        let mut wanted: BTreeSet<[u32; 2]> = BTreeSet::new();
        let mut middles: Vec<[f64; 2]> = Vec::new();
        let mut unmet = false;
        for (corners, fixed) in &triangles {
            let mut key = *corners;
            key.sort_unstable();
            if let Some(known) = done.get(&key) {
                error = error.max(*known);
                continue;
            }
            let judged = judge(plane, *corners, *fixed, goal);
            if judged.wants == Wants::Nothing {
                done.insert(key, judged.error);
            }
            error = error.max(judged.error);
            unmet |= judged.wants != Wants::Nothing && judged.far;
            match judged.wants {
                Wants::Nothing => {}
                Wants::Edge(edge) => _ = wanted.insert(edge),
                Wants::Middle => {
                    let at = corners.map(|k| plane.vertices[k as usize].at);
                    middles.push([0, 1].map(|d: usize| (at[0][d] + at[1][d] + at[2][d]) / 3.0));
                }
            }
        }
        let mut added = false;
        if round < ROUNDS {
            for [a, b] in wanted {
                let [a, b] = [a, b].map(|k| plane.vertices[k as usize].at);
                added |= plane.add([0, 1].map(|d: usize| 0.5 * (a[d] + b[d])));
            }
            for at in middles {
                added |= plane.add(at);
            }
        }
        if !added {
            if unmet {
                return Err(Error::Invalid(format!(
                    "it is too singular to be cut: {} is the nearest that could be certified",
                    loftsman_kernel::text::short(error * goal.size)
                )));
            }
            let triangles = triangles.into_iter().map(|(corners, _)| corners).collect();
            return Ok(Filled { triangles, error });
        }
    }
    Err(Error::Invalid("it could not be cut".into()))
}

/// The corners of cells that are nearly flat enough, with the sizes of the cells: halved between creases and seams until they are.
fn first(plane: &Plane<'_>, inside: &[bool], goal: &Goal) -> Result<Vec<([f64; 2], [f64; 2])>> {
    let carrier = plane.carrier;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (corners, _) in plane.triangles(inside) {
        for k in corners {
            let at = plane.vertices[k as usize].at;
            for d in 0..2 {
                (low[d], high[d]) = (low[d].min(at[d]), high[d].max(at[d]));
            }
        }
    }
    if (0..2).any(|d| low[d].total_cmp(&high[d]).is_ge()) {
        return Err(Error::NoExtent("its loops bound no area".into()));
    }
    let stops = [0, 1].map(|d: usize| {
        let mut all = vec![low[d]];
        all.extend(carrier.sides[d].lines.iter().copied().filter(|x| *x > low[d] && *x < high[d]));
        all.push(high[d]);
        all
    });
    let mut open: Vec<[[f64; 2]; 2]> = Vec::new();
    for u in stops[0].windows(2) {
        for v in stops[1].windows(2) {
            open.push([[u[0], v[0]], [u[1], v[1]]]);
        }
    }
    let mut places: Vec<([f64; 2], [f64; 2])> = Vec::new();
    let mut cells = 0;
    while let Some([low, high]) = open.pop() {
        let size = [0, 1].map(|d: usize| high[d] - low[d]);
        match halved(carrier, low, high, goal) {
            Some(d) => {
                let middle = 0.5 * (low[d] + high[d]);
                let (mut one, mut other) = ([low, high], [low, high]);
                (one[1][d], other[0][d]) = (middle, middle);
                open.extend([other, one]);
            }
            None => {
                cells += 1;
                if cells > goal.budget {
                    return Err(Error::Invalid(format!(
                        "it needs more than {} triangles: choose a coarser tolerance or angle",
                        goal.budget
                    )));
                }
                for at in [low, [high[0], low[1]], high, [low[0], high[1]]] {
                    places.push((at, size));
                }
            }
        }
    }
    let order = |a: &([f64; 2], [f64; 2]), b: &([f64; 2], [f64; 2])| {
        let of = |k: usize| a.0[k].total_cmp(&b.0[k]);
        of(0).then(of(1)).then(a.1[0].total_cmp(&b.1[0])).then(a.1[1].total_cmp(&b.1[1]))
    };
    places.sort_unstable_by(order);
    places.dedup_by(|a, b| a.0 == b.0);
    Ok(places)
}

/// The direction in which a cell has to be halved, if any.
fn halved(carrier: &Carrier, low: [f64; 2], high: [f64; 2], goal: &Goal) -> Option<usize> {
    let size = [0, 1].map(|d: usize| high[d] - low[d]);
    let middle = [0, 1].map(|d: usize| 0.5 * (low[d] + high[d]));
    if (0..2).any(|d| middle[d] <= low[d] || middle[d] >= high[d]) {
        return None;
    }
    let speeds = carrier.bounds.speeds(low, high);
    if (0..2).all(|d| speeds[d] * size[d] <= goal.chord) {
        return None;
    }
    let mut spread = carrier.bounds.spread(low, high);
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
    let normals = corners.map(|at| carrier.normal(at, middle));
    let points = corners.map(|at| carrier.point(at));
    let normal =
        (points[2] - points[0]).cross(&(points[3] - points[1])).try_normalize(0.0).unwrap_or_default();
    let upright = normals.iter().all(|n| n.dot(&normal) >= UPRIGHT);
    let bound_by = |spread: &Spread| {
        let mut bound = spread.whole(size);
        if upright {
            let ranges = spread.across(&normal);
            let one = ranges.about([corners[0], corners[1], corners[2]]);
            let other = ranges.about([corners[0], corners[2], corners[3]]);
            bound = bound.min(one.max(other));
        }
        bound + carrier.kinks(low, high)
    };
    let mut bound = bound_by(&spread);
    // Near the tip of a cone the cells of its derivatives are larger than what is halved there.
    if bound > FIRST * goal.chord && carrier.bounds.are_coarse(low, high) {
        let sharper = carrier.spread(low, high);
        let less = bound_by(&sharper);
        if less < bound {
            (spread, bound) = (sharper, less);
        }
    }
    let [uu, uv, vv] = if upright { spread.across(&normal).sizes() } else { spread.most() };
    let bends = [uu * size[0] * size[0], vv * size[1] * size[1]];
    let longer = |bends: [f64; 2]| usize::from(bends[1] > bends[0]);
    if bound > FIRST * goal.chord {
        let mixed = 2.0 * uv * size[0] * size[1];
        let lengths = [speeds[0] * size[0], speeds[1] * size[1]];
        return Some(if mixed > bends[0] + bends[1] { longer(lengths) } else { longer(bends) });
    }
    if goal.angle >= std::f64::consts::PI {
        return None;
    }
    // Normals along the sides.
    let turn = |a: usize, b: usize| {
        let far = (points[a] - points[b]).norm() > 2.0 * goal.chord;
        let known = normals[a] != Vector::zeros() && normals[b] != Vector::zeros();
        if far && known { normals[a].angle(&normals[b]) } else { 0.0 }
    };
    let turns = [turn(0, 1).max(turn(3, 2)), turn(1, 2).max(turn(0, 3))];
    (turns[0].max(turns[1]) > goal.angle).then(|| longer(turns))
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Wants {
    Nothing,
    /// An edge halved.
    Edge([u32; 2]),
    /// A point within.
    Middle,
}

struct Judged {
    error: f64,
    /// Whether it is too far, and not only turned too much.
    far: bool,
    wants: Wants,
}

/// How far the surface can be from a triangle with one corner in a pole, along a unit normal or in all directions: over what lies
/// between its opposite edge and the pole, straight across. That is no more than how far the edge is, and what the surface bends
/// along the way: where the pole is, as a place in the plane, does not matter. `None` where the edge runs back.
fn fan_bound(
    carrier: &Carrier,
    at: [[f64; 2]; 3],
    (apex, across, end): (usize, usize, usize),
    spread: &Spread,
    normal: Option<&Vector>,
) -> Option<f64> {
    let (a, b) = (at[(apex + 1) % 3], at[(apex + 2) % 3]);
    if runs_around(at, (apex, across, end)) <= 0.0 {
        return None;
    }
    let side = &carrier.sides[across];
    let pole = [side.low, side.high][end];
    let reach = (a[across] - pole).abs().max((b[across] - pole).abs());
    let edge = [0, 1].map(|d: usize| (b[d] - a[d]).abs());
    let (low, high) = ([0, 1].map(|d: usize| a[d].min(b[d])), [0, 1].map(|d: usize| a[d].max(b[d])));
    let beside = carrier.bounds.spread(low, high);
    let (bend, chord) = match normal {
        Some(normal) => (spread.across(normal).largest()[2 * across], beside.across(normal).along(a, b)),
        None => (spread.most()[2 * across], beside.whole(edge)),
    };
    Some(0.125 * bend * reach * reach + chord)
}

/// How far the surface can be from a plane over a triangle of parameters: over its quarters as much as at their corners, and what it
/// bends in them; quarter by quarter again where that is more than `enough`.
fn from_plane(
    carrier: &Carrier,
    [a, b, c]: [[f64; 2]; 3],
    plane: (&Vector, &Vector),
    enough: f64,
    depth: u32,
) -> f64 {
    let (normal, on) = plane;
    let middle = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|d: usize| 0.5 * (a[d] + b[d]));
    let [p, q, r] = [middle(a, b), middle(b, c), middle(c, a)];
    let away = |at: [f64; 2]| normal.dot(&(carrier.point(at) - on)).abs();
    let [fa, fb, fc, fp, fq, fr] = [a, b, c, p, q, r].map(away);
    let parts = [([a, p, r], fa.max(fp).max(fr)), ([p, b, q], fp.max(fb).max(fq))];
    let rest = [([r, q, c], fr.max(fq).max(fc)), ([p, q, r], fp.max(fq).max(fr))];
    let mut worst = 0.0_f64;
    for (part, corners) in parts.into_iter().chain(rest) {
        if corners > enough {
            return corners;
        }
        let low = [0, 1].map(|d: usize| part[0][d].min(part[1][d]).min(part[2][d]));
        let high = [0, 1].map(|d: usize| part[0][d].max(part[1][d]).max(part[2][d]));
        let mut bound = corners + carrier.spread(low, high).across(normal).triangle(part);
        if bound > enough && depth > 0 {
            bound = bound.min(from_plane(carrier, part, plane, enough, depth - 1));
        }
        worst = worst.max(bound);
        if worst > enough {
            return worst;
        }
    }
    worst
}

/// How far the edge opposite to a corner in a pole runs around it: not at all where the triangle is a line to the pole, less than that where it
/// lies on its back.
fn runs_around(at: [[f64; 2]; 3], (apex, across, end): (usize, usize, usize)) -> f64 {
    let along = 1 - across;
    let (a, b) = (at[(apex + 1) % 3], at[(apex + 2) % 3]);
    // Counterclockwise, with the pole to the left: at the upper end of `v` the edge runs to larger `u`, at that of `u` to smaller `v`.
    let runs = if across == 1 { b[along] - a[along] } else { a[along] - b[along] };
    if end == 1 { runs } else { -runs }
}

/// How far a corner of a triangle can be from the longest side, in space, where the surface is run over at these speeds at most, and the number of
/// the corner with which that side starts.
fn thickness(at: [[f64; 2]; 3], speeds: [f64; 2]) -> (f64, usize) {
    let way = |k: usize, l: usize| [0, 1].map(|d: usize| (at[l][d] - at[k][d]) * speeds[d]);
    let sides = [way(0, 1), way(1, 2), way(2, 0)];
    let lengths = sides.map(|[u, v]| u.hypot(v));
    let longest = (1..3).fold(0, |most, k| if lengths[k] > lengths[most] { k } else { most });
    let area = (sides[0][0] * sides[1][1] - sides[0][1] * sides[1][0]).abs();
    // Both coordinates of the way to the foot count in full.
    let thick = if lengths[longest] > 0.0 { std::f64::consts::SQRT_2 * area / lengths[longest] } else { 0.0 };
    (thick, longest)
}

/// How far a triangle can be from the surface, and what would bring it nearer.
fn judge(plane: &Plane<'_>, corners: [u32; 3], fixed: [bool; 3], goal: &Goal) -> Judged {
    let carrier = plane.carrier;
    let vertices = corners.map(|k| plane.vertices[k as usize]);
    let at = vertices.map(|v| v.at);
    let off = vertices.iter().map(|v| v.off).fold(0.0, f64::max);
    if carrier.flat {
        return Judged { error: off, far: false, wants: Wants::Nothing };
    }
    let least = |d: usize| at[0][d].min(at[1][d]).min(at[2][d]);
    let most = |d: usize| at[0][d].max(at[1][d]).max(at[2][d]);
    let (low, high) = ([least(0), least(1)], [most(0), most(1)]);
    let poles = at.map(|at| carrier.pole_at(at));
    let on_pole = poles.iter().flatten().count();
    // What has an edge in a pole is a line: the fans beside it reach over it.
    if on_pole > 1 {
        return Judged { error: off, far: false, wants: Wants::Nothing };
    }
    let fan = (0..3).find_map(|k| poles[k].map(|(d, end)| (k, d, end)));
    // A line to the pole has no area in space, and what lies on its back there is turned over.
    let turned = fan.filter(|&fan| runs_around(at, fan) <= AROUND * carrier.sides[1 - fan.1].length());
    let mut drawn_in = at;
    // A pole is at all places along it.
    if let Some((apex, across, _)) = fan {
        drawn_in[apex][1 - across] = at[(apex + 1) % 3][1 - across];
    }
    let (thick, longest) = thickness(drawn_in, carrier.bounds.speeds(low, high));
    if turned.is_none() && thick <= THIN * goal.chord {
        // Between corners on one line there is nothing but the curves along its sides: what lies across these, or a border as it was cut, says how
        // near they are; how near these sides are to the longest one is seen where they meet.
        let [a, b, c] = [0, 1, 2].map(|k| Point::from(vertices[(longest + k) % 3].place));
        let error = off.max(from_segment(&c, &a, &b));
        if error <= goal.chord {
            return Judged { error, far: false, wants: Wants::Nothing };
        }
    }
    let centre = [0, 1].map(|d: usize| (at[0][d] + at[1][d] + at[2][d]) / 3.0);
    let normals = [0, 1, 2].map(|k: usize| plane.normal(corners[k], centre));
    // What lies beside an edge is always allowed to bend as that is (see `cut`).
    // Where a triangle ends, a point that is near its plane may still lie beyond its edge: by no more than what is beside that bends.
    let border = fixed.contains(&true);
    let room = if border { (1.0 - BESIDE * BESIDE).sqrt() } else { 1.0 };
    let enough = (room * goal.chord - off).max(1.1 * BESIDE * goal.chord);
    let kinks = carrier.kinks(low, high);
    let [a, b, c] = vertices.map(|v| v.place);
    let (s, t) = (b - a, c - a);
    let normal = s.cross(&t).try_normalize(0.0).unwrap_or_default();
    let upright = normals.iter().all(|n| n.dot(&normal) >= UPRIGHT);
    let bound_by = |spread: &Spread| {
        let whole = spread.whole([high[0] - low[0], high[1] - low[1]]);
        kinks + if upright { whole.min(spread.across(&normal).triangle(at)) } else { whole }
    };
    let bound_by = |spread: &Spread| match fan
        .and_then(|fan| fan_bound(carrier, at, fan, spread, upright.then_some(&normal)))
    {
        Some(bound) => kinks + bound,
        None => bound_by(spread),
    };
    let mut spread = carrier.bounds.spread(low, high);
    let mut bound = bound_by(&spread);
    // Beside a border that hardly bends, what is farther in may bend a thousand times as much: what a cell says is nothing to go by there.
    if bound > enough && (bound < FAR * enough || carrier.bounds.are_coarse(low, high)) {
        let sharper = carrier.spread(low, high);
        let less = bound_by(&sharper);
        if less < bound {
            (spread, bound) = (sharper, less);
        }
    }
    let slip = if border {
        let whole = kinks + spread.whole([high[0] - low[0], high[1] - low[1]]);
        whole.min(BESIDE * goal.chord)
    } else {
        0.0
    };
    let mut error = bound.hypot(slip) + off;
    if fan.is_none() && bound > enough && upright && bound < FAR * enough && kinks == 0.0 {
        // From the plane of the triangle, `off` included.
        let sharper = from_plane(carrier, at, (&normal, &a), enough, DEPTH);
        if sharper <= enough {
            (bound, error) = (sharper, sharper.max(off).hypot(slip));
        }
    }
    let [uu, uv, vv] = if upright { spread.across(&normal).sizes() } else { spread.most() };
    let free = || (0..3).filter(|&k| !fixed[k]);
    let pair = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        [a.min(b), a.max(b)]
    };
    // Halves of the edge opposite to the pole lie as that does; the longer way to the pole halved, they come to lie beside the pole.
    if let Some((apex, across, _)) = turned {
        let [a, b] = [(apex + 1) % 3, (apex + 2) % 3];
        let away = |k: usize| (at[k][across] - at[apex][across]).abs();
        // By the number of the edge that starts or ends in the corner.
        let mut ways = [(a, apex), (b, b)];
        if away(b) > away(a) {
            ways.reverse();
        }
        let way = ways.into_iter().find(|&(_, k)| !fixed[k]);
        let far = bound > enough;
        return Judged { error, far, wants: way.map_or(Wants::Nothing, |(_, k)| Wants::Edge(pair(k))) };
    }
    if bound > enough {
        let bends = |k: usize| {
            let [h, l] = [0, 1].map(|d: usize| (at[(k + 1) % 3][d] - at[k][d]).abs());
            // Towards a pole only the length along its lines counts.
            let (h, l) = match fan {
                Some((apex, 0, _)) if apex == k || apex == (k + 1) % 3 => (h, 0.0),
                Some((apex, _, _)) if apex == k || apex == (k + 1) % 3 => (0.0, l),
                _ => (h, l),
            };
            uu * h * h
                + 2.0 * uv * h * l
                + vv * l * l
                + carrier.kinks(low, high) * (h / (high[0] - low[0])).max(l / (high[1] - low[1]))
        };
        let wants = free()
            .max_by(|&k, &l| bends(k).total_cmp(&bends(l)))
            .map_or(Wants::Middle, |k| Wants::Edge(pair(k)));
        return Judged { error, far: true, wants };
    }
    if goal.angle >= std::f64::consts::PI {
        return Judged { error, far: false, wants: Wants::Nothing };
    }
    let turn = |k: usize| {
        let l = (k + 1) % 3;
        let far = (vertices[k].place - vertices[l].place).norm() > 2.0 * goal.chord;
        let known = normals[k] != Vector::zeros() && normals[l] != Vector::zeros();
        let one = vertices[k].point.is_some() && vertices[k].point == vertices[l].point;
        if far && known && !one { normals[k].angle(&normals[l]) } else { 0.0 }
    };
    let worst = free().max_by(|&k, &l| turn(k).total_cmp(&turn(l)));
    let wants = worst.filter(|&k| turn(k) > goal.angle).map_or(Wants::Nothing, |k| Wants::Edge(pair(k)));
    Judged { error, far: false, wants }
}
