//! Faces of surfaces and meshes: shaded, the far ones first, so that the near ones hide them (painter's order).

use loftsman_kernel::Vector;
use loftsman_kernel::spline::{Space, Surface};

use crate::draw::color;
use crate::path::{Path, Spot};
use crate::sheet::{Layer, Sheet};
use crate::stage::Stage;
use crate::stage::body::Form;
use crate::svg::Element;
use crate::theme::Color;

/// At least about this many isoparametric lines each way, and at most twice as many.
const LINES: usize = 8;

/// Cells from one isoparametric line to the next, so that lines look round.
const CELLS: usize = 6;

/// Levels of shading: faces of one level share their colour, which keeps documents small.
const LEVELS: f64 = 24.0;

/// A surface on a grid whose every `CELLS`-th row and column is an isoparametric line.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Row after row.
    pub(crate) points: Vec<Vector>,
    columns: usize,
    /// Which rows and columns are lines: 0 none, 1 a line, 2 a border.
    row_kind: Vec<u8>,
    column_kind: Vec<u8>,
}

/// Samples a surface.
pub(crate) fn samples(surface: &Surface) -> Samples {
    let (u, row_kind) = parameters(surface.u());
    let (v, column_kind) = parameters(surface.v());
    let mut points = Vec::with_capacity(u.len() * v.len());
    for &u in &u {
        for &v in &v {
            // The parameters are in the domain; a failure could only repeat the point before.
            let last = points.last().copied().unwrap_or_else(Vector::zeros);
            points.push(surface.point(u, v).map_or(last, |p| p.coords));
        }
    }
    Samples { points, columns: v.len(), row_kind, column_kind }
}

/// Parameters of a grid in one direction: lines at knots where their number is right, more between few knots,
/// fewer of many.
fn parameters(space: &Space) -> (Vec<f64>, Vec<u8>) {
    let breaks = space.breakpoints();
    let spans = breaks.len() - 1;
    let lines: Vec<f64> = if spans > 2 * LINES {
        let step = spans.div_ceil(2 * LINES);
        let mut lines: Vec<f64> = breaks.iter().copied().step_by(step).collect();
        if !spans.is_multiple_of(step) {
            lines.push(breaks[spans]);
        }
        lines
    } else {
        subdivided(&breaks, LINES.div_ceil(spans))
    };
    let all = subdivided(&lines, CELLS);
    let last = all.len() - 1;
    let border = if space.is_periodic() { 1 } else { 2 };
    let kind =
        (0..=last).map(|i| if i == 0 || i == last { border } else { u8::from(i % CELLS == 0) }).collect();
    (all, kind)
}

/// The values with `parts - 1` even steps between each two.
fn subdivided(values: &[f64], parts: usize) -> Vec<f64> {
    let between = |pair: &[f64]| {
        let (a, b) = (pair[0], pair[1]);
        (0..parts).map(move |i| a + (b - a) * (i as f64 / parts as f64)).collect::<Vec<_>>()
    };
    let mut all: Vec<f64> = values.windows(2).flat_map(between).collect();
    all.extend(values.last());
    all
}

/// A polygon of the page that hides what is behind it.
struct Face {
    depth: f64,
    corners: Vec<Spot>,
    fill: Color,
    /// Sides to be drawn: index of the first corner, width, colour.
    sides: Vec<(usize, f64)>,
    line: Color,
}

/// Draws the faces of all surfaces and meshes together.
pub(crate) fn draw(sheet: &mut Sheet, stage: &Stage<'_>) {
    let mut faces = Vec::new();
    for body in &stage.new {
        let base = color(sheet, body, false);
        match &body.form {
            Form::Surface { surface, .. } => of_surface(sheet, &samples(surface), base, &mut faces),
            Form::Mesh { points, corners, starts } => {
                of_mesh(sheet, points, corners, starts, base, &mut faces);
            }
            _ => {}
        }
    }
    // A stable sort by depth: equal depths keep the order of the scene.
    faces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let mut out = String::new();
    for face in &faces {
        paint(face, &mut out);
    }
    if !out.is_empty() {
        sheet.put(Layer::Faces, &out);
    }
}

fn paint(face: &Face, out: &mut String) {
    let mut path = Path::default();
    face.corners.iter().for_each(|&spot| path.line_to(spot));
    path.close();
    let fill = face.fill.hex();
    // A hair of the same colour closes the seams that anti-aliasing leaves between neighbours.
    let polygon = Element::new("path")
        .attribute("d", &path.finish())
        .attribute("fill", &fill)
        .attribute("stroke", &fill)
        .length("stroke-width", 0.06);
    out.push_str(&polygon.empty());
    for width in [0.12, 0.35] {
        let mut path = Path::default();
        for &(side, _) in face.sides.iter().filter(|(_, w)| *w == width) {
            path.move_to(face.corners[side]);
            path.line_to(face.corners[(side + 1) % face.corners.len()]);
        }
        let data = path.finish();
        if !data.is_empty() {
            let element = Element::new("path")
                .attribute("d", &data)
                .attribute("fill", "none")
                .attribute("stroke", &face.line.hex())
                .length("stroke-width", width);
            out.push_str(&element.empty());
        }
    }
}

