//! Points of many kinds, none of them chosen because a fit does well on it.

use std::f64::consts::TAU;

use loftsman_kernel::{Point, Vector};

/// A generator without a library, so that the same seed gives the same points for ever (SplitMix64).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between 0 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    pub(crate) fn whole(&mut self, a: usize, b: usize) -> usize {
        a + (self.next() % (b - a + 1) as u64) as usize
    }

    /// Normally distributed, nearly: twelve uniform numbers.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    pub(crate) fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.whole(0, all.len() - 1)]
    }
}

pub(crate) const KINDS: [&str; 16] = [
    "jagged",
    "noisy circle",
    "noisy wave",
    "zigzag",
    "star",
    "spiral",
    "airfoil",
    "near duplicates",
    "repeated",
    "collinear",
    "cornered",
    "uneven",
    "walk",
    "steps",
    "lattice",
    "there and back",
];

/// One member: its points, and whether they are meant to close.
pub(crate) struct Member {
    pub(crate) kind: &'static str,
    pub(crate) points: Vec<Point>,
    pub(crate) closed: bool,
}

/// The member of a seed: the kind in turn, everything else drawn; one in four at a size of 1e-9 or 1e9.
pub(crate) fn member(seed: u64) -> Member {
    let mut r = Random::new(seed);
    let kind = (seed % KINDS.len() as u64) as usize;
    let (mut points, closed) = flat(kind, &mut r);
    // Out of the plane, sometimes.
    if r.whole(0, 2) == 0 {
        let tilt = r.between(-1.0, 1.0);
        points.iter_mut().for_each(|p| p.z += tilt * p.x);
    }
    let size = r.pick(&[1.0, 1.0, 80.0, 1e-9, 1e9, 1.0]);
    let shift = if r.whole(0, 5) == 0 { Vector::new(7.0, -300.0, 20.0) } else { Vector::zeros() };
    let points = points.iter().map(|p| (p + shift) * size).collect();
    Member { kind: KINDS[kind], points, closed }
}

