//! Path data of the page, and chains of short segments thinned out to what can be seen.

use crate::svg::length;

/// A point of the page in millimetres, x to the right and y *down*.
pub(crate) type Spot = [f64; 2];

/// How far a thinned chain may be from the full one: a fiftieth of the thinnest line.
const THIN: f64 = 0.004;

/// Path data under construction. Runs of straight segments are thinned out: points that leave the line within
/// `THIN` of where it was are not written, so a million vertices take no more room than can be seen.
#[derive(Debug, Default)]
pub(crate) struct Path {
    data: String,
    run: Option<Run>,
}

/// A straight segment that still grows: from `start`, every direction in `cone` passes all points so far.
#[derive(Debug)]
struct Run {
    start: Spot,
    last: Spot,
    /// Directions (as angles about the first one) that pass within `THIN` of every point of the run.
    cone: Option<(f64, f64, f64)>,
    /// The furthest from the start that the run has been: it may not turn back.
    reach: f64,
}

impl Path {
    /// Starts a new piece.
    pub(crate) fn move_to(&mut self, at: Spot) {
        self.flush();
        self.command('M', &[at]);
        self.run = Some(Run { start: at, last: at, cone: None, reach: 0.0 });
    }

    /// A straight segment.
    pub(crate) fn line_to(&mut self, to: Spot) {
        let Some(run) = &mut self.run else { return self.move_to(to) };
        if run.takes(to) {
            run.last = to;
            return;
        }
        let from = run.last;
        self.command('L', &[from]);
        let mut run = Run { start: from, last: from, cone: None, reach: 0.0 };
        if run.takes(to) {
            run.last = to;
        }
        self.run = Some(run);
    }

    /// A cubic Bézier piece from where the path is.
    pub(crate) fn cubic_to(&mut self, a: Spot, b: Spot, to: Spot) {
        self.flush();
        self.command('C', &[a, b, to]);
        self.run = Some(Run { start: to, last: to, cone: None, reach: 0.0 });
    }

    /// Joins the end of the piece to its start.
    pub(crate) fn close(&mut self) {
        self.flush();
        self.data.push('Z');
    }

    /// Where the path is.
    pub(crate) fn pen(&self) -> Option<Spot> {
        self.run.as_ref().map(|run| run.last)
    }

    /// The data of the `d` attribute.
    pub(crate) fn finish(mut self) -> String {
        self.flush();
        self.data
    }

    fn flush(&mut self) {
        if let Some(run) = self.run.take()
            && run.last != run.start
        {
            self.command('L', &[run.last]);
        }
    }

    fn command(&mut self, letter: char, spots: &[Spot]) {
        self.data.push(letter);
        for (i, [x, y]) in spots.iter().enumerate() {
            if i > 0 {
                self.data.push(' ');
            }
            self.data.push_str(&length(*x));
            self.data.push(' ');
            self.data.push_str(&length(*y));
        }
    }
}

impl Run {
    /// Whether the run can end at `to` instead; narrows the cone if so.
    fn takes(&mut self, to: Spot) -> bool {
        let [dx, dy] = [to[0] - self.start[0], to[1] - self.start[1]];
        let distance = dx.hypot(dy);
        if distance <= THIN {
            // So near the start that any direction does, unless the run has been further out.
            return self.reach <= THIN;
        }
        let half = (THIN / distance).asin();
        let angle = dy.atan2(dx);
        match self.cone {
            None => self.cone = Some((angle, -half, half)),
            Some((middle, low, high)) => {
                let turn = (angle - middle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI;
                if turn < low || turn > high || distance < self.reach - THIN {
                    return false;
                }
                self.cone = Some((middle, low.max(turn - half), high.min(turn + half)));
            }
        }
        self.reach = self.reach.max(distance);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_chains_become_one_segment() {
        let mut path = Path::default();
        for i in 0..=10_000 {
            path.line_to([f64::from(i) * 0.01, 5.0]);
        }
        assert_eq!(path.finish(), "M0 5L100 5");
    }

    #[test]
    fn thinned_chains_stay_near_the_full_one() {
        let full: Vec<Spot> = (0..=20_000)
            .map(|i| f64::from(i) / 20_000.0 * std::f64::consts::TAU)
            .map(|a| [50.0 + 40.0 * a.cos(), 50.0 + 40.0 * a.sin()])
            .collect();
        let mut path = Path::default();
        full.iter().for_each(|&spot| path.line_to(spot));
        let data = path.finish();
        let kept: Vec<Spot> = data
            .split(['M', 'L'])
            .filter(|part| !part.is_empty())
            .map(|part| part.split(' ').map(|n| n.parse().unwrap()).collect::<Vec<f64>>())
            .map(|xy| [xy[0], xy[1]])
            .collect();
        assert!(kept.len() < 400, "{}", kept.len());
        for pair in kept.windows(2) {
            let middle = [(pair[0][0] + pair[1][0]) / 2.0 - 50.0, (pair[0][1] + pair[1][1]) / 2.0 - 50.0];
            assert!((middle[0].hypot(middle[1]) - 40.0).abs() < 2.0 * THIN);
        }
    }

    #[test]
    fn a_path_that_turns_back_keeps_its_tip() {
        let mut path = Path::default();
        for x in [0.0, 1.0, 2.0, 1.0, 0.0] {
            path.line_to([x, 0.0]);
        }
        assert_eq!(path.finish(), "M0 0L2 0L0 0");
    }
}
