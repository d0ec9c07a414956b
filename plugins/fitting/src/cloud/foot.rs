//! The point of a shape that is nearest to a given one.

use loftsman_kernel::error::Result;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector, parallel};

use super::patches::{Patches, Room};
use super::tree::{Near, Tree};

/// Steps of one search, and halvings of one step by 4.
const STEPS: usize = 40;
const SHORTENINGS: usize = 8;
/// Points whose feet are looked for one after another, and how many times as many before anybody may say that it is enough.
const EACH: usize = 256;
const TOGETHER: usize = 32;
/// A step of this part of the distance that is left ends the search: the one behind it would be its square.
const LAST: f64 = 1e-6;

/// The foot of a point on a shape.
#[derive(Debug, Clone)]
pub(super) struct Foot {
    /// Where it is.
    pub(super) at: Location,
    /// A piece of the same room, and the parameters.
    piece: usize,
    place: [f64; 2],
    /// The shape's point there less the given one.
    pub(super) away: Vector,
    pub(super) distance: f64,
    pub(super) jet: Jet,
    /// The parameters that the foot can go along: two on a face, one on an edge, none at a corner.
    pub(super) free: [bool; 2],
}

/// The feet of points on a shape as it is, in the order of the points, and the order in which they are side by side on the shape.
///
/// Every point is looked for on all pieces of the shape that can hold something nearer than what is known, by Newton's method in the
/// parameters of a face, shortened until it comes nearer, along edges and into corners where a face ends. Where feet are `known` of the
/// shape before it moved, a search begins at these: mostly one step is enough then, and few pieces can hold anything nearer.
pub(super) fn feet(
    shape: &dyn Shape,
    patches: &Patches,
    points: &[Point],
    known: Option<(&[Foot], &[u32])>,
    cancelled: &dyn Fn() -> bool,
) -> Result<Option<(Vec<Foot>, Vec<u32>)>> {
    let tree = Tree::new(patches, patches.points(shape.control_vertices()));
    let starts: Vec<(u32, Start)> = match known {
        Some((feet, order)) => order.iter().map(|&k| (k, Start::of(&feet[k as usize]))).collect(),
        None => {
            let near = parallel::map(points.len(), |k| tree.nearest(&points[k].coords));
            let of = |(k, near): (u32, Option<Near>)| Some((k, Start::at(patches, &near?)));
            let mut starts: Vec<(u32, Start)> = (0..).zip(near).filter_map(of).collect();
            // Neighbours on the shape one after another: rows there cost less.
            starts.sort_by_key(|(k, start)| (start.piece, *k));
            starts
        }
    };
    let mut all: Vec<Option<Foot>> = vec![None; points.len()];
    let mut order = Vec::with_capacity(points.len());
    for some in starts.chunks(TOGETHER * EACH) {
        if cancelled() {
            return Ok(None);
        }
        let runs: Vec<_> = some.chunks(EACH).collect();
        let found = parallel::map(runs.len(), |run| {
            let foot = |(k, start): &(u32, Start)| {
                nearest(shape, patches, &tree, start, &points[*k as usize].coords)
            };
            runs[run].iter().map(foot).collect::<Result<Vec<Foot>>>()
        });
        for (run, feet) in runs.into_iter().zip(found) {
            for (&(k, _), foot) in run.iter().zip(feet?) {
                all[k as usize] = Some(foot);
                order.push(k);
            }
        }
    }
    Ok(all.into_iter().collect::<Option<Vec<Foot>>>().map(|feet| (feet, order)))
}

/// Where a search begins.
#[derive(Debug, Clone, Copy)]
struct Start {
    piece: usize,
    place: [f64; 2],
}

impl Start {
    fn of(foot: &Foot) -> Self {
        Self { piece: foot.piece, place: foot.place }
    }

    fn at(patches: &Patches, near: &Near) -> Self {
        let place = patches.room(near.piece).hold(patches.pieces()[near.piece].place(near.shares));
        Self { piece: near.piece, place }
    }
}

/// The foot of a point: the nearest of those that searches from all pieces near enough end at, the one that is known first. What begins within half
/// a piece of a foot would end there, too: pieces are taken for so small that they hold one.
fn nearest(
    shape: &dyn Shape,
    patches: &Patches,
    tree: &Tree<'_>,
    start: &Start,
    point: &Vector,
) -> Result<Foot> {
    let mut best = descend(shape, patches, start, point)?;
    let mut failed = None;
    tree.nearer(point, best.distance * (1.0 - 1e-9), &mut |other| {
        let start = Start::at(patches, &other);
        let leads_there = patches.alike(best.piece, start.piece)
            && (0..2).all(|k| (start.place[k] - best.place[k]).abs() <= 0.5 * patches.size(best.piece)[k]);
        if !leads_there {
            match descend(shape, patches, &start, point) {
                Ok(foot) if foot.distance < best.distance => best = foot,
                Ok(_) => {}
                Err(error) => failed = Some(error),
            }
        }
        best.distance * (1.0 - 1e-9)
    });
    failed.map_or(Ok(best), Err)
}

