//! The plane of a face as triangles, and which of them are the face.

use std::collections::BTreeMap;

use loftsman_kernel::{Error, Result, Vector};
use spade::handles::{FixedDirectedEdgeHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, PositionInTriangulation, Triangulation};

use super::arrange::{Arranged, Border, Clash};
use super::carrier::Carrier;
use super::cut::Goal;

/// By how much more a step along one direction may be than along the other, in space.
const SLENDER: f64 = 30.0;

/// See [`Plane::slant`].
const SLANT: f64 = 1.0 / 1024.0;

/// A vertex: its place, scaled so that a step that the tolerance allows is about 1.
#[derive(Debug, Clone, Copy)]
struct Corner(Point2<f64>);

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.0
    }
}

type Triangles = ConstrainedDelaunayTriangulation<Corner>;

/// What is known of a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vertex {
    pub(crate) at: [f64; 2],
    /// Its point in the frame.
    pub(crate) place: Vector,
    /// How far that is from the surface at its parameters.
    pub(crate) off: f64,
    /// The number of its point; none yet inside the face.
    pub(crate) point: Option<u32>,
    /// The unit normal, where it does not depend on the side from which one looks.
    pub(crate) normal: Option<Vector>,
}

/// The triangulation of a face.
pub(crate) struct Plane<'c> {
    pub(crate) carrier: &'c Carrier,
    triangles: Triangles,
    pub(crate) vertices: Vec<Vertex>,
    origin: [f64; 2],
    scale: [f64; 2],
    /// How much of one direction is added to the other: rectangles and circles become figures of which no four corners lie on a circle, so that
    /// predicates are decided without exact arithmetic. None of it where the plane's ends have to stay straight to the last bit.
    slant: [f64; 2],
    borders: BTreeMap<[u32; 2], Border>,
    seams: Vec<[[u32; 2]; 2]>,
    poles: Vec<[u32; 2]>,
    /// Whether what is inside is left of borders, or what is separated from the outside by an odd number of them; found once.
    rule: Option<Rule>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    Left,
    Odd,
}

/// Why a face has no triangles.
pub(crate) enum Trouble {
    Clash(Clash),
    Other(Error),
}

impl Trouble {
    /// As an error.
    pub(crate) fn error(self) -> Error {
        match self {
            Self::Other(error) => error,
            Self::Clash(_) => Error::Invalid("its loops cross or touch".into()),
        }
    }
}

