//! Loops, special curves and special points of surfaces, and where surfaces meet.

use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Surface, Trimmed};

use super::build::Stop;
use super::{At, Body, Freeform, Mended, Piece, Used, at, check};
use crate::number::{entry, next_number};
use crate::read::raw::Raw;
use crate::read::section::Shape;
use crate::read::statement::Known;
use crate::text::{keyword, tokens};

/// `con`: two surfaces by their numbers, each with a curve in its parameter plane.
#[derive(Debug)]
pub(crate) struct Meeting {
    pub(crate) sides: [(usize, ParameterCurve); 2],
    pub(crate) line: usize,
}

/// `u0 u1 curve …`, for each curve of a chain.
pub(super) fn pieces(mut text: &[u8], count: usize) -> Result<Vec<Piece>, String> {
    let mut pieces = Vec::new();
    let missing = || "each curve of a loop needs a start, an end and the number of a curv2".to_owned();
    while let Some(from) = next_number(&mut text)? {
        let to = next_number(&mut text)?.ok_or_else(missing)?;
        let (word, rest) = keyword(text);
        if word.is_empty() {
            return Err(missing());
        }
        let curve = entry(word, count, "curve (curv2)")?;
        check(curve, count, "curve (curv2)")?;
        pieces.push((from, to, curve));
        text = rest;
    }
    if pieces.is_empty() {
        return Err(missing());
    }
    Ok(pieces)
}

impl Freeform {
    /// A surface with the loops, special curves and special points of its body; itself where there are none.
    pub(super) fn trimmed(
        &mut self,
        surface: Surface,
        body: &Body,
        raw: &Raw,
        used: &mut Used,
        mended: &mut Mended,
    ) -> Result<Shape, Stop> {
        if body.loops.is_empty() && body.special.is_empty() {
            return Ok(Shape::Surface(surface));
        }
        let mut regions: Vec<Region> = Vec::new();
        let mut curves = Vec::new();
        for one in &body.loops {
            let mut chain = Vec::with_capacity(one.pieces.len());
            for &piece in &one.pieces {
                let (curve, turned) = self.parameter_curve(piece, one.line)?;
                mended.turned |= turned;
                chain.push(curve);
            }
            match one.kind {
                Known::Trim => regions.push(Region { outer: chain, holes: Vec::new() }),
                Known::Hole => {
                    // A hole before any outer loop is one in the whole surface.
                    if regions.is_empty() {
                        regions.push(Region::default());
                    }
                    regions
                        .iter_mut()
                        .last()
                        .into_iter()
                        .for_each(|r| r.holes.push(std::mem::take(&mut chain)));
                }
                _ => curves.push(chain),
            }
        }
        let points =
            body.special.iter().map(|&p| raw.parameters[p as usize]).map(|[u, v, _]| [u, v]).collect();
        let trimmed = Trimmed::new(surface, regions, curves, points).map_err(|e| Stop::kernel(&e, body))?;
        used.parameters.extend(&body.special);
        used.loops += body.loops.len();
        for &(_, _, curve) in body.loops.iter().flat_map(|l| &l.pieces) {
            self.plane_curves[curve as usize].used = true;
        }
        Ok(Shape::Trimmed(trimmed))
    }

    /// The part of a curve that a loop uses, and whether it had to be turned round: a range that decreases runs backwards.
    fn parameter_curve(
        &mut self,
        (from, to, number): Piece,
        line: usize,
    ) -> Result<(ParameterCurve, bool), Stop> {
        let Some(curve) = &self.plane_curves[number as usize].curve else {
            return Err(Stop::LeftOut("it is trimmed by curves that are left out".to_owned()));
        };
        self.held += curve.points().len();
        if self.held > self.budget {
            let problem = "the curves of the parameter plane are used so often that the scene would be many times the file";
            return Err(Stop::At(at(line, problem)));
        }
        // Ranges are often printed with fewer digits than knots.
        let (a, b) = curve.domain();
        let slack = 1e-9 * (b - a);
        let near = |t: f64| {
            if (t - a).abs() <= slack {
                a
            } else if (t - b).abs() <= slack {
                b
            } else {
                t
            }
        };
        let (from, to) = (near(from), near(to));
        let turned = from > to;
        let made = if turned {
            let reverse =
                curve.reverse().map_err(|e| Stop::At(at(line, format!("curve {}: {e}", number + 1))))?;
            // The ends exactly, where they are those of the curve.
            let back = |t: f64| {
                if t == a {
                    b
                } else if t == b {
                    a
                } else {
                    (a + (b - t)).clamp(a, b)
                }
            };
            ParameterCurve::new(reverse, back(from), back(to))
        } else {
            ParameterCurve::new(curve.clone(), from, to)
        };
        let made = made.map_err(|e| Stop::At(at(line, format!("curve {}: {e}", number + 1))))?;
        Ok((made, turned))
    }

    /// `con surf_1 q0_1 q1_1 curv2d_1 surf_2 q0_2 q1_2 curv2d_2`; a reason where it is left out.
    pub(crate) fn connection(&mut self, rest: &[u8], line: usize) -> Result<Result<Meeting, String>, At> {
        let found: Vec<&[u8]> = tokens(rest).collect();
        let [s1, a1, b1, c1, s2, a2, b2, c2] = found[..] else {
            return Err(format!("con has {} values: 8 are right", found.len()).into());
        };
        let mut sides = Vec::with_capacity(2);
        for [surface, from, to, curve] in [[s1, a1, b1, c1], [s2, a2, b2, c2]] {
            let count = self.surfaces.len();
            let surface = entry(surface, count, "surface")?;
            check(surface, count, "surface")?;
            let count = self.plane_curves.len();
            let curve = entry(curve, count, "curve (curv2)")?;
            check(curve, count, "curve (curv2)")?;
            if !self.surfaces[surface as usize] {
                return Ok(Err("it connects a surface that is left out".to_owned()));
            }
            let number = |mut word: &[u8]| Ok::<f64, String>(next_number(&mut word)?.unwrap_or_default());
            let piece = (number(from)?, number(to)?, curve);
            match self.parameter_curve(piece, line) {
                Ok((made, _)) => sides.push((surface as usize, made)),
                Err(Stop::LeftOut(reason)) => return Ok(Err(reason)),
                Err(Stop::At(error)) => return Err(error),
            }
            self.plane_curves[curve as usize].used = true;
        }
        match <[_; 2]>::try_from(sides) {
            Ok(sides) => Ok(Ok(Meeting { sides, line })),
            Err(_) => Ok(Err("it connects nothing".to_owned())),
        }
    }
}
