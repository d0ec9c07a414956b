//! Frames as morph targets, and the keys that show one after the other.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write as _;

use loftsman_kernel::mesh::{Mesh, Polyline};
use loftsman_kernel::scene::Animation;
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Result};

use super::bin::{Bin, Kind, Out, Use};
use super::schema::{self, Channel, Sampler, Target};
use super::shape::{Failure, Shaped, targets};

/// The largest number of frames: every frame has a weight for every other, so that their square is written.
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

    pub(super) fn count(&self) -> usize {
        self.frames.frames.len()
    }

    pub(super) fn rate(&self) -> f64 {
        self.frames.rate
    }

    /// The morph target of each frame.
    pub(super) fn targets(
        &self,
        shaped: &Shaped,
        bin: &mut Bin<'a>,
    ) -> std::result::Result<Vec<BTreeMap<&'static str, usize>>, Failure> {
        targets(&self.base, shaped, self.count(), |k| Ok(self.frames.frames[k].clone()), bin)
    }
}

/// A curve's polyline at these parameters, now and in each frame of its control vertices.
pub(super) fn of_curve<'a>(
    curve: &Curve,
    parameters: &[f64],
    closed: bool,
    frames: &Animation,
) -> Result<(Polyline, Moves<'a>)> {
    // A closed polyline comes back to its start by itself.
    let parameters = if closed { &parameters[..parameters.len().saturating_sub(1)] } else { parameters };
    let line = |curve: &Curve| parameters.iter().map(|&u| curve.point(u)).collect::<Result<Vec<Point>>>();
    let points = line(curve)?;
    let moved = frames.frames.iter().map(|frame| {
        line(&Curve::build(curve.space().clone(), frame.clone(), curve.weights().map(<[f64]>::to_vec))?)
    });
    let frames = Animation { rate: frames.rate, frames: moved.collect::<Result<_>>()? };
    Ok((Polyline { points: points.clone(), closed }, Moves::new(points, Cow::Owned(frames))))
}

/// A surface's mesh in each frame of its control vertices: each point moves as the surface does at its parameters, which
/// the mesh has as texture coordinates. `None` where it has not.
pub(super) fn of_surface<'a>(
    surface: &Surface,
    mesh: &Mesh,
    frames: &Animation,
) -> Result<Option<Moves<'a>>> {
    let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
    let mut parameters = vec![None; mesh.points().len()];
    for (corner, &point) in mesh.corners().iter().enumerate() {
        if let Some(&[u, v]) = mesh.uvs.at(corner, point) {
            let at = |a: f64, b: f64, t: f64| (a + (b - a) * t).clamp(a, b);
            parameters[point as usize].get_or_insert((at(u0, u1, u), at(v0, v1, v)));
        }
    }
    let Some(parameters) = parameters.into_iter().collect::<Option<Vec<(f64, f64)>>>() else {
        return Ok(None);
    };
    let points =
        |surface: &Surface| parameters.iter().map(|&(u, v)| surface.point(u, v)).collect::<Result<Vec<_>>>();
    let base = points(surface)?;
    let moved = frames.frames.iter().map(|frame| {
        let (u, v) = (surface.u().clone(), surface.v().clone());
        let frame = points(&Surface::build(u, v, frame.clone(), surface.weights().map(<[f64]>::to_vec))?)?;
        // At seams the mesh has one point for two parameters: the move counts, not the place.
        Ok(mesh.points().iter().zip(frame).zip(&base).map(|((p, q), b)| p + (q - b)).collect())
    });
    let frames = Animation { rate: frames.rate, frames: moved.collect::<Result<_>>()? };
    Ok(Some(Moves::new(mesh.points().to_vec(), Cow::Owned(frames))))
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
    pub(super) fn add(&mut self, object: usize, count: usize, rate: f64, bin: &mut Bin<'_>) {
        let times = *self.times.entry((count, rate.to_bits())).or_insert_with(|| {
            let time = move |k: usize| (k as f64 / rate) as f32;
            let pour =
                move |out: &mut Out<'_>| (0..count).try_for_each(|k| out.write_all(&time(k).to_le_bytes()));
            let bounds = [vec![time(0)], vec![time(count - 1)]];
            bin.later(Kind::floats(1), Use::Other, count, Some(bounds), Box::new(pour))
        });
        let weights = *self.weights.entry(count).or_insert_with(|| {
            let pour = move |out: &mut Out<'_>| {
                let cells = (0..count)
                    .flat_map(|k| (0..count).map(move |target| if k == target { 1.0_f32 } else { 0.0 }));
                cells.into_iter().try_for_each(|w| out.write_all(&w.to_le_bytes()))
            };
            bin.later(Kind::floats(1), Use::Other, count * count, None, Box::new(pour))
        });
        self.tracks.push((object, times, weights));
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
