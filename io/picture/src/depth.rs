//! A depth buffer of the page: which face is nearest at each place, how it is lit, and which parts of lines it hides.
//!
//! Faces are sampled at the middles of small cells, so what is hidden is decided to within about a cell
//! ([`CELL`], a pixel at 250 dpi): a line that goes behind a face ends at most a cell and a half from where it should. Time and room
//! are linear in the faces, the lengths of lines and the area of the drawing, whatever hides what.

use loftsman_kernel::Vector;

use crate::error::PictureError;
use crate::layout::Rect;
use crate::path::Spot;
use crate::raster;
use crate::theme::Color;

/// The side of a cell, in millimetres.
pub(crate) const CELL: f64 = 0.1;

/// The most cells; on larger pages they are larger.
const MOST: f64 = 8e6;

/// The most cells that all faces together may cover, each counted for itself: about two seconds. Where they would cover more
/// the cells are larger, but not larger than [`LARGEST`], in millimetres.
const WORK: f64 = 4e8;
const LARGEST: f64 = 1.0;

/// A line in the surface of a face is in front of it, though both are rounded, in millimetres of depth.
pub(crate) const ON_FACE: f64 = 0.02;

/// An edge of a solid is in front of the faces that meet there: where these come towards the viewer on both sides, no cell's middle is as
/// far back as the edge between them. In millimetres of depth: a cell's side, on a slope.
pub(crate) const ON_EDGE: f64 = 0.15;

/// A curve that lies in a surface is in front of the facets that stand for it, in millimetres of depth.
pub(crate) const IN_SURFACE: f64 = 0.35;

/// Parts of lines shorter than this are not caption apart from what is around them, in millimetres.
const SHORT: f64 = 0.25;

/// What is nearest to the viewer in every cell.
#[derive(Debug)]
pub(crate) struct Depth {
    low: Spot,
    cell: f64,
    columns: usize,
    rows: usize,
    /// How near what is there is, in millimetres; minus infinity where nothing is.
    near: Vec<f32>,
    colors: Vec<Color>,
}

/// A part of a line that is seen, or hidden.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) seen: bool,
    pub(crate) spots: Vec<Spot>,
}

impl Depth {
    /// An empty buffer over an area of the page, for faces that cover so many square millimetres of it together.
    ///
    /// # Errors
    /// When that is more than can be drawn in reasonable time.
    pub(crate) fn new(area: &Rect, covered: f64) -> Result<Self, PictureError> {
        let [width, height] = area.size();
        let cell = CELL.max((width * height / MOST).sqrt()).max((covered / WORK).sqrt());
        if cell > LARGEST.max((width * height / MOST).sqrt()) {
            return Err(PictureError::Covered(covered / (width * height)));
        }
        let (columns, rows) = ((width / cell).ceil() as usize + 1, (height / cell).ceil() as usize + 1);
        let (near, colors) = (vec![f32::NEG_INFINITY; columns * rows], vec![Color([0; 3]); columns * rows]);
        Ok(Self { low: area.low, cell, columns, rows, near, colors })
    }

    /// The side of a cell, in millimetres, where it is larger than usual.
    pub(crate) fn coarse(&self) -> Option<f64> {
        (self.cell > 1.5 * CELL).then_some(self.cell)
    }

    /// How many square millimetres of an area of the page a face may cover: its own, or that of its box there.
    pub(crate) fn covers(area: &Rect, corners: &[Vector]) -> f64 {
        let [Some(first), Some(last)] = [corners.first(), corners.last()] else { return 0.0 };
        let (low, high) = corners.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
        let side = |i: usize| (high[i].min(area.high[i]) - low[i].max(area.low[i])).max(0.0);
        let legs = corners.windows(2).map(|p| p[0].x * p[1].y - p[0].y * p[1].x).sum::<f64>();
        let own = 0.5 * (legs + last.x * first.y - last.y * first.x).abs();
        // Each row costs something, too.
        let cells = own.min(side(0) * side(1)) + CELL * side(1);
        if cells.is_finite() { cells } else { 0.0 }
    }

