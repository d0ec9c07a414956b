//! Frames as morph targets, and the keys that show one after the other.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write as _;

use loftsman_kernel::plugin::FormatError;
use loftsman_kernel::scene::Animation;
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Error, Point, Result};

use super::bin::{Bin, Kind, Out, Use};
use super::schema::{self, Channel, Sampler, Target};
use super::shape::{Shaped, targets};

/// The largest number of frames: every frame has a weight for every other, and readers make the square of their number out
/// of what is written.
pub(super) const LARGEST: usize = 2000;

/// The frames of a shape that is written: its points as they are, and as they are in each frame.
pub(super) struct Moves<'a> {
    base: Vec<Point>,
    frames: Cow<'a, Animation>,
}

impl<'a> Moves<'a> {
    pub(super) fn new(base: Vec<Point>, frames: Cow<'a, Animation>) -> Self {
        Self { base, frames }
    }

    /// The moves of a shape of [`states`], which starts as the first of these.
    pub(super) fn of(mut states: Vec<Vec<Point>>, starts: bool, rate: f64) -> Self {
        let base = states.first().cloned().unwrap_or_default();
        if !starts && !states.is_empty() {
            states.remove(0);
        }
        Self { base, frames: Cow::Owned(Animation { rate, frames: states }) }
    }

    /// Whether the shape itself is not its first frame.
    pub(super) fn starts_elsewhere(&self) -> bool {
        self.frames.frames.first().is_some_and(|first| *first != self.base)
    }

    pub(super) fn count(&self) -> usize {
        self.frames.frames.len()
    }

    pub(super) fn rate(&self) -> f64 {
        self.frames.rate
    }

    /// The morph target of each frame; what is watched is told of each.
    pub(super) fn targets(
        &self,
        shaped: &Shaped,
        bin: &mut Bin<'a>,
    ) -> Result<Vec<BTreeMap<&'static str, usize>>, FormatError> {
        targets(&self.base, shaped, self.count(), |k| Ok(self.frames.frames[k].clone()), bin)
    }
}

/// Where a shape is so many times as large as all its frames, what these are would be lost in rounding beside it.
const LARGE: f64 = 8.0;

/// The control vertices of all states of a shape that are shown: its own first, as the base of all others, then its frames; and whether the
/// first is a frame already. So it is where its own are the first frame, and where it is so large that it cannot be the base.
pub(super) fn states<'f>(own: &'f [Point], frames: Option<&'f Animation>) -> (Vec<&'f [Point]>, bool) {
    let frames = frames.map(|frames| frames.frames.as_slice()).unwrap_or_default();
    let reach = |points: &[Point]| {
        let Some(first) = points.first() else { return 0.0 };
        points.iter().map(|p| (p - first).amax()).fold(0.0, f64::max)
    };
    let largest = frames.iter().map(|frame| reach(frame)).fold(0.0, f64::max);
    let starts = frames.first().is_some_and(|first| first == own || reach(own) > LARGE * largest);
    let beside = if starts { None } else { Some(own) };
    (beside.into_iter().chain(frames.iter().map(Vec::as_slice)).collect(), starts)
}

/// A curve with the control vertices of each state.
pub(super) fn curves(curve: &Curve, states: &[&[Point]]) -> Result<Vec<Curve>> {
    let weights = || curve.weights().map(<[f64]>::to_vec);
    states.iter().map(|f| Curve::build(curve.space().clone(), f.to_vec(), weights())).collect()
}

/// A surface with those of each state.
pub(super) fn surfaces(surface: &Surface, states: &[&[Point]]) -> Result<Vec<Surface>> {
    let (u, v) = (surface.u(), surface.v());
    let weights = || surface.weights().map(<[f64]>::to_vec);
    states.iter().map(|f| Surface::build(u.clone(), v.clone(), f.to_vec(), weights())).collect()
}

/// The keys of all objects that move, in one animation: Blender plays only one at a time.
#[derive(Default)]
pub(super) struct Keys {
    /// The object of each channel, its times and its weights.
    tracks: Vec<(usize, usize, usize)>,
    /// Times by their number and rate, weights by their number: objects that move alike share them.
    times: BTreeMap<(usize, u64), usize>,
    weights: BTreeMap<usize, usize>,
}

impl Keys {
    /// Shows one frame after the other: at the time of frame `k` its morph target has weight 1, all others 0.
    ///
    /// # Errors
    /// When single precision, which glTF has, does not hold the times or tell them apart.
    pub(super) fn add(&mut self, object: usize, count: usize, rate: f64, bin: &mut Bin<'_>) -> Result<()> {
        let time = move |k: usize| (k as f64 / rate) as f32;
        // Below the smallest normal number a time has few bits or none.
        let told_apart = |k: usize| time(k).is_normal() && time(k - 1) < time(k);
        if let Some(frame) = (1..count).find(|&k| !told_apart(k)) {
            let (at, before) = (frame as f64 / rate, (frame - 1) as f64 / rate);
            return Err(Error::Invalid(format!(
                "at a rate of {rate:e} frames a second frame {frame} comes at {at:e} s, the one before at {before:e} s: that is beyond single precision, which glTF has; choose another rate"
            )));
        }
        let times = *self.times.entry((count, rate.to_bits())).or_insert_with(|| {
            let pour =
                move |out: &mut Out<'_>| (0..count).try_for_each(|k| out.write_all(&time(k).to_le_bytes()));
            let bounds = [vec![time(0)], vec![time(count - 1)]];
            bin.later(Kind::floats(1), Use::Other, count, Some(bounds), Box::new(pour))
        });
        let weights = *self.weights.entry(count).or_insert_with(|| {
            // A one for each key, all else zeros: as many numbers as keys, not their square.
            let ones: Vec<(u32, [f32; 1])> = (0..count).map(|k| ((k * (count + 1)) as u32, [1.0])).collect();
            bin.sparse(count * count, None, &ones)
        });
        self.tracks.push((object, times, weights));
        Ok(())
    }

    /// The animation of the document, given each object's node.
    pub(super) fn finish(self, numbers: &[Option<usize>]) -> Vec<schema::Animation> {
        if self.tracks.is_empty() {
            return Vec::new();
        }
        let mut animation = schema::Animation { name: "frames".to_owned(), ..schema::Animation::default() };
        for (object, input, output) in self.tracks {
            let Some(&Some(node)) = numbers.get(object) else { continue };
            animation.samplers.push(Sampler { input, output, interpolation: "LINEAR" });
            let sampler = animation.samplers.len() - 1;
            animation.channels.push(Channel { sampler, target: Target { node, path: "weights" } });
        }
        vec![animation]
    }
}
