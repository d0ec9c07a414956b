//! A Doo-Sabin surface as triangles.

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::plugin::{Faceted, Fineness};
use loftsman_kernel::{Point, Vector};

use super::DooSabinSurface;
use super::node::Node;
use crate::doo_sabin::refine::{intervals, refine};
use crate::surface::apart::{Apart, Over};
use crate::surface::facing::{Aim, Scheme};
use crate::surface::net::{Net, both, cut};
use crate::surface::pattern::Quadrant;
use crate::surface::places::Place;
use crate::surface::quads::Quads;
use crate::surface::refused;
use crate::surface::tessellate::diagonal;
use crate::topology::{NONE, Topology};
use crate::weld::root;

impl DooSabinSurface {
    /// The neighbourhood of each face.
    pub(super) fn nodes(&self) -> crate::error::Result<Vec<Node<Vector>>> {
        let fine = refine(&self.cage)?;
        let point = |v: u32| fine.points()[v as usize].coords;
        let node = |&half: &u32| Node {
            rings: self.rings(half).map(|ring| ring.into_iter().map(point).collect()),
            rules: self.layout.spans.rules(&self.cage, half),
        };
        Ok(self.layout.corners.iter().map(node).collect())
    }
}

impl Node<Vector> {
    /// The Bézier points of a regular piece, of degree 3 in each direction.
    pub(super) fn patch(&self) -> Net {
        let net = self.net();
        let line = |c: [Vector; 4]| {
            let [a, b, c] = [0.5 * (c[0] + c[1]), c[1], 0.5 * (c[1] + c[2])];
            [a, (a + b * 2.0) / 3.0, (b * 2.0 + c) / 3.0, c]
        };
        // Of a line of three the fourth counts for nothing.
        both(&std::array::from_fn(|k| *net[3 * (k / 4).min(2) + (k % 4).min(2)]), line, line)
    }
}

/// The states of a surface as the same triangles: each face in quads that are divided as often as they need in the worst of them, no more
/// than one level apart from their neighbours, and cut so that nothing gapes, as those of
/// [`SubdivisionSurface`](crate::SubdivisionSurface) are.
///
/// The error is a bound of the distance that any point of the surface has from the triangles: of a biquadratic piece by the second
/// differences of its Bézier points, of another by those of the quarters that it consists of, down to one whose neighbourhood, in the hull of
/// which it lies, is near enough to one triangle. What counts is how far the surface is, not where its parameters go, which are not smooth
/// round extraordinary points: triangles are no smaller there than its curvature asks for. For the sake of the angle quads are divided that
/// turn by more and are larger than the chord.
///
/// # Errors
/// [`Error::NoExtent`] where all is one point; when there is no state, the states are different surfaces, the fineness is not positive,
/// or more than two million vertices are needed.
pub(super) fn tessellate(states: &[&DooSabinSurface], fineness: &Fineness) -> Result<Faceted> {
    let Some(first) = states.first() else {
        return Err(Error::Invalid("there is no state of the surface to tessellate".into()));
    };
    let alike = |s: &&DooSabinSurface| {
        s.cage.topology() == first.cage.topology()
            && s.layout.corners == first.layout.corners
            && s.cage.end_intervals == first.cage.end_intervals
    };
    if !states.iter().all(alike) {
        return Err(Error::Invalid(
            "the states of the surface have different faces or intervals: they are not one surface".into(),
        ));
    }
    let nodes: Vec<Vec<Node<Vector>>> =
        states.iter().map(|s| s.nodes().map_err(refused)).collect::<Result<_>>()?;
    let sizes: Vec<f64> = states.iter().zip(&nodes).map(|(s, nodes)| size(s.cage.points(), nodes)).collect();
    let aim = Aim::new(fineness, &sizes)?;
    let (pieces, quads) = Pieces::new(first, nodes);
    aim.faceted(pieces, quads)
}

/// The diagonal of the box of the corners of a surface's faces, at least its size; where these are one point but for rounding, of those of their
/// quarters; 0 where these are, too.
pub(super) fn size(cage: &[Point], nodes: &[Node<Vector>]) -> f64 {
    let largest = crate::surface::net::largest(cage.iter().map(|p| p.coords.amax()));
    let least = f64::max(1e-12 * diagonal(cage), 8.0 * f64::EPSILON * largest);
    let corners = |node: &Node<Vector>| [0, 1, 2, 3].map(|k| Point::from(node.corner(k).0));
    let own = diagonal(&nodes.iter().flat_map(corners).collect::<Vec<_>>());
    if own > least || !own.is_finite() {
        return own;
    }
    let quarters = |node: &Node<Vector>| node.quarters().each_ref().map(corners).concat();
    let finer = diagonal(&nodes.iter().flat_map(quarters).collect::<Vec<_>>());
    if finer > least { finer } else { 0.0 }
}

