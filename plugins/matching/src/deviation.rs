//! How well two surfaces meet along an edge, and how well they should.

use std::fmt;

use loftsman_kernel::error::Result;
use loftsman_kernel::scene::Unit;
use loftsman_kernel::text::{figure, without_rounding};

/// So many of the largest places of a profile are looked at between their neighbours, and those only that are nearly the largest.
const PEAKS: usize = 4;
const PEAK: f64 = 0.9;
/// Golden sections: what is left is a 1e-5 of the way, and a maximum is known to 1e-10 of its curvature there.
const SECTIONS: usize = 24;

/// What is allowed instead is so much more than what was reached.
pub(crate) const MORE: f64 = 1.05;
/// Parts of two curvatures that differ by less than this factor are told as one.
const ALIKE: f64 = 1.1;
/// A curvature that is so many times the other surface's is told as that: how much larger it is tells nothing.
const BEYOND: f64 = 10.0;
/// What is no more than this, of the edges' size, of a radian, of the other surface's largest curvature, is told as rounding: what solving leaves.
const ROUNDING: [f64; 3] = [1e-12, 1e-11, 1e-9];

/// What a match may miss between the places where it is imposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The largest distance; none: to rounding, or refused.
    pub distance: Option<f64>,
    /// The largest angle between the tangent planes, in radians.
    pub angle: f64,
    /// The largest difference of the normal curvatures square to the edge, as a part of the largest normal curvature, in any
    /// direction, of the surface that stands still along the edge. Where that one is flat to rounding (1e-8 / size of the
    /// edge), as a part of this.
    pub curvature: f64,
}

impl Default for Limits {
    /// Positions to rounding, tangent planes to 0.1°, curvatures to 5 %.
    fn default() -> Self {
        Self { distance: None, angle: 0.1_f64.to_radians(), curvature: 0.05 }
    }
}

/// How far two surfaces are from one another along an edge: the largest of each, looked for at places all along it, its ends and both sides of its knots among
/// them, and between these where it is largest. Distances are those of edges, however their parameters run: from a place of each to the nearest place of the
/// other, near to where parameters match, so that no distance is told too small. Angles and curvatures are compared where the other edge is nearest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// The largest distance of a place of either edge from the other edge.
    pub distance: f64,
    /// The largest angle between the surfaces, in radians: 0 where they are smooth, π where they are folded.
    pub angle: f64,
    /// The largest difference of their normal curvatures square to the edge, each surface's own.
    pub curvature: f64,
    /// That as a part of what [`Limits::curvature`] says.
    pub part: f64,
    /// That as a part of the largest normal curvature square to the edge of the surface that stands still, which may be much smaller
    /// than its largest in any direction; infinite where it has none.
    pub square: f64,
    /// Whether the surface that stands still is flat along the edge, so that no curvature is there to be a part of.
    pub flat: bool,
}

impl Limits {
    /// `position 0.001, angle 0.1°, curvature 5 %`, as much of it as belongs to a continuity.
    pub(crate) fn up_to(&self, continuity: usize, distance: f64) -> String {
        let [distance, angle, curvature] =
            [distance, self.angle.to_degrees(), 100.0 * self.curvature].map(figure);
        let all =
            [format!("position {distance}"), format!("angle {angle}°"), format!("curvature {curvature} %")];
        all[..=continuity.min(2)].join(", ")
    }
}

impl Deviation {
    /// Whether it is within limits, up to a continuity; `distance` is the allowed one.
    pub(crate) fn within(&self, continuity: usize, distance: f64, limits: &Limits) -> bool {
        self.excess(continuity, distance, limits) <= 1.0
    }

    /// How many times what is allowed it is, up to a continuity: 1 or less within the limits.
    pub(crate) fn excess(&self, continuity: usize, distance: f64, limits: &Limits) -> f64 {
        let all = [self.distance / distance, self.angle / limits.angle, self.part / limits.curvature];
        all[..=continuity].iter().fold(0.0, |m, x| f64::max(m, *x))
    }

    /// The fields of a match that allow what was found, a little more than that, of those that do not: `angle = 0.5, curvature = 1071`; nothing where a
    /// surface stands back over the other one somewhere, which is a fold.
    pub(crate) fn allowing(&self, continuity: usize, distance: f64, limits: &Limits) -> Option<String> {
        if continuity > 0 && self.angle > std::f64::consts::FRAC_PI_2 {
            return None;
        }
        let fields = [
            ("tolerance", self.distance, distance, 1.0),
            ("angle", self.angle, limits.angle, 1.0_f64.to_degrees()),
            ("curvature", self.part, limits.curvature, 100.0),
        ];
        let missed = fields.into_iter().take(continuity + 1).filter(|(_, found, allowed, _)| found > allowed);
        let words = missed.map(|(name, found, _, unit)| format!("{name} = {}", figure(found * unit * MORE)));
        let words: Vec<String> = words.collect();
        Some(words.join(", "))
    }

