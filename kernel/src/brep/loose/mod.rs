//! Some faces of a Brep move, the rest stands still, and all of it stays together.
//!
//! Parameter curves stay where they are, so that everything is linear: the displacement of a surface along an edge is a sum of its control
//! vertices' displacements with fixed coefficients. What holds:
//!
//! * *Beside a face that stands still* an edge stays to the last bit. Every control vertex stands still on which anything depends that
//!   happens along the edge; where the two faces meet smoothly, derivatives across it too. A surface that has too few others is given knots
//!   until a place that is to move can. There are no equations, and nothing is left between places at which they hold.
//! * *Between two faces that move* displacements are the same along the edge: exactly where it is a line of constant parameter of both and
//!   runs through both at one pace (rows for the control vertices of both boundary curves in one space), or both are polynomials along it (as many
//!   places as these have coefficients: flat faces with straight edges). Where it is such a line of one face only, that face's boundary is given
//!   knots and follows at its own places; what is left between them, some 10⁻⁶ of the way as a rule, is measured afterwards, told, and in
//!   the edge's tolerance. An edge of neither kind stays where it is.
//! * *Where they meet smoothly* along a line of parameters of one of them, they go on doing so ([`tangent`]), exactly or at places as above; along
//!   any other edge a crease may appear. How much the angle between them has changed is told for all edges that follow.
//! * *Edges between them follow*, and vertices: as the curve on one of the faces, exactly where it is a line of constant parameter, else by
//!   interpolation in the edge's own space, refined.

mod edge;
mod fold;
mod follow;
mod measure;
mod pair;
mod room;
mod seam;
mod settle;
mod sheet;
mod strand;
mod tangent;
mod touch;
mod trace;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use self::follow::Edges;
pub use self::measure::Opening;
use self::pair::Tie;
use self::sheet::{Sheet, Still};
use super::{Brep, Parts};
use crate::Point;
use crate::error::{Error, Result};
use crate::shape::{Bond, Bonds, Shape, Stencil};
use crate::spline::Surface;

/// Coefficients of a row below this part of its largest are rounding.
const ROUNDING: f64 = 1e-14;

/// Which faces of a Brep an edit may move.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Moving {
    faces: Option<BTreeSet<usize>>,
    neighbours: usize,
    sharp: bool,
}

impl Moving {
    /// The faces that are asked about, and no other.
    pub fn new() -> Self {
        Self::default()
    }

    /// These faces, whichever are asked about.
    #[must_use]
    pub fn faces(mut self, faces: impl IntoIterator<Item = usize>) -> Self {
        self.faces = Some(faces.into_iter().collect());
        self
    }

    /// And so many rings of faces around them.
    #[must_use]
    pub fn neighbours(mut self, rings: usize) -> Self {
        self.neighbours = rings;
        self
    }

    /// Lets creases appear at edges where faces meet smoothly.
    #[must_use]
    pub fn sharp(mut self) -> Self {
        self.sharp = true;
        self
    }
}

/// Whether a Brep is to be edited, and how far that is prepared. No part of what it is: all states are equal.
#[derive(Debug, Clone, Default)]
pub(super) enum Motion {
    #[default]
    None,
    Wished(Moving),
    Ready(Arc<Loose>),
    /// An edit has ended, and this did not move.
    Settled(Arc<settle::Rest>),
}

impl PartialEq for Motion {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A control vertex that follows: where it is beside its base, by those of others.
#[derive(Debug, Clone, PartialEq)]
struct Follower {
    vertex: usize,
    row: Stencil,
}

/// A Brep made ready to be edited.
#[derive(Debug)]
pub(super) struct Loose {
    /// The faces that may move.
    faces: Vec<usize>,
    /// The edges that follow.
    edges: Vec<usize>,
    held: Vec<usize>,
    bonds: Vec<Bond>,
    followers: Vec<Follower>,
    /// All control vertices as they were.
    base: Vec<Point>,
    /// What it was before it was made ready: what faces and edges that do not move may be again.
    original: Parts,
    /// The openings along edges that follow, as they were.
    before: Vec<Opening>,
    /// And along those at which faces that move may get a crease with ones that stand still.
    beside: Vec<Opening>,
    /// Edges that are held together at places only.
    between: BTreeSet<usize>,
    /// Edges at which faces go on meeting smoothly.
    smooth: BTreeSet<usize>,
    /// How many edges stay though their faces move.
    stays: usize,
}

impl Brep {
    /// The same Brep, of which edits move these faces: without it, those that constraints name by their places.
    ///
    /// ```
    /// use loftsman_kernel::{Point, brep::{Brep, Moving}, shape::Shape};
    /// use loftsman_kernel::edit::{Ask, Edit};
    /// use loftsman_kernel::{functional::position, shape::Location};
    ///
    /// let block = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0))?.moving(Moving::new().neighbours(1));
    /// let top = Location::Face(1, 1.5, 1.0);
    /// let edited = Edit::new(&block).ask(position(top).by([0.0, 0.0, 0.25])).solve()?;
    /// assert!((edited.shape().value(top, Default::default())?.z - 1.25).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn moving(mut self, moving: Moving) -> Self {
        self.motion = Motion::Wished(moving);
        self
    }

