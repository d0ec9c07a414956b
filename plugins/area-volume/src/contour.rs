//! Closed boundaries made of curves: periodic ones, ends that meet, pieces joined end to end.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Result};

use crate::members::{curve, extent, name_of};
use crate::ties::Tie;

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
    /// # Errors
    /// When a member is not a curve, is torn, or its ends meet no others.
    pub(crate) fn find(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Self> {
        let (_, size) = extent(shapes, members)?;
        let Chain { senses, loops, joints } = Self::chain(shapes, members, what)?;
        let mut ties = Vec::with_capacity(joints.len());
        for joint in joints {
            if joint.distance > TOGETHER * size {
                let (name, other) =
                    (name_of(&members[joint.from.member]), name_of(&members[joint.to.member]));
                let end = |last: bool| if last { "end" } else { "start" };
                return Err(Error::Invalid(format!(
                    "{what}: the boundary is open: the {} of {name} is {:.3e} away from the {} of {other}; close it, or \
                     name all of its pieces in \"objects\"",
                    end(joint.from.last),
                    joint.distance,
                    end(joint.to.last)
                )));
            }
            let side = |end: End| -> Result<_> {
                let own = curve(shapes, &members[end.member], what, INSTEAD)?;
                Ok((members[end.member].shape, own.stencil(parameter(own, end).into(), 0.into())?))
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
            check_whole(own, on, what)?;
            if own.is_periodic() {
                ends.push(None);
                continue;
            }
            let (a, b) = own.domain();
            let both = [own.point(a)?, own.point(b)?];
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

fn parameter(curve: &Curve, end: End) -> f64 {
    let (a, b) = curve.domain();
    if end.last { b } else { a }
}

/// A curve that a knot of full multiplicity tears in two encloses nothing.
fn check_whole(curve: &Curve, on: &On, what: &str) -> Result<()> {
    let space = curve.space();
    let breaks = space.breakpoints();
    let torn = breaks[1..breaks.len() - 1].iter().find(|&&u| space.multiplicity(u) > space.degree());
    match torn {
        None => Ok(()),
        Some(u) => Err(Error::Invalid(format!(
            "{what}: {} may be torn at {u}, where the knot is repeated {} times; split it there, or remove one",
            name_of(on),
            space.multiplicity(*u)
        ))),
    }
}
