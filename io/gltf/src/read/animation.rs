//! Animations of morph targets as frames.

use std::collections::HashMap;

use loftsman_kernel::Point;
use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};
use loftsman_kernel::scene::Animation;

use super::file::{File, clip};
use super::schema;

/// Frames a second where the file's keys are not evenly spaced.
const RATE: f64 = 24.0;

/// The weights of a node's morph targets over time.
#[derive(Debug)]
pub(super) struct Track {
    path: String,
    input: usize,
    output: usize,
    interpolation: Interpolation,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Interpolation {
    Linear,
    Step,
    Cubic,
}

/// The track of every node that has one: that of the first animation which moves the node's morph targets.
pub(super) fn tracks(file: &File<'_>, report: &mut ReadReport) -> Result<HashMap<usize, Track>, FormatError> {
    let mut tracks = HashMap::new();
    for index in 0..file.root.animations.len() {
        let raw: schema::Animation<'_> = file.entry("animations", &file.root.animations, index)?;
        super::report::extras(raw.extras, "animation", report);
        let name = raw.name.as_deref().map_or_else(String::new, |n| format!(" \"{}\"", clip(n)));
        for (k, channel) in raw.channels.iter().enumerate() {
            let path = format!("animations[{index}].channels[{k}]");
            let (Some(node), "weights") = (channel.target.node, channel.target.path.as_str()) else {
                let what = clip(&channel.target.path);
                report.count(
                    Fate::LeftOut,
                    &format!("animation of a node's {what}: only morph targets become frames"),
                );
                continue;
            };
            let sampler = channel.sampler.index();
            let Some(sampler) = raw.samplers.get(sampler) else {
                let count = raw.samplers.len();
                let problem = format!("sampler {sampler} does not exist, there are {count}");
                return Err(file.fail(format!("{path}.sampler"), problem));
            };
            let interpolation = match sampler.interpolation.as_deref() {
                None | Some("LINEAR") => Interpolation::Linear,
                Some("STEP") => Interpolation::Step,
                Some("CUBICSPLINE") => Interpolation::Cubic,
                Some(other) => {
                    let problem = format!("the interpolation \"{}\" does not exist", clip(other));
                    return Err(file.fail(path, problem));
                }
            };
            if tracks.contains_key(&node.index()) {
                let reason = format!("animation{name}: the node has frames of another one");
                report.count(Fate::LeftOut, &reason);
                continue;
            }
            let (input, output) = (sampler.input.index(), sampler.output.index());
            tracks.insert(node.index(), Track { path, input, output, interpolation });
        }
    }
    Ok(tracks)
}

impl Track {
    /// The frames of a shape: its points, moved by the targets as much as the weights say at each time.
    pub(super) fn frames(
        &self,
        file: &File<'_>,
        points: &[Point],
        targets: &[Vec<Vector>],
        report: &mut ReadReport,
    ) -> Result<Option<Animation>, FormatError> {
        let path = self.path.as_str();
        let input = file.elements(self.input, path)?;
        let output = file.elements(self.output, path)?;
        if targets.is_empty() || input.count == 0 {
            report.count(Fate::LeftOut, "animation of weights without morph targets or keys");
            return Ok(None);
        }
        let parts = if self.interpolation == Interpolation::Cubic { 3 } else { 1 };
        let keys = input.count;
        if input.components != 1
            || output.components != 1
            || keys.checked_mul(targets.len()).and_then(|n| n.checked_mul(parts)) != Some(output.count)
        {
            let problem = format!(
                "{} weights for {keys} keys of {} morph targets: there must be {parts} for each",
                output.count,
                targets.len()
            );
            return Err(file.fail(path, problem));
        }
        let times: Vec<f64> = file.vectors::<1>(&input, 0.0, path)?.into_iter().map(|[t]| t).collect();
        if !times.iter().all(|t| t.is_finite()) || !times.is_sorted_by(|a, b| a < b) {
            return Err(file.fail(path, "its times must be finite and ascend"));
        }
        let weights = file.vectors::<1>(&output, 0.0, path)?;
        if !weights.iter().all(|[w]| w.is_finite()) {
            return Err(file.fail(path, "its weights must be finite"));
        }
        // Between the incoming and outgoing slopes of a cubic spline's key stands its value.
        let weight = |key: usize, target: usize| {
            let row = if parts == 3 { 3 * key + 1 } else { key };
            weights[row * targets.len() + target][0]
        };
        let (rate, moments) = match even_rate(&times) {
            Some(rate) => (rate, (0..keys).map(|k| (k, 0.0)).collect()),
            None => (RATE, self.moments(file, &times)?),
        };
        let reason = match (even_rate(&times), self.interpolation) {
            (None, _) => "animation whose keys are not evenly spaced, as 24 frames a second",
            (_, Interpolation::Linear) => "",
            (_, Interpolation::Step) => "animation by steps, as frames",
            (_, Interpolation::Cubic) => "animation by a cubic spline, as frames at its keys",
        };
        report.count(if reason.is_empty() { Fate::Kept } else { Fate::Approximated }, reason);
        if times[0] > 0.5 / rate {
            report.notes.push(format!("an animation that starts at {} s starts at 0 here", times[0]));
        }
        let mut frames = Vec::new();
        for (key, part) in moments {
            file.take(path, points.len(), size_of::<Point>())?;
            let mut frame = points.to_vec();
            for (target, moves) in targets.iter().enumerate() {
                let mut w = weight(key, target);
                if part > 0.0 && key + 1 < keys && self.interpolation != Interpolation::Step {
                    w += part * (weight(key + 1, target) - w);
                }
                if w != 0.0 {
                    frame.iter_mut().zip(moves).for_each(|(p, m)| *p += m * w);
                }
            }
            if !frame.iter().all(|p| p.iter().all(|x| x.is_finite())) {
                return Err(file.fail(path, "a frame overflows: the weights or morph targets are too large"));
            }
            frames.push(frame);
        }
        Ok(Some(Animation { rate, frames }))
    }

