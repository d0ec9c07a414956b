//! Trimmed surfaces (144): boundaries (142) as curves in parameters, exactly, and in space, exactly where these run along a parameter.

use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface, Trimmed};
use loftsman_kernel::{Error, Point, Result};

use super::print::{Look, Printer, Purpose, Record};

/// How far curves in space may be off, as a part of the size of the surface: they are there for programs that take no others.
const NEAR: f64 = 1e-7;
/// As often at most a piece of such a curve is halved.
const DEEPEST: usize = 12;

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
        let (mut flat, mut lifted) = (Vec::new(), Vec::new());
        for one in chain {
            let (from, to) = one.range();
            let whole = (from, to) == one.curve().domain();
            let part = if whole { one.curve().clone() } else { one.curve().between(from, to)? };
            let part = part.clamped()?;
            lifted.push(self.curve(&on_surface(surface, &part)?, Look::PART, &[]));
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

/// The curve on a surface over a curve in its parameters: along one of these exactly, else by cubic pieces that keep point and
/// tangent at their ends.
fn on_surface(surface: &Surface, flat: &Curve) -> Result<Curve> {
    let points = flat.points();
    let (first, last) = (points[0], points[points.len() - 1]);
    let straight = flat.degree() == 1 && points.len() == 2 && flat.weights().is_none();
    for (direction, at, ends) in [
        (Direction::U, [first.x, last.x], [first.y, last.y]),
        (Direction::V, [first.y, last.y], [first.x, last.x]),
    ] {
        if straight && at[0] == at[1] && ends[0] != ends[1] {
            let along = surface.space(direction.other()).domain();
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let (across, inner) = (surface.space(direction).domain(), low >= along.0 && high <= along.1);
            if inner && (across.0..=across.1).contains(&at[0]) {
                let curve = surface.isocurve(direction, at[0])?;
                let part = if (low, high) == along { curve } else { curve.between(low, high)? };
                return if ends[0] < ends[1] { Ok(part) } else { part.reverse() };
            }
        }
    }
    let net = surface.points();
    let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
    let mut lift = Lift { surface, flat, near: NEAR * size, knots: Vec::new(), net: Vec::new() };
    let breaks = flat.space().breakpoints();
    for pair in breaks.windows(2) {
        lift.piece(pair[0], pair[1], 0)?;
    }
    let end = flat.domain().1;
    let mut knots = vec![breaks[0]];
    knots.extend(lift.knots.iter().flat_map(|t| [*t; 3]));
    knots.extend([end; 4]);
    Curve::new(Space::open(3, knots)?, lift.net)
}

/// Pieces of a curve on a surface.
struct Lift<'a> {
    surface: &'a Surface,
    flat: &'a Curve,
    near: f64,
    /// Where the pieces start.
    knots: Vec<f64>,
    net: Vec<Point>,
}

impl Lift<'_> {
    /// Point and derivative at a parameter.
    fn at(&self, t: f64) -> Result<(Point, loftsman_kernel::Vector)> {
        let (p, d) = (self.flat.point(t)?, self.flat.derivative(t, 1)?);
        let clamp = |space: &Space, x: f64| x.clamp(space.domain().0, space.domain().1);
        let (u, v) = (clamp(self.surface.u(), p.x), clamp(self.surface.v(), p.y));
        let along = self.surface.derivative(u, v, 1, 0)? * d.x + self.surface.derivative(u, v, 0, 1)? * d.y;
        Ok((self.surface.point(u, v)?, along))
    }

    fn piece(&mut self, from: f64, to: f64, depth: usize) -> Result<()> {
        let h = to - from;
        let ((a, da), (b, db)) = (self.at(from)?, self.at(to)?);
        let piece = [a, a + da * (h / 3.0), b - db * (h / 3.0), b];
        let mut off = 0.0_f64;
        for s in [0.25, 0.5, 0.75] {
            let r = 1.0 - s;
            let by = [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s];
            let on: loftsman_kernel::Vector = piece.iter().zip(by).map(|(p, w)| p.coords * w).sum();
            // By components, whose squares may overflow; what is no number stays that.
            let away = (on - self.at(from + s * h)?.0.coords).abs();
            off = away.iter().fold(off, |off, x| if *x <= off { off } else { *x });
        }
        if !off.is_finite() {
            return Err(Error::Invalid(
                "a curve on a trimmed surface overflows; scale the surface down".into(),
            ));
        }
        let middle = 0.5 * (from + to);
        if off > self.near && depth < DEEPEST && from < middle && middle < to {
            self.piece(from, middle, depth + 1)?;
            return self.piece(middle, to, depth + 1);
        }
        self.knots.push(from);
        self.net.pop();
        self.net.extend(piece);
        Ok(())
    }
}
