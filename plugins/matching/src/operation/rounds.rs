//! Rounds of solving and of knots inserted where the match is outside its limits.

use loftsman_kernel::edit::{Ask, Edit, EditError, Metric};
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::plugin::{Context, OperationError};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{SaddlePoint, SolveError};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::{figure, short};

use super::MOST;
use super::asked::Asked;
use super::attempt::{Case, Work};
use super::changed::Changed;
use super::made::Made;
use super::remedy::{Refused, Why};
use super::seam::Kept;
use crate::deviation::{Deviation, Limits};
use crate::history::{Attempt, History, Stuck};

/// Knots stop where estimates, which are rough, say that this many times as many control vertices would be needed.
pub(super) const DOUBTFUL: usize = 2;
/// Spans that are shorter than this part of the domain are not halved.
pub(super) const SHORTEST: f64 = 1e-6;
/// Knots that are closer together than this part of their domain hide how much a surface bends.
pub(super) const CLOSE: f64 = 1e-4;

impl Asked {
    /// From a surface with these knots on, to so many control vertices along the edge at most.
    pub(super) fn from(
        &self,
        mut start: Surface,
        as_many: usize,
        case: &Case<'_>,
        context: &Context<'_>,
        work: &mut Work,
    ) -> Result<Result<Made, Refused>, OperationError> {
        let Case { surface, other, along, size, distance, before, .. } = *case;
        // What the equations leave between is judged here, by the limits: no curvature is too much beside a flat surface either.
        let lax = Limits { distance: Some(1e6 * size), angle: std::f64::consts::TAU, curvature: 1e200 };
        let most = MOST[self.continuity].max(2 * surface.space(along).len()).min(as_many);
        let (mut history, mut kept) = (History::default(), Kept::Smooth);
        loop {
            let count = start.space(along).len();
            if work.done >= work.most {
                return Ok(Err(Refused::of(history.last(), size, Why::Work)));
            }
            work.done += count;
            context.observer.proceed(work.called, count as u64, most as u64)?;
            let asked =
                self.matching(lax).begun(case.begun).bound_to(&Shapes::new([&start as &dyn Shape, other]))?;
            let made = |kept: Kept| -> Result<Edit<Surface>, OperationError> {
                let still = 0..other.control_vertices().len() as i64;
                let mut edit =
                    Edit::new(&start).with(other.boxed()).lock(self.locked(&start, along)?).lock_on(1, still);
                if let Some(name) = &self.other.name {
                    edit = edit.named(1, name.clone());
                }
                if self.bend {
                    edit = edit.metric(Metric::Bend);
                }
                let mut edit = edit.smooth(u8::from(kept == Kept::Smooth)).ask(asked.clone().hold());
                if kept == Kept::Shut {
                    for tie in self.seam(&start, along)? {
                        edit = edit.ask(tie);
                    }
                }
                Ok(edit)
            };
            // With knots of its own a surface is moved whatever that takes; knots are inserted while that is quick.
            let quick = self.bend && history.last().is_some();
            let edit = |kept: Kept| -> Result<_, OperationError> {
                if !quick {
                    return Ok(made(kept)?.solve());
                }
                Ok(match made(kept)?.solve_with(SaddlePoint) {
                    // What it takes for nearly dependent others take.
                    Err(EditError::Solve(SolveError::IllConditioned { .. })) => made(kept)?.solve(),
                    solved => solved,
                })
            };
            // Where the other edge has corners that the surface has not, the two conflict: there they appear. What meets along a seam goes on meeting, if it can.
            let mut solved = edit(kept)?;
            while let (
                Err(EditError::Solve(SolveError::Conflict { .. } | SolveError::NearConflict { .. })),
                Some(less),
            ) = (&solved, kept.less())
            {
                kept = less;
                solved = edit(kept)?;
            }
            let edited = match (solved, history.last()) {
                (Ok(edited), _) => edited,
                (Err(EditError::Solve(SolveError::TooLarge { .. })), Some(last)) => {
                    return Ok(Err(Refused::of(Some(last), size, Why::Work)));
                }
                (
                    Err(EditError::Solve(
                        SolveError::NotConverged { .. }
                        | SolveError::StillMoving { .. }
                        // Equations that are nearly dependent, all but met.
                        | SolveError::Missed { .. },
                    )),
                    _,
                ) => {
                    return Ok(Err(Refused { count, worst: None, size, why: Why::NoneFound }));
                }
                (Err(EditError::Solve(SolveError::Metric { .. })), _) if self.bend => {
                    return Ok(Err(Refused {
                        count,
                        worst: None,
                        size,
                        why: Why::Unmeasured(too_close(&start)),
                    }));
                }
                (Err(error), _) => return Err(error.into()),
            };
            let profile = asked.profile(&Shapes::new([edited.shape() as &dyn Shape, other]))?;
            let worst = Deviation::worst(&profile).without_rounding(size);
            if worst.within(self.continuity, distance, &self.limits) {
                let degrees = |s: &Surface| [along, along.other()].map(|d| s.space(d).degree());
                let count = |s: &Surface, direction| s.space(direction).len();
                let (along, across) = (along, along.other());
                let changed = Changed::of([surface, edited.shape()], along, case.at_end, size)?;
                return Ok(Ok(Made {
                    size,
                    changed,
                    before,
                    after: worst,
                    along: [count(surface, along), count(&start, along)],
                    across: [count(surface, across), count(&start, across)],
                    degrees: [degrees(surface), degrees(&start)],
                    edited,
                    cornered: kept != Kept::Smooth,
                    shut: kept == Kept::Shut && !self.seam(&start, along)?.is_empty(),
                    way: None,
                }));
            }
            let excess = worst.excess(self.continuity, distance, &self.limits);
            history.push(Attempt { count, excess, worst });
            start = match self.halved(&start, case, most, &profile, &mut history)? {
                Ok(halved) => halved,
                Err(why) => return Ok(Err(Refused::of(history.last(), size, why))),
            };
        }
    }

