//! Parameters at arc lengths, many at once: one table of a curve's speed, made once, from which every length is read.
//!
//! On each piece the speed `|C'|` is a Legendre series `Σ c_k P_k(x)` through its values at 16 Gauss nodes, so that the
//! length up to a place is a series too: `∫₋₁ˣ P_k = (P_k+1(x) - P_k-1(x)) / (2k + 1)`. A piece whose last coefficients
//! are more than it may be wrong by is halved. The parameter at a length is found by Newton's method on the series of its
//! piece, within a bracket: no more looks at the curve.

use super::Curve;
use super::length::{DEPTH, HALVINGS, Length, Speeds, finite};
use crate::error::{Error, Result};
use crate::quadrature::gauss_legendre;

/// Nodes of a piece, and terms of its series.
const TERMS: usize = 16;

/// How long a curve is from its start up to every parameter; see [`Curve::arc_length`].
#[derive(Debug, Clone)]
pub struct ArcLength {
    pieces: Vec<Piece>,
    length: Length,
    /// A length below this is none: rounding of the control vertices.
    rounding: f64,
}

/// A piece of the domain.
#[derive(Debug, Clone)]
struct Piece {
    from: f64,
    to: f64,
    /// The length up to its start, and up to its end.
    before: f64,
    after: f64,
    /// The speed over `[-1, 1]`.
    speed: [f64; TERMS],
}

/// A piece that may have to be halved: where, the series of its speed, its length and what that may be wrong by.
struct Rough {
    from: f64,
    to: f64,
    speed: [f64; TERMS],
    length: f64,
    error: f64,
    /// What of the error no halving takes away, as parameters are rounded.
    noise: f64,
    /// Which span of the curve it is of.
    span: usize,
    depth: usize,
}

impl Curve {
    /// The table from which the lengths up to any parameter, and the parameters at any length, are read; to the relative
    /// `accuracy` of the whole. Made in `O(n p²)`, more where the curve has cusps; a look at it costs no look at the curve.
    ///
    /// ```
    /// use loftsman_kernel::{Point, Vector, spline::Curve};
    /// let circle = Curve::circle(Point::origin(), Vector::z(), 2.0)?;
    /// let table = circle.arc_length(1e-12)?;
    /// let u = table.parameter(1.0)?; // a length of 1 is half a radian
    /// assert!((circle.point(u)? - circle.point(0.0)?).norm() - 4.0 * 0.25_f64.sin() < 1e-11);
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When `accuracy` is not a number between 0 and 1, or the length is beyond what numbers can hold.
    pub fn arc_length(&self, accuracy: f64) -> Result<ArcLength> {
        if !(0.0..=1.0).contains(&accuracy) {
            return Err(Error::Invalid(format!(
                "an accuracy of {accuracy} is not between 0 and 1: try 1e-9"
            )));
        }
        if let Some((curve, unit)) = self.within_reach()? {
            let mut table = curve.arc_length(accuracy)?;
            let Length { value, error, reached } = table.length;
            table.rounding *= unit;
            table.length = finite(Length { value: value * unit, error: error * unit, reached })?;
            for piece in &mut table.pieces {
                piece.before *= unit;
                piece.after *= unit;
                piece.speed.iter_mut().for_each(|c| *c *= unit);
            }
            return Ok(table);
        }
        let rule = Rule::new();
        let flat = self.space().flat();
        let aim = accuracy.max(256.0 * f64::EPSILON);
        // Later pieces first, so that the list is worked off from its end.
        let speeds = Speeds::of(self)?;
        let spans = self.space().spans().enumerate();
        let mut todo: Vec<Rough> =
            spans.map(|(k, span)| rule.piece(&speeds, k, [flat[span], flat[span + 1]], 0)).collect();
        todo.reverse();
        let rough: f64 = todo.iter().map(|piece| piece.length).sum();
        // As for lengths: at a cusp the error shrinks only against the whole.
        let share = 0.01 * rough / todo.len().max(1) as f64;
        let mut halvings = HALVINGS * todo.len();
        let mut pieces = Vec::with_capacity(todo.len());
        let (mut total, mut errors) = (0.0, 0.0);
        while let Some(piece) = todo.pop() {
            let middle = 0.5 * piece.from + 0.5 * piece.to;
            let enough = (aim * (0.5 * piece.length).max(share)).max(piece.noise);
            let done = piece.error <= enough || piece.depth >= DEPTH || halvings == 0;
            if !done && piece.from < middle && middle < piece.to {
                halvings -= 1;
                todo.push(rule.piece(&speeds, piece.span, [middle, piece.to], piece.depth + 1));
                todo.push(rule.piece(&speeds, piece.span, [piece.from, middle], piece.depth + 1));
                continue;
            }
            let after = total + piece.length.max(0.0);
            let Rough { from, to, speed, .. } = piece;
            pieces.push(Piece { from, to, before: total, after, speed });
            total = after;
            errors += piece.error;
        }
        let error = errors + 32.0 * f64::EPSILON * total;
        let length = Length { value: total, error, reached: error <= accuracy * total || total == 0.0 };
        let largest = self.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let rounding = 16.0 * f64::EPSILON * largest;
        Ok(ArcLength { pieces, length: finite(length)?, rounding })
    }

