//! Spline functions: a space and a coefficient for each of its B-splines.

use super::Coefficient;
use super::times::times;
use crate::error::{Error, Result};
use crate::space::{MAX_ORDER, Space};
use crate::spline::{Conversion, Curve};
use crate::{Point, Vector};

/// A spline function `f(u) = Σ c_i N_i(u)` with numbers or vectors as values: what curves are multiplied with, and what their
/// derivatives and products are, of any degree from 0 and torn where they are.
///
/// ```
/// use loftsman_kernel::spline::{Space, algebra::Function};
/// // u² on [0, 2] from u by u, and its integral from 0: u³ / 3.
/// let u = Function::new(Space::clamped(1, &[0.0, 2.0])?, vec![0.0, 2.0])?;
/// let square = u.times(&u)?;
/// assert_eq!((square.space().degree(), square.value(1.5)?), (2, 2.25));
/// assert_eq!(square.integral(0.0)?.value(1.5)?, 1.125);
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Function<T> {
    space: Space,
    coefficients: Vec<T>,
}

impl<T: Coefficient> Function<T> {
    /// The function with these coefficients, one for each B-spline of the space.
    ///
    /// # Errors
    /// When there are not as many, or one is not finite.
    pub fn new(space: Space, coefficients: Vec<T>) -> Result<Self> {
        if coefficients.len() != space.len() {
            return Err(Error::Invalid(format!(
                "{} coefficients for a space of {} B-splines (degree {}): give one for each",
                coefficients.len(),
                space.len(),
                space.degree()
            )));
        }
        if let Some(index) = coefficients.iter().position(|c| !c.is_finite()) {
            return Err(Error::Invalid(format!("coefficient {index} of a spline function is not finite")));
        }
        Ok(Self { space, coefficients })
    }

    /// The function that has the same value everywhere.
    ///
    /// # Errors
    /// When the value is not finite.
    pub fn constant(space: Space, value: T) -> Result<Self> {
        let coefficients = vec![value; space.len()];
        Self::new(space, coefficients)
    }

    /// Its space.
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Its coefficients.
    pub fn coefficients(&self) -> &[T] {
        &self.coefficients
    }

    /// Its space and its coefficients.
    pub fn into_parts(self) -> (Space, Vec<T>) {
        (self.space, self.coefficients)
    }

    /// A coefficient, zero where there is none.
    pub(super) fn at(&self, index: usize) -> T {
        self.coefficients.get(index).copied().unwrap_or_else(T::zero)
    }

    /// `f(u)`; at a knot where it jumps the value from the right. `O(p²)`.
    ///
    /// # Errors
    /// When `u` is outside the domain of an open space.
    pub fn value(&self, u: f64) -> Result<T> {
        let u = self.space.locate(u)?;
        let (p, span) = (self.space.degree(), self.space.span(u));
        let mut row = [0.0; MAX_ORDER];
        self.space.basis_into(span, u, 0, &mut row[..=p]);
        let each = row[..=p].iter().enumerate();
        Ok(each.fold(T::zero(), |sum, (i, n)| sum + self.at(self.space.vertex(span - p + i)) * *n))
    }

    /// The product with a function of numbers, `f(u) g(u)`: exact, of degree `p + q`, in the space of [`Space::product`]; in its own where
    /// the other is one piece of degree 0, a number. `O(n (p+1)(q+1))`; who multiplies often on the same spaces prepares that once.
    ///
    /// # Errors
    /// As for [`Space::product`], and when numbers overflow.
    pub fn times(&self, by: &Function<f64>) -> Result<Self> {
        if let [number] = by.coefficients[..]
            && by.space.degree() == 0
            && by.space.domain() == self.space.domain()
        {
            return Self::new(self.space.clone(), self.coefficients.iter().map(|c| *c * number).collect());
        }
        let multiply = |a: T, b: f64| a * b;
        match times(self, by, multiply)? {
            Some(product) => Ok(product),
            None => self.space.product(&by.space)?.combine(self, by, multiply),
        }
    }

