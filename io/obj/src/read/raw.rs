//! The numbered lists of a file: vertices, texture coordinates, normals, parameter vertices.

use loftsman_kernel::mesh::color::from_srgb;
use loftsman_kernel::{Point, Vector};

use super::part::{Counts, Parsed, Slots};
use crate::text::tokens;

/// What has become of an entry of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Use {
    Nothing,
    Kept,
}

/// The lists, as the file has them.
#[derive(Debug, Default)]
pub(crate) struct Raw {
    pub(crate) points: Vec<Point>,
    pub(crate) uvs: Vec<[f64; 2]>,
    pub(crate) normals: Vec<Vector>,
    pub(crate) parameters: Vec<[f64; 3]>,
    /// One a point; shorter while the last ones are 1.
    weights: Vec<f64>,
    /// Linear colours, one a point, NaN where it has none; shorter while the last ones have none.
    colors: Vec<[f64; 4]>,
    /// Colours in comments, for the points before them; how many points there were.
    block: Vec<[f64; 4]>,
    block_at: usize,
}

const NO_COLOR: [f64; 4] = [f64::NAN; 4];

impl Raw {
    /// Room for all of a file.
    pub(crate) fn new(counts: Counts) -> Self {
        Self {
            points: vec![Point::origin(); counts.points],
            uvs: vec![[0.0; 2]; counts.uvs],
            normals: vec![Vector::zeros(); counts.normals],
            parameters: vec![[0.0; 3]; counts.parameters],
            ..Self::default()
        }
    }

    /// The slots of consecutive parts, the first of which starts behind `before`.
    pub(crate) fn slots<'s>(&'s mut self, before: Counts, counts: &[Counts]) -> Vec<Slots<'s>> {
        let mut points = &mut self.points[before.points..];
        let mut uvs = &mut self.uvs[before.uvs..];
        let mut normals = &mut self.normals[before.normals..];
        let mut parameters = &mut self.parameters[before.parameters..];
        let mut out = Vec::with_capacity(counts.len());
        for count in counts {
            let (a, b, c, d);
            (a, points) = points.split_at_mut(count.points);
            (b, uvs) = uvs.split_at_mut(count.uvs);
            (c, normals) = normals.split_at_mut(count.normals);
            (d, parameters) = parameters.split_at_mut(count.parameters);
            out.push(Slots { points: a, uvs: b, normals: c, parameters: d });
        }
        out
    }

    /// Takes the weights and colours of a part whose first vertex is `first`.
    pub(crate) fn take(&mut self, first: usize, parsed: &mut Parsed<'_>) {
        if !parsed.weights.is_empty() {
            self.weights.resize(first, 1.0);
            self.weights.append(&mut parsed.weights);
        }
        if !parsed.colors.is_empty() {
            self.colors.resize(first, NO_COLOR);
            self.colors.append(&mut parsed.colors);
        }
    }

    /// The weight of a vertex.
    pub(crate) fn weight(&self, vertex: u32) -> f64 {
        self.weights.get(vertex as usize).copied().unwrap_or(1.0)
    }

    /// The vertices that have a weight other than 1.
    pub(crate) fn weighted(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.weights).filter(|(_, w)| **w != 1.0).map(|(v, _)| v)
    }

    /// The colour of a vertex, where it has one.
    pub(crate) fn color(&self, vertex: u32) -> Option<[f64; 4]> {
        self.colors.get(vertex as usize).copied().filter(|c| !c[0].is_nan())
    }

    /// Whether any vertex has a colour.
    pub(crate) fn colored(&self) -> bool {
        !self.colors.is_empty()
    }

    /// `#MRGB`: eight hexadecimal digits a vertex, mask, red, green and blue, for as many vertices before `count` as
    /// there are colours until vertices follow again.
    pub(crate) fn mrgb(&mut self, text: &[u8], count: usize) -> Result<(), String> {
        let mut wrong = None;
        if count != self.block_at {
            wrong = self.finish_block().err();
            self.block_at = count;
        }
        for word in tokens(text) {
            for digits in word.chunks(8) {
                let value = std::str::from_utf8(digits).ok().filter(|d| d.len() == 8);
                let Some(value) = value.and_then(|d| u32::from_str_radix(d, 16).ok()) else {
                    // The vertices of the others stay theirs.
                    self.block.push(NO_COLOR);
                    wrong.get_or_insert_with(|| {
                        format!(
                            "\"{}\" is no vertex colour: MMRRGGBB in hexadecimal digits is one",
                            crate::text::show(digits)
                        )
                    });
                    continue;
                };
                let [_, rgb @ ..] = value.to_be_bytes();
                let [r, g, b] = rgb.map(|byte| from_srgb(f64::from(byte) / 255.0));
                self.block.push([r, g, b, 1.0]);
            }
        }
        wrong.map_or(Ok(()), Err)
    }

    /// Gives the colours of a block of comments to their vertices.
    pub(crate) fn finish_block(&mut self) -> Result<(), String> {
        let block = std::mem::take(&mut self.block);
        let Some(first) = self.block_at.checked_sub(block.len()) else {
            let (colors, count) = (block.len(), self.block_at);
            return Err(format!(
                "{colors} vertex colours (#MRGB) follow {count} vertices: there are too many"
            ));
        };
        if !block.is_empty() {
            let end = self.block_at.max(self.colors.len());
            self.colors.resize(end, NO_COLOR);
            self.colors[first..self.block_at].copy_from_slice(&block);
        }
        Ok(())
    }
}
