//! Faces of surfaces and meshes: shaded, the far ones first, so that the near ones hide them (painter's order).

use loftsman_kernel::Vector;

use crate::draw::color;
use crate::draw::raster::Raster;
use crate::draw::surface::{Line, Samples, samples};
use crate::path::{Path, Spot};
use crate::sheet::{Layer, Sheet};
use crate::stage::Stage;
use crate::stage::body::Form;
use crate::svg::Element;
use crate::theme::Color;

/// Levels of shading: faces of one level share their colour, which keeps documents small.
const LEVELS: f64 = 48.0;

/// The most faces that are drawn one by one; more become a raster.
const MOST: usize = 30_000;

/// Widths of lines on faces, in millimetres: isoparametric lines and edges; outlines, where a surface turns
/// away from the viewer; borders.
const WIDTHS: [f64; 3] = [0.12, 0.25, 0.35];

/// A polygon on the stage.
struct Face {
    corners: Vec<Vector>,
    color: Color,
    /// The width of each side that is drawn, as an index of `WIDTHS`: the side from corner `i` to the next.
    sides: Vec<(usize, usize)>,
    /// How near the viewer it is: the mean of its corners.
    depth: f64,
}

impl Face {
    fn new(corners: Vec<Vector>, color: Color, sides: Vec<(usize, usize)>) -> Self {
        let depth = corners.iter().map(|p| p.z).sum::<f64>() / corners.len() as f64;
        Self { corners, color, sides, depth }
    }
}

/// The faces so far: a list, or a raster when they have become too many.
#[derive(Default)]
struct Faces {
    list: Vec<Face>,
    raster: Option<Raster>,
    count: usize,
}

impl Faces {
    fn add(&mut self, sheet: &Sheet, face: Face) {
        self.count += 1;
        self.list.push(face);
        if self.count > MOST {
            let raster = self.raster.get_or_insert_with(|| Raster::new(sheet.layout.area));
            for face in self.list.drain(..) {
                let flat = |p: &Vector| {
                    let [x, y] = sheet.spot(p);
                    Vector::new(x, y, p.z)
                };
                let corners: Vec<Vector> = face.corners.iter().map(flat).collect();
                raster.add(&corners, sheet.theme.lit(face.color, light(&face.corners)));
            }
        }
    }
}

/// Draws the faces of all surfaces and meshes together.
pub(crate) fn draw(sheet: &mut Sheet, stage: &Stage<'_>) {
    let surfaces = stage.surfaces();
    let mut faces = Faces::default();
    for body in &stage.new {
        let base = color(sheet, body, false);
        let mut add = |corners, sides| faces.add(sheet, Face::new(corners, base, sides));
        match &body.form {
            Form::Surface { surface, .. } => of_surface(&samples(surface, surfaces), &mut add),
            Form::Mesh { points, corners, starts } => {
                for range in starts.windows(2) {
                    let corners: Vec<Vector> =
                        corners[range[0]..range[1]].iter().map(|&i| points[i as usize]).collect();
                    let sides = (0..corners.len()).map(|i| (i, 0)).collect();
                    add(corners, sides);
                }
            }
            _ => {}
        }
    }
    let Faces { mut list, raster, count } = faces;
    if let Some(raster) = raster {
        sheet.told.note(format!("{count} faces are drawn as a shaded raster"));
        let content = raster.finish(&mut sheet.ink);
        sheet.put(Layer::Faces, &content);
        return;
    }
    // A stable sort: equal depths keep the order of the scene.
    list.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let mut out = String::new();
    for face in &list {
        paint(sheet, face, &mut out);
    }
    if !out.is_empty() {
        // A hair of its own colour around each face closes the seams that anti-aliasing leaves between them.
        let group = Element::new("g").length("stroke-width", 0.06);
        sheet.put(Layer::Faces, &group.around(&out));
    }
}

fn paint(sheet: &mut Sheet, face: &Face, out: &mut String) {
    let spots: Vec<Spot> = face.corners.iter().map(|p| sheet.spot(p)).collect();
    for (i, &spot) in spots.iter().enumerate() {
        sheet.ink.segment(spot, spots[(i + 1) % spots.len()], 1);
    }
    let mut path = Path::default();
    spots.iter().for_each(|&spot| path.line_to(spot));
    path.close();
    let fill = sheet.theme.lit(face.color, light(&face.corners)).hex();
    let polygon = Element::new("path").attribute("d", &path.finish()).attribute("fill", &fill);
    out.push_str(&polygon.attribute("stroke", &fill).empty());
    let line = face.color.mixed(sheet.theme.ink(), 0.25).hex();
    for (width, millimetres) in WIDTHS.into_iter().enumerate() {
        let mut path = Path::default();
        for &(side, _) in face.sides.iter().filter(|(_, w)| *w == width) {
            path.move_to(spots[side]);
            path.line_to(spots[(side + 1) % spots.len()]);
        }
        let data = path.finish();
        if !data.is_empty() {
            let element = Element::new("path").attribute("d", &data).attribute("fill", "none");
            out.push_str(&element.attribute("stroke", &line).length("stroke-width", millimetres).empty());
        }
    }
}

