//! Arc length: of a curve or a part of it, and the parameter at a given length.

use super::Curve;
use crate::error::{Error, Result};
use crate::quadrature::binomial;

/// A length with what is known about its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// The length.
    pub value: f64,
    /// An estimate of its absolute error, from above in all but contrived cases.
    pub error: f64,
    /// Whether the error is within the accuracy that was asked for.
    pub reached: bool,
}

/// A length that is a number.
pub(super) fn finite(length: Length) -> Result<Length> {
    if length.value.is_finite() {
        return Ok(length);
    }
    Err(Error::Invalid(
        "the length is beyond what numbers can hold: scale the curve down, or make its weights alike".into(),
    ))
}

/// Halvings of a span after which an interval is taken as it is, its error estimate counted.
pub(super) const DEPTH: usize = 48;
/// Halvings allowed in all, for each span.
pub(super) const HALVINGS: usize = 500;
/// Beyond this degree a piece is evaluated from its Bézier vertices, in `O(p)` where de Boor's steps take `O(p²)`.
const LOW: usize = 7;
/// What is left by rules that differ by no more than this part of an interval's length, and whose difference a halving does not bring down, is rounding.
const NOISE: f64 = 1e-9;
/// A halving brings a difference down to less than this part of it, at a cusp, too, where it is a quarter.
const SHRINKS: f64 = 0.5;

impl Curve {
    /// The length of the whole curve; see [`length_between`](Self::length_between).
    ///
    /// # Errors
    /// When `accuracy` is not a number between 0 and 1.
    pub fn length(&self, accuracy: f64) -> Result<Length> {
        let (a, b) = self.domain();
        self.length_between(a, b, accuracy)
    }

    /// The length `∫ |C'| du` from `a` to `b` (negative where `b < a`), to the relative `accuracy`.
    ///
    /// Gauss–Kronrod rules of 7 and 15 points on every span (the integrand is smooth inside), halved where the two
    /// disagree. At a cusp the halves shrink towards it. `accuracy` below 1e-14 asks for more than rounding allows;
    /// the answer's [`reached`](Length::reached) then tells. A knot where the curve is torn adds no length.
    ///
    /// # Errors
    /// When `accuracy` is not a number between 0 and 1, `a` or `b` is outside the domain (also of a periodic
    /// curve: cut the way at its seam), or the length is beyond what numbers can hold.
    pub fn length_between(&self, a: f64, b: f64, accuracy: f64) -> Result<Length> {
        if !(0.0..=1.0).contains(&accuracy) {
            return Err(Error::Invalid(format!(
                "an accuracy of {accuracy} is not between 0 and 1: try 1e-9"
            )));
        }
        if b < a {
            let Length { value, error, reached } = self.length_between(b, a, accuracy)?;
            return Ok(Length { value: -value, error, reached });
        }
        let (start, end) = self.domain();
        for value in [a, b] {
            if !(value >= start && value <= end) {
                return Err(Error::Outside { value, start, end });
            }
        }
        if let Some((curve, unit)) = self.within_reach()? {
            let Length { value, error, reached } = curve.length_between(a, b, accuracy)?;
            return finite(Length { value: value * unit, error: error * unit, reached });
        }
        let flat = self.space().flat();
        // Below this the two rules differ by rounding, which halving does not reduce.
        let aim = accuracy.max(256.0 * f64::EPSILON);
        let mut todo = Vec::new();
        let mut rough = 0.0;
        let speeds = Speeds::of(self)?;
        for (piece, span) in self.space().spans().enumerate() {
            let (low, high) = (flat[span].max(a), flat[span + 1].min(b));
            if low < high {
                let (value, error) = speeds.kronrod(piece, low, high);
                rough += value;
                todo.push(Part { piece, low, high, value, error, depth: 0 });
            }
        }
        // A cusp leaves one small interval a halving whose error does not shrink against its own length, only
        // against the whole: such an interval is done when a hundredth of its share of the whole is left.
        let share = 0.01 * rough / todo.len().max(1) as f64;
        // Where rounding is larger still (a small curve far from the origin), the number of halvings ends it.
        let mut halvings = HALVINGS * todo.len();
        let (mut total, mut errors) = (0.0, 0.0);
        while let Some(Part { piece, low, high, value, error, depth }) = todo.pop() {
            let middle = 0.5 * low + 0.5 * high;
            let done = error <= aim * (0.5 * value).max(share) || depth >= DEPTH || halvings == 0;
            if done || !(low < middle && middle < high) {
                total += value;
                errors += error;
                continue;
            }
            halvings -= 1;
            let halves = [(middle, high), (low, middle)].map(|(low, high)| {
                let (value, error) = speeds.kronrod(piece, low, high);
                Part { piece, low, high, value, error, depth: depth + 1 }
            });
            let left: f64 = halves.iter().map(|half| half.error).sum();
            if error <= NOISE * value && left >= SHRINKS * error {
                // Weights or knots far from one another leave more rounding than is asked for: it is counted, and not halved further.
                total += halves.iter().map(|half| half.value).sum::<f64>();
                errors += left;
                continue;
            }
            todo.extend(halves);
        }
        let error = errors + 4.0 * f64::EPSILON * total;
        finite(Length { value: total, error, reached: error <= accuracy * total || total == 0.0 })
    }

