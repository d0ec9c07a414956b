//! How far edges are from their vertices and surfaces.

use std::sync::OnceLock;

use super::Brep;
use crate::error::Result;
use crate::spline::{Curve, Surface};
use crate::{Point, parallel};

/// The part of a distance that is more than a tolerance by which another place may be nearer than the one that is taken.
const OFF: f64 = 1e-3;

/// Pieces of a surface that are looked at, place after place, for what of an edge may be nearer to it than where the way downhill has ended. On files of CAD programs
/// a place takes some tens; on those with one wrong number in them all places of an edge may be about as far from a million pieces.
const PIECES: usize = 4000;

/// Edges that are off by more than this part of the Brep's size are misplaced: no rounding of a writer, nor a curve that it fitted, comes to that.
const MISPLACED: f64 = 1e-4;
/// Edges that are off by less than this part of the Brep's size, or of how far away it is, are so by rounding.
const ROUNDING: f64 = 1e-9;
const ROUNDING_FAR_AWAY: f64 = 1e-12;
/// What is off by no more than this many times its tolerance is as the file meant it: readers allow for that, and a larger tolerance moves more.
const MEANT: f64 = 2.0;
/// So many flaws are told one by one.
const TOLD: usize = 3;

/// What is known of a Brep until something of it moves: what is [misplaced](Brep::misplaced). No part of what it is.
#[derive(Debug, Clone, Default)]
pub(super) struct Known(OnceLock<Vec<Flaw>>);

impl PartialEq for Known {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Something that is further from its place than its tolerance says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flaw {
    /// An end of an edge is not at its vertex.
    End {
        /// The edge.
        edge: usize,
        /// The vertex.
        vertex: usize,
        /// How far apart they are.
        distance: f64,
    },
    /// An edge is not on the surface of a face that it bounds.
    Off {
        /// The edge.
        edge: usize,
        /// The face.
        face: usize,
        /// Where on the edge's curve it is furthest off.
        at: f64,
        /// By how much there.
        distance: f64,
    },
}

impl Flaw {
    /// How far apart the two are.
    pub fn distance(&self) -> f64 {
        match self {
            Self::End { distance, .. } | Self::Off { distance, .. } => *distance,
        }
    }

    /// Flaws in words: the first of them, and how many more there are; `None` where there are none. As [`Brep::misplaced`] has them these are the
    /// furthest.
    pub fn told(flaws: &[Self]) -> Option<String> {
        let told: Vec<String> = flaws.iter().take(TOLD).map(Self::to_string).collect();
        let more = match flaws.len().saturating_sub(TOLD) {
            0 => String::new(),
            more => format!("; {more} more by less"),
        };
        (!flaws.is_empty()).then(|| told.join("; ") + &more)
    }
}

impl std::fmt::Display for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let short = crate::text::short;
        match self {
            Self::End { edge, vertex, distance } => {
                write!(f, "edge {edge} ends {} from vertex {vertex}", short(*distance))
            }
            Self::Off { edge, face, distance, .. } => {
                write!(f, "edge {edge} is up to {} off the surface of face {face}", short(*distance))
            }
        }
    }
}

