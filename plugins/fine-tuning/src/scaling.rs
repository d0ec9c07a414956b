//! What a surface's derivatives are scaled by.

use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};

use crate::alpha::{restricted, same};
use crate::error::{FineTuneError, Result};
use crate::lift::Alpha;
use crate::lines::{along, derivative_u, facing, index, name, turned};
use crate::patch::Region;
use crate::positive::check_positive;

/// What the derivatives of a surface are scaled by. Two different multiples of `S_u` and `S_v` are in general no derivatives of
/// any surface, so that there are three ways.
#[derive(Debug, Clone, PartialEq)]
pub enum Scaling {
    /// `(T_u S)(u, v) = S(u₀, v) + ∫ α(u) S_u du` and `T_v` with `β(v)`, either or both, which commute: exact. The derivative by
    /// `u` of `T_u S` is `α S_u`; that of `T_v T_u S` is `α` times the one of `T_v S`, so that with both each `u`-line keeps the
    /// tangents of that line of `T_v S`, and has its curvature divided by `α`.
    Directional {
        /// `α(u)`.
        u: Option<Function<f64>>,
        /// `β(v)`.
        v: Option<Function<f64>>,
    },
    /// `D(u, v) = S(u₀, v) + ∫ α(u, v) S_u du`: one direction, with another `α` on each of its lines; exact. Along `v` likewise.
    Along {
        /// The direction of the lines that are tuned.
        direction: Direction,
        /// `α(u, v)`, without jumps across that direction.
        alpha: Field<f64>,
    },
    /// Both derivatives as nearly as can be: `min ∫∫ |D_u - αS_u|² + |D_v - βS_v|²`.
    Both {
        /// `α(u, v)`, for the derivative by `u`.
        u: Field<f64>,
        /// `β(u, v)`, for the derivative by `v`; often the same.
        v: Field<f64>,
    },
}

impl Scaling {
    /// Along `u` by `α(u)`.
    pub fn u(alpha: Function<f64>) -> Self {
        Self::Directional { u: Some(alpha), v: None }
    }

    /// Along `v` by `β(v)`.
    pub fn v(beta: Function<f64>) -> Self {
        Self::Directional { u: None, v: Some(beta) }
    }

    /// Along `u` by `α(u)` and along `v` by `β(v)`.
    pub fn u_and_v(alpha: Function<f64>, beta: Function<f64>) -> Self {
        Self::Directional { u: Some(alpha), v: Some(beta) }
    }

    /// Along one direction by `α(u, v)`.
    pub fn along(direction: Direction, alpha: Field<f64>) -> Self {
        Self::Along { direction, alpha }
    }

    /// Both derivatives by one `α(u, v)`.
    pub fn both(alpha: Field<f64>) -> Self {
        Self::Both { u: alpha.clone(), v: alpha }
    }

    /// Its α for one direction, as a function of that direction's parameter first.
    pub(crate) fn of(&self, direction: Direction) -> Result<Option<Alpha>> {
        Ok(match self {
            Self::Directional { u, v } => [u, v][index(direction)].clone().map(Alpha::Line),
            Self::Along { direction: own, alpha } => {
                if *own == direction {
                    Some(Alpha::Net(facing(alpha, direction)?))
                } else {
                    None
                }
            }
            Self::Both { u, v } => Some(Alpha::Net(facing([u, v][index(direction)], direction)?)),
        })
    }

    /// With another α for one direction.
    pub(crate) fn with(self, direction: Direction, changed: Alpha) -> Result<Self> {
        Ok(match (self, changed) {
            (Self::Directional { u, v }, Alpha::Line(line)) => match direction {
                Direction::U => Self::Directional { u: Some(line), v },
                Direction::V => Self::Directional { u, v: Some(line) },
            },
            (Self::Along { direction, .. }, Alpha::Net(net)) => {
                Self::Along { direction, alpha: facing(&net, direction)? }
            }
            (same, _) => same,
        })
    }