    /// The curve in units in which no square overflows or vanishes, and that unit; none where it is so already. A common
    /// factor on all weights changes nothing. Powers of two, so that nothing is rounded.
    pub(super) fn within_reach(&self) -> Result<Option<(Self, f64)>> {
        let largest = self.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
        let weight = self.weights().map_or(1.0, |w| w.iter().copied().fold(0.0, f64::max));
        let unit = match largest {
            x if x > 1e140 => 2_f64.powi(600),
            x if x > 0.0 && x < 1e-140 => 2_f64.powi(-600),
            _ => 1.0,
        };
        if unit == 1.0 && (1e-100..1e100).contains(&weight) {
            return Ok(None);
        }
        let points = self.points().iter().map(|p| p / unit).collect();
        let weights = self.weights().map(|w| w.iter().map(|w| w / weight).collect());
        Ok(Some((Self::build(self.space().clone(), points, weights)?, unit)))
    }

    /// The parameter at which the curve, from its start, has the given length: Newton's method on the length, kept
    /// within a bracket. A length beyond the whole by less than `accuracy` gives the end. For many lengths, see
    /// [`parameters_at_lengths`](Self::parameters_at_lengths).
    ///
    /// # Errors
    /// When the length is negative or more than the whole, or `accuracy` is not between 0 and 1.
    pub fn parameter_at_length(&self, length: f64, accuracy: f64) -> Result<f64> {
        let flat = self.space().flat();
        let (start, end) = self.domain();
        let mut before = 0.0;
        if length.is_nan() || length < 0.0 {
            return Err(Error::Invalid(format!("a length of {length} is not on the curve: give 0 or more")));
        }
        for span in self.space().spans() {
            let (a, b) = (flat[span], flat[span + 1]);
            let here = self.length_between(a, b, accuracy)?.value;
            if before + here < length {
                before += here;
                continue;
            }
            let wanted = length - before;
            let (mut low, mut high) = (a, b);
            let (mut u, mut at) = (a, 0.0);
            for _ in 0..200 {
                if (at - wanted).abs() <= accuracy * here || low >= high {
                    break;
                }
                if at < wanted {
                    low = u;
                } else {
                    high = u;
                }
                let newton = u + (wanted - at) / self.derivative(u, 1)?.norm();
                // Where C' vanishes the step is infinite or not a number: halve instead.
                let next = if newton > low && newton < high { newton } else { 0.5 * low + 0.5 * high };
                at += self.length_between(u, next, accuracy)?.value;
                if next == u {
                    break;
                }
                u = next;
            }
            return Ok(u);
        }
        if length <= before * (1.0 + accuracy.max(4.0 * f64::EPSILON)) {
            return Ok(end);
        }
        Err(Error::Invalid(format!(
            "a length of {length} is beyond the curve, which from {start} to {end} is {before} long"
        )))
    }
}

/// A part of a span that may have to be halved: the length by 15 points and its difference from that by 7.
struct Part {
    piece: usize,
    low: f64,
    high: f64,
    value: f64,
    error: f64,
    depth: usize,
}

/// The speed of a curve, span by span.
pub(super) struct Speeds<'a> {
    curve: &'a Curve,
    /// Of a high degree the pieces, in Bézier form.
    pieces: Vec<Bezier>,
}

/// A polynomial or rational piece over its part of the domain: homogeneous vertices times binomial coefficients, and those of the derivative.
struct Bezier {
    from: f64,
    length: f64,
    vertices: Vec<[f64; 4]>,
    along: Vec<[f64; 4]>,
}

impl<'a> Speeds<'a> {
    pub(super) fn of(curve: &'a Curve) -> Result<Self> {
        let mut pieces = Vec::new();
        if curve.degree() > LOW {
            for segment in curve.bezier_segments()? {
                let (from, to) = segment.domain();
                pieces.push(Bezier::new(&segment, from, to - from));
            }
            // One for each span, or none.
            if pieces.len() != curve.space().spans().count() {
                pieces.clear();
            }
        }
        Ok(Self { curve, pieces })
    }

