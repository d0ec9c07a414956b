//! Breps and surfaces of plug-ins: faces lit by the normals of their surfaces, their edges, and where they turn away from the viewer.

use loftsman_kernel::Vector;

use crate::depth::{Depth, ON_EDGE, Run};
use crate::draw::face::{Copies, LONG, Lines, Weight, trace};
use crate::draw::light::{light, tone, tones};
use crate::draw::paint::Brush;
use crate::draw::turns::Turns;
use crate::path::Path;
use crate::sheet::Sheet;
use crate::stage::shell::{Kind, Shell};
use crate::theme::Color;
use crate::view::Lens;

/// Draws the faces, and adds the lines.
pub(super) fn draw(
    shell: &Shell,
    (base, brush): (&[Color], Option<Brush<'_>>),
    (sheet, lens): (&Sheet, Lens),
    (depth, copies): (&mut Depth, &mut Copies),
    lines: &mut Lines,
) {
    let Shell { skin, points, normals, .. } = shell;
    let places: Vec<Vector> = points.iter().map(|p| sheet.layout.place(p)).collect();
    let own = |color: &Option<[f64; 4]>| match color {
        None => base.to_vec(),
        color => tones(sheet.theme, sheet.theme.object(0, *color)),
    };
    let colors: Vec<Vec<Color>> = skin.colors.iter().map(own).collect();
    let mut any = false;
    for (number, (triangle, slot)) in skin.triangles.iter().zip(&skin.slots).enumerate() {
        let at = triangle.map(|i| i as usize);
        let corners = at.map(|i| places[i]);
        if !copies.is_new(&corners) {
            continue;
        }
        any = true;
        let tones = colors.get(*slot as usize).map_or(base, Vec::as_slice);
        let [p, q, r] = at.map(|i| normals[i]);
        let [a, b, c] = at.map(|i| points[i]);
        depth.triangle([&corners[0], &corners[1], &corners[2]], |v, w| {
            let normal = p + (q - p) * v + (r - p) * w;
            Some(match &brush {
                None => tone(tones, &normal),
                Some(brush) => {
                    let point = a + (b - a) * v + (c - a) * w;
                    brush.color(shell.painted_at(number), [v, w], &normal, (lens, &point), light(&normal))
                }
            })
        });
    }
    if any {
        lines.chains.extend(outlines(shell, lens, &places));
    }
}

/// The edges of a shell and its outline, as chains of places on the page. Borders of a surface's faces between which it goes on are its
/// isoparametric lines, left out where they would be a smear.
fn outlines(shell: &Shell, lens: Lens, places: &[Vector]) -> Vec<(Weight, Vec<Vector>)> {
    let Shell { skin, points, normals, laid } = shell;
    let facing: Vec<f64> = points.iter().zip(normals).map(|(p, n)| n.dot(&lens.toward(p))).collect();
    let mut turns = Turns::default();
    for triangle in &skin.triangles {
        turns.triangle(triangle.map(|i| i as usize), &facing, places);
    }
    let mut all: Vec<(Weight, Vec<Vector>)> =
        turns.chains().into_iter().map(|chain| (Weight::Outline, chain)).collect();
    let is_front = |triangle: u32| {
        let [a, b, c] = skin.triangles[triangle as usize].map(|i| points[i as usize]);
        (b - a).cross(&(c - a)).dot(&lens.toward(&a)) > 0.0
    };
    let place = |i: &u32| places[*i as usize];
    for edge in &skin.edges {
        let weight = match edge.kind {
            Kind::Sharp => Some(Weight::Outline),
            Kind::Smooth => Some(Weight::Inner),
            Kind::Open => Some(Weight::Border),
            Kind::Within => None,
        };
        all.extend(weight.map(|weight| (weight, edge.points.iter().map(place).collect())));
        // A smooth edge may be the outline itself, to rounding.
        for (segment, [one, other]) in edge.points.windows(2).zip(&edge.beside) {
            if is_front(*one) != is_front(*other) {
                all.push((Weight::Outline, segment.iter().map(place).collect()));
            }
        }
    }
    if let Some(laid) = laid {
        let inner = all.iter().filter(|(weight, _)| *weight == Weight::Inner);
        let segments = inner.flat_map(|(_, chain)| chain.windows(2));
        let length: f64 = segments.map(|s| (s[1] - s[0]).xy().norm()).sum();
        if length < LONG * laid.sides as f64 {
            all.retain(|(weight, _)| *weight != Weight::Inner);
        }
    }
    all
}

/// The edges and the outline of a shell that hides nothing, as far as no face hides them and no line of what is there runs along them, as path data: of a surface with
/// the borders of its faces.
pub(super) fn wires(sheet: &mut Sheet, shell: &Shell, lens: Lens) -> String {
    let places: Vec<Vector> = shell.points.iter().map(|p| sheet.layout.place(p)).collect();
    let mut path = Path::default();
    for (weight, chain) in outlines(shell, lens, &places) {
        if weight == Weight::Inner && shell.laid.is_none() {
            continue;
        }
        let runs = match &sheet.depth {
            Some(depth) => depth.runs(chain, ON_EDGE),
            None => vec![Run { seen: true, spots: chain.iter().map(|p| [p.x, p.y]).collect() }],
        };
        for run in runs.into_iter().filter(|run| run.seen) {
            for spots in sheet.traces.apart(&run.spots) {
                trace(sheet, &Run { seen: true, spots }, &mut path);
            }
        }
    }
    path.finish()
}
