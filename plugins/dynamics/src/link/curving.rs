//! How what is held curves along its shapes: what Newton's method at rest needs of it.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{Equation, Shapes, Store};
use loftsman_kernel::shape::Derivative;
use smallvec::SmallVec;

use super::Link;
use crate::error::Result;

/// How what is held curves as places float, weighed by the multipliers: second derivatives of `λᵀg`.
#[derive(Debug, Default)]
pub(crate) struct Curving {
    /// `∂²(λᵀg)/∂q∂s`: vertex, parameter, a number for each axis.
    pub(crate) mixed: Vec<(usize, usize, Vector)>,
    /// `∂²(λᵀg)/∂s²`: a pair of parameters, the second no later than the first.
    pub(crate) twice: Vec<(usize, usize, f64)>,
}

impl Link {
    /// Adds how what it holds curves along its shapes; its parameters are numbered from `first` on.
    pub(crate) fn curve(&self, shapes: &Shapes<'_>, first: usize, out: &mut Curving) -> Result<()> {
        let mut multipliers = self.multipliers.iter();
        let (mut store, mut change) = (Store::default(), Vec::new());
        for part in &self.parts {
            let count = part.value.len();
            let asked = |k: usize| count != 3 || self.axes[k];
            let lambda: SmallVec<[f64; 3]> = (0..count)
                .map(|k| if asked(k) { multipliers.next().copied().unwrap_or(0.0) } else { 0.0 })
                .collect();
            for term in &part.terms {
                let Some(index) = term.place.filter(|index| self.places[*index].floats) else { continue };
                let location = self.places[index].location;
                let own: usize =
                    self.places[..index].iter().filter(|p| p.floats).map(|p| p.location.parameters()).sum();
                for axis in 0..location.parameters() {
                    let by = term.sign * self.slides[own + axis].pace;
                    let (u, v) = if axis == 0 { (1, 0) } else { (0, 1) };
                    store.clear();
                    term.functional.along_rows(shapes, Derivative { u, v }, &mut store.rows(shapes))?;
                    let mut mixed = |vertex: usize, pull: Vector| {
                        out.mixed.push((vertex, first + own + axis, pull * by));
                    };
                    let mut k = 0;
                    for equation in store.equations() {
                        match equation {
                            Equation::Alike { vertices, coefficients, .. } => {
                                let pull =
                                    Vector::from_fn(|axis, _| lambda.get(k + axis).copied().unwrap_or(0.0));
                                vertices.iter().zip(coefficients).for_each(|(v, c)| mixed(*v, pull * *c));
                                k += 3;
                            }
                            Equation::Coupled { vertices, vectors, .. } => {
                                let pull = lambda.get(k).copied().unwrap_or(0.0);
                                vertices.iter().zip(vectors).for_each(|(v, a)| mixed(*v, a * pull));
                                k += 1;
                            }
                        }
                    }
                    for other in 0..=axis {
                        let (u, v) = if other == 0 { (u + 1, v) } else { (u, v + 1) };
                        change.clear();
                        change.resize(count, 0.0);
                        term.functional.along(shapes, Derivative { u, v }, &mut change)?;
                        let pull: f64 = lambda.iter().zip(&change).map(|(l, c)| l * c).sum();
                        let twice = pull * by * self.slides[own + other].pace;
                        out.twice.push((first + own + axis, first + own + other, twice));
                    }
                }
            }
        }
        Ok(())
    }
}