    fn loose(&self) -> Option<&Arc<Loose>> {
        match &self.motion {
            Motion::Ready(loose) => Some(loose),
            _ => None,
        }
    }

    /// The faces that an edit may move: all as long as nobody says which.
    pub(super) fn may_move(&self) -> Vec<usize> {
        self.loose().map_or_else(|| (0..self.face_count()).collect(), |loose| loose.faces.clone())
    }

    /// The faces that move where something is asked of these.
    fn movers(&self, moving: &Moving, asked: &[(u32, [f64; 2])]) -> Result<BTreeSet<usize>> {
        let count = self.face_count();
        let places = asked.iter().map(|(face, _)| *face as usize);
        let mut faces = moving.faces.clone().unwrap_or_else(|| places.clone().collect());
        if let Some(face) =
            faces.iter().chain(places.clone().collect::<Vec<_>>().iter()).find(|f| **f >= count)
        {
            return Err(Error::Invalid(format!(
                "there is no face {face}: the brep has {count}, numbered from 0"
            )));
        }
        if faces.is_empty() {
            return Err(Error::Invalid(
                "nothing that is asked names a face of the brep, so that none may move: say which (\"faces\": [number, …])".into(),
            ));
        }
        for _ in 0..moving.neighbours {
            let edges: BTreeSet<usize> =
                faces.iter().flat_map(|&f| self.loops(f)).flatten().map(|one| one.edge).collect();
            let before = faces.len();
            faces.extend(edges.into_iter().flat_map(|edge| self.uses(edge)).map(|one| one.face));
            if faces.len() == before {
                break;
            }
        }
        Ok(faces)
    }

    /// This Brep ready for an edit.
    fn loosened(&self, moving: &Moving, places: &[(u32, [f64; 2])]) -> Result<Self> {
        let faces = self.movers(moving, places)?;
        for &(face, at) in places {
            self.check_place(face as usize, at)?;
        }
        let on = |face: usize| -> Vec<[f64; 2]> {
            places.iter().filter(|(f, _)| *f as usize == face).map(|(_, at)| *at).collect()
        };
        let mut sheets = BTreeMap::new();
        for &face in &faces {
            sheets.insert(face, self.sheet(face, &on(face))?);
        }
        // Edges of faces that all move, and what keeps these together there.
        let mut ties = BTreeMap::new();
        for one in faces.iter().flat_map(|&face| self.loops(face)).flatten() {
            let free = self.uses(one.edge).iter().all(|place| faces.contains(&place.face));
            if free && !ties.contains_key(&one.edge) {
                ties.insert(one.edge, self.tie(one.edge, &sheets)?);
            }
        }
        let stays = ties.values().filter(|tie| **tie == Tie::Held).count();
        ties.retain(|_, tie| *tie != Tie::Held);
        let moves = |edge: usize| ties.contains_key(&edge);
        self.hold(&mut sheets, &moves, moving)?;
        let smooth = if moving.sharp { BTreeSet::new() } else { self.stay_smooth(&ties, &sheets)? };
        for &edge in ties.keys() {
            let order = usize::from(smooth.contains(&edge));
            for one in self.uses(edge) {
                if let Some(sheet) = sheets.get_mut(&one.face) {
                    sheet.tied.push(Still::Edge {
                        edge,
                        chain: one.chain,
                        number: one.number,
                        order,
                        among: true,
                    });
                }
            }
        }
        for (&edge, &tie) in &ties {
            self.elevate_along(edge, tie, &mut sheets)?;
        }
        let moved = self.free(places, &ties, &mut sheets)?;
        for (&edge, &tie) in ties.iter().filter(|(edge, _)| smooth.contains(edge)) {
            self.refine_across(edge, tie, &mut sheets)?;
        }
        // Twice: a face that others follow may be given knots after they were.
        for _ in 0..2 {
            for (&edge, &tie) in &ties {
                self.refine_along(edge, tie, &moved, &mut sheets)?;
            }
        }
        // The same Brep with these surfaces and parameter curves, and with edges that can follow.
        let mut parts = self.parts();
        for (&face, sheet) in &sheets {
            parts.faces[face].surface = sheet.surface.clone();
            for (chain, curves) in parts.faces[face].loops.iter_mut().zip(&sheet.curves) {
                for (one, curve) in chain.iter_mut().zip(curves) {
                    one.parameters = Some(curve.clone());
                }
            }
        }
        let mut plans = BTreeMap::new();
        for &edge in ties.keys() {
            plans.insert(edge, edge::replace(self, edge, &sheets, &mut parts)?);
        }
        let mut ready = Self::new(parts)?;
        let seams = if moving.sharp { ready.seams(&sheets)? } else { Vec::new() };
        ready.prepare(&sheets, &ties, &plans, (smooth, stays, seams), self.parts())?;
        if moving.sharp {
            ready.look_beside(&sheets)?;
        }
        Ok(ready)
    }