    /// All of it by name, the angle in degrees; what is not finite is null.
    pub(crate) fn numbers(&self) -> serde_json::Value {
        serde_json::json!({
            "position": self.distance,
            "angle": self.angle.to_degrees(),
            "curvature": self.curvature,
            "part": self.part,
        })
    }

    /// The worst of all these.
    pub(crate) fn worst(profile: &[(f64, Self)]) -> Self {
        profile.iter().fold(Self::default(), |all, (_, one)| all.or_worse(*one))
    }

    /// The same, where what is only rounding is 0: of distances beside the edges' size, of angles beside a radian, of curvatures beside the other surface's.
    pub(crate) fn without_rounding(self, size: f64) -> Self {
        let part = without_rounding(self.part, 1.0);
        Self {
            distance: without_rounding(self.distance, size),
            angle: without_rounding(self.angle, 1.0),
            curvature: if part == 0.0 && !self.flat { 0.0 } else { self.curvature },
            part,
            ..self
        }
    }

    /// Whether a surface stands back over the other one along most of the edge: at less than a right angle to it.
    pub(crate) fn folded(profile: &[(f64, Self)]) -> bool {
        Self::mostly_beyond(profile, std::f64::consts::FRAC_PI_2)
    }

    /// Whether a surface lies on the other one, folded back, along most of the edge: where the angle between the two is less than what counts as one
    /// tangent plane ([`Limits::angle`], and no more than by default). On which side it lies nothing tells then, so that it can be bent round on neither;
    /// at a larger angle its own side is the one that it is bent round on.
    pub(crate) fn lies_on(profile: &[(f64, Self)], limits: &Limits) -> bool {
        Self::mostly_beyond(profile, std::f64::consts::PI - limits.angle.min(Limits::default().angle))
    }

    fn mostly_beyond(profile: &[(f64, Self)], angle: f64) -> bool {
        2 * profile.iter().filter(|(_, one)| one.angle > angle).count() > profile.len()
    }

    /// The larger of each.
    pub(crate) fn or_worse(self, other: Self) -> Self {
        Self {
            distance: self.distance.max(other.distance),
            angle: self.angle.max(other.angle),
            curvature: self.curvature.max(other.curvature),
            part: self.part.max(other.part),
            square: self.square.max(other.square),
            flat: self.flat || other.flat,
        }
    }

    /// `position 0.0012, angle 0.03°, curvature 0.4 (1.2 % of the other surface's largest)`, as much of it as belongs to a continuity; where the other
    /// surface bends less across the edge than along it, that is said as well; where there is nothing to be a part of, `curvature 0.4 (the other surface
    /// is flat)`.
    pub(crate) fn up_to(&self, continuity: usize) -> String {
        self.told(continuity, ["", ""])
    }

    /// The same of edges of this size with the unit of lengths: `position 0.0012 mm, angle 0.03°, curvature 0.4 per mm (…)`; what is no more than rounding is
    /// said to be that: `position to rounding`.
    pub(crate) fn up_to_in(&self, continuity: usize, size: f64, unit: Unit) -> String {
        let [near, smooth, bent] = ROUNDING;
        let rounded = Self {
            distance: if self.distance <= near * size { 0.0 } else { self.distance },
            angle: if self.angle <= smooth { 0.0 } else { self.angle },
            // Of a flat surface there is nothing to be a part of.
            part: if self.part <= bent && !self.flat { 0.0 } else { self.part },
            ..*self
        };
        rounded.told(continuity, [&format!(" {}", unit.symbol()), &format!(" per {}", unit.one())])
    }

    fn told(&self, continuity: usize, [length, bend]: [&str; 2]) -> String {
        let [distance, angle, curvature, part] =
            [self.distance, self.angle.to_degrees(), self.curvature, 100.0 * self.part].map(figure);
        if continuity > 1 && !self.flat && self.part > BEYOND {
            return format!(
                "{}, curvature more than {BEYOND} times the other surface's largest",
                self.told(1, [length, bend])
            );
        }
        let of = if self.flat {
            "the other surface is flat".to_owned()
        } else if !self.square.is_finite() {
            format!("{part} % of the other surface's largest, which has none across the edge")
        } else if self.square > ALIKE * self.part {
            format!(
                "{part} % of the other surface's largest, {} % of its largest across the edge",
                figure(100.0 * self.square)
            )
        } else {
            format!("{part} % of the other surface's largest")
        };
        let told = |found: f64, what: &str, words: String| {
            if found == 0.0 { format!("{what} to rounding") } else { format!("{what} {words}") }
        };
        let all = [
            told(self.distance, "position", format!("{distance}{length}")),
            told(self.angle, "angle", format!("{angle}°")),
            told(
                if self.flat { self.curvature } else { self.part },
                "curvature",
                format!("{curvature}{bend} ({of})"),
            ),
        ];
        all[..=continuity.min(2)].join(", ")
    }
}

