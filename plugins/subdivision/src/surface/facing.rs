//! A surface on its way to triangles: its faces divided in four, each as often as it needs, whatever the scheme that makes it.

use std::sync::OnceLock;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Drawn, Faceted, Fineness};
use loftsman_kernel::shape::Location;
use loftsman_kernel::{Point, Vector, parallel};
use smallvec::SmallVec;

use super::apart::Apart;
use super::cut::Cut;
use super::normals::Normals;
use super::places::Place;
use super::quads::{Quads, Since};
use super::sampled::sampled;
use crate::topology::NONE;

/// Points, at most.
const MOST: usize = 1 << 21;
/// Levels of a face, at most: beyond these sizes are rounding.
const LEVELS: u32 = 40;
/// Levels more than the chord needs, at most, for the sake of the angle: where the surface is folded it is never small.
const FOR_ANGLE: u32 = 4;
/// Points beyond which nothing is refined for the sake of the angle.
const MOST_FOR_ANGLE: usize = 1 << 17;

/// What makes a surface of its faces.
pub(crate) trait Scheme: Sync {
    /// What it knows a face by.
    type Own: Copy + Sync;
    /// Levels more than were found to be enough, at most, for the sake of a proof; what is not proved then is said to be as was found.
    const FOR_PROOF: u32;

    /// Divides faces that are not yet: puts down their children, and where the points are that these have more. `nodes` ascend.
    fn refine(&mut self, quads: &mut Quads<Self::Own>, nodes: &[usize]) -> Result<()>;

    /// A bound of the distance that a quad has from triangles, in a state.
    fn apart(&self, own: Self::Own, state: usize, apart: &mut Apart<'_>) -> Result<f64>;

    /// The unit normals at the corners of a quad, in a state, where the surface is to be smooth and has one.
    fn normals(&self, own: Self::Own, state: usize) -> [Option<Vector>; 4];

    /// The unit normal that a quad has at a corner in the first state, where its point has more than one: on a crease that never ends.
    fn side_normal(&self, own: Self::Own, corner: usize) -> Option<Vector> {
        let _ = (own, corner);
        None
    }
}

/// How fine triangles are to be.
pub(crate) struct Aim {
    /// The chord that was asked for.
    asked: f64,
    /// The chord of each state.
    chords: Vec<f64>,
    angle: f64,
}

impl Aim {
    /// Of states of these sizes.
    ///
    /// # Errors
    /// When the fineness is not positive, or all sizes are 0 or one is not finite.
    pub(crate) fn new(fineness: &Fineness, sizes: &[f64]) -> Result<Self> {
        fineness.check()?;
        let (Chord::Absolute(asked) | Chord::Relative(asked)) = fineness.chord;
        let largest = super::net::largest(sizes.iter().copied());
        if largest <= 0.0 {
            return Err(Error::NoExtent("all of the surface is one point".into()));
        }
        if !largest.is_finite() {
            return Err(Error::Invalid("the surface has points that are not finite".into()));
        }
        let chord = |size: &f64| match fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(part) => part * size.max(largest * 1e-3),
        };
        Ok(Self { asked, chords: sizes.iter().map(chord).collect(), angle: fineness.angle })
    }

    /// The states of a surface as the same triangles: each face divided as often as it needs in the worst of them, quads halved, or cut from
    /// their middle where a neighbour is divided further, so that nothing gapes. Faces side by side are no more than one level apart.
    ///
    /// Where a proof takes more than some levels beyond what is found to be enough in the middles of edges and faces, the error is that, and not
    /// certified. For the sake of the angle faces are divided that turn by more and are larger than the chord. Cost: linear in the
    /// triangles, for every state.
    ///
    /// # Errors
    /// When more than two million vertices are needed.
    pub(crate) fn faceted<S: Scheme>(self, scheme: S, quads: Quads<S::Own>) -> Result<Faceted> {
        let mut facing = Facing { scheme, quads, aim: self, judged: Vec::new() };
        facing.refined()?;
        facing.faceted()
    }
}

/// What is known of a face as it is cut.
#[derive(Debug, Clone, Copy)]
struct Judged {
    cut: Cut,
    error: f64,
    /// Whether it is a bound.
    proved: bool,
    /// Whether that depends on the triangles round it.
    from_others: bool,
}

/// A surface on its way to triangles.
struct Facing<S: Scheme> {
    scheme: S,
    quads: Quads<S::Own>,
    aim: Aim,
    /// What is known of each face.
    judged: Vec<Option<Judged>>,
}

