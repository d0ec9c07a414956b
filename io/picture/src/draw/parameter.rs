//! Parameters: where on a curve `u = 0.4` is, and on a surface the lines of equal `u` and `v`; and the numbers of vertices, of meshes, polylines and cages.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::Splines;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::Surface;

use crate::draw::{color, dots};
use crate::labels::{Label, ONE, Room, Row, ranks};
use crate::path::Spot;
use crate::sheet::{Layer, Sheet, Stroke};
use crate::stage::body::{Body, Form};
use crate::stage::laid::Laid;
use crate::stage::piece::Piece;
use crate::stage::trim::{Mask, Trim};
use crate::text;
use crate::theme::Color;

/// About so many places of a curve have their parameter, and of each direction of a surface.
const ON_CURVE: usize = 10;
const ON_EDGE: usize = 5;

/// The parameters of one direction of a surface stand along one of so many lines across it, its two borders among them.
const LINES: usize = 33;

/// Of more vertices no number can be read.
const NUMBERED: usize = 500;

/// With so many labels on a page nobody looks for room for more.
const CROWDED: usize = 500;

/// What has its parameter: the place, the name of the parameter, its value, and how far down its row it is.
struct Named {
    place: Vector,
    name: &'static str,
    value: String,
    rank: u32,
}

/// Writes the parameters of a curve or surface, or the numbers of vertices.
pub(crate) fn draw(sheet: &mut Sheet, body: &Body<'_>) {
    let ink = color(sheet, body, false).mixed(sheet.theme.ink(), 0.5);
    let object = text::clipped(body.object.name(), 30);
    let mut hidden = 0;
    let mut all: Vec<Named> = Vec::new();
    match &body.form {
        Form::Curve { pieces, .. } => {
            let Some(breaks) = breaks(body.object.geometry()) else { return };
            for named in on_curve(pieces, &breaks) {
                if sheet.hides(&named.place) {
                    hidden += 1;
                } else {
                    all.push(named);
                }
            }
        }
        Form::Surface { surface, trim, .. } => {
            let mask = trim.as_ref().map(|trim: &Trim| Mask::new(trim, surface));
            for along in [Along::U, Along::V] {
                let (found, out_of_sight) = on_surface(sheet, (surface, mask.as_ref()), along, ink);
                all.extend(found);
                hidden += out_of_sight;
            }
        }
        Form::Mesh { points, .. } | Form::Polyline { points, .. } => {
            (all, hidden) = numbers(sheet, &object, points);
        }
        Form::Solid(shell) if shell.laid.as_ref().is_none_or(Laid::has_faces) => {
            let is_cage = !body.edges.is_empty();
            let beside = if is_cage { "the numbers are those of its control vertices; " } else { "" };
            let words = "its faces have parameters each, which are not drawn: point at a place by `closest`";
            sheet.caption.note(format!("{object}: {beside}{words}"));
            if !is_cage {
                return;
            }
            (all, hidden) = numbers(sheet, &object, &body.vertices);
        }
        _ => return,
    }
    sheet.note_behind(&object, hidden);
    let spots: Vec<_> = all.iter().map(|named| sheet.spot(&named.place)).collect();
    sheet.put(Layer::Beads, &Stroke::plain(ink, 0.9).path("parameters", dots(&spots)).empty());
    // Where a shape is closed or comes to a point several places are one, which has one label.
    let mut places: Vec<(Spot, Vec<Named>)> = Vec::new();
    for (spot, named) in spots.into_iter().zip(all) {
        sheet.ink.segment(spot, spot, 6);
        let same = |(at, _): &&mut (Spot, _)| (at[0] - spot[0]).hypot(at[1] - spot[1]) < ONE;
        match places.iter_mut().find(same) {
            Some((_, said)) => said.push(named),
            None => places.push((spot, vec![named])),
        }
    }
    for (anchor, said) in places {
        let rank = said.iter().map(|named| named.rank).min().unwrap_or_default();
        let row = Some(Row { rank, object: object.clone() });
        sheet.labels.push(Label { anchor, lines: vec![words(&said)], color: ink, row });
    }
}

