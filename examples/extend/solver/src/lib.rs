//! A solver of one's own: the textbook formula, with the Cholesky factor that the kernel offers.

use loftsman_kernel::solve::{Diagnosis, EnvelopeCholesky, Factored, SolveError, Solver, System};

/// `d = Fᵀ (F Fᵀ)⁻¹ b`, for independent rows; others are refused with a better name. Metrics are taken out before.
#[derive(Debug, Clone, Copy, Default)]
pub struct Textbook;

/// The system, the lengths of its rows, and the factor of the Gram matrix of rows of unit length.
struct FactoredTextbook(System, Vec<f64>, EnvelopeCholesky);

impl Solver for Textbook {
    fn name(&self) -> &'static str {
        "textbook"
    }

    fn factor_minimum_norm(&self, system: &System) -> Result<Box<dyn Factored>, SolveError> {
        let rows = system.rows();
        let lengths: Vec<f64> = (0..rows.len()).map(|row| rows.norm(row)).collect();
        let cosine = |i: usize, j: usize| rows.dot(i, j) / lengths[i] / lengths[j];
        let gram = EnvelopeCholesky::factor(vec![0; rows.len()], 1e-8, cosine);
        match gram {
            // Small pivots are not all that makes rows dependent: the condition says whether the factor means anything.
            Ok(gram) if gram.condition() < 1e6 => {
                Ok(Box::new(FactoredTextbook(system.clone(), lengths, gram)))
            }
            _ => {
                let (solver, better) = (self.name().to_owned(), "householder-qr");
                Err(SolveError::IllConditioned { solver, condition: f64::NAN, better })
            }
        }
    }
}

impl Factored for FactoredTextbook {
    fn solver(&self) -> &'static str {
        "textbook"
    }

    fn rank(&self) -> usize {
        self.0.rows().len()
    }

    fn diagnosis(&self) -> Diagnosis {
        Diagnosis { rank: self.rank(), condition: self.2.condition().sqrt(), dependencies: Vec::new() }
    }

    fn solve_into(&mut self, rhs: &[f64], d: &mut [f64]) {
        let (mut multipliers, sides) = (rhs.to_vec(), self.0.sides());
        self.multipliers_into(rhs, &mut multipliers);
        d.fill(0.0);
        for (row, values) in multipliers.chunks_exact(sides).enumerate() {
            for (column, f) in self.0.rows().iter_row(row) {
                d[column * sides..].iter_mut().zip(values).for_each(|(d, v)| *d += f * v);
            }
        }
    }

    fn multipliers_into(&mut self, rhs: &[f64], multipliers: &mut [f64]) {
        let sides = self.0.sides();
        let scale = |numbers: &mut [f64], lengths: &[f64]| {
            let rows = numbers.chunks_exact_mut(sides).zip(lengths);
            rows.for_each(|(row, length)| row.iter_mut().for_each(|v| *v /= length));
        };
        multipliers.copy_from_slice(rhs);
        scale(multipliers, &self.1);
        self.2.solve(multipliers, sides);
        scale(multipliers, &self.1);
    }
}