fn flat(kind: usize, r: &mut Random) -> (Vec<Point>, bool) {
    let point = |x: f64, y: f64| Point::new(x, y, 0.0);
    let m = r.whole(8, 60);
    match kind {
        0 => ((0..m).map(|_| point(r.unit(), r.unit())).collect(), r.whole(0, 1) == 1),
        1 => {
            let (m, noise) = (r.whole(12, 160), 10.0_f64.powf(r.between(-4.0, -1.0)));
            let closed = r.whole(0, 1) == 1;
            let ring = (0..m).map(|i| TAU * i as f64 / m as f64);
            (
                ring.map(|a| point(a.cos() + noise * r.normal(), a.sin() + noise * r.normal())).collect(),
                closed,
            )
        }
        2 => {
            let (m, noise, waves) =
                (r.whole(10, 150), 10.0_f64.powf(r.between(-4.0, -0.7)), r.between(0.0, 12.0));
            (
                (0..m)
                    .map(|i| i as f64 / m as f64)
                    .map(|t| point(4.0 * t, (waves * t).sin() + noise * r.normal()))
                    .collect(),
                false,
            )
        }
        3 => {
            let height = r.between(0.2, 4.0);
            ((0..m).map(|i| point(i as f64, if i % 2 == 1 { height } else { 0.0 })).collect(), false)
        }
        4 => {
            let (spikes, inner, turn) = (r.whole(3, 15), r.between(0.1, 0.9), r.unit());
            let star = (0..2 * spikes).map(|i| {
                let (a, radius) =
                    (TAU * (i as f64 / (2 * spikes) as f64 + turn), if i % 2 == 0 { 1.0 } else { inner });
                point(radius * a.cos(), radius * a.sin())
            });
            (star.collect(), r.whole(0, 2) > 0)
        }
        5 => {
            let turns = r.between(0.5, 8.0);
            (
                (0..m)
                    .map(|i| i as f64 / m as f64)
                    .map(|t| point(t * (TAU * turns * t).cos(), t * (TAU * turns * t).sin()))
                    .collect(),
                false,
            )
        }
        6 => (airfoil(r, m), r.whole(0, 1) == 1),
        7 => {
            let (base, near) = (r.whole(0, 6), 10.0_f64.powf(r.between(-13.0, -2.0)));
            let (points, closed) = flat(base, r);
            let doubled = points.iter().flat_map(|p| {
                let off = Vector::new(near * r.normal(), near * r.normal(), 0.0);
                let both = [*p, p + off];
                if r.whole(0, 3) == 0 { both.to_vec() } else { vec![*p] }
            });
            (doubled.collect(), closed)
        }
        8 => {
            let base = r.whole(0, 6);
            let (points, closed) = flat(base, r);
            (
                points
                    .iter()
                    .flat_map(|p| vec![*p; if r.whole(0, 4) == 0 { r.whole(2, 4) } else { 1 }])
                    .collect(),
                closed,
            )
        }
        9 => {
            let (a, b) = (r.between(-1.0, 1.0), r.between(-1.0, 1.0));
            let mut t = 0.0;
            (
                (0..m)
                    .map(|_| {
                        t += r.unit().powi(3);
                        point(a + t, b - 2.0 * t)
                    })
                    .collect(),
                false,
            )
        }
        10 => {
            let (sides, each) = (r.whole(3, 8), r.whole(2, 20));
            let corners: Vec<Point> = (0..sides)
                .map(|i| TAU * (i as f64 + 0.3 * r.unit()) / sides as f64)
                .map(|a| point(2.0 * a.cos(), a.sin()))
                .collect();
            let noise = if r.whole(0, 1) == 1 { 1e-3 } else { 0.0 };
            let line = (0..sides * each).map(|k| {
                let (side, t) = (k / each, (k % each) as f64 / each as f64);
                let p = corners[side].coords.lerp(&corners[(side + 1) % sides].coords, t);
                point(p.x + noise * r.normal(), p.y + noise * r.normal())
            });
            (line.collect(), r.whole(0, 1) == 1)
        }
        11 => {
            let mut at = Vector::zeros();
            let mut heading = 0.0;
            let spread = r.between(0.5, 4.0);
            (
                (0..m)
                    .map(|_| {
                        heading += r.between(-1.0, 1.0);
                        at += Vector::new(heading.cos(), heading.sin(), 0.0)
                            * 10.0_f64.powf(-spread * r.unit());
                        Point::from(at)
                    })
                    .collect(),
                false,
            )
        }
        12 => {
            let mut at = Vector::zeros();
            (
                (0..m)
                    .map(|_| {
                        at += Vector::new(r.normal(), r.normal(), 0.0);
                        Point::from(at)
                    })
                    .collect(),
                r.whole(0, 3) == 0,
            )
        }
        13 => (
            (0..m)
                .map(|i| point((i / 2) as f64 + 1e-3 * (i % 2) as f64, f64::from(u8::from((i / 2) % 2 == 1))))
                .collect(),
            false,
        ),
        14 => {
            ((0..m).map(|_| point(r.whole(0, 6) as f64, r.whole(0, 6) as f64)).collect(), r.whole(0, 1) == 1)
        }
        _ => {
            let (base, _) = flat(2, r);
            let back: Vec<Point> = base.iter().rev().skip(1).copied().collect();
            ([base, back].concat(), false)
        }
    }
}

/// A four-digit section from trailing edge over the nose and back, its points bunched at the nose or not.
pub(crate) fn airfoil(r: &mut Random, m: usize) -> Vec<Point> {
    let (camber, place, thick) = (r.between(0.0, 0.06), r.between(0.25, 0.6), r.between(0.06, 0.24));
    let (half, bunched) = (m.max(10), r.whole(0, 2) > 0);
    let noise = r.pick(&[0.0, 0.0, 1e-5, 1e-4]);
    let x = |i: usize| {
        let t = i as f64 / half as f64;
        if bunched { 0.5 * (1.0 - (std::f64::consts::PI * t).cos()) } else { t }
    };
    let side = |x: f64, sign: f64| {
        let y = 5.0
            * thick
            * (0.2969 * x.sqrt() - 0.1260 * x - 0.3516 * x * x + 0.2843 * x.powi(3) - 0.1015 * x.powi(4));
        let c = if x < place {
            camber / (place * place) * (2.0 * place * x - x * x)
        } else {
            camber / (1.0 - place).powi(2) * (1.0 - 2.0 * place + 2.0 * place * x - x * x)
        };
        (x, c + sign * y)
    };
    let line = (0..=half).rev().map(|i| side(x(i), 1.0)).chain((1..=half).map(|i| side(x(i), -1.0)));
    line.map(|(x, y)| Point::new(x + noise * r.normal(), y + noise * r.normal(), 0.0)).collect()
}