impl<S: Scheme> Facing<S> {
    /// Refines until all is near enough.
    fn refined(&mut self) -> Result<()> {
        let chord = self.aim.asked;
        let too_many = || {
            Error::Invalid(format!(
                "the tessellation would take more than {MOST} vertices: ask for a larger chord than {chord}"
            ))
        };
        let odd: Vec<usize> = self.quads.shown().filter(|&k| self.quads.all[k].place.is_err()).collect();
        self.refine(&odd)?;
        odd.iter().for_each(|&k| self.quads.split(k, Since::default()));
        loop {
            self.judged.resize(self.quads.all.len(), None);
            let open = self.open();
            let around = Around::new(&self.quads);
            let verdicts = parallel::map(open.len(), |k| self.judge(open[k], &around));
            let mut more = Vec::new();
            for (&node, verdict) in open.iter().zip(verdicts) {
                let (judged, enough) = verdict?;
                self.judged[node] = Some(judged);
                if !enough {
                    more.push(node);
                }
            }
            if more.iter().any(|&k| self.quads.all[k].level >= LEVELS) {
                return Err(too_many());
            }
            self.refine(&more)?;
            more.iter().for_each(|&node| self.split(node));
            let balanced = self.balance()?;
            if self.quads.normals.len() > MOST {
                return Err(too_many());
            }
            if more.is_empty() && balanced {
                return Ok(());
            }
        }
    }

    /// Divides faces, as far as they are not: their children are there, and not yet in their places. `nodes` ascend.
    fn refine(&mut self, nodes: &[usize]) -> Result<()> {
        let wanted: Vec<usize> =
            nodes.iter().copied().filter(|&k| self.quads.all[k].children.is_none()).collect();
        self.scheme.refine(&mut self.quads, &wanted)
    }

    /// The faces that are shown and not known to be near enough as they are cut now.
    fn open(&self) -> Vec<usize> {
        let known = |judged: Judged, node: usize| {
            !judged.proved || (judged.cut == self.quads.cut(node) && !judged.from_others)
        };
        self.quads.shown().filter(|&k| !self.judged[k].is_some_and(|judged| known(judged, k))).collect()
    }

    /// What is known of a face as it is cut now, and whether that is enough.
    fn judge(&self, node: usize, around: &Around<S>) -> Result<(Judged, bool)> {
        let own = &self.quads.all[node];
        let numbers = self.quads.numbers(node);
        let cut = self.quads.cut(node);
        let mut judged = Judged { cut, error: 0.0, proved: true, from_others: false };
        for (state, &chord) in self.aim.chords.iter().enumerate() {
            let at = self.quads.places(state, &numbers);
            let round = || around.triangles(state, &numbers);
            let mut apart = Apart::new(cut, at, chord, &round);
            let error = self.scheme.apart(own.own, state, &mut apart)?;
            judged.error = judged.error.max(error);
            judged.from_others |= apart.from_others;
            if error > chord {
                return Ok((Judged { proved: false, ..judged }, false));
            }
        }
        let may = own.since.proved < FOR_ANGLE && self.quads.normals.len() <= MOST_FOR_ANGLE;
        Ok((judged, !(may && self.turns(own.own, &numbers))))
    }

    /// Whether a face is larger than the chord and turns by too much along an edge, in any state.
    fn turns(&self, own: S::Own, numbers: &[u32; 9]) -> bool {
        self.aim.chords.iter().enumerate().any(|(state, &chord)| {
            let at = self.quads.places(state, numbers);
            let small = (at[0] - at[2]).norm().max((at[1] - at[3]).norm()) <= chord;
            !small && {
                let normals = self.scheme.normals(own, state);
                (0..4).any(|k| match [normals[k], normals[(k + 1) % 4]] {
                    [Some(m), Some(n)] => m.angle(&n) > self.aim.angle,
                    _ => false,
                })
            }
        })
    }

    /// Puts a face's children in its place; or leaves it as it is where it has been found to be near enough for some levels, and that cannot be
    /// proved.
    fn split(&mut self, node: usize) {
        let own = &self.quads.all[node];
        let mut since = own.since;
        if self.judged[node].is_some_and(|judged| judged.proved) {
            since.proved += 1;
        } else {
            let numbers = self.quads.numbers(node);
            let errors: Vec<f64> =
                (0..self.aim.chords.len()).map(|s| sampled(&self.quads.places(s, &numbers))).collect();
            let found = errors.iter().zip(&self.aim.chords).all(|(error, chord)| *error <= 0.9 * chord);
            since.found += u32::from(found);
            if since.found > S::FOR_PROOF && found {
                let error = errors.into_iter().fold(0.0, f64::max);
                if let Some(judged) = &mut self.judged[node] {
                    judged.error = error;
                }
                return;
            }
        }
        self.judged[node] = None;
        self.quads.split(node, since);
    }

    /// Refines faces beside which others are two levels finer, and finds the middles of those that are cut from there. Whether nothing was
    /// split.
    fn balance(&mut self) -> Result<bool> {
        let mut balanced = true;
        loop {
            let (mut uneven, mut fans) = (Vec::new(), Vec::new());
            for k in self.quads.shown() {
                let corners = &self.quads.all[k].corners;
                let next = |i: usize| corners[(i + 1) % 4];
                let middles = [0, 1, 2, 3].map(|i| self.quads.shown_middle(corners[i], next(i)));
                let finer = |i: usize| {
                    middles[i].is_some_and(|m| {
                        [corners[i], next(i)].into_iter().any(|end| self.quads.shown_middle(m, end).is_some())
                    })
                };
                if (0..4).any(finer) {
                    uneven.push(k);
                } else if middles.iter().any(Option::is_some) {
                    fans.push(k);
                }
            }
            if uneven.is_empty() {
                self.refine(&fans)?;
                return Ok(balanced);
            }
            balanced = false;
            self.refine(&uneven)?;
            for node in uneven {
                let since = self.quads.all[node].since;
                self.quads.split(node, since);
            }
            if self.quads.normals.len() > MOST {
                return Ok(false);
            }
        }
    }

