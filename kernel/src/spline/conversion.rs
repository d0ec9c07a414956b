//! The linear map from the control vertices of one spline space to those of another that contains it.
//!
//! Inserting knots, raising the degree, cutting out a part, opening a periodic curve and bringing a curve to Bézier
//! form are all the same thing: the function stays, the space grows, and every new vertex is a weighted mean of a
//! few old ones. So each of them is a [`Conversion`], made once from the knots alone, and applied to curves, to both
//! directions of surfaces, or to anything else that lives on the vertices.

use std::fmt::Debug;

use super::curve::check_curve_space;
use super::space::{MAX_ORDER, Space, periodic_knot};
use super::{Curve, Surface};
use crate::Point;
use crate::error::{Error, Result};

/// A direction of a surface: along `u` (the rows of the control net follow one another) or along `v`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Along the first parameter.
    U,
    /// Along the second parameter.
    V,
}

impl Direction {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::U => Self::V,
            Self::V => Self::U,
        }
    }
}

/// A sparse matrix that gives the control vertices of a spline in a larger space: `Q_k = Σ_i c_ki P_i`.
///
/// Every coefficient is non-negative and every row sums to one (to rounding), so that no conversion amplifies
/// errors, whatever the knots. Rational splines are converted in homogeneous coordinates.
#[derive(Debug, Clone)]
pub struct Conversion {
    from: Space,
    to: Space,
    /// Row `k` starts at vertex `firsts[k]` of `from` (and goes round where that is periodic) ...
    firsts: Vec<usize>,
    /// ... and has the coefficients `offsets[k] .. offsets[k + 1]`.
    offsets: Vec<usize>,
    coefficients: Vec<f64>,
}

impl Conversion {
    /// The conversion to a space of the same degree whose knots contain those of `from` that lie within its domain.
    pub(super) fn refining(from: &Space, to: Space) -> Result<Self> {
        Self::build(from, &Line::new(from, 0), to, |line, start, arguments, row| {
            line.add_blossom(start, arguments, 1.0, row)
        })
    }

    /// The conversion to the clamped space over the part `[c, d]` of the domain, which may go on into the next
    /// period where `from` is periodic.
    pub(super) fn restricting(from: &Space, c: f64, d: f64) -> Result<Self> {
        let ahead = if from.is_periodic() { from.len() } else { 0 };
        let (line, p) = (Line::new(from, ahead), from.degree());
        let first = line.knots.partition_point(|&k| k <= c);
        let last = line.knots.partition_point(|&k| k < d);
        let mut knots = vec![c; p + 1];
        knots.extend_from_slice(line.knots.get(first..last).unwrap_or_default());
        knots.extend(std::iter::repeat_n(d, p + 1));
        let to = Space::open(p, knots)?;
        Self::build(from, &line, to, |line, start, arguments, row| {
            line.add_blossom(start, arguments, 1.0, row)
        })
    }

    /// The conversion to the space of the next degree in which every knot is repeated once more.
    ///
    /// The polar form of a polynomial of degree `p`, seen as one of degree `p + 1`, is the mean over its arguments
    /// left out one at a time, `F(a_0, …, a_p) = Σ_j f(a_0, …, â_j, …, a_p) / (p + 1)` (Ramshaw 1989, *Blossoms are
    /// polar forms*, §4); every `f` here is one that knot insertion also computes, a convex combination.
    pub(super) fn elevating(from: &Space, to: Space) -> Result<Self> {
        let p = from.degree();
        Self::build(from, &Line::new(from, 0), to, |line, start, arguments, row| {
            let mut kept = [0.0; MAX_ORDER];
            let mut j = 0;
            while j <= p {
                let copies = arguments[j..=p].iter().take_while(|&&a| a == arguments[j]).count();
                kept[..j].copy_from_slice(&arguments[..j]);
                kept[j..p].copy_from_slice(&arguments[j + 1..=p]);
                line.add_blossom(start, &kept[..p], copies as f64 / (p + 1) as f64, row)?;
                j += copies;
            }
            Ok(())
        })
    }

