//! A surface as triangles between limits of vertices.

use std::sync::OnceLock;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{Chord, Drawn, Faceted, Fineness};
use loftsman_kernel::shape::Location;
use loftsman_kernel::{Point, Vector, parallel};
use smallvec::SmallVec;

use super::apart::{Faced, apart};
use super::cut::Cut;
use super::places::Place;
use super::sampled::sampled;
use super::template::Templates;
use super::tree::{Node, Since, Tree};
use super::{SubdivisionSurface, refused};
use crate::cage::Cage;
use crate::catmull_clark::{limit_points, refine};
use crate::topology::NONE;

/// Points, at most.
const MOST: usize = 1 << 21;
/// Levels of a face, at most: beyond these sizes are rounding.
const LEVELS: u32 = 40;
/// Levels more than the chord needs, at most, for the sake of the angle: where the surface is folded it is never small.
const FOR_ANGLE: u32 = 4;
/// Levels more than were found to be enough, at most, for the sake of a proof: round vertices that are sharp to a finite degree bounds are
/// coarse.
const FOR_PROOF: u32 = 4;
/// Points beyond which nothing is refined for the sake of the angle.
const MOST_FOR_ANGLE: usize = 1 << 17;

/// The states of a surface as the same triangles: each face refined as often as it needs in the worst of them, vertices at their limits,
/// quads halved, or cut from their middle where a neighbour is refined further, so that nothing gapes. Faces side by side are no more than
/// one level apart.
///
/// The error is a bound of the distance that any point of the surface has from the triangles: of regular quads by the second
/// differences of their Bézier points, of others by those of the quadrants they consist of, down to one whose neighbourhood, in the hull of which
/// it lies, is near enough. Where that takes more than some levels beyond what is found to be enough in the middles of edges and faces, it
/// is that, and not certified. For the sake of the angle faces are refined that turn by more and are larger than the chord. Cost: linear in
/// the triangles, for every state.
///
/// # Errors
/// [`Error::NoExtent`] where all is one point; when there is no state, the states are different surfaces, the fineness is not positive,
/// or more than two million vertices are needed.
pub(super) fn tessellate(states: &[&SubdivisionSurface], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
    };
    let alike = |s: &&SubdivisionSurface| {
        let (a, b) = (&s.cage, &first.cage);
        a.topology() == b.topology()
            && (&a.creases, &a.corners, &a.holes, &a.intervals, a.boundary)
                == (&b.creases, &b.corners, &b.holes, &b.intervals, b.boundary)
    };
    if !states.iter().all(alike) {
        return Err(Error::Invalid(
            "the states of the surface have different faces or creases: they are not one surface".into(),
        ));
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let (Chord::Absolute(chord) | Chord::Relative(chord)) = fineness.chord;
    if !positive(chord) || !positive(fineness.angle) {
        return Err(Error::Invalid(
            "the chord and the angle of a tessellation must be positive and finite".into(),
        ));
    }
    let sizes: Vec<f64> = states.iter().map(|s| size(&s.cage).map_err(refused)).collect::<Result<_>>()?;
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(Error::NoExtent("all of the surface is one point".into()));
    }
    if !largest.is_finite() {
        return Err(Error::Invalid("the surface has points that are not finite".into()));
    }
    let chords: Vec<f64> = sizes
        .iter()
        .map(|size| match fineness.chord {
            Chord::Absolute(length) => length,
            Chord::Relative(part) => part * size.max(largest * 1e-3),
        })
        .collect();
    let tree = Tree::new(states.iter().map(|s| s.cage.clone()).collect(), &first.layout.first)?;
    let mut facing =
        Facing { tree, chords, angle: fineness.angle, templates: Templates::default(), judged: Vec::new() };
    facing.refined(chord)?;
    facing.faceted()
}

/// The diagonal of the box around the limits of a cage's vertices; where these are one point but for rounding, of those of the refined cage;
/// 0 where these are, too.
fn size(cage: &Cage) -> crate::error::Result<f64> {
    let least = 1e-12 * diagonal(cage.points());
    let own = diagonal(&limit_points(cage)?);
    if own > least || !own.is_finite() {
        return Ok(own);
    }
    let finer = diagonal(&limit_points(&refine(cage)?)?);
    Ok(if finer > least { finer } else { 0.0 })
}

