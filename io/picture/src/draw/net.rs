//! Control polygons and nets: thin lines with small squares at the control vertices.

use loftsman_kernel::Vector;

use crate::draw::color;
use crate::draw::mark::arrow;
use crate::path::Path;
use crate::sheet::{Layer, Sample, Sheet, Stroke, spread};
use crate::stage::Stage;
use crate::stage::body::{Body, Form};
use crate::svg::{Element, length};

/// The side of a square, in millimetres.
const SIDE: f64 = 1.2;

/// The most squares of an object.
const MOST: usize = 2000;

/// Draws the control polygon or net of a curve or surface.
pub(crate) fn draw(sheet: &mut Sheet, body: &Body<'_>, old: bool) {
    let (points, paths): (&[Vector], Vec<Path>) = match &body.form {
        Form::Curve { net, closed, .. } => (net, vec![sheet.chain(net, *closed, 2)]),
        Form::Surface { net, grid, .. } => {
            let mut paths = Vec::new();
            for row in net.chunks(grid.columns.max(1)) {
                paths.push(sheet.chain(row, grid.columns_wrap, 1));
            }
            for column in 0..grid.columns {
                let along = net.iter().skip(column).step_by(grid.columns.max(1));
                paths.push(sheet.chain(along, grid.rows_wrap, 1));
            }
            (net, paths)
        }
        _ => return,
    };
    let theme = sheet.theme;
    let base = color(sheet, body, old);
    let tone = if old { base.mixed(theme.paper(), 0.3) } else { base.mixed(theme.ink(), 0.35) };
    let (layer, width) = if old { (Layer::Old, 0.14) } else { (Layer::Nets, 0.16) };
    let stroke = Stroke::plain(tone, width);
    let data: String = paths.into_iter().map(Path::finish).collect();
    sheet.put(layer, &stroke.path("control-polygon", data).empty());

    let half = SIDE / 2.0;
    let places = points.iter().map(|p| sheet.layout.spot(p));
    let kept = spread(places, SIDE * 0.75, MOST);
    let squares: String = kept
        .iter()
        .map(|[x, y]| format!("M{} {}h{SIDE}v{SIDE}h-{SIDE}z", length(x - half), length(y - half)))
        .collect();
    let element = Element::new("path")
        .attribute("class", "control-vertices")
        .attribute("d", &squares)
        .attribute("fill", &theme.paper().hex())
        .attribute("stroke", &tone.hex())
        .length("stroke-width", if old { 0.16 } else { 0.22 });
    sheet.put(layer, &element.empty());
    for &spot in &kept {
        sheet.ink.segment(spot, spot, 4);
    }
    sheet.told.note_thinned(body.object.name(), (kept.len(), "squares"), (points.len(), "control vertices"));
    if !old {
        let what = if matches!(body.form, Form::Curve { .. }) { "control polygon" } else { "control net" };
        sheet.told.explain_once(Sample::Net(stroke), what);
    }
}

/// Arrows from each control vertex before to where it is now; none where they are too many to see or too short.
pub(crate) fn movements(sheet: &mut Sheet, stage: &Stage<'_>) {
    let net = |body: &Body<'_>| match &body.form {
        Form::Curve { net, .. } | Form::Surface { net, .. } => net.clone(),
        _ => Vec::new(),
    };
    let color = sheet.theme.accent().mixed(sheet.theme.paper(), 0.25).hex();
    let mut out = String::new();
    for old in &stage.old {
        let Some(new) = stage.new.iter().find(|new| new.object.name() == old.object.name()) else { continue };
        let (from, to) = (net(old), net(new));
        if from.len() != to.len() || from.len() > MOST {
            continue;
        }
        for (from, to) in from.iter().zip(&to) {
            let (from, to) = (sheet.spot(from), sheet.spot(to));
            if (to[0] - from[0]).hypot(to[1] - from[1]) >= 0.25 {
                sheet.ink.segment(from, to, 4);
                out.push_str(&arrow(from, to, color.clone(), 0.22));
            }
        }
    }
    if !out.is_empty() {
        sheet.put(Layer::Nets, &out);
        sheet.told.explain_once(Sample::Movement, "control vertex moved");
    }
}
