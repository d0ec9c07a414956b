//! What was smooth stays smooth: rows that keep, at the knots where a corner can appear, the continuity that a shape has
//! there, and the corners that an edit makes all the same.
//!
//! At a knot of multiplicity `p` (every Bézier chain, an exact circle or revolution) nothing in the space of functions
//! keeps the pieces on both sides in one direction, at one of `p + 1`, or where a closed curve of an open space has its
//! seam, not even in one place. Where they *are* in one direction when an edit is prepared, `C'₊ = r C'₋`, this is asked
//! to stay, with the `r` that is measured then (G¹: a linear row, alike in all axes); with level 2 also
//! `C''₊ = r² C''₋ + s C'₋` (G²: the same curvature, where that is measured). On surfaces the same is asked of each column
//! of the net across a knot line; see [`Relation`].
//!
//! Where an edge of a surface is a point, that [pole](pole) stays one, and smooth if it is.
//!
//! Only knots that an edit touches are looked at. Keeping one moves vertices of its own, which touch others: all that
//! follow are kept too, so that the least adjustment is that under all of them. On a cubic Bézier chain the rows of two
//! knots have no vertex in common; on a quadratic one all hang together. Who moves everything (fairing) asks for all knots
//! around vertices that may move.

mod columns;
mod corner;
mod joint;
mod pole;
mod relation;
mod row;

use std::any::Any;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use smallvec::SmallVec;

use self::columns::{Columns, nets};
use self::corner::Watch;
use self::joint::{Joint, joint_at, joints_near};
use self::pole::Pole;
use self::relation::{Column, Relation, ends_meet, reach};
pub(crate) use self::row::Smooth;
pub use self::row::SmoothKnot;
use super::Freedom;
use super::constraint::Constraint;
use super::metric::Metric;
use crate::error::Result;
use crate::functional::{Equation, Functional, On, Shapes, Store};
use crate::problem::Corner;
use crate::shape::{Shape, Stencil};

/// A joint of a net: shape, which of its splines, direction, the span on its left.
type Line = (usize, usize, usize, usize);

/// What there is to keep, and to look at afterwards.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// One for each knot or knot line at which something is kept.
    pub(crate) kept: Vec<Smooth>,
    watches: BTreeMap<(Line, usize), Option<Watch>>,
}

/// The places that an edit touches where corners can appear, as they were.
#[derive(Debug, Default)]
pub(crate) struct Watched(BTreeMap<(Line, usize), Option<Watch>>);

impl Watched {
    /// Looks at these places too, unless they are known already.
    pub(crate) fn add(&mut self, found: &mut Found) {
        for (place, watch) in std::mem::take(&mut found.watches) {
            self.0.entry(place).or_insert(watch);
        }
    }

    /// The corners that have appeared there, or changed.
    pub(crate) fn corners(&self, shapes: &Shapes<'_>) -> Vec<Corner> {
        corner::corners(self.0.values().flatten(), shapes)
    }
}

/// Whether a constraint is one of ours.
pub(crate) fn is_ours(constraint: &Constraint) -> bool {
    ours(constraint).is_some()
}

/// What a constraint keeps smooth, if it is one of ours.
pub(crate) fn ours(constraint: &Constraint) -> Option<&Smooth> {
    let any: &dyn Any = constraint.functional.as_ref();
    any.downcast_ref()
}

/// What to do about a conflict with what is kept smooth.
pub(crate) const ADVICE: &str = ", or say smooth = 0 to let corners appear";

/// What to do about a conflict with what is kept together.
pub(crate) const BONDS: &str = ", or let other faces move (`faces`, more or fewer `neighbours`)";

/// Whether a net has places where a corner (with level 2, a jump of the curvature) can appear, and whether it closes a seam.
/// `O(p²)`: whoever has none pays no more.
fn has_joints(net: &Columns<'_>, level: u8) -> (bool, bool) {
    let closes = !net.across.is_periodic() && ends_meet(net, 0) && ends_meet(net, net.columns() - 1);
    (closes || net.across.most_repeated() >= least(net, level), closes)
}

