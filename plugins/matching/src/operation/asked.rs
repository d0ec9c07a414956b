//! What a match is asked for.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Edge, On, Shapes};
use loftsman_kernel::plugin::{OperationError, Parameters, SceneShapes};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Surface;

use crate::beside::{Beside, edge_of};
use crate::deviation::Limits;
use crate::fields::{continuity, limits};
use crate::matching::{Matching, matching};

/// What is asked.
#[derive(Debug, Clone)]
pub(super) struct Asked {
    pub(super) edge: Edge,
    pub(super) other: On,
    pub(super) other_edge: Edge,
    pub(super) continuity: usize,
    pub(super) limits: Limits,
    pub(super) keep: Option<usize>,
    /// Whether that was said, and is not as the continuity.
    pub(super) keeps: bool,
    /// Whether limits were given that a lower continuity has not.
    pub(super) limited: bool,
    pub(super) bend: bool,
    /// Whether the metric was said.
    pub(super) measured: bool,
    pub(super) refine: bool,
    /// Whether a closed edge may begin between the knots of the other.
    pub(super) free: bool,
    /// Whether the lines across leave the edge as those of the other surface arrive there.
    pub(super) led: bool,
    pub(super) unit: Unit,
}

impl Asked {
    pub(super) fn new(
        p: &Parameters,
        with: &Parameters,
        names: &mut SceneShapes<'_>,
        unit: Unit,
    ) -> Result<Self, OperationError> {
        let other = crate::edge_on::named(with, "object", names)?;
        let continuity = continuity(p)?;
        let keep = if !p.has("keep") {
            Some(continuity)
        } else if p.value("keep").is_some_and(|keep| keep.is_string()) {
            match p.text("keep")? {
                "nothing" => None,
                other => {
                    return Err(p.error("keep", format!("\"{other}\" is not 0, 1, 2 or \"nothing\"")).into());
                }
            }
        } else {
            match p.count("keep")? {
                order @ 0..=2 => Some(order),
                order => {
                    return Err(p.error("keep", format!("{order} is not 0, 1, 2 or \"nothing\"")).into());
                }
            }
        };
        Ok(Self {
            edge: Edge::from_parameters(p, "edge")?,
            other,
            other_edge: Edge::from_parameters(with, "edge")?,
            continuity,
            limits: limits(p, continuity)?,
            keep,
            keeps: p.has("keep"),
            limited: p.has("angle") || p.has("curvature"),
            bend: !p.has("metric") || p.choice("metric", &[("bend", true), ("least", false)])?,
            measured: p.has("metric"),
            refine: !p.has("refine") || p.flag("refine")?,
            free: true,
            led: false,
            unit,
        })
    }

    /// The match with these limits.
    pub(super) fn matching(&self, limits: Limits) -> Matching {
        matching(self.edge, self.other.clone(), self.other_edge, self.continuity, limits)
            .free(self.free)
            .led(self.led)
    }

    /// Rows of control vertices, from an edge on, that a continuity moves.
    pub(super) fn rows(continuity: usize) -> usize {
        continuity + 1
    }

    /// Whether the edge begins beside the other where that has no knots, and would not have to.
    pub(super) fn starts_between(&self, surface: &Surface, other: &dyn Shape) -> Result<bool, Error> {
        let shapes = Shapes::new([surface as &dyn Shape, other]);
        let there = edge_of(&shapes, &self.other, self.other_edge, "match")?;
        let track = |exact: bool| -> Result<_, Error> {
            let edge = edge_of(&shapes, &On::default(), self.edge, "match")?;
            Ok(Beside::new(edge, &there.curve, exact)?.track())
        };
        Ok(track(false)? != track(true)?)
    }
}
