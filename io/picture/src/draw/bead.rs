//! Beads on curves: at the knots, or uniform in the parameter.

use loftsman_kernel::Vector;

use crate::choices::Beads;
use crate::draw::{color, dots};
use crate::sheet::{Layer, Sample, Sheet, Stroke, spread};
use crate::stage::body::{Body, Form};

/// The most beads of a curve.
const MOST: usize = 2000;

/// Draws the beads of a curve.
pub(crate) fn draw(sheet: &mut Sheet, body: &Body<'_>, beads: Beads) {
    let Form::Curve { pieces, closed, .. } = &body.form else { return };
    let each = match beads {
        Beads::Off | Beads::Uniform(0) => return,
        Beads::Knots => 1,
        // More would only be thinned out again.
        Beads::Uniform(count) => count.min(1000),
    };
    let mut all = 0_usize;
    let mut places: Vec<Vector> = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        places.extend((0..each).map(|i| piece.point(i as f64 / each as f64)));
        all += each;
        // Where the curve is torn the knot is at both ends.
        if pieces.get(index + 1).is_some_and(|next| !piece.meets(next)) {
            places.push(piece.point(1.0));
            all += 1;
        }
    }
    if let Some(last) = pieces.last().filter(|_| !closed) {
        places.push(last.point(1.0));
        all += 1;
    }
    places.retain(|place| !sheet.hides(place));
    let spots = places.iter().map(|p| sheet.layout.spot(p));
    let kept = spread(spots, 0.8, MOST);
    let color = color(sheet, body, false);
    let data = dots(&kept);
    sheet.put(Layer::Beads, &Stroke::plain(color, 1.4).path("beads", data.clone()).empty());
    let inner = Stroke::plain(sheet.theme.paper(), 0.7).path("bead-holes", data);
    sheet.put(Layer::Beads, &inner.empty());
    for &spot in &kept {
        sheet.ink.segment(spot, spot, 6);
    }
    let things = if beads == Beads::Knots { "knots" } else { "beads" };
    sheet.note_thinned(body.object.name(), (kept.len(), all), (all, things));
    let words = match beads {
        Beads::Uniform(count) => format!("{count} beads a knot span, uniform in the parameter"),
        _ => "knot".to_owned(),
    };
    sheet.caption.explain_once(Sample::Bead(color), words);
}