    /// The parameters at which the curve, from its start, has the given lengths, in their order; to the relative
    /// `accuracy` of the whole length. `O(n p² + k log n)` for `k` lengths.
    ///
    /// # Errors
    /// As for [`arc_length`](Self::arc_length) and [`ArcLength::parameter`].
    pub fn parameters_at_lengths(&self, lengths: &[f64], accuracy: f64) -> Result<Vec<f64>> {
        let table = self.arc_length(accuracy)?;
        lengths.iter().map(|&length| table.parameter(length)).collect()
    }
}

impl ArcLength {
    /// The length of the whole curve; its error holds for every length that is read from the table.
    pub fn length(&self) -> Length {
        self.length
    }

    /// The parameter at which the curve, from its start, has this length; where it stands still, the first. A length
    /// beyond the whole by no more than its error gives the end. `O(log n)`.
    ///
    /// # Errors
    /// When the length is negative, not a number or more than the whole.
    pub fn parameter(&self, length: f64) -> Result<f64> {
        let (Some(first), Some(last)) = (self.pieces.first(), self.pieces.last()) else {
            return Err(Error::Invalid("a curve without spans has no lengths".into()));
        };
        let total = self.length.value;
        if length.is_nan() || length < 0.0 {
            return Err(Error::Invalid(format!("a length of {length} is not on the curve: give 0 or more")));
        }
        if length > total + self.length.error {
            return Err(Error::Invalid(format!(
                "a length of {length} is beyond the curve, which from {} to {} is {total} long",
                first.from, last.to
            )));
        }
        if length >= total {
            return Ok(if total == 0.0 { first.from } else { last.to });
        }
        let at = self.pieces.partition_point(|piece| piece.after < length);
        Ok(self.pieces.get(at).unwrap_or(last).parameter(length, total))
    }

    /// The length from the start up to a parameter.
    ///
    /// # Errors
    /// When `u` is outside the domain.
    pub fn up_to(&self, u: f64) -> Result<f64> {
        let (Some(first), Some(last)) = (self.pieces.first(), self.pieces.last()) else {
            return Err(Error::Invalid("a curve without spans has no lengths".into()));
        };
        if !(u >= first.from && u <= last.to) {
            return Err(Error::Outside { value: u, start: first.from, end: last.to });
        }
        let at = self.pieces.partition_point(|piece| piece.to < u);
        let piece = self.pieces.get(at).unwrap_or(last);
        let x = 2.0 * ((u - piece.from) / (piece.to - piece.from)) - 1.0;
        Ok((piece.before + piece.half() * evaluate(&piece.speed, x).1).clamp(piece.before, piece.after))
    }

    /// The parameters of `count` places from the start on, the same length apart: with the end as the last where
    /// `both_ends`, else (round a closed curve) with the end left out.
    ///
    /// # Errors
    /// When there are fewer than two, or the curve has no length.
    pub fn evenly(&self, count: usize, both_ends: bool) -> Result<Vec<f64>> {
        let steps = if both_ends { count.saturating_sub(1) } else { count };
        if count < 2 {
            return Err(Error::Invalid(format!(
                "{count} {} too few to be spread along a curve: ask for 2 at least",
                if count == 1 { "place is" } else { "places are" }
            )));
        }
        let Length { value, error, .. } = self.length;
        if value <= error.max(self.rounding) {
            return Err(Error::NoExtent("the curve has no length: nothing is spread along it".into()));
        }
        (0..count).map(|k| self.parameter(value * (k as f64 / steps as f64))).collect()
    }
}

impl Piece {
    fn half(&self) -> f64 {
        0.5 * (self.to - self.from)
    }