    /// The surface with the spans halved along which the match is outside its limits; or why that would not help.
    pub(super) fn halved(
        &self,
        surface: &Surface,
        case: &Case<'_>,
        most: usize,
        profile: &[(f64, Deviation)],
        history: &mut History,
    ) -> Result<Result<Surface, Why>, OperationError> {
        let (space, folded) = (surface.space(case.along), self.continuity > 0 && Deviation::folded(profile));
        let stuck = history.is_stuck();
        let outside = |a: f64, b: f64| {
            let within = |one: &Deviation| one.within(self.continuity, case.distance, &self.limits);
            profile.iter().any(|(t, one)| *t >= a && *t <= b && !within(one))
        };
        let mut knots = Vec::new();
        for piece in space.breakpoints().windows(2) {
            let (a, b) = (piece[0], piece[1]);
            // Where knots at some spans only moved what is left to others, all are halved.
            if (stuck.is_some() || outside(a, b)) && b - a > SHORTEST * space.length() {
                knots.push(0.5 * a + 0.5 * b);
            }
        }
        let hopeless = stuck == Some(Stuck::Everywhere) || folded;
        let needed = history.needed().filter(|needed| *needed > DOUBTFUL * most);
        if hopeless
            || needed.is_some()
            || knots.is_empty()
            || space.len() + knots.len() > most
            || !self.refine
        {
            let back = |(_, one): &(f64, Deviation)| one.angle > std::f64::consts::FRAC_PI_2;
            return Ok(Err(if case.lay_on && folded {
                Why::LayOn
            } else if folded {
                Why::Folds
            } else if self.continuity > 0 && profile.iter().any(back) {
                Why::FoldsInPart
            } else if let (true, false, Some(needed)) = (self.refine, hopeless, needed) {
                Why::Needs { needed, most }
            } else {
                Why::Limits
            }));
        }
        if stuck.is_some() {
            history.all_halved();
        }
        Ok(Ok(surface.insert_knots(case.along, &knots)?))
    }
}

/// Why it cannot be measured how much a surface bends: its degree, or which of its knots are closest together, by the length of their domain.
pub(super) fn too_close(surface: &Surface) -> String {
    let mut closest = (f64::INFINITY, "u", 0.0, 0.0);
    for (name, space) in [("u", surface.u()), ("v", surface.v())] {
        for pair in space.breakpoints().windows(2) {
            let (gap, share) = (pair[1] - pair[0], (pair[1] - pair[0]) / space.length());
            if share < closest.0 {
                closest = (share, name, pair[0], gap);
            }
        }
    }
    let (share, name, at, gap) = closest;
    if share > CLOSE {
        let degree = surface.u().degree().max(surface.v().degree());
        return format!(
            "how much the surface bends cannot be measured: rounding hides that of degree {degree}"
        );
    }
    format!(
        "how much the surface bends cannot be measured: its knots at {name} = {} are only {} apart",
        figure(at),
        short(gap)
    )
}
