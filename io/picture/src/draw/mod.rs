//! What is drawn, one kind of thing a module.

pub(crate) mod bead;
pub(crate) mod comb;
pub(crate) mod curve;
pub(crate) mod face;
pub(crate) mod legend;
mod light;
pub(crate) mod mark;
pub(crate) mod movement;
pub(crate) mod net;
pub(crate) mod paint;
pub(crate) mod parameter;
mod sides;
pub(crate) mod silhouette;
pub(crate) mod solid;
pub(crate) mod surface;
mod turns;

use loftsman_kernel::Vector;
use loftsman_kernel::scene::{Geometry, Unit};

use crate::chain::linked;
use crate::choices::Choices;
use crate::error::PictureError;
use crate::layout::Rect;
use crate::path::Spot;
use crate::sheet::{Fill, Layer, Sample, Sheet, Stroke, spread};
use crate::stage::body::{Body, Form};
use crate::stage::shell::Shell;
use crate::stage::{Ghost, Stage};
use crate::svg::Element;
use crate::text;
use crate::theme::{Color, Theme};
use crate::view::Lens;
use comb::Combing;
use paint::Painting;

/// Objects that the legend names; more are counted.
const NAMED: usize = 12;

/// What all that will be drawn takes up on the stage.
pub(crate) fn bounds(stage: &Stage<'_>, combs: &Combing, choices: &Choices) -> Rect {
    let mut rect = Rect::NONE;
    let surfaces = stage.surfaces();
    let lens = stage.projection.lens();
    let mut take = |p: &Vector| {
        let p = lens.flat(p);
        rect.take([p.x, p.y]);
    };
    let old = stage.old.iter().filter(|_| choices.old);
    for body in old.chain(stage.frames.iter().map(|(body, _)| body)).chain(&stage.new) {
        match &body.form {
            Form::Empty => {}
            Form::Curve { pieces, net, .. } => {
                let steps = (4096 / pieces.len().max(1)).clamp(2, 32);
                for piece in pieces {
                    for i in 0..=steps {
                        take(&piece.point(i as f64 / steps as f64));
                    }
                }
                if choices.control_polygons && body.vertices.is_empty() {
                    net.iter().for_each(&mut take);
                }
            }
            Form::Surface { surface, net, .. } => {
                surface::samples(surface, surfaces, 1).points.iter().for_each(&mut take);
                if choices.control_polygons && body.vertices.is_empty() {
                    net.iter().for_each(&mut take);
                }
            }
            Form::Polyline { points, .. }
            | Form::Mesh { points, .. }
            | Form::Solid(Shell { points, .. })
            | Form::Cloud(points) => {
                points.iter().for_each(&mut take);
            }
        }
        if choices.control_polygons {
            body.vertices.iter().for_each(&mut take);
        }
    }
    stage.moments.iter().for_each(&mut take);
    for light in &stage.marks {
        take(&light.position);
        take(&light.before);
    }
    combs.tips().for_each(|tip| take(&tip));
    // Glyphs have a size on the page: their share of a drawing of usual size has room on the stage.
    let [width, height] = rect.size();
    let reach = GLYPH * width.max(height);
    for light in &stage.marks {
        let at = lens.flat(&light.position);
        for [x, y] in mark::reaches(light, lens) {
            rect.take([at.x + x * reach, at.y + y * reach]);
        }
    }
    rect
}

/// The length of a mark's arrow, as a share of a drawing of usual size.
const GLYPH: f64 = 0.1;

/// Draws everything but labels and legend.
///
/// # Errors
/// When the image of the faces cannot be made.
pub(crate) fn draw(
    sheet: &mut Sheet,
    stage: &Stage<'_>,
    (combs, painting): (&Combing, &Painting),
    choices: &Choices,
    unit: Unit,
) -> Result<(), PictureError> {
    let (surfaces, lens) = (stage.surfaces(), stage.projection.lens());
    // First, so that it is known what the faces hide of the rest.
    face::draw(sheet, stage, painting)?;
    painting.explain(&mut sheet.caption, unit);
    for (index, body) in stage.new.iter().enumerate() {
        object(sheet, body, (false, lens), surfaces, choices.alternate, painting.fill(index));
    }
    for body in stage.old.iter().filter(|_| choices.old) {
        object(sheet, body, (true, lens), surfaces, false, None);
    }
    for (body, ghost) in &stage.frames {
        frame(sheet, body, *ghost, lens);
    }
    combs.draw(sheet, stage, unit);
    if choices.control_polygons {
        for body in stage.old.iter().filter(|_| choices.old) {
            net::draw(sheet, body, true);
        }
        for body in &stage.new {
            net::draw(sheet, body, false);
        }
    }
    if choices.movements {
        movement::draw(sheet, stage);
    }
    for body in &stage.new {
        bead::draw(sheet, body, choices.beads);
    }
    if choices.parameters {
        for body in &stage.new {
            parameter::draw(sheet, body);
        }
    }
    mark::draw(sheet, stage, choices.labels);
    Ok(())
}

