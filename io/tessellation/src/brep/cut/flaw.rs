//! Whether a chord is near enough to its stretch of the edge, and to all faces that have it.

use loftsman_kernel::{Result, Vector};

use super::{BESIDE, Chain, Flaw, Path, SHARE, Sample, TURN};
use crate::brep::carrier::Carrier;

impl Chain {
    /// What is wrong with a chord, if anything is.
    pub(super) fn flaw(&mut self, part: usize, carriers: &[Option<Carrier>]) -> Result<Option<Flaw>> {
        let (ta, tb) = (self.parameters[part], self.parameters[part + 1]);
        let middle = 0.5 * (ta + tb);
        let mut halfway: Option<Sample> = None;
        for k in 0..self.tracks.len() {
            let Some(carrier) = carriers.get(self.tracks[k].face).and_then(Option::as_ref) else { continue };
            let Some([a, b]) = Self::ends(&self.tracks[k], part, carrier) else { continue };
            if let Some(flaw) = self.crossing(part, k, [a, b], carrier)? {
                return Ok(Some(flaw));
            }
            let Some([a, b]) = Self::ends(&self.tracks[k], part, carrier) else { continue };
            if halfway.is_none() {
                halfway = Some(self.sample(middle, Some(&self.places(part)), carriers)?);
            }
            let Some(half) = &halfway else { continue };
            if self.tracks[k].is_far(half.off[k]) {
                self.tracks[k].lose(half.off[k]);
                continue;
            }
            let (off, mut m) = (half.off[k], half.at[k]);
            self.is_off(k, off);
            for d in 0..2 {
                if m[d].is_nan() {
                    m[d] = a[d];
                }
                m[d] = carrier.sides[d].unwrapped(m[d], 0.5 * (a[d] + b[d]));
            }
            let (mut low, mut high) = (a, a);
            for x in [b, m] {
                for d in 0..2 {
                    (low[d], high[d]) = (low[d].min(x[d]), high[d].max(x[d]));
                }
            }
            if let Path::Lifted(curve) = &self.path {
                let hull = curve.between(ta, tb)?;
                let hull = hull.points().iter().map(|p| [0, 1].map(|d: usize| [p.x, p.y][d]));
                let speeds = carrier.bounds.speeds(low, high);
                let mut away = 0.0_f64;
                // Shifted to where the ends are.
                let first = curve.point(ta)?;
                let shift = [a[0] - first.x, a[1] - first.y];
                for p in hull {
                    let p = [p[0] + shift[0], p[1] + shift[1]];
                    for d in 0..2 {
                        (low[d], high[d]) = (low[d].min(p[d]), high[d].max(p[d]));
                    }
                    away = away.max(distance(p, [a, b], speeds));
                }
                let away = std::f64::consts::SQRT_2 * away;
                if away > SHARE * self.goal.chord {
                    return Ok(Some(Flaw::At(middle)));
                }
                self.bend = self.bend.max(away);
            }
            let turns = (0..2).any(|d| {
                let side = &carrier.sides[d];
                side.closed && high[d] - low[d] > TURN * side.length()
            });
            if turns {
                return Ok(Some(Flaw::At(middle)));
            }
            // Boxes that go beyond a seam bend as what is on the other side does.
            let inside = [0, 1].map(|d: usize| {
                let side = &carrier.sides[d];
                let shift = if low[d] < side.low && side.closed {
                    side.length()
                } else if high[d] > side.high && side.closed {
                    -side.length()
                } else {
                    0.0
                };
                [low[d] + shift, high[d] + shift]
            });
            let (low, high) = ([inside[0][0], inside[1][0]], [inside[0][1], inside[1][1]]);
            let whole = carrier.whole_within(low, high, BESIDE * self.goal.chord);
            if whole > BESIDE * self.goal.chord {
                return Ok(Some(Flaw::At(middle)));
            }
            self.beside = self.beside.max(whole);
            if self.goal.angle >= std::f64::consts::PI {
                continue;
            }
            let ends = [&self.points[part], &self.points[part + 1]].map(|p| carrier.framed(p));
            if (ends[1] - ends[0]).norm() > 2.0 * self.goal.chord && !carrier.flat {
                let wrap = |at: [f64; 2]| [0, 1].map(|d: usize| carrier.sides[d].wrapped(at[d]));
                let (wa, wb) = (wrap(a), wrap(b));
                let [n, o] = [carrier.normal(wa, wb), carrier.normal(wb, wa)];
                if n != Vector::zeros() && o != Vector::zeros() && n.angle(&o) > self.goal.angle {
                    // A crease along the edge turns at once, and not less on any part of it.
                    let o = carrier.normal(wrap(m), wa);
                    if n.angle(&o) > 0.25 * self.goal.angle
                        || carrier.normal(wrap(m), wb).angle(&o) > 0.25 * self.goal.angle
                    {
                        return Ok(Some(Flaw::At(middle)));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// The distance of a place from a segment, both scaled.
fn distance(p: [f64; 2], [a, b]: [[f64; 2]; 2], scale: [f64; 2]) -> f64 {
    let scaled =
        |x: [f64; 2], y: [f64; 2]| nalgebra::Vector2::new((y[0] - x[0]) * scale[0], (y[1] - x[1]) * scale[1]);
    let (along, to) = (scaled(a, b), scaled(a, p));
    let squared = along.norm_squared();
    let share = if squared > 0.0 { (to.dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (to - along * share).norm()
}