/// A piece of the surface in each state, all biquadratic or none.
enum Piece {
    Patches(Vec<Net>),
    Nodes(Vec<Node<Vector>>),
}

impl Piece {
    fn new(states: Vec<Node<Vector>>) -> Self {
        if states.iter().all(Node::is_regular) {
            return Self::Patches(states.iter().map(Node::patch).collect());
        }
        Self::Nodes(states)
    }
}

/// What lies over a quadrant of a piece: all of it, where it is not biquadratic.
#[derive(Debug, Clone, Copy)]
struct Part {
    piece: u32,
    within: Quadrant,
}

/// All pieces that there are, on any level; what is within a biquadratic one is not one of its own.
struct Pieces(Vec<Piece>);

/// The corners of pieces: they lie at the faces, the edges and the vertices of the cage. Those between which a piece has no extent are one.
pub(super) struct Corners {
    /// Another of each one's group, or itself.
    group: Vec<usize>,
}

impl Corners {
    pub(super) fn new(surface: &DooSabinSurface) -> Self {
        let (cage, topology) = (&surface.cage, surface.cage.topology());
        let count = topology.face_count() + topology.edge_count() + topology.vertex_count();
        let mut corners = Self { group: (0..count).collect() };
        if cage.has_end_intervals() {
            let inner = |h: &u32| !topology.is_boundary_vertex(topology.origin(*h) as usize);
            for half in (0..topology.corner_count() as u32).filter(inner) {
                let [along_u, along_v] = intervals(cage, half).map(|d| d <= 0.0);
                let [a, b, c, d] = corners.of(topology, half);
                for (vanishes, pairs) in [(along_u, [(a, b), (d, c)]), (along_v, [(a, d), (b, c)])] {
                    if vanishes {
                        pairs.into_iter().for_each(|(one, other)| corners.join(one, other));
                    }
                }
            }
        }
        corners
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.group.len()
    }

    /// Those of the piece at a corner of the cage.
    pub(super) fn of(&mut self, topology: &Topology, half: u32) -> [usize; 4] {
        let (edges, vertices) = (topology.face_count(), topology.face_count() + topology.edge_count());
        [
            topology.face_of(half) as usize,
            edges + topology.edge_of(topology.previous(half)) as usize,
            vertices + topology.origin(half) as usize,
            edges + topology.edge_of(half) as usize,
        ]
        .map(|place| root(&mut self.group, place))
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (root(&mut self.group, one), root(&mut self.group, other));
        self.group[one.max(other)] = one.min(other);
    }
}

impl Pieces {
    /// The faces of a surface, by their neighbourhoods in each state.
    fn new(surface: &DooSabinSurface, states: Vec<Vec<Node<Vector>>>) -> (Self, Quads<Part>) {
        let (topology, count) = (surface.cage.topology(), states.len());
        let (mut pieces, mut quads) = (Self(Vec::new()), Quads::new(count));
        let mut corners_of = Corners::new(surface);
        let mut numbers = vec![NONE; corners_of.group.len()];
        let mut states: Vec<_> = states.into_iter().map(Vec::into_iter).collect();
        for (face, &half) in (0..).zip(&surface.layout.corners) {
            let nodes: Vec<Node<Vector>> = states.iter_mut().filter_map(Iterator::next).collect();
            if nodes.iter().any(|node| node.vanishes().contains(&true)) {
                continue;
            }
            let part = pieces.add(Piece::new(nodes));
            let places = corners_of.of(topology, half);
            let mut corners = [NONE; 4];
            for (corner, place) in places.into_iter().enumerate() {
                if numbers[place] == NONE {
                    numbers[place] = quads.name();
                    pieces.put(&mut quads, numbers[place], part, corner);
                }
                corners[corner] = numbers[place];
            }
            quads.add(part, corners.into(), Ok(Place::whole(face)));
        }
        (pieces, quads)
    }

    /// Adds a piece.
    fn add(&mut self, piece: Piece) -> Part {
        self.0.push(piece);
        Part { piece: self.0.len() as u32 - 1, within: Quadrant::WHOLE }
    }

    /// Puts down where a point is that is a corner of a part.
    fn put(&self, quads: &mut Quads<Part>, name: u32, part: Part, corner: usize) {
        for state in 0..quads.points.len() {
            let (point, normal) = self.corner(part, state, corner);
            quads.points[state][name as usize] = Point::from(point);
            if state == 0 {
                quads.normals[name as usize] = normal;
            }
        }
    }

