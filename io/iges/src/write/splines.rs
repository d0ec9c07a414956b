//! Shapes of plug-ins that are splines exactly.

use loftsman_kernel::plugin::Splines;

use super::print::{Look, Printer};

impl Printer {
    /// Writes the splines that a shape is: the entities, as what, and what comes back changed.
    ///
    /// # Errors
    /// Only when numbers overflow.
    pub(super) fn splines(
        &mut self,
        splines: &Splines,
        look: Look,
        properties: &[u32],
    ) -> loftsman_kernel::Result<(Vec<u32>, &'static str, Vec<&'static str>)> {
        let (mut items, mut changes) = (Vec::new(), vec!["the splines that it is exactly"]);
        let mut changed = |change: Option<&'static str>| match change {
            Some(change) if !changes.contains(&change) => changes.push(change),
            _ => {}
        };
        let form = match splines {
            Splines::Curves(curves) => {
                for curve in curves {
                    items.push(self.curve(curve.clamped()?.as_ref(), look, properties));
                    changed(curve.change_when_clamped());
                }
                "B-spline curves"
            }
            Splines::Surfaces(surfaces) => {
                for surface in surfaces {
                    items.push(self.surface(surface.clamped()?.as_ref(), look, properties));
                    changed(surface.change_when_clamped());
                }
                "B-spline surfaces"
            }
        };
        Ok((items, form, changes))
    }
}
