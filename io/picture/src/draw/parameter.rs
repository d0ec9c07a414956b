//! Parameters: where on a curve `u = 0.4` is, and on a surface `u` and `v` along two of its edges.

use loftsman_kernel::Vector;
use loftsman_kernel::scene::Geometry;

use crate::draw::{color, dots};
use crate::labels::Label;
use crate::path::Spot;
use crate::sheet::{Layer, Sheet, Stroke};
use crate::stage::body::{Body, Form};
use crate::text;

/// About so many places of a curve have their parameter, and of an edge of a surface.
const ON_CURVE: usize = 10;
const ON_EDGE: usize = 5;

/// Places nearer than this on the page are one, in millimetres.
const ONE: f64 = 0.6;

/// Writes the parameters of a curve or surface.
pub(crate) fn draw(sheet: &mut Sheet, body: &Body<'_>) {
    let mut all: Vec<(Vector, &str, String)> = Vec::new();
    match (&body.form, body.object.geometry()) {
        (Form::Curve { pieces, .. }, Geometry::Curve(curve)) => {
            let breaks = curve.space().breakpoints();
            for u in even(curve.domain(), ON_CURVE) {
                // The span that holds it; the last one its end, too.
                let span = breaks.partition_point(|&knot| knot <= u).clamp(1, pieces.len().max(1)) - 1;
                let (Some(piece), Some(ends)) = (pieces.get(span), breaks.get(span..span + 2)) else {
                    continue;
                };
                let share = ((u - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0);
                all.push((piece.point(share), "", text::number(u)));
            }
        }
        (Form::Surface { surface, .. }, _) => {
            let (us, vs) = (surface.u().domain(), surface.v().domain());
            let at = |u: f64, v: f64| surface.point(u, v).ok().map(|p| p.coords);
            all.extend(even(us, ON_EDGE).filter_map(|u| Some((at(u, vs.0)?, "u ", text::number(u)))));
            all.extend(even(vs, ON_EDGE).filter_map(|v| Some((at(us.0, v)?, "v ", text::number(v)))));
        }
        _ => return,
    }
    all.retain(|(place, ..)| !sheet.hides(place));
    let ink = color(sheet, body, false).mixed(sheet.theme.ink(), 0.5);
    let spots: Vec<_> = all.iter().map(|(place, ..)| sheet.spot(place)).collect();
    sheet.put(Layer::Beads, &Stroke::plain(ink, 0.9).path("parameters", dots(&spots)).empty());
    // Where a shape is closed or comes to a point several places are one, which has one label.
    let mut places: Vec<(Spot, Vec<(&str, String)>)> = Vec::new();
    for (spot, (_, name, number)) in spots.into_iter().zip(all) {
        sheet.ink.segment(spot, spot, 6);
        let same = |(at, _): &&mut (Spot, _)| (at[0] - spot[0]).hypot(at[1] - spot[1]) < ONE;
        match places.iter_mut().find(same) {
            Some((_, said)) => said.push((name, number)),
            None => places.push((spot, vec![(name, number)])),
        }
    }
    for (anchor, said) in places {
        let lines = vec![words(&said)];
        sheet.labels.push(Label { anchor, lines, color: ink, dispensable: true });
    }
}

/// The parameters of one place: `0.4`, `u 0 and 6.28`, `u 0 to 6.28, v 1`.
fn words(said: &[(&str, String)]) -> String {
    let mut parts: Vec<String> = Vec::new();
    for name in ["", "u ", "v "] {
        let mut numbers: Vec<&str> =
            said.iter().filter(|(n, _)| *n == name).map(|(_, number)| number.as_str()).collect();
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
        let said = |list: &[(&'static str, &str)]| {
            words(&list.iter().map(|(name, number)| (*name, (*number).to_owned())).collect::<Vec<_>>())
        };
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
