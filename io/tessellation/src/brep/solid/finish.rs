//! The faces filled and all put together.

use std::collections::BTreeSet;

use loftsman_kernel::plugin::{Apart, Chord, Fineness, TessellatedBrep};
use loftsman_kernel::{Error, Point, Result, Vector, parallel};

use super::Cut;
use super::finer::{FINER_BY, FINEST};
use super::lay::Laid;
use crate::brep::assemble::{Piece, assemble};
use crate::brep::fill::fill;
use crate::brep::plane::Trouble;
use crate::fineness::Frame;
use crate::surface;

impl Cut<'_> {
    /// Points inside faces, as far as they are known yet.
    pub(super) fn inner_samples(&mut self) -> Vec<Point> {
        let found = parallel::map_mut(
            &mut self.planes,
            || (),
            |(), _, plane| {
                let Some(Laid { plane: Ok(plane), .. }) = plane else { return Vec::new() };
                let carrier = plane.carrier;
                if carrier.flat {
                    return Vec::new();
                }
                let Ok(inside) = plane.labels() else { return Vec::new() };
                let triangles = plane.triangles(&inside);
                let centre = |corners: [u32; 3]| -> Vector {
                    let at = corners.map(|k| plane.vertices[k as usize].at);
                    carrier.point([0, 1].map(|d: usize| (at[0][d] + at[1][d] + at[2][d]) / 3.0))
                };
                triangles.into_iter().map(|(corners, _)| carrier.unframed(&centre(corners))).collect()
            },
        );
        found.into_iter().flatten().collect()
    }

    /// Fills the faces and puts all together.
    pub(super) fn finish(mut self, frame: &Frame, fineness: &Fineness) -> Result<TessellatedBrep> {
        let (all, inner) = self.numbered(0..self.brep.edge_count());
        let (vertices, first_own) = (self.brep.vertices(), all.next);
        let mut points = vertices.to_vec();
        points.extend(inner);
        let mut planes = std::mem::take(&mut self.planes);
        let made = parallel::map_mut(
            &mut planes,
            || (),
            |(), face, plane| -> Option<Result<Piece>> {
                let reversed = self.brep.is_reversed(face);
                if self.brep.loops(face).is_empty() {
                    let surface = self.brep.surface(face)?;
                    let fineness = Fineness { chord: Chord::Absolute(self.tolerance), ..*fineness };
                    let whole = surface::mesh(&surface, &fineness, self.goal.budget, None);
                    return Some(whole.map(|found| {
                        Piece::whole(&found.mesh, frame, reversed, first_own, found.error / self.goal.size)
                    }));
                }
                Some(match plane.take()?.of_all(vertices.len(), &all) {
                    Ok(mut plane) => fill(&mut plane, &self.goal)
                        .and_then(|filled| Piece::new(&plane, filled, reversed, first_own)),
                    Err(Trouble::Clash(clash)) => Err(self.told(face, &clash)),
                    Err(Trouble::Other(error)) => Err(error),
                })
            },
        );
        let mut pieces = Vec::new();
        for (face, piece) in made.into_iter().enumerate() {
            match piece {
                Some(Ok(piece)) => pieces.push((face, piece)),
                Some(Err(error)) => _ = self.troubles.insert(face, error),
                None => {}
            }
        }
        let left_out: Vec<(usize, Error)> = self.troubles.clone().into_iter().collect();
        if pieces.is_empty() {
            let reason = left_out.first().map(|(face, error)| format!(": face {face}: {error}"));
            return Err(Error::Invalid(format!(
                "none of its {} faces can be cut{}",
                self.brep.face_count(),
                reason.unwrap_or_default()
            )));
        }
        let count: usize = pieces.iter().map(|(_, piece)| piece.corners.len()).sum();
        if count > self.goal.budget {
            let tolerance = self.tolerance;
            return Err(Error::Invalid(format!(
                "a chord tolerance of {tolerance:e} needs {count} triangles, more than {}: choose a coarser one",
                self.goal.budget
            )));
        }
        let whole = assemble(&pieces, &points, frame)?;
        let present: BTreeSet<usize> = pieces.iter().map(|(face, _)| *face).collect();
        let mut error = pieces.iter().map(|(_, piece)| piece.error).fold(0.0, f64::max);
        let mut edges = vec![Vec::new(); self.brep.edge_count()];
        let mut furthest: Option<Apart> = None;
        for (number, out) in edges.iter_mut().enumerate() {
            if !self.brep.uses(number).iter().any(|place| present.contains(&place.face)) {
                continue;
            }
            if let Some(Some(chain)) = self.chains.get(number) {
                error = error.max(chain.bend + chain.beside + chain.off);
                if let Some(face) = chain.off_face
                    && furthest.is_none_or(|known| known.distance < chain.off * self.goal.size)
                {
                    furthest = Some(Apart { edge: number, face, distance: chain.off * self.goal.size });
                }
                let numbers = self.numbers(number, &all).into_iter();
                *out = numbers.filter_map(|k| whole.numbers.get(k as usize).copied().flatten()).collect();
            }
        }
        Ok(TessellatedBrep {
            mesh: whole.mesh,
            faces: whole.faces,
            edges,
            left_out,
            tolerance: self.tolerance,
            error: error * self.goal.size,
            furthest,
        })
    }

    /// What is said of chords that cannot get out of each other's way.
    fn told(&self, face: usize, clash: &[(usize, usize)]) -> Error {
        let edges: BTreeSet<usize> = clash.iter().map(|(edge, _)| *edge).collect();
        let names: Vec<String> = edges.iter().map(usize::to_string).collect();
        let place = clash.first().and_then(|(edge, part)| {
            let chain = self.chains.get(*edge)?.as_ref()?;
            chain.points.get(*part).copied()
        });
        let near = place.map_or(String::new(), |p| {
            let short = loftsman_kernel::text::short;
            format!(" near ({}, {}, {})", short(p.x), short(p.y), short(p.z))
        });
        let names = names.join(", ");
        let keep = "loops must keep clear of one another and of themselves";
        // Where chords meet in space, finer ones do, too.
        let hint = if self.meet(face, clash) {
            String::new()
        } else {
            let finer = loftsman_kernel::text::short(FINEST * FINER_BY * self.tolerance);
            format!("; where they only come close, a tolerance of {finer} may part them")
        };
        Error::Invalid(format!("its loops cross or touch at edge {names}{near}: {keep}{hint}"))
    }
}