/// Where between the places of a profile a measure may be larger than at them: places around which it is largest, to rounding (golden sections of the
/// way between both neighbours). `O(n)`, and some 300 more places.
pub(crate) fn peaks(
    profile: &[(f64, Deviation)],
    at: &dyn Fn(f64) -> Result<Option<Deviation>>,
) -> Result<Vec<(f64, Deviation)>> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let measures: [fn(&Deviation) -> f64; 3] = [|d| d.distance, |d| d.angle, |d| d.curvature];
    let mut found = Vec::new();
    for measure in measures {
        let value = |k: usize| profile.get(k).map_or(f64::NEG_INFINITY, |(_, one)| measure(one));
        let largest = (0..profile.len()).map(value).fold(0.0, f64::max);
        let is_peak = |k: usize| value(k) >= value(k.wrapping_sub(1)) && value(k) >= value(k + 1);
        let mut tops: Vec<usize> =
            (0..profile.len()).filter(|k| value(*k) > PEAK * largest && is_peak(*k)).collect();
        tops.sort_by(|x, y| value(*y).total_cmp(&value(*x)).then(x.cmp(y)));
        for k in tops.into_iter().take(PEAKS) {
            let last = profile.len() - 1;
            let (mut low, mut high) = (profile[k.saturating_sub(1)].0, profile[(k + 1).min(last)].0);
            let mut inner = [high - golden * (high - low), low + golden * (high - low)];
            let mut values = [at(inner[0])?, at(inner[1])?];
            for _ in 0..SECTIONS {
                let [Some(x), Some(y)] = values else { break };
                if measure(&x) >= measure(&y) {
                    high = inner[1];
                    inner = [high - golden * (high - low), inner[0]];
                    values = [at(inner[0])?, Some(x)];
                } else {
                    low = inner[0];
                    inner = [inner[1], low + golden * (high - low)];
                    values = [Some(y), at(inner[1])?];
                }
            }
            found.extend(inner.into_iter().zip(values).filter_map(|(t, one)| Some((t, one?))));
        }
    }
    Ok(found)
}

impl fmt::Display for Deviation {
    /// `position 0.0012, angle 0.03°, curvature 0.4 (1.2 % of the other surface's largest)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.up_to(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_their_unit_and_rounding_is_no_figure() {
        let found = Deviation {
            distance: 0.25,
            angle: 0.5_f64.to_radians(),
            curvature: 0.5,
            part: 0.125,
            square: 0.125,
            flat: false,
        };
        let told = |found: Deviation| found.up_to_in(2, 100.0, Unit::Millimetre);
        assert_eq!(
            told(found),
            "position 0.25 mm, angle 0.5°, curvature 0.5 per mm (12.5 % of the other surface's largest)"
        );
        let left = Deviation { distance: 3e-13, angle: 1e-15, curvature: 4.9e-16, part: 1.2e-14, ..found };
        assert_eq!(told(left), "position to rounding, angle to rounding, curvature to rounding");
        // What is much larger than the other is not counted in percent.
        let far = Deviation { curvature: 7.9e10, part: 24.13, square: 114.71, ..found };
        assert_eq!(
            told(far),
            "position 0.25 mm, angle 0.5°, curvature more than 10 times the other surface's largest"
        );
        // But what would allow it is.
        let limits = Limits::default();
        assert_eq!(
            far.allowing(2, 1.0, &limits).unwrap(),
            format!("angle = {}, curvature = {}", figure(0.525), figure(2533.65))
        );
        assert_eq!(Deviation { angle: 3.0, ..far }.allowing(2, 1.0, &limits), None);
        // Beside what is flat every curvature is a figure.
        let flat = Deviation { curvature: 1e-10, part: 1e-12, flat: true, ..found };
        assert!(told(flat).ends_with("curvature 1e-10 per mm (the other surface is flat)"), "{}", told(flat));
        assert_eq!(Deviation { distance: 2.0, ..left }.up_to_in(0, 100.0, Unit::Unknown), "position 2 units");
    }
}
