//! Edges that stay, as equations for the net of α: `∫ (α - 1) S_u du = 0` for all `v`.

use loftsman_kernel::text::short;
use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Axis, Edit, EditError, Report, Unknowns};
use loftsman_kernel::functional::vertex;
use loftsman_kernel::shape::{Derivative, Domain, Interval, Location, Shape, Side, Stencil};
use loftsman_kernel::solve::{SolveError, Solver, SparseRows};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::{Point, Vector};

use crate::error::{FineTuneError, Result};
use crate::lift::{Alpha, Place};
use crate::lines::derivative_u;
use crate::measure::{mass, nearest_with_ones};
use crate::positive::{Above, Bound, POSITIVE, bound, bounded, reaches_zero, told};
use crate::surface::Pin;

/// How the edges are to stay.
pub(crate) struct Edges<'a> {
    /// So many rows of α at the start and at the end along `u` are 1: for derivatives that stay at the edges.
    pub(crate) rows: [usize; 2],
    /// So many columns at the sides where `v` starts and ends are 1: for sides that stay.
    pub(crate) columns: [usize; 2],
    /// Values that α has somewhere.
    pub(crate) pins: Vec<&'a Pin>,
    pub(crate) solver: &'a Arc<dyn Solver>,
    pub(crate) any_sign: bool,
    pub(crate) names: [&'static str; 2],
}

/// Some of the numbers `∫ N_k(u) R_l(v) S_u du` as functions of `v`: an equation for each coordinate of each coefficient.
struct Equations {
    /// What each coefficient, a vector, has of each value of α.
    rows: Vec<Vec<(usize, Vector)>>,
    /// α's values somewhere: what each has of each value of α, and what it is to be.
    pins: Vec<(Vec<(usize, f64)>, f64)>,
}

impl Edges<'_> {
    /// α nearest to the one asked for, in `∫∫ (Δα)²`, with which the edge `u = u₁` stays (that at `u₀` stays by itself). Values
    /// that continuity sets to 1 are set, and what that takes along with them; the least change is that of all. Nothing is solved where nothing need be.
    ///
    /// # Errors
    /// When no α but 1 does it, or none that is positive.
    pub(crate) fn solve(&self, given: &Field<Vector>, alpha: &Alpha) -> Result<(Alpha, Option<Report>)> {
        let alpha = alpha.clone().clamped(self.rows != [0; 2], self.columns != [0; 2])?;
        let (height, width) = (alpha.along().len(), alpha.columns());
        let edge = |k: usize, [first, last]: [usize; 2], of: usize| k < first || k + last >= of;
        let [rows, columns] = [self.rows, self.columns].map(|counts| counts.iter().sum::<usize>());
        let fixed = |k: usize| edge(k / width, self.rows, height) || edge(k % width, self.columns, width);
        let free_values: Vec<usize> = (0..height * width).filter(|k| !fixed(*k)).collect();
        let start = if free_values.len() < height * width {
            nearest_with_ones(&mass(&alpha)?, alpha.values(), &free_values)
        } else {
            alpha.values().to_vec()
        };
        let pins =
            self.pins.iter().map(|pin| Ok((alpha.row((self.facing(pin), [Side::Right; 2]))?, pin.value)));
        let equations = Equations { pins: pins.collect::<Result<_>>()?, ..Equations::new(given, &alpha)? };
        let is_one = |values: &[f64]| values.iter().all(|c| (c - 1.0).abs() <= 1e-9);
        let nothing = |values: &[f64]| self.pins.is_empty() && is_one(values) && !is_one(alpha.values());
        let refused = |equations: usize| {
            let free_columns = width.saturating_sub(columns).max(1);
            FineTuneError::Edges {
                along: self.names[0],
                net: width > 1,
                equations,
                values: free_values.len(),
                needed: rows + equations / free_columns + 1,
                columns: width,
            }
        };
        let sides = || {
            let needed = if free_values.is_empty() {
                let across = width.max(columns + 1);
                // As many equations as functions across have; more of those have more.
                let all: Vec<usize> = (0..height * width).collect();
                let each = equations.count(&all).div_ceil(width) * across / (across - columns);
                [rows + each + 1, across]
            } else {
                [0; 2]
            };
            FineTuneError::Sides {
                along: self.names[0],
                found: [height, width],
                fixed: [self.rows, self.columns],
                needed,
            }
        };
        if equations.hold(&start) {
            return if nothing(&start) { Err(sides()) } else { Ok((alpha.with(start)?, None)) };
        }
        if free_values.is_empty() {
            return Err(sides());
        }
        let problem =
            Problem { equations: &equations, start: &start, free: &free_values, alpha: &alpha, edges: self };
        let (mut values, mut report) = problem.solve(&[])?;
        if nothing(&values) {
            return Err(refused(equations.count(&free_values)));
        }
        let [least, most] = alpha.with(values.clone())?.extremes()?;
        if !self.any_sign && reaches_zero([least, most]) {
            let bound = bound(alpha.extremes()?[0], [least, most]);
            let none = || FineTuneError::NoPositive { least, most, bound: bound.at_least };
            (values, report) = problem.bounded(&values, bound).map_err(|error| match error {
                FineTuneError::Edit(EditError::Solve(SolveError::Conflict { .. })) => none(),
                other => other,
            })?;
            if reaches_zero(alpha.with(values.clone())?.extremes()?) {
                return Err(none());
            }
        }
        Ok((alpha.with(values)?, Some(report)))
    }

    /// A place, the direction that is scaled first.
    fn facing(&self, pin: &Pin) -> (f64, f64) {
        match pin.direction {
            Direction::U => pin.at,
            Direction::V => (pin.at.1, pin.at.0),
        }
    }
}