    fn parameter(&self, length: f64, total: f64) -> f64 {
        let wanted = length - self.before;
        let half = self.half();
        let (mut low, mut high) = (-1.0, 1.0);
        let whole = self.after - self.before;
        let mut x = if whole > 0.0 { 2.0 * (wanted / whole) - 1.0 } else { -1.0 };
        for _ in 0..200 {
            let (speed, sum) = evaluate(&self.speed, x);
            let off = half * sum - wanted;
            if off.abs() <= 2.0 * f64::EPSILON * total {
                break;
            }
            if off > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - off / (half * speed);
            // Where the speed vanishes the step is no number: halve instead.
            let next = if newton > low && newton < high { newton } else { 0.5 * low + 0.5 * high };
            if next == x {
                break;
            }
            x = next;
        }
        (0.5 * (1.0 - x) * self.from + 0.5 * (1.0 + x) * self.to).clamp(self.from, self.to)
    }
}

/// The value of a Legendre series at `x`, and its integral from -1 to `x`.
fn evaluate(series: &[f64; TERMS], x: f64) -> (f64, f64) {
    let (mut before, mut here) = (1.0, x);
    let (mut value, mut integral) = (series[0], series[0] * (x + 1.0));
    for (k, &c) in series.iter().enumerate().skip(1) {
        let next = ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64;
        value += c * here;
        integral += c * (next - before) / (2 * k + 1) as f64;
        (before, here) = (here, next);
    }
    (value, integral)
}

/// The nodes on `[-1, 1]`, and for each what it adds to every coefficient.
struct Rule {
    nodes: Vec<f64>,
    shares: Vec<[f64; TERMS]>,
}

impl Rule {
    fn new() -> Self {
        let (nodes, weights) = gauss_legendre(TERMS);
        let nodes: Vec<f64> = nodes.iter().map(|x| 2.0 * x - 1.0).collect();
        // A speed that stays the same has no error but rounding.
        let whole: f64 = weights.iter().sum();
        let shares = nodes.iter().zip(&weights).map(|(&x, &w)| {
            let w = w / whole;
            let mut share = [0.0; TERMS];
            let (mut before, mut here) = (0.0, 1.0);
            for (k, share) in share.iter_mut().enumerate() {
                // The weights are those of [0, 1]: half of those of [-1, 1].
                *share = (2 * k + 1) as f64 * w * here;
                let next = ((2 * k + 1) as f64 * x * here - k as f64 * before) / (k + 1) as f64;
                (before, here) = (here, next);
            }
            share
        });
        Self { shares: shares.collect(), nodes }
    }

    fn piece(&self, speeds: &Speeds<'_>, span: usize, [from, to]: [f64; 2], depth: usize) -> Rough {
        let (middle, half) = (0.5 * from + 0.5 * to, 0.5 * (to - from));
        let mut speed = [0.0; TERMS];
        for (x, share) in self.nodes.iter().zip(&self.shares) {
            // Parameters between knots are always inside the domain.
            let value = speeds.at(span, middle + half * x);
            speed.iter_mut().zip(share).for_each(|(c, s)| *c += value * s);
        }
        // What is left out is less than what the last terms add, each of which is `2/(2k + 1)` at most.
        let last = TERMS - 3;
        let error = half
            * speed
                .iter()
                .enumerate()
                .skip(last)
                .map(|(k, c)| 2.0 * c.abs() / (2 * k + 1) as f64)
                .sum::<f64>();
        let varies = speed.iter().skip(1).map(|c| c.abs()).sum::<f64>();
        let noise = f64::EPSILON * from.abs().max(to.abs()) * varies;
        Rough { from, to, speed, length: 2.0 * half * speed[0], error, noise, span, depth }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::any_curve;
    use super::*;
    use crate::spline::Space;
    use crate::{Point, Vector};

    proptest! {
        #[test]
        fn the_table_agrees_with_another_rule(curve in any_curve(), s in 0.0..=1.0_f64) {
            let table = curve.arc_length(1e-10).unwrap();
            let (length, other) = (table.length(), curve.length(1e-10).unwrap());
            prop_assert!((length.value - other.value).abs() <= length.error + other.error, "{length:?} {other:?}");
            let wanted = s * length.value;
            let u = table.parameter(wanted).unwrap();
            let found = curve.length_between(curve.domain().0, u, 1e-11).unwrap();
            let slack = length.error + found.error + 1e-13 * length.value;
            prop_assert!((found.value - wanted).abs() <= slack, "{} for {wanted}, {length:?}", found.value);
            prop_assert!((table.up_to(u).unwrap() - wanted).abs() <= 1e-13 * length.value);
        }

        #[test]
        fn many_at_once_are_those_one_by_one(curve in any_curve()) {
            let table = curve.arc_length(1e-9).unwrap();
            let at = table.evenly(7, true).unwrap();
            let lengths: Vec<f64> = (0..7).map(|k| table.length().value * (f64::from(k) / 6.0)).collect();
            prop_assert_eq!(&curve.parameters_at_lengths(&lengths, 1e-9).unwrap(), &at);
            prop_assert_eq!((at[0], at[6]), curve.domain());
            prop_assert!(at.windows(2).all(|pair| pair[0] < pair[1]), "{at:?}");
        }
    }

    /// A span so short that its parameters are rounded takes none of the halvings that others need.
    #[test]
    fn a_very_short_span_does_not_cost_the_others_theirs() {
        let points = [
            [0.001, 0.299, -0.274],
            [-0.891, -0.455, -0.992],
            [0.06, 1.34, -0.492],
            [-0.62, 0.49, 0.357],
            [0.105, -0.93, -0.029],
            [0.695, -1.344, -0.458],
            [-1.901, -1.29, -1.842],
            [-0.235, -1.267, 0.271],
        ];
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.4999999, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 1.0];
        let curve = Curve::new(Space::open(3, knots).unwrap(), points.map(Point::from).to_vec()).unwrap();
        let table = curve.arc_length(1e-12).unwrap();
        // The length by another rule on parts of it.
        let parts = (0..1000).map(|k| f64::from(k) / 1000.0);
        let sum: f64 =
            parts.map(|u| curve.length_between(u, (u + 1e-3).min(1.0), 1e-12).unwrap().value).sum();
        assert!((table.length().value - sum).abs() < 1e-8 * sum, "{:?} {sum}", table.length());
        assert!((table.up_to(table.parameter(0.5 * sum).unwrap()).unwrap() - 0.5 * sum).abs() < 1e-8);
    }

