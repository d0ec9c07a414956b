//! Faces of surfaces and meshes, shaded, and their lines as far as no face hides them.

use std::collections::HashSet;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use loftsman_kernel::Vector;

use crate::chain::linked;
use crate::depth::{Depth, ON_EDGE, ON_FACE, Run};
use crate::draw::color;
use crate::draw::light::{light, tone, tones};
use crate::draw::paint::{Brush, Painting};
use crate::draw::silhouette::weighed;
use crate::draw::solid;
use crate::draw::surface::{Line, Samples, kept, loop_of, parts};
use crate::draw::turns::Turns;
use crate::error::PictureError;
use crate::layout::Rect;
use crate::path::{Path, Spot};
use crate::sheet::{Layer, Sheet, Stroke};
use crate::stage::Stage;
use crate::stage::body::Form;
use crate::stage::trim::Mask;
use crate::svg::Element;
use crate::theme::Color;
use crate::view::Lens;

/// Edges of meshes that are neither borders nor outlines nor creases are drawn where they are this long on average, in millimetres: on
/// finer meshes they would be a smear.
pub(super) const LONG: f64 = 1.6;

/// How heavy a line on a face is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Weight {
    /// Isoparametric lines, edges between faces.
    Inner,
    /// Edges where a mesh bends sharply.
    Crease,
    /// Where a shape turns away from the viewer.
    Outline,
    /// Where a shape ends.
    Border,
}

impl Weight {
    const ALL: [Self; 4] = [Self::Inner, Self::Crease, Self::Outline, Self::Border];

    /// In millimetres.
    fn width(self) -> f64 {
        match self {
            Self::Inner => 0.12,
            Self::Crease => 0.18,
            Self::Outline => 0.25,
            Self::Border => 0.35,
        }
    }
}

/// The lines of an object: chains of places on the page with their depth.
pub(super) struct Lines {
    color: Color,
    /// Whether they are those of a solid: nearer to its faces, and drawn once.
    solid: bool,
    pub(super) chains: Vec<(Weight, Vec<Vector>)>,
}

