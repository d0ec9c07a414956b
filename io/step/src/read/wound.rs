//! Which way bounds run in the parameters that a file gives with their edges.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use loftsman_kernel::brep::Use;

use super::brep::Builder;

/// Places on each span of a parameter curve, by which the area inside a bound is told.
const EACH: usize = 8;
/// Ends that are nearer than this part of a bound's extent are one, and a latitude that is as near to a quarter of a turn is a pole.
const SAME: f64 = 1e-5;

/// A use in parameters: places from its start to its end, or both of a seam.
type Track = Vec<[f64; 2]>;

impl Builder<'_, '_> {
    /// The widest bound of a face that has the number `number` in the file, and whether it runs the wrong way round as its parameter curves have it; `None` where the
    /// file has not all of them, or they leave no area inside: where a bound goes around the surface.
    pub(super) fn outer_in_parameters(
        &self,
        face: usize,
        number: u64,
        turned: bool,
    ) -> Option<(usize, bool)> {
        let entity = self.space.entity(number).ok()?;
        if !matches!(entity.only(), b"ADVANCED_FACE" | b"FACE_SURFACE") {
            return None;
        }
        let (surface, same) = (entity.args().reference(2).ok()?, entity.args().flag(3).ok()?);
        let has_poles = self.space.entity(surface).ok()?.only() == b"SPHERICAL_SURFACE";
        let loops = &self.parts.faces[face].loops;
        let areas: Vec<f64> =
            loops.iter().map(|chain| self.area(chain, surface, has_poles)).collect::<Option<_>>()?;
        let (bound, area) = areas.into_iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        // Beside a vertex alone all of them are holes in a whole surface.
        let is_hole = !self.parts.faces[face].points.is_empty();
        let is_wrong = ((area > 0.0) != (same != turned)) != is_hole;
        (area != 0.0 && area.is_finite()).then_some((bound, is_wrong))
    }

    /// The area inside a bound in the parameters of a surface, less than nothing where it runs clockwise; `None` where it does not close there. Of the two sides of a seam
    /// the file may have either first: they are taken as they close.
    fn area(&self, chain: &[Use], surface: u64, has_poles: bool) -> Option<f64> {
        let tracks: Vec<Vec<Track>> =
            chain.iter().map(|one| self.tracks(one, surface)).collect::<Option<_>>()?;
        let mut times: HashMap<usize, usize> = HashMap::new();
        chain.iter().for_each(|one| *times.entry(one.edge).or_default() += 1);
        let twice = |one: &Use| times.get(&one.edge) == Some(&2);
        let of = |swapped: bool| -> Option<(usize, f64)> {
            let mut laid = Vec::with_capacity(chain.len());
            for (one, sides) in chain.iter().zip(&tracks) {
                let last = twice(one) && (one.reversed != swapped);
                if twice(one) && sides.len() != 2 {
                    return None;
                }
                laid.push(if last { sides.last()? } else { sides.first()? });
            }
            closed(&laid, has_poles)
        };
        let best = [of(false), of(true)].into_iter().flatten().min_by_key(|one| one.0)?;
        Some(best.1)
    }

    /// What a use is in the parameters of a surface, the way it runs.
    fn tracks(&self, one: &Use, surface: u64) -> Option<Vec<Track>> {
        let origin = *self.origins.get(&one.edge)?;
        let mut all = Vec::new();
        for curve in self.space.planar_curves(origin, surface).ok()? {
            let (from, to) = curve.domain();
            let count = EACH * curve.space().breakpoints().len();
            let mut track = Vec::with_capacity(count + 1);
            for k in 0..=count {
                let share = k as f64 / count as f64;
                let p = curve.point(if k == count { to } else { from + (to - from) * share }).ok()?;
                track.push([p.x, p.y]);
            }
            if one.reversed {
                track.reverse();
            }
            all.push(track);
        }
        (!all.is_empty()).then_some(all)
    }
}

/// How often a bound jumps along a pole, and the area inside it: what is along a pole adds nothing to that. `None` where it is torn elsewhere.
fn closed(laid: &[&Track], has_poles: bool) -> Option<(usize, f64)> {
    let all = || laid.iter().copied().flatten();
    let extent = [0, 1].map(|d: usize| {
        let ends = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[d]), h.max(p[d])));
        ends.1 - ends.0
    });
    let (mut jumps, mut area) = (0, 0.0);
    for (track, next) in laid.iter().zip(laid.iter().cycle().skip(1)) {
        area += track
            .windows(2)
            .map(|pair| 0.5 * (pair[0][0] + pair[1][0]) * (pair[1][1] - pair[0][1]))
            .sum::<f64>();
        let (end, start) = (track.last()?, next.first()?);
        let apart = [0, 1].map(|d: usize| (end[d] - start[d]).abs() > SAME * extent[d]);
        if apart[1] {
            return None;
        }
        if apart[0] {
            if !(has_poles && (end[1].abs() - FRAC_PI_2).abs() <= SAME) {
                return None;
            }
            jumps += 1;
        }
    }
    (area.abs() > SAME * extent[0] * extent[1]).then_some((jumps, area))
}
