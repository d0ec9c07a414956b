//! Very many faces as a raster: a depth buffer of small squares, written as runs of one colour.

use std::collections::HashMap;

use loftsman_kernel::Vector;

use crate::labels::Ink;
use crate::layout::Rect;
use crate::svg::{Element, length};
use crate::theme::Color;

/// The side of a square, in millimetres: about a pixel of a screen.
const CELL: f64 = 0.25;

/// A depth buffer over an area of the page.
pub(crate) struct Raster {
    area: Rect,
    columns: usize,
    rows: usize,
    /// Depth (towards the viewer) and index of the colour of each square.
    cells: Vec<(f32, u32)>,
    colors: Vec<Color>,
    known: HashMap<[u8; 3], u32>,
}

impl Raster {
    /// An empty raster.
    pub(crate) fn new(area: Rect) -> Self {
        let [width, height] = area.size();
        let (columns, rows) = ((width / CELL).ceil() as usize + 1, (height / CELL).ceil() as usize + 1);
        let cells = vec![(f32::NEG_INFINITY, u32::MAX); columns * rows];
        Self { area, columns, rows, cells, colors: Vec::new(), known: HashMap::new() }
    }

    /// Adds a polygon (page x, page y, depth) as a fan of triangles, where it is nearer than what is there.
    pub(crate) fn add(&mut self, corners: &[Vector], color: Color) {
        let index = *self.known.entry(color.0).or_insert_with(|| {
            self.colors.push(color);
            self.colors.len() as u32 - 1
        });
        // In squares, so that square (i, j) has its middle at (i, j).
        let spot = |c: &Vector| {
            let [x, y] = [c.x - self.area.low[0], c.y - self.area.low[1]];
            Vector::new(x / CELL - 0.5, y / CELL - 0.5, c.z)
        };
        let corners: Vec<Vector> = corners.iter().map(spot).collect();
        for pair in corners.windows(2).skip(1) {
            self.triangle(&corners[0], &pair[0], &pair[1], index);
        }
    }

    fn triangle(&mut self, a: &Vector, b: &Vector, c: &Vector, color: u32) {
        let (low, high) = (a.inf(b).inf(c), a.sup(b).sup(c));
        // The casts saturate, and empty ranges end at once.
        let first = |low: f64| low.ceil().max(0.0) as usize;
        let last = |high: f64, count: usize| high.floor().min(count as f64 - 1.0);
        let (right, bottom) = (last(high.x, self.columns), last(high.y, self.rows));
        if right < 0.0 || bottom < 0.0 {
            return;
        }
        let (ab, ac) = (b - a, c - a);
        let area = ab.x * ac.y - ab.y * ac.x;
        for j in first(low.y)..=bottom as usize {
            for i in first(low.x)..=right as usize {
                let p = Vector::new(i as f64, j as f64, 0.0) - a;
                // Barycentric coordinates; an edge-on triangle has none (not finite) and shows nothing.
                let v = (p.x * ac.y - p.y * ac.x) / area;
                let w = (ab.x * p.y - ab.y * p.x) / area;
                if v >= -1e-9 && w >= -1e-9 && v + w <= 1.0 + 1e-9 {
                    let depth = (a.z + v * ab.z + w * ac.z) as f32;
                    let cell = &mut self.cells[j * self.columns + i];
                    if depth > cell.0 {
                        *cell = (depth, color);
                    }
                }
            }
        }
    }

    /// One path a colour: every run of squares a short thick line.
    pub(crate) fn finish(self, ink: &mut Ink) -> String {
        let mut data = vec![String::new(); self.colors.len()];
        for row in 0..self.rows {
            let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
            let y = self.area.low[1] + (row as f64 + 0.5) * CELL;
            let mut start = 0;
            while start < self.columns {
                let color = cells[start].1;
                let run = cells[start..].iter().take_while(|cell| cell.1 == color).count();
                if let Some(data) = data.get_mut(color as usize) {
                    let x = self.area.low[0] + start as f64 * CELL;
                    let wide = run as f64 * CELL;
                    data.push_str(&format!("M{} {}h{}", length(x), length(y), length(wide)));
                    ink.segment([x, y], [x + wide, y], 1);
                }
                start += run;
            }
        }
        self.colors
            .iter()
            .zip(data)
            .filter(|(_, data)| !data.is_empty())
            .map(|(color, data)| {
                Element::new("path")
                    .attribute("class", "raster")
                    .attribute("d", &data)
                    .attribute("fill", "none")
                    .attribute("stroke", &color.hex())
                    // A little more than a row, so that no seams show.
                    .length("stroke-width", CELL + 0.02)
                    .attribute("stroke-linecap", "butt")
                    .empty()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_faces_hide_far_ones_in_any_order() {
        let area = Rect { low: [10.0, 10.0], high: [20.0, 15.0] };
        let square = |z: f64, side: f64| {
            [[10.0, 10.0], [10.0 + side, 10.0], [10.0 + side, 15.0], [10.0, 15.0]]
                .map(|[x, y]| Vector::new(x, y, z))
        };
        let (red, blue) = (Color([255, 0, 0]), Color([0, 0, 255]));
        for order in [[0, 1], [1, 0]] {
            let mut raster = Raster::new(area);
            for i in order {
                let (corners, color) = [(square(0.0, 10.0), red), (square(1.0, 5.0), blue)][i];
                raster.add(&corners, color);
            }
            let count = |color: Color| {
                let index = raster.colors.iter().position(|c| *c == color).unwrap() as u32;
                raster.cells.iter().filter(|cell| cell.1 == index).count()
            };
            assert_eq!((count(red), count(blue)), (400, 400));
        }
    }

    #[test]
    fn faces_off_the_page_and_degenerate_ones_do_no_harm() {
        let mut raster = Raster::new(Rect { low: [0.0, 0.0], high: [10.0, 10.0] });
        let corner = |x: f64, y: f64| Vector::new(x, y, 0.0);
        for corners in [
            [corner(-1e300, 0.0), corner(1e300, 1.0), corner(0.0, 5.0)],
            [corner(-9.0, -9.0), corner(-5.0, -9.0), corner(-9.0, -5.0)],
            [corner(1.0, 1.0); 3],
            [corner(f64::NAN, 1.0), corner(2.0, 2.0), corner(3.0, 1.0)],
        ] {
            raster.add(&corners, Color([1, 2, 3]));
        }
        let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [10.0, 10.0] });
        assert!(raster.finish(&mut ink).len() < 100_000);
    }
}