    /// Adds a triangle (page across, page down, depth towards the viewer), where it is nearer than what is there and `paint`
    /// gives a colour: it gets the barycentric coordinates of the second and third corner.
    pub(crate) fn triangle(&mut self, corners: [&Vector; 3], paint: impl Fn(f64, f64) -> Option<Color>) {
        // In cells, so that cell (i, j) has its middle at (i, j).
        let [a, b, c] = corners.map(|p| {
            let [x, y] = [0, 1].map(|i| (p[i] - self.low[i]) / self.cell - 0.5);
            Vector::new(x, y, p.z)
        });
        let (ab, ac) = (b - a, c - a);
        let area = ab.x * ac.y - ab.y * ac.x;
        if !(area.is_finite() && area != 0.0) {
            return;
        }
        // The casts saturate, and empty ranges end at once.
        let first = |low: f64| low.ceil().max(0.0) as usize;
        let last = |high: f64, count: usize| high.floor().min(count as f64 - 1.0);
        let bottom = last(a.y.max(b.y).max(c.y), self.rows);
        if bottom < 0.0 {
            return;
        }
        for j in first(a.y.min(b.y).min(c.y))..=bottom as usize {
            let y = j as f64;
            // Where the row crosses the sides: so a long sliver costs its rows, not its box.
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (p, q) in [(&a, &b), (&b, &c), (&c, &a)] {
                if (p.y - y) * (q.y - y) <= 0.0 && p.y != q.y {
                    let x = p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y));
                    (left, right) = (left.min(x), right.max(x));
                } else if p.y == y && q.y == y {
                    (left, right) = (left.min(p.x).min(q.x), right.max(p.x).max(q.x));
                }
            }
            let end = last(right, self.columns);
            if end < 0.0 {
                continue;
            }
            for i in first(left)..=end as usize {
                let (x, y) = (i as f64 - a.x, y - a.y);
                let v = (x * ac.y - y * ac.x) / area;
                let w = (ab.x * y - ab.y * x) / area;
                let near = (a.z + v * ab.z + w * ac.z) as f32;
                let at = j * self.columns + i;
                if near > self.near[at]
                    && let Some(color) = paint(v, w)
                {
                    self.near[at] = near;
                    self.colors[at] = color;
                }
            }
        }
    }

    /// Adds a face. `paint` gets the numbers of three of its corners and the barycentric coordinates of the second and third.
    /// A face of more than four corners is taken as plane, may be concave, and has one colour, that of the middle of three corners.
    pub(crate) fn face(&mut self, corners: &[Vector], paint: impl Fn([usize; 3], f64, f64) -> Color) {
        match corners {
            [a, b, c] => self.triangle([a, b, c], |v, w| Some(paint([0, 1, 2], v, w))),
            [a, b, c, d] => {
                // Cut where both halves turn the same way, so that an arrowhead stays one.
                let turn = |a: &Vector, b: &Vector, c: &Vector| (b - a).xy().perp(&(c - a).xy());
                let halves = if turn(a, b, c) * turn(a, c, d) >= 0.0 {
                    [[0, 1, 2], [0, 2, 3]]
                } else {
                    [[1, 2, 3], [1, 3, 0]]
                };
                for half in halves {
                    self.triangle(half.map(|k| &corners[k]), |v, w| Some(paint(half, v, w)));
                }
            }
            [_, _, _, ..] => {
                let third = corners.len() / 3;
                self.polygon(corners, paint([0, third, 2 * third], 1.0 / 3.0, 1.0 / 3.0));
            }
            _ => {}
        }
    }

    /// A plane polygon, row by row between its sides: what is inside is decided by counting them (even or odd).
    fn polygon(&mut self, corners: &[Vector], color: Color) {
        let corners: Vec<Vector> = corners
            .iter()
            .map(|p| {
                let [x, y] = [0, 1].map(|i| (p[i] - self.low[i]) / self.cell - 0.5);
                Vector::new(x, y, p.z)
            })
            .collect();
        // The plane through the middle with Newell's normal; an edge-on polygon shows nothing.
        let from = |i: usize| corners[i % corners.len()] - corners[0];
        let normal = (0..corners.len()).fold(Vector::zeros(), |sum, i| sum + from(i).cross(&from(i + 1)));
        let middle = corners.iter().sum::<Vector>() / corners.len() as f64;
        let slope = [normal.x / normal.z, normal.y / normal.z];
        if !slope.iter().all(|s| s.is_finite()) {
            return;
        }
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); self.rows];
        for (i, p) in corners.iter().enumerate() {
            let q = &corners[(i + 1) % corners.len()];
            // From the lower end, included, to the upper, not included: a corner counts once.
            let (low, high) = (p.y.min(q.y), p.y.max(q.y));
            let (first, end) = (low.ceil().max(0.0) as usize, high.ceil().max(0.0).min(self.rows as f64));
            for (j, row) in crossings.iter_mut().enumerate().take(end as usize).skip(first) {
                row.push(p.x + (q.x - p.x) * ((j as f64 - p.y) / (q.y - p.y)));
            }
        }
        for (j, row) in crossings.iter_mut().enumerate() {
            row.sort_by(f64::total_cmp);
            for pair in row.chunks_exact(2) {
                let (first, end) = (pair[0].ceil().max(0.0), pair[1].ceil().min(self.columns as f64));
                for i in first as usize..end.max(0.0) as usize {
                    let (x, y) = (i as f64 - middle.x, j as f64 - middle.y);
                    let near = (middle.z - slope[0] * x - slope[1] * y) as f32;
                    let at = j * self.columns + i;
                    if near > self.near[at] {
                        self.near[at] = near;
                        self.colors[at] = color;
                    }
                }
            }
        }
    }

    /// Whether faces hide a place: everywhere around it something is nearer by more than `slack` millimetres.
    pub(crate) fn hides(&self, p: &Vector, slack: f64) -> bool {
        let [x, y] = [0, 1].map(|i| (p[i] - self.low[i]) / self.cell);
        if !(x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64) {
            return false;
        }
        let (column, row) = (x as usize, y as usize);
        let around = |at: usize, count: usize| at.saturating_sub(1)..=(at + 1).min(count - 1);
        let limit = (p.z + slack) as f32;
        around(row, self.rows)
            .all(|j| around(column, self.columns).all(|i| self.near[j * self.columns + i] > limit))
    }

    /// The parts of a chain (page across, page down, depth) that are seen and that are hidden, in order.
    pub(crate) fn runs(&self, chain: impl IntoIterator<Item = Vector>, slack: f64) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        let mut last: Option<(Vector, bool)> = None;
        for to in chain {
            let Some((from, mut seen)) = last else {
                let seen = !self.hides(&to, slack);
                runs.push(Run { seen, spots: vec![[to.x, to.y]] });
                last = Some((to, seen));
                continue;
            };
            let steps = ((to - from).xy().norm() / self.cell).ceil().clamp(1.0, 16_384.0) as usize;
            let at = |i: f64| from + (to - from) * (i / steps as f64);
            for i in 1..=steps {
                let now = !self.hides(&at(i as f64), slack);
                if now != seen {
                    let between = at(i as f64 - 0.5);
                    let spot = [between.x, between.y];
                    if let Some(run) = runs.last_mut() {
                        run.spots.push(spot);
                    }
                    runs.push(Run { seen: now, spots: vec![spot] });
                    seen = now;
                }
            }
            if let Some(run) = runs.last_mut() {
                run.spots.push([to.x, to.y]);
            }
            last = Some((to, seen));
        }
        // First gaps too short to be there are closed, then parts too short to be seen go.
        for seen in [true, false] {
            runs = joined(runs, seen);
        }
        runs
    }

    /// The faces as a PNG image, and where on the page it goes; `None` where there are none. A pixel is two cells wide and
    /// high, so that edges are smooth.
    ///
    /// # Errors
    /// When it cannot be encoded.
    pub(crate) fn image(&self) -> Result<Option<(Vec<u8>, Rect)>, PictureError> {
        let filled = |at: usize| self.near[at] > f32::NEG_INFINITY;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for at in (0..self.near.len()).filter(|&at| filled(at)) {
            for (i, c) in [at % self.columns / 2, at / self.columns / 2].into_iter().enumerate() {
                (low[i], high[i]) = (low[i].min(c), high[i].max(c + 1));
            }
        }
        if low[0] == usize::MAX {
            return Ok(None);
        }
        let [width, height] = [0, 1].map(|i| high[i] - low[i]);
        let mut pixels = Vec::with_capacity(4 * width * height);
        for (row, column) in (low[1]..high[1]).flat_map(|r| (low[0]..high[0]).map(move |c| (r, c))) {
            let (mut sum, mut count) = ([0_u32; 3], 0_u32);
            for (j, i) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let (j, i) = (2 * row + j, 2 * column + i);
                if j < self.rows && i < self.columns && filled(j * self.columns + i) {
                    let Color(rgb) = self.colors[j * self.columns + i];
                    (0..3).for_each(|k| sum[k] += u32::from(rgb[k]));
                    count += 1;
                }
            }
            // Colours are premultiplied: cells without a face count as black and clear.
            let [r, g, b] = sum.map(|c| (c / 4) as u8);
            let alpha = (count * 255 / 4) as u8;
            // Rounding must not make them brighter than they are opaque.
            pixels.extend([r.min(alpha), g.min(alpha), b.min(alpha), alpha]);
        }
        let png = raster::encode(pixels, [width, height])?;
        let page = |at: [usize; 2]| [0, 1].map(|i| self.low[i] + 2.0 * self.cell * at[i] as f64);
        Ok(Some((png, Rect { low: page(low), high: page(high) })))
    }
}

