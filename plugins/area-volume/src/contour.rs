//! Closed boundaries made of curves: periodic ones, ends that meet, pieces joined end to end.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::{Derivative, Tear, torn};
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Result};

use crate::members::{Member, curve, extent, name_of};
use crate::tie::Tie;

/// Ends nearer than this, of the size of the whole, are one point.
pub(crate) const TOGETHER: f64 = 1e-9;

/// Curves that close: how each is run through, and which ends stay together.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contour {
    /// For each member: 1 where it is run through as it is, -1 backwards.
    pub(crate) senses: Vec<f64>,
    /// For each member: the first one of the loop that it is part of.
    pub(crate) loops: Vec<usize>,
    pub(crate) ties: Vec<Tie>,
}

/// How members follow one another.
struct Chain {
    senses: Vec<f64>,
    loops: Vec<usize>,
    joints: Vec<Joint>,
}

/// An end of a member's curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct End {
    member: usize,
    last: bool,
}

impl End {
    fn other(self) -> Self {
        Self { last: !self.last, ..self }
    }
}

/// Where two ends are joined, and how far they are apart.
struct Joint {
    from: End,
    to: End,
    distance: f64,
}

const INSTEAD: &str = "ask for its volume, or its surface-area";

impl Contour {
    /// `advice` says what to do where it is open.
    ///
    /// # Errors
    /// When a member is not a curve, is torn, or its ends meet no others.
    pub(crate) fn find(shapes: &Shapes<'_>, members: &[On], what: &str, advice: &str) -> Result<Self> {
        let (_, size) = extent(shapes, members)?;
        let Chain { senses, loops, joints } = Self::chain(shapes, members, what)?;
        let mut ties = Vec::with_capacity(joints.len());
        for joint in joints {
            if joint.distance > TOGETHER * size {
                let (name, other) =
                    (name_of(&members[joint.from.member]), name_of(&members[joint.to.member]));
                let end = |last: bool| if last { "end" } else { "start" };
                return Err(Error::Invalid(format!(
                    "{what}: the boundary is open: the {} of {name} is {} away from the {} of {other}; {advice}, or \
                     name all of its pieces in \"objects\"",
                    end(joint.from.last),
                    figure(joint.distance),
                    end(joint.to.last)
                )));
            }
            let side = |end: End| -> Result<_> {
                let own = curve(shapes, &members[end.member], what, INSTEAD)?;
                Ok((
                    members[end.member].shape,
                    own.shape.stencil(parameter(&own, end).into(), Derivative::POSITION)?,
                ))
            };
            ties.push(Tie { first: side(joint.to)?, second: side(joint.from)? });
        }
        Ok(Self { senses, loops, ties })
    }

    pub(crate) fn gap(shapes: &Shapes<'_>, members: &[On]) -> Result<f64> {
        let Chain { joints, .. } = Self::chain(shapes, members, "gap")?;
        Ok(joints.iter().fold(0.0, |m, joint| m.max(joint.distance)))
    }

    /// Closes every curve onto itself, or else goes on with the nearest end of another, until the way is closed.
    fn chain(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Chain> {
        let (_, size) = extent(shapes, members)?;
        let mut senses = vec![1.0; members.len()];
        let mut loops: Vec<usize> = (0..members.len()).collect();
        let mut joints = Vec::new();
        let mut ends: Vec<Option<[Point; 2]>> = Vec::with_capacity(members.len());
        for (member, on) in members.iter().enumerate() {
            let own = curve(shapes, on, what, INSTEAD)?;
            check_whole(&own, on, what)?;
            let Some((a, b)) = open_ends(&own) else {
                ends.push(None);
                continue;
            };
            let point = |u: f64| own.shape.value(u.into(), Derivative::POSITION).map(Point::from);
            let both = [point(a)?, point(b)?];
            let distance = (both[1] - both[0]).norm();
            if distance <= TOGETHER * size {
                let end = End { member, last: true };
                joints.push(Joint { from: end, to: end.other(), distance });
                ends.push(None);
            } else {
                ends.push(Some(both));
            }
        }
        while let Some(start) = ends.iter().position(Option::is_some) {
            let Some([first, mut here]) = ends[start].take() else { break };
            let mut end = End { member: start, last: true };
            loop {
                let home = ((first - here).norm(), End { member: start, last: false });
                let next = ends.iter().enumerate().filter_map(|(member, both)| Some((member, (*both)?)));
                let next = next.flat_map(|(member, both)| {
                    [false, true].map(|last| ((both[usize::from(last)] - here).norm(), End { member, last }))
                });
                // The way home first, where ends lie equally near.
                let (distance, to) = next.fold(home, |best, new| if new.0 < best.0 { new } else { best });
                joints.push(Joint { from: end, to, distance });
                let Some([a, b]) = ends[to.member].take() else { break };
                loops[to.member] = start;
                (senses[to.member], here) = if to.last { (-1.0, a) } else { (1.0, b) };
                end = to.other();
            }
        }
        Ok(Chain { senses, loops, joints })
    }
}

/// Where a curve starts and ends; `None` where it is periodic.
fn open_ends(curve: &Member<'_>) -> Option<(f64, f64)> {
    let domain = curve.shape.domain();
    domain.first().filter(|interval| !interval.periodic).map(|interval| (interval.start, interval.end))
}

fn parameter(curve: &Member<'_>, end: End) -> f64 {
    open_ends(curve).map_or(0.0, |(a, b)| if end.last { b } else { a })
}

/// A curve that may be torn in two (a spline by a knot of full multiplicity) encloses nothing.
fn check_whole(curve: &Member<'_>, on: &On, what: &str) -> Result<()> {
    let Some(Tear { at, repeated, .. }) = torn(curve.shape, what)? else { return Ok(()) };
    let (name, why) =
        (name_of(on), repeated.map(|times| format!(", where the knot is repeated {times} times")));
    let advice = if why.is_some() { "split it there, or remove one" } else { "split it there" };
    let why = why.unwrap_or_default();
    Err(Error::Invalid(format!("{what}: {name} may be torn at {at}{why}; {advice}")))
}