/// The colour of a body; that of none where its points have colours of their own.
pub(crate) fn color(sheet: &Sheet, body: &Body<'_>, old: bool) -> Color {
    let color = match &body.form {
        Form::Mesh { colors, .. } if !colors.is_empty() => sheet.theme.faint(),
        Form::Solid(shell) => sheet.theme.object(body.index, shell.skin.color().or(body.object.color)),
        _ => sheet.theme.object(body.index, body.object.color),
    };
    if old { sheet.theme.old(color) } else { color }
}

/// Draws the lines and dots of an object and enters it in the legend; `painted`, what its faces show instead of its colour.
fn object(
    sheet: &mut Sheet,
    body: &Body<'_>,
    (old, lens): (bool, Lens),
    surfaces: usize,
    alternate: bool,
    painted: Option<Fill>,
) {
    let color = color(sheet, body, old);
    let layer = if old { Layer::Old } else { Layer::Curves };
    let stroke = Stroke::plain(color, if old { 0.4 } else { 0.5 });
    if let Some(missing) = &body.missing {
        sheet.caption.note(format!("{}: {missing}", text::clipped(body.object.name(), 30)));
    }
    let (element, sample) = match &body.form {
        Form::Empty => {
            if body.object.geometry().is_unknown() {
                let (name, kind) = (body.object.name(), body.object.geometry().kind());
                let [name, kind] = [name, kind].map(|text| text::clipped(text, 30));
                sheet
                    .caption
                    .note(format!("{name}: not drawn, the plug-in of its kind ({kind}) is not here"));
            }
            return;
        }
        Form::Curve { pieces, .. } if sheet.depth.is_some() => {
            let chains = curve::flattened(pieces, &sheet.layout);
            named(sheet, body, old, Sample::Line(stroke));
            parted(sheet, body, old, ("curve", stroke), &chains);
            return;
        }
        Form::Polyline { points, closed } if sheet.depth.is_some() => {
            let thin = Stroke { width: 0.3, ..stroke };
            let chain: Vec<Vector> =
                points.iter().chain(points.first().filter(|_| *closed)).copied().collect();
            named(sheet, body, old, Sample::Line(thin));
            parted(sheet, body, old, ("polyline", thin), &[chain]);
            return;
        }
        Form::Curve { pieces, .. } if alternate => {
            let pale = Stroke { color: color.mixed(sheet.theme.paper(), 0.55), ..stroke };
            let mut every = |first: usize, stroke: Stroke| {
                let pieces = pieces.iter().skip(first).step_by(2);
                stroke.path("curve", curve::trace(pieces, false, &sheet.layout, &mut sheet.ink))
            };
            let (even, odd) = (every(0, stroke), every(1, pale));
            // Butt ends: the pieces meet, they do not overlap.
            let group = Element::new("g").attribute("stroke-linecap", "butt");
            named(sheet, body, old, Sample::Alternate(stroke, pale));
            let name = Element::new("title").text(body.object.name());
            sheet.put(layer, &group.around(&(name + &even.empty() + &odd.empty())));
            return;
        }
        Form::Curve { pieces, closed, .. } => {
            let data = curve::trace(pieces, *closed, &sheet.layout, &mut sheet.ink);
            (stroke.path("curve", data), Sample::Line(stroke))
        }
        Form::Polyline { points, closed } => {
            let thin = Stroke { width: 0.3, ..stroke };
            let path = sheet.chain(points, *closed, 4);
            (thin.path("polyline", path.finish()), Sample::Line(thin))
        }
        Form::Cloud(points) if !old && points.len() <= FEW => {
            let seen: Vec<Spot> =
                points.iter().filter(|p| !sheet.hides(p)).map(|p| sheet.layout.spot(p)).collect();
            for [x, y] in &seen {
                sheet.ink.segment([x - 1.0, *y], [x + 1.0, *y], 8);
                sheet.ink.segment([*x, y - 1.0], [*x, y + 1.0], 8);
            }
            let name = Element::new("title").text(body.object.name());
            let group = Element::new("g").around(&(name + &few(sheet.theme, color, &seen, "cloud")));
            named(sheet, body, old, Sample::Spot(color));
            sheet.put(Layer::Points, &group);
            return;
        }
        Form::Cloud(points) => {
            let seen: Vec<Vector> = points.iter().filter(|p| !sheet.hides(p)).copied().collect();
            let kept = spread(seen.iter().map(|p| sheet.layout.spot(p)), 0.25, 20_000);
            kept.iter().for_each(|&spot| sheet.ink.segment(spot, spot, 2));
            sheet.note_thinned(body.object.name(), (kept.len(), seen.len()), (points.len(), "points"));
            let element = Stroke::plain(color, 0.7).path("cloud", dots(&kept));
            if !old {
                named(sheet, body, old, Sample::Dot(color));
                sheet.put(Layer::Clouds, &titled(element, body.object.name()));
                return;
            }
            (element, Sample::Dot(color))
        }
        Form::Surface { surface, trim, .. } if old => {
            let data = surface::wires(sheet, surface, trim.as_ref(), surfaces);
            let thin = Stroke { width: 0.2, ..stroke };
            (thin.path("surface", data), Sample::Line(thin))
        }
        Form::Mesh { points, corners, starts, lines, .. } if old => {
            let thin = Stroke { width: 0.12, ..stroke };
            match face::outlines(sheet, points, corners, starts, lines) {
                Some(data) => (thin.path("mesh", data), Sample::Line(thin)),
                None => {
                    let kept = spread(points.iter().map(|p| sheet.layout.spot(p)), 0.4, 20_000);
                    let all = points.len();
                    sheet.note_thinned(body.object.name(), (kept.len(), all), (all, "points"));
                    (Stroke::plain(color, 0.3).path("mesh", dots(&kept)), Sample::Dot(color))
                }
            }
        }
        Form::Solid(shell) if old => {
            let data = solid::wires(sheet, shell, lens);
            let thin = Stroke { width: 0.2, ..stroke };
            (thin.path(if shell.laid.is_some() { "surface" } else { "solid" }, data), Sample::Line(thin))
        }
        // The faces of all objects hide one another, so they are drawn together; the loose lines of a mesh are drawn as polylines are.
        Form::Mesh { points, starts, lines, .. } if !lines.is_empty() => {
            let thin = Stroke { width: 0.3, ..stroke };
            let fill = painted.unwrap_or(Fill::Plain(color));
            let sample = if starts.len() > 1 { Sample::Lined(fill, thin) } else { Sample::Line(thin) };
            named(sheet, body, old, sample);
            let chains: Vec<Vec<Vector>> = chained(points, lines).collect();
            parted(sheet, body, old, ("line", thin), &chains);
            return;
        }
        Form::Surface { .. } | Form::Mesh { .. } | Form::Solid(_) => {
            // Where they are painted their own colour is not seen but in their lines, which tell several apart.
            let lined = surfaces > 1 && !matches!(body.form, Form::Mesh { .. });
            let sample = match painted {
                Some(fill) if lined => Sample::Lined(fill, stroke),
                fill => Sample::Face(fill.unwrap_or(Fill::Plain(color))),
            };
            named(sheet, body, old, sample);
            return;
        }
    };
    named(sheet, body, old, sample);
    sheet.put(layer, &titled(element, body.object.name()));
}

