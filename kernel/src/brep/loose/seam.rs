//! Faces on surfaces that close: what keeps these closed where a seam may become a crease. Loops may cross it without an edge there.

use std::collections::BTreeMap;

use super::super::Brep;
use super::sheet::{CLOSES, Sheet};
use crate::error::Result;
use crate::shape::{Bond, Stencil};
use crate::spline::Direction;

impl Brep {
    /// What keeps surfaces closed that move; where nothing may become sharp it is kept with all else that is smooth.
    pub(super) fn seams(&self, sheets: &BTreeMap<usize, Sheet>) -> Result<Vec<Bond>> {
        let found = sheets.values().map(|sheet| self.seam(sheet)).collect::<Result<Vec<Bond>>>()?;
        Ok(found.into_iter().filter(|bond| !bond.rows.is_empty()).collect())
    }

    /// The rows that keep both ends of a surface together where it closes without being periodic, and each pole one point: `P_i - P_j = 0` for pairs of control
    /// vertices, none of which the others imply.
    fn seam(&self, sheet: &Sheet) -> Result<Bond> {
        let mut bond = Bond { name: format!("the seam of face {}", sheet.face), rows: Vec::new() };
        let Some(product) = self.product(sheet.face) else { return Ok(bond) };
        let points = sheet.surface.points();
        let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
        let sides = sheet.surface.parameter_sides(CLOSES * size)?;
        let counts = [product.u.len(), product.v.len()];
        let vertex = |d: usize, along: usize, across: usize| {
            let [i, j] = if d == 0 { [along, across] } else { [across, along] };
            product.first + i * counts[1] + j
        };
        let mut tie =
            |a: usize, b: usize| bond.rows.push([(a, 1.0), (b, -1.0)].into_iter().collect::<Stencil>());
        for (d, side) in sides.iter().enumerate() {
            for (pole, end) in side.poles.into_iter().zip([0, counts[d] - 1]) {
                if pole {
                    (1..counts[1 - d]).for_each(|k| tie(vertex(d, end, k), vertex(d, end, 0)));
                }
            }
            let direction = if d == 0 { Direction::U } else { Direction::V };
            if !side.closed || sheet.surface.space(direction).is_periodic() {
                continue;
            }
            // What is in a pole, or the seam of the other direction says, is so already.
            let other = &sides[1 - d];
            let last = counts[1 - d] - 1;
            let from = usize::from(other.poles[0]);
            let closes = d == 1 && other.closed && !sheet.surface.u().is_periodic();
            let to = last - usize::from(other.poles[1] || closes);
            (from..=to).for_each(|k| tie(vertex(d, counts[d] - 1, k), vertex(d, 0, k)));
        }
        Ok(bond)
    }
}
