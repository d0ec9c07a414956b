//! Two edges side by side: which way they run, where in one a place of the other is, and one space for both.

use super::side::SurfaceEdge;
use crate::error::Result;
use crate::spline::{Conversion, Space};

/// Ends, knots and distances that differ by less than this part of what they are measured by are taken for the same when
/// it comes to *choosing* how edges run. Nothing is computed with it.
const SAME: f64 = 1e-9;
/// Knots that are apart by more than rounding but by less than this part of the edge were meant to be one.
const NEARLY: f64 = 1e-7;
/// Places at which closed edges are compared.
const SAMPLES: usize = 16;

/// How the second edge is run through where the first is run from its start to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Track {
    reversed: bool,
    /// The breakpoint of the second edge at which it starts; not one of its ends only where both edges are closed.
    cut: usize,
}

/// Two edges and how they lie to one another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub(crate) first: &'a SurfaceEdge<'a>,
    pub(crate) second: &'a SurfaceEdge<'a>,
    track: Track,
    /// Where the second edge starts.
    start: f64,
}

/// Every coefficient of an edge in a larger space, made of its own: `Σ c_i h_i`.
pub(crate) type Map = Vec<Terms>;

/// Numbers of coefficients, and how much of each.
pub(crate) type Terms = Vec<(usize, f64)>;

/// The second's space beside the first's, its coefficients, and two knots that nearly agree.
type Aligned = (Space, Map, Option<(f64, f64)>);

/// Both edges in one space, over the first one's domain.
pub(crate) struct Common {
    pub(crate) space: Space,
    pub(crate) first: Map,
    pub(crate) second: Map,
    /// Two knots, in the first one's domain, that were meant to be one and are not.
    pub(crate) nearly: Option<(f64, f64)>,
}

