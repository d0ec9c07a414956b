//! What came of a match, and how it is told.

use loftsman_kernel::edit::{Corner, Edited};
use loftsman_kernel::functional::Functional;
use loftsman_kernel::plugin::StepReport;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::figure;

use super::asked::Asked;
use super::changed::Changed;
use crate::deviation::Deviation;

/// Another way than the one that is tried first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// It is moved least.
    Least,
    /// Its lines across are led.
    Led,
    /// Both.
    LedLeast,
}

impl Way {
    fn told(self) -> &'static str {
        match self {
            Self::Least => "it is moved as little as can be, and not bent as little (metric = \"least\")",
            Self::Led => {
                "its lines across leave the edge as fast as those of the other arrive there, but for one factor all along"
            }
            Self::LedLeast => {
                "it is moved as little as can be, and its lines across leave the edge as fast as those of the other arrive there, but for one factor all along"
            }
        }
    }
}

/// Why another way was gone than the one that is tried first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instead {
    /// It would fold back on the other surface at the edge.
    Folds,
    /// It would fold back over itself here.
    FoldsAt([f64; 2]),
    /// It would go so far.
    Farther(f64),
    /// None was found.
    NoneFound,
    /// How much it bends cannot be measured.
    Unmeasured,
}

/// An edge that goes no farther than this part of its size stays where it is, but for what solving leaves.
const ROUNDING: f64 = 1e-12;

/// How many times, in words for many.
fn times(ratio: f64) -> String {
    const MANY: f64 = 100.0;
    if ratio < MANY { figure(ratio) } else { "more than 100".to_owned() }
}

/// What a gap counts for, in degrees ([`Corner::change`]).
const GAP: f64 = 360.0;

/// What became of it.
pub(super) struct Made {
    pub(super) edited: Edited<Surface>,
    /// The larger edge's size.
    pub(super) size: f64,
    /// Whether corners could not be kept away.
    pub(super) cornered: bool,
    /// Whether its seam alone was kept closed where corners came.
    pub(super) shut: bool,
    /// Which other way was gone, and why.
    pub(super) way: Option<(Way, Instead)>,
    /// What became of the whole surface.
    pub(super) changed: Changed,
    pub(super) before: Deviation,
    pub(super) after: Deviation,
    /// Control vertices along the edge, before and after.
    pub(super) along: [usize; 2],
    /// The same across.
    pub(super) across: [usize; 2],
    /// Degrees along and across, before and after.
    pub(super) degrees: [[usize; 2]; 2],
}

impl Made {
    /// The sharpest corner that it has made, in degrees; a gap is sharper than all, and so is a seam that would gape if it were not held.
    pub(super) fn corner(&self) -> f64 {
        let held = if self.shut { GAP } else { 0.0 };
        self.edited.report().smooth.corners.iter().map(Corner::change).fold(held, f64::max)
    }

    pub(super) fn report(&self, op: &str, object: &str, asked: &Asked) -> StepReport {
        let report = self.edited.report();
        let mut notes = vec![
            format!(
                "along the edge, before: {}",
                self.before.up_to_in(asked.continuity.max(1), self.size, asked.unit)
            ),
            format!("along the edge, now: {}", self.after.up_to_in(2, self.size, asked.unit)),
        ];
        for (what, [before, after], [old, new]) in [
            ("along", self.along, [self.degrees[0][0], self.degrees[1][0]]),
            ("across", self.across, [self.degrees[0][1], self.degrees[1][1]]),
        ] {
            if before != after {
                let degree =
                    if old == new { String::new() } else { format!(", of degree {new} instead of {old}") };
                notes.push(format!("{after} control vertices {what} the edge instead of {before}{degree}"));
            }
        }
        if let Some((way, why)) = self.way {
            let told = way.told();
            notes.push(match why {
                Instead::Folds => format!("left free it would fold back on the other: {told}"),
                Instead::FoldsAt([u, v]) => {
                    let (u, v) = (figure(u), figure(v));
                    format!("bent as little as can be it would fold back over itself near u = {u}, v = {v}: {told}")
                }
                Instead::Farther(far) => {
                    format!("bent as little as can be it would go {} times as far: {told}", times(far / self.changed.moved))
                }
                Instead::NoneFound => format!("bent as little as can be no surface was found: {told}"),
                Instead::Unmeasured => {
                    format!("how much it bends cannot be measured, which rounding hides: {told}")
                }
            });
        }
        if self.way.is_none() && self.changed.goes_far() {
            // How far it goes is measured by who runs the operation, from the new one to the old one and back: one number for one question.
            let far = if self.changed.edge <= ROUNDING * self.size {
                "parts of it go away from where it was, though its edge stays where it is".to_owned()
            } else {
                format!(
                    "parts of it go {} times as far from where it was as its edge",
                    times(self.changed.moved / self.changed.edge)
                )
            };
            // Where no metric was said the other one was tried.
            let more = if asked.bend && asked.measured {
                "metric = \"least\", or more that stays at the opposite edge (`keep`), holds it back, where they can"
            } else {
                "more that stays at the opposite edge (`keep`) holds it back, where it can"
            };
            notes.push(format!("{far}: {more}"));
        }
        if self.changed.is_lost() {
            let instead = if asked.bend { ": say metric = \"least\"" } else { "" };
            notes.push(format!(
                "control vertices lie many times as far away as the surface is large, as its knots are open outwards{instead}"
            ));
        }
        if let Some([u, v]) = self.changed.fold {
            let (u, v) = (figure(u), figure(v));
            let share = match self.changed.share {
                share if share < 1e-3 => "in a line".to_owned(),
                share => format!("some {} % of it", figure(100.0 * share)),
            };
            let more = if asked.measured {
                "without `metric`, a way without folds is looked for"
            } else {
                "no way without folds was found"
            };
            notes.push(format!("it folds back over itself near u = {u}, v = {v}, {share}: {more}"));
        }
        if self.cornered {
            let why = "meeting the other edge and staying smooth at all knots conflict";
            notes.push(format!("{why}: corners may appear, as where that edge has some"));
        }
        // What is left along the edge is told above.
        let own = format!("{}: ", asked.matching(asked.limits).describe());
        notes.extend(report.notes.iter().filter(|note| !note.starts_with(&own)).cloned());
        StepReport {
            op: op.into(),
            object: Some(object.into()),
            solver: Some(report.solver.clone()),
            equations: Some(report.equations),
            rank: Some(report.rank),
            residual: Some(report.residual),
            condition: Some(report.condition),
            adjustment: Some(report.adjustment),
            iterations: Some(report.iterations),
            convergence: report.convergence,
            // What was asked: behind it are the equations of seams, if any.
            constraints: report.constraints.iter().take(1).cloned().collect(),
            numbers: [("before", &self.before), ("after", &self.after)]
                .into_iter()
                .map(|(when, found)| (when.to_owned(), found.numbers()))
                .collect(),
            smooth: Some(report.smooth.clone()).filter(|smooth| !smooth.is_empty()),
            notes,
            leading: 2,
            ..StepReport::default()
        }
    }
}
