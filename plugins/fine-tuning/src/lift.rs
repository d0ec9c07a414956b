//! `T S = S(u₀, v) + ∫ α S_u du`: one direction of a surface scaled.

use loftsman_kernel::shape::Side;
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::text::short;
use loftsman_kernel::{Point, Vector};

use crate::alpha::{check_degree, extremes};
use crate::error::{FineTuneError, Result};
use crate::lines::{along_u, closed_u, derivative_u, size, start_row, turned};

/// A place of α: parameters (the second counts for nets only), and from which side each is looked at.
pub(crate) type Place = ((f64, f64), [Side; 2]);

/// α along `u`: of that parameter, or of both.
#[derive(Debug, Clone)]
pub(crate) enum Alpha {
    Line(Function<f64>),
    Net(Field<f64>),
}

impl Alpha {
    pub(crate) fn along(&self) -> &Space {
        match self {
            Self::Line(line) => line.space(),
            Self::Net(net) => net.space(Direction::U),
        }
    }

    /// The space of the other parameter, where it is a function of that, too.
    pub(crate) fn across(&self) -> Option<&Space> {
        match self {
            Self::Line(_) => None,
            Self::Net(net) => Some(net.space(Direction::V)),
        }
    }

    /// How many values it has across: 1 for a function of one parameter.
    pub(crate) fn columns(&self) -> usize {
        match self {
            Self::Line(_) => 1,
            Self::Net(net) => net.space(Direction::V).len(),
        }
    }

    pub(crate) fn values(&self) -> &[f64] {
        match self {
            Self::Line(line) => line.coefficients(),
            Self::Net(net) => net.coefficients(),
        }
    }

    /// The smallest and the largest value, as [`extremes`] finds them; of steps those of the values.
    pub(crate) fn extremes(&self) -> Result<[f64; 2]> {
        match self {
            Self::Line(line) => extremes(line),
            Self::Net(net) => {
                let (u, v) = (net.space(Direction::U), net.space(Direction::V));
                if u.degree() == 0 || v.degree() == 0 {
                    let most = |m: [f64; 2], c: &f64| [m[0].min(*c), m[1].max(*c)];
                    return Ok(net.coefficients().iter().fold([f64::INFINITY, f64::NEG_INFINITY], most));
                }
                let points = net.coefficients().iter().map(|c| Point::new(*c, 0.0, 0.0)).collect();
                let (low, high) = Surface::new(u.clone(), v.clone(), points)?.bounds();
                Ok([low.x, high.x])
            }
        }
    }

    /// What the function has of each of its values at a place.
    ///
    /// # Errors
    /// When the place is outside.
    pub(crate) fn row(&self, ((u, v), sides): Place) -> Result<Vec<(usize, f64)>> {
        let of = |space: &Space, at: f64, side: Side| -> Result<Vec<(usize, f64)>> {
            let (span, at) = space.span_on(space.locate(at)?, side);
            let p = space.degree();
            let mut row = vec![0.0; p + 1];
            space.basis_into(span, at, 0, &mut row);
            Ok(row.into_iter().enumerate().map(|(i, c)| (space.vertex(span - p + i), c)).collect())
        };
        let along = of(self.along(), u, sides[0])?;
        let Self::Net(net) = self else { return Ok(along) };
        let (space, across) = (net.space(Direction::V), of(net.space(Direction::V), v, sides[1])?);
        let row = |(i, a): &(usize, f64)| {
            let (i, a) = (*i, *a);
            across.iter().map(move |(j, b)| (i * space.len() + j, a * b))
        };
        Ok(along.iter().flat_map(row).collect())
    }

    /// Its value at a place.
    ///
    /// # Errors
    /// When the place is outside.
    pub(crate) fn at(&self, place: &Place) -> Result<f64> {
        let values = self.values();
        Ok(self.row(*place)?.into_iter().map(|(k, c)| c * values[k]).sum())
    }

    /// The same space, other values.
    pub(crate) fn with(&self, values: Vec<f64>) -> Result<Self> {
        Ok(match self {
            Self::Line(line) => Self::Line(Function::new(line.space().clone(), values)?),
            Self::Net(net) => Self::Net(Field::new(
                net.space(Direction::U).clone(),
                net.space(Direction::V).clone(),
                values,
            )?),
        })
    }

    pub(crate) fn one(&self) -> Result<Self> {
        self.with(vec![1.0; self.values().len()])
    }

