//! How the parameter of a file runs over a spline. Arcs are counted by their angle, while a rational arc has that at its knots only.

/// A stretch of the file's parameter and the same of the spline's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    file: [f64; 2],
    ours: [f64; 2],
    /// Of an arc, into how many equal pieces the spline cuts it; 0 where both run evenly. Then the angle gone through.
    pieces: usize,
    sweep: f64,
}

/// A parameter of a file as that of a spline.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pace(Vec<Stretch>);

impl Pace {
    /// Both run evenly.
    pub(crate) fn even(file: [f64; 2], ours: [f64; 2]) -> Self {
        Self(vec![Stretch { file, ours, pieces: 0, sweep: 0.0 }])
    }

    /// The file counts angles of an arc of so many pieces.
    pub(crate) fn turn(file: [f64; 2], ours: [f64; 2], pieces: usize, sweep: f64) -> Self {
        Self(vec![Stretch { file, ours, pieces, sweep: sweep.abs() }])
    }

    /// From where to where the file counts.
    pub(crate) fn range(&self) -> [f64; 2] {
        let ends = self.0.first().zip(self.0.last());
        ends.map_or([0.0, 1.0], |(first, last)| [first.file[0], last.file[1]])
    }

    /// The same, counted from one number to another.
    pub(crate) fn over(mut self, [from, to]: [f64; 2]) -> Self {
        let [a, b] = self.range();
        let map = |t: f64| from + (to - from) * ((t - a) / (b - a));
        for stretch in &mut self.0 {
            stretch.file = stretch.file.map(map);
        }
        self
    }

    /// This, and behind it another.
    pub(crate) fn then(mut self, next: &Self, ours: f64) -> Self {
        let shift = self.range()[1] - next.range()[0];
        let start = next.0.first().map_or(0.0, |first| first.ours[0]);
        self.0.extend(next.0.iter().map(|stretch| Stretch {
            file: stretch.file.map(|t| t + shift),
            ours: stretch.ours.map(|t| t - start + ours),
            ..*stretch
        }));
        self
    }

    /// `[factor, shift]` of an even pace all along.
    pub(crate) fn affine(&self) -> Option<[f64; 2]> {
        let slope = |s: &Stretch| (s.ours[1] - s.ours[0]) / (s.file[1] - s.file[0]);
        let first = self.0.first()?;
        let factor = slope(first);
        let all = self.0.iter().all(|s| s.pieces == 0 && (slope(s) - factor).abs() <= 1e-12 * factor.abs());
        (all && factor.is_finite()).then(|| [factor, first.ours[0] - factor * first.file[0]])
    }

    /// Where the file's parameter is at knots of the spline, or counts at another speed from.
    pub(crate) fn joints(&self) -> Vec<f64> {
        let of = |s: &Stretch| {
            let ([from, to], pieces) = (s.file, s.pieces.max(1));
            (0..pieces).map(move |k| from + (to - from) * (k as f64 / pieces as f64))
        };
        self.0.iter().flat_map(of).skip(1).collect()
    }

    /// The spline's parameter. Beyond the ends by rounding it is that of the end.
    pub(crate) fn at(&self, t: f64) -> Option<f64> {
        let [from, to] = self.range();
        let slack = 1e-6 * (to - from);
        if !(t >= from - slack && t <= to + slack) {
            return None;
        }
        let stretch = self.0.iter().find(|s| t <= s.file[1]).or_else(|| self.0.last())?;
        let share = ((t - stretch.file[0]) / (stretch.file[1] - stretch.file[0])).clamp(0.0, 1.0);
        let share = if stretch.pieces == 0 { share } else { stretch.turned(share) };
        Some(stretch.ours[0] + (stretch.ours[1] - stretch.ours[0]) * share)
    }
}

impl Stretch {
    /// The share of the spline's parameter at a share of the angle. A piece that turns by `2a` is at the angle `φ` from its middle
    /// at `1/2 + tan(φ/2) / (2 tan(a/2))`.
    fn turned(&self, share: f64) -> f64 {
        let pieces = self.pieces as f64;
        let at = share * pieces;
        let piece = at.floor().min(pieces - 1.0);
        let half = self.sweep / (2.0 * pieces);
        let angle = (2.0 * (at - piece) - 1.0) * half;
        let local = 0.5 + (0.5 * angle).tan() / (2.0 * (0.5 * half).tan());
        (piece + local) / pieces
    }
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::spline::Curve;
    use loftsman_kernel::{Point, Vector};

    use super::*;

    #[test]
    fn angles_become_parameters_of_rational_arcs() {
        for sweep in [0.3, 1.5, 2.0, 4.0, std::f64::consts::TAU] {
            let arc = Curve::elliptic_arc(Point::origin(), Vector::x(), Vector::y(), 0.0, sweep).unwrap();
            let (a, b) = arc.domain();
            let pace = Pace::turn([0.7, 0.7 + sweep], [a, b], arc.space().spans().count(), sweep);
            for k in 0..=50 {
                let angle = sweep * f64::from(k) / 50.0;
                let p = arc.point(pace.at(0.7 + angle).unwrap()).unwrap();
                assert!((p.x - angle.cos()).abs() + (p.y - angle.sin()).abs() < 1e-14, "{sweep} {angle}");
            }
            assert_eq!((pace.at(0.0), pace.affine()), (None, None));
        }
    }

    #[test]
    fn stretches_follow_one_another() {
        let first = Pace::even([0.0, 1.0], [0.0, 2.0]);
        let both = first.clone().then(&Pace::even([5.0, 7.0], [1.0, 5.0]), 2.0);
        assert_eq!((both.range(), both.affine()), ([0.0, 3.0], Some([2.0, 0.0])));
        assert_eq!(both.clone().over([0.0, 1.0]).at(0.5), Some(3.0));
        let uneven = first.then(&Pace::even([5.0, 7.0], [1.0, 2.0]), 2.0);
        assert_eq!((uneven.affine(), uneven.at(2.0)), (None, Some(2.5)));
    }
}
