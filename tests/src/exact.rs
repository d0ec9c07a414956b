//! An evaluator that shares nothing with the kernel: native documents, de Boor's algorithm by the book, exact rationals.

use num_rational::BigRational;
use num_traits::{Num, ToPrimitive};
use serde_json::Value;

/// What the evaluator computes with: exact numbers where every bit counts, those of the machine where many are asked.
trait Number: Num + Clone {
    fn of(exact: &BigRational) -> Self;
    fn near(&self) -> f64;
}

impl Number for BigRational {
    fn of(exact: &BigRational) -> Self {
        exact.clone()
    }

    fn near(&self) -> f64 {
        self.to_f64().unwrap_or(f64::NAN)
    }
}

impl Number for f64 {
    fn of(exact: &BigRational) -> Self {
        exact.near()
    }

    fn near(&self) -> f64 {
        *self
    }
}

fn whole<T: Number>(n: usize) -> T {
    (0..n).fold(T::zero(), |sum, _| sum + T::one())
}

type Homogeneous<T> = [T; 4];

/// A number of a document, exactly.
///
/// # Panics
/// When it is not finite.
pub fn exact(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap_or_else(|| panic!("{value} is not a number"))
}

/// The numbers of a list.
///
/// # Panics
/// When there is something else among them.
pub fn numbers(list: &Value) -> Vec<f64> {
    let all = list.as_array().unwrap_or_else(|| panic!("{list} is not a list"));
    all.iter().map(|v| v.as_f64().unwrap_or_else(|| panic!("{v} is not a number"))).collect()
}

/// One direction of a spline as a document has it: knots unrolled, and which vertex each function belongs to.
#[derive(Debug, Clone)]
pub struct Direction {
    degree: usize,
    flat: Vec<BigRational>,
    count: usize,
    first: usize,
    periodic: bool,
}

impl Direction {
    /// From `{ degree, periodic, knots }`.
    ///
    /// # Panics
    /// When it is something else.
    pub fn new(said: &Value) -> Self {
        let degree = usize::try_from(said["degree"].as_u64().expect("a degree")).expect("a small degree");
        let knots: Vec<BigRational> = numbers(&said["knots"]).into_iter().map(exact).collect();
        if said["periodic"] != true {
            let count = knots.len() - degree - 1;
            return Self { degree, flat: knots, count, first: 0, periodic: false };
        }
        // Vertex i belongs to the function whose support starts at knots[i]; those of the period before reach into it.
        let count = knots.len() - 1;
        let period = &knots[count] - &knots[0];
        let laps = degree.div_ceil(count) + 1;
        let at = |i: usize| {
            let lap = BigRational::from_integer((i / count).into()) - BigRational::from_integer(laps.into());
            &knots[i % count] + &period * lap
        };
        let start = laps * count - degree;
        let flat = (start..laps * count + count + degree + 1).map(at).collect();
        Self { degree, flat, count, first: (count - degree % count) % count, periodic: true }
    }

    /// The interval of its parameter.
    pub fn domain(&self) -> (f64, f64) {
        let last = if self.periodic { self.degree + self.count } else { self.count };
        let end = |k: &BigRational| k.to_f64().unwrap_or(f64::NAN);
        (end(&self.flat[self.degree]), end(&self.flat[last]))
    }

    /// The number of control vertices.
    pub fn count(&self) -> usize {
        self.count
    }

