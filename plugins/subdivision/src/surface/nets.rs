//! The bicubic pieces of a surface as they are: nets of points, and no rows.

use std::ops::Range;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{CellNet, CellSide};
use loftsman_kernel::{Point, Vector};

use super::SubdivisionSurface;
use super::ground::Ground;
use super::net::{Net, bezier, bezier_of};
use super::pattern::Quadrant;
use super::regular;
use crate::surface::refused;
use crate::topology::NONE;

impl SubdivisionSurface {
    /// The Bézier nets of cells. Cost: that of the faces' surroundings, where they are not regular, and for each cell a sum over the vertices that it
    /// depends on.
    pub(super) fn nets_of(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Result<()> {
        let (layout, mut last) = (&self.layout, None);
        let mut face = layout.cells.partition_point(|&first| first <= numbers.start).saturating_sub(1);
        while let (Some(&first), Some(&end)) = (layout.cells.get(face), layout.cells.get(face + 1))
            && first < numbers.end
        {
            let own = numbers.start.max(first)..numbers.end.min(end);
            if !own.is_empty() {
                let quadrants =
                    &layout.quadrants[layout.pattern_of[face] as usize][own.start - first..own.end - first];
                let mut number = own.start;
                self.nets_of_face(face, quadrants, origin, &mut last, &mut |quadrant, net| {
                    let size = 0.5_f64.powi(quadrant.level as i32);
                    let sides = [quadrant.i, quadrant.j].map(|k| CellSide {
                        start: k as f64 * size,
                        end: (k + 1) as f64 * size,
                        degree: 3,
                    });
                    each(CellNet { number, face: Some(face as u32), sides, points: net });
                    number += 1;
                })?;
            }
            face += 1;
        }
        Ok(())
    }

    fn nets_of_face(
        &self,
        face: usize,
        quadrants: &[Quadrant],
        origin: &Point,
        last: &mut Option<Ground>,
        each: &mut dyn FnMut(Quadrant, &Net),
    ) -> Result<()> {
        let points = self.cage.points();
        let [of, corner] = self.layout.faces[face];
        if let [Quadrant::WHOLE] = quadrants
            && corner == NONE
            && let Some(rows) = regular::net(&self.cage, of as usize)
        {
            let point = |&(v, c): &(u32, f64)| (points[v as usize] - origin) * c;
            let net = rows.map(|row| row.iter().map(point).sum::<Vector>());
            each(Quadrant::WHOLE, &bezier(&net));
            return Ok(());
        }
        let pattern = self.layout.pattern(face);
        let own = Ground::new(&self.cage, pattern, of, corner, last.as_ref()).map_err(refused)?;
        let points = own.points(|v| points[v as usize] - origin);
        let cage = own.cage(&self.cage);
        let part_of = |quadrant: &Quadrant| own.part(*quadrant).map(|(part, _)| part);
        for run in quadrants.chunk_by(|a, b| part_of(a) == part_of(b)) {
            let within = run.iter().filter_map(|&quadrant| own.part(quadrant).map(|(_, within)| within));
            let Some(part) = part_of(&run[0]) else { return Err(no_piece(face, run[0])) };
            let pieces = self.layout.templates.pieces(cage, own.near(part), within).map_err(refused)?;
            for (piece, &quadrant) in pieces.into_iter().zip(run) {
                let piece = piece.ok_or_else(|| no_piece(face, quadrant))?;
                each(quadrant, &bezier_of(&piece, |place| points.of(part)[place]));
            }
        }
        *last = Some(own);
        Ok(())
    }
}

fn no_piece(face: usize, quadrant: Quadrant) -> Error {
    Error::Invalid(format!("face {face} is no bicubic piece on a part that is counted as one: {quadrant:?}"))
}
