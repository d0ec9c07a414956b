//! Downhill by Newton's method within a trust region, its steps by conjugate gradients, so that no matrix is made (Steihaug 1983).

use super::super::Session;
use super::super::sequential::Linearized;
use super::squares::{Place, add_rows, amax, dot};
use super::{LEAST, Search, TAKEN};
use crate::problem::bound::right_hand_side;
use crate::problem::{EditError, Numbers, view};
use crate::shape::Shape;

/// Newton's steps at each share of the adjustment, and the products of each.
const STEPS: usize = 60;
const PRODUCTS: usize = 400;
/// Differences of gradients are taken over this share of the shapes' size: central ones, whose error is its square and the rounding of one over it.
const DIFFERENCE: f64 = 1e-5;

/// The sum and its slope at a place.
pub(super) struct Downhill {
    pub(super) value: f64,
    pub(super) down: Place,
    /// Of the rows in it.
    pub(super) factors: Vec<f64>,
    pub(super) noise: f64,
}

impl<S: Shape> Session<S> {
    /// The sum and its slope `∇/‖·‖` where the search is: `W⁻¹∇` and `∇`.
    pub(super) fn slope(search: &mut Search, here: &Linearized) -> Result<Downhill, EditError> {
        let pull = search.squares.share * search.squares.largest;
        let way = search.at.plus(-1.0, &search.from);
        let factors = search.squares.factors(&here.rhs);
        let mut slope: Vec<f64> = way.dual.iter().map(|w| pull * w).collect();
        add_rows(here.assembly.system.rows(), search.squares.sides, &factors, &mut slope);
        let down = Place { d: search.squares.raise(&slope), dual: slope };
        let half = search.squares.half(&here.rhs);
        let value = half + 0.5 * pull * way.square();
        let sides = search.squares.sides;
        let sizes =
            here.size.iter().enumerate().map(|(entry, size)| search.squares.weights[entry / sides] * size);
        let rounding = sizes.fold(0.0, f64::max);
        // `‖Jᵀm‖ ≤ √λ ‖m‖`; what a miss of rounding would pull is none.
        let root = search.squares.largest.sqrt();
        let most = root * (2.0 * half).sqrt() + pull * way.square().sqrt() + 1e-4 * root * rounding;
        search.slope = if most > 0.0 { down.square().sqrt() / most } else { 0.0 };
        if !(search.slope.is_finite() && value.is_finite()) {
            return Err(crate::problem::solution::overflow());
        }
        // Less than the sum's own rounding is neither gained nor lost.
        let noise = 1e-12 * value + 1e-16 * rounding * rounding;
        Ok(Downhill { value, down, factors, noise })
    }

    /// Newton's method with a trust region, until the slope is `slight`; at the end of the path, where that does not arrive, slower.
    pub(super) fn descend_squares(&mut self, search: &mut Search, slight: f64) -> Result<(), EditError> {
        let mut here = self.linearize_at(&search.at)?;
        search.looks += 2;
        search.squares.weigh(here.assembly.system.rows());
        let mut downhill = Self::slope(search, &here)?;
        // Ten times as far as the stiffest row would send it, or a part of the way that it has come.
        let mut radius =
            10.0 * downhill.down.square().sqrt() / search.squares.largest + 0.1 * search.at.square().sqrt();
        for _ in 0..STEPS {
            if search.slope <= slight || search.squares.largest == 0.0 {
                return Ok(());
            }
            if search.looks >= search.most {
                return if search.is_enough() { Ok(()) } else { Err(self.not_least(search).into()) };
            }
            let (step, promised) = self.newton(search, &here, &downhill.factors, &downhill.down, radius)?;
            search.steps += 1;
            let (before, length) = (search.at.clone(), step.square().sqrt());
            search.at = before.plus(1.0, &step);
            let near = promised <= 1e3 * downhill.noise;
            let reached =
                if near { Some(downhill.value) } else { self.squares_at(search, &here, &search.at.clone()) };
            search.looks += 1;
            let gained = reached.map_or(f64::NEG_INFINITY, |reached| downhill.value - reached);
            if !near && gained < 0.1 * promised {
                search.at = before;
                search.shortened += 1;
                radius = 0.25 * length.min(radius);
                if radius <= 1e-12 * (search.at.square().sqrt() + length) {
                    break;
                }
                continue;
            }
            if gained >= 0.75 * promised && length >= 0.9 * radius {
                radius *= 4.0;
            }
            let sloped = search.slope;
            let there = self.linearize_at(&search.at)?;
            search.looks += 2;
            search.squares.weigh(there.assembly.system.rows());
            let next = Self::slope(search, &there)?;
            // Where the sum is rounding, the slope tells.
            if near && search.slope > 0.5 * sloped {
                search.at = before;
                search.slope = sloped;
                break;
            }
            (here, downhill) = (there, next);
        }
        if slight > LEAST || search.slope <= TAKEN {
            return Ok(());
        }
        self.creep(search)?;
        if search.slope <= LEAST {
            return Ok(());
        }
        if search.looks >= search.most && !search.is_enough() {
            return Err(self.not_least(search).into());
        }
        search.settled = true;
        Ok(())
    }

