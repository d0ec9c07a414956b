//! A problem solved once.

use std::collections::BTreeMap;

use super::bound::{BoundConstraint, right_hand_side};
use super::check::{Check, Miss, Moved, excess, missed_by, near_conflict};
use super::program::{Solved, senses};
use super::smooth::is_ours;
use super::{Assembly, Constraint, EditError, Numbers, Problem, view};
use crate::error::Error;
use crate::measure::PROPORTION;
use crate::solve::{Dependency, Diagnosis, SolveError, Solver};
use crate::{Point, Vector};

/// The least adjustment that meets the equations and inequalities of a problem whose constraints are linear.
pub struct Solution {
    full: Assembly,
    solved: Solved,
    diagnosis: Diagnosis,
    redundant: Vec<String>,
}

impl std::fmt::Debug for Solution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solution").field("diagnosis", &self.diagnosis).finish_non_exhaustive()
    }
}

impl Problem {
    /// The least adjustment that meets what is asked, of the shapes as they are, which stay as they are. Every row is checked on
    /// the vertices as they will be rounded, and that the adjustment is in proportion to what is asked.
    ///
    /// # Errors
    /// When something is not linear, the constraints cannot all hold, or the solver refuses the system.
    pub fn solve(&self, solver: &dyn Solver) -> Result<Solution, EditError> {
        if let Some(functional) = self.nonlinear() {
            return Err(SolveError::Unsupported(format!(
                "{} is not linear in the control vertices: solve it in a session",
                functional.describe()
            ))
            .into());
        }
        match self.solve_as(solver, false) {
            // What others nearly imply was left out, and is missed by more than rounding: it is not implied.
            Err(EditError::Solve(SolveError::Missed { .. })) => self.solve_as(solver, true),
            done => done,
        }
    }

    fn solve_as(&self, solver: &dyn Solver, finely: bool) -> Result<Solution, EditError> {
        let shapes = view(&self.shapes);
        let full = self.assemble(finely)?;
        let (mut rhs, mut size) = (Numbers::new(), Numbers::new());
        right_hand_side(&shapes, &self.bound, &full, &mut rhs, &mut size)?;
        let mut solved = self.program(solver, &full, &rhs, &size)?;
        if !solved.d.iter().all(|d| d.is_finite()) {
            return Err(overflow());
        }
        let part = solved.part.as_ref().map_or(&full, |(part, _)| part);
        if !solved.softened {
            let right = (&solved.rhs[..], &solved.size[..]);
            if !self.forced
                && let Some(excess) =
                    excess(&part.system, solved.factored.as_ref(), right, &solved.d, PROPORTION)?
            {
                let error = near_conflict(&self.bound, part, solved.factored.as_mut(), &solved.rhs, excess);
                return Err(error.into());
            }
            let base: Vec<Point> = full.vertices().map(|vertex| shapes.vertex(vertex)).collect();
            let constraints: Vec<&Constraint> = self.constraints().collect();
            let senses = senses(&full, &constraints);
            let check = Check::new(&full.system, solved.factored.as_ref(), &base)?;
            let mut way = vec![[0.0; 3]; base.len()];
            let moved = Moved::by(&base, &solved.d, &mut way);
            let asked = |row: usize| {
                (senses[row], constraints[full.constraint_of(row)].functional().accuracy().tolerance())
            };
            match check.missed(&full.system, asked, (&rhs, &size), &moved) {
                None => {}
                Some(Miss::Overflow) => return Err(overflow()),
                Some(Miss::Row(row, error)) => {
                    let constraint = constraints[full.constraint_of(row)];
                    return Err(missed_by(solved.factored.solver(), constraint, error).into());
                }
            }
        }
        let diagnosis = solved.factored.diagnosis();
        let (redundant, _) = redundant(&self.bound, part, &mut diagnosis.dependencies.iter());
        Ok(Solution { full, solved, diagnosis, redundant })
    }
}

impl Solution {
    /// The system of all that was asked.
    pub fn assembly(&self) -> &Assembly {
        &self.full
    }

    /// The control vertices that move, by their numbers through all shapes, and how far.
    pub fn adjustments(&self) -> impl Iterator<Item = (usize, Vector)> + '_ {
        let ways = self.solved.d.as_chunks::<3>().0.iter().map(|d| Vector::from(*d));
        self.full.vertices().zip(ways)
    }

    /// The solver that did the work.
    pub fn solver(&self) -> &str {
        self.solved.factored.solver()
    }

    /// Scalar equations, active inequalities among them.
    pub fn equations(&self) -> usize {
        self.solved.part.as_ref().map_or(&self.full, |(part, _)| part).slots.len()
    }

    /// Independent ones among them.
    pub fn rank(&self) -> usize {
        self.diagnosis.rank * self.full.system.sides()
    }

    /// Estimate of the condition number of the equations, each scaled to unit length.
    pub fn condition(&self) -> f64 {
        self.diagnosis.condition
    }

    /// Constraints (or parts of them) that the others imply: they were dropped, and hold.
    pub fn redundant(&self) -> &[String] {
        &self.redundant
    }
}

/// The names of constraints that were asked for of which others imply some rows, and how many equations of what is kept smooth they imply.
pub(crate) fn redundant(
    bound: &[BoundConstraint],
    assembly: &Assembly,
    dependencies: &mut dyn Iterator<Item = &Dependency>,
) -> (Vec<String>, usize) {
    let sides = assembly.system.sides();
    let mut lost: BTreeMap<usize, usize> = BTreeMap::new();
    for dependency in dependencies {
        *lost.entry(assembly.constraint_of(dependency.row)).or_default() += 1;
    }
    let (mut names, mut smooth) = (Vec::new(), 0);
    for (k, lost) in lost {
        if is_ours(&bound[k].constraint) {
            smooth += lost * sides;
            continue;
        }
        // What stands still beside what was asked, and follows from that, nobody asked for.
        if bound[k].constraint.companion.is_some() {
            continue;
        }
        let rows = assembly.slots(k).len() / sides;
        let name = bound[k].constraint.describe();
        names.push(if lost < rows { format!("{name} ({lost} of its {rows} equations)") } else { name });
    }
    (names, smooth)
}

pub(crate) fn overflow() -> EditError {
    Error::Invalid("the adjustment overflows: ask for a smaller change".into()).into()
}
