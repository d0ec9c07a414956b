//! A loft measured afresh: at its sections, and between them.

use loftsman_kernel::measure::{Error, place};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Vector};

use super::align::{Aligned, area_vector};
use super::{Lofted, size_of};
use crate::error::{RegionError, Result};

/// Places on each section's pieces.
const A_PIECE: usize = 3;
/// Places on a section at most, beside three a piece of the first two thousand.
const MOST: usize = 6000;
/// Places round the surface, and between two sections, at which it is looked at.
const ROUND: usize = 48;
const BETWEEN: usize = 12;
/// A loft may swing out of the sections' box by this share of its longest side ...
const SWING: f64 = 0.5;
/// ... and its lines from section to section may be so much longer than their chords, all in all.
const LONGER: f64 = 2.0;
/// A section between two that has less than this share of the smaller one's area is told.
const NARROW: f64 = 0.25;

impl Lofted {
    /// The largest distance of a section, as it was given, from the surface where that should pass through it: between its
    /// knots, and at them.
    ///
    /// # Errors
    /// Where it is more than rounding of the coordinates, and of the parameters where those are far from zero.
    pub(super) fn measure(&mut self, given: &[Curve]) -> Result<()> {
        let (u0, u1) = self.surface.u().domain();
        let size = size_of(given);
        let vertices = self.surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        for (k, (section, change)) in given.iter().zip(&self.sections).enumerate() {
            for share in places(section, change) {
                let at = given_at(section, change, share);
                let mut out = [Vector::zeros(); 2];
                section.derivatives_into(at, &mut out)?;
                let on = self.surface.point((u0 + share * (u1 - u0)).min(u1), self.parameters[k])?;
                let (a, b) = section.domain();
                let blur = f64::EPSILON * (a.abs().max(b.abs()) + (b - a)) * out[1].amax();
                let Error { error, allowed } = place(&on, &Point::from(out[0]), vertices, size);
                self.deviation = self.deviation.max(error);
                if !(Error { error, allowed: allowed + 32.0 * blur }.holds()) {
                    return Err(RegionError::Sections(format!(
                        "the surface misses section {k} by {error}, more than rounding explains: lower the degree, or \
                         leave out sections that nearly coincide",
                        error = figure(error)
                    )));
                }
            }
        }
        Ok(())
    }

    /// Looks between the sections: refuses what swings out, and finds where the surface is narrowest.
    ///
    /// # Errors
    /// Where the surface leaves the sections' box by more than half its size, or its lines from section to section are, all
    /// in all, more than twice as long as their chords.
    pub(super) fn look_between(&mut self) -> Result<()> {
        let (u0, u1) = self.surface.u().domain();
        let us: Vec<f64> = (0..ROUND).map(|i| u0 + (u1 - u0) * (i as f64 + 0.5) / ROUND as f64).collect();
        let ring = |surface: &Surface, v: f64| -> Result<Vec<Point>> {
            Ok(us.iter().map(|&u| surface.point(u, v)).collect::<loftsman_kernel::Result<_>>()?)
        };
        let at: Vec<Vec<Point>> =
            self.parameters.iter().map(|&v| ring(&self.surface, v)).collect::<Result<_>>()?;
        let Some(start) = at.first().and_then(|r| r.first()) else { return Ok(()) };
        let (low, high) =
            at.iter().flatten().fold((*start, *start), |(low, high), p| (low.inf(p), high.sup(p)));
        let size = (high - low).amax();
        let area = |ring: &[Point]| {
            let centred: Vec<Vector> = ring.iter().map(|p| (p - start) / size).collect();
            area_vector(&centred).norm()
        };
        let (mut chords, mut lines, mut out) = (0.0, 0.0, (0.0, 0));
        for k in 1..at.len() {
            let (mut last, mut least) = (at[k - 1].clone(), (f64::INFINITY, 0.0));
            for i in 1..=BETWEEN {
                let share = i as f64 / BETWEEN as f64;
                let v = self.parameters[k - 1] * (1.0 - share) + self.parameters[k] * share;
                let now = if i == BETWEEN { at[k].clone() } else { ring(&self.surface, v)? };
                lines += last.iter().zip(&now).map(|(p, q)| ((q - p) / size).norm()).sum::<f64>();
                for p in &now {
                    let beyond = beyond(&low, p, &high);
                    // What is no point counts as far out.
                    if beyond > out.0 || beyond.is_nan() {
                        out = (beyond, k);
                    }
                }
                let here = area(&now);
                if i < BETWEEN && here < least.0 {
                    least = (here, v);
                }
                last = now;
            }
            chords += at[k - 1].iter().zip(&at[k]).map(|(p, q)| ((q - p) / size).norm()).sum::<f64>();
            let smaller = area(&at[k - 1]).min(area(&at[k]));
            let share = least.0 / smaller;
            if share < NARROW && self.narrow.is_none_or(|n| share < n.share) {
                self.narrow = Some(Narrow { after: k - 1, share });
            }
        }
        let (beyond, k) = out;
        let (outside, long) = (beyond / size, lines / chords);
        if outside.is_nan() || long.is_nan() || outside > SWING || long > LONGER {
            return Err(RegionError::Sections(format!(
                "a loft of degree {} swings out between its sections: {} at section {k}; lower the degree (3 seldom does), \
                 or space the sections more evenly",
                self.surface.v().degree(),
                if beyond <= SWING * size {
                    format!("its lines are {:.1} times as long as their chords, most", lines / chords)
                } else {
                    format!("{:.1} times the size of all sections, most", beyond / size)
                }
            )));
        }
        Ok(())
    }
}