/// How much light a face gets from above the viewer's left shoulder, 0 to 1; both sides alike.
fn light(corners: &[Vector]) -> f64 {
    let normal = normal(corners);
    let light = normal.dot(&Vector::new(-0.45, 0.55, 0.7)).abs() / normal.norm();
    if light.is_finite() { (light * LEVELS).round() / LEVELS } else { 0.0 }
}

/// Newell's normal, right for faces that are neither plane nor triangles; as long as twice the area.
fn normal(corners: &[Vector]) -> Vector {
    let from = |i: usize| corners[i % corners.len()] - corners[0];
    (0..corners.len()).fold(Vector::zeros(), |sum, i| sum + from(i).cross(&from(i + 1)))
}

/// The cells of a surface. Where a cell faces the viewer and its neighbour faces away, an outline runs.
fn of_surface(grid: &Samples, add: &mut impl FnMut(Vec<Vector>, Vec<(usize, usize)>)) {
    let (rows, columns) = (grid.rows.len() - 1, grid.columns.len() - 1);
    let corners = |row: usize, column: usize| {
        let at = row * (columns + 1) + column;
        [at, at + 1, at + columns + 2, at + columns + 1].map(|i| grid.points[i])
    };
    let facing: Vec<bool> =
        (0..rows * columns).map(|cell| normal(&corners(cell / columns, cell % columns)).z > 0.0).collect();
    // The neighbour in a direction that may be closed; none beyond a border.
    let step = |at: usize, count: usize, forward: bool, closed: bool| match (at, forward) {
        (0, false) => closed.then(|| count - 1),
        (_, false) => Some(at - 1),
        (_, true) if at + 1 == count => closed.then_some(0),
        (_, true) => Some(at + 1),
    };
    let (rows_closed, columns_closed) = (grid.rows[0] == Line::Inner, grid.columns[0] == Line::Inner);
    for row in 0..rows {
        for column in 0..columns {
            let beside = [
                step(row, rows, false, rows_closed).map(|r| (r, column)),
                step(column, columns, true, columns_closed).map(|c| (row, c)),
                step(row, rows, true, rows_closed).map(|r| (r, column)),
                step(column, columns, false, columns_closed).map(|c| (row, c)),
            ];
            let lines = [grid.rows[row], grid.columns[column + 1], grid.rows[row + 1], grid.columns[column]];
            let side = |i: usize| {
                let turns =
                    beside[i].is_some_and(|(r, c)| facing[r * columns + c] != facing[row * columns + column]);
                match lines[i] {
                    Line::Border => Some((i, 2)),
                    _ if turns => Some((i, 1)),
                    Line::Inner => Some((i, 0)),
                    Line::None => None,
                }
            };
            let sides = (0..4).filter_map(side).collect();
            add(corners(row, column).to_vec(), sides);
        }
    }
}

/// The most edges of a mesh that are drawn as outlines.
const EDGES: usize = 40_000;

/// The edges of a mesh that hides nothing, each once, as path data; `None` where there are too many to see.
pub(crate) fn outlines(
    sheet: &mut Sheet,
    points: &[Vector],
    corners: &[u32],
    starts: &[usize],
) -> Option<String> {
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
    if edges.len() > EDGES {
        return None;
    }
    let mut path = Path::default();
    for (a, b) in edges {
        let (from, to) = (sheet.spot(&points[a as usize]), sheet.spot(&points[b as usize]));
        sheet.ink.segment(from, to, 1);
        path.move_to(from);
        path.line_to(to);
    }
    Some(path.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_does_not_depend_on_the_side_or_the_size() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.3], [0.0, 1.0, 0.0]].map(Vector::from);
        let mut turned = corners;
        turned.reverse();
        assert_eq!(light(&corners), light(&turned));
        assert_eq!(light(&corners), light(&corners.map(|c| c * 1e-8)));
        assert_eq!(light(&[corners[0]; 3]), 0.0);
    }
}