/// Draws the faces of all surfaces and meshes together, and leaves the sheet their depth: what is drawn later is hidden by
/// them too.
///
/// # Errors
/// When the image of the faces cannot be made.
pub(crate) fn draw(sheet: &mut Sheet, stage: &Stage<'_>, painting: &Painting) -> Result<(), PictureError> {
    let solid = |form: &Form| matches!(form, Form::Surface { .. } | Form::Mesh { .. } | Form::Solid(_));
    if !stage.new.iter().any(|body| solid(&body.form)) {
        return Ok(());
    }
    let lens = stage.projection.lens();
    let area = sheet.layout.area.grown(0.5);
    let grid = |index: usize| painting.body(index).and_then(|painted| painted.grid.as_ref());
    let grids = (0..stage.new.len()).filter_map(grid);
    let covered: f64 = grids.map(|grid| of_grid(grid, sheet, &area)).sum();
    let mut copies = Copies::default();
    let mut of_faces = faces(stage, sheet, &area, &mut copies);
    if covered + of_faces > OFTEN * area.size()[0] * area.size()[1] {
        // Instances at one place are one as far as can be seen.
        copies.count = true;
        of_faces = faces(stage, sheet, &area, &mut copies);
        copies.seen.clear();
    }
    let mut depth = Depth::new(&area, covered + of_faces)?;
    if let Some(cell) = depth.coarse() {
        let cell = crate::text::number(cell);
        sheet
            .caption
            .note(format!("faces cover one another so often that they are drawn in cells of {cell} mm"));
    }
    let mut all = Vec::new();
    for (index, body) in stage.new.iter().enumerate() {
        let base = color(sheet, body, false);
        let tones = tones(sheet.theme, base);
        let paint = (tones.as_slice(), painting.brush(index, sheet.theme));
        let mut lines =
            Lines { color: base.mixed(sheet.theme.ink(), 0.25), solid: false, chains: Vec::new() };
        match &body.form {
            Form::Surface { surface, trim, .. } => {
                let Some(grid) = grid(index) else { continue };
                let mask = trim.as_ref().map(|trim| Mask::new(trim, surface));
                of_surface(grid, mask.as_ref(), sheet, lens, &mut depth, paint, &mut lines);
                for points in trim.iter().flat_map(|trim| &trim.loops) {
                    let edge = loop_of(surface, points).iter().map(|p| sheet.layout.place(p)).collect();
                    lines.chains.push((Weight::Border, edge));
                }
            }
            Form::Mesh { points, corners, starts, normals, colors, .. } => {
                let mesh = (points.as_slice(), corners.as_slice(), starts.as_slice());
                of_mesh(mesh, (normals, colors), sheet, lens, (&mut depth, &mut copies), paint, &mut lines);
            }
            Form::Solid(shell) => {
                lines.solid = true;
                if shell.laid.is_none() {
                    lines.color = base.mixed(sheet.theme.ink(), SOLID);
                }
                let painted = painting.body(index).and_then(|painted| painted.shell.as_ref());
                let shell = painted.unwrap_or(shell);
                solid::draw(shell, paint, (sheet, lens), (&mut depth, &mut copies), &mut lines);
            }
            _ => continue,
        }
        all.push(lines);
    }
    if let Some((png, place)) = depth.image()? {
        let [width, height] = place.size();
        let image = Element::new("image")
            .attribute("class", "shading")
            .length("x", place.low[0])
            .length("y", place.low[1])
            .length("width", width)
            .length("height", height)
            .attribute("preserveAspectRatio", "none")
            .attribute("href", &format!("data:image/png;base64,{}", STANDARD.encode(png)));
        sheet.put(Layer::Faces, &image.empty());
    }
    for weight in Weight::ALL {
        for lines in &all {
            let mut path = Path::default();
            for (_, chain) in lines.chains.iter().filter(|(w, _)| *w == weight) {
                let slack = if lines.solid { ON_EDGE } else { ON_FACE };
                for run in depth.runs(chain.iter().copied(), slack) {
                    trace(sheet, &run, &mut path);
                    if lines.solid && run.seen {
                        sheet.traces.add(&run.spots);
                    }
                }
            }
            let data = path.finish();
            if !data.is_empty() {
                let class = format!("{weight:?}").to_lowercase();
                let stroke = Stroke::plain(lines.color, weight.width());
                sheet.put(Layer::Faces, &stroke.path(&class, data).empty());
            }
        }
    }
    sheet.depth = Some(depth);
    Ok(())
}

/// How dark the lines of solids are: the share of ink in them, so that they are read on faces of any colour.
const SOLID: f64 = 0.7;

/// Where the faces cover the page more often than this, those at one place are counted and drawn once.
const OFTEN: f64 = 50.0;

/// Which faces there were already at the same place: a long hash of their corners stands for each.
#[derive(Default)]
pub(super) struct Copies {
    /// Whether they are counted at all.
    count: bool,
    seen: HashSet<u128>,
}

impl Copies {
    /// Whether a face is the first with these corners: a later one is not nearer, so that nothing is seen of it.
    pub(super) fn is_new(&mut self, corners: &[Vector]) -> bool {
        if !self.count {
            return true;
        }
        // FNV-1a of 128 bits, by Fowler, Noll and Vo.
        let numbers = corners.iter().flat_map(|p| [p.x, p.y, p.z]).map(|x| (x + 0.0).to_bits());
        let hash = numbers
            .flat_map(u64::to_le_bytes)
            .fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128, |hash, byte| {
                (hash ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b)
            });
        self.seen.insert(hash)
    }
}

