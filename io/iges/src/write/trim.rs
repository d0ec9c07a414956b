//! Trimmed surfaces (144): boundaries (142) as curves in parameters, exactly, and in space, exactly where these run along a parameter or the surface is one affine patch.

use loftsman_kernel::Result;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Space, Surface, Trimmed};

use super::print::{Look, Printer, Purpose, Record};

/// How far curves in space may be off, as a part of the size of the surface: they are there for programs that take no others.
const NEAR: f64 = 1e-7;
/// What was written of a trimmed surface.
pub(crate) struct Written {
    /// An entity for each region.
    pub(crate) items: Vec<u32>,
    pub(crate) changes: Vec<&'static str>,
}

impl Printer {
    /// All regions of a trimmed surface; `Err` with why where it cannot go out.
    pub(crate) fn trimmed(
        &mut self,
        trimmed: &Trimmed,
        look: Look,
        properties: &[u32],
    ) -> Result<std::result::Result<Written, &'static str>> {
        let surface = trimmed.surface().clamped()?;
        let mut changes = Vec::new();
        if let Some(change) = trimmed.surface().change_when_clamped() {
            if !trimmed.loops().flatten().all(|one| inside(&surface, one).unwrap_or(false)) {
                return Ok(Err("its loops run through the seam of a periodic surface: split it there first"));
            }
            changes.push(change);
        }
        if !(trimmed.curves().is_empty() && trimmed.points().is_empty()) {
            changes.push("its special curves and points are left out");
        }
        if trimmed.regions().len() > 1 {
            changes.push("its regions are objects of their own");
        }
        let whole = [Region::default()];
        let regions = if trimmed.regions().is_empty() { &whole } else { trimmed.regions() };
        let mut items = Vec::new();
        for region in regions {
            let of = self.surface(&surface, Look::PART, &[]);
            let mut boundaries = Vec::new();
            let outer = Some(&region.outer).filter(|outer| !outer.is_empty());
            for chain in outer.into_iter().chain(&region.holes) {
                boundaries.push(self.boundary(&surface, of, chain)?);
            }
            let has_outer = i64::from(outer.is_some());
            let holes = region.holes.len();
            let record = Record::new(144).entity(of).whole(has_outer).count(holes);
            let record = if outer.is_some() { record } else { record.whole(0) };
            items.push(self.put(record.entities(&boundaries).properties(properties), look));
        }
        Ok(Ok(Written { items, changes }))
    }

    /// A boundary: in parameters and in space.
    fn boundary(&mut self, surface: &Surface, of: u32, chain: &[ParameterCurve]) -> Result<u32> {
        let net = surface.points();
        let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
        let (mut flat, mut lifted) = (Vec::new(), Vec::new());
        for one in chain {
            let (from, to) = one.range();
            let whole = (from, to) == one.curve().domain();
            let part = if whole { one.curve().clone() } else { one.curve().between(from, to)? };
            let part = part.clamped()?;
            lifted.push(self.curve(&one.on(surface, NEAR * size)?.curve, Look::PART, &[]));
            flat.push(self.curve(&part, Look::PART.purpose(Purpose::Parametric), &[]));
        }
        let flat = self.chain(&flat, Look::PART.purpose(Purpose::Parametric));
        let lifted = self.chain(&lifted, Look::PART);
        let record = Record::new(142).whole(0).entities(&[of, flat, lifted]).whole(1);
        Ok(self.put(record, Look::PART))
    }

    /// Curves as one.
    fn chain(&mut self, curves: &[u32], look: Look) -> u32 {
        match curves {
            [only] => *only,
            _ => self.put(Record::new(102).count(curves.len()).entities(curves), look),
        }
    }
}

/// Whether a curve in parameters is where the surface is.
fn inside(surface: &Surface, one: &ParameterCurve) -> Result<bool> {
    let (from, to) = one.range();
    let part = if (from, to) == one.curve().domain() {
        one.curve().clone()
    } else {
        one.curve().between(from, to)?
    };
    let (low, high) = part.bounds();
    let within = |space: &Space, low: f64, high: f64| {
        let (start, end) = space.domain();
        let slack = 1e-9 * (end - start);
        low >= start - slack && high <= end + slack
    };
    Ok(within(surface.u(), low.x, high.x) && within(surface.v(), low.y, high.y))
}