impl From<Error> for Trouble {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

impl<'c> Plane<'c> {
    /// The nodes of a face joined into triangles that follow its borders and stretches. `place` gives the points of the whole, in the
    /// frame.
    pub(crate) fn new(
        carrier: &'c Carrier,
        arranged: &Arranged,
        first_own: u32,
        place: impl Fn(u32) -> Vector,
        goal: &Goal,
    ) -> Result<Self, Trouble> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for node in &arranged.nodes {
            for d in 0..2 {
                (low[d], high[d]) = (low[d].min(node.at[d]), high[d].max(node.at[d]));
            }
        }
        if arranged.nodes.len() < 3 || (0..2).any(|d| low[d].total_cmp(&high[d]).is_ge()) {
            return Err(Error::NoExtent("its loops bound no area".into()).into());
        }
        let scale = steps(carrier, low, high, goal).map(|step| 1.0 / step);
        if (0..2).any(|d| !(scale[d] * (high[d] - low[d])).is_finite()) {
            return Err(Error::Invalid("its parameters are no numbers that can be told apart".into()).into());
        }
        // Of what closes or ends in a pole the ends are the hull of all nodes.
        let bare = |d: usize| !carrier.sides[d].closed && carrier.poles[d].iter().all(Option::is_none);
        let slant = match [bare(0), bare(1)] {
            [_, true] => [0.0, SLANT],
            [true, false] => [SLANT, 0.0],
            _ => [0.0; 2],
        };
        let mut plane = Self {
            carrier,
            slant,
            triangles: Triangles::new(),
            vertices: Vec::with_capacity(arranged.nodes.len()),
            origin: [0, 1].map(|d: usize| 0.5 * (low[d] + high[d])),
            scale,
            borders: arranged
                .borders
                .iter()
                .map(|b| ([b.ends[0].min(b.ends[1]), b.ends[0].max(b.ends[1])], *b))
                .collect(),
            seams: arranged.seams.clone(),
            poles: arranged.poles.clone(),
            rule: None,
        };
        let mut corners = Vec::with_capacity(arranged.nodes.len());
        for node in &arranged.nodes {
            let on = carrier.point(node.at);
            let (spot, off) = if node.point < first_own {
                let spot = place(node.point);
                (spot, (spot - on).norm())
            } else {
                let own = arranged.own.get((node.point - first_own) as usize).copied();
                let spot = carrier.point(own.unwrap_or(node.at));
                (spot, (spot - on).norm())
            };
            let mut vertex = plane.vertex(node.at, spot);
            (vertex.off, vertex.point) = (off, Some(node.point));
            plane.vertices.push(vertex);
            corners.push(Corner(plane.position(node.at)));
        }
        let count = corners.len();
        let mut constraints: Vec<[usize; 2]> = Vec::new();
        let pairs = plane.borders.keys().chain(&arranged.stretches);
        constraints.extend(pairs.map(|pair| pair.map(|k| k as usize)));
        let mut refused = Vec::new();
        let loaded = Triangles::try_bulk_load_cdt(corners, constraints.clone(), |edge| refused.push(edge));
        let invalid = |_| Error::Invalid("its parameters are no numbers that can be told apart".into());
        plane.triangles = loaded.map_err(invalid)?;
        if plane.triangles.num_vertices() != count {
            return Err(plane.nearly_one(arranged));
        }
        let mut clash: Clash = Vec::new();
        for &[a, b] in &constraints {
            let [from, to] = [a, b].map(FixedVertexHandle::from_index);
            if plane.triangles.exists_constraint(from, to) {
                continue;
            }
            let own = plane.borders.get(&[a as u32, b as u32]);
            let crossed =
                plane.triangles.get_conflicting_edges_between_vertices(from, to).filter_map(|edge| {
                    let [c, d] = edge.vertices().map(|v| v.fix().index() as u32);
                    plane.borders.get(&[c.min(d), c.max(d)])
                });
            let before = clash.len();
            clash.extend(own.into_iter().chain(crossed).map(|border| (border.edge, border.part)));
            // A vertex on a border lies on no constraint that it crosses: the border itself has to become shorter.
            if clash.len() == before && own.is_some() {
                clash.extend(own.map(|border| (border.edge, border.part)));
            }
        }
        if clash.is_empty() { Ok(plane) } else { Err(Trouble::Clash(clash)) }
    }

    /// The borders at nodes that rounding makes one.
    fn nearly_one(&self, arranged: &Arranged) -> Trouble {
        let mut seen: BTreeMap<[u64; 2], u32> = BTreeMap::new();
        let mut doubled = Vec::new();
        for (k, node) in arranged.nodes.iter().enumerate() {
            let p = self.position(node.at);
            if let Some(other) = seen.insert([p.x.to_bits(), p.y.to_bits()], k as u32) {
                doubled.extend([other, k as u32]);
            }
        }
        let touching = arranged.borders.iter().filter(|b| b.ends.iter().any(|end| doubled.contains(end)));
        Trouble::Clash(touching.map(|b| (b.edge, b.part)).collect())
    }

    fn position(&self, at: [f64; 2]) -> Point2<f64> {
        let [x, y] = [0, 1].map(|d: usize| (at[d] - self.origin[d]) * self.scale[d]);
        let x = [x + self.slant[0] * y, y + self.slant[1] * x];
        // Numbers as small as that are rounding, and not taken.
        let [x, y] = x.map(|x| if x.abs() < 1e-30 { 0.0 } else { x });
        Point2::new(x, y)
    }