    /// Clamped along `u` and, for a net where that is asked, along `v`: so that its first values are those at an end.
    pub(crate) fn clamped(self, u: bool, v: bool) -> Result<Self> {
        let open = |line: Function<f64>| {
            if line.space().is_clamped() && !line.space().is_periodic() {
                Ok(line)
            } else {
                Ok(line.opened()?)
            }
        };
        Ok(match self {
            Self::Line(line) if u => Self::Line(open(line)?),
            Self::Net(net) => {
                let net = if u { along_u(&net, open)? } else { net };
                Self::Net(if v { turned(&along_u(&turned(&net)?, open)?)? } else { net })
            }
            line @ Self::Line(_) => line,
        })
    }
}

/// `S(u₀, v) + ∫ α S_u du`, exactly; where `closes` says so, of a surface closed along `u` a closed one again. A surface that is
/// closed along `v` stays so.
///
/// # Errors
/// When a degree would be above 25, the domains differ, α jumps across `u`, or what should close does not.
pub(crate) fn lifted(
    given: &Field<Vector>,
    alpha: &Alpha,
    closes: bool,
    names: [&str; 2],
) -> Result<Field<Vector>> {
    let derivative = derivative_u(given)?;
    check_degree(derivative.space(Direction::U), alpha.along())?;
    let start = start_row(given)?;
    let (integrand, start) = match alpha {
        Alpha::Line(line) => (derivative.times_along(Direction::U, line)?, start),
        Alpha::Net(net) => {
            let v = net.space(Direction::V);
            (derivative.times(net)?, start.times(&Function::constant(v.clone(), 1.0)?)?)
        }
    };
    check_torn(integrand.space(Direction::V), names[1])?;
    let own = integrand.space(Direction::U);
    let lifted = if closes && own.is_periodic() {
        closed_integral(&integrand, &start)?
    } else {
        let open = plus_row(&integrand.integral(Direction::U)?, &start, 1.0)?;
        if closes { closed_u(&open, names[0])? } else { open }
    };
    if given.space(Direction::V).is_periodic() && !lifted.space(Direction::V).is_periodic() {
        return turned(&closed_u(&turned(&lifted)?, names[1])?);
    }
    Ok(lifted)
}

/// Refuses functions that jump inside their domain.
fn check_torn(space: &Space, name: &str) -> Result<()> {
    let breakpoints = space.breakpoints();
    let inner = breakpoints.get(1..breakpoints.len().saturating_sub(1)).unwrap_or_default();
    match inner.iter().find(|t| space.multiplicity(**t) > space.degree()) {
        Some(t) => Err(FineTuneError::Contradiction(format!(
            "α jumps at {name} = {t}, and the surface would be torn there: give α degree 1 or more along {name}, and no knot more \
             often than the degree"
        ))),
        None => Ok(()),
    }
}

/// A function of `v` added to every row.
fn plus_row(field: &Field<Vector>, row: &Function<Vector>, factor: f64) -> Result<Field<Vector>> {
    let (u, v) = (field.space(Direction::U), field.space(Direction::V));
    let each =
        field.coefficients().iter().zip(row.coefficients().iter().cycle()).map(|(c, r)| c + r * factor);
    Ok(Field::new(u.clone(), v.clone(), each.collect())?)
}

/// The antiderivative of a function that is periodic along `u`, periodic itself, with the values `start` at its seam. What is
/// left of the integral over a period is rounding, or refused.
fn closed_integral(integrand: &Field<Vector>, start: &Function<Vector>) -> Result<Field<Vector>> {
    let (u, v) = (integrand.space(Direction::U), integrand.space(Direction::V));
    let space = Space::periodic(u.degree() + 1, u.knots().to_vec())?;
    let (p, t, n) = (space.degree(), space.flat(), v.len());
    let mut all = Vec::with_capacity(integrand.coefficients().len());
    let (mut sums, mut lost) = (vec![Vector::zeros(); n], vec![Vector::zeros(); n]);
    for (i, row) in integrand.coefficients().chunks_exact(n).enumerate() {
        let share = (t[i + 2 * p] - t[i + p]) / p as f64;
        for ((c, sum), lost) in row.iter().zip(&mut sums).zip(&mut lost) {
            let part = c * share - *lost;
            let next = *sum + part;
            *lost = (next - *sum) - part;
            *sum = next;
        }
        all.extend_from_slice(&sums);
    }
    let closed = Field::new(space, v.clone(), all)?;
    let gap = sums.iter().fold(0.0_f64, |m, s| m.max(s.amax()));
    let extent = start.coefficients().iter().fold(size(&closed), |m, c| m.max(c.amax()));
    if gap > 1e-9 * extent {
        return Err(FineTuneError::Contradiction(format!(
            "the scaled derivatives of the closed surface leave a gap of {gap}: let α be changed (ends = \"exact\"), or open it \
             (ends = \"free\")",
            gap = short(gap)
        )));
    }
    plus_row(&plus_row(&closed, &start_row(&closed)?, -1.0)?, start, 1.0)
}
