//! Bézier curves in the parameter plane, cut where they cross lines.

use smallvec::SmallVec;

use crate::error::Result;
use crate::spline::trimmed::ParameterCurve;

/// Halvings on the way to a root.
const DEPTH: u32 = 48;
/// Steps to a root that is known to be one.
const STEPS: usize = 80;

/// Bézier points `(u w, v w, w)`.
pub(super) type Net = Vec<[f64; 3]>;

/// The pieces of a parameter curve, from its end to its start if `reversed`.
pub(super) fn pieces(curve: &ParameterCurve, reversed: bool) -> Result<Vec<Net>> {
    let (from, to) = curve.range();
    let mut all = Vec::new();
    for segment in curve.curve().between(from, to)?.bezier_segments()? {
        let weight = |k: usize| segment.weights().map_or(1.0, |w| w[k]);
        let net =
            segment.points().iter().enumerate().map(|(k, p)| [p.x * weight(k), p.y * weight(k), weight(k)]);
        let mut net: Net = net.collect();
        if reversed {
            net.reverse();
        }
        all.push(net);
    }
    if reversed {
        all.reverse();
    }
    Ok(all)
}

/// The places of its ends.
pub(super) fn ends(net: &Net) -> [[f64; 2]; 2] {
    let of = |p: &[f64; 3]| [p[0] / p[2], p[1] / p[2]];
    [of(&net[0]), of(&net[net.len() - 1])]
}

/// The range of a coordinate of its Bézier points, which is at least that of the curve.
pub(super) fn range(net: &Net, d: usize) -> [f64; 2] {
    let all = net.iter().map(|p| p[d] / p[2]);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    [low, high]
}

pub(super) fn shifted(net: &Net, by: [f64; 2]) -> Net {
    if by == [0.0; 2] {
        return net.clone();
    }
    net.iter().map(|p| [p[0] + by[0] * p[2], p[1] + by[1] * p[2], p[2]]).collect()
}

/// A curve in two.
fn halves(net: &[[f64; 3]], t: f64) -> [Net; 2] {
    let mut rest = net.to_vec();
    let mut first = Vec::with_capacity(net.len());
    let mut second = vec![[0.0; 3]; net.len()];
    for k in (0..net.len()).rev() {
        first.push(rest[0]);
        second[k] = rest[k];
        for i in 0..k {
            rest[i] = [0, 1, 2].map(|d: usize| rest[i][d] + (rest[i + 1][d] - rest[i][d]) * t);
        }
    }
    [first, second]
}

/// A curve cut at the lines of a direction that it crosses.
pub(super) fn cut(net: Net, d: usize, lines: impl Iterator<Item = f64>) -> Vec<Net> {
    let mut places: Vec<f64> = Vec::new();
    for line in lines {
        let values: SmallVec<[f64; 8]> = net.iter().map(|p| p[d] - line * p[2]).collect();
        roots(&values, &mut places);
    }
    places.retain(|t| *t > 0.0 && *t < 1.0);
    places.sort_unstable_by(f64::total_cmp);
    places.dedup();
    let mut all = Vec::with_capacity(places.len() + 1);
    let mut rest = net;
    let mut from = 0.0;
    for t in places {
        let share = (t - from) / (1.0 - from);
        if !(share > 0.0 && share < 1.0) {
            continue;
        }
        let [first, second] = halves(&rest, share);
        all.push(first);
        rest = second;
        from = t;
    }
    all.push(rest);
    all
}

/// Where a polynomial in Bernstein's form changes its sign.
fn roots(values: &[f64], out: &mut Vec<f64>) {
    let mut open: Vec<(u32, f64, f64, SmallVec<[f64; 8]>)> =
        vec![(0, 0.0, 1.0, SmallVec::from_slice(values))];
    while let Some((depth, a, b, own)) = open.pop() {
        let changes = own.windows(2).filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0)).count();
        if changes == 0 {
            continue;
        }
        if changes == 1 {
            out.push(root(&own, a, b));
            continue;
        }
        if depth >= DEPTH {
            out.push(0.5 * (a + b));
            continue;
        }
        let (mut rest, mut first) = (own.clone(), SmallVec::<[f64; 8]>::new());
        let mut second: SmallVec<[f64; 8]> = own.clone();
        for k in (0..own.len()).rev() {
            first.push(rest[0]);
            second[k] = rest[k];
            for i in 0..k {
                rest[i] = 0.5 * (rest[i] + rest[i + 1]);
            }
        }
        let middle = 0.5 * (a + b);
        open.push((depth + 1, middle, b, second));
        open.push((depth + 1, a, middle, first));
    }
}

/// The one root of a polynomial whose Bernstein coefficients change their sign once: Illinois' rule, and halving.
fn root(values: &[f64], a: f64, b: f64) -> f64 {
    let value = |t: f64| {
        let mut rest: SmallVec<[f64; 8]> = SmallVec::from_slice(values);
        for k in (1..values.len()).rev() {
            for i in 0..k {
                rest[i] += (rest[i + 1] - rest[i]) * t;
            }
        }
        rest[0]
    };
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    let (mut at_low, mut at_high) = (values[0], values[values.len() - 1]);
    let negative = at_low < 0.0;
    let mut best = (f64::INFINITY, 0.5);
    for step in 0..STEPS {
        if high - low <= f64::EPSILON {
            break;
        }
        let mut t = low - at_low * (high - low) / (at_high - at_low);
        if step % 4 == 3 || !(t > low && t < high) {
            t = 0.5 * (low + high);
        }
        let found = value(t);
        if found.abs() <= best.0 {
            best = (found.abs(), t);
        }
        if found == 0.0 {
            break;
        }
        if (found < 0.0) == negative {
            (low, at_low) = (t, found);
            at_high *= 0.5;
        } else {
            (high, at_high) = (t, found);
            at_low *= 0.5;
        }
    }
    a + (b - a) * best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_where_they_cross() {
        // u = t, v = (2t - 1)(4t - 1)(4t - 3) + 1/8, as a cubic.
        let net = vec![
            [0.0, -2.875, 1.0],
            [1.0 / 3.0, 4.458_333_333_333_333, 1.0],
            [2.0 / 3.0, -4.208_333_333_333_333, 1.0],
            [1.0, 3.125, 1.0],
        ];
        let parts = cut(net.clone(), 1, [0.125].into_iter());
        let joints: Vec<f64> = parts.iter().skip(1).map(|part| ends(part)[0][0]).collect();
        assert_eq!(joints.len(), 3, "{joints:?}");
        for (joint, expected) in joints.iter().zip([0.25, 0.5, 0.75]) {
            assert!((joint - expected).abs() < 1e-14);
        }
        let whole = [ends(&net)[0], ends(&net)[1]];
        assert_eq!([ends(&parts[0])[0], ends(&parts[3])[1]], whole);
        assert_eq!(cut(net, 0, [-1.0, 2.0].into_iter()).len(), 1);
        // Touching is no crossing.
        let arc = vec![[0.0, 1.0, 1.0], [0.5, 0.0, 1.0], [1.0, 1.0, 1.0]];
        assert!(cut(arc.clone(), 1, [0.5 - 1e-12].into_iter()).len() == 1);
        assert!(cut(arc, 1, [0.5 + 1e-12].into_iter()).len() == 3);
    }
}
