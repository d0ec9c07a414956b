//! Balances that are not stable: found by their second derivatives, and left.

use loftsman_kernel::Vector;

use super::descent::{MEET, ROUNDING, Start};
use super::equilibrium::{LARGEST, LEAST};
use super::tangent::{Tangent, dot};
use super::{Moving, Simulation};
use crate::error::Result;
use crate::stiffness::Part;

/// Steps of the search for the direction.
const SEARCHES: usize = 40;
/// A direction leads down where its frequency squared is below this share of the highest, negative.
pub(super) const FALLS: f64 = -1e-10;
/// So many lengths of a direction are tried to both sides.
const SIDES: usize = 6;
/// Differences of energies are more than rounding from this share of what they are made of.
const NOISE: f64 = 1e-13;
/// And by this share of what energies are made of, or more.
const DOWN: f64 = 1e-10;
/// And clearly so below this.
pub(super) const CLEARLY: f64 = -1e-9;
/// The lowest is known where Newton's matrix is positive definite with so many times what is asked as a shift.
const BOUND: f64 = 101.0;

/// What the second derivatives of the energy say, on what the constraints allow.
#[derive(Debug)]
pub(super) enum Lowest {
    /// They are not negative, to what is asked.
    Rises,
    /// The energy falls along this direction: by its frequency squared, as a share of the highest.
    Falls(f64, Vec<f64>),
    /// They are not negative, to what is asked, but along this direction they are: it may be rounding, or the highest, of a short span, is far above
    /// what bends. What the energy itself does there tells.
    Leans(Vec<f64>),
    /// It is not to be told.
    Unknown,
}

impl Simulation {
    /// Whether an unstable balance is left: not where nothing but tension and compression acts. What is slack without bending crumples at the
    /// scale of its vertices, which says nothing of the shape.
    pub(super) fn buckles(&self) -> bool {
        let bends = |body: &Moving| body.elastic.as_ref().is_some_and(|elastic| elastic.bend.is_some());
        self.gravity != Vector::zeros()
            || !self.loads.is_empty()
            || self.bodies.iter().any(bends)
            || self.applied.iter().any(|force| *force != 0.0)
    }

    /// Whether the energy falls along some direction that the constraints allow: by more than this share of the highest frequency squared,
    /// relative to the mass. Where Newton's matrix is positive definite (with what constraints hold counted in), it does not; where it is
    /// not, the lowest frequency is found by inverse iteration on what the constraints allow, and its Rayleigh quotient tells.
    pub(super) fn lowest(&mut self, tangent: &mut Tangent, below: f64) -> Result<Lowest> {
        if tangent.factor(self, Part::Whole, 0.0)? {
            return Ok(Lowest::Rises);
        }
        let highest = self.highest();
        // As little as is needed: iteration converges by how far the lowest stands off the next, measured from the shift.
        let mut shift = if below > CLEARLY { f64::EPSILON } else { LEAST } * highest;
        while !tangent.factor(self, Part::Whole, shift)? {
            shift *= 10.0;
            if shift > LARGEST * highest {
                return Ok(Lowest::Unknown);
            }
        }
        // A start with all frequencies in it, the same every time.
        let n = tangent.unknowns();
        let mut x: Vec<f64> =
            (0..n).map(|i| 1.0 + ((i * 7 + 3) % 11) as f64 / 11.0 - 2.0 * (i % 2) as f64).collect();
        let first = n - self.desk.parameters;
        x[first..].iter_mut().enumerate().filter(|(k, _)| tangent.stays(*k)).for_each(|(_, x)| *x = 0.0);
        let (mut weighed, mut lowest) = (Vec::new(), f64::NAN);
        for _ in 0..SEARCHES {
            tangent.weigh(&self.bodies, &x, &mut weighed);
            let size = dot(&x, &weighed).max(0.0).sqrt();
            if !(size > 0.0 && size.is_finite()) {
                return Ok(Lowest::Unknown);
            }
            x.iter_mut().zip(&mut weighed).for_each(|(x, w)| (*x, *w) = (*x / size, *w / size));
            let mut next = weighed.clone();
            let mut none = vec![0.0; self.desk.gap.len()];
            tangent.solve(&mut next, &mut none);
            lowest = 1.0 / dot(&next, &weighed) - shift;
            x = next;
        }
        Ok(match lowest / highest {
            share if share < below => Lowest::Falls(share, x),
            share if share < 0.0 && shift <= -BOUND * below * highest => Lowest::Leans(x),
            // A Rayleigh quotient is never below the lowest: that the matrix is positive definite with little more of a shift bounds it.
            share if share >= below && shift <= -BOUND * below * highest => Lowest::Rises,
            _ => Lowest::Unknown,
        })
    }