    /// De Boor's algorithm: what remains of the values of `degree + 1` functions at `u`, on the span to its right (at the
    /// end of the domain, to its left); of their derivatives of an order, after as many differences.
    fn combine<T: Number>(
        &self,
        u: &BigRational,
        order: usize,
        value: impl Fn(usize) -> Homogeneous<T>,
    ) -> Homogeneous<T> {
        let (p, t) = (self.degree, &self.flat);
        if order > p {
            return std::array::from_fn(|_| T::zero());
        }
        let last = t.len() - p - 2;
        let span = (p..=last).rev().find(|&k| t[k] <= *u && t[k] < t[k + 1]).expect("within the domain");
        let mut d: Vec<Homogeneous<T>> =
            (0..=p).map(|j| value((span - p + j + self.first) % self.count)).collect();
        // The differences are exact before they are rounded.
        let apart = |a: &BigRational, b: &BigRational| T::of(&(a - b));
        for r in 1..=order {
            for j in (r..=p).rev() {
                let slope = whole::<T>(p + 1 - r) / apart(&t[span + 1 + j - r], &t[span - p + j]);
                let before = d[j - 1].clone();
                for (mine, other) in d[j].iter_mut().zip(before) {
                    *mine = (mine.clone() - other) * slope.clone();
                }
            }
        }
        for r in 1..=p - order {
            for j in (order + r..=p).rev() {
                let (low, high) = (&t[span - p + j], &t[span + 1 + j - order - r]);
                let alpha = apart(u, low) / apart(high, low);
                let before = d[j - 1].clone();
                for (mine, other) in d[j].iter_mut().zip(before) {
                    *mine = mine.clone() * alpha.clone() + other * (T::one() - alpha.clone());
                }
            }
        }
        d.swap_remove(p)
    }
}

fn homogeneous<T: Number>(point: &Value, weight: Option<&Value>) -> Homogeneous<T> {
    let p = numbers(point);
    let number = |v: f64| T::of(&exact(v));
    let w = number(weight.map_or(1.0, |w| w.as_f64().expect("a weight")));
    [number(p[0]) * w.clone(), number(p[1]) * w.clone(), number(p[2]) * w.clone(), w]
}

/// The derivative of orders `[i, j]` of what is given homogeneously, by Leibniz' rule for `w · S`.
fn quotient<T: Number>([i, j]: [usize; 2], of: impl Fn(usize, usize) -> Homogeneous<T>) -> [f64; 3] {
    let choose = |n: usize, k: usize| (0..k).fold(1_usize, |c, i| c * (n - i) / (i + 1));
    let given: Vec<Vec<Homogeneous<T>>> = (0..=i).map(|a| (0..=j).map(|b| of(a, b)).collect()).collect();
    let weight = &given[0][0][3];
    assert!(!weight.is_zero(), "a weight of zero");
    let mut found: Vec<Vec<[T; 3]>> = Vec::new();
    for a in 0..=i {
        found.push(Vec::new());
        for b in 0..=j {
            let [x, y, z, _] = given[a][b].clone();
            let mut sum = [x, y, z];
            for c in 0..=a {
                for d in (0..=b).filter(|d| c + d > 0) {
                    let share = given[c][d][3].clone() * whole(choose(a, c) * choose(b, d));
                    for (sum, known) in sum.iter_mut().zip(&found[a - c][b - d]) {
                        *sum = sum.clone() - known.clone() * share.clone();
                    }
                }
            }
            found[a].push(sum.map(|v| v / weight.clone()));
        }
    }
    found[i][j].clone().map(|v| v.near())
}

fn on_curve<T: Number>(curve: &Value, u: f64, order: usize) -> [f64; 3] {
    let weight = |i: usize| curve.get("weights").map(|w| &w[i]);
    let (space, u) = (Direction::new(curve), exact(u));
    quotient::<T>([order, 0], |k, _| space.combine(&u, k, |i| homogeneous(&curve["points"][i], weight(i))))
}

fn on_surface<T: Number>(surface: &Value, at: [f64; 2], orders: [usize; 2]) -> [f64; 3] {
    let (along, across) = (Direction::new(&surface["u"]), Direction::new(&surface["v"]));
    let weight = |i: usize, j: usize| surface.get("weights").map(|w| &w[i][j]);
    let [u, v] = at.map(exact);
    quotient::<T>(orders, |a, b| {
        along.combine(&u, a, |i| {
            across.combine(&v, b, |j| homogeneous(&surface["points"][i][j], weight(i, j)))
        })
    })
}

/// The point of a document's `curve` at `u`, correct to the last bit but one.
///
/// # Panics
/// When it is no curve or `u` is outside of its domain.
pub fn curve_point(curve: &Value, u: f64) -> [f64; 3] {
    on_curve::<BigRational>(curve, u, 0)
}

