//! Where surfaces turn away from the viewer.

use std::collections::HashMap;

use loftsman_kernel::Vector;

use crate::chain::linked;

/// Where a smooth surface turns away from the viewer: segments from side to side of triangles, along which the normal is
/// square to the view.
#[derive(Default)]
pub(super) struct Turns {
    /// The places on sides, by the numbers of their ends.
    sides: HashMap<(usize, usize), usize>,
    places: Vec<Vector>,
    /// How much nearer each of them is told to be than it is.
    raised: Vec<f64>,
    segments: Vec<(usize, usize)>,
}

impl Turns {
    pub(super) fn triangle(&mut self, corners: [usize; 3], facing: &[f64], places: &[Vector]) {
        let [a, b, c] = corners;
        let mut ends = [(a, b), (b, c), (c, a)].into_iter().filter(|(a, b)| {
            // Strictly on one side and not on it: a corner of zero belongs to the side away.
            (facing[*a] > 0.0) != (facing[*b] > 0.0)
        });
        if let (Some(from), Some(to)) = (ends.next(), ends.next()) {
            let segment = [from, to].map(|(a, b)| {
                let side = (a.min(b), a.max(b));
                *self.sides.entry(side).or_insert_with(|| {
                    let (a, b) = side;
                    let t = facing[a] / (facing[a] - facing[b]);
                    self.places.push(places[a] + (places[b] - places[a]) * t);
                    self.raised.push(0.0);
                    self.places.len() - 1
                })
            });
            // The facet stands for a piece that bends away here: nothing of itself hides its outline. Along the outline it does not
            // bend, however long it is and however much nearer its other end: only what it rises across counts.
            let line = segment.map(|place| self.places[place]);
            let rise = corners.map(|corner| above(line, &places[corner])).into_iter().fold(0.0, f64::max);
            for place in segment {
                self.raised[place] = self.raised[place].max(rise);
            }
            self.segments.push((segment[0], segment[1]));
        }
    }

    pub(super) fn chains(&self) -> Vec<Vec<Vector>> {
        let place = |i: usize| self.places[i] + Vector::z() * self.raised[i];
        linked(&self.segments).into_iter().map(|chain| chain.into_iter().map(place).collect()).collect()
    }
}

/// How much nearer to the viewer a place is than its foot on the line through two others; than the first of them where they are one.
fn above([from, to]: [Vector; 2], place: &Vector) -> f64 {
    let along = to - from;
    let square = along.norm_squared();
    let share = if square > 0.0 { (place - from).dot(&along) / square } else { 0.0 };
    place.z - (from.z + share * along.z)
}