impl Equations {
    /// `O(n)` for α of one parameter; for a net as many products as it has rows.
    fn new(given: &Field<Vector>, alpha: &Alpha) -> Result<Self> {
        let derivative = derivative_u(given)?;
        let (u, v) = (derivative.space(Direction::U), derivative.space(Direction::V));
        let inner = alpha.along().inner_products(u)?;
        // ∫ N_k S_u du as a function of v, for each k.
        let moments = (0..alpha.along().len()).map(|k| {
            let mut own = vec![Vector::zeros(); v.len()];
            for (i, w) in inner.iter_row(k) {
                let row = &derivative.coefficients()[i * v.len()..(i + 1) * v.len()];
                own.iter_mut().zip(row).for_each(|(own, c)| *own += c * w);
            }
            own
        });
        let mut rows;
        match alpha {
            Alpha::Line(_) => {
                rows = vec![Vec::new(); v.len()];
                for (k, own) in moments.enumerate() {
                    rows.iter_mut().zip(own).for_each(|(row, by)| row.push((k, by)));
                }
            }
            Alpha::Net(net) => {
                let across = net.space(Direction::V);
                let product = v.product(across)?;
                let few = across.degree() + 1;
                rows = vec![Vec::new(); product.space().len()];
                for (k, own) in moments.enumerate() {
                    let terms = product.with_first(&Function::new(v.clone(), own)?);
                    for (row, terms) in rows.iter_mut().zip(terms.chunks_exact(few)) {
                        row.extend(terms.iter().map(|(l, by)| (k * across.len() + l, *by)));
                    }
                }
            }
        }
        Ok(Self { rows, pins: Vec::new() })
    }

    /// How far the edge is off, and the size of the numbers that this comes from.
    fn off(&self, row: &[(usize, Vector)], alpha: &[f64]) -> (Vector, f64) {
        row.iter().fold((Vector::zeros(), 0.0), |(sum, size), (k, by)| {
            (sum + by * (alpha[*k] - 1.0), size + by.amax() * alpha[*k].abs().max(1.0))
        })
    }

    /// How many scalar equations there are that are more than rounding, of the values that may change.
    fn count(&self, free: &[usize]) -> usize {
        let norm = |row: &Vec<(usize, Vector)>| {
            let own = row.iter().filter(|(k, _)| free.binary_search(k).is_ok());
            own.fold(Vector::zeros(), |sum, (_, by)| sum + by.component_mul(by)).map(f64::sqrt)
        };
        let norms: Vec<Vector> = self.rows.iter().map(norm).collect();
        let largest = norms.iter().fold(0.0_f64, |m, n| m.max(n.amax()));
        norms.iter().flat_map(|n| n.iter()).filter(|n| **n > 1e-13 * largest).count() + self.pins.len()
    }

    fn hold(&self, alpha: &[f64]) -> bool {
        let all = self.rows.iter().map(|row| self.off(row, alpha));
        let (off, size) =
            all.fold((0.0_f64, 0.0_f64), |(off, size), (o, s)| (off.max(o.amax()), size.max(s)));
        let held = |(row, to): &(Vec<(usize, f64)>, f64)| {
            pin_off(row, alpha, *to).abs() <= 1e-14 * to.abs().max(1.0)
        };
        off <= 1e-14 * size && self.pins.iter().all(held)
    }
}

/// How far α is from what it is to be somewhere.
fn pin_off(row: &[(usize, f64)], alpha: &[f64], to: f64) -> f64 {
    row.iter().map(|(k, by)| by * alpha[*k]).sum::<f64>() - to
}

struct Problem<'a> {
    equations: &'a Equations,
    start: &'a [f64],
    free: &'a [usize],
    alpha: &'a Alpha,
    edges: &'a Edges<'a>,
}

