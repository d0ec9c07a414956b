//! An energy that is least elsewhere: `min ½ dᵀWd - gᵀd` under equations is the least adjustment from its own minimum `W⁻¹g`.

use super::{EditError, Problem, view};
use crate::energy::Energy;
use crate::error::Error;
use crate::functional::Shapes;
use crate::measure::PROPORTION;
use crate::problem::solution::overflow;
use crate::shape::Shape;
use crate::solve::{SparseRows, System};
use crate::text::short;
use crate::{Point, Vector};

impl Problem {
    /// Moves the shapes to where the energy is least by itself, with nothing but what may move. What is asked stays bound to the
    /// numbers of the shapes as they were.
    ///
    /// # Errors
    /// When the energy cannot be measured on these shapes, does not see some motion, or is least where numbers end.
    pub(crate) fn start_at_minimum(&mut self) -> Result<(), EditError> {
        let shapes = view(&self.shapes);
        let may_move = |v: usize| self.freedom.may_move(v);
        let every = (0..shapes.vertex_count()).filter(|&v| may_move(v)).collect();
        let moving = self.freedom.widen(&self.metric, &shapes, every, &may_move)?;
        let pull = self.metric.pull(&shapes, &moving)?;
        if pull.is_empty() || moving.is_empty() {
            return Ok(());
        }
        if pull.len() != moving.len() || pull.iter().any(|g| g.iter().any(|c| !c.is_finite())) {
            return Err(Error::Invalid(format!(
                "the energy \"{}\" pulls at {} control vertices of {} that move, or not by finite numbers",
                self.metric.describe(),
                pull.len(),
                moving.len()
            ))
            .into());
        }
        let alike = self.freedom.is_alike();
        let metric = self.freedom.resolve(&self.metric, &shapes, &moving, !alike)?;
        let (sides, columns) = if alike {
            (3, moving.clone())
        } else {
            (1, moving.iter().flat_map(|v| 3 * v..3 * v + 3).collect())
        };
        let system = System::new(SparseRows::new(columns.len()), columns, sides, metric);
        let pull: Vec<f64> = pull.iter().flat_map(|g| [g.x, g.y, g.z]).collect();
        let (mut way, mut work) = (vec![0.0; pull.len()], vec![0.0; pull.len()]);
        system.inverse_metric()?.apply(&pull, sides, &mut way, &mut work);
        if way.iter().any(|c| !c.is_finite()) {
            return Err(overflow());
        }
        // From farther away, rounding alone would miss what is asked.
        let farthest = way.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let reach = (0..shapes.vertex_count()).map(|v| shapes.vertex(v).coords.amax());
        let targets = self.bound.iter().flat_map(|b| &b.target).map(|t| t.abs());
        let reach = reach.chain(targets).fold(0.0, f64::max);
        if reach > 0.0 && farthest > PROPORTION * reach {
            return Err(Error::Invalid(format!(
                "the energy \"{}\" alone would take control vertices {farthest} away, {} times the size of the shapes: let it pull \
                 less, or weigh more what holds them",
                self.metric.describe(),
                short(farthest / reach),
                farthest = short(farthest)
            ))
            .into());
        }
        self.taken = moving.iter().map(|&v| (v, shapes.vertex(v))).collect();
        move_by(&mut self.shapes, &moving, &way);
        Ok(())
    }

    /// Each vertex that the energy alone took away, and where it was.
    pub(crate) fn taken_from(&self, vertex: usize) -> Option<Point> {
        let at = self.taken.binary_search_by_key(&vertex, |(v, _)| *v).ok()?;
        Some(self.taken[at].1)
    }
}

fn move_by(boxes: &mut [Box<dyn Shape>], moving: &[usize], way: &[f64]) {
    let offsets: Vec<usize> = {
        let shapes: Shapes<'_> = view(boxes);
        (0..=shapes.len()).map(|index| shapes.offset(index)).collect()
    };
    for (&vertex, way) in moving.iter().zip(way.as_chunks::<3>().0) {
        let shape = offsets.partition_point(|&o| o <= vertex) - 1;
        boxes[shape].control_vertices_mut()[vertex - offsets[shape]] += Vector::from(*way);
    }
}
