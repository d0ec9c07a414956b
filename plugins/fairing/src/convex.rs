//! The least energy between bounds: proximal steps, each a nearest point in the energy's own metric.
//!
//! `min E(x) + ‖x - c‖²_D` under equations and inequalities, `c` the last step's answer (Rockafellar 1976), `D` a millionth of a
//! millionth of every vertex's own stiffness. With `D` every motion has an energy, so that each step is a strictly convex
//! program, which the dual active-set method solves exactly; and energies that do not see some motions need no care. The first
//! step starts from the shape as it was: of several shapes of least energy it finds (nearly) the nearest. What `D` holds
//! back shrinks by about `10¹² (σ/σ_max)²` a step; two or three are enough where the energy's waves are not many thousands.

use loftsman_kernel::Vector;

use crate::active::{Failure, Nearest, Row, Space, nearest};
use crate::damped::Damped;
use crate::null_space::remove;
use crate::orthogonal::dot;
use crate::squares::Squares;

/// Least energy under rows.
pub(crate) struct Convex<'a> {
    pub(crate) squares: &'a Squares,
    pub(crate) damped: &'a Damped,
    /// Motions without energy, orthonormal.
    pub(crate) motions: &'a [Vec<f64>],
    pub(crate) rows: &'a [Row],
}

impl Convex<'_> {
    /// One step from a centre; `guess` are inequalities that are probably active.
    ///
    /// # Errors
    /// When the rows contradict each other, or it is too much work.
    pub(crate) fn step(&self, centre: &[Vector], guess: &[usize]) -> Result<Nearest, Failure> {
        let mut down = vec![Vector::zeros(); centre.len()];
        self.squares.gradient(centre, true, &mut down);
        for (vertex, g) in down.iter_mut().enumerate() {
            if self.damped.place(vertex).is_none() {
                *g = Vector::zeros();
            }
        }
        // A gradient has no part along motions without energy, but for rounding, which would be enlarged.
        remove(self.motions, &mut down);
        self.damped.solve(&mut down);
        let start: Vec<Vector> = centre.iter().zip(&down).map(|(c, d)| c - d).collect();
        nearest(self.rows, &Proximal { damped: self.damped, start }, centre.len(), guess)
    }
}

struct Proximal<'a> {
    damped: &'a Damped,
    start: Vec<Vector>,
}

impl Space for Proximal<'_> {
    fn whiten(&self, row: &Row) -> Vec<f64> {
        let count = self.damped.count();
        let mut white = vec![0.0; 3 * count];
        let mut used = [false; 3];
        for &(at, c) in &row.terms {
            if let Some(place) = self.damped.place(at / 3) {
                white[at % 3 * count + place] += c;
                used[at % 3] = true;
            }
        }
        let parts = white.chunks_exact_mut(count.max(1)).zip(used);
        parts.filter(|(_, used)| *used).for_each(|(part, _)| self.damped.forward(part));
        white
    }

    fn place(&self, v: &[f64], x: &mut [Vector]) {
        let count = self.damped.count();
        let mut moved = v.to_vec();
        for part in moved.chunks_exact_mut(count.max(1)).filter(|part| part.iter().any(|v| *v != 0.0)) {
            self.damped.backward(part);
        }
        x.copy_from_slice(&self.start);
        for (vertex, x) in x.iter_mut().enumerate() {
            if let Some(place) = self.damped.place(vertex) {
                *x += Vector::new(moved[place], moved[count + place], moved[2 * count + place]);
            }
        }
    }
}

/// Of the shapes `x + Σ y_k z_k` that meet the rows, the one nearest to `rest`: `z` are orthonormal motions that leave the energy
/// as it is.
///
/// # Errors
/// As for [`Convex::step`].
pub(crate) fn nearest_along(
    motions: &[Vec<Vector>],
    x: &[Vector],
    rest: &[Vector],
    rows: &[Row],
) -> Result<Nearest, Failure> {
    let mut start = x.to_vec();
    for motion in motions {
        let along: f64 = motion.iter().zip(rest.iter().zip(x)).map(|(m, (r, x))| m.dot(&(r - x))).sum();
        start.iter_mut().zip(motion).for_each(|(s, m)| *s += m * along);
    }
    nearest(rows, &Along { motions, start }, x.len(), &[])
}

struct Along<'a> {
    motions: &'a [Vec<Vector>],
    start: Vec<Vector>,
}

impl Space for Along<'_> {
    fn whiten(&self, row: &Row) -> Vec<f64> {
        let along = |m: &Vec<Vector>| row.terms.iter().map(|&(at, c)| c * m[at / 3][at % 3]).sum();
        let white: Vec<f64> = self.motions.iter().map(along).collect();
        // What is rounding beside the row itself is nothing.
        let length = row.terms.iter().map(|(_, c)| c * c).sum::<f64>().sqrt();
        if dot(&white, &white).sqrt() <= 1e-11 * length { vec![0.0; white.len()] } else { white }
    }

    fn place(&self, v: &[f64], x: &mut [Vector]) {
        x.copy_from_slice(&self.start);
        for (motion, v) in self.motions.iter().zip(v) {
            x.iter_mut().zip(motion).for_each(|(x, m)| *x += m * *v);
        }
    }
}
