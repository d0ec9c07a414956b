//! Which control vertices may move, and how.

use super::metric::Metric;
use super::unknowns::Unknowns;
use crate::energy::Energy;
use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::solve::SystemMetric;

/// Which vertices may move: global numbers, ascending.
#[derive(Debug, Clone, Default)]
pub(crate) struct Freedom {
    pub(crate) locked: Vec<usize>,
    pub(crate) only: Option<Vec<usize>>,
    /// The interval that the edit is kept within, where `only` comes from one.
    pub(crate) within: Option<(f64, f64)>,
    /// Vertices that belong to the problem though nothing touches them where the shapes are: something did elsewhere.
    pub(crate) reached: Vec<usize>,
    /// The unknowns, where they are not the vertices.
    pub(crate) unknowns: Option<Box<Unknowns>>,
}

impl Freedom {
    pub(crate) fn may_move(&self, vertex: usize) -> bool {
        self.locked.binary_search(&vertex).is_err()
            && self.only.as_ref().is_none_or(|only| only.binary_search(&vertex).is_ok())
    }

    /// Whether every vertex may move.
    pub(crate) fn is_all(&self) -> bool {
        self.locked.is_empty() && self.only.is_none()
    }

    /// The vertices that move where these do, ascending: those that the metric takes along, or all that unknowns move.
    pub(crate) fn widen(
        &self,
        metric: &Metric,
        shapes: &Shapes<'_>,
        touched: Vec<usize>,
        may_move: &dyn Fn(usize) -> bool,
    ) -> Result<Vec<usize>> {
        let Some(unknowns) = &self.unknowns else { return metric.takes_along(shapes, touched, may_move) };
        let count = shapes.vertex_count();
        if let Some(last) = unknowns.vertices().last().filter(|v| **v >= count) {
            return Err(Error::Invalid(format!(
                "unknowns move control vertex {last}, but there are {count}, numbered from 0"
            )));
        }
        Ok(unknowns.vertices().as_ref().clone())
    }

    /// Whether all vertices that may move do where one does.
    pub(crate) fn takes_all(&self, metric: &Metric) -> bool {
        self.unknowns.is_some() || metric.takes_all()
    }

    /// Whether x, y and z can be solved for side by side.
    pub(crate) fn is_alike(&self) -> bool {
        self.unknowns.as_ref().is_none_or(|unknowns| unknowns.is_alike())
    }

    /// The metric over the vertices that move.
    pub(crate) fn resolve(
        &self,
        metric: &Metric,
        shapes: &Shapes<'_>,
        moving: &[usize],
        per_axis: bool,
    ) -> Result<SystemMetric> {
        match &self.unknowns {
            None if per_axis => Ok(metric.form(shapes, moving)?.per_axis()),
            None => metric.form(shapes, moving),
            Some(unknowns) => unknowns.resolve(metric, shapes, per_axis),
        }
    }

    /// What could be done where nothing that may move has influence.
    pub(crate) fn advice(&self) -> String {
        if self.unknowns.is_some() {
            return "release it, or give unknowns that reach it".to_owned();
        }
        match (self.within, self.only.is_some(), self.locked.is_empty()) {
            (Some((start, end)), _, true) => format!("widen within = [{start}, {end}], or release it"),
            (Some((start, end)), _, false) => format!("unlock one, or widen within = [{start}, {end}]"),
            (None, true, true) => "widen the locality, or release it".to_owned(),
            (None, true, false) => "unlock one, or widen the locality".to_owned(),
            (None, false, false) => "unlock one, or release it".to_owned(),
            (None, false, true) => "release it".to_owned(),
        }
    }
}