    /// `|C'|` at a parameter of a span, which is inside the domain.
    pub(super) fn at(&self, piece: usize, u: f64) -> f64 {
        match self.pieces.get(piece) {
            Some(piece) => piece.speed(u),
            None => self.curve.derivative(u, 1).map_or(0.0, |d| d.norm()),
        }
    }

    /// The integral of `|C'|` by 15 points and its difference from that by 7 of them.
    fn kronrod(&self, piece: usize, a: f64, b: f64) -> (f64, f64) {
        let (middle, half) = (0.5 * a + 0.5 * b, 0.5 * (b - a));
        let speed = |x: f64| self.at(piece, middle + half * x);
        let centre = speed(0.0);
        let (mut fine, mut coarse) = (FINE[7] * centre, COARSE[3] * centre);
        for i in 0..7 {
            let both = speed(NODES[i]) + speed(-NODES[i]);
            fine += FINE[i] * both;
            if i % 2 == 1 {
                coarse += COARSE[i / 2] * both;
            }
        }
        (fine * half, (fine - coarse).abs() * half)
    }
}

impl Bezier {
    fn new(segment: &Curve, from: f64, length: f64) -> Self {
        let p = segment.degree();
        // About the first vertex: nothing of where the curve is is left in the derivative.
        let origin = segment.points().first().copied().unwrap_or_default();
        let weight = |k: usize| segment.weights().map_or(1.0, |w| w[k]);
        let home = |(k, q): (usize, &crate::Point)| {
            let d = (q - origin) * weight(k);
            [d.x, d.y, d.z, weight(k)]
        };
        let net: Vec<[f64; 4]> = segment.points().iter().enumerate().map(home).collect();
        let times = |p: usize, c: [f64; 4], k: usize| c.map(|x| x * binomial(p, k));
        let along = net.windows(2).enumerate().map(|(k, w)| {
            let d = [0, 1, 2, 3].map(|a| (w[1][a] - w[0][a]) * p as f64 / length);
            times(p - 1, d, k)
        });
        let along = along.collect();
        let vertices = net.iter().enumerate().map(|(k, c)| times(p, *c, k)).collect();
        Self { from, length, vertices, along }
    }

    fn speed(&self, u: f64) -> f64 {
        let t = ((u - self.from) / self.length).clamp(0.0, 1.0);
        let (point, along) = (summed(&self.vertices, t), summed(&self.along, t));
        let w = point[3];
        let d = [0, 1, 2].map(|a| (along[a] - point[a] / w * along[3]) / w);
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
    }
}

/// `Σ c_k t^k (1-t)^(n-k)`, the coefficients with their binomials: by Horner's rule in the ratio of the smaller of `t` and `1-t` to the larger, all of whose
/// terms have the signs of the coefficients (Schumaker and Volk 1986).
fn summed(coefficients: &[[f64; 4]], t: f64) -> [f64; 4] {
    let n = coefficients.len().saturating_sub(1) as i32;
    let s = 1.0 - t;
    let (ratio, power, late) = if t <= 0.5 { (t / s, s.powi(n), true) } else { (s / t, t.powi(n), false) };
    let mut sum = [0.0; 4];
    let mut add = |c: &[f64; 4]| sum.iter_mut().zip(c).for_each(|(sum, c)| *sum = *sum * ratio + c);
    if late {
        coefficients.iter().rev().for_each(&mut add);
    } else {
        coefficients.iter().for_each(&mut add);
    }
    sum.map(|x| x * power)
}

