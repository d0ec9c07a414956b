//! Where chords cross the lines of a carrier.

use loftsman_kernel::Result;

use super::{Chain, Flaw, ONE_PLACE, Path, STEPS};
use crate::brep::carrier::Carrier;

impl Chain {
    /// Where a chord goes across a line of a face. Ends that are near enough to a line are put onto it instead.
    pub(super) fn crossing(
        &mut self,
        part: usize,
        k: usize,
        [a, b]: [[f64; 2]; 2],
        carrier: &Carrier,
    ) -> Result<Option<Flaw>> {
        for d in 0..2 {
            let side = &carrier.sides[d];
            let (low, high) = (a[d].min(b[d]), a[d].max(b[d]));
            let turns: &[f64] = if side.closed { &[-1.0, 0.0, 1.0] } else { &[0.0] };
            let lines = side.lines.iter().flat_map(|line| turns.iter().map(move |turn| (line, turn)));
            let across = lines
                .map(|(line, turn)| (side.wrapped(*line), line + turn * side.length()))
                .find(|(_, line)| *line > low && *line < high);
            let Some((own, line)) = across else { continue };
            let (mut ta, mut tb) = (self.parameters[part], self.parameters[part + 1]);
            let mut near = a;
            let ends = [self.points[part], self.points[part + 1]];
            let mut place = None;
            for _ in 0..STEPS {
                let t = 0.5 * (ta + tb);
                if t <= ta || t >= tb {
                    break;
                }
                let (point, x) = match &self.path {
                    Path::Space { curve, .. } => {
                        let point = curve.point(t)?;
                        let inside = [0, 1].map(|e: usize| carrier.sides[e].wrapped(near[e]));
                        let enough = self.enough();
                        let searches = &mut self.tracks[k].searches;
                        (point, carrier.foot(&point, Some(inside), enough, searches)?.0)
                    }
                    Path::Lifted(curve) => {
                        let p = curve.point(t)?;
                        let at = [0, 1].map(|e: usize| carrier.sides[e].wrapped([p.x, p.y][e]));
                        (carrier.unframed(&carrier.point(at)), [p.x, p.y])
                    }
                };
                let x = [0, 1].map(|e: usize| carrier.sides[e].unwrapped(x[e], near[e]));
                near = x;
                place = Some((t, point));
                if (x[d] < line) == (a[d] < line) {
                    ta = t;
                } else {
                    tb = t;
                }
                if (x[d] - line).abs() <= 1e-13 * side.length() {
                    break;
                }
            }
            let Some((t, point)) = place else { continue };
            let reach = self.goal.size * ONE_PLACE.max(2.0 * self.tolerance.min(0.1 * self.goal.chord));
            let close = ends.map(|end| nalgebra::distance(&end, &point) <= reach);
            if close[0] {
                self.tracks[k].at[part][d] = own;
            } else if close[1] {
                self.tracks[k].at[part + 1][d] = own;
            } else {
                return Ok(Some(Flaw::On(t, k, d, own)));
            }
        }
        Ok(None)
    }
}
