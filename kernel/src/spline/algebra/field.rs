//! Spline functions of two parameters.

use super::bernstein::Pieces;
use super::{Coefficient, Function};
use crate::error::{Error, Result};
use crate::space::Space;
use crate::spline::{Direction, Surface};
use crate::{Point, Vector};

/// A tensor-product spline function `f(u, v) = Σ c_ij M_i(u) N_j(v)` with numbers or vectors as values. Coefficient `(i, j)` is
/// number `i · v.len() + j`.
#[derive(Debug, Clone, PartialEq)]
pub struct Field<T> {
    u: Space,
    v: Space,
    coefficients: Vec<T>,
}

impl<T: Coefficient> Field<T> {
    /// The function with these coefficients: rows along `u`, each along `v`.
    ///
    /// # Errors
    /// When there are not as many as the spaces have B-splines, or one is not finite.
    pub fn new(u: Space, v: Space, coefficients: Vec<T>) -> Result<Self> {
        if u.len().checked_mul(v.len()) != Some(coefficients.len()) {
            return Err(Error::Invalid(format!(
                "{} coefficients for {} × {} B-splines: give one for each, along v first",
                coefficients.len(),
                u.len(),
                v.len()
            )));
        }
        if let Some(index) = coefficients.iter().position(|c| !c.is_finite()) {
            let (row, column) = (index / v.len(), index % v.len());
            return Err(Error::Invalid(format!(
                "coefficient [{row}, {column}] of a spline function is not finite"
            )));
        }
        Ok(Self { u, v, coefficients })
    }

    /// Its space in a direction.
    pub fn space(&self, direction: Direction) -> &Space {
        match direction {
            Direction::U => &self.u,
            Direction::V => &self.v,
        }
    }

    /// Its coefficients, along `v` first.
    pub fn coefficients(&self) -> &[T] {
        &self.coefficients
    }

    /// `f(u, v)`. `O((p+1)(q+1))`.
    ///
    /// # Errors
    /// When a parameter is outside the domain of an open space.
    pub fn value(&self, u: f64, v: f64) -> Result<T> {
        let columns = self.v.len();
        let row = |i: usize| {
            let own = self.coefficients[i * columns..(i + 1) * columns].to_vec();
            Function::new(self.v.clone(), own)?.value(v)
        };
        let (at, p) = (self.u.locate(u)?, self.u.degree());
        let span = self.u.span(at);
        let mut values = vec![0.0; p + 1];
        self.u.basis_into(span, at, 0, &mut values);
        let each = values.iter().enumerate();
        each.map(|(i, n)| Ok(row(self.u.vertex(span - p + i))? * *n))
            .try_fold(T::zero(), |sum, part: Result<T>| Ok(sum + part?))
    }

    /// Each line along a direction as a function of its own, changed by `change`, and put together again.
    fn along(
        &self,
        direction: Direction,
        change: impl Fn(Function<T>) -> Result<Function<T>>,
    ) -> Result<Self> {
        let (rows, columns) = (self.u.len(), self.v.len());
        let (count, length, step, stride) = match direction {
            Direction::U => (columns, rows, columns, 1),
            Direction::V => (rows, columns, 1, columns),
        };
        let line = |k: usize| {
            let own = (0..length).map(|i| self.coefficients[k * stride + i * step]).collect();
            change(Function::new(self.space(direction).clone(), own)?)
        };
        let lines = (0..count).map(line).collect::<Result<Vec<_>>>()?;
        let Some(first) = lines.first() else { return Ok(self.clone()) };
        let space = first.space().clone();
        match direction {
            Direction::V => {
                let all = lines.iter().flat_map(|line| line.coefficients()).copied().collect();
                Self::new(self.u.clone(), space, all)
            }
            Direction::U => {
                let all = (0..space.len()).flat_map(|i| lines.iter().map(move |line| line.at(i))).collect();
                Self::new(space, self.v.clone(), all)
            }
        }
    }

    /// The partial derivative in a direction; see [`Function::derivative`].
    ///
    /// # Errors
    /// As there.
    pub fn derivative(&self, direction: Direction) -> Result<Self> {
        self.along(direction, |line| line.derivative())
    }

    /// The field of a linear map of one parameter, `f(slope · t + offset, v)` or `f(u, slope · t + offset)`; see [`Function::compose`].
    ///
    /// # Errors
    /// As there.
    pub fn compose(&self, direction: Direction, slope: f64, offset: f64) -> Result<Self> {
        self.along(direction, |line| line.compose(slope, offset))
    }

    /// The antiderivative in a direction that is zero where that direction's domain starts; see [`Function::integral`].
    ///
    /// # Errors
    /// As there.
    pub fn integral(&self, direction: Direction) -> Result<Self> {
        self.along(direction, |line| line.integral(T::zero()))
    }

    /// The product with a function of one of the parameters, `f(u, v) α(u)`, exactly.
    ///
    /// # Errors
    /// As for [`Space::product`], and when numbers overflow.
    pub fn times_along(&self, direction: Direction, by: &Function<f64>) -> Result<Self> {
        let product = self.space(direction).product(by.space())?;
        self.along(direction, |line| product.combine(&line, by, |a, b| a * b))
    }