    /// The moments at the usual rate: the key before each, and which part of the way to the next has passed.
    fn moments(&self, file: &File<'_>, times: &[f64]) -> Result<Vec<(usize, f64)>, FormatError> {
        let (first, last) = (times[0], times[times.len() - 1]);
        let count = ((last - first) * RATE).ceil() + 1.0;
        let count = if count < 1e9 { count as usize } else { usize::MAX };
        file.take(&self.path, count, 16)?;
        let mut key = 0;
        Ok((0..count)
            .map(|k| {
                let time = (first + k as f64 / RATE).min(last);
                while key + 1 < times.len() && times[key + 1] <= time {
                    key += 1;
                }
                let next = times.get(key + 1).copied().unwrap_or(last);
                (key, if next > times[key] { (time - times[key]) / (next - times[key]) } else { 0.0 })
            })
            .collect())
    }
}

/// The frames a second of evenly spaced times; whole where single precision allows. A single key has the usual rate.
fn even_rate(times: &[f64]) -> Option<f64> {
    let (first, last) = (*times.first()?, *times.last()?);
    if times.len() == 1 {
        return Some(RATE);
    }
    let step = (last - first) / (times.len() - 1) as f64;
    // Times are rounded to single precision.
    let slack = 1e-3 * step + 2.0 * f64::from(f32::EPSILON) * last.abs();
    let even = times.iter().enumerate().all(|(k, t)| (t - first - k as f64 * step).abs() <= slack);
    let rate = 1.0 / step;
    if !even || !rate.is_finite() {
        return None;
    }
    let whole = rate.round();
    Some(if (rate - whole).abs() <= 1e-4 * whole { whole } else { rate })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_found_in_single_precision() {
        for rate in [24.0, 25.0, 30.0, 60.0, 120.0] {
            let times: Vec<f64> = (0..500).map(|k| f64::from((f64::from(k) / rate) as f32)).collect();
            assert_eq!(even_rate(&times), Some(rate));
        }
        assert!((even_rate(&[0.0, 1.0 / 29.97, 2.0 / 29.97]).unwrap() - 29.97).abs() < 1e-9);
        assert_eq!(even_rate(&[0.0, 0.1, 0.4]), None);
        assert_eq!(even_rate(&[0.5]), Some(24.0));
    }
}