    /// The conversion to a space with the same vertices in another order: new vertex `k` is old `vertex(k)`.
    pub(super) fn reordering(from: &Space, to: Space, vertex: impl Fn(usize) -> usize) -> Result<Self> {
        check_curve_space(from)?;
        let n = from.len();
        Ok(Self {
            from: from.clone(),
            to,
            firsts: (0..n).map(|k| vertex(k) % n).collect(),
            offsets: (0..=n).collect(),
            coefficients: vec![1.0; n],
        })
    }

    /// Rows from the arguments of each vertex's blossom value: the knots inside the support of its function.
    fn build(
        from: &Space,
        line: &Line,
        to: Space,
        fill: impl Fn(&Line, f64, &[f64], &mut Row) -> Result<()>,
    ) -> Result<Self> {
        check_curve_space(from)?;
        let degree = to.degree();
        let shift = if to.is_periodic() { degree } else { 0 };
        let mut firsts = Vec::with_capacity(to.len());
        let mut offsets = Vec::with_capacity(to.len() + 1);
        let mut coefficients = Vec::with_capacity(to.len() * 2);
        offsets.push(0);
        let mut row = Row::default();
        for k in shift..shift + to.len() {
            row.clear();
            fill(line, to.flat()[k], &to.flat()[k + 1..=k + degree], &mut row)?;
            firsts.push(line.vertex(row.first));
            coefficients.extend_from_slice(&row.values[..row.len]);
            offsets.push(coefficients.len());
        }
        Ok(Self { from: from.clone(), to, firsts, offsets, coefficients })
    }

    /// The space converted from.
    pub fn from(&self) -> &Space {
        &self.from
    }

    /// The space converted to.
    pub fn to(&self) -> &Space {
        &self.to
    }

    /// The old vertices and coefficients that make up new vertex `k`. A vertex may come twice where the old space
    /// is periodic with fewer vertices than the row has coefficients. Empty where there is no vertex `k`.
    pub fn row(&self, k: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (first, values) = match (self.firsts.get(k), self.offsets.get(k + 1)) {
            (Some(&first), Some(&end)) => (first, &self.coefficients[self.offsets[k]..end]),
            _ => (0, &[][..]),
        };
        let n = self.from.len();
        values.iter().enumerate().map(move |(j, &c)| ((first + j) % n, c))
    }

    /// Converts every line of an array of `outer × n × inner` vertices along its middle axis.
    fn apply(
        &self,
        points: &[Point],
        weights: Option<&[f64]>,
        outer: usize,
        inner: usize,
    ) -> (Vec<Point>, Option<Vec<f64>>) {
        let (n, m) = (self.from.len(), self.to.len());
        let mut new_points = Vec::with_capacity(outer * m * inner);
        let mut new_weights = weights.map(|_| Vec::with_capacity(outer * m * inner));
        for o in 0..outer {
            for k in 0..m {
                for c in 0..inner {
                    let at = |i: usize| (o * n + i) * inner + c;
                    let (point, weight) = self.combine(k, at, points, weights);
                    new_points.push(point);
                    if let Some(all) = &mut new_weights {
                        all.push(weight);
                    }
                }
            }
        }
        (new_points, new_weights)
    }

    fn combine(
        &self,
        k: usize,
        at: impl Fn(usize) -> usize,
        points: &[Point],
        weights: Option<&[f64]>,
    ) -> (Point, f64) {
        let n = self.from.len();
        let row = &self.coefficients[self.offsets[k]..self.offsets[k + 1]];
        let mut i = self.firsts[k];
        if let [_] = row {
            // A vertex that stays does so to the last bit.
            return (points[at(i)], weights.map_or(1.0, |w| w[at(i)]));
        }
        let next = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        let mut sum = Point::origin();
        let Some(weights) = weights else {
            for &c in row {
                sum += points[at(i)].coords * c;
                i = next(i);
            }
            return (sum, 1.0);
        };
        // Weights first: then the points are averaged with shares that sum to one, which cannot overflow.
        let mut total = 0.0;
        for &c in row {
            total += c * weights[at(i)];
            i = next(i);
        }
        i = self.firsts[k];
        for &c in row {
            sum += points[at(i)].coords * (c * weights[at(i)] / total);
            i = next(i);
        }
        (sum, total)
    }
}