    /// The product with a function of both parameters, exactly, of the sum of the degrees in each direction.
    /// `O(rows × columns × (p+1)²(q+1)²)`.
    ///
    /// # Errors
    /// As for [`Space::product`], and when numbers overflow.
    pub fn times(&self, by: &Field<f64>) -> Result<Self> {
        let (along_u, along_v) = (self.u.product(&by.u)?, self.v.product(&by.v)?);
        let [own_u, other_u] = along_u.factors();
        let [own_v, other_v] = along_v.factors();
        let own = Net::new(&self.coefficients, self.v.len(), own_u, own_v);
        let other = Net::new(&by.coefficients, by.v.len(), other_u, other_v);
        let coefficient = |row: usize, column: usize| {
            let (r, c) = (along_u.target(row), along_v.target(column));
            let mut sum = T::zero();
            for (s, t, share) in along_u.pairs(r) {
                for (k, l, part) in along_v.pairs(c) {
                    let (a, b) = (own.at(r.piece, s, c.piece, k), other.at(r.piece, t, c.piece, l));
                    sum = sum + a * (b * share * part);
                }
            }
            sum
        };
        let (rows, columns) = (along_u.space().len(), along_v.space().len());
        let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let all = all.map(|(row, column)| coefficient(row, column)).collect();
        Self::new(along_u.space().clone(), along_v.space().clone(), all)
    }

    /// This function plus `factor` times another, in spaces that have both.
    ///
    /// # Errors
    /// As for [`Function::plus`].
    pub fn plus(&self, factor: f64, other: &Self) -> Result<Self> {
        let (first, second) = self.in_common_spaces(other)?;
        let sum = first.coefficients.iter().zip(&second.coefficients).map(|(a, b)| *a + *b * factor);
        Self::new(first.u.clone(), first.v.clone(), sum.collect())
    }

    /// Both in spaces that have both.
    fn in_common_spaces(&self, other: &Self) -> Result<(Self, Self)> {
        let (mut first, mut second) = (self.clone(), other.clone());
        for direction in [Direction::U, Direction::V] {
            let (a, b) = (first.space(direction).clone(), second.space(direction).clone());
            if a == b {
                continue;
            }
            if a.domain() != b.domain() {
                return Err(Error::Invalid(format!(
                    "functions over [{}, {}] and over [{}, {}] cannot be added: restrict or reparametrise one of them",
                    a.domain().0,
                    a.domain().1,
                    b.domain().0,
                    b.domain().1
                )));
            }
            let common = a.common(&b)?;
            let step = |field: Self, steps: &[crate::spline::Conversion]| {
                steps.iter().try_fold(field, |field, step| field.along(direction, |line| line.convert(step)))
            };
            (first, second) = (step(first, &common.first)?, step(second, &common.second)?);
        }
        Ok((first, second))
    }

    /// `∫∫ f du dv` over the domain.
    ///
    /// # Errors
    /// When numbers overflow.
    pub fn total(&self) -> Result<T> {
        let (of_u, of_v) = (self.u.integrals(), self.v.integrals());
        let rows = self.coefficients.chunks_exact(self.v.len().max(1)).zip(of_u);
        let total = rows.fold(T::zero(), |sum, (row, w)| {
            sum + row.iter().zip(&of_v).fold(T::zero(), |sum, (c, w)| sum + *c * *w) * w
        });
        if total.is_finite() { Ok(total) } else { Err(Error::Invalid("an integral overflows".into())) }
    }

    /// A linear map of its values.
    ///
    /// # Errors
    /// When a coefficient becomes not finite.
    pub fn mapped<S: Coefficient>(&self, map: impl Fn(T) -> S) -> Result<Field<S>> {
        Field::new(self.u.clone(), self.v.clone(), self.coefficients.iter().map(|c| map(*c)).collect())
    }
}

impl Field<Vector> {
    /// The surface with these values as points.
    ///
    /// # Errors
    /// When a degree is 0, which no surface has.
    pub fn into_surface(self) -> Result<Surface> {
        Surface::new(self.u, self.v, self.coefficients.into_iter().map(Point::from).collect())
    }
}

impl Surface {
    /// The points of a polynomial surface as a function.
    ///
    /// # Errors
    /// When the surface is rational: it is no linear combination of B-splines.
    pub fn function(&self) -> Result<Field<Vector>> {
        if self.weights().is_some() {
            return Err(Error::Invalid(
                "a rational surface is a quotient of spline functions, not one: take its numerator and denominator apart"
                    .into(),
            ));
        }
        Field::new(self.u().clone(), self.v().clone(), self.points().iter().map(|p| p.coords).collect())
    }
}

/// The Bernstein coefficients of a function on all of its patches.
struct Net<T> {
    /// Orders in `u` and `v`.
    orders: [usize; 2],
    width: usize,
    coefficients: Vec<T>,
}

impl<T: Coefficient> Net<T> {
    fn new(coefficients: &[T], columns: usize, u: &Pieces, v: &Pieces) -> Self {
        let rows = coefficients.chunks_exact(columns.max(1));
        let along_v: Vec<Vec<T>> = rows.map(|row| v.coefficients(|j| row[j])).collect();
        let width = along_v.first().map_or(0, Vec::len);
        let columns: Vec<Vec<T>> = (0..width).map(|c| u.coefficients(|i| along_v[i][c])).collect();
        let height = columns.first().map_or(0, Vec::len);
        let all = (0..height).flat_map(|r| columns.iter().map(move |column| column[r])).collect();
        Self { orders: [u.order(), v.order()], width, coefficients: all }
    }

    fn at(&self, piece_u: u32, s: usize, piece_v: u32, t: usize) -> T {
        let (row, column) = (piece_u as usize * self.orders[0] + s, piece_v as usize * self.orders[1] + t);
        self.coefficients[row * self.width + column]
    }
}