impl<'a> Pair<'a> {
    /// How two edges lie to one another now: open ones run the way in which their ends are nearer to one another. Closed
    /// ones run the way, and start at the breakpoint of the second, that bring them nearest to one another, all round;
    /// where that is so with some for which the breakpoints agree, one of those.
    pub(crate) fn new(first: &'a SurfaceEdge<'a>, second: &'a SurfaceEdge<'a>) -> Result<Self> {
        let spans = second.space().spans().count();
        let straight = Self::on(first, second, Track { reversed: false, cut: 0 });
        let reversed = Self::on(first, second, Track { reversed: true, cut: spans });
        let ends = |side: &SurfaceEdge<'_>| -> Result<_> {
            let (a, b) = side.space().domain();
            Ok((side.point(a)?, side.point(b)?))
        };
        let closed = is_closed(first)? && is_closed(second)?;
        if !closed {
            let ((p0, p1), (q0, q1)) = (ends(first)?, ends(second)?);
            let (along, against) = ((p0 - q0).norm() + (p1 - q1).norm(), (p0 - q1).norm() + (p1 - q0).norm());
            if !ties(along, against) {
                return Ok(if along < against { straight } else { reversed });
            }
        }
        let mut candidates = vec![straight, reversed];
        if closed {
            for cut in 1..spans {
                let track = |reversed| Track { reversed, cut };
                candidates.extend([false, true].map(|reversed| Self::on(first, second, track(reversed))));
            }
        }
        let alike: Vec<bool> = candidates.iter().map(Self::breakpoints_agree).collect();
        let only_alike = alike.contains(&true) && closed;
        let (a, b) = first.space().domain();
        let places = (0..SAMPLES).map(|i| a + (b - a) * (i as f64 + 0.5) / SAMPLES as f64);
        let points = places.map(|t| Ok((t, first.point(t)?))).collect::<Result<Vec<_>>>()?;
        let mut best: Option<(f64, bool, Self)> = None;
        for (pair, alike) in candidates.into_iter().zip(alike).filter(|(_, alike)| *alike || !only_alike) {
            let mut far = 0.0;
            for (t, point) in &points {
                far += (second.point(pair.there(*t))? - point).norm();
            }
            let better =
                best.as_ref().is_none_or(
                    |(least, agrees, _)| {
                        if ties(far, *least) { alike && !agrees } else { far < *least }
                    },
                );
            if better {
                best = Some((far, alike, pair));
            }
        }
        Ok(best.map_or(straight, |(.., pair)| pair))
    }

    /// The same two edges as when they lay to one another in this way.
    pub(crate) fn on(first: &'a SurfaceEdge<'a>, second: &'a SurfaceEdge<'a>, track: Track) -> Self {
        let start = second.space().breakpoints().get(track.cut).copied();
        let (c, d) = second.space().domain();
        let start = start.unwrap_or(if track.reversed { d } else { c });
        Self { first, second, track, start }
    }

    pub(crate) fn track(&self) -> Track {
        self.track
    }

    /// The factor of the second's derivative of an order: both are taken as of a path that crosses the joint.
    pub(crate) fn sign(&self, order: usize) -> f64 {
        if self.first.at_end() == self.second.at_end() && order % 2 == 1 { -1.0 } else { 1.0 }
    }

    /// The second's parameter at the first's `t`.
    pub(crate) fn there(&self, t: f64) -> f64 {
        let ((a, b), (c, d)) = (self.first.space().domain(), self.second.space().domain());
        let x = (t - a) / (b - a);
        let u = if self.track.reversed { self.start - x * (d - c) } else { self.start + x * (d - c) };
        let whole = self.start == if self.track.reversed { d } else { c };
        let wrapped = if whole || (c..=d).contains(&u) {
            u
        } else if u > d {
            u - (d - c)
        } else {
            u + (d - c)
        };
        wrapped.clamp(c, d)
    }

    /// The first's parameter at the second's `u`.
    pub(crate) fn here(&self, u: f64) -> f64 {
        let ((a, b), (c, d)) = (self.first.space().domain(), self.second.space().domain());
        let x = if self.track.reversed { self.start - u } else { u - self.start } / (d - c);
        (a + if x < 0.0 { x + 1.0 } else { x } * (b - a)).clamp(a, b)
    }

    /// A place of both between two of the first's parameters, the one of the domain whose numbers are coarser taken as it
    /// is: what the other's are rounded by is less.
    pub(crate) fn place(&self, t: f64) -> (f64, f64) {
        let coarse = |space: &Space| {
            let (a, b) = space.domain();
            a.abs().max(b.abs()) / (b - a)
        };
        let u = self.there(t);
        if coarse(self.second.space()) > coarse(self.first.space()) { (self.here(u), u) } else { (t, u) }
    }

    /// Whether the breakpoints of both are the same.
    fn breakpoints_agree(&self) -> bool {
        let (a, b) = self.first.space().domain();
        let inner = |t: &f64| *t - a > SAME * (b - a) && b - *t > SAME * (b - a);
        let mut there: Vec<f64> = self.second.space().breakpoints().iter().map(|&u| self.here(u)).collect();
        there.sort_by(f64::total_cmp);
        // Where a closed edge is cut open elsewhere, its two ends come to lie at one place.
        there.dedup_by(|u, before| *u - *before <= SAME * (b - a));
        let (mut here, mut there) =
            (self.first.space().breakpoints().into_iter().filter(inner), there.into_iter().filter(inner));
        loop {
            match (here.next(), there.next()) {
                (None, None) => return true,
                (Some(t), Some(u)) if (t - u).abs() <= SAME * (b - a) => {}
                _ => return false,
            }
        }
    }

    /// One space for both: that of the first where the second has the same, else the least one that contains both.
    pub(crate) fn common(&self) -> Result<Common> {
        let first = self.first.space();
        let (second, map, nearly) = self.aligned()?;
        let own = (0..first.len()).map(|i| vec![(i, 1.0)]).collect();
        if *first == second {
            return Ok(Common { space: second, first: own, second: map, nearly });
        }
        let steps = first.common(&second)?;
        let end = |steps: &[Conversion], start: Space| steps.last().map_or(start, |last| last.to().clone());
        let space = end(&steps.first, first.clone());
        let all = |map: Map, steps: &[Conversion]| steps.iter().fold(map, |map, step| after(step, &map));
        Ok(Common { space, first: all(own, &steps.first), second: all(map, &steps.second), nearly })
    }

    /// The second's space as it lies beside the first's: reversed, cut open elsewhere, over the first's domain, its knots on
    /// the first's where they differ by rounding only.
    fn aligned(&self) -> Result<Aligned> {
        let mut space = self.second.space().clone();
        let mut map: Map = (0..space.len()).map(|i| vec![(i, 1.0)]).collect();
        let (mut cut, spans) = (self.track.cut, space.spans().count());
        if self.track.reversed {
            let reversing = space.reversing()?;
            map = after(&reversing, &map);
            space = reversing.to().clone();
            cut = spans - cut.min(spans);
        }
        if cut % spans != 0 {
            (space, map) = cut_at(&space, &map, cut)?;
        }
        let first = self.first.space();
        let ((a, b), (c, d)) = (first.domain(), space.domain());
        let scale = (b - a) / (d - c);
        let slack = 16.0 * f64::EPSILON * (a.abs().max(b.abs()) + c.abs().max(d.abs()) * scale);
        let beside = |t: f64| {
            let at = first.flat().partition_point(|&k| k < t);
            let around = first.flat()[at.saturating_sub(1)..first.flat().len().min(at + 1)].iter().copied();
            around.min_by(|x, y| (x - t).abs().total_cmp(&(y - t).abs())).unwrap_or(t)
        };
        let mut nearly = None;
        let mut moved = |&k: &f64| {
            // Each end is met exactly, and what lies beyond one is measured from it.
            let t = if k < c {
                a - (c - k) * scale
            } else if k < d {
                (a + (k - c) * scale).min(b)
            } else {
                b + (k - d) * scale
            };
            let near = beside(t);
            if (near - t).abs() <= slack {
                return near;
            }
            if (near - t).abs() <= NEARLY * (b - a) && t > a && t < b {
                nearly = Some((near, t));
            }
            t
        };
        let knots: Vec<f64> = space.knots().iter().map(&mut moved).collect();
        let p = space.degree();
        let space = if space.is_periodic() { Space::periodic(p, knots)? } else { Space::open(p, knots)? };
        Ok((space, map, nearly))
    }
}