impl Curve {
    /// The same curve in the larger space of a conversion.
    ///
    /// # Errors
    /// When the conversion starts from another space than the curve's.
    pub fn convert(&self, conversion: &Conversion) -> Result<Self> {
        check_space(self.space(), conversion)?;
        let (points, weights) = conversion.apply(self.points(), self.weights(), 1, 1);
        Self::build(conversion.to.clone(), points, weights)
    }
}

impl Surface {
    /// The space along a direction.
    pub fn space(&self, direction: Direction) -> &Space {
        match direction {
            Direction::U => self.u(),
            Direction::V => self.v(),
        }
    }

    /// The same surface in the larger space that a conversion has in one direction.
    ///
    /// # Errors
    /// When the conversion starts from another space than the surface's.
    pub fn convert(&self, direction: Direction, conversion: &Conversion) -> Result<Self> {
        check_space(self.space(direction), conversion)?;
        let to = conversion.to.clone();
        match direction {
            Direction::U => {
                let (points, weights) = conversion.apply(self.points(), self.weights(), 1, self.v().len());
                Self::build(to, self.v().clone(), points, weights)
            }
            Direction::V => {
                let (points, weights) = conversion.apply(self.points(), self.weights(), self.u().len(), 1);
                Self::build(self.u().clone(), to, points, weights)
            }
        }
    }
}

fn check_space(space: &Space, conversion: &Conversion) -> Result<()> {
    if *space == conversion.from {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "the conversion is for a space of degree {} with {} vertices, not for this one of degree {} with {}: make it \
         from the shape's own space",
        conversion.from.degree(),
        conversion.from.len(),
        space.degree(),
        space.len()
    )))
}

/// A row of coefficients under way: consecutive functions of a [`Line`] from `first` on.
#[derive(Debug)]
struct Row {
    first: usize,
    len: usize,
    values: [f64; 2 * MAX_ORDER],
    /// Where the run of knots of the last blossom value started: the next one's is near.
    near: usize,
}

impl Default for Row {
    fn default() -> Self {
        Self { first: 0, len: 0, values: [0.0; 2 * MAX_ORDER], near: 0 }
    }
}

impl Row {
    fn clear(&mut self) {
        self.values[..self.len].fill(0.0);
        self.len = 0;
    }

    /// Adds coefficients that start at function `first`; the row grows at either end as needed.
    fn add(&mut self, first: usize, values: &[f64], factor: f64) -> Result<()> {
        if self.len == 0 {
            self.first = first;
        }
        let shift = self.first.saturating_sub(first);
        let end = (first + values.len()).max(self.first + self.len);
        if end - self.first.min(first) > self.values.len() {
            return Err(not_contained());
        }
        if shift > 0 {
            self.values.copy_within(..self.len, shift);
            self.values[..shift].fill(0.0);
            self.first = first;
        }
        self.len = end - self.first;
        for (sum, value) in self.values[first - self.first..].iter_mut().zip(values) {
            *sum += value * factor;
        }
        Ok(())
    }
}

/// The knots of a space as one open line, those of a periodic space continued far enough beyond both ends.
struct Line {
    degree: usize,
    knots: Vec<f64>,
    /// Function 0 of the line is function `-before` of the period.
    before: usize,
    len: usize,
}

impl Line {
    /// The line of a space; that of a periodic space goes on for `ahead` more knots.
    fn new(space: &Space, ahead: usize) -> Self {
        let (degree, len) = (space.degree(), space.len());
        if !space.is_periodic() {
            return Self { degree, knots: space.flat().to_vec(), before: 0, len };
        }
        // A function of the next degree that starts within the period reaches p + 2 knots beyond its end, and so do
        // the functions it is made of, p + 1 more.
        let before = 2 * degree + 2;
        let knots = (-(before as isize)..=(len + 2 * before + ahead) as isize)
            .map(|k| periodic_knot(space.knots(), k))
            .collect();
        Self { degree, knots, before, len }
    }

