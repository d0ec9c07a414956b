//! Why a match is refused, and what helps: remedies are tried before they are named.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::plugin::{Context, OperationError};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::{figure, measured, short};

use super::TOLERANCE;
use super::asked::Asked;
use super::attempt::Work;
use crate::deviation::{Deviation, Limits, MORE};
use crate::history::Attempt;

/// A match that is not within its limits.
#[derive(Debug)]
pub(super) struct Refused {
    /// Control vertices along the edge.
    pub(super) count: usize,
    /// What was left; nothing where no surface was found.
    pub(super) worst: Option<Deviation>,
    /// Of the larger edge.
    pub(super) size: f64,
    pub(super) why: Why,
}

/// Why more knots do not help.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Why {
    /// No surface solves the equations.
    NoneFound,
    /// How much it bends cannot be measured, for this reason.
    Unmeasured(String),
    /// They would be too much work.
    Work,
    /// So many would be needed.
    Needs {
        needed: usize,
        most: usize,
    },
    /// It lay on the other before, folded back.
    LayOn,
    /// It would.
    Folds,
    FoldsInPart,
    /// They bring it no nearer.
    Limits,
}

impl Refused {
    pub(super) fn of(last: Option<&Attempt>, size: f64, why: Why) -> Self {
        Self { count: last.map_or(0, |last| last.count), worst: last.map(|last| last.worst), size, why }
    }

    /// Whether it would fold back on the other, and did not lie on it before.
    pub(super) fn folds(&self) -> bool {
        matches!(self.why, Why::Folds | Why::FoldsInPart)
    }
}

impl Asked {
    /// The refusal, with the remedies that were tried and helped: the limits that are met, and the first of the others.
    pub(super) fn told(
        &self,
        refused: &Refused,
        surface: &Surface,
        other: &dyn Shape,
        context: &Context<'_>,
        work: &Work,
    ) -> Result<OperationError, OperationError> {
        let count = refused.count;
        let what = match (&refused.worst, &refused.why) {
            (_, Why::Unmeasured(why)) => why.clone(),
            (Some(worst), _) => format!(
                "with {count} control vertices along the edge the surfaces are still apart by {}",
                worst.up_to_in(self.continuity, refused.size, self.unit)
            ),
            (None, _) => format!(
                "with {count} control vertices along the edge no surface was found that meets the other with continuity {}",
                self.continuity
            ),
        };
        let why = match &refused.why {
            Why::NoneFound | Why::Limits | Why::Unmeasured(_) => String::new(),
            Why::Work => ": more of them would take too much work".to_owned(),
            Why::Needs { needed, most } => format!(": some {needed} would be needed, and {most} are the most"),
            Why::LayOn => ": the surface lies on the other, folded back, and there is no side to bend it round on: turn it round first".to_owned(),
            Why::Folds => ": brought there it would fold back on the other".to_owned(),
            Why::FoldsInPart => ": along a part of the edge it would fold back on the other, as where an edge turns back or a \
                                 surface shrinks to a point"
                .to_owned(),
        };
        // A smooth edge cannot meet one with a corner.
        let shapes = Shapes::new([surface as &dyn Shape, other]);
        let corner = if self.continuity > 0 {
            self.matching(self.limits).corner_there(&shapes).unwrap_or_default()
        } else {
            None
        };
        let corner = corner.map_or_else(String::new, |(angle, at)| {
            format!(
                "; the other surface has a corner of {}° along {}{}, at {} of it",
                figure(angle.to_degrees()),
                self.other_edge,
                self.other,
                measured(at)
            )
        });
        let mut helps = Vec::new();
        let mut tries = self.remedies(refused);
        // One limit may do, where all are missed.
        let more =
            |distance: bool| refused.worst.and_then(|worst| self.allowing(&worst, refused.size, distance));
        let (one, all) = (more(false), more(true));
        let tried = [one.filter(|(_, words)| all.as_ref().is_some_and(|(_, all)| words != all)), all];
        let works = |asked: &Self| -> Result<bool, OperationError> {
            let mut work = Work { called: "remedy", ..work.as_much_again() };
            match asked.best(surface, other, context, &mut work) {
                Ok(made) => Ok(made.is_ok()),
                // Whoever asked may have had enough; all else is no remedy.
                Err(error) => {
                    context.observer.proceed("remedy", 0, 0)?;
                    drop(error);
                    Ok(false)
                }
            }
        };
        for (asked, words) in tried.into_iter().flatten() {
            if works(&asked)? {
                helps.push(words);
                break;
            }
        }
        for (asked, words) in tries.drain(..) {
            if works(&asked)? {
                helps.push(words);
                break;
            }
        }
        let advice = match &helps[..] {
            [] if refused.why == Why::LayOn => String::new(),
            [] => ": nothing that was tried helps: smooth the edge that stands still there, or bring the surface nearer to it by hand"
                .to_owned(),
            _ => format!(": {}", helps.join(", or ")),
        };
        Ok(Error::Invalid(format!("{what}{why}{corner}{advice}")).into())
    }