    /// Whether the energy falls to both sides of a direction, as a parabola does: a fall to one side is of the forces that are left, and one that is only
    /// far away of another place of rest.
    pub(super) fn falls_both_ways(
        &mut self,
        tangent: &mut Tangent,
        way: &[f64],
        start: &mut Start,
    ) -> Result<bool> {
        let n = tangent.unknowns();
        let most = way[..n - self.desk.parameters].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        if most <= 0.0 {
            return Ok(false);
        }
        start.remember(self);
        let (before, made_of) = self.potential();
        let mut by = 1e-2 * self.size / most;
        let mut falls = Vec::with_capacity(SIDES);
        for _ in 0..SIDES {
            let mut both = 0.0;
            for side in [by, -by] {
                self.go(tangent, way, side);
                self.meet(tangent)?;
                both += self.potential().0 - before;
                start.back(self);
            }
            falls.push(both);
            by *= 0.25;
        }
        self.recollect()?;
        // As a parabola does, a sixteenth for a quarter of the way, down to what rounding leaves.
        falls.retain(|fall| fall.abs() > NOISE * made_of);
        let is_parabola = |pair: &[f64]| (8.0..32.0).contains(&(pair[0] / pair[1]));
        Ok(falls.len() > 2 && falls.iter().all(|fall| *fall < 0.0) && falls[1..].windows(2).all(is_parabola))
    }

    /// Back to the constraints, by the least way as stiffness measures it.
    fn meet(&mut self, tangent: &mut Tangent) -> Result<()> {
        for _ in 0..MEET {
            self.recollect()?;
            let mut back = vec![0.0; tangent.unknowns()];
            let mut asked: Vec<f64> = self.desk.gap.iter().map(|gap| -gap).collect();
            tangent.solve(&mut back, &mut asked);
            self.go(tangent, &back, 1.0);
        }
        self.recollect()
    }

    /// On a saddle: along a direction in which the energy falls, as far as it does. Whether it falls by what energies show.
    pub(super) fn leave_saddle(
        &mut self,
        tangent: &mut Tangent,
        way: &[f64],
        left: &[f64],
        start: &mut Start,
    ) -> Result<bool> {
        let mut x = way.to_vec();
        let n = tangent.unknowns();
        if dot(&x, left) < 0.0 {
            x.iter_mut().for_each(|v| *v = -*v);
        }
        let most = x[..n - self.desk.parameters].iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        if most <= 0.0 {
            return Ok(false);
        }
        start.remember(self);
        let (before, made_of) = self.potential();
        let mut best: Option<(f64, f64)> = None;
        let mut by = 1e-3 * self.size / most;
        for _ in 0..40 {
            self.go(tangent, &x, by);
            self.meet(tangent)?;
            let (now, sizes) = self.potential();
            let met = self.desk.gap.iter().all(|gap| gap.abs() <= 1e-6 * self.size);
            let falls = met && now < before - 10.0 * ROUNDING * (made_of + sizes);
            // Shorter until it falls, then longer as long as it falls more.
            match best {
                None if falls => best = Some((by, now)),
                None => {}
                Some((_, least)) if falls && now < least => best = Some((by, now)),
                Some((last, least)) => {
                    start.back(self);
                    if least > before - DOWN * made_of {
                        break;
                    }
                    self.go(tangent, &x, last);
                    return Ok(true);
                }
            }
            start.back(self);
            by *= if best.is_some() { 2.0 } else { 0.5 };
        }
        self.recollect()?;
        Ok(false)
    }
}