    /// Refuses α that is not positive everywhere.
    pub(crate) fn check_positive(&self) -> Result<()> {
        for direction in [Direction::U, Direction::V] {
            match self.of(direction)? {
                Some(Alpha::Net(net)) => check_positive(&Alpha::Net(facing(&net, direction)?))?,
                Some(line) => check_positive(&line)?,
                None => {}
            }
        }
        Ok(())
    }

    /// On a region.
    pub(crate) fn restricted(&self, region: &Region) -> Result<Self> {
        let line = |f: &Function<f64>, direction| match region[index(direction)] {
            Some((a, b)) => restricted(f, a, b),
            None => Ok(f.clone()),
        };
        let net = |f: &Field<f64>| {
            let f = along(f, Direction::U, |l| line(&l, Direction::U))?;
            along(&f, Direction::V, |l| line(&l, Direction::V))
        };
        Ok(match self {
            Self::Directional { u, v } => Self::Directional {
                u: u.as_ref().map(|f| line(f, Direction::U)).transpose()?,
                v: v.as_ref().map(|f| line(f, Direction::V)).transpose()?,
            },
            Self::Along { direction, alpha } => Self::Along { direction: *direction, alpha: net(alpha)? },
            Self::Both { u, v } => Self::Both { u: net(u)?, v: net(v)? },
        })
    }

    /// Refuses functions over another domain than the surface's.
    pub(crate) fn check_domains(&self, surface: &Surface) -> Result<()> {
        let check = |space: &Space, direction: Direction| {
            let (own, wanted) = (space.domain(), surface.space(direction).domain());
            if own == wanted {
                return Ok(());
            }
            Err(FineTuneError::Contradiction(format!(
                "α is given over {} in [{}, {}], and what is tuned is over [{}, {}]: give it over the same domain",
                name(direction),
                own.0,
                own.1,
                wanted.0,
                wanted.1
            )))
        };
        let both =
            |f: &Field<f64>| [Direction::U, Direction::V].into_iter().try_for_each(|d| check(f.space(d), d));
        match self {
            Self::Directional { u, v } => {
                u.iter().try_for_each(|f| check(f.space(), Direction::U))?;
                v.iter().try_for_each(|f| check(f.space(), Direction::V))
            }
            Self::Along { alpha, .. } => both(alpha),
            Self::Both { u, v } => both(u).and_then(|()| both(v)),
        }
    }
}

/// The spaces in which α is given by its values alone: those of the derivatives by `u` and by `v`, degrees `p - 1` and `q - 1` on
/// the surface's knots. `O(n)`.
///
/// # Errors
/// When the surface is rational, or torn.
pub fn surface_alpha_spaces(surface: &Surface) -> Result<[Space; 2]> {
    let given = match surface.weights() {
        None => surface.function()?,
        Some(weights) if same(weights) => {
            Surface::new(surface.u().clone(), surface.v().clone(), surface.points().to_vec())?.function()?
        }
        Some(_) => return Err(FineTuneError::Rational { what: "surface" }),
    };
    let of = |field: Field<_>| -> Result<Space> { Ok(derivative_u(&field)?.space(Direction::U).clone()) };
    Ok([of(given.clone())?, of(turned(&given)?)?])
}

/// `α(u, v)` with these values in the [spaces](surface_alpha_spaces) of a surface's derivatives, along `v` first.
///
/// # Errors
/// When there are not as many values; as for [`surface_alpha_spaces`].
pub fn surface_alpha_of(surface: &Surface, values: Vec<f64>) -> Result<Field<f64>> {
    let [u, v] = surface_alpha_spaces(surface)?;
    if Some(values.len()) != u.len().checked_mul(v.len()) {
        return Err(FineTuneError::Contradiction(format!(
            "α(u, v) has {} values and needs {} × {}: one for each pair of B-splines of degrees {} and {} on the knots of the \
             derivatives; other knots are given as {{ degree, knots, values }}",
            values.len(),
            u.len(),
            v.len(),
            u.degree(),
            v.degree()
        )));
    }
    Ok(Field::new(u, v, values)?)
}