    /// What may help, and how it is said, in the order in which it is tried.
    fn remedies(&self, refused: &Refused) -> Vec<(Self, String)> {
        let mut tries = Vec::new();
        if !self.refine {
            tries.push((
                Self { refine: true, ..self.clone() },
                "let knots be inserted (refine = true)".to_owned(),
            ));
        }
        let unmeasured = matches!(refused.why, Why::Unmeasured(_));
        if unmeasured {
            tries.push((Self { bend: false, ..self.clone() }, "say metric = \"least\"".to_owned()));
        } else if matches!(refused.why, Why::Work | Why::NoneFound) || refused.folds() {
            let freed = Self { keep: None, ..self.clone() };
            let metric = if self.bend { "least" } else { "bend" };
            // Where none was said, the other was tried where that may help.
            if self.measured || refused.why == Why::Work {
                tries.push((Self { bend: !self.bend, ..self.clone() }, format!("say metric = \"{metric}\"")));
            }
            if self.keep.is_some() {
                let words = format!("let more of it move (keep = \"nothing\", metric = \"{metric}\")");
                tries.push((freed.clone(), "let more of it move (keep = \"nothing\")".to_owned()));
                tries.push((Self { bend: !self.bend, ..freed }, words));
            }
        }
        // What lay on the other does so with tangent planes as well.
        let least = if refused.why == Why::LayOn { self.continuity.min(1) } else { self.continuity };
        for continuity in (0..least).rev() {
            let keep = if self.keeps { self.keep } else { Some(continuity) };
            let limits = if continuity == 0 {
                Limits { distance: self.limits.distance, ..Limits::default() }
            } else {
                self.limits
            };
            let refine = if self.refine { "" } else { " and refine = true" };
            let without = if self.limited { ", without the limits of more" } else { "" };
            let words = format!("ask for continuity {continuity}{refine}{without}");
            // With any continuity it bends beyond measure.
            let (bend, words) = if unmeasured {
                (false, format!("say metric = \"least\" and {words}"))
            } else {
                (self.bend, words)
            };
            let lower = Self { continuity, keep, limits, bend, refine: true, ..self.clone() };
            let least =
                (continuity > 0 && self.measured && bend).then(|| Self { bend: false, ..lower.clone() });
            let as_well = format!("{words} and metric = \"least\"");
            tries.push((lower, words));
            tries.extend(least.map(|least| (least, as_well)));
        }
        // Where none was found with curvature, all else with curvature takes as long: what is linear is tried first.
        if refused.why == Why::NoneFound && self.continuity > 1 {
            // But for the metric that was not said.
            let other = |asked: &Self| self.measured && asked.bend != self.bend && asked.keep == self.keep;
            tries.sort_by_key(|(asked, _)| asked.continuity != 1 && !other(asked));
        }
        tries
    }

    /// The same with as much allowed as was reached, of position only where that is asked for; nothing where that would be a fold.
    fn allowing(&self, worst: &Deviation, size: f64, distance: bool) -> Option<(Self, String)> {
        let mut asked = self.clone();
        let mut words = Vec::new();
        let more = |found: f64| short(found * MORE).parse::<f64>().ok().filter(|more| *more >= found);
        if distance && worst.distance > self.limits.distance.unwrap_or(TOLERANCE * size) {
            asked.limits.distance = Some(more(worst.distance)?);
            words.push(format!("tolerance = {}", short(worst.distance * MORE)));
        }
        if self.continuity > 0 && worst.angle > self.limits.angle {
            if worst.angle > std::f64::consts::FRAC_PI_2 {
                return None;
            }
            let degrees = more(worst.angle.to_degrees())?;
            asked.limits.angle = degrees.to_radians();
            words.push(format!("angle = {}", short(worst.angle.to_degrees() * MORE)));
        }
        if self.continuity > 1 && worst.part > self.limits.curvature {
            let percent = more(100.0 * worst.part)?;
            asked.limits.curvature = percent / 100.0;
            words.push(format!("curvature = {}", short(100.0 * worst.part * MORE)));
        }
        (!words.is_empty()).then(|| (asked, format!("allow more ({})", words.join(", "))))
    }
}