/// The numbers of vertices that are seen, and how many are not.
fn numbers(sheet: &mut Sheet, object: &str, vertices: &[Vector]) -> (Vec<Named>, usize) {
    if vertices.len() > NUMBERED {
        sheet.caption.note(format!("{object}: its {} vertices are too many to be numbered", vertices.len()));
        return (Vec::new(), 0);
    }
    let all = vertices.iter().zip(ranks(vertices.len())).enumerate();
    let seen = all.filter(|(_, (place, _))| !sheet.hides(place));
    let named: Vec<Named> = seen
        .map(|(number, (place, rank))| Named { place: *place, name: "", value: number.to_string(), rank })
        .collect();
    let hidden = vertices.len() - named.len();
    (named, hidden)
}

/// The parameters at which the pieces of a curve begin and end.
fn breaks(geometry: &Geometry) -> Option<Vec<f64>> {
    match geometry {
        Geometry::Curve(curve) => Some(curve.space().breakpoints()),
        Geometry::Custom(custom) => match custom.splines() {
            Some(Splines::Curves(curves)) => curves.first().map(|curve| curve.space().breakpoints()),
            _ => None,
        },
        _ => None,
    }
}

/// Round parameters of a curve and where they are.
fn on_curve(pieces: &[Piece], breaks: &[f64]) -> Vec<Named> {
    let (Some(&start), Some(&end)) = (breaks.first(), breaks.last()) else { return Vec::new() };
    let values: Vec<f64> = even((start, end), ON_CURVE).collect();
    let ranks = ranks(values.len());
    let at = |(u, rank): (f64, u32)| {
        // The span that holds it; the last one its end, too.
        let span = breaks.partition_point(|&knot| knot <= u).clamp(1, pieces.len().max(1)) - 1;
        let (piece, ends) = pieces.get(span).zip(breaks.get(span..span + 2))?;
        let share = ((u - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0);
        Some(Named { place: piece.point(share), name: "", value: text::parameter(u), rank })
    };
    values.into_iter().zip(ranks).filter_map(at).collect()
}

/// The direction whose parameters are written.
#[derive(Clone, Copy, PartialEq)]
enum Along {
    U,
    V,
}

/// Round parameters of one direction of a surface, along that line across it where most of them are seen, and most of these have room for
/// their numbers; one that is not, or has none there, stands where its own line of equal parameter is seen and has room, as near as can be.
/// And how many are seen nowhere.
fn on_surface(
    sheet: &Sheet,
    (surface, mask): (&Surface, Option<&Mask>),
    along: Along,
    color: Color,
) -> (Vec<Named>, usize) {
    let (own, other) = match along {
        Along::U => (surface.u().domain(), surface.v().domain()),
        Along::V => (surface.v().domain(), surface.u().domain()),
    };
    let name = if along == Along::U { "u " } else { "v " };
    let values: Vec<f64> = even(own, ON_EDGE).collect();
    let ranks = ranks(values.len());
    let across: Vec<f64> = (0..LINES)
        .map(|i| match i {
            0 => other.0,
            _ if i + 1 == LINES => other.1,
            _ => other.0 + (other.1 - other.0) * (i as f64 / (LINES - 1) as f64),
        })
        .collect();
    let seen = |own: f64, other: f64| {
        let at = if along == Along::U { [own, other] } else { [other, own] };
        let place = surface.point(at[0], at[1]).ok().map(|p| p.coords)?;
        (mask.is_none_or(|mask| mask.has(at)) && !sheet.hides(&place)).then_some(place)
    };
    let places: Vec<Vec<Option<Vector>>> =
        values.iter().map(|&own| across.iter().map(|&other| seen(own, other)).collect()).collect();
    let room = Room::on(&sheet.ink);
    // How far off each number would have to stand, where it has a place.
    let crowded = sheet.labels.len() > CROWDED;
    let distance = |place: &Vector, (value, rank): (f64, u32)| {
        if crowded {
            return None;
        }
        let row = Some(Row { rank, object: String::new() });
        let lines = vec![format!("{name}{}", text::parameter(value))];
        room.near(&Label { anchor: sheet.spot(place), lines, color, row })
    };
    let near: Vec<Vec<Option<f64>>> = places
        .iter()
        .zip(values.iter().copied().zip(ranks.iter().copied()))
        .map(|(places, number)| places.iter().map(|place| distance(place.as_ref()?, number)).collect())
        .collect();
    // How well the numbers can be read along a line.
    let worth = |line: usize| -> f64 {
        let one = |(places, near): (&Vec<Option<Vector>>, &Vec<Option<f64>>)| match (places[line], near[line])
        {
            (None, _) => 0.0,
            (_, None) => 1.0,
            (_, Some(distance)) => 2.0 - 0.05 * distance,
        };
        // A border is known without a line that is drawn, so that it wins where little speaks against it.
        let border = if line == 0 || line + 1 == LINES { 1.1 } else { 1.0 };
        border * places.iter().zip(&near).map(one).sum::<f64>()
    };
    let best = (0..LINES).map(|line| (worth(line), line));
    let (_, best) = best.fold((0.0, 0), |best, one| if one.0 > best.0 { one } else { best });
    let (mut found, mut hidden) = (Vec::new(), 0);
    for (((value, places), near), rank) in values.into_iter().zip(&places).zip(&near).zip(ranks) {
        let by_distance = |line: &usize| line.abs_diff(best);
        let with_room = (0..LINES).filter(|&line| near[line].is_some()).min_by_key(by_distance);
        let seen = (0..LINES).filter(|&line| places[line].is_some()).min_by_key(by_distance);
        match with_room.or(seen).and_then(|line| places[line]) {
            Some(place) => found.push(Named { place, name, value: text::parameter(value), rank }),
            None => hidden += 1,
        }
    }
    (found, hidden)
}

/// The parameters of one place: `0.4`, `u 0 and 6.28`, `u 0 to 6.28, v 1`.
fn words(said: &[Named]) -> String {
    let mut parts: Vec<String> = Vec::new();
    for name in ["", "u ", "v "] {
        let mut numbers: Vec<&str> =
            said.iter().filter(|named| named.name == name).map(|named| named.value.as_str()).collect();
        numbers.dedup();
        match numbers[..] {
            [] => {}
            [one] => parts.push(format!("{name}{one}")),
            [one, other] => parts.push(format!("{name}{one} and {other}")),
            [first, .., last] => parts.push(format!("{name}{first} to {last}")),
        }
    }
    parts.join(", ")
}

/// Round numbers in an interval, about so many, and its two ends.
fn even((start, end): (f64, f64), count: usize) -> impl Iterator<Item = f64> {
    let raw = (end - start) / count as f64;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|step| *step >= raw * (1.0 - 1e-9));
    let step = step.unwrap_or(raw);
    let first = (start / step).floor() + 1.0;
    // What is nearer to an end than half a step would stand on its number.
    let inside = (0..4 * count).map(move |k| (first + k as f64) * step);
    let inside = inside.filter(move |u| *u > start + 0.5 * step && *u < end - 0.5 * step);
    std::iter::once(start).chain(inside).chain(std::iter::once(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_place_has_one_label() {
        let named = |&(name, value): &(&'static str, &str)| Named {
            place: Vector::zeros(),
            name,
            value: value.to_owned(),
            rank: 0,
        };
        let said = |list: &[(&'static str, &str)]| words(&list.iter().map(named).collect::<Vec<_>>());
        assert_eq!(said(&[("", "0.4")]), "0.4");
        assert_eq!(said(&[("u ", "0"), ("v ", "0"), ("u ", "6.28")]), "u 0 and 6.28, v 0");
        assert_eq!(said(&[("v ", "0"), ("u ", "0"), ("u ", "2"), ("u ", "4")]), "u 0 to 4, v 0");
    }

    #[test]
    fn places_are_round_and_hold_both_ends() {
        let close = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            found
                .iter()
                .zip(wanted)
                .for_each(|(a, b)| assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{found:?}"));
        };
        close(even((0.0, 1.0), 5).collect(), &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        close(even((-3.0, 7.0), 10).collect(), &[-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        close(even((0.13, 0.97), 5).collect(), &[0.13, 0.4, 0.6, 0.8, 0.97]);
        for domain in [(0.0, 1e-300), (-1e300, 1e300), (1e16, 1e16 + 4.0), (0.0, 5e-324)] {
            let all: Vec<f64> = even(domain, 10).collect();
            assert!(all.len() < 50 && all.iter().all(|u| *u >= domain.0 && *u <= domain.1), "{all:?}");
        }
    }
}
