//! Corners of a path: how sections lean beside them, so that both sides end in the plane between them.

use loftsman_kernel::error::Result;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};

use super::{Frame, Lean, Walk};
use crate::sweep::Mitre;

impl Walk<'_> {
    /// How sections lean: at a corner so far that they lie in the plane between both sides. From there it takes one straight piece, where that is
    /// long enough, or as many as are twice as long as what the profile's vertices are moved, but not beyond the next corner.
    pub(super) fn leaning(&self, profile: &Curve) -> Result<Vec<[Option<Lean>; 2]>> {
        let count = self.pieces.len();
        // The rotations at both ends of each piece.
        let mut ends: Vec<Option<[Frame; 2]>> = vec![None; count];
        self.each(true, |begin, end, _| {
            match &mut ends[begin.piece] {
                Some([_, last]) => *last = end.clone(),
                none => *none = Some([begin.clone(), end.clone()]),
            }
            Ok(true)
        })?;
        let start = self.start();
        let mut leans = vec![[None; 2]; count];
        for k in 0..count {
            for side in [0, 1] {
                let (Some(across), Some(ends)) = (self.mitres[k][side], &ends[k]) else { continue };
                let frame = &ends[side];
                let by = -(frame.turn.transpose() * across) / frame.tangent.dot(&across);
                let furthest =
                    profile.points().iter().map(|p| by.dot(&(p - start)).abs()).fold(0.0, f64::max);
                let (mut reach, mut last) = (0.0, k);
                loop {
                    let length = self.lengths[last] - if last > 0 { self.lengths[last - 1] } else { 0.0 };
                    reach += length;
                    let enough = if last == k && self.straight[k] { furthest } else { 2.0 * furthest };
                    let next = if side == 0 { last + 1 } else { last.wrapping_sub(1) };
                    if reach > enough || self.mitres[last][1 - side].is_some() || next >= count {
                        break;
                    }
                    last = next;
                }
                for piece in &mut leans[k.min(last)..=k.max(last)] {
                    piece[side] = Some(Lean { by, corner: frame.length, reach });
                }
            }
        }
        Ok(leans)
    }

    /// At how many corners both sides end in the plane between them.
    pub(in crate::sweep) fn corners(&self) -> usize {
        self.mitres.iter().filter(|ends| ends[1].is_some()).count()
    }

    /// The corners' mitres, that which reaches furthest from the path first, of places of the profile at these arms.
    pub(in crate::sweep) fn mitres(&self, arms: &[Vector]) -> Result<Vec<Mitre>> {
        let tangent = self.first()?.tangent;
        let profile = arms.iter().map(|arm| arm.norm()).fold(0.0, f64::max);
        let mut mitres = Vec::new();
        for (k, ends) in self.mitres.iter().enumerate() {
            let (Some(across), Some(lean)) = (ends[1], self.leans[k][1]) else { continue };
            let reach = arms.iter().map(|arm| (arm + tangent * lean.by.dot(arm)).norm()).fold(0.0, f64::max);
            // Across is the sum of both tangents.
            let turn = 2.0 * (0.5 * across.norm()).min(1.0).acos();
            mitres.push(Mitre { at: self.pieces[k].domain().1, turn, reach, profile });
        }
        mitres.sort_by(|x, y| y.reach.total_cmp(&x.reach));
        Ok(mitres)
    }

    /// How far what leans is from the sweep of sections that do not, each place from the way of its own, which goes on straight beyond its ends: the
    /// largest distance at places of all pieces that are not straight.
    pub(in crate::sweep) fn leaned(&self, arms: &[Vector]) -> Result<f64> {
        let leans = |k: usize| !self.straight[k] && self.leans[k].iter().any(Option::is_some);
        if !(0..self.pieces.len()).any(leans) {
            return Ok(0.0);
        }
        let mut frames: Vec<Frame> = Vec::new();
        // Where a corner is between a frame and the one before it.
        let mut begins: Vec<usize> = Vec::new();
        self.each(true, |begin, end, inner| {
            let joins = frames
                .last()
                .is_some_and(|f: &Frame| f.piece == begin.piece || self.mitres[begin.piece][0].is_none());
            let run = if joins { begins.last().copied().unwrap_or(0) } else { frames.len() };
            for frame in [begin].into_iter().chain(inner).chain([end]) {
                frames.push(frame.clone());
                begins.push(run);
            }
            Ok(true)
        })?;
        let way =
            |frame: &Frame, arm: &Vector| (frame.point + frame.turn * arm, frame.speed + frame.turning * arm);
        let mut largest = 0.0_f64;
        for (i, frame) in frames.iter().enumerate().filter(|(_, f)| leans(f.piece)) {
            for arm in arms {
                let (ahead, _) = self.ahead(frame, arm);
                // What folds back by itself is said elsewhere.
                if ahead == 0.0 || way(frame, arm).1.dot(&frame.tangent) <= 0.0 {
                    continue;
                }
                let place = self.carried(frame, arm).0;
                let (mut k, mut found) = (i, None);
                loop {
                    let next = if ahead > 0.0 { k + 1 } else { k.wrapping_sub(1) };
                    if frames.get(next).is_none() || begins[next] != begins[i] {
                        break;
                    }
                    let (there, along) = way(&frames[next], arm);
                    if (place - there).dot(&along) * ahead <= 0.0 {
                        found = Some(next);
                        break;
                    }
                    k = next;
                }
                let distance = match found {
                    Some(next) => {
                        let (from, to) = (&frames[k.min(next)], &frames[k.max(next)]);
                        foot(&place, (way(from, arm), way(to, arm)), to.at - from.at)
                    }
                    None => {
                        let beyond = place - way(&frames[k], arm).0;
                        let tangent = frames[k].tangent;
                        (beyond - tangent * tangent.dot(&beyond)).norm()
                    }
                };
                largest = largest.max(distance);
            }
        }
        Ok(largest)
    }

    /// Whether it has corners, at which both sides end in the plane between them.
    pub(in crate::sweep) fn is_mitred(&self) -> bool {
        self.mitres.iter().flatten().any(Option::is_some)
    }

    /// Whether that is so where the path starts and ends.
    pub(in crate::sweep) fn is_mitred_at_start(&self) -> bool {
        self.mitres.first().is_some_and(|ends| ends[0].is_some())
    }
}

/// How far a place is from the cubic with these points and derivatives, by its parameter, over a width, where its foot lies on that.
fn foot(place: &Point, ((p, dp), (q, dq)): ((Point, Vector), (Point, Vector)), width: f64) -> f64 {
    let (c1, c2) = (p + dp * (width / 3.0), q - dq * (width / 3.0));
    let at = |x: f64| {
        let y = 1.0 - x;
        let point = p.coords * (y * y * y)
            + c1.coords * (3.0 * y * y * x)
            + c2.coords * (3.0 * y * x * x)
            + q.coords * (x * x * x);
        let along = (c1 - p) * (y * y) + (c2 - c1) * (2.0 * x * y) + (q - c2) * (x * x);
        (place.coords - point, along)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let (off, along) = at(middle);
        if off.dot(&along) > 0.0 { low = middle } else { high = middle }
    }
    at(0.5 * (low + high)).0.norm()
}
