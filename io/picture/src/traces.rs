//! Where lines have been drawn: what is drawn later and runs along them is left out.

use std::collections::HashSet;

use crate::path::Spot;

/// The size of a cell, in millimetres: what is in the same one as a line, or beside it, is on it.
const CELL: f64 = 0.12;
/// A segment has no more places than these.
const MOST: f64 = 4096.0;
/// What is left of a line between others, in millimetres, and is shorter is a speck.
const SPECK: f64 = 1.0;

/// The cells of the page that lines go through.
#[derive(Debug, Default)]
pub(crate) struct Traces(HashSet<[i32; 2]>);

impl Traces {
    /// Adds a line.
    pub(crate) fn add(&mut self, line: &[Spot]) {
        for pair in line.windows(2) {
            self.0.extend(places(pair[0], pair[1], 0.5 * CELL).map(cell));
        }
    }

    /// The parts of a line that are not on what was added.
    pub(crate) fn apart(&self, line: &[Spot]) -> Vec<Vec<Spot>> {
        if self.0.is_empty() {
            return vec![line.to_vec()];
        }
        let mut parts: Vec<Vec<Spot>> = Vec::new();
        let (mut part, mut last): (Vec<Spot>, Option<Spot>) = (Vec::new(), None);
        let mut close = |part: &mut Vec<Spot>, last: &mut Option<Spot>| {
            part.extend(last.take());
            let part = std::mem::take(part);
            let length: f64 = part.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
            if length >= SPECK {
                parts.push(part);
            }
        };
        for pair in line.windows(2) {
            for place in places(pair[0], pair[1], CELL) {
                if self.is_on(place) {
                    close(&mut part, &mut last);
                } else if part.is_empty() {
                    part.push(place);
                } else {
                    last = Some(place);
                }
            }
            // Its corners stay; what is between them is straight.
            part.extend(last.take());
        }
        close(&mut part, &mut last);
        parts
    }

    fn is_on(&self, place: Spot) -> bool {
        let [x, y] = cell(place);
        (-1..=1).any(|i| (-1..=1).any(|j| self.0.contains(&[x.saturating_add(i), y.saturating_add(j)])))
    }
}

fn cell(place: Spot) -> [i32; 2] {
    place.map(|c| (c / CELL).floor() as i32)
}

fn distance(a: Spot, b: Spot) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The ends of a segment, and places between them this far from one another.
fn places(from: Spot, to: Spot, step: f64) -> impl Iterator<Item = Spot> {
    let count = (distance(from, to) / step).ceil().clamp(1.0, MOST) as usize;
    (0..=count).map(move |k| {
        let share = k as f64 / count as f64;
        [0, 1].map(|c| from[c] + (to[c] - from[c]) * share)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_along_a_line_is_left_out_and_the_rest_kept() {
        let mut traces = Traces::default();
        assert_eq!(traces.apart(&[[0.0, 0.0], [5.0, 0.0]]), [[[0.0, 0.0], [5.0, 0.0]]]);
        traces.add(&[[0.0, 0.0], [10.0, 0.0], [10.0, 7.0]]);
        // The same, the other way round, in other pieces, and to a tenth of a line's width.
        let same = [[10.02, 7.0], [10.0, 3.0], [9.98, 0.03], [4.0, -0.03], [0.0, 0.0]];
        assert!(traces.apart(&same).is_empty());
        // Along it, away from it and back to it.
        let parts = traces.apart(&[[0.0, 0.0], [4.0, 0.0], [5.0, 2.0], [6.0, 0.0], [10.0, 0.0]]);
        let [part] = &parts[..] else { panic!("{parts:?}") };
        assert_eq!((part.len(), part[1]), (3, [5.0, 2.0]));
        assert!(part[0][1] > 0.0 && part[0][1] < 0.4 && part[2][1] < 0.4, "{part:?}");
        // One across it is cut where it crosses.
        let parts = traces.apart(&[[5.0, -3.0], [5.0, 3.0]]);
        assert_eq!(parts.len(), 2, "{parts:?}");
        // A wave that leaves it nowhere for long leaves no specks; one far away, of any length, is as it was.
        let wave: Vec<Spot> = (0..100).map(|k| [0.1 * f64::from(k), 0.3 * f64::from(k % 2)]).collect();
        assert!(traces.apart(&wave).iter().all(|part| part.len() > 1));
        let far = [[0.0, 50.0], [1e9, 51.0]];
        assert_eq!(traces.apart(&far), [far]);
    }
}