    /// The derivative, in the space [`Space::derived`]: `q_i = p (c_{i+1} - c_i) / (t_{i+p+1} - t_{i+1})`. `O(n)`.
    ///
    /// # Errors
    /// As for [`Space::derived`], and when numbers overflow.
    pub fn derivative(&self) -> Result<Self> {
        let (space, p, n) = (self.space.derived()?, self.space.degree(), self.space.len());
        // Function i of the derived space takes what function i of a periodic space, or i + 1 of an open one, gives
        // up to its left neighbour.
        let difference = |i: usize| {
            let k = if self.space.is_periodic() { i + p } else { i + 1 };
            let (left, right) = if self.space.is_periodic() { ((i + n - 1) % n, i) } else { (i, i + 1) };
            let length = self.space.flat()[k + p] - self.space.flat()[k];
            (self.at(right) - self.at(left)) * (p as f64 / length)
        };
        let coefficients = (0..space.len()).map(difference).collect();
        Self::new(space, coefficients)
    }

    /// The antiderivative that has the value `start` where the domain starts: `F_{i+1} = F_i + f_i (t_{i+p+1} - t_i) / (p + 1)`,
    /// the running sum compensated, so that its error does not grow with the number of knots. Open, also that of a periodic
    /// function, which need not close. `O(n)`.
    ///
    /// # Errors
    /// When the degree is 25, or numbers overflow.
    pub fn integral(&self, start: T) -> Result<Self> {
        if self.space.is_periodic() {
            return self.opened()?.integral(start);
        }
        let (p, t) = (self.space.degree(), self.space.flat());
        let mut knots = Vec::with_capacity(t.len() + 2);
        knots.extend(t.first());
        knots.extend(t);
        knots.extend(t.last());
        let space = Space::open(p + 1, knots)?;
        let (mut sum, mut lost) = (T::zero(), T::zero());
        let mut coefficients = Vec::with_capacity(space.len());
        coefficients.push(sum);
        for (i, c) in self.coefficients.iter().enumerate() {
            let part = *c * ((t[i + p + 1] - t[i]) / (p + 1) as f64) - lost;
            let next = sum + part;
            lost = (next - sum) - part;
            sum = next;
            coefficients.push(sum);
        }
        let mut integral = Self { space, coefficients };
        let begin = integral.space.domain().0;
        let by = if integral.space.is_clamped() { start } else { start - integral.value(begin)? };
        integral.coefficients.iter_mut().for_each(|c| *c = *c + by);
        Self::new(integral.space, integral.coefficients)
    }

    /// The antiderivative of a periodic function that is periodic itself, with the value `start` where the period starts: there is
    /// one where the function's integral over the period is zero. `O(n)`.
    ///
    /// # Errors
    /// When the function is not periodic; when its integral over the period is more than rounding (`1e-9` of what it is made of);
    /// when the degree is 25, or numbers overflow.
    pub fn closed_integral(&self, start: T) -> Result<Self> {
        let (p, n) = (self.space.degree() + 1, self.space.len());
        if !self.space.is_periodic() {
            return Err(Error::Invalid(
                "the integral of a function that is not periodic does not close: take the open one".into(),
            ));
        }
        let space = Space::periodic(p, self.space.knots().to_vec())?;
        let part = |i: usize| self.at(i) * ((space.flat()[i + 2 * p] - space.flat()[i + p]) / p as f64);
        let (mut sum, mut lost, mut size) = (T::zero(), T::zero(), 0.0);
        let mut coefficients = Vec::with_capacity(n);
        for i in 0..n {
            let own = part(i);
            size += own.size();
            let next = sum + (own - lost);
            lost = (next - sum) - (own - lost);
            sum = next;
            coefficients.push(sum);
        }
        if sum.size() > 1e-9 * size {
            return Err(Error::Invalid(format!(
                "the integral over a period is {sum:?}, and not zero: an antiderivative does not close"
            )));
        }
        let integral = Self::new(space, coefficients)?;
        let by = start - integral.value(integral.space.domain().0)?;
        integral.mapped(|c| c + by)
    }

    /// `∫ f(u) du` over the domain. `O(n p²)`.
    ///
    /// # Errors
    /// When numbers overflow.
    pub fn total(&self) -> Result<T> {
        let each = self.space.integrals().into_iter().zip(&self.coefficients);
        let total = each.fold(T::zero(), |sum, (w, c)| sum + *c * w);
        if total.is_finite() { Ok(total) } else { Err(Error::Invalid("an integral overflows".into())) }
    }

    /// `∫ f(u) g(u) du` over the domain, exactly. `O(n (p+1)(q+1))`.
    ///
    /// # Errors
    /// As for [`Space::product`], and when numbers overflow.
    pub fn inner(&self, by: &Function<f64>) -> Result<T> {
        self.times(by)?.total()
    }