/// Whether one of two lengths cannot be told to be the shorter.
fn ties(x: f64, y: f64) -> bool {
    (x - y).abs() <= SAME * x.max(y)
}

/// Whether an edge ends where it starts, and is not a point.
fn is_closed(side: &SurfaceEdge<'_>) -> Result<bool> {
    if side.space().is_periodic() {
        return Ok(true);
    }
    let (a, b) = side.space().domain();
    let start = side.point(a)?;
    let mut extent = 0.0_f64;
    for i in 1..8 {
        extent = extent.max((side.point(a + (b - a) * f64::from(i) / 8.0)? - start).norm());
    }
    Ok((side.point(b)? - start).norm() <= SAME * extent && extent > 0.0)
}

/// A map, and then a conversion.
fn after(step: &Conversion, map: &Map) -> Map {
    let row = |k| {
        let mut sum = Terms::new();
        for (i, c) in step.row(k) {
            for &(j, value) in &map[i] {
                match sum.iter_mut().find(|(known, _)| *known == j) {
                    Some((_, total)) => *total += c * value,
                    None => sum.push((j, c * value)),
                }
            }
        }
        sum
    };
    (0..step.to().len()).map(row).collect()
}

/// A closed space run through from breakpoint `cut` once round. An open one is torn where its ends meet: that it is closed
/// is for what it is made equal to.
fn cut_at(space: &Space, map: &Map, cut: usize) -> Result<(Space, Map)> {
    let ((a, b), p) = (space.domain(), space.degree());
    let start = space.breakpoints()[cut];
    if space.is_periodic() {
        let knots = space.knots();
        let by = knots.partition_point(|&k| k < start);
        let next = knots[1..=by].iter().map(|k| b + (k - a));
        let turned = Space::periodic(p, knots[by..].iter().copied().chain(next).collect())?;
        let map = map[by..].iter().chain(&map[..by]).cloned().collect();
        return Ok((turned, map));
    }
    let (to_end, from_start) = (space.restricting(start, b)?, space.restricting(a, start)?);
    let mut knots = to_end.to().flat().to_vec();
    knots.extend(from_start.to().flat()[p + 1..].iter().map(|k| b + (k - a)));
    let mut rows = after(&to_end, map);
    rows.extend(after(&from_start, map));
    Ok((Space::open(p, knots)?, rows))
}