/// The segments of a mesh's loose lines as chains, as long as they go.
fn chained(points: &[Vector], lines: &[(usize, usize)]) -> impl Iterator<Item = Vec<Vector>> {
    linked(lines).into_iter().map(|chain| chain.into_iter().map(|i| points[i]).collect())
}

/// Draws the lines of an object that faces may hide: what is hidden is thin, pale and dashed.
fn parted(
    sheet: &mut Sheet,
    body: &Body<'_>,
    old: bool,
    (class, stroke): (&str, Stroke),
    chains: &[Vec<Vector>],
) {
    let [mut seen, mut hidden] = [String::new(), String::new()];
    for chain in chains {
        let [more_seen, more_hidden] = sheet.parted(chain, 6);
        seen += &more_seen;
        hidden += &more_hidden;
    }
    let layer = if old { Layer::Old } else { Layer::Curves };
    let pale = Stroke::plain(stroke.color.mixed(sheet.theme.paper(), 0.35), 0.18);
    if !hidden.is_empty() && !old {
        sheet.caption.explain_once(Sample::Line(pale.dashed()), "hidden");
        sheet.put(layer, &titled(pale.dashed().path("hidden", hidden), body.object.name()));
    }
    sheet.put(layer, &titled(stroke.path(class, seen), body.object.name()));
}

