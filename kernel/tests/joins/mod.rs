//! Joins of whole edges, looked at all along by an evaluator of the tests' own.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

mod book;
mod closed;
mod family;
mod pairs;

use std::sync::Arc;

use loftsman_kernel::edit::{Ask, Edit, EditError};
use loftsman_kernel::functional::{Edge, Functional, Join, Shapes, join};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Solver, Sparse};
use loftsman_kernel::spline::Surface;

pub(crate) const EDGES: [(&str, Edge); 4] =
    [("u0", Edge::UStart), ("u1", Edge::UEnd), ("v0", Edge::VStart), ("v1", Edge::VEnd)];

pub(crate) fn edge(name: &str) -> Edge {
    EDGES.iter().find(|(n, _)| *n == name).unwrap().1
}

pub(crate) fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
        Arc::new(Sparse),
        Arc::new(Adjoint),
    ]
}

/// A join of `a`'s edge with `b`'s.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    pub(crate) a: Surface,
    pub(crate) b: Surface,
    pub(crate) edges: (&'static str, &'static str),
    pub(crate) order: usize,
}

impl Pair {
    pub(crate) fn join(&self) -> Join {
        join(edge(self.edges.0), 1, edge(self.edges.1), self.order)
    }

    pub(crate) fn edit(&self) -> Edit<Surface> {
        Edit::new(&self.a).with(Box::new(self.b.clone()))
    }

    pub(crate) fn solve(&self, join: Join, solver: Arc<dyn Solver>) -> Result<Self, EditError> {
        self.done(self.edit().ask(join.hold()), solver)
    }

    pub(crate) fn done(&self, edit: Edit<Surface>, solver: Arc<dyn Solver>) -> Result<Self, EditError> {
        let edited = edit.solve_with(solver)?;
        let any: &dyn std::any::Any = edited.shape_at(1).unwrap();
        let b = any.downcast_ref::<Surface>().unwrap().clone();
        Ok(Self { a: edited.shape().clone(), b, ..*self })
    }

    pub(crate) fn shapes(&self) -> Shapes<'_> {
        Shapes::new([&self.a as &dyn Shape, &self.b])
    }

    /// The largest difference of each order at 100 places and both ends, of the size of the numbers there; `there` is the
    /// relative parameter of the second at one of the first.
    pub(crate) fn apart(&self, there: impl Fn(f64) -> f64) -> Vec<f64> {
        let along =
            |s: &Surface, edge: &str| if edge.starts_with('u') { s.v().domain() } else { s.u().domain() };
        let (p, q) = (along(&self.a, self.edges.0), along(&self.b, self.edges.1));
        let turn = self.edges.0.ends_with('1') == self.edges.1.ends_with('1');
        let mut apart = vec![0.0_f64; self.order + 1];
        for i in 0..=101 {
            let x = f64::from(i) / 101.0;
            let at = |(start, end): (f64, f64), x: f64| (start + (end - start) * x).clamp(start, end);
            let first = book::across(&self.a, self.edges.0, at(p, x), self.order);
            let second = book::across(&self.b, self.edges.1, at(q, there(x)), self.order);
            for k in 0..=self.order {
                let sign = if turn && k == 1 { -1.0 } else { 1.0 };
                let size = book::size(&self.a, self.edges.0, k).max(book::size(&self.b, self.edges.1, k));
                // Of a degree below the order, nothing is left to compare by: the derivative is zero.
                let gap = (first[k] - second[k] * sign).norm() / if size > 0.0 { size } else { 1.0 };
                assert!(!gap.is_nan());
                apart[k] = apart[k].max(gap);
            }
        }
        apart
    }

    /// What the join's witness finds, of the size of the net.
    pub(crate) fn witnessed(&self, start: &Self, join: &Join) -> f64 {
        let bound = join.bind(&start.shapes()).unwrap().unwrap();
        let witness = bound.witness(&self.shapes()).unwrap().unwrap();
        let mut value = vec![f64::NAN; witness.equations()];
        witness.value(&self.shapes(), &mut value).unwrap();
        let size = book::size(&self.a, self.edges.0, 0).max(book::size(&self.b, self.edges.1, 0));
        value.iter().fold(0.0_f64, |m, v| if v.is_nan() { f64::INFINITY } else { m.max(v.abs()) }) / size
    }

    /// The largest distance that the join's witness finds.
    pub(crate) fn farthest(&self, start: &Self, join: &Join) -> f64 {
        let bound = join.bind(&start.shapes()).unwrap().unwrap();
        let witness = bound.witness(&self.shapes()).unwrap().unwrap();
        let mut value = vec![f64::NAN; witness.equations()];
        witness.value(&self.shapes(), &mut value).unwrap();
        let length = |v: &[f64; 3]| v.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
        value.as_chunks::<3>().0.iter().map(length).fold(0.0, f64::max)
    }
}
