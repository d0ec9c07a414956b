//! What counts of a Brep's surfaces, and what they bound.

use super::Brep;
use crate::error::{Error, Result};
use crate::parallel;
use crate::shape::{Cells, Share};

/// How many open edges a message names.
const NAMED: usize = 5;

impl Brep {
    /// What loops leave of the cells of its surfaces, face after face.
    pub(super) fn shares_of_cells(&self) -> Result<Option<Vec<Share>>> {
        if !self.is_partial() {
            return Ok(None);
        }
        let of = |face: usize| -> Result<Vec<Share>> {
            let region = self
                .parameter_region(face)
                .map_err(|error| Error::Invalid(format!("face {face}: {error}")))?;
            let Some(product) = self.product(face) else { return Ok(Vec::new()) };
            let share = |index: usize| match product.cell(index, None).as_ref().map(|cell| &cell.sides[..]) {
                Some([u, v]) => {
                    region.as_ref().map_or(Share::Whole, |region| region.share([u.start, v.start]).clone())
                }
                _ => Share::Nothing,
            };
            Ok((0..product.cell_count()).map(share).collect())
        };
        let mut all = Vec::with_capacity(self.count());
        for shares in parallel::map(self.face_count(), of) {
            all.extend(shares?);
        }
        Ok(Some(all))
    }

    /// How the faces are turned that bound volumes: those of its solids; where it has none, those of shells that close.
    pub(super) fn senses_of_faces(&self) -> Result<Vec<f64>> {
        let mut senses = vec![0.0; self.face_count()];
        let mut count = |shell: usize| {
            for &face in self.shells.get(shell).map_or(&[][..], |shell| &shell.faces) {
                senses[face] = if self.is_reversed(face) { -1.0 } else { 1.0 };
            }
        };
        for solid in &self.solids {
            std::iter::once(&solid.outer).chain(&solid.voids).for_each(|&shell| count(shell));
        }
        if !self.solids.is_empty() {
            return Ok(senses);
        }
        let closed: Vec<usize> =
            (0..self.shells.len()).filter(|&shell| self.is_closed(&self.shells[shell].faces)).collect();
        closed.iter().for_each(|&shell| count(shell));
        if closed.is_empty() {
            let all: Vec<usize> = (0..self.face_count()).collect();
            let open = self.open_edges(&all);
            let names: Vec<String> = open.iter().take(NAMED).map(usize::to_string).collect();
            let more = if open.len() > NAMED { ", …" } else { "" };
            return Err(Error::Invalid(format!(
                "it has no solid, and no shell of it closes: it is open at {} edges (number {}{more})",
                open.len(),
                names.join(", ")
            )));
        }
        Ok(senses)
    }
}