/// Where a loft is much narrower than the sections on either side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// Between this section and the next one.
    pub after: usize,
    /// Its area there, as a share of the smaller one's.
    pub share: f64,
}

/// How far a point is out of a box: 0 inside, NaN where it is no point.
fn beyond(low: &Point, p: &Point, high: &Point) -> f64 {
    let sides = (low - p).iter().chain((p - high).iter()).copied().collect::<Vec<_>>();
    sides.into_iter().fold(0.0, |most: f64, x| if x > most || x.is_nan() { x } else { most })
}

/// Shares of the aligned section's parameters: inside each piece, and at its ends.
fn places(section: &Curve, change: &Aligned) -> Vec<f64> {
    let (a, b) = section.domain();
    let knots = section.space().breakpoints();
    let every = (knots.len() * (A_PIECE + 1)).div_ceil(MOST).max(1);
    let mut shares = Vec::new();
    for pair in knots.windows(2).step_by(every) {
        for i in 0..A_PIECE {
            let at = pair[0] + (pair[1] - pair[0]) * (i as f64 + 0.5) / A_PIECE as f64;
            let own = (at - a) / (b - a);
            let forward = if change.reversed { 1.0 - own } else { own };
            shares.push((forward - change.turned).rem_euclid(1.0));
        }
    }
    shares.push(0.0);
    shares
}

/// The parameter of a section, as it was given, at a share of the aligned one.
fn given_at(section: &Curve, change: &Aligned, share: f64) -> f64 {
    let (a, b) = section.domain();
    let forward = share + change.turned;
    let forward = if forward > 1.0 { forward - 1.0 } else { forward };
    let own = if change.reversed { 1.0 - forward } else { forward };
    (a + own * (b - a)).clamp(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loft::loft;
    use loftsman_kernel::shape::Shape;
    use loftsman_kernel::spline::Space;

    /// A ring of eight vertices, drawn up along z while its middle goes along `way`: quadratic, sections where it starts and ends.
    fn drawn(radius: f64, height: f64, way: &[Vector]) -> Lofted {
        let u = Space::periodic_uniform(3, 8).unwrap();
        let v = Space::clamped_uniform(2, way.len()).unwrap();
        let last = (way.len() - 1) as f64;
        let vertex = |i: usize, j: usize| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / 8.0).sin_cos();
            Point::new(radius * cos, radius * sin, height * j as f64 / last) + way[j]
        };
        let points =
            (0..8).flat_map(|i| (0..way.len()).map(move |j| (i, j))).map(|(i, j)| vertex(i, j)).collect();
        let (start, end) = v.domain();
        Lofted {
            surface: Surface::new(u, v, points).unwrap(),
            sections: vec![Aligned::default(); 2],
            parameters: vec![start, end],
            deviation: 0.0,
            narrow: None,
        }
    }

    #[test]
    fn what_swings_out_and_what_goes_to_and_fro_are_refused_each_for_itself() {
        let aside = |x: f64| Vector::new(x, 0.0, 0.0);
        let refused = |mut lofted: Lofted| lofted.look_between().map_err(|error| error.to_string());
        refused(drawn(1.0, 4.0, &[aside(0.0); 5])).unwrap();
        // Far out of the box, by lines that are not much longer than their chords.
        let out = refused(drawn(0.2, 4.0, &[0.0, 2.6, 2.6, 2.6, 0.0].map(aside))).unwrap_err();
        assert!(out.contains("times the size of all sections"), "{out}");
        // Within half of the box beside it, to and fro.
        let long = refused(drawn(5.0, 1.0, &[0.0, 2.0, -2.0, 2.0, -2.0, 0.0].map(aside))).unwrap_err();
        assert!(long.contains("times as long as their chords"), "{long}");
        let nothing = refused(drawn(1.0, 4.0, &[aside(0.0), aside(f64::MAX), aside(0.0)]));
        assert!(nothing.is_err());
    }

    #[test]
    fn a_section_that_is_missed_is_told() {
        let ring = |z: f64| Curve::circle(Point::new(0.0, 0.0, z), Vector::z(), 1.0 + z).unwrap();
        let given: Vec<Curve> = (0..4).map(|k| ring(f64::from(k))).collect();
        for by in [0.0, 1e-11, 0.1, f64::INFINITY] {
            let mut lofted = loft(&given, 3).unwrap();
            // The vertices of the last section end the rows of the net; they act on those before it, too. they act on those before it, too.
            let columns = lofted.surface.v().len();
            for point in lofted.surface.control_vertices_mut().iter_mut().skip(columns - 1).step_by(columns) {
                point.z += by;
            }
            match lofted.measure(&given) {
                Ok(()) => assert!(by == 0.0 && lofted.deviation < 1e-14),
                Err(error) => assert!(by > 0.0 && error.to_string().contains("misses section "), "{error}"),
            }
        }
    }
}
