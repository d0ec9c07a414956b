//! What came of a match, and how it is told.

use loftsman_kernel::edit::{Corner, Edited};
use loftsman_kernel::functional::Functional;
use loftsman_kernel::plugin::StepReport;
use loftsman_kernel::spline::Surface;

use super::Asked;
use crate::deviation::Deviation;

/// What keeps a surface from folding back that would where it is bent as little as can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unfolded {
    /// It is moved least.
    Least,
    /// Its lines across are led.
    Led,
}

impl Unfolded {
    fn told(self) -> &'static str {
        match self {
            Self::Least => "it is moved as little as can be, and not bent as little (metric = \"least\")",
            Self::Led => {
                "its lines across leave the edge as fast as those of the other arrive there, but for one factor all along"
            }
        }
    }
}

/// What became of it.
pub(super) struct Made {
    pub(super) edited: Edited<Surface>,
    /// The larger edge's size.
    pub(super) size: f64,
    /// Whether corners could not be kept away.
    pub(super) cornered: bool,
    /// What keeps it from folding back.
    pub(super) unfolded: Option<Unfolded>,
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
    /// The sharpest corner that it has made, in degrees; a gap is sharper than all.
    pub(super) fn corner(&self) -> f64 {
        self.edited.report().smooth.corners.iter().map(Corner::change).fold(0.0, f64::max)
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
        if let Some(unfolded) = self.unfolded {
            notes.push(format!("left free it would fold back on the other: {}", unfolded.told()));
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
            constraints: report.constraints.clone(),
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