/// The multiplicity from which a knot matters.
fn least(net: &Columns<'_>, level: u8) -> usize {
    let p = net.across.degree();
    if level < 2 { p } else { (p - 1).max(1) }
}

/// Whether any of these shapes has places where something is to be kept, perhaps.
pub(crate) fn has_places(shapes: &Shapes<'_>, level: u8) -> bool {
    let may_have = |net: &Columns<'_>| net.along.is_some() || has_joints(net, level).0;
    (0..shapes.len()).any(|shape| nets(shapes, shape).iter().any(may_have))
}

/// What is to be kept at level `level` (0: nothing; 1: G¹; 2: G² too) where these functionals are asked of shapes that
/// messages call by these `names`, and the places where it may be lost; `everywhere`: not where these functionals
/// are felt, but wherever vertices may move. The work is proportional to the vertices that move; `None` where no shape has
/// such places.
///
/// # Errors
/// When something cannot be asked of the shapes.
pub(crate) fn find<'f>(
    shapes: &Shapes<'_>,
    asked: impl Iterator<Item = &'f dyn Functional>,
    names: &dyn Fn(usize) -> On,
    freedom: &Freedom,
    metric: &Metric,
    level: u8,
    everywhere: bool,
) -> Result<Option<Found>> {
    let mut search = Search::new(shapes, level);
    if search.nets.iter().flatten().next().is_none() && search.poles.iter().flatten().next().is_none() {
        return Ok(None);
    }
    let names: Vec<On> = (0..shapes.len()).map(names).collect();
    let count = shapes.vertex_count();
    let may_move = |v: usize| v < count && freedom.may_move(v);
    let mut fresh: Vec<usize> = if everywhere {
        (0..count).filter(|&v| may_move(v)).collect()
    } else {
        let mut store = Store::default();
        for functional in asked {
            functional.rows(shapes, &mut store.rows(shapes))?;
        }
        let touched = store.equations().flat_map(|equation| match equation {
            Equation::Alike { vertices, .. } | Equation::Coupled { vertices, .. } => vertices,
        });
        touched.copied().filter(|&v| may_move(v)).collect()
    };
    // Vertices in rows, and those that move: more, where the metric takes others along (all, at the first one).
    let (mut touched, mut moving) = (BTreeSet::new(), BTreeSet::new());
    let takes_all = freedom.takes_all(metric);
    let mut queue = Vec::new();
    loop {
        fresh.retain(|&v| touched.insert(v));
        if !(fresh.is_empty() || takes_all && !moving.is_empty()) {
            fresh.sort_unstable();
            let wide = freedom.widen(metric, shapes, std::mem::take(&mut fresh), &may_move)?;
            queue.extend(wide.into_iter().filter(|&v| moving.insert(v)));
        }
        fresh.clear();
        let Some(vertex) = queue.pop() else { break };
        search.visit(vertex, &may_move, &names, &mut fresh);
    }
    Ok(Some(search.into_found(&names)))
}

/// The vertices of a curve that cannot move while only those `inside` an interval may and what is smooth at a parameter is
/// kept.
pub(crate) fn frozen(curve: &dyn Shape, u: f64, inside: &[usize], level: u8) -> Vec<usize> {
    let shapes = Shapes::one(curve);
    let mut frozen = Vec::new();
    for net in nets(&shapes, 0).iter().filter(|_| level > 0) {
        let (_, closes) = has_joints(net, level);
        let Some(joint) = joint_at(net.across, u, least(net, level), closes) else { continue };
        let column = Column::new(net, &joint, 0);
        for row in Relation::common(&joint, &[&column], level).rows(&joint, &column) {
            let free: Vec<usize> = row
                .vertices()
                .iter()
                .copied()
                .filter(|v| inside.contains(v) && !frozen.contains(v))
                .collect();
            if let [only] = free[..] {
                frozen.push(only);
            }
        }
    }
    frozen
}