impl Brep {
    /// What is further from its place than its own tolerance and `slack` (in the scene's unit): ends of edges from vertices, edges
    /// from the surfaces of their faces, at `2p + 3` places of each knot span. By number of edge. Each place costs a few steps downhill
    /// on the surface from the place before; where these end too far off, and further than at the places before, a search of all of it, as long as it has looked at
    /// few pieces of the surface for the edge: after that what is said to be off may be so by less.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn flaws(&self, slack: f64) -> Result<Vec<Flaw>> {
        self.flaws_beyond(slack, slack)
    }

    /// As [`flaws`](Self::flaws), with a search of all of a surface only for what is further off than `far`.
    fn flaws_beyond(&self, slack: f64, far: f64) -> Result<Vec<Flaw>> {
        let surfaces: Vec<Option<Surface>> = (0..self.face_count()).map(|face| self.surface(face)).collect();
        let found = parallel::map(self.edge_count(), |edge| self.flaws_of(edge, &surfaces, [slack, far]));
        let mut all = Vec::new();
        for one in found {
            all.extend(one?);
        }
        Ok(all)
    }

    /// How far edges are from their vertices and from the surfaces of their faces, at the places of [`flaws`](Self::flaws), where that is more than twice what their
    /// tolerances say: what a file should state to be taken as it is. 0 where tolerances say it, but for rounding. What is [misplaced](Self::misplaced) is none
    /// of it: no tolerance mends that.
    ///
    /// # Errors
    /// As for [`flaws`](Self::flaws).
    pub fn gap(&self) -> Result<f64> {
        let (size, away) = self.extent();
        let (least, most) = ((ROUNDING * size).max(ROUNDING_FAR_AWAY * away), MISPLACED * size);
        let found = self.flaws_beyond(least, most)?;
        let said = |flaw: &Flaw| match *flaw {
            Flaw::End { edge, vertex, .. } => self.tolerances[vertex].max(self.edges[edge].tolerance),
            Flaw::Off { edge, .. } => self.edges[edge].tolerance,
        };
        let more = found.iter().filter(|flaw| flaw.distance() > MEANT * said(flaw));
        Ok(more.map(Flaw::distance).filter(|distance| *distance <= most).fold(0.0, f64::max))
    }

    /// The diagonal of the box around the vertices, and how far away that is.
    fn extent(&self) -> (f64, f64) {
        let vertices = self.vertices();
        let first = vertices.first().copied().unwrap_or_default();
        let (low, high) = vertices.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        ((high - low).norm(), low.coords.amax().max(high.coords.amax()))
    }

    /// What is further from its place than any rounding of a writer brings it, 1e-4 of the Brep's size, the furthest first: as [`flaws`](Self::flaws), and
    /// found once, as long as nothing moves.
    ///
    /// # Errors
    /// As for [`flaws`](Self::flaws).
    pub fn misplaced(&self) -> Result<Vec<Flaw>> {
        if let Some(known) = self.known.0.get() {
            return Ok(known.clone());
        }
        let mut flaws = self.flaws(MISPLACED * self.extent().0)?;
        flaws.sort_by(|a, b| b.distance().total_cmp(&a.distance()));
        Ok(self.known.0.get_or_init(|| flaws).clone())
    }

    fn flaws_of(
        &self,
        number: usize,
        surfaces: &[Option<Surface>],
        [slack, far]: [f64; 2],
    ) -> Result<Vec<Flaw>> {
        let mut flaws = Vec::new();
        let Some(edge) = self.edge(number) else { return Ok(flaws) };
        let (from, to) = edge.range;
        for (t, vertex) in [from, to].into_iter().zip(edge.ends) {
            let distance = nalgebra::distance(&edge.curve.point(t)?, &self.vertices()[vertex]);
            if distance > self.tolerances[vertex].max(edge.tolerance) + slack {
                flaws.push(Flaw::End { edge: number, vertex, distance });
            }
        }
        let places = places(&edge.curve, from, to);
        let points: Vec<Point> = places.iter().map(|&t| edge.curve.point(t)).collect::<Result<_>>()?;
        let mut faces: Vec<usize> = self.uses(number).iter().map(|place| place.face).collect();
        faces.dedup();
        for face in faces {
            let Some(surface) = &surfaces[face] else { continue };
            let mut worst = (from, 0.0);
            let mut last = None;
            let mut left = PIECES;
            for (&t, point) in places.iter().zip(&points) {
                let enough = edge.tolerance + slack;
                let start = last.unwrap_or_else(|| surface.seed(*point));
                let mut foot =
                    surface.foot_within(*point, start, enough).map(|foot| (foot.at, foot.distance))?;
                // Downhill it may have come to a border that the edge crosses, or to another sheet.
                if foot.1 > (edge.tolerance + far).max(worst.1) && left > 0 {
                    // Which of the places that are about as near matters not; of that one the distance is told as it is.
                    let (nearly, looked) = surface.nearly_closest_of(*point, 0.01 * enough, OFF, left)?;
                    left = left.saturating_sub(looked);
                    let closest = surface.foot(*point, nearly.at)?;
                    for other in [(closest.at, closest.distance), (nearly.at, nearly.distance)] {
                        if other.1 < foot.1 {
                            foot = other;
                        }
                    }
                }
                last = Some(foot.0);
                if foot.1 > worst.1 {
                    worst = (t, foot.1);
                }
            }
            if worst.1 > edge.tolerance + slack {
                flaws.push(Flaw::Off { edge: number, face, at: worst.0, distance: worst.1 });
            }
        }
        Ok(flaws)
    }
}

/// Parameters of a part of a curve: some in each of its knot spans, and both ends.
fn places(curve: &Curve, from: f64, to: f64) -> Vec<f64> {
    let (start, end) = curve.domain();
    let breaks = curve.space().breakpoints();
    // On a periodic curve the part may run into the next period.
    let turns = if to > end { vec![0.0, end - start] } else { vec![0.0] };
    let mut knots = vec![from];
    for turn in turns {
        knots.extend(breaks.iter().map(|t| t + turn).filter(|t| *t > from && *t < to));
    }
    knots.push(to);
    let steps = 2 * curve.degree() + 2;
    let mut places = vec![from];
    for pair in knots.windows(2) {
        places.extend((1..=steps).map(|k| pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64)));
    }
    places
}