    /// The point at a corner of a part, and the unit normal where there is one.
    fn corner(&self, part: Part, state: usize, corner: usize) -> (Vector, Option<Vector>) {
        match &self.0[part.piece as usize] {
            Piece::Nodes(states) => {
                let (point, tangents) = states[state].corner(corner);
                (point, normal(tangents))
            }
            Piece::Patches(states) => corner_of(&over(&states[state], part.within), corner),
        }
    }

    /// The four parts of a part, the corner of each being that of the whole with the same number.
    fn quarters(&mut self, part: Part) -> [Part; 4] {
        let quarters: Vec<[Node<Vector>; 4]> = match &self.0[part.piece as usize] {
            Piece::Patches(_) => return part.within.parts().map(|within| Part { within, ..part }),
            Piece::Nodes(states) => states.iter().map(Node::quarters).collect(),
        };
        [0, 1, 2, 3].map(|k| self.add(Piece::new(quarters.iter().map(|of| of[k].clone()).collect())))
    }
}

/// The Bézier points over a quadrant of a patch.
fn over(patch: &Net, Quadrant { level, i, j }: Quadrant) -> Net {
    let size = 0.5_f64.powi(level as i32);
    let side = |k: u64| [k as f64 * size, (k + 1) as f64 * size];
    if level == 0 { *patch } else { cut(patch, side(i), side(j)) }
}

/// The point at a corner of a patch, and the unit normal where there is one.
fn corner_of(patch: &Net, corner: usize) -> (Vector, Option<Vector>) {
    let at = |i: usize, j: usize| patch[4 * i + j];
    let (i, j) = [(0, 0), (3, 0), (3, 3), (0, 3)][corner % 4];
    let (u, v) = ([at(0, j), at(1, j), at(2, j), at(3, j)], [at(i, 0), at(i, 1), at(i, 2), at(i, 3)]);
    let slope = |line: [Vector; 4], end: usize| if end == 0 { line[1] - line[0] } else { line[3] - line[2] };
    (at(i, j), normal([slope(u, i), slope(v, j)]))
}

/// The unit normal to two tangents, where they have a length and are not parallel.
fn normal([u, v]: [Vector; 2]) -> Option<Vector> {
    u.try_normalize(0.0)?.cross(&v.try_normalize(0.0)?).try_normalize(1e-12)
}

impl Scheme for Pieces {
    type Own = Part;
    /// Halves of a piece have half its hull, so that a proof always comes.
    const FOR_PROOF: u32 = u32::MAX;

    fn refine(&mut self, quads: &mut Quads<Part>, nodes: &[usize]) -> Result<()> {
        for &node in nodes {
            let (part, corners, place) =
                (quads.all[node].own, quads.all[node].corners.clone(), quads.all[node].place);
            let Ok(place) = place else { continue };
            let parts = self.quarters(part);
            let known = quads.normals.len() as u32;
            let middles = [0, 1, 2, 3].map(|k| quads.name_middle(corners[k], corners[(k + 1) % 4]));
            for (k, &middle) in middles.iter().enumerate().filter(|(_, name)| **name >= known) {
                self.put(quads, middle, parts[k], (k + 1) % 4);
            }
            let centre = quads.name();
            self.put(quads, centre, parts[0], 2);
            let children = parts.into_iter().enumerate().map(|(k, part)| {
                let mut own = [corners[k], middles[k], centre, middles[(k + 3) % 4]];
                own.rotate_right(k);
                (part, own.into(), place.part(k))
            });
            quads.add_children(node, centre, children);
        }
        Ok(())
    }

    fn apart(&self, part: Part, state: usize, apart: &mut Apart<'_>) -> Result<f64> {
        let node = match &self.0[part.piece as usize] {
            Piece::Patches(states) => {
                return Ok(apart.of_patch(&over(&states[state], part.within), Quadrant::WHOLE));
            }
            Piece::Nodes(states) => &states[state],
        };
        apart.of_parts(
            node,
            |_, part| part.quarters(),
            |_, part| {
                let hull = || part.rings.iter().flatten().map(|p| Point::from(*p)).collect();
                Ok(if part.is_regular() { Over::Patch(Box::new(part.patch())) } else { Over::Hull(hull()) })
            },
        )
    }

    fn normals(&self, part: Part, state: usize) -> [Option<Vector>; 4] {
        [0, 1, 2, 3].map(|k| self.corner(part, state, k).1)
    }
}
