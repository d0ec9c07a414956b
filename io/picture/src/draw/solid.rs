//! Breps: faces lit by the normals of their surfaces, their edges, and where they turn away from the viewer.

use loftsman_kernel::Vector;

use crate::depth::{Depth, ON_EDGE};
use crate::draw::chain::Turns;
use crate::draw::face::{Copies, Lines, Weight, trace};
use crate::draw::light::{light, tone, tones};
use crate::draw::paint::Brush;
use crate::path::Path;
use crate::sheet::Sheet;
use crate::stage::solid::{Kind, Solid};
use crate::theme::Color;
use crate::view::Lens;

/// Draws the faces, and adds the lines.
pub(super) fn draw(
    (solid, points, normals): (&Solid, &[Vector], &[Vector]),
    (base, brush): (&[Color], Option<Brush<'_>>),
    (sheet, lens): (&Sheet, Lens),
    (depth, copies): (&mut Depth, &mut Copies),
    lines: &mut Lines,
) {
    let places: Vec<Vector> = points.iter().map(|p| sheet.layout.place(p)).collect();
    let own = |color: &Option<[f64; 4]>| match color {
        None => base.to_vec(),
        color => tones(sheet.theme, sheet.theme.object(0, *color)),
    };
    let colors: Vec<Vec<Color>> = solid.colors.iter().map(own).collect();
    let mut any = false;
    for (triangle, slot) in solid.triangles.iter().zip(&solid.slots) {
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
                    brush.color(at, [v, w], &normal, (lens, &point), light(&normal))
                }
            })
        });
    }
    if any {
        lines.chains.extend(outlines((solid, points, normals), lens, &places));
    }
}

/// The edges of a solid and its outline, as chains of places on the page.
fn outlines(
    (solid, points, normals): (&Solid, &[Vector], &[Vector]),
    lens: Lens,
    places: &[Vector],
) -> Vec<(Weight, Vec<Vector>)> {
    let facing: Vec<f64> = points.iter().zip(normals).map(|(p, n)| n.dot(&lens.toward(p))).collect();
    let mut turns = Turns::default();
    for triangle in &solid.triangles {
        turns.triangle(triangle.map(|i| i as usize), &facing, places);
    }
    let mut all: Vec<(Weight, Vec<Vector>)> =
        turns.chains().into_iter().map(|chain| (Weight::Outline, chain)).collect();
    let is_front = |triangle: u32| {
        let [a, b, c] = solid.triangles[triangle as usize].map(|i| points[i as usize]);
        (b - a).cross(&(c - a)).dot(&lens.toward(&a)) > 0.0
    };
    let place = |i: &u32| places[*i as usize];
    for edge in &solid.edges {
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
    all
}

/// The edges and the outline of a solid that hides nothing, as far as no face hides them, as path data.
pub(super) fn wires(sheet: &mut Sheet, solid: (&Solid, &[Vector], &[Vector]), lens: Lens) -> String {
    let places: Vec<Vector> = solid.1.iter().map(|p| sheet.layout.place(p)).collect();
    let mut path = Path::default();
    for (weight, chain) in outlines(solid, lens, &places) {
        if weight == Weight::Inner {
            continue;
        }
        let runs = match &sheet.depth {
            Some(depth) => depth.runs(chain, ON_EDGE),
            None => vec![crate::depth::Run { seen: true, spots: chain.iter().map(|p| [p.x, p.y]).collect() }],
        };
        for run in runs {
            trace(sheet, &run, &mut path);
        }
    }
    path.finish()
}