/// How many square millimetres of the page the faces of all meshes cover.
fn faces(stage: &Stage<'_>, sheet: &Sheet, area: &Rect, copies: &mut Copies) -> f64 {
    let mut covered = 0.0;
    let mut flat = Vec::new();
    for body in &stage.new {
        if let Form::Solid(shell) = &body.form {
            for triangle in &shell.skin.triangles {
                let flat = triangle.map(|i| sheet.layout.place(&shell.points[i as usize]));
                if copies.is_new(&flat) {
                    covered += Depth::covers(area, &flat);
                }
            }
        }
        let Form::Mesh { points, corners, starts, .. } = &body.form else { continue };
        for range in starts.windows(2) {
            flat.clear();
            flat.extend(corners[range[0]..range[1]].iter().map(|&i| sheet.layout.place(&points[i as usize])));
            if copies.is_new(&flat) {
                covered += Depth::covers(area, &flat);
            }
        }
    }
    covered
}

/// The same of the cells of a surface.
fn of_grid(grid: &Samples, sheet: &Sheet, area: &Rect) -> f64 {
    let columns = grid.columns.len();
    let places: Vec<Vector> = grid.points.iter().map(|p| sheet.layout.place(p)).collect();
    let mut covered = 0.0;
    for at in 0..places.len() - columns {
        if at % columns + 1 < columns {
            covered += Depth::covers(area, &[places[at], places[at + 1], places[at + columns]]);
            covered += Depth::covers(area, &[places[at + 1], places[at + columns + 1], places[at + columns]]);
        }
    }
    covered
}

/// Adds a run that is seen to a path.
pub(super) fn trace(sheet: &mut Sheet, run: &Run, path: &mut Path) {
    if !run.seen {
        return;
    }
    let mut last: Option<Spot> = None;
    for &spot in &run.spots {
        match last {
            None if path.pen() == Some(spot) => {}
            None => path.move_to(spot),
            Some(from) => {
                sheet.ink.segment(from, spot, 1);
                path.line_to(spot);
            }
        }
        last = Some(spot);
    }
}

/// The colour between those of three corners.
fn between([a, b, c]: [Color; 3], v: f64, w: f64) -> Color {
    let mix = |k: usize| {
        let [a, b, c] = [a, b, c].map(|color| f64::from(color.0[k]));
        (a + (b - a) * v + (c - a) * w).round().clamp(0.0, 255.0) as u8
    };
    Color([mix(0), mix(1), mix(2)])
}

/// A surface, or what a mask leaves of it: cells as pairs of triangles with normals at their corners, isoparametric lines, borders and
/// outlines.
#[allow(clippy::too_many_arguments, reason = "three to read from, three to write to, and the mask")]
fn of_surface(
    grid: &Samples,
    mask: Option<&Mask>,
    sheet: &Sheet,
    lens: Lens,
    depth: &mut Depth,
    (tones, brush): (&[Color], Option<Brush<'_>>),
    lines: &mut Lines,
) {
    let (rows, columns) = (grid.rows.len(), grid.columns.len());
    let places: Vec<Vector> = grid.points.iter().map(|p| sheet.layout.place(p)).collect();
    let normals = normals(grid);
    let facing: Vec<f64> = grid.points.iter().zip(&normals).map(|(p, n)| n.dot(&lens.toward(p))).collect();
    let parameters = |at: usize| [grid.u[at / columns], grid.v[at % columns]];
    let has = |at: [f64; 2]| mask.is_none_or(|mask| mask.has(at));
    let mut turns = Turns::default();
    for row in (0..rows - 1).filter(|&row| Samples::joined(&grid.rows, row)) {
        for column in (0..columns - 1).filter(|&column| Samples::joined(&grid.columns, column)) {
            let at = row * columns + column;
            let [a, b, c, d] = [at, at + 1, at + columns + 1, at + columns];
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                let [p, q, r] = [normals[a], normals[b], normals[c]];
                let corners = [a, b, c].map(parameters);
                let between = |v: f64, w: f64| {
                    let [p, q, r] = corners;
                    [0, 1].map(|i| p[i] + (q[i] - p[i]) * v + (r[i] - p[i]) * w)
                };
                let points = [a, b, c].map(|i| grid.points[i]);
                depth.triangle([&places[a], &places[b], &places[c]], |v, w| {
                    let mix = |[p, q, r]: [Vector; 3]| p + (q - p) * v + (r - p) * w;
                    has(between(v, w)).then(|| {
                        let normal = mix([p, q, r]);
                        match &brush {
                            None => tone(tones, &normal),
                            Some(brush) => {
                                let at = (lens, &mix(points));
                                brush.color([a, b, c], [v, w], &normal, at, light(&normal))
                            }
                        }
                    })
                });
                if has(between(1.0 / 3.0, 1.0 / 3.0)) {
                    turns.triangle([a, b, c], &facing, &places);
                }
            }
        }
    }
    let weight = |line: Line| match line {
        Line::None => None,
        // Loops are the borders of what is left.
        Line::Border | Line::Tear if mask.is_some() => Some(Weight::Inner),
        Line::Border | Line::Tear => Some(Weight::Border),
        Line::Inner => Some(Weight::Inner),
    };
    let mut add = |line: Line, at: &mut dyn Iterator<Item = usize>| {
        let Some(weight) = weight(line) else { return };
        let ends: Vec<([f64; 2], Vector)> = at.map(|i| (parameters(i), places[i])).collect();
        let chains = if mask.is_some() {
            kept(&ends, &has)
        } else {
            vec![ends.into_iter().map(|(_, place)| place).collect()]
        };
        lines.chains.extend(chains.into_iter().map(|chain| (weight, chain)));
    };
    for row in 0..rows {
        for part in parts(&grid.columns) {
            add(grid.rows[row], &mut part.map(|column| row * columns + column));
        }
    }
    for column in 0..columns {
        for part in parts(&grid.rows) {
            add(grid.columns[column], &mut part.map(|row| row * columns + column));
        }
    }
    lines.chains.extend(turns.chains().into_iter().map(|chain| (Weight::Outline, chain)));
}