/// Runs without those that are `short` and of the kind `seen`: these become part of the others. The first and last keep
/// their kind only if they are not short or the only ones.
fn joined(runs: Vec<Run>, seen: bool) -> Vec<Run> {
    let count = runs.len();
    let mut out: Vec<Run> = Vec::with_capacity(count);
    for run in runs {
        let length: f64 = run.spots.windows(2).map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1])).sum();
        let kind = if count > 1 && run.seen != seen && length < SHORT { seen } else { run.seen };
        match out.last_mut() {
            Some(last) if last.seen == kind => last.spots.extend(run.spots.into_iter().skip(1)),
            _ => out.push(Run { seen: kind, spots: run.spots }),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn buffer() -> Depth {
        Depth::new(&Rect { low: [10.0, 10.0], high: [20.0, 15.0] }, 0.0).unwrap()
    }

    fn square(low: f64, high: f64, z: f64) -> [Vector; 4] {
        [[low, 10.0], [high, 10.0], [high, 15.0], [low, 15.0]].map(|[x, y]| Vector::new(x, y, z))
    }

    const RED: Color = Color([255, 0, 0]);
    const BLUE: Color = Color([0, 0, 255]);

    #[test]
    fn near_faces_hide_far_ones_in_any_order() {
        for order in [[0, 1], [1, 0]] {
            let mut depth = buffer();
            for i in order {
                let (corners, color) = [(square(10.0, 20.0, 0.0), RED), (square(10.0, 15.0, 1.0), BLUE)][i];
                depth.face(&corners, |_, _, _| color);
            }
            let count = |color: Color| {
                (0..depth.near.len())
                    .filter(|&i| depth.near[i].is_finite() && depth.colors[i] == color)
                    .count()
            };
            assert_eq!((count(RED), count(BLUE)), (50 * 50, 50 * 50));
        }
    }

    #[test]
    fn a_line_through_a_face_is_cut_where_it_goes_in() {
        let mut depth = buffer();
        depth.face(&square(12.0, 18.0, 0.0), |_, _, _| RED);
        // From the front on the left through the face at 15 to behind it, and out on the right at 18.
        let line = [Vector::new(10.0, 12.0, 5.0), Vector::new(20.0, 12.0, -5.0)];
        let runs = depth.runs(line, ON_FACE);
        assert_eq!(runs.iter().map(|r| r.seen).collect::<Vec<_>>(), [true, false, true]);
        assert!((runs[1].spots[0][0] - 15.0).abs() < 1.5 * CELL, "{runs:?}");
        assert!((runs[2].spots[0][0] - 18.0).abs() < 1.5 * CELL, "{runs:?}");
        // In the face, and before it.
        for z in [0.0, 3.0] {
            let runs = depth.runs([Vector::new(10.0, 12.0, z), Vector::new(20.0, 12.0, z)], ON_FACE);
            assert_eq!((runs.len(), runs[0].seen), (1, true));
        }
    }

    #[test]
    fn lines_in_a_steep_face_are_seen() {
        let mut depth = buffer();
        let up = |x: f64, y: f64| Vector::new(x, y, (x - 15.0) * 40.0);
        let corners = [up(14.0, 10.0), up(16.0, 10.0), up(16.0, 15.0), up(14.0, 15.0)];
        depth.face(&corners, |_, _, _| RED);
        for [a, b] in [[[14.0, 10.5], [16.0, 14.0]], [[14.7, 10.2], [14.7, 14.8]]] {
            let runs = depth.runs([up(a[0], a[1]), up(b[0], b[1])], ON_FACE);
            assert!(runs.len() == 1 && runs[0].seen, "{runs:?}");
        }
    }

    #[test]
    fn concave_faces_cover_what_they_are() {
        let at = |x: f64, y: f64| Vector::new(x, y, x + y);
        let arrowhead = [at(10.0, 10.0), at(20.0, 12.5), at(10.0, 15.0), at(14.0, 12.5)];
        let star: Vec<Vector> = (0..10)
            .map(|i| (f64::from(i) * std::f64::consts::TAU / 10.0, if i % 2 == 0 { 2.4 } else { 1.0 }))
            .map(|(a, r)| at(15.0 + r * a.sin(), 12.5 + r * a.cos()))
            .collect();
        for corners in [&arrowhead[..], &star] {
            let mut depth = buffer();
            depth.face(corners, |_, _, _| RED);
            let covered = depth.near.iter().filter(|z| z.is_finite()).count() as f64 * CELL * CELL;
            let area = (0..corners.len())
                .map(|i| (corners[i], corners[(i + 1) % corners.len()]))
                .map(|(p, q)| (p.x * q.y - p.y * q.x) / 2.0)
                .sum::<f64>()
                .abs();
            assert!((covered - area).abs() < 0.03 * area, "{covered} {area}");
            // The depth is the plane's.
            let middle = at(15.0, 12.5);
            assert!(depth.hides(&(middle - Vector::z()), 0.5) && !depth.hides(&middle, 0.2));
        }
    }

    #[test]
    fn faces_off_the_page_and_degenerate_ones_do_no_harm() {
        let mut depth = buffer();
        let corner = |x: f64, y: f64| Vector::new(x, y, 0.0);
        for corners in [
            [corner(-1e300, 0.0), corner(1e300, 1.0), corner(0.0, 5.0)],
            [corner(-9.0, -9.0), corner(-5.0, -9.0), corner(-9.0, -5.0)],
            [corner(1.0, 1.0); 3],
            [corner(f64::NAN, 1.0), corner(2.0, 2.0), corner(3.0, 1.0)],
        ] {
            depth.face(&corners, |_, _, _| RED);
            depth.face(&[corners[0], corners[1], corners[2], corners[0], corners[1]], |_, _, _| RED);
        }
        assert!(depth.image().is_ok());
        assert!(!depth.hides(&corner(f64::NAN, 0.0), 0.0));
        assert!(depth.runs([corner(-1e300, 0.0), corner(1e300, 0.0)], 0.0).len() < 9);
    }

    #[test]
    fn the_image_has_smooth_edges() {
        let mut depth = buffer();
        assert!(depth.image().unwrap().is_none());
        depth.face(
            &square(12.05, 14.05, 0.0).map(|p| p.component_mul(&Vector::new(1.0, 1.0, 1.0))),
            |_, _, _| BLUE,
        );
        let (png, place) = depth.image().unwrap().unwrap();
        let image = tiny_skia::Pixmap::decode_png(&png).unwrap();
        assert!((place.low[0] - 12.0).abs() < 0.2 && place.high[0] >= 14.0);
        let alphas: Vec<u8> = image.pixels().iter().map(|p| p.alpha()).collect();
        assert!(alphas.contains(&255));
        assert_eq!(image.width(), ((place.high[0] - place.low[0]) / (2.0 * CELL)).round() as u32);
    }
}