    /// This function plus `factor` times another, in a space that has both: the higher degree, the knots of both.
    ///
    /// # Errors
    /// When the domains differ, or numbers overflow.
    pub fn plus(&self, factor: f64, other: &Self) -> Result<Self> {
        let (a, b) = (self.space.domain(), other.space.domain());
        if a != b {
            return Err(Error::Invalid(format!(
                "functions over [{}, {}] and over [{}, {}] cannot be added: restrict or reparametrise one of them",
                a.0, a.1, b.0, b.1
            )));
        }
        if self.space == other.space {
            let sum = self.coefficients.iter().zip(&other.coefficients).map(|(a, b)| *a + *b * factor);
            return Self::new(self.space.clone(), sum.collect());
        }
        let common = self.space.common(&other.space)?;
        let first = common.first.iter().try_fold(self.clone(), |f, step| f.convert(step))?;
        let second = common.second.iter().try_fold(other.clone(), |f, step| f.convert(step))?;
        let sum = first.coefficients.iter().zip(&second.coefficients).map(|(a, b)| *a + *b * factor);
        Self::new(first.space, sum.collect())
    }

    /// The same function in another space that holds it.
    ///
    /// # Errors
    /// When the conversion starts at another space, or numbers overflow.
    pub fn convert(&self, conversion: &Conversion) -> Result<Self> {
        if conversion.from() != &self.space {
            return Err(Error::Invalid("the conversion is one of another space than the function's".into()));
        }
        let to = conversion.to();
        let row = |k: usize| conversion.row(k).fold(T::zero(), |sum, (i, w)| sum + self.at(i) * w);
        Self::new(to.clone(), (0..to.len()).map(row).collect())
    }

    /// The same function over a clamped open space: of a periodic one, one period; what it has on its domain.
    ///
    /// # Errors
    /// When numbers overflow.
    pub fn opened(&self) -> Result<Self> {
        if self.space.degree() > 0 {
            return self.convert(&self.space.clamping()?);
        }
        // Steps have no knots beyond those that they are between, and each vertex the one step that starts at its knot.
        let space = Space::open(0, self.space.knots().to_vec())?;
        Self::new(space, self.coefficients.clone())
    }

    /// The function of a linear map of the parameter, `t ↦ f(slope · t + offset)`: the same coefficients, in reverse where the slope is negative, over the knots
    /// `(u - offset) / slope`. At a knot where it jumps a reversed function has the value that `f` has from the left. `O(n)`.
    ///
    /// ```
    /// use loftsman_kernel::spline::{Space, algebra::Function};
    /// // u on [0, 2], as a function of t = (3 - u) / 2.
    /// let u = Function::new(Space::clamped(1, &[0.0, 2.0])?, vec![0.0, 2.0])?;
    /// let of_t = u.compose(-2.0, 3.0)?;
    /// assert_eq!((of_t.space().domain(), of_t.value(1.25)?), ((0.5, 1.5), 0.5));
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Space::composing`], but that the degree may be 0.
    pub fn compose(&self, slope: f64, offset: f64) -> Result<Self> {
        let space = self.space.composed(slope, offset)?;
        let vertex = |k: usize| if slope < 0.0 { self.space.mirrored(k) } else { k };
        let coefficients = (0..space.len()).map(|k| self.at(vertex(k))).collect();
        Self::new(space, coefficients)
    }

    /// A linear map of its values, `A f(u)`: scaled, turned, one of its coordinates.
    ///
    /// # Errors
    /// When a coefficient becomes not finite.
    pub fn mapped<S: Coefficient>(&self, map: impl Fn(T) -> S) -> Result<Function<S>> {
        Function::new(self.space.clone(), self.coefficients.iter().map(|c| map(*c)).collect())
    }
}

impl Function<Vector> {
    /// The curve with these values as points.
    ///
    /// # Errors
    /// When the degree is 0, which no curve has.
    pub fn into_curve(self) -> Result<Curve> {
        Curve::new(self.space, self.coefficients.into_iter().map(Point::from).collect())
    }
}

impl Curve {
    /// The points of a polynomial curve as a function.
    ///
    /// # Errors
    /// When the curve is rational: it is no linear combination of B-splines.
    pub fn function(&self) -> Result<Function<Vector>> {
        if self.weights().is_some() {
            return Err(Error::Invalid(
                "a rational curve is a quotient of spline functions, not one: take its numerator and denominator apart".into(),
            ));
        }
        Function::new(self.space().clone(), self.points().iter().map(|p| p.coords).collect())
    }
}