    /// The sum where an adjustment leads; nothing where something cannot be asked there.
    fn squares_at(&mut self, search: &Search, here: &Linearized, at: &Place) -> Option<f64> {
        self.prepared.d.copy_from_slice(&at.d);
        if !self.place() {
            return None;
        }
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        let shapes = view(&self.problem.shapes);
        right_hand_side(&shapes, &self.problem.bound, &here.assembly, &mut rhs, &mut size).ok()?;
        let way = at.plus(-1.0, &search.from);
        let value =
            search.squares.half(&rhs) + 0.5 * search.squares.share * search.squares.largest * way.square();
        value.is_finite().then_some(value)
    }

    /// A step of Newton's method within a radius, by conjugate gradients, and what it promises.
    fn newton(
        &mut self,
        search: &mut Search,
        here: &Linearized,
        factors: &[f64],
        down: &Place,
        radius: f64,
    ) -> Result<(Place, f64), EditError> {
        let mut step = Place::zero(down.d.len());
        let (mut promised, mut left) = (0.0, down.times(-1.0));
        let mut way = left.clone();
        let first = left.square();
        let slight = search.slope.sqrt().clamp(1e-6, 0.1);
        let mut square = first;
        for _ in 0..PRODUCTS {
            let bent = self.product(search, here, factors, &way);
            let curvature = dot(&way.d, &bent);
            let whole = square / curvature;
            // How far it is along the way to the edge: |s + t p|² = r².
            let (a, b, c) = (way.square(), step.with(&way), step.square() - radius * radius);
            let edge = (-b + (b * b - a * c).max(0.0).sqrt()) / a.max(f64::MIN_POSITIVE);
            let share = if curvature > 0.0 && whole < edge { whole } else { edge };
            let along = dot(&left.dual, &way.d);
            promised += share * along - 0.5 * share * share * curvature;
            step = step.plus(share, &way);
            if share == edge {
                break;
            }
            left.dual.iter_mut().zip(&bent).for_each(|(l, b)| *l -= share * b);
            left.d = search.squares.raise(&left.dual);
            let next = left.square();
            if next <= slight * slight * first || next.is_nan() || search.looks >= search.most {
                break;
            }
            way = left.plus(next / square, &way);
            square = next;
        }
        Ok((step, promised))
    }

    /// The Hessian times a way.
    fn product(&mut self, search: &mut Search, here: &Linearized, factors: &[f64], way: &Place) -> Vec<f64> {
        let squares = &search.squares;
        let (rows, sides) = (here.assembly.system.rows(), squares.sides);
        let mut bent: Vec<f64> = way.dual.iter().map(|w| squares.share * squares.largest * w).collect();
        let mut along = vec![0.0; here.rhs.len()];
        rows.multiply(&way.d, sides, &mut along);
        for (entry, along) in along.iter_mut().enumerate() {
            let weight = squares.weights[entry / sides];
            let stiff = squares.pull(entry, here.rhs[entry]).map_or(0.0, |(stiff, _)| stiff);
            *along *= stiff * weight * weight;
        }
        add_rows(rows, sides, &along, &mut bent);
        let curved: Vec<f64> = (factors.iter().enumerate())
            .map(|(entry, factor)| if squares.curved[entry / sides] { *factor } else { 0.0 })
            .collect();
        if curved.iter().all(|factor| *factor == 0.0) {
            return bent;
        }
        let far = amax(&way.d);
        let by = DIFFERENCE * (self.prepared.check.reach + amax(&search.at.d)) / far;
        if !(by.is_finite() && by > 0.0) {
            return bent;
        }
        let mut bow = vec![0.0; bent.len()];
        for sign in [1.0, -1.0] {
            search.looks += 2;
            self.prepared.d.copy_from_slice(&search.at.plus(sign * by, way).d);
            self.place();
            // Where something cannot be asked there, its bend is not known.
            let Ok(there) = self.problem.assemble(false) else { return bent };
            if there.system.rows().len() != rows.len() || there.system.rows().width() != rows.width() {
                return bent;
            }
            let factors: Vec<f64> = curved.iter().map(|factor| 0.5 * sign * factor / by).collect();
            add_rows(there.system.rows(), sides, &factors, &mut bow);
        }
        if bow.iter().all(|b| b.is_finite()) {
            bent.iter_mut().zip(bow).for_each(|(b, bow)| *b += bow);
        }
        bent
    }
}
