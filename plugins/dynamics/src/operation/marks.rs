//! Where things are held, for pictures: at the end, and in each frame.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Frames, Mark, MarkKind, OperationError, Spot, Track};
use loftsman_kernel::shape::{Derivative, Shape};

use crate::simulation::Simulation;

/// The spots of all places of all constraints, frame by frame.
#[derive(Debug, Default)]
pub(super) struct Spots(Vec<Vec<Option<Spot>>>);

impl Spots {
    /// Remembers where constraints hold now, as one more frame. `O(places)`.
    pub(super) fn keep(&mut self, simulation: &Simulation) -> Result<(), OperationError> {
        let mut next = 0;
        for index in 0..simulation.constraints() {
            let holds = simulation.holds(index)?;
            for (_, at) in simulation.places(index)? {
                if self.0.len() == next {
                    self.0.push(Vec::new());
                }
                self.0[next].push(holds.then_some(Spot::At(at)));
                next += 1;
            }
        }
        Ok(())
    }

    /// Of places that slide, come or go, where they were; all of them where they ended.
    pub(super) fn marks(
        self,
        simulation: &Simulation,
        rate: f64,
        names: &[String],
        seen: &Frames,
        first: &[Box<dyn Shape>],
    ) -> Result<Vec<Mark>, OperationError> {
        let mut all = Vec::new();
        let mut kept = self.0.into_iter();
        for index in 0..simulation.constraints() {
            let stays = simulation.holds(index)?;
            for (place, (body, at)) in simulation.places(index)?.into_iter().enumerate() {
                let spots = kept.next().unwrap_or_default();
                let Some(at) =
                    (if stays { Some(Spot::At(at)) } else { spots.iter().rev().copied().find_map(|s| s) })
                else {
                    continue;
                };
                let Spot::At(location) = at else { continue };
                let changes = spots.iter().any(|spot| *spot != Some(at));
                let shape = seen.own_shape(body, simulation.shape(body)?);
                let before = seen.own_shape(body, first[body].as_ref());
                let point = |shape: &dyn Shape| shape.value(location, Derivative::POSITION).map(Point::from);
                all.push(Mark {
                    object: names[body].clone(),
                    kind: if simulation.slides_at(index, place)? { MarkKind::Slides } else { MarkKind::Kept },
                    position: point(shape.as_ref())?,
                    before: point(before.as_ref())?,
                    vector: None,
                    label: simulation.name_of(index)?.to_owned(),
                    spot: Some(at),
                    track: (changes || !stays).then_some(Track { rate, spots, stays }),
                });
            }
        }
        Ok(all)
    }
}
