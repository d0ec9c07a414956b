//! Its rows in the system of a step, and what they miss.

use loftsman_kernel::Vector;
use loftsman_kernel::functional::{Equation, Shapes, Store, rows_of};
use loftsman_kernel::shape::Derivative;
use loftsman_kernel::solve::RangeSpace;

use super::{HeldPart, HeldTerm, Link};
use crate::constraint::Target;
use crate::error::Result;

/// A parameter that turned round so often goes no slower: a millionth of its way.
const TURNS: usize = 20;

/// What is written while rows are collected; kept from step to step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Desk {
    store: Store,
    vertices: Vec<usize>,
    coefficients: Vec<f64>,
    /// What each equation is now, less its target, and the target's rate and acceleration.
    pub(crate) gap: Vec<f64>,
    pub(crate) target_rate: Vec<f64>,
    pub(crate) target_acceleration: Vec<f64>,
    /// What velocities add: `2 Σ q̇ b' ṡ + P'' ṡ²`.
    pub(crate) curving: Vec<f64>,
    /// `(equation, parameter, by)`, parameters numbered through all links.
    pub(crate) changes: Vec<(usize, usize, f64)>,
    /// `(parameter, factor)`: those that turned round, damped.
    pub(crate) damped: Vec<(usize, f64)>,
    pub(crate) parameters: usize,
    value: Vec<f64>,
    along: Vec<f64>,
}

impl Desk {
    pub(crate) fn clear(&mut self) {
        self.gap.clear();
        self.target_rate.clear();
        self.target_acceleration.clear();
        self.curving.clear();
        self.changes.clear();
        self.damped.clear();
        self.parameters = 0;
    }
}