/// The derivative of an order of a document's `curve` at `u`, from the right at knots; to rounding.
///
/// # Panics
/// When it is no curve or `u` is outside of its domain.
pub fn curve_derivative(curve: &Value, u: f64, order: usize) -> [f64; 3] {
    on_curve::<f64>(curve, u, order)
}

/// The point of a document's `surface` at `(u, v)`.
///
/// # Panics
/// When it is no surface or the parameters are outside of its domain.
pub fn surface_point(surface: &Value, u: f64, v: f64) -> [f64; 3] {
    on_surface::<BigRational>(surface, [u, v], [0, 0])
}

/// The derivative of orders `[i, j]` of a document's `surface` at `[u, v]`; to rounding.
///
/// # Panics
/// When it is no surface or the parameters are outside of its domain.
pub fn surface_derivative(surface: &Value, at: [f64; 2], orders: [usize; 2]) -> [f64; 3] {
    on_surface::<f64>(surface, at, orders)
}

/// The object of this name in a document.
///
/// # Panics
/// When there is none.
pub fn object<'a>(document: &'a Value, name: &str) -> &'a Value {
    let all = document["objects"].as_array().expect("objects");
    all.iter().find(|o| o["name"] == name).unwrap_or_else(|| panic!("no \"{name}\" in the document"))
}

/// The distance of two points, in the largest coordinate.
pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn closed_forms() {
        // A cubic Bézier curve, a quarter of a circle, and the uniform cubic's knots' points (1, 4, 1)/6.
        let bezier = json!({ "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 1, 1, 1],
            "points": [[0, 0, 0], [0, 8, 0], [8, 8, 0], [8, 0, 0]] });
        assert_eq!(curve_point(&bezier, 0.5), [4.0, 6.0, 0.0]);
        assert_eq!(curve_point(&bezier, 1.0), [8.0, 0.0, 0.0]);
        assert_eq!(curve_derivative(&bezier, 0.5, 1), [12.0, 0.0, 0.0]);
        assert_eq!(curve_derivative(&bezier, 0.0, 2), [48.0, -48.0, 0.0]);
        assert_eq!(curve_derivative(&bezier, 0.25, 4), [0.0; 3]);
        let arc = json!({ "degree": 2, "periodic": false, "knots": [0, 0, 0, 1, 1, 1],
            "points": [[1, 0, 0], [1, 1, 0], [0, 1, 0]], "weights": [1, 0.5_f64.sqrt(), 1] });
        let [x, y, _] = curve_point(&arc, 0.3);
        assert!((x.hypot(y) - 1.0).abs() < 1e-15);
        // |C|² = 1: C·C' = 0 and C·C'' = -|C'|².
        let [p, one, two] = [0, 1, 2].map(|k| curve_derivative(&arc, 0.3, k));
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        assert!(dot(p, one).abs() < 1e-15 && (dot(p, two) + dot(one, one)).abs() < 1e-14);
        // x = u, y = v, z = 3 u v: bilinear.
        let line = json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1] });
        let bent =
            json!({ "u": line, "v": line, "points": [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 3]]] });
        assert_eq!(surface_derivative(&bent, [0.25, 0.5], [1, 0]), [1.0, 0.0, 1.5]);
        assert_eq!(surface_derivative(&bent, [0.25, 0.5], [1, 1]), [0.0, 0.0, 3.0]);
        for n in [2, 5] {
            let points: Vec<_> = (0..n).map(|i| json!([f64::from(i * i), 0, 1])).collect();
            let knots: Vec<_> = (0..=n).collect();
            let ring = json!({ "degree": 3, "periodic": true, "knots": knots, "points": points });
            let at = |i: i32| f64::from(i.rem_euclid(n).pow(2));
            for k in 0..n {
                // At knot k the functions that start at k - 3, k - 2 and k - 1 weigh 1, 4 and 1 sixths.
                let expected = (at(k - 3) + 4.0 * at(k - 2) + at(k - 1)) / 6.0;
                assert!(apart(curve_point(&ring, f64::from(k)), [expected, 0.0, 1.0]) < 1e-14, "{n} {k}");
            }
        }
    }
}
