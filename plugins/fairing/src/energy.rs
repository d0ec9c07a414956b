//! What is to be small: energies, and weighted sums of them.

use std::ops::{Add, Mul};

use loftsman_kernel::Point;
use loftsman_kernel::shape::Location;

/// A weighted sum of energies, each a square that depends on the control vertices only:
///
/// | | curve | surface |
/// |---|---|---|
/// | [`stretch`] | `∫ \|C'\|² du` | membrane, `∫∫ \|S_u\|² + \|S_v\|²` |
/// | [`bend`] | `∫ \|C''\|² du` | thin plate, `∫∫ \|S_uu\|² + 2\|S_uv\|² + \|S_vv\|²` |
/// | [`variation`] | `∫ \|C'''\|² du` | `∫∫ \|S_uuu\|² + 3\|S_uuv\|² + 3\|S_uvv\|² + \|S_vvv\|²` |
/// | [`near`] | `∫ \|C - C₀\|² du` | `∫∫ \|S - S₀\|²`, `C₀` and `S₀` as they were |
/// | [`data`] | `Σ w_k \|C(u_k) - Q_k\|²` | the same |
///
/// Integrals are over the shape's own parameters: on a domain twice as long, the same curve has an eighth of the bending
/// energy. That matters for sums only. Round extraordinary vertices of subdivision surfaces, where the parameters are not smooth and the
/// surface is, stretch and bend are taken by the coordinates of the characteristic map
/// ([`Cells::chart`](loftsman_kernel::shape::Cells::chart)): so they are finite, and a plane does not bend however its net lies in
/// it. The variation has no finite value there; it is taken by the parameters, as deep as the surface's cells go, and the report says so. Rational shapes have their weights fixed, and the energy is that of the rational
/// shape itself, whose points depend linearly on the control vertices as those of any other.
///
/// ```
/// use loftsman_fairing::{bend, stretch};
/// let energy = bend() + 0.1 * stretch();
/// assert_eq!(energy.to_string(), "bend + 0.1 stretch");
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnergySum {
    pub(crate) terms: Vec<(f64, Term)>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Term {
    /// The derivatives of this order.
    Derivative(usize),
    Near,
    Data(Vec<Datum>),
}

/// A place that a shape should be near to, with the weight of its squared distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Datum {
    /// Where on the shape.
    pub at: Location,
    /// What it should be near to.
    pub to: Point,
    /// Its weight, positive.
    pub weight: f64,
}

/// `∫ |C'|²`; of a surface the membrane energy.
pub fn stretch() -> EnergySum {
    one(Term::Derivative(1))
}

/// `∫ |C''|²`; of a surface the thin plate's.
pub fn bend() -> EnergySum {
    one(Term::Derivative(2))
}

/// `∫ |C'''|²`: how much the bending varies.
pub fn variation() -> EnergySum {
    one(Term::Derivative(3))
}

/// `∫ |C - C₀|²`: how far it went from the shape as it was.
pub fn near() -> EnergySum {
    one(Term::Near)
}

/// `Σ w_k |C(u_k) - Q_k|²`: how far it passes from given points.
pub fn data(points: impl IntoIterator<Item = Datum>) -> EnergySum {
    one(Term::Data(points.into_iter().collect()))
}

fn one(term: Term) -> EnergySum {
    EnergySum { terms: vec![(1.0, term)] }
}

impl Add for EnergySum {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.terms.extend(other.terms);
        self
    }
}

impl Mul<EnergySum> for f64 {
    type Output = EnergySum;

    fn mul(self, mut energy: EnergySum) -> EnergySum {
        energy.terms.iter_mut().for_each(|(weight, _)| *weight *= self);
        energy
    }
}

impl std::fmt::Display for EnergySum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, (weight, term)) in self.terms.iter().enumerate() {
            if i > 0 {
                write!(f, " + ")?;
            }
            if weight.to_bits() != 1.0_f64.to_bits() {
                write!(f, "{weight} ")?;
            }
            match term {
                Term::Derivative(1) => write!(f, "stretch"),
                Term::Derivative(2) => write!(f, "bend"),
                Term::Derivative(_) => write!(f, "variation"),
                Term::Near => write!(f, "near"),
                Term::Data(points) => write!(f, "data ({} points)", points.len()),
            }?;
        }
        Ok(())
    }
}
