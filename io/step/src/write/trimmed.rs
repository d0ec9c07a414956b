//! Trimmed surfaces: what curves in the parameters of a surface bound, exactly.

use loftsman_kernel::Result;
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Surface, Trimmed};

use super::print::{Printer, flag, references};
use crate::part21::encode;

/// What was written of a trimmed surface.
pub(super) struct Written {
    /// An entity for each region.
    pub(super) items: Vec<u64>,
    pub(super) changes: Vec<&'static str>,
}

impl Printer {
    /// All regions of a trimmed surface under a name; `Err` with why where it cannot go out.
    pub(super) fn trimmed(
        &mut self,
        trimmed: &Trimmed,
        name: &str,
    ) -> Result<std::result::Result<Written, &'static str>> {
        let surface = trimmed.surface().clamped()?;
        let mut changes = Vec::new();
        if let Some(change) = trimmed.surface().change_when_clamped() {
            for one in trimmed.loops().flatten() {
                if !inside(&surface, one)? {
                    return Ok(Err(
                        "its loops run through the seam of a periodic surface: split it there first",
                    ));
                }
            }
            changes.push(change);
        }
        if !(trimmed.curves().is_empty() && trimmed.points().is_empty()) {
            changes.push("its special curves and points are left out");
        }
        if trimmed.regions().len() > 1 {
            changes.push("its regions are objects of their own");
        }
        let of = self.surface(&surface);
        let mut items = Vec::new();
        for region in trimmed.regions() {
            let outer = Some(&region.outer).filter(|outer| !outer.is_empty());
            let mut bounds = Vec::new();
            for (chain, kind) in outer
                .map(|outer| (outer, "OUTER_BOUNDARY_CURVE"))
                .into_iter()
                .chain(region.holes.iter().map(|hole| (hole, "BOUNDARY_CURVE")))
            {
                bounds.push(self.boundary(of, chain, kind)?);
            }
            if bounds.is_empty() {
                changes.push("a region without loops is the whole surface");
                items.push(of);
                continue;
            }
            let (bounds, implicit) = (references(&bounds), flag(outer.is_none()));
            items.push(
                self.put(&format!("CURVE_BOUNDED_SURFACE({},#{of},{bounds},{implicit})", encode(name))),
            );
        }
        if trimmed.regions().is_empty() {
            changes.push("as a surface without loops, which it is");
            items.push(of);
        }
        Ok(Ok(Written { items, changes }))
    }

    /// A loop: a chain of parameter curves.
    fn boundary(&mut self, surface: u64, chain: &[ParameterCurve], kind: &str) -> Result<u64> {
        let mut segments = Vec::with_capacity(chain.len());
        for one in chain {
            let (from, to) = one.range();
            let whole = (from, to) == one.curve().domain();
            let part = if whole { one.curve().to_clamped()? } else { one.curve().between(from, to)? };
            let curve = self.parameter_curve(&part, surface);
            segments.push(self.put(&format!("COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{curve})")));
        }
        Ok(self.put(&format!("{kind}('',{},.F.)", references(&segments))))
    }
}

/// Whether a parameter curve is inside the domain of a surface.
fn inside(surface: &Surface, one: &ParameterCurve) -> Result<bool> {
    let (from, to) = one.range();
    let (low, high) = one.curve().between(from, to)?.bounds();
    let domains = [surface.u().domain(), surface.v().domain()];
    Ok((0..2).all(|k| {
        let (a, b) = domains[k];
        let slack = 1e-9 * (b - a);
        low[k] >= a - slack && high[k] <= b + slack
    }))
}
