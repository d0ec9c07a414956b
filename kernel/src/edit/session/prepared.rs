//! What is known for one set of constraints at one state of the shapes.

use smallvec::SmallVec;

use super::border::{Border, members};
use super::strategy::Strategy;
use super::{Handle, State};
use crate::Point;
use crate::edit::report::Convergence;
use crate::error::Error;
use crate::functional::Linearity;
use crate::problem::assembly::{Assembly, Slot};
use crate::problem::bound::{BoundConstraint, difference};
use crate::problem::check::{Check, Response};
use crate::problem::constraint::Constraint;
use crate::problem::known::Known;
use crate::problem::program::{Bounds, equations, gather, has_inequalities, senses};
use crate::problem::{EditError, Numbers, Problem};
use crate::solve::{Dependency, Factored, Solver, SystemMetric};

/// What is known for one set of constraints at one state of the shapes.
pub(super) struct Prepared {
    pub(super) assembly: Assembly,
    pub(super) factored: Box<dyn Factored>,
    pub(super) dependencies: Vec<Dependency>,
    /// Wanted changes, and the sizes of the numbers they come from.
    pub(super) rhs: Numbers,
    pub(super) size: Numbers,
    /// The adjustment of the touched columns, and what it is without the handle.
    pub(super) d: Vec<f64>,
    pub(super) still: SmallVec<[f64; 12]>,
    /// Room for another adjustment: an event that fails gives back the last one.
    pub(super) other: Vec<f64>,
    /// The adjustment that each number of the handle asks for by changing by 1.
    pub(super) response: SmallVec<[Response; 1]>,
    /// Where the touched columns' vertices were.
    pub(super) base: SmallVec<[Point; 4]>,
    /// The way that they went from there, when last checked.
    pub(super) way: SmallVec<[[f64; 3]; 4]>,
    /// Shape and vertex of each.
    pub(super) places: SmallVec<[(u32, u32); 4]>,
    pub(super) refinement: Refinement,
    /// Of the rows that events check: all of the bounds' where there are some.
    pub(super) check: Check,
    pub(super) strategy: Strategy,
    pub(super) iterations: usize,
    pub(super) convergence: Option<Convergence>,
    /// Whether the last event was a best effort that misses something.
    pub(super) gave_way: bool,
    /// Vertices that are reached where the shapes are and were not when prepared.
    pub(super) strayed: Vec<usize>,
}

/// Prepares the constraints: where some are not linear, those that are, with the others as their border if that can be
/// (they are few, and none depends on the rest where the shapes are), else all in one system. `finely`: rows that the others
/// nearly imply are not left out. `known`: of the first constraints, on the shapes as they are.
pub(super) fn prepare(
    problem: &Problem,
    handle: Option<usize>,
    solver: &dyn Solver,
    known: &mut Known,
    finely: bool,
) -> Result<Box<Prepared>, EditError> {
    let bound = &problem.bound;
    let bordered = !problem.best_effort && !has_inequalities(bound);
    let members = if bordered { members(bound) } else { Vec::new() };
    if !members.is_empty() {
        let mut prepared = prepare_system(problem, handle, solver, &mut known.clone(), &members, finely)?;
        let moving = prepared.assembly.vertices().collect();
        let mut border = Border::new(members, bound, &prepared.assembly, moving, &prepared.base)?;
        border.learn(&problem.shapes(), bound)?;
        if border.project(&prepared.assembly, prepared.factored.as_mut()) == Ok(true) {
            border.keep_as_base();
            prepared.strategy = Strategy::Bordered(Box::new(border));
            return Ok(prepared);
        }
    }
    prepare_system(problem, handle, solver, known, &[], finely)
}