fn of_surface(sheet: &mut Sheet, grid: &Samples, base: Color, faces: &mut Vec<Face>) {
    let columns = grid.columns;
    let width = |kind: u8| match kind {
        0 => None,
        1 => Some(0.12),
        _ => Some(0.35),
    };
    for row in 0..grid.row_kind.len() - 1 {
        for column in 0..columns - 1 {
            let at = row * columns + column;
            let corners = [at, at + 1, at + columns + 1, at + columns].map(|i| grid.points[i]);
            let kinds = [
                grid.row_kind[row],
                grid.column_kind[column + 1],
                grid.row_kind[row + 1],
                grid.column_kind[column],
            ];
            let sides = kinds.into_iter().enumerate().filter_map(|(i, k)| Some((i, width(k)?))).collect();
            faces.push(face(sheet, &corners, sides, base));
        }
    }
}

fn of_mesh(
    sheet: &mut Sheet,
    points: &[Vector],
    corners: &[u32],
    starts: &[usize],
    base: Color,
    faces: &mut Vec<Face>,
) {
    for range in starts.windows(2) {
        let corners: Vec<Vector> = corners[range[0]..range[1]].iter().map(|&i| points[i as usize]).collect();
        let sides = (0..corners.len()).map(|i| (i, 0.12)).collect();
        faces.push(face(sheet, &corners, sides, base));
    }
}

/// A face with its depth and light, which also leaves its ink.
fn face(sheet: &mut Sheet, corners: &[Vector], sides: Vec<(usize, f64)>, base: Color) -> Face {
    let count = corners.len() as f64;
    let depth = corners.iter().map(|p| p.z).sum::<f64>() / count;
    // Newell's normal: right for faces that are neither plane nor triangles.
    let normal = (0..corners.len()).fold(Vector::zeros(), |sum, i| {
        let (a, b) = (corners[i] - corners[0], corners[(i + 1) % corners.len()] - corners[0]);
        sum + a.cross(&b)
    });
    let towards_light = Vector::new(-0.45, 0.55, 0.7);
    let light = normal.dot(&towards_light).abs() / normal.norm();
    let light = if light.is_finite() { (light * LEVELS).round() / LEVELS } else { 0.0 };
    let spots: Vec<Spot> = corners.iter().map(|p| sheet.layout.spot(p)).collect();
    for (i, &spot) in spots.iter().enumerate() {
        sheet.ink.segment(spot, spots[(i + 1) % spots.len()], 1);
    }
    let fill = sheet.theme.lit(base, light);
    Face { depth, corners: spots, fill, sides, line: base.mixed(sheet.theme.ink(), 0.25) }
}

/// The isoparametric lines of a surface that hides nothing.
pub(crate) fn wires(sheet: &mut Sheet, surface: &Surface) -> String {
    let grid = samples(surface);
    let mut data = String::new();
    let rows = grid.row_kind.len();
    for row in (0..rows).filter(|&r| grid.row_kind[r] > 0) {
        let line = &grid.points[row * grid.columns..(row + 1) * grid.columns];
        data.push_str(&sheet.chain(line, false, 1).finish());
    }
    for column in (0..grid.columns).filter(|&c| grid.column_kind[c] > 0) {
        let line = grid.points.iter().skip(column).step_by(grid.columns);
        data.push_str(&sheet.chain(line, false, 1).finish());
    }
    data
}

/// The edges of a mesh that hides nothing, each once.
pub(crate) fn outlines(sheet: &mut Sheet, points: &[Vector], corners: &[u32], starts: &[usize]) -> String {
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(corners.len());
    for range in starts.windows(2) {
        let face = &corners[range[0]..range[1]];
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            edges.push((a.min(b), a.max(b)));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let mut path = Path::default();
    for (a, b) in edges {
        let (from, to) = (sheet.spot(&points[a as usize]), sheet.spot(&points[b as usize]));
        sheet.ink.segment(from, to, 1);
        path.move_to(from);
        path.line_to(to);
    }
    path.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_neither_few_nor_many() {
        for spans in [1, 2, 7, 16, 17, 40, 1000] {
            let breaks: Vec<f64> = (0..=spans).map(f64::from).collect();
            let (all, kinds) = parameters(&Space::clamped(3, &breaks).unwrap());
            let lines = kinds.iter().filter(|k| **k > 0).count();
            assert!((LINES..=2 * LINES + 2).contains(&lines), "{spans}: {lines}");
            assert_eq!((all[0], all[all.len() - 1]), (0.0, f64::from(spans)));
            assert!(all.windows(2).all(|w| w[0] < w[1]));
            assert_eq!(all.len(), kinds.len());
        }
    }
}