    fn faceted(self) -> Result<Faceted> {
        let quads = &self.quads;
        let mut number = vec![NONE; quads.normals.len()];
        let (mut used, mut corners) = (Vec::new(), Vec::new());
        let (mut places, mut of_corners): (Vec<Location>, Vec<Location>) = Default::default();
        let (mut error, mut certified) = (0.0_f64, true);
        let mut normals = Normals::default();
        for k in quads.shown() {
            let (Ok(place), Some(judged)) = (&quads.all[k].place, &self.judged[k]) else { continue };
            error = error.max(judged.error);
            certified &= judged.proved;
            let numbers = quads.numbers(k);
            for triangle in quads.cut(k).triangles() {
                for at in triangle {
                    let name = numbers[usize::from(at)] as usize;
                    let [u, v] = of_place(place, usize::from(at));
                    let here = Location::Face(place.face, u, v);
                    of_corners.push(here);
                    if number[name] == NONE {
                        number[name] = used.len() as u32;
                        used.push(name);
                        places.push(here);
                        normals.point(quads.normals[name]);
                    }
                    corners.push(number[name]);
                    normals.corner(number[name], self.side_normal(k, usize::from(at)));
                }
            }
        }
        let chosen = |points: &Vec<Point>| used.iter().map(|&k| points[k]).collect::<Vec<_>>();
        let states: Vec<Vec<Point>> = quads.points.iter().map(chosen).collect();
        let starts = (0..=corners.len() / 3).map(|k| 3 * k).collect();
        let mut mesh = Mesh::from_parts(states.first().cloned().unwrap_or_default(), corners, starts)?;
        mesh.normals = normals.into_layer();
        let tolerance = self.aim.chords.iter().copied().fold(0.0, f64::max);
        let drawn = Drawn::Mesh(mesh);
        Ok(Faceted { drawn, states, tolerance, error, certified, places, corners: of_corners })
    }

    /// The normal of its own that a face has at one of its points ([`Quads::numbers`]).
    fn side_normal(&self, node: usize, at: usize) -> Option<Vector> {
        let quad = &self.quads.all[node];
        match at {
            0..=3 => self.scheme.side_normal(quad.own, at),
            // The middle of a side is the second corner of the child there, which a face has that is cut there.
            4..=7 => {
                let (first, ..) = quad.children?;
                self.scheme.side_normal(self.quads.all[first as usize + at - 4].own, 1)
            }
            _ => None,
        }
    }
}

/// The parameters of a corner of a face, of the middle of an edge, or of its own.
fn of_place(place: &Place, at: usize) -> [f64; 2] {
    match at {
        0..=3 => place.corners[at],
        4..=7 => place.middle(at - 4),
        _ => place.centre(),
    }
}

/// Which faces there are at each point, looked for where somebody asks.
struct Around<'a, S: Scheme> {
    quads: &'a Quads<S::Own>,
    faces: OnceLock<Vec<SmallVec<[u32; 6]>>>,
}

impl<'a, S: Scheme> Around<'a, S> {
    fn new(quads: &'a Quads<S::Own>) -> Self {
        Self { quads, faces: OnceLock::new() }
    }

    fn faces(&self) -> &[SmallVec<[u32; 6]>] {
        self.faces.get_or_init(|| {
            let mut all = vec![SmallVec::new(); self.quads.normals.len()];
            for k in self.quads.shown() {
                let corners = &self.quads.all[k].corners;
                for (i, &a) in corners.iter().enumerate() {
                    all[a as usize].push(k as u32);
                    if let Some(middle) = self.quads.shown_middle(a, corners[(i + 1) % corners.len()]) {
                        all[middle as usize].push(k as u32);
                    }
                }
            }
            all
        })
    }

    /// The triangles of a face and of all that have a point in common with it.
    fn triangles(&self, state: usize, numbers: &[u32; 9]) -> Vec<[Point; 3]> {
        let faces = self.faces();
        let at = |name: u32| faces.get(name as usize).into_iter().flatten().copied();
        let mut near: Vec<u32> = numbers[..8].iter().flat_map(|&name| at(name)).collect();
        near.sort_unstable();
        near.dedup();
        let mut all = Vec::with_capacity(2 * near.len());
        for k in near {
            let points = self.quads.places(state, &self.quads.numbers(k as usize));
            let cut = self.quads.cut(k as usize).triangles();
            all.extend(cut.iter().map(|t| t.map(|k| points[usize::from(k)])));
        }
        all
    }
}
