//! How what is held curves along its shapes: what Newton's method at rest needs of it.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::shape::Derivative;

use super::Link;
use crate::constraint::Place;
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
    /// Adds how what it holds curves along its shapes; its parameters are numbered from `first` on. What is no derivative at a place counts as
    /// straight.
    pub(crate) fn curve(&self, shapes: &Shapes<'_>, first: usize, out: &mut Curving) -> Result<()> {
        let mut equations = self.multipliers.iter();
        for part in &self.parts {
            let count = part.value.len();
            let mut lambda = Vector::zeros();
            for k in (0..count).filter(|&k| count != 3 || self.axes[k]) {
                let multiplier = equations.next().copied().unwrap_or(0.0);
                if count == 3 {
                    lambda[k] = multiplier;
                }
            }
            for term in &part.terms {
                let Some((order, index)) = term.order.zip(term.place).filter(|(_, i)| self.places[*i].floats)
                else {
                    continue;
                };
                let Place { body, location, .. } = self.places[index];
                let own: usize =
                    self.places[..index].iter().filter(|p| p.floats).map(|p| p.location.parameters()).sum();
                let shape = shapes.get(body)?;
                for axis in 0..location.parameters() {
                    let pace = self.slides[own + axis].pace;
                    let (u, v) = if axis == 0 { (order + 1, 0) } else { (order, 1) };
                    let pull = lambda * (term.sign * pace);
                    let stencil = shape.stencil(location, Derivative { u, v })?;
                    let start = shapes.offset(body);
                    let entries = stencil.iter().map(|(i, c)| (start + i, first + own + axis, pull * c));
                    out.mixed.extend(entries);
                    for other in 0..=axis {
                        let (u, v) = if other == 0 { (u + 1, v) } else { (u, v + 1) };
                        let change = shape.value(location, Derivative { u, v })?;
                        let by = pull.dot(&change) * self.slides[own + other].pace;
                        out.twice.push((first + own + axis, first + own + other, by));
                    }
                }
            }
        }
        Ok(())
    }
}