    /// What stands still of the faces that move.
    fn hold(
        &self,
        sheets: &mut BTreeMap<usize, Sheet>,
        moves: &dyn Fn(usize) -> bool,
        moving: &Moving,
    ) -> Result<()> {
        // Vertices of edges that stand still.
        let mut still = BTreeSet::new();
        for edge in (0..self.edge_count()).filter(|&edge| !self.uses(edge).is_empty() && !moves(edge)) {
            still.extend(self.ends(edge).into_iter().flatten());
        }
        let (all, mut smooth) = (sheets.keys().copied().collect::<BTreeSet<_>>(), BTreeMap::new());
        for (&face, sheet) in sheets.iter_mut() {
            for (chain, uses) in self.loops(face).iter().enumerate() {
                for (number, one) in uses.iter().enumerate() {
                    if !moves(one.edge) {
                        let order = if moving.sharp {
                            0
                        } else {
                            let known = smooth.get(&one.edge).copied();
                            let meets = match known {
                                Some(meets) => meets,
                                None => self.meets_smoothly(one.edge)?,
                            };
                            smooth.insert(one.edge, meets);
                            usize::from(meets)
                        };
                        let among = self.uses(one.edge).iter().all(|place| all.contains(&place.face));
                        sheet.still.push(Still::Edge { edge: one.edge, chain, number, order, among });
                        continue;
                    }
                    let Some(ends) = self.ends(one.edge) else { continue };
                    let places = sheet.curves[chain][number].ends()?;
                    for (vertex, at) in ends.into_iter().zip(places) {
                        if still.contains(&vertex) {
                            sheet.still.push(Still::Vertex { vertex, at });
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Whether the faces of an edge have one tangent plane all along it, as far as files tell: to within 1°.
    fn meets_smoothly(&self, edge: usize) -> Result<bool> {
        let (Some(edge_whole), [first, second]) = (self.edge(edge), self.uses(edge)) else {
            return Ok(false);
        };
        if first.face == second.face {
            return Ok(false);
        }
        let (Some(f), Some(g)) = (self.surface(first.face), self.surface(second.face)) else {
            return Ok(false);
        };
        let (from, to) = edge_whole.range;
        let mut starts: [Option<(f64, f64)>; 2] = [None, None];
        let mut compared = 0;
        for k in 1..8 {
            let t = from + (to - from) * (f64::from(k) / 8.0);
            let point = edge_whole.curve.point(t)?;
            let mut normals = Vec::new();
            for (surface, start) in [&f, &g].into_iter().zip(&mut starts) {
                let at = match *start {
                    Some(start) => surface.foot(point, start)?.at,
                    None => surface.closest(point)?.at,
                };
                *start = Some(at);
                normals.push(normal(surface, at)?);
            }
            if let [Some(a), Some(b)] = normals[..] {
                compared += 1;
                if a.cross(&b).norm() > measure::MEETS {
                    return Ok(false);
                }
            }
        }
        Ok(compared > 0)
    }

    /// Rows and followers of a Brep whose surfaces and edges are those of the edit.
    fn prepare(
        &mut self,
        sheets: &BTreeMap<usize, Sheet>,
        ties: &BTreeMap<usize, Tie>,
        plans: &BTreeMap<usize, edge::Plan>,
        (smooth, stays, seams): (BTreeSet<usize>, usize, Vec<Bond>),
        original: Parts,
    ) -> Result<()> {
        let mut free = vec![false; self.net.len()];
        for (&face, sheet) in sheets {
            let held = sheet.held()?;
            let range = self.range_of(face);
            for (k, vertex) in range.enumerate() {
                free[vertex] = !held.contains(&k);
            }
        }
        let held: Vec<usize> = (0..self.net.len()).filter(|&k| !free[k]).collect();
        let (mut bonds, mut between) = (seams, BTreeSet::new());
        for (&edge, &tie) in ties {
            let edges = Edges { sheets, ties, smooth: &smooth, free: &free };
            let rows = pair::rows(self, edge, &edges, tie)?;
            if rows.places {
                between.insert(edge);
            }
            // What rounding has left of functions that end at a corner would be an equation of its own.
            let clean = |row: Stencil| -> Option<Stencil> {
                let least = ROUNDING * row.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
                let row: Stencil = row.iter().filter(|(_, c)| c.abs() > least).collect();
                row.vertices().iter().any(|v| free[*v]).then_some(row)
            };
            let mut rows = rows.rows;
            if smooth.contains(&edge) {
                rows.extend(self.smooth_rows(edge, tie, sheets)?);
            }
            let kept: Vec<Stencil> = rows.into_iter().filter_map(clean).collect();
            if !kept.is_empty() {
                let mut faces: Vec<String> = self.uses(edge).iter().map(|one| one.face.to_string()).collect();
                faces.dedup();
                bonds.push(Bond { name: format!("edge {edge} of face {}", faces.join(" and ")), rows: kept });
            }
        }
        let mut followers = Vec::new();
        for (&edge, plan) in plans {
            edge::followers(self, edge, plan, sheets, &mut followers)?;
        }
        let follow: BTreeSet<usize> = ties.keys().copied().collect();
        self.vertices_follow(sheets, &follow, &mut followers)?;
        for follower in &mut followers {
            // What stands still says nothing.
            follower.row = follower.row.iter().filter(|(v, c)| free[*v] && *c != 0.0).collect();
        }
        followers.retain(|follower| !follower.row.vertices().is_empty());
        let edges: Vec<usize> = follow.into_iter().collect();
        let before = self.openings_of(&edges)?;
        self.motion = Motion::Ready(Arc::new(Loose {
            faces: sheets.keys().copied().collect(),
            edges,
            held,
            bonds,
            followers,
            base: self.net.clone(),
            original,
            before,
            beside: Vec::new(),
            between,
            smooth,
            stays,
        }));
        Ok(())
    }

    /// The vertices at the ends of edges that follow, and those alone in faces that move.
    fn vertices_follow(
        &self,
        sheets: &BTreeMap<usize, Sheet>,
        follow: &BTreeSet<usize>,
        followers: &mut Vec<Follower>,
    ) -> Result<()> {
        let mut known = BTreeSet::new();
        for (&face, sheet) in sheets {
            for (uses, curves) in self.loops(face).iter().zip(&sheet.curves) {
                for (one, curve) in uses.iter().zip(curves).filter(|(one, _)| follow.contains(&one.edge)) {
                    let Some(ends) = self.ends(one.edge) else { continue };
                    for (vertex, at) in ends.into_iter().zip(curve.ends()?) {
                        if known.insert(vertex) {
                            let row = self.row_at(&sheet.surface, face, at)?;
                            followers.push(Follower { vertex: self.places.vertices + vertex, row });
                        }
                    }
                }
            }
            for &vertex in self.lone_vertices(face) {
                if known.insert(vertex) {
                    let (u, v) = sheet.surface.closest(self.vertices()[vertex])?.at;
                    let row = self.row_at(&sheet.surface, face, [u, v])?;
                    followers.push(Follower { vertex: self.places.vertices + vertex, row });
                }
            }
        }
        Ok(())
    }

    /// The row of a place on a face.
    fn row_at(&self, surface: &Surface, face: usize, at: [f64; 2]) -> Result<Stencil> {
        self.stencil(strand::location(surface, face, at), crate::shape::Derivative::POSITION)
    }
}

/// Steps over the whole domain that are shorter than this part of those in the other direction are rounding: at a pole an edit leaves
/// such behind, and they point anywhere.
const NO_STEP: f64 = 1e-9;

/// The unit vector along `S_u × S_v`; `None` where that vanishes, to rounding.
fn normal(surface: &Surface, (u, v): (f64, f64)) -> Result<Option<crate::Vector>> {
    let mut d = [crate::Vector::zeros(); 4];
    surface.derivatives_into(u, v, [1, 1], &mut d)?;
    let (a, b) = (d[2] * surface.u().length(), d[1] * surface.v().length());
    let least = NO_STEP * a.norm().max(b.norm());
    let (su, sv) = (a.try_normalize(least), b.try_normalize(least));
    Ok(su.zip(sv).and_then(|(a, b)| a.cross(&b).try_normalize(1e-6)))
}

impl Bonds for Brep {
    fn is_ready(&self) -> bool {
        matches!(self.motion, Motion::Ready(_))
    }

    fn ready(&self, places: &[(u32, [f64; 2])]) -> Result<Box<dyn Shape>> {
        let moving = match &self.motion {
            Motion::Wished(moving) => moving.clone(),
            _ => Moving::new(),
        };
        Ok(Box::new(self.loosened(&moving, places)?))
    }

    fn held(&self) -> &[usize] {
        self.loose().map_or(&[], |loose| &loose.held)
    }

    fn bonds(&self) -> &[Bond] {
        self.loose().map_or(&[], |loose| &loose.bonds)
    }
}