    /// The control vertex of a function of the line.
    fn vertex(&self, function: usize) -> usize {
        let n = self.len;
        (function % n + n - self.before % n) % n
    }

    /// Adds to `row`, times `factor`, the coefficients of the blossom value `f(arguments)` of the piecewise
    /// polynomial in terms of the line's vertices `f(t_{i+1}, …, t_{i+p})`; `start` is where the support of the new
    /// function starts.
    ///
    /// The arguments ascend, and hold every knot strictly between the first and the last of them. So they are a run
    /// of consecutive knots `t_q …` and `r` others, which lie between the neighbours of the run (inclusive); then
    /// `r` steps of de Boor's algorithm lead there from the `r + 1` vertices whose knots contain the run, each step
    /// a convex combination (Boehm 1980; Goldman 1990 for the blossoming view). The steps are taken backwards here,
    /// from the value to the weights of the vertices. `O(r²)` for rows in order, else `O(r² + log n)`.
    fn add_blossom(&self, start: f64, arguments: &[f64], factor: f64, row: &mut Row) -> Result<()> {
        let (t, p) = (&self.knots, self.degree);
        let (first, last) = (arguments[0], arguments[p - 1]);
        let next = row.near + 1;
        if first < last && t.get(next..next + p) == Some(arguments) {
            // A vertex that stays, next to the one before: what most are where few knots are new.
            row.near = next;
            return row.add(next - 1, &[1.0], factor);
        }
        let (low, low_end) = equal_range(t, row.near, first);
        let mut others = [0.0; MAX_ORDER];
        let mut count = 0;
        let mut push = |value: f64, copies: usize| {
            others[count..count + copies].fill(value);
            count += copies;
        };
        let (run, run_end);
        if first == last {
            let used = p.min(low_end - low);
            // A knot repeated p + 1 times has two vertices: a function that comes from the left has the first.
            run = if start < first { low } else { low_end - used };
            run_end = run + used;
            push(first, p - used);
        } else {
            let copies = |value: f64| arguments.iter().filter(|&&a| a == value).count();
            let (firsts, lasts) = (copies(first), copies(last));
            let (high, high_end) = equal_range(t, row.near, last);
            run = low_end - firsts.min(low_end - low);
            run_end = high + lasts.min(high_end - high);
            push(first, firsts - (low_end - run));
            let mut expected = low_end;
            for &a in &arguments[firsts..p - lasts] {
                if expected < high && t[expected] == a {
                    expected += 1;
                } else {
                    push(a, 1);
                }
            }
            push(last, lasts - (run_end - high));
        }
        let r = count;
        if run_end - run + r != p || run < r + 1 || run + p > t.len() {
            return Err(not_contained());
        }
        row.near = run;
        let mut values = [0.0; MAX_ORDER];
        values[0] = 1.0;
        for step in (1..=r).rev() {
            let a = others[step - 1];
            let mut carry = 0.0;
            for l in 0..=r - step {
                let (left, right) = (t[run - 1 + step - r + l], t[run + p - r + l]);
                let share = values[l] / (right - left);
                values[l] = carry + (right - a) * share;
                carry = (a - left) * share;
            }
            values[r - step + 1] = carry;
        }
        row.add(run - 1 - r, &values[..=r], factor)
    }
}

/// Where a value is among ascending numbers: from the first that is not less to the first that is greater. It is
/// looked for around a place first.
fn equal_range(sorted: &[f64], near: usize, value: f64) -> (usize, usize) {
    let (from, to) = (near.saturating_sub(MAX_ORDER), (near + 2 * MAX_ORDER).min(sorted.len()));
    let low = match sorted.get(from..to) {
        Some(part @ [first, .., last]) if *first < value && value <= *last => {
            from + part.partition_point(|&k| k < value)
        }
        _ => sorted.partition_point(|&k| k < value),
    };
    let high = low + sorted[low..].iter().take_while(|&&k| k == value).count();
    (low, high)
}

fn not_contained() -> Error {
    Error::Invalid("the new knots do not contain the old ones: this conversion would change the shape".into())
}