fn prepare_system(
    problem: &Problem,
    handle: Option<usize>,
    solver: &dyn Solver,
    known: &mut Known,
    aside: &[usize],
    finely: bool,
) -> Result<Box<Prepared>, EditError> {
    let (shapes, bound) = (problem.shapes(), &problem.bound);
    let mut assembly =
        problem.assemble_beside(&shapes, &mut known.linear, finely, &|k| aside.contains(&k))?;
    let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
    difference(&shapes, bound, &assembly, &known.values, (&mut rhs, &mut size), |_| {})?;
    let mut bounds = None;
    if has_inequalities(bound) {
        let constraints: Vec<&Constraint> = problem.constraints().collect();
        let kept = equations(&senses(&assembly, &constraints));
        let part = assembly.select(&kept);
        let some = (gather(&rhs, &kept), gather(&size, &kept));
        bounds = Some(Box::new(Bounds { full: assembly, rhs, size, active: Vec::new() }));
        assembly = part;
        (rhs, size) = some;
    }
    let factored = solver.factor(&assembly.system)?;
    let count = assembly.vertices().len();
    let (mut places, mut base) = (SmallVec::with_capacity(count), SmallVec::with_capacity(count));
    // Ascending, and so shape after shape.
    let mut vertices = assembly.vertices().peekable();
    for (shape, own) in problem.shapes.iter().enumerate() {
        let (offset, points) = (shapes.offset(shape), own.control_vertices());
        let local = |vertex: &usize| vertex.checked_sub(offset).filter(|&v| v < points.len());
        while let Some(vertex) = vertices.peek().and_then(local) {
            places.push((shape as u32, vertex as u32));
            base.push(points[vertex]);
            vertices.next();
        }
    }
    // Rows are checked where they arrive; a metric's neighbours are not.
    if let Some(vertex) = vertices.next() {
        let all = shapes.vertex_count();
        return Err(Error::Invalid(format!(
            "control vertex {vertex} should move, but there are {all}, numbered from 0"
        ))
        .into());
    }
    drop(vertices);
    let whole = bounds.as_ref().map_or(&assembly.system, |bounds| &bounds.full.system);
    let check = Check::new(whole, factored.as_ref(), &base)?;
    let dependencies = if needs_diagnosis(factored.as_ref(), &assembly) {
        factored.diagnosis().dependencies
    } else {
        Vec::new()
    };
    let linear = bound.iter().all(|b| b.constraint.functional.linearity() == Linearity::Linear);
    let handle = handle.filter(|_| bounds.is_none());
    // Not `vec!`: a few zeros are quicker written than asked for.
    let d: Vec<f64> = std::iter::repeat_n(0.0, 3 * count).collect();
    let mut prepared = Box::new(Prepared {
        factored,
        dependencies,
        rhs,
        size,
        other: d.clone(),
        d,
        still: SmallVec::new(),
        response: SmallVec::new(),
        base,
        way: SmallVec::from_elem([0.0; 3], count),
        places,
        refinement: Refinement::of(&assembly),
        check,
        strategy: match bounds {
            _ if !linear => Strategy::Sequential(None),
            Some(bounds) => Strategy::Bounded(bounds),
            None => Strategy::Linear,
        },
        iterations: 1,
        convergence: None,
        gave_way: false,
        strayed: Vec::new(),
        assembly,
    });
    if let Some(handle) = handle {
        prepared.learn(handle);
    }
    Ok(prepared)
}

impl Prepared {
    /// Learns what a handle's events are made of: the adjustment without it, and what each of its numbers adds.
    fn learn(&mut self, handle: usize) {
        let Self { assembly, factored, rhs, other, still, response, check, refinement, .. } = self;
        let (sides, slots) = (assembly.system.sides(), assembly.slots(handle));
        for slot in slots {
            rhs[assembly.entry(slot)] = 0.0;
        }
        still.resize(other.len(), 0.0);
        // Nothing asked for costs nothing.
        let moves = rhs.iter().any(|b| *b != 0.0);
        if moves {
            refinement.solve(assembly, factored.as_mut(), rhs, still);
        }
        // With three sides, x, y and z share one column of C.
        let columns = || slots.iter().filter(|slot| slot.side == 0);
        let mut one = Numbers::from_elem(0.0, rhs.len());
        for slot in columns() {
            one[assembly.entry(slot)] = 1.0;
            refinement.solve(assembly, factored.as_mut(), &one, other);
            one[assembly.entry(slot)] = 0.0;
            response.push(other.chunks_exact(sides).map(|column| column[0]).collect());
        }
        let rows = columns().map(|slot| slot.row as usize);
        check.of_events(sides, moves.then_some(&still[..]), response, rows);
    }

