//! Control polygons and nets: thin lines with small squares at the control vertices.

use loftsman_kernel::Vector;

use crate::draw::color;
use crate::sheet::{Layer, Sample, Sheet, Stroke, spread};
use crate::stage::body::{Body, Form};
use crate::svg::{Element, length};
use crate::theme::Color;

/// The side of a square, in millimetres.
const SIDE: f64 = 1.2;

/// The most squares of an object.
const MOST: usize = 2000;

/// Draws the control polygon or net of a curve or surface, and the control vertices of a plug-in's shape.
pub(crate) fn draw(sheet: &mut Sheet, body: &Body<'_>, old: bool) {
    let mut data = [String::new(), String::new()];
    let mut add = |sheet: &mut Sheet, chain: Vec<Vector>, closed: bool, weight: u16| {
        let first = chain.first().copied().filter(|_| closed);
        let parts = sheet.parted(chain.iter().chain(&first), weight);
        data.iter_mut().zip(parts).for_each(|(data, part)| data.push_str(&part));
    };
    let points: &[Vector] = match &body.form {
        // Which vertices of a plug-in's shape are neighbours nobody guesses: without edges they are squares alone.
        _ if !body.vertices.is_empty() => {
            for [a, b] in &body.edges {
                add(sheet, vec![body.vertices[*a], body.vertices[*b]], false, 1);
            }
            &body.vertices
        }
        Form::Curve { net, closed, .. } => {
            add(sheet, net.clone(), *closed, 2);
            net
        }
        Form::Surface { net, grid, .. } => {
            let columns = grid.columns.max(1);
            for row in net.chunks(columns) {
                add(sheet, row.to_vec(), grid.columns_wrap, 1);
            }
            for column in 0..grid.columns {
                add(sheet, net.iter().skip(column).step_by(columns).copied().collect(), grid.rows_wrap, 1);
            }
            net
        }
        _ => return,
    };
    let theme = sheet.theme;
    let base = color(sheet, body, old);
    let tone = if old { base.mixed(theme.paper(), 0.3) } else { base.mixed(theme.ink(), 0.35) };
    let (layer, width) = if old { (Layer::Old, 0.14) } else { (Layer::Nets, 0.16) };
    let stroke = Stroke::plain(tone, width);
    let [seen, hidden] = data;
    // What faces hide of a net shows through them, pale: half a net would be hard to read.
    let pale = Stroke { color: tone.mixed(theme.paper(), 0.55), ..stroke };
    let (front, back): (Vec<Vector>, Vec<Vector>) = points.iter().partition(|p| !sheet.hides(p));
    // Those that are one behind the other in this view are one.
    let apart = spread(points.iter().map(|p| sheet.layout.spot(p)), 0.05, usize::MAX).len();
    let spots = |points: &[Vector], most: usize| {
        spread(points.iter().map(|p| sheet.layout.spot(p)), SIDE * 0.75, most)
    };
    let (kept, through) = (spots(&front, MOST), spots(&back, MOST / 2));
    if !hidden.is_empty() && !old {
        sheet.put(layer, &pale.path("control-polygon-hidden", hidden).empty());
        sheet.put(layer, &squares(&through, None, pale.color, 0.18));
    }
    sheet.put(layer, &stroke.path("control-polygon", seen).empty());
    sheet.put(layer, &squares(&kept, Some(theme.paper()), tone, if old { 0.16 } else { 0.22 }));
    for &spot in &kept {
        for side in [-0.5 * SIDE, 0.5 * SIDE] {
            sheet.ink.segment(
                [spot[0] - 0.5 * SIDE, spot[1] + side],
                [spot[0] + 0.5 * SIDE, spot[1] + side],
                4,
            );
        }
    }
    let shown = kept.len() + through.len();
    sheet.note_thinned(body.object.name(), (shown, apart), (points.len(), "control vertices"));
    if !old {
        let what = match body.form {
            _ if !body.edges.is_empty() => "control cage",
            _ if !body.vertices.is_empty() => "control vertices",
            Form::Curve { .. } => "control polygon",
            _ => "control net",
        };
        sheet.caption.explain_once(Sample::Net(stroke), what);
    }
}

/// Small squares about places of the page.
fn squares(spots: &[[f64; 2]], fill: Option<Color>, color: Color, width: f64) -> String {
    let half = SIDE / 2.0;
    let data: String = spots
        .iter()
        .map(|[x, y]| format!("M{} {}h{SIDE}v{SIDE}h-{SIDE}z", length(x - half), length(y - half)))
        .collect();
    Element::new("path")
        .attribute("class", "control-vertices")
        .attribute("d", &data)
        .attribute("fill", &fill.map_or_else(|| "none".to_owned(), Color::hex))
        .attribute("stroke", &color.hex())
        .length("stroke-width", width)
        .empty()
}