/// The poles of a shape, where something is to be kept.
fn poles<'a>(shapes: &Shapes<'a>, shape: usize, level: u8) -> SmallVec<[(Columns<'a>, Pole, bool); 1]> {
    let all = nets(shapes, shape).into_iter().filter(|net| level > 0 && net.along.is_some());
    all.flat_map(|net| Pole::of(&net).into_iter().map(move |pole| (net, pole, false))).collect()
}

/// How a face is named behind something of it.
fn on_face(face: Option<u32>) -> String {
    face.map_or_else(String::new, |face| format!(" of face {face}"))
}

/// What is known of one joint.
struct Cut {
    joint: Joint,
    /// The vertices of a column that its position and first derivatives, and those that its second ones are made of.
    first: SmallVec<[usize; 16]>,
    second: SmallVec<[usize; 16]>,
}

/// What the search has come across.
struct Search<'a> {
    shapes: &'a Shapes<'a>,
    level: u8,
    /// Of each shape the nets that have joints, and whether they close a seam.
    nets: Vec<SmallVec<[(Columns<'a>, bool); 2]>>,
    /// Of each shape the poles, each in its net, and whether it has been come across.
    poles: Vec<SmallVec<[(Columns<'a>, Pole, bool); 1]>>,
    cuts: BTreeMap<Line, Cut>,
    columns: BTreeMap<(Line, usize), Column>,
    relations: BTreeMap<(Line, usize), Relation>,
    done: BTreeSet<(Line, usize)>,
    rows: BTreeMap<Line, Vec<Stencil>>,
    /// Of each line the least order that a column keeps.
    orders: BTreeMap<Line, Option<usize>>,
    watches: BTreeMap<(Line, usize), Option<Watch>>,
}

impl<'a> Search<'a> {
    fn new(shapes: &'a Shapes<'a>, level: u8) -> Self {
        let worth = |shape: usize| -> SmallVec<[(Columns<'a>, bool); 2]> {
            let all = nets(shapes, shape).into_iter().map(|net| (net, has_joints(&net, level)));
            all.filter(|(_, (any, _))| *any).map(|(net, (_, closes))| (net, closes)).collect()
        };
        Self {
            shapes,
            level,
            nets: (0..shapes.len()).map(worth).collect(),
            poles: (0..shapes.len()).map(|shape| poles(shapes, shape, level)).collect(),
            cuts: BTreeMap::new(),
            columns: BTreeMap::new(),
            relations: BTreeMap::new(),
            done: BTreeSet::new(),
            rows: BTreeMap::new(),
            orders: BTreeMap::new(),
            watches: BTreeMap::new(),
        }
    }

    /// Looks at the joints around a vertex that moves; what their rows move that may goes to `fresh`.
    fn visit(
        &mut self,
        vertex: usize,
        may_move: &dyn Fn(usize) -> bool,
        names: &[On],
        fresh: &mut Vec<usize>,
    ) {
        let shape = (0..self.shapes.len()).rev().find(|&s| self.shapes.offset(s) <= vertex).unwrap_or(0);
        let offset = self.shapes.offset(shape);
        for (net, pole, met) in &mut self.poles[shape] {
            if *met || !net.has(vertex - offset) || !pole.has(net, vertex - offset) {
                continue;
            }
            *met = true;
            // Where nothing may move, nothing can be lost.
            pole.rows.retain(|row| {
                let before = fresh.len();
                fresh.extend(row.vertices().iter().map(|v| offset + v).filter(|v| may_move(*v)));
                fresh.len() > before
            });
        }
        for (net, closes) in self.nets[shape].clone() {
            if !net.has(vertex - offset) {
                continue;
            }
            let (i, column) = net.place(vertex - offset);
            for joint in joints_near(net.across, i, least(&net, self.level), closes) {
                let line = net.line(joint.left.0);
                let cut = self.cuts.entry(line).or_insert_with(|| Cut {
                    joint,
                    first: reach(&net, &joint, 1),
                    second: reach(&net, &joint, 2),
                });
                let (first, second) = (cut.first.contains(&i), cut.second.contains(&i));
                if self.done.contains(&(line, column)) || !(first || second && self.level > 1) {
                    continue;
                }
                let relation = self.relation(&net, &joint, line, column);
                if !first && relation.bend.is_none() {
                    continue;
                }
                self.done.insert((line, column));
                if joint.sharp {
                    self.watch(&net, &joint, line, column, &names[shape]);
                }
                let own = self.poles[shape].iter().filter(|(beside, ..)| beside.patch == net.patch);
                let kept = own.into_iter().any(|(_, pole, _)| pole.keeps(net.direction, column));
                if self.level == 0 || kept {
                    continue;
                }
                let least = self.orders.entry(line).or_insert(relation.order());
                *least = (*least).min(relation.order());
                let rows = relation.rows(&joint, self.column(&net, &joint, line, column));
                for row in rows {
                    let vertices = row.iter().map(|(i, c)| (net.index(i, column), c));
                    let row: Stencil = vertices.collect();
                    let free = row.vertices().iter().map(|v| offset + v).filter(|v| may_move(*v));
                    let before = fresh.len();
                    fresh.extend(free);
                    // Where nothing may move, nothing can be lost.
                    if fresh.len() > before {
                        self.rows.entry(line).or_default().push(row);
                    }
                }
            }
        }
    }

    fn column(&mut self, net: &Columns<'a>, joint: &Joint, line: Line, column: usize) -> &Column {
        match self.columns.entry((line, column)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Column::new(net, joint, column)),
        }
    }

    /// What a column's sides have in common: in the first of its spans where all columns agree to more than that they meet.
    fn relation(&mut self, net: &Columns<'a>, joint: &Joint, line: Line, column: usize) -> Relation {
        if self.level == 0 {
            return Relation::default();
        }
        let mut best = Relation::default();
        for span in net.spans(column) {
            let relation = match self.relations.get(&(line, span)) {
                Some(known) => *known,
                None => {
                    let on = net.columns_on(span);
                    for &j in &on {
                        self.column(net, joint, line, j);
                    }
                    let columns: SmallVec<[&Column; 8]> =
                        on.iter().filter_map(|&j| self.columns.get(&(line, j))).collect();
                    let relation = Relation::common(joint, &columns, self.level);
                    self.relations.insert((line, span), relation);
                    relation
                }
            };
            let rank = |r: &Relation| (r.meets, r.ratio.is_some(), r.bend.is_some());
            if rank(&relation) > rank(&best) {
                best = relation;
            }
        }
        best
    }

    fn watch(&mut self, net: &Columns<'a>, joint: &Joint, line: Line, column: usize, on: &On) {
        for span in net.spans(column) {
            if let Entry::Vacant(new) = self.watches.entry((line, span)) {
                new.insert(Watch::along(self.shapes, net, joint, span, on));
            }
        }
    }

    fn into_found(self, names: &[On]) -> Found {
        let mut kept = Vec::with_capacity(self.rows.len());
        for (poles, on) in self.poles.into_iter().zip(names) {
            let met = poles.into_iter().filter(|(_, pole, met)| *met && !pole.rows.is_empty());
            kept.extend(met.map(|(net, pole, _)| Smooth {
                on: on.clone(),
                knot: None,
                place: format!("{}{}", pole.describe(), on_face(net.face)),
                rows: pole.rows,
                bond: false,
            }));
        }
        for (line, rows) in self.rows {
            let (Some(cut), Some(on)) = (self.cuts.get(&line), names.get(line.0)) else { continue };
            let own = self.nets[line.0].iter().find(|(net, _)| net.patch == line.1);
            let surface = own.is_some_and(|(net, _)| net.along.is_some());
            let face = on_face(own.and_then(|(net, _)| net.face));
            let what = if cut.joint.seam {
                "seam"
            } else if surface {
                "knot line"
            } else {
                "knot"
            };
            let tangent =
                self.relations.range((line, 0)..=(line, usize::MAX)).any(|(_, r)| r.ratio.is_some());
            let how = if tangent { "smooth" } else { "closed" };
            let at = cut.joint.right.1;
            let place = match (surface, line.2) {
                (false, _) => format!("{how} {what} at {at}"),
                (true, 0) => format!("{how} {what} u = {at}{face}"),
                (true, _) => format!("{how} {what} v = {at}{face}"),
            };
            let order = self.orders.get(&line).copied().flatten();
            let knot = Some(SmoothKnot { shape: line.0, direction: line.2, at, order });
            kept.push(Smooth { on: on.clone(), knot, place, rows, bond: false });
        }
        Found { kept, watches: self.watches }
    }
}
