//! Segments that hang together, as chains; where surfaces turn away.

use std::collections::HashMap;

use loftsman_kernel::Vector;

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

/// Segments between numbered places as chains, as long as they go; each segment once. Linear but for a sort.
pub(super) fn linked(segments: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut ends: Vec<(usize, usize)> =
        segments.iter().enumerate().flat_map(|(i, (a, b))| [(*a, i), (*b, i)]).collect();
    ends.sort_unstable();
    let first = |place: usize| ends.partition_point(|(p, _)| *p < place);
    let mut used = vec![false; segments.len()];
    // Where the next unused segment of a place is looked for: what is before is used.
    let mut next: HashMap<usize, usize> = HashMap::new();
    let mut chains = Vec::new();
    let mut walk = |start: usize, used: &mut Vec<bool>| {
        let mut chain = vec![start];
        let mut place = start;
        loop {
            let at = next.entry(place).or_insert_with(|| first(place));
            while ends.get(*at).is_some_and(|(p, i)| *p == place && used[*i]) {
                *at += 1;
            }
            match ends.get(*at) {
                Some(&(p, i)) if p == place => {
                    used[i] = true;
                    let (a, b) = segments[i];
                    place = if a == place { b } else { a };
                    chain.push(place);
                }
                _ => return chain,
            }
        }
    };
    // From the places where an odd number of segments end, so that chains begin at their ends; then what is left are loops.
    let mut at = 0;
    let mut odd = Vec::new();
    while at < ends.len() {
        let place = ends[at].0;
        let count = ends[at..].iter().take_while(|(p, _)| *p == place).count();
        if count % 2 == 1 {
            odd.push(place);
        }
        at += count;
    }
    for start in odd.into_iter().chain(segments.iter().map(|(a, _)| *a)) {
        let chain = walk(start, &mut used);
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_have_every_segment_once() {
        // A square with a tail, and a loop of its own.
        let segments = [(0, 1), (1, 2), (2, 3), (3, 0), (3, 4), (7, 8), (8, 9), (9, 7)];
        let chains = linked(&segments);
        let mut found: Vec<(usize, usize)> =
            chains.iter().flat_map(|c| c.windows(2)).map(|s| (s[0].min(s[1]), s[0].max(s[1]))).collect();
        found.sort_unstable();
        let mut expected = segments.map(|(a, b)| (a.min(b), a.max(b)));
        expected.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(chains.len(), 2);
        assert_eq!(linked(&[]), Vec::<Vec<usize>>::new());
    }
}