/// The dashes of frames, in turn.
const DASHES: [&str; 4] = ["1.8 1", "0.3 0.9", "3 0.8 0.3 0.8", "0.9 0.6"];

/// Draws a frame of an animation: its lines, a mesh's outline, or its points as dots.
fn frame(sheet: &mut Sheet, body: &Body<'_>, ghost: Ghost, lens: Lens) {
    let own = color(sheet, body, false);
    let (color, width, dashes) = match ghost {
        Ghost::Dashed(number) => {
            let dashes = DASHES[(number - 1) % DASHES.len()];
            (own.mixed(sheet.theme.paper(), 0.25), 0.35, Some(dashes))
        }
        Ghost::Faded(share) => (sheet.theme.frame(own, share), 0.3, None),
    };
    let stroke = Stroke { color, width, dashes };
    let (data, stroke) = match &body.form {
        Form::Empty => return,
        Form::Curve { pieces, closed, .. } => {
            (curve::trace(pieces, *closed, &sheet.layout, &mut sheet.ink), stroke)
        }
        Form::Polyline { points, closed } => (sheet.chain(points, *closed, 3).finish(), stroke),
        Form::Surface { surface, trim, .. } => (
            surface::wires(sheet, surface, trim.as_ref(), 13),
            Stroke { width: 0.15, dashes: None, ..stroke },
        ),
        Form::Mesh { points, corners, starts, lines, .. } if starts.len() > 1 || !lines.is_empty() => {
            let mut data = silhouette::silhouette(sheet, lens, points, (corners, starts));
            for chain in chained(points, lines) {
                data += &sheet.chain(&chain, false, 3).finish();
            }
            (data, Stroke { width: 0.2, dashes: None, ..stroke })
        }
        Form::Solid(shell) => {
            (solid::wires(sheet, shell, lens), Stroke { width: 0.2, dashes: None, ..stroke })
        }
        Form::Mesh { points, .. } | Form::Cloud(points) => {
            let kept = spread(points.iter().map(|p| sheet.layout.spot(p)), 0.4, 5_000);
            (dots(&kept), Stroke { width: 0.4, dashes: None, ..stroke })
        }
    };
    match ghost {
        Ghost::Dashed(number) => sheet.caption.explain_once(Sample::Line(stroke), format!("frame {number}")),
        Ghost::Faded(_) => {
            let faint = Stroke { color: sheet.theme.frame(own, 0.6), ..stroke };
            sheet.caption.explain_once(Sample::Line(faint), "frames, the fainter the earlier");
        }
    }
    sheet.put(Layer::Frames, &titled(stroke.path("frame", data), body.object.name()));
}

/// An element with a name that browsers show under the pointer.
fn titled(element: Element, name: &str) -> String {
    element.around(&Element::new("title").text(name))
}

/// Enters an object in the legend.
pub(crate) fn named(sheet: &mut Sheet, body: &Body<'_>, old: bool, sample: Sample) {
    if body.index < NAMED {
        sheet.caption.name(sample, &text::clipped(body.object.name(), 40), old);
    } else if !old {
        sheet.caption.leave_unnamed(
            sample,
            &text::clipped(body.object.name(), 40),
            kind(body.object.geometry()),
        );
    }
}

/// What an object is, where several are counted.
fn kind(geometry: &Geometry) -> &'static str {
    match geometry {
        Geometry::Curve(_) => "curve[|s]",
        Geometry::Surface(_) | Geometry::Trimmed(_) => "surface[|s]",
        Geometry::Brep(_) => "brep[|s]",
        Geometry::Mesh(_) => "mesh[|es]",
        Geometry::Polyline(_) => "polyline[|s]",
        Geometry::Cloud(_) => "cloud[|s]",
        _ => "object[|s]",
    }
}

/// So many loose points of an object, and no more, are drawn above lines and larger than the dots of a cloud: what was found where things
/// meet is looked for.
const FEW: usize = 24;

/// A few points that are to be seen, with paper around each.
fn few(theme: Theme, color: Color, spots: &[Spot], class: &str) -> String {
    let data = dots(spots);
    Stroke::plain(theme.paper(), 2.3).path("halo", data.clone()).empty()
        + &Stroke::plain(color, 1.6).path(class, data.clone()).empty()
        + &Stroke::plain(theme.paper(), 0.45).path("point-holes", data).empty()
}

/// Path data of dots: segments too short to see, whose round caps are the dots.
pub(crate) fn dots(spots: &[[f64; 2]]) -> String {
    use crate::svg::length;
    spots.iter().map(|[x, y]| format!("M{} {}h.001", length(*x), length(*y))).collect()
}