    /// The right-hand side for the present target of the handle, and the adjustment that the independent rows ask for.
    pub(super) fn meet(&mut self, bound: &[BoundConstraint], handle: Option<&Handle>) {
        let Some(handle) = handle else {
            let Self { refinement, assembly, factored, rhs, d, .. } = self;
            refinement.solve(assembly, factored.as_mut(), rhs, d);
            return;
        };
        // d = C₀b₀ + Σ response · change: only the columns of C whose b is ever non-zero.
        let Self { assembly, rhs, d, still, response, .. } = self;
        let (target, start, d, rhs) =
            (&bound[handle.at].target[..], &handle.start[..], &mut d[..], &mut rhs[..]);
        let slots = assembly.slots(handle.at);
        let mut change = |slot: &Slot, at: usize| {
            let change = target[slot.equation as usize] - start[slot.equation as usize];
            rhs[at] = change;
            change
        };
        if response.is_empty() {
            d.copy_from_slice(still);
        }
        for (k, response) in response.iter().enumerate() {
            let from = if k == 0 { Some(&still[..]) } else { None };
            if assembly.system.sides() == 3 {
                let slots = &slots[3 * k..3 * k + 3];
                let row = 3 * slots[0].row as usize;
                respond([0, 1, 2].map(|side| change(&slots[side], row + side)), response, from, d);
            } else {
                respond([change(&slots[k], slots[k].row as usize)], response, from, d);
            }
        }
    }

    /// Where the vertices were.
    pub(super) fn state(&self) -> State {
        self.places.iter().zip(&self.base).map(|(&(shape, vertex), point)| (shape, vertex, *point)).collect()
    }

    /// The first dependent row that the adjustment does not meet.
    pub(super) fn disagreement(&self) -> Option<usize> {
        let Self { assembly, rhs, size, d, .. } = self;
        self.dependencies.iter().position(|dependency| !dependency.agrees(&assembly.system, rhs, size, d))
    }
}

/// `d = from + change · response` of so many sides; of `d` itself where there is no `from`.
#[inline]
fn respond<const S: usize>(change: [f64; S], response: &[f64], from: Option<&[f64]>, d: &mut [f64]) {
    let d = d.as_chunks_mut::<S>().0;
    match from.map(|from| from.as_chunks::<S>().0) {
        Some(from) => {
            for ((d, from), r) in d.iter_mut().zip(from).zip(response) {
                *d = std::array::from_fn(|side| from[side] + change[side] * r);
            }
        }
        None => {
            for (d, r) in d.iter_mut().zip(response) {
                (0..S).for_each(|side| d[side] += change[side] * r);
            }
        }
    }
}

/// Solving with one step of iterative refinement where there is a metric: `d = C b`, then `d += C (b - F d)`. A metric's
/// condition (that of bending grows with the fourth power of the vertices' number) leaves the rows met to far less than
/// rounding; what is missing is met as badly, and so to rounding. Without a metric the solvers meet them to rounding.
#[derive(Debug, Default)]
pub(super) struct Refinement(Option<[Vec<f64>; 2]>);

impl Refinement {
    fn of(assembly: &Assembly) -> Self {
        let system = &assembly.system;
        let plain = matches!(system.metric(), SystemMetric::Least);
        let room = |count: usize| vec![0.0; count * system.sides()];
        Self((!plain).then(|| [room(system.rows().len()), room(system.touched().len())]))
    }

    pub(super) fn solve(
        &mut self,
        assembly: &Assembly,
        factored: &mut dyn Factored,
        rhs: &[f64],
        d: &mut [f64],
    ) {
        factored.solve_into(rhs, d);
        let Some([missed, again]) = &mut self.0 else { return };
        assembly.system.rows().multiply(d, assembly.system.sides(), missed);
        missed.iter_mut().zip(rhs).for_each(|(m, b)| *m = b - *m);
        factored.solve_into(missed, again);
        d.iter_mut().zip(again.iter()).for_each(|(d, more)| *d += more);
    }
}

/// Whether rows may have been dropped. The rank is always known without asking for the condition.
pub(super) fn needs_diagnosis(factored: &dyn Factored, assembly: &Assembly) -> bool {
    factored.rank() < assembly.system.rows().len()
}