/// Unit normals at the points of a grid, from differences of their neighbours; across a seam where the grid closes. At a pole,
/// where these vanish, the normal of the next row or column; zero where there is none.
fn normals(grid: &Samples) -> Vec<Vector> {
    let (rows, columns) = (grid.rows.len(), grid.columns.len());
    let closed = [grid.rows[0] == Line::Inner, grid.columns[0] == Line::Inner];
    // The points before and after, beyond the seam those that are one further; none beyond a tear.
    let beside = |at: usize, lines: &[Line], closed: bool| {
        let count = lines.len();
        let before = if at > 0 {
            if Samples::joined(lines, at - 1) { at - 1 } else { at }
        } else if closed {
            count - 2
        } else {
            0
        };
        let after = if at + 1 < count {
            if Samples::joined(lines, at) { at + 1 } else { at }
        } else if closed {
            1
        } else {
            at
        };
        (before, after)
    };
    let point = |row: usize, column: usize| grid.points[row * columns + column];
    let at = |row: usize, column: usize| {
        let (up, down) = beside(row, &grid.rows, closed[0]);
        let (left, right) = beside(column, &grid.columns, closed[1]);
        let along = point(down, column) - point(up, column);
        let across = point(row, right) - point(row, left);
        across.cross(&along).try_normalize(1e-200)
    };
    let inward = |at: usize, lines: &[Line]| {
        if at == 0 || !Samples::joined(lines, at - 1) {
            at + 1
        } else if at + 1 == lines.len() || !Samples::joined(lines, at) {
            at - 1
        } else {
            at
        }
    };
    (0..rows * columns)
        .map(|i| {
            let (row, column) = (i / columns, i % columns);
            at(row, column)
                .or_else(|| at(inward(row, &grid.rows), column))
                .or_else(|| at(row, inward(column, &grid.columns)))
                .unwrap_or_else(Vector::zeros)
        })
        .collect()
}