    fn vertex(&self, at: [f64; 2], place: Vector) -> Vertex {
        let plain = self.carrier.pole_at(at).is_none() && !self.carrier.on_line(at);
        let normal = plain.then(|| self.carrier.normal(at, at)).filter(|n| *n != Vector::zeros());
        Vertex { at, place, off: 0.0, point: None, normal }
    }

    /// The normal at a vertex, as seen from somewhere.
    pub(crate) fn normal(&self, vertex: u32, toward: [f64; 2]) -> Vector {
        let Vertex { at, normal, .. } = self.vertices[vertex as usize];
        normal.unwrap_or_else(|| {
            let mut at = at;
            if let Some((d, _)) = self.carrier.pole_at(at) {
                at[1 - d] = toward[1 - d];
            }
            self.carrier.normal(at, toward)
        })
    }

    /// Adds a place inside the face; nothing where there is a vertex or a constraint.
    pub(crate) fn add(&mut self, at: [f64; 2]) -> bool {
        let position = self.position(at);
        if position.x.is_nan() || position.y.is_nan() {
            return false;
        }
        let hint = self.vertices.len().checked_sub(1).map(FixedVertexHandle::from_index);
        let found = match hint {
            Some(hint) => self.triangles.locate_with_hint(position, hint),
            None => self.triangles.locate(position),
        };
        match found {
            PositionInTriangulation::OnFace(face) => {
                let beside = self.triangles.face(face).adjacent_edges().iter().any(|edge| {
                    let ends = edge.vertices().map(|v| self.vertices[v.fix().index()].at);
                    edge.is_constraint_edge()
                        && self.away(at, ends, self.scale.map(|s| 1.0 / s)) < BESIDE_LINE
                });
                if beside {
                    return false;
                }
            }
            PositionInTriangulation::OnEdge(edge) if !self.is_fixed(edge) => {}
            _ => return false,
        }
        let inserted = match hint {
            Some(hint) => self.triangles.insert_with_hint(Corner(position), hint),
            None => self.triangles.insert(Corner(position)),
        };
        if inserted.is_err() || self.triangles.num_vertices() == self.vertices.len() {
            return false;
        }
        let place = self.carrier.point(at);
        let vertex = self.vertex(at, place);
        self.vertices.push(vertex);
        true
    }

    fn is_fixed(&self, edge: FixedDirectedEdgeHandle) -> bool {
        self.triangles.is_constraint_edge(edge.as_undirected())
    }

    /// Of places those that lie inside the face, not nearer to a constraint of their triangle than a part of the step there.
    pub(crate) fn inside(&self, inside: &[bool], places: &[([f64; 2], [f64; 2])]) -> Vec<[f64; 2]> {
        let mut kept = Vec::new();
        let mut hint = FixedVertexHandle::from_index(0);
        for (at, step) in places {
            let position = self.position(*at);
            if position.x.is_nan() || position.y.is_nan() {
                continue;
            }
            let face = match self.triangles.locate_with_hint(position, hint) {
                PositionInTriangulation::OnFace(face) => face,
                PositionInTriangulation::OnEdge(edge) if !self.is_fixed(edge) => {
                    match self.triangles.directed_edge(edge).face().as_inner() {
                        Some(face) => face.fix(),
                        None => continue,
                    }
                }
                _ => continue,
            };
            let face = self.triangles.face(face);
            hint = face.vertices()[0].fix();
            if !inside[face.fix().index()] {
                continue;
            }
            let near = face.adjacent_edges().iter().any(|edge| {
                edge.is_constraint_edge() && {
                    let ends = edge.vertices().map(|v| self.vertices[v.fix().index()].at);
                    self.away(*at, ends, *step) < NEAR
                }
            });
            let crowded = face.vertices().iter().any(|v| {
                let other = self.vertices[v.fix().index()].at;
                (0..2).all(|d| (other[d] - at[d]).abs() < NEAR * step[d])
            });
            if !near && !crowded {
                kept.push(*at);
            }
        }
        kept
    }