impl Link {
    /// Pushes its rows, and what they miss. `velocities` are shapes whose control vertices are velocities.
    pub(crate) fn push(
        &mut self,
        shapes: &Shapes<'_>,
        velocities: &Shapes<'_>,
        time: f64,
        space: &mut RangeSpace,
        desk: &mut Desk,
    ) -> Result<()> {
        let first = space.equations();
        let first_parameter = desk.parameters;
        // So that none is asked for where one turns round later.
        desk.damped.reserve(first_parameter + self.slides.len());
        for part in &self.parts {
            let start = desk.gap.len();
            let (mut value, mut rate, mut acceleration) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            if let Target::Path(path) = &part.target {
                let [place, velocity, change] = path.at(time);
                value.copy_from_slice(place.as_slice());
                rate.copy_from_slice(velocity.as_slice());
                acceleration.copy_from_slice(change.as_slice());
            }
            let moving = matches!(part.target, Target::Path(_));
            let count = part.value.len();
            let asked = |k: usize| count != 3 || self.axes[k];
            // Rows, all terms' together.
            let mut alike = count == 3;
            desk.store.clear();
            {
                let mut rows = desk.store.rows(shapes);
                for term in &part.terms {
                    rows_of(term.functional.as_ref(), shapes, &mut rows)?;
                }
            }
            desk.value.clear();
            desk.value.resize(count * part.terms.len(), 0.0);
            desk.store.evaluate(shapes, &mut desk.value);
            alike &= desk.store.equations().all(|e| matches!(e, Equation::Alike { .. }));
            if alike {
                desk.vertices.clear();
                desk.coefficients.clear();
                for (equation, term) in desk.store.equations().zip(&part.terms) {
                    if let Equation::Alike { vertices, coefficients, .. } = equation {
                        desk.vertices.extend_from_slice(vertices);
                        desk.coefficients.extend(coefficients.iter().map(|c| c * term.sign));
                    }
                }
                let entries = desk.vertices.iter().copied().zip(desk.coefficients.iter().copied());
                if self.axes == [true; 3] {
                    space.push_alike(entries);
                } else {
                    for axis in (0..3).filter(|&k| asked(k)) {
                        let unit = move |c: f64| std::array::from_fn(|k| if k == axis { c } else { 0.0 });
                        space.push_coupled(entries.clone().map(|(v, c)| (v, unit(c))));
                    }
                }
            } else {
                push_any(&desk.store, part, if count == 3 { self.axes } else { [true; 3] }, space);
            }
            for k in (0..count).filter(|&k| asked(k)) {
                let now: f64 = part
                    .terms
                    .iter()
                    .enumerate()
                    .map(|(t, term)| term.sign * desk.value[t * count + k])
                    .sum();
                let wanted = if moving { value[k] } else { part.value[k] };
                desk.gap.push(now - wanted);
                desk.target_rate.push(if moving { rate[k] } else { 0.0 });
                desk.target_acceleration.push(if moving { acceleration[k] } else { 0.0 });
                desk.curving.push(0.0);
            }
            // What its parameters do.
            for term in &part.terms {
                let Some(index) = term.place.filter(|index| self.places[*index].floats) else { continue };
                let own: usize =
                    self.places[..index].iter().filter(|p| p.floats).map(|p| p.location.parameters()).sum();
                let directions = self.places[index].location.parameters();
                let look = |shapes: &Shapes<'_>, u: usize, v: usize, along: &mut Vec<f64>| -> Result<()> {
                    along.clear();
                    along.resize(count, 0.0);
                    Ok(term.functional.along(shapes, Derivative { u, v }, along)?)
                };
                for axis in 0..directions {
                    let turns = self.turns[own + axis].1.min(TURNS) as i32;
                    if turns > 0 {
                        desk.damped.push((first_parameter + own + axis, 2.0_f64.powi(turns) - 1.0));
                    }
                    if self.stands[own + axis] {
                        continue;
                    }
                    let pace = self.slides[own + axis].pace;
                    let speed = self.rates[own + axis] * pace;
                    let (u, v) = if axis == 0 { (1, 0) } else { (0, 1) };
                    look(shapes, u, v, &mut desk.along)?;
                    for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                        let by = term.sign * desk.along[k] * pace;
                        desk.changes.push((equation, first_parameter + own + axis, by));
                    }
                    if speed == 0.0 {
                        continue;
                    }
                    look(velocities, u, v, &mut desk.along)?;
                    for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                        desk.curving[equation] += term.sign * 2.0 * speed * desk.along[k];
                    }
                    for other in (0..directions).filter(|other| !self.stands[own + other]) {
                        let product = speed * self.rates[own + other] * self.slides[own + other].pace;
                        let (u2, v2) = if other == 0 { (u + 1, v) } else { (u, v + 1) };
                        look(shapes, u2, v2, &mut desk.along)?;
                        for (equation, k) in (start..).zip((0..count).filter(|&k| asked(k))) {
                            desk.curving[equation] += term.sign * product * desk.along[k];
                        }
                    }
                }
            }
        }
        desk.parameters += self.slides.len();
        self.first = first;
        self.equations = space.equations() - first;
        self.multipliers.resize(self.equations, 0.0);
        Ok(())
    }
}

fn push_any(store: &Store, part: &HeldPart, asked: [bool; 3], space: &mut RangeSpace) {
    // Several terms are all points; only a functional that stands alone is of any kind.
    let sign = part.terms.first().map_or(1.0, |term| term.sign);
    let mut number = 0;
    for equation in store.equations() {
        match equation {
            Equation::Alike { vertices, coefficients, .. } => {
                space.push_alike(vertices.iter().copied().zip(coefficients.iter().map(|c| c * sign)));
                number += 3;
            }
            Equation::Coupled { vertices, vectors, .. } => {
                if number >= 3 || asked[number] {
                    let turned = |v: &Vector| [v.x * sign, v.y * sign, v.z * sign];
                    space.push_coupled(vertices.iter().copied().zip(vectors.iter().map(turned)));
                }
                number += 1;
            }
        }
    }
}

impl HeldTerm {
    pub(super) fn value(&self, shapes: &Shapes<'_>, desk: &mut Desk) -> Result<Vec<f64>> {
        desk.store.clear();
        rows_of(self.functional.as_ref(), shapes, &mut desk.store.rows(shapes))?;
        let mut value = vec![0.0; self.functional.equations()];
        desk.store.evaluate(shapes, &mut value);
        Ok(value)
    }
}