/// A mesh: faces that are smooth where their corners have normals, else flat; borders, outlines and creases, and all other edges where they are not too many to see.
#[allow(
    clippy::too_many_arguments,
    reason = "the mesh and its layers, three to read from, three to write to"
)]
fn of_mesh(
    (points, corners, starts): (&[Vector], &[u32], &[usize]),
    (by_corner, colors): (&[Vector], &[Color]),
    sheet: &Sheet,
    lens: Lens,
    (depth, copies): (&mut Depth, &mut Copies),
    (tones, brush): (&[Color], Option<Brush<'_>>),
    lines: &mut Lines,
) {
    let places: Vec<Vector> = points.iter().map(|p| sheet.layout.place(p)).collect();
    let mut any = false;
    for range in starts.windows(2) {
        let face_corners = &corners[range[0]..range[1]];
        let outline: Vec<Vector> = face_corners.iter().map(|&i| points[i as usize]).collect();
        let normal = newell(&outline);
        let flat: Vec<Vector> = face_corners.iter().map(|&i| places[i as usize]).collect();
        let given =
            by_corner.get(range[0]..range[1]).filter(|given| given.iter().all(|n| *n != Vector::zeros()));
        let is_new = copies.is_new(&flat);
        any |= is_new;
        let colors = colors.get(range[0]..range[1]);
        let there = |[a, b, c]: [usize; 3], v: f64, w: f64| match given {
            Some(n) => n[a] + (n[b] - n[a]) * v + (n[c] - n[a]) * w,
            None => normal,
        };
        match (colors, given) {
            _ if !is_new => {}
            _ if let Some(brush) = &brush => depth.face(&flat, |at, v, w| {
                let corners = at.map(|k| face_corners[k] as usize);
                let [p, q, r] = corners.map(|i| points[i]);
                let (point, normal) = (p + (q - p) * v + (r - p) * w, there(at, v, w));
                brush.color(corners, [v, w], &normal, (lens, &point), light(&normal))
            }),
            (Some(colors), _) => depth.face(&flat, |at, v, w| {
                sheet.theme.painted(between(at.map(|k| colors[k]), v, w), light(&there(at, v, w)))
            }),
            (None, Some(_)) => depth.face(&flat, |at, v, w| tone(tones, &there(at, v, w))),
            (None, None) => {
                let tone = tone(tones, &normal);
                depth.face(&flat, |_, _, _| tone);
            }
        }
    }
    if !any {
        // All of it is where something else is already, lines included.
        return;
    }
    let by_weight = weighed((points, corners, starts), lens);
    let inner = &by_weight[Weight::Inner as usize];
    let length: f64 = inner.iter().map(|(a, b)| (places[*a] - places[*b]).xy().norm()).sum();
    let too_many = length < LONG * inner.len() as f64;
    for weight in Weight::ALL.into_iter().skip(usize::from(too_many)) {
        let chains = linked(&by_weight[weight as usize]);
        let chains = chains.into_iter().map(|chain| chain.into_iter().map(|i| places[i]).collect());
        lines.chains.extend(chains.map(|chain: Vec<Vector>| (weight, chain)));
    }
}

/// Newell's normal, right for faces that are neither plane nor triangles; as long as twice the area.
pub(super) fn newell(corners: &[Vector]) -> Vector {
    let from = |i: usize| corners[i % corners.len()] - corners[0];
    (0..corners.len()).fold(Vector::zeros(), |sum, i| sum + from(i).cross(&from(i + 1)))
}

/// The most edges of a mesh that are drawn as outlines.
const EDGES: usize = 40_000;

/// The edges and loose lines of a mesh that hides nothing, each once and as far as no face hides them, as path data; `None` where there are
/// too many to see.
pub(crate) fn outlines(
    sheet: &mut Sheet,
    points: &[Vector],
    corners: &[u32],
    starts: &[usize],
    lines: &[(usize, usize)],
) -> Option<String> {
    let mut edges: Vec<(usize, usize)> = Vec::with_capacity(corners.len() + lines.len());
    edges.extend(lines);
    for range in starts.windows(2) {
        let face = &corners[range[0]..range[1]];
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            edges.push((a.min(b) as usize, a.max(b) as usize));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    if edges.len() > EDGES {
        return None;
    }
    let mut path = Path::default();
    for chain in linked(&edges) {
        for run in sheet.runs(chain.iter().map(|&i| &points[i]), ON_FACE) {
            trace(sheet, &run, &mut path);
        }
    }
    Some(path.finish())
}