    /// The distance from a segment, in steps.
    fn away(&self, at: [f64; 2], [a, b]: [[f64; 2]; 2], step: [f64; 2]) -> f64 {
        let scaled = |x: [f64; 2], y: [f64; 2]| {
            nalgebra::Vector2::new((y[0] - x[0]) / step[0], (y[1] - x[1]) / step[1])
        };
        let (along, to) = (scaled(a, b), scaled(a, at));
        let squared = along.norm_squared();
        let share = if squared > 0.0 { (to.dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
        (to - along * share).norm()
    }

    /// Which triangles are the face, by their numbers.
    ///
    /// # Errors
    /// When its borders do not say.
    pub(crate) fn labels(&mut self) -> Result<Vec<bool>> {
        let count = self.triangles.num_all_faces();
        let mut groups = crate::weld::Welds::new(count);
        let outer = self.triangles.outer_face().fix().index();
        for edge in self.triangles.undirected_edges() {
            let [a, b] = edge.vertices().map(|v| v.fix().index() as u32);
            let [one, other] =
                [edge.as_directed().face(), edge.as_directed().rev().face()].map(|f| f.fix().index());
            let fixed = edge.is_constraint_edge() && self.borders.contains_key(&[a.min(b), a.max(b)]);
            if !fixed && one != outer && other != outer {
                groups.join(one, other);
            }
        }
        let beside = |pair: [u32; 2]| -> Option<usize> {
            let edge = self.triangles.get_edge_from_neighbors(
                FixedVertexHandle::from_index(pair[0] as usize),
                FixedVertexHandle::from_index(pair[1] as usize),
            )?;
            let faces = [edge.face(), edge.rev().face()].map(|f| f.fix().index());
            faces.into_iter().find(|face| *face != outer)
        };
        let mut closed: std::collections::BTreeSet<[u32; 2]> = self.poles.iter().copied().collect();
        for pairs in &self.seams {
            closed.extend(pairs.iter().map(|[a, b]| [*a.min(b), *a.max(b)]));
            if let [Some(one), Some(other)] = pairs.map(beside) {
                groups.join(one, other);
            }
        }
        // Where the plane ends and nothing says that the surface goes on.
        let mut open = vec![false; count];
        for edge in self.triangles.convex_hull() {
            let [a, b] = edge.vertices().map(|v| v.fix().index() as u32);
            let pair = [a.min(b), a.max(b)];
            if !self.borders.contains_key(&pair) && !closed.contains(&pair) {
                let faces = [edge.face(), edge.rev().face()].map(|f| f.fix().index());
                faces
                    .into_iter()
                    .filter(|face| *face != outer)
                    .for_each(|face| open[groups.root(face)] = true);
            }
        }
        // What is left and what is right of each border, by group; 0 is outside of all.
        let mut sides = Vec::with_capacity(self.borders.len());
        for border in self.borders.values() {
            let [a, b] = border.ends.map(|k| FixedVertexHandle::from_index(k as usize));
            let Some(edge) = self.triangles.get_edge_from_neighbors(a, b) else { continue };
            let of = |face: usize| (face != outer).then_some(face);
            let (left, right) = (of(edge.face().fix().index()), of(edge.rev().face().fix().index()));
            let [left, right] = [left, right].map(|face| face.map(|face| groups.root(face)));
            if left != right {
                sides.push((left, right));
            }
        }
        let mut inside = vec![None; count];
        if self.rule != Some(Rule::Odd) && left_of(&sides, &open, &mut inside) {
            self.rule = Some(Rule::Left);
        } else {
            inside.fill(None);
            self.rule = Some(Rule::Odd);
            if !odd(&sides, &open, &mut inside) {
                return Err(Error::Invalid(
                    "its loops do not separate what is inside from what is outside: they must close and run counterclockwise around it".into(),
                ));
            }
        }
        let of = |face: usize| face != outer && inside[groups.root(face)] == Some(true);
        Ok((0..count).map(of).collect())
    }

    /// The triangles of the face, counterclockwise in the plane, and which of their edges are fixed: that from each corner to the next.
    pub(crate) fn triangles(&self, inside: &[bool]) -> Vec<([u32; 3], [bool; 3])> {
        let faces = self.triangles.inner_faces().filter(|face| inside[face.fix().index()]);
        let of = |face: spade::handles::FaceHandle<
            '_,
            spade::handles::InnerTag,
            Corner,
            (),
            spade::CdtEdge<()>,
            (),
        >| {
            let edges = face.adjacent_edges();
            (edges.map(|edge| edge.from().fix().index() as u32), edges.map(|edge| edge.is_constraint_edge()))
        };
        faces.map(of).collect()
    }
}

/// How near to a constraint a place may be, in steps.
const NEAR: f64 = 0.4;
/// What is nearer to a constraint than this, in steps, is on it but for rounding.
const BESIDE_LINE: f64 = 1e-9;

/// Whether what is left of borders is inside, and nothing says otherwise.
fn left_of(sides: &[(Option<usize>, Option<usize>)], open: &[bool], inside: &mut [Option<bool>]) -> bool {
    let mut said = sides.iter().flat_map(|(left, right)| [(*left, true), (*right, false)]);
    said.all(|(group, value)| match group {
        // Beyond the plane nothing is inside.
        None => !value,
        Some(group) => {
            let agrees = inside[group].replace(value).is_none_or(|known| known == value);
            agrees && !(value && open[group])
        }
    })
}

/// Whether borders separate inside and outside, where the plane ends being outside.
fn odd(sides: &[(Option<usize>, Option<usize>)], open: &[bool], inside: &mut [Option<bool>]) -> bool {
    let mut next: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut start: Vec<(usize, bool)> = (0..open.len()).filter(|&k| open[k]).map(|k| (k, false)).collect();
    for &(left, right) in sides {
        match (left, right) {
            (Some(a), Some(b)) => {
                next.entry(a).or_default().push(b);
                next.entry(b).or_default().push(a);
            }
            (Some(a), None) | (None, Some(a)) => start.push((a, true)),
            (None, None) => {}
        }
    }
    if start.is_empty() {
        return false;
    }
    while let Some((group, value)) = start.pop() {
        match inside[group].replace(value) {
            Some(known) if known != value => return false,
            Some(_) => {}
            None => start.extend(next.get(&group).into_iter().flatten().map(|&other| (other, !value))),
        }
    }
    true
}

/// The steps along `u` and `v` that the tolerance allows, about, in a box of parameters.
fn steps(carrier: &Carrier, low: [f64; 2], high: [f64; 2], goal: &Goal) -> [f64; 2] {
    let extent = [0, 1].map(|d: usize| high[d] - low[d]);
    let speeds = carrier.bounds.speeds_of_some(low, high);
    let fallback = speeds.iter().zip(extent).map(|(s, e)| s * e).fold(0.0, f64::max);
    let speeds =
        [0, 1].map(|d: usize| if speeds[d] > 0.0 { speeds[d] } else { fallback.max(1e-300) / extent[d] });
    let mean = carrier.bounds.mean(low, high);
    let of = |bend: f64| (8.0 * goal.chord / bend).sqrt();
    // Lengths in space.
    let mut lengths = [of(mean[0]) * speeds[0], of(mean[2]) * speeds[1]];
    let longest = fallback.max(1e-300);
    lengths = lengths.map(|length| if length.is_nan() { longest } else { length.min(longest) });
    let least = lengths[0].min(lengths[1]);
    [0, 1].map(|d: usize| lengths[d].min(SLENDER * least).max(1e-12 * longest) / speeds[d])
}