    #[test]
    fn circles_of_any_size_are_divided_evenly() {
        for radius in [1e-300, 1e-9, 1.0, 1e9, 1e300] {
            let circle = Curve::circle(Point::origin(), Vector::z(), radius).unwrap();
            let table = circle.arc_length(1e-13).unwrap();
            let at = table.evenly(12, false).unwrap();
            let first = circle.point(at[0]).unwrap().coords / radius;
            for (k, &u) in at.iter().enumerate() {
                let p = circle.point(u).unwrap().coords / radius;
                let angle = first.cross(&p).z.atan2(first.dot(&p));
                let wanted = (k as f64 / 12.0 + 0.5).fract() - 0.5;
                let off = angle / std::f64::consts::TAU - wanted;
                assert!((off - off.round()).abs() < 1e-13, "{k} of {radius}: {angle}");
            }
        }
    }

    #[test]
    fn cusps_and_standing_still() {
        // (t², t³) for t in [-1, 1]: the length up to t > 0 is known.
        let points = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
        let cusp = Curve::bezier(points.map(|(x, y)| Point::new(x, y, 0.0)).to_vec()).unwrap();
        let side = |t: f64| ((4.0 + 9.0 * t * t).powf(1.5) - 8.0) / 27.0;
        let table = cusp.arc_length(1e-12).unwrap();
        assert!((table.length().value - 2.0 * side(1.0)).abs() < 1e-11);
        for t in [0.1, 0.5, 0.9] {
            let u = table.parameter(side(1.0) + side(t)).unwrap();
            assert!((2.0 * u - 1.0 - t).abs() < 1e-10, "{u} for {t}");
        }
        // It rests between u = 1 and 2.
        let space = Space::clamped(1, &[0.0, 1.0, 2.0, 3.0]).unwrap();
        let points = [0.0, 1.0, 1.0, 2.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let rests = Curve::new(space, points).unwrap().arc_length(1e-12).unwrap();
        let at = rests.parameter(1.0).unwrap();
        assert!((1.0 - 1e-14..2.0 + 1e-14).contains(&at), "{at}");
        assert!((rests.parameter(1.5).unwrap() - 2.5).abs() < 1e-15);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let line = Curve::line(Point::origin(), Point::new(3.0, 4.0, 0.0)).unwrap();
        assert!(line.arc_length(f64::NAN).is_err() && line.arc_length(2.0).is_err());
        let table = line.arc_length(1e-9).unwrap();
        assert_eq!(table.parameter(5.0).unwrap(), 1.0);
        for wrong in [-1.0, 5.1, f64::NAN, f64::INFINITY] {
            assert!(table.parameter(wrong).is_err(), "{wrong}");
        }
        assert!(table.up_to(1.5).is_err() && table.evenly(1, true).is_err());
        let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap().arc_length(1e-9).unwrap();
        assert_eq!(point.parameter(0.0).unwrap(), 0.0);
        assert!(point.evenly(3, true).is_err());
    }
}