impl Problem<'_> {
    /// The same with α at least `bound` everywhere, where it is not so in the first answer.
    fn bounded(&self, first: &[f64], bound: Bound) -> Result<(Vec<f64>, Report)> {
        let first = self.alpha.with(first.to_vec())?;
        let solve = |held: &[Place]| {
            let rows = held.iter().map(|place| Ok((first.row(*place)?, bound)));
            self.solve(&rows.collect::<Result<Vec<_>>>()?)
        };
        let (values, mut report) = bounded(&first, bound, solve, |(values, _)| values.clone())?;
        report.constraints.retain(|one| one.name != POSITIVE);
        report.active = vec![format!("alpha ≥ {}", short(bound.at_least))];
        report.notes.push(told(&first.with(values.clone())?, bound, "edges")?);
        Ok((values, report))
    }

    /// The least change that makes the equations true, and sums of α's values at least so large.
    fn solve(&self, bounds: &[(Vec<(usize, f64)>, Bound)]) -> Result<(Vec<f64>, Report)> {
        let mut number = vec![None; self.start.len()];
        self.free.iter().enumerate().for_each(|(x, k)| number[*k] = Some(x));
        let count = self.equations.rows.len();
        let mut map = SparseRows::new(self.free.len());
        let (mut gaps, mut norms) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for row in &self.equations.rows {
            let free = || row.iter().filter_map(|(k, by)| number[*k].map(|x| (x, by)));
            for axis in 0..3 {
                map.push(free().map(|(x, by)| (x, by[axis])));
            }
            norms
                .push(free().fold(Vector::zeros(), |sum, (_, by)| sum + by.component_mul(by)).map(f64::sqrt));
            gaps.push(Point::from(self.equations.off(row, self.start).0));
        }
        for (row, to) in &self.equations.pins {
            map.push(row.iter().filter_map(|(k, by)| number[*k].map(|x| (x, *by))));
            map.push([]);
            map.push([]);
            gaps.push(Point::new(pin_off(row, self.start, *to), 0.0, 0.0));
        }
        let asked = gaps.len();
        for x in 0..self.free.len() {
            map.push([(x, 1.0)]);
            map.push([]);
            map.push([]);
        }
        let vertices = self.free.iter().map(|k| Point::new(self.start[*k], 0.0, 0.0)).collect();
        let unknowns = Unknowns::sparse((0..asked + self.free.len()).collect(), map)?
            .measured(Some(mass(self.alpha)?.select(self.free)))?;
        let [along, _] = self.edges.names;
        let mut edit = Edit::of(Points(gaps))
            .with(Box::new(Points(vertices)))
            .named(0, format!("the edge at the end of {along}"))
            .named(1, "α")
            .through(unknowns)
            .smooth(0);
        // Rows that are rounding beside the others (flat, or of a pole) ask nothing.
        let largest = norms.iter().fold(0.0_f64, |m, n| m.max(n.amax()));
        for (c, norm) in norms.iter().enumerate() {
            for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
                if norm[k] > 1e-13 * largest {
                    edit = edit.ask(vertex(c as i64).axis(axis).to(0.0));
                }
            }
        }
        for k in 0..self.equations.pins.len() {
            let pin = vertex((count + k) as i64).axis(Axis::X).to(0.0);
            edit = edit.ask(pin.called(&format!("alpha_at[{k}]")));
        }
        for (row, bound) in bounds {
            // What is fixed counts, and cannot change.
            let fixed: f64 =
                row.iter().filter(|(k, _)| number[*k].is_none()).map(|(k, c)| c * self.start[*k]).sum();
            let free: Vec<_> = row.iter().filter_map(|(k, c)| Some((number[*k]?, *c))).collect();
            if !free.is_empty() {
                let above = Above { terms: free, accuracy: bound.near };
                edit = edit.ask(above.at_least(bound.at_least - fixed).called(POSITIVE));
            }
        }
        let done = edit.solve_with(Arc::clone(self.edges.solver))?;
        let mut values = self.start.to_vec();
        let found = done.shape_at(1)?;
        self.free.iter().zip(found.control_vertices()).for_each(|(k, p)| values[*k] = p.x);
        Ok((values, done.report().clone()))
    }
}

/// Numbers as a shape of control vertices and nothing else.
#[derive(Debug, Clone)]
struct Points(Vec<Point>);

impl Shape for Points {
    fn control_vertices(&self) -> &[Point] {
        &self.0
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.0
    }

    fn stencil(&self, _: Location, _: Derivative) -> loftsman_kernel::error::Result<Stencil> {
        Err(loftsman_kernel::Error::Invalid(
            "numbers by themselves have no locations: ask of their vertices".into(),
        ))
    }

    fn domain(&self) -> Domain {
        std::iter::once(Interval { start: 0.0, end: 1.0, periodic: false }).collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}
