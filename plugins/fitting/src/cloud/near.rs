//! The nearest of many points.

use loftsman_kernel::{Point, Vector};

/// Points in a leaf.
const LEAF: usize = 8;

/// Points in a tree of halves (Bentley 1975): those below the middle one along the longest side of their box, and those above. Cost: `n log² n`, of a nearest
/// point some `log n`.
pub(super) struct Near {
    points: Vec<Vector>,
    /// The direction in which each part is cut, in the order in which the parts are come to: the first half follows.
    cuts: Vec<u8>,
}

impl Near {
    pub(super) fn new(points: &[Point]) -> Self {
        let mut points: Vec<Vector> = points.iter().map(|p| p.coords).collect();
        let mut cuts = vec![0; points.len()];
        halve(&mut points, &mut cuts);
        Self { points, cuts }
    }

    /// The distance of a place from the nearest point, infinite where there is none.
    pub(super) fn distance(&self, place: &Vector) -> f64 {
        let mut least = f64::INFINITY;
        visit(&self.points, &self.cuts, place, &mut least);
        least.sqrt()
    }
}

/// The middle point is where it would be in order; its place in `cuts` says the direction.
fn halve(points: &mut [Vector], cuts: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let start = (points[0], points[0]);
    let (low, high) = points.iter().fold(start, |(a, b), p| (a.inf(p), b.sup(p)));
    let (axis, middle) = ((high - low).imax(), points.len() / 2);
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    cuts[middle] = axis as u8;
    let (below, above) = points.split_at_mut(middle);
    let (cuts_below, cuts_above) = cuts.split_at_mut(middle);
    halve(below, cuts_below);
    halve(&mut above[1..], &mut cuts_above[1..]);
}

fn visit(points: &[Vector], cuts: &[u8], place: &Vector, least: &mut f64) {
    if points.len() <= LEAF {
        points.iter().for_each(|p| *least = least.min((p - place).norm_squared()));
        return;
    }
    let middle = points.len() / 2;
    let (axis, here) = (usize::from(cuts[middle]), points[middle]);
    *least = least.min((here - place).norm_squared());
    let away = place[axis] - here[axis];
    let below = (&points[..middle], &cuts[..middle]);
    let above = (&points[middle + 1..], &cuts[middle + 1..]);
    let (first, then) = if away < 0.0 { (below, above) } else { (above, below) };
    visit(first.0, first.1, place, least);
    if away * away < *least {
        visit(then.0, then.1, place, least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_all_is_found() {
        let number = |k: usize| ((k * 7919 + 13) % 10_007) as f64 / 5_000.0 - 1.0;
        for count in [0, 1, 7, 8, 9, 40, 1000] {
            // Every third one twice, and all in one plane for the half of them.
            let point = |k: usize| {
                Point::new(
                    number(3 * (k - k % 3 % 2)),
                    number(5 * k + 1),
                    if count > 9 { 0.5 } else { number(k) },
                )
            };
            let points: Vec<Point> = (0..count).map(point).collect();
            let near = Near::new(&points);
            for k in 0..200 {
                let place = Vector::new(number(11 * k), number(13 * k + 5), number(17 * k + 2)) * 2.0;
                let all = points.iter().map(|p| (p.coords - place).norm()).fold(f64::INFINITY, f64::min);
                let found = near.distance(&place);
                assert!(found == all || (found - all).abs() <= 1e-15 * all, "{count}: {found} {all}");
            }
        }
    }
}