pub(super) fn diagonal(points: &[Point]) -> f64 {
    let start = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    let (low, high) = points.iter().fold(start, |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
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
struct Facing {
    tree: Tree,
    /// The chord of each state.
    chords: Vec<f64>,
    angle: f64,
    templates: Templates,
    /// What is known of each face.
    judged: Vec<Option<Judged>>,
}

impl Facing {
    /// Refines until all is near enough.
    fn refined(&mut self, chord: f64) -> Result<()> {
        let too_many = || {
            Error::Invalid(format!(
                "the tessellation would take more than {MOST} vertices: ask for a larger chord than {chord}"
            ))
        };
        let odd: Vec<usize> = self.tree.shown().filter(|&k| self.tree.nodes[k].place.is_err()).collect();
        self.tree.refine(&odd)?;
        odd.iter().for_each(|&k| self.tree.split(k, Since::default()));
        loop {
            self.judged.resize(self.tree.nodes.len(), None);
            let open = self.open();
            let around = Around::new(&self.tree);
            let verdicts = parallel::map(open.len(), |k| self.judge(open[k], &around));
            let mut more = Vec::new();
            for (&node, verdict) in open.iter().zip(verdicts) {
                let (judged, enough) = verdict?;
                self.judged[node] = Some(judged);
                if !enough {
                    more.push(node);
                }
            }
            if more.iter().any(|&k| self.tree.nodes[k].level >= LEVELS) {
                return Err(too_many());
            }
            self.tree.refine(&more)?;
            more.iter().for_each(|&node| self.split(node));
            let balanced = self.balance()?;
            if self.tree.normals.len() > MOST {
                return Err(too_many());
            }
            if more.is_empty() && balanced {
                return Ok(());
            }
        }
    }

    /// The faces that are shown and not known to be near enough as they are cut now.
    fn open(&self) -> Vec<usize> {
        let known = |judged: Judged, node: usize| {
            let cut = self.tree.cut(&self.tree.corners(&self.tree.nodes[node]));
            !judged.proved || (judged.cut == cut && !judged.from_others)
        };
        self.tree.shown().filter(|&k| !self.judged[k].is_some_and(|judged| known(judged, k))).collect()
    }

    /// What is known of a face as it is cut now, and whether that is enough.
    fn judge(&self, node: usize, around: &Around) -> Result<(Judged, bool)> {
        let own = &self.tree.nodes[node];
        let batch = &self.tree.batches[own.batch as usize];
        let corners = self.tree.corners(own);
        let numbers = self.tree.numbers(own, &corners);
        let cut = self.tree.cut(&corners);
        let mut judged = Judged { cut, error: 0.0, proved: true, from_others: false };
        for (state, &chord) in self.chords.iter().enumerate() {
            let at = self.places(state, &numbers);
            let faced = Faced { cage: &batch.cages[state], face: own.face as usize, cut, at };
            let round = || around.triangles(self, state, &numbers);
            let (error, from_others) = apart(&self.templates, &faced, chord, &round)?;
            judged.error = judged.error.max(error);
            judged.from_others |= from_others;
            if error > chord {
                return Ok((Judged { proved: false, ..judged }, false));
            }
        }
        let may = own.since.proved < FOR_ANGLE && self.tree.normals.len() <= MOST_FOR_ANGLE;
        Ok((judged, !(may && self.turns(own, &numbers))))
    }

    /// Where numbered points are in a state; the origin where there is none.
    fn places(&self, state: usize, numbers: &[u32; 9]) -> [Point; 9] {
        let points = &self.tree.points[state];
        numbers.map(|k| points.get(k as usize).copied().unwrap_or_default())
    }

    /// Whether a face is larger than the chord and turns by too much along an edge, in any state.
    fn turns(&self, node: &Node, numbers: &[u32; 9]) -> bool {
        let batch = &self.tree.batches[node.batch as usize];
        let cage = &batch.cages[0];
        let topology = cage.topology();
        let corners = topology.face(node.face as usize);
        let sharp = |v: usize| {
            cage.vertex_sharpness(v) > 0.0 || topology.vertex_edges(v).any(|e| cage.crease(e as usize) > 0.0)
        };
        let sharp = [0, 1, 2, 3].map(|k| sharp(corners[k] as usize));
        batch.normals.iter().enumerate().any(|(state, normals)| {
            let at = self.places(state, numbers);
            let small = (at[0] - at[2]).norm().max((at[1] - at[3]).norm()) <= self.chords[state];
            !small
                && (0..4).any(|k| {
                    let next = (k + 1) % 4;
                    match [k, next].map(|k| normals[corners[k] as usize]) {
                        [Some(m), Some(n)] if !sharp[k] && !sharp[next] => m.angle(&n) > self.angle,
                        _ => false,
                    }
                })
        })
    }

    /// Puts a face's children in its place; or leaves it as it is where it has been found to be near enough for some levels, and that cannot be
    /// proved.
    fn split(&mut self, node: usize) {
        let own = &self.tree.nodes[node];
        let mut since = own.since;
        if self.judged[node].is_some_and(|judged| judged.proved) {
            since.proved += 1;
        } else {
            let numbers = self.tree.numbers(own, &self.tree.corners(own));
            let errors: Vec<f64> =
                (0..self.chords.len()).map(|s| sampled(&self.places(s, &numbers))).collect();
            let found = errors.iter().zip(&self.chords).all(|(error, chord)| *error <= 0.9 * chord);
            since.found += u32::from(found);
            if since.found > FOR_PROOF && found {
                let error = errors.into_iter().fold(0.0, f64::max);
                if let Some(judged) = &mut self.judged[node] {
                    judged.error = error;
                }
                return;
            }
        }
        self.judged[node] = None;
        self.tree.split(node, since);
    }

    /// Refines faces beside which others are two levels finer, and finds the middles of those that are cut from there. Whether nothing was
    /// split.
    fn balance(&mut self) -> Result<bool> {
        let mut balanced = true;
        loop {
            let (mut uneven, mut fans) = (Vec::new(), Vec::new());
            for k in self.tree.shown() {
                let corners = self.tree.corners(&self.tree.nodes[k]);
                let next = |i: usize| corners[(i + 1) % 4];
                let middles = [0, 1, 2, 3].map(|i| self.tree.shown_middle(corners[i], next(i)));
                let finer = |i: usize| {
                    middles[i].is_some_and(|m| {
                        [corners[i], next(i)].into_iter().any(|end| self.tree.shown_middle(m, end).is_some())
                    })
                };
                if (0..4).any(finer) {
                    uneven.push(k);
                } else if middles.iter().any(Option::is_some) {
                    fans.push(k);
                }
            }
            if uneven.is_empty() {
                self.tree.refine(&fans)?;
                return Ok(balanced);
            }
            balanced = false;
            self.tree.refine(&uneven)?;
            for node in uneven {
                let since = self.tree.nodes[node].since;
                self.tree.split(node, since);
            }
            if self.tree.normals.len() > MOST {
                return Ok(false);
            }
        }
    }

    fn faceted(self) -> Result<Faceted> {
        let tree = &self.tree;
        let mut number = vec![NONE; tree.normals.len()];
        let (mut used, mut corners) = (Vec::new(), Vec::new());
        let mut places: Vec<Location> = Vec::new();
        let (mut error, mut certified) = (0.0_f64, true);
        for k in tree.shown() {
            let node = &tree.nodes[k];
            let (Ok(place), Some(judged)) = (&node.place, &self.judged[k]) else { continue };
            error = error.max(judged.error);
            certified &= judged.proved;
            let own = tree.corners(node);
            let numbers = tree.numbers(node, &own);
            for triangle in tree.cut(&own).triangles() {
                for at in triangle {
                    let name = numbers[usize::from(at)] as usize;
                    if number[name] == NONE {
                        number[name] = used.len() as u32;
                        used.push(name);
                        let [u, v] = of_place(place, usize::from(at));
                        places.push(Location::Face(place.face, u, v));
                    }
                    corners.push(number[name]);
                }
            }
        }
        let chosen = |points: &Vec<Point>| used.iter().map(|&k| points[k]).collect::<Vec<_>>();
        let states: Vec<Vec<Point>> = tree.points.iter().map(chosen).collect();
        let starts = (0..=corners.len() / 3).map(|k| 3 * k).collect();
        let mut mesh = Mesh::from_parts(states.first().cloned().unwrap_or_default(), corners, starts)?;
        let normals = used.iter().map(|&k| tree.normals[k].unwrap_or_else(Vector::z));
        mesh.normals = Layer::per_point(normals.collect());
        let tolerance = self.chords.iter().copied().fold(0.0, f64::max);
        Ok(Faceted { drawn: Drawn::Mesh(mesh), states, tolerance, error, certified, places })
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
struct Around<'a> {
    tree: &'a Tree,
    faces: OnceLock<Vec<SmallVec<[u32; 6]>>>,
}

impl<'a> Around<'a> {
    fn new(tree: &'a Tree) -> Self {
        Self { tree, faces: OnceLock::new() }
    }

    fn faces(&self) -> &[SmallVec<[u32; 6]>] {
        self.faces.get_or_init(|| {
            let mut all = vec![SmallVec::new(); self.tree.normals.len()];
            for k in self.tree.shown() {
                let corners = self.tree.corners(&self.tree.nodes[k]);
                for (i, &a) in corners.iter().enumerate() {
                    all[a as usize].push(k as u32);
                    if let Some(middle) = self.tree.shown_middle(a, corners[(i + 1) % corners.len()]) {
                        all[middle as usize].push(k as u32);
                    }
                }
            }
            all
        })
    }

    /// The triangles of a face and of all that have a point in common with it.
    fn triangles(&self, facing: &Facing, state: usize, numbers: &[u32; 9]) -> Vec<[Point; 3]> {
        let faces = self.faces();
        let at = |name: u32| faces.get(name as usize).into_iter().flatten().copied();
        let mut near: Vec<u32> = numbers[..8].iter().flat_map(|&name| at(name)).collect();
        near.sort_unstable();
        near.dedup();
        let mut all = Vec::with_capacity(2 * near.len());
        for k in near {
            let node = &self.tree.nodes[k as usize];
            let corners = self.tree.corners(node);
            let points = facing.places(state, &self.tree.numbers(node, &corners));
            let cut = self.tree.cut(&corners).triangles();
            all.extend(cut.iter().map(|t| t.map(|k| points[usize::from(k)])));
        }
        all
    }
}