/// First and second derivatives, these where they exist.
#[derive(Debug, Clone)]
pub(super) struct Jet {
    pub(super) first: [Vector; 2],
    second: Option<[Vector; 3]>,
}

impl Jet {
    fn new(shape: &dyn Shape, at: Location, curve: bool) -> Result<Self> {
        if curve {
            let first = [shape.value(at, Derivative::from(1))?, Vector::zeros()];
            let second = shape.value(at, Derivative::from(2)).ok();
            return Ok(Self { first, second: second.map(|s| [s, Vector::zeros(), Vector::zeros()]) });
        }
        let by = |u: usize, v: usize| shape.value(at, Derivative { u, v });
        let first = [by(1, 0)?, by(0, 1)?];
        let all = |s: [Option<Vector>; 3]| Some([s[0]?, s[1]?, s[2]?]);
        // At an extraordinary vertex there are none: half of Newton's matrix is enough there.
        Ok(Self { first, second: all([by(2, 0).ok(), by(1, 1).ok(), by(0, 2).ok()]) })
    }

    /// Newton's steps for half the squared distance: in all free directions together, then in each alone.
    fn steps(&self, away: &Vector, free: [bool; 2]) -> Vec<[f64; 2]> {
        let [a, b] = self.first;
        let gradient = [away.dot(&a), away.dot(&b)];
        let plain = [a.dot(&a), a.dot(&b), b.dot(&b)];
        let full = match &self.second {
            Some(s) => std::array::from_fn(|k| plain[k] + away.dot(&s[k])),
            None => plain,
        };
        let mut steps = Vec::with_capacity(4);
        if free == [true, true] {
            for [e, f, g] in [full, plain] {
                let determinant = e * g - f * f;
                if e > 0.0 && determinant > 1e-14 * e * g {
                    steps.push([
                        (f * gradient[1] - g * gradient[0]) / determinant,
                        (f * gradient[0] - e * gradient[1]) / determinant,
                    ]);
                    break;
                }
            }
        }
        for k in 0..2 {
            let (whole, half) = (full[2 * k], plain[2 * k]);
            let by = if whole > 0.25 * half { whole } else { half };
            if free[k] && by > 0.0 {
                let mut step = [0.0; 2];
                step[k] = -gradient[k] / by;
                steps.push(step);
            }
        }
        steps.retain(|s| s.iter().all(|x| x.is_finite()));
        steps
    }

    /// The second derivatives of half the squared distance by the parameters, where they exist.
    pub(super) fn curvature(&self, away: &Vector) -> Option<[f64; 3]> {
        let ([a, b], s) = (self.first, self.second.as_ref()?);
        let plain = [a.dot(&a), a.dot(&b), b.dot(&b)];
        Some(std::array::from_fn(|k| plain[k] + away.dot(&s[k])))
    }

    fn length(&self, step: [f64; 2]) -> f64 {
        (self.first[0] * step[0] + self.first[1] * step[1]).norm()
    }
}

/// From a place on a piece downhill to a foot. No step goes farther from the point.
fn descend(shape: &dyn Shape, patches: &Patches, start: &Start, point: &Vector) -> Result<Foot> {
    let room = patches.room(start.piece);
    let mut place = start.place;
    let mut away = shape.value(room.at(place), Derivative::POSITION)? - point;
    let mut jet = Jet::new(shape, room.at(place), patches.is_curve())?;
    for _ in 0..STEPS {
        let free = free(&room, place, &jet, &away);
        let mut moved = None;
        'steps: for step in jet.steps(&away, free) {
            let mut share = 1.0;
            for _ in 0..SHORTENINGS {
                let next = room.hold([place[0] + share * step[0], place[1] + share * step[1]]);
                if next == place {
                    break;
                }
                let then = shape.value(room.at(next), Derivative::POSITION)? - point;
                let (now, before) = (then.norm_squared(), away.norm_squared());
                let last = jet.length(step) <= LAST * before.sqrt();
                if now < before || last && now <= before * (1.0 + 1e-12) {
                    moved = Some((next, then, last));
                    break 'steps;
                }
                share *= 0.25;
            }
        }
        let Some((next, then, last)) = moved else { break };
        (place, away) = (next, then);
        // Over the last step derivatives change no more than it is long: those from before it serve.
        if last {
            break;
        }
        jet = Jet::new(shape, room.at(place), patches.is_curve())?;
    }
    let free = free(&room, place, &jet, &away);
    Ok(Foot { at: room.at(place), piece: start.piece, place, distance: away.norm(), away, jet, free })
}

/// The parameters that the foot can still go along: all but those at whose end it would go on.
fn free(room: &Room, place: [f64; 2], jet: &Jet, away: &Vector) -> [bool; 2] {
    std::array::from_fn(|k| {
        let [start, end] = room.sides[k];
        let slope = away.dot(&jet.first[k]);
        let out = place[k] <= start && slope > 0.0 || place[k] >= end && slope < 0.0;
        !(room.curve && k == 1) && (room.wraps[k] || !out)
    })
}