/// Nodes and weights of the Gauss–Kronrod pair of 7 and 15 points (Kronrod 1965; every second node is Gauss's).
const NODES: [f64; 7] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
];
const FINE: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_83,
];
const COARSE: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::spline::Space;

    /// A quarter circle, so large.
    fn arc(radius: f64) -> Curve {
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let points =
            [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Point::new(x * radius, y * radius, 0.0));
        Curve::rational(space, points.to_vec(), vec![1.0, 0.5_f64.sqrt(), 1.0]).unwrap()
    }

    #[test]
    fn a_quarter_circle_of_any_size() {
        for radius in [1e-9, 1.0, 1e9] {
            let length = arc(radius).length(1e-12).unwrap();
            let exact = radius * std::f64::consts::FRAC_PI_2;
            assert!(length.reached && (length.value - exact).abs() <= 1e-13 * exact);
            let u = arc(radius).parameter_at_length(0.3 * radius, 1e-13).unwrap();
            let point = arc(radius).point(u).unwrap();
            assert!((point.y.atan2(point.x) - 0.3).abs() < 1e-12);
        }
    }

    #[test]
    fn sizes_whose_squares_overflow_or_vanish() {
        for (radius, weight) in [(1e-300, 1.0), (1e-160, 1e-200), (1e160, 1e200), (1e300, 1e307)] {
            let (space, points, weights) = arc(radius).into_parts();
            let weights = weights.map(|w| w.iter().map(|w| w * weight).collect());
            let length = Curve::build(space, points, weights).unwrap().length(1e-10).unwrap();
            let exact = radius * std::f64::consts::FRAC_PI_2;
            assert!((length.value - exact).abs() <= 1e-12 * exact, "{radius}: {length:?}");
        }
        let far = [-1.7e308, 1.7e308].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let error = Curve::bezier(far).unwrap().length(1e-10).unwrap_err().to_string();
        assert!(error.contains("beyond what numbers can hold"), "{error}");
    }

    #[test]
    fn a_cusp_is_no_obstacle() {
        // (t², t³) for t in [-1, 1]: (13^(3/2) - 8) / 27 on either side.
        let points = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
        let curve = Curve::bezier(points.map(|(x, y)| Point::new(x, y, 0.0)).to_vec()).unwrap();
        let exact = (13.0_f64.powf(1.5) - 8.0) / 27.0;
        for (a, b, part) in [(0.0, 1.0, 2.0), (0.0, 0.5, 1.0)] {
            let length = curve.length_between(a, b, 1e-10).unwrap();
            assert!(length.reached && (length.value - part * exact).abs() <= 1e-10 * part * exact);
            assert!((length.value - part * exact).abs() <= length.error, "{length:?}");
        }
        // An odd place of the cusp within the interval: found by halving.
        let length = curve.length_between(0.123, 0.987, 1e-9).unwrap();
        let side = |t: f64| ((4.0 + 9.0 * t * t).powf(1.5) - 8.0) / 27.0;
        let exact = side(2.0 * 0.987 - 1.0) + side(1.0 - 2.0 * 0.123);
        assert!(
            length.reached && (length.value - exact).abs() <= length.error.max(1e-12),
            "{length:?} {exact}"
        );
    }

    #[test]
    fn high_degrees_are_as_long_as_low_ones_and_end_soon() {
        // The same curve with a degree of 25, and with weights that differ a million times.
        let points: Vec<Point> =
            (0..6).map(|k| Point::new(f64::from(k), f64::from(k * k % 5), 1e3)).collect();
        let curve = Curve::new(Space::clamped_uniform(3, 6).unwrap(), points.clone()).unwrap();
        let length = curve.length(1e-12).unwrap();
        for degree in [8, 25] {
            let raised = curve.elevate(degree - 3).unwrap().length(1e-12).unwrap();
            assert!(
                raised.reached && (raised.value - length.value).abs() < 1e-12 * length.value,
                "{raised:?}"
            );
        }
        let count = 46;
        let points =
            (0..count).map(|k| Point::new(f64::from(k % 7), f64::from(k * k % 11), f64::from(k % 3)));
        let weights: Vec<f64> = (0..count).map(|k| 10_f64.powi(k * 7 % 6 - 3)).collect();
        let space = Space::clamped_uniform(25, count as usize).unwrap();
        let wild = Curve::rational(space, points.collect(), weights).unwrap();
        let told = wild.length(1e-10).unwrap();
        let (a, b) = wild.domain();
        let chords: f64 = (0..20_000)
            .map(|k| {
                let at = |k: i32| wild.point((a + (b - a) * f64::from(k) / 20_000.0).min(b)).unwrap();
                (at(k + 1) - at(k)).norm()
            })
            .sum();
        assert!(told.reached && told.error <= 1e-10 * told.value, "{told:?}");
        // Chords are shorter, by the square of their length.
        assert!((0.0..1e-4 * chords).contains(&(told.value - chords)), "{} {chords}", told.value);
    }

    #[test]
    fn what_cannot_be_is_an_error_and_what_is_not_reached_is_told() {
        assert!(arc(1.0).length(f64::NAN).is_err());
        assert!(arc(1.0).length_between(0.0, 2.0, 1e-9).is_err());
        assert!(arc(1.0).parameter_at_length(2.0, 1e-9).is_err());
        assert!(!arc(1.0).length(0.0).unwrap().reached);
        let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap();
        // Zero to the rounding of a point 3.7 from the origin.
        assert!(point.length(1e-9).unwrap().value <= 1e-15);
        assert_eq!(point.parameter_at_length(0.0, 1e-9).unwrap(), 0.0);
    }
}
