//! Triangles that fill what rings of points bound.

use loftsman_kernel::Point;
use spade::handles::FixedVertexHandle;
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, HasPosition, Point2, RefinementParameters, Triangulation,
};

use crate::error::{RegionError, Result};
use crate::plane::Plane;

/// The most points that a refinement adds.
const MOST: usize = 5_000_000;

/// How fine the triangles are.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Refinement {
    /// No triangle with more area than an equilateral one with sides of this length; `None` for as large as they come.
    pub size: Option<f64>,
    /// The smallest angle to aim for, in degrees, 0 (none) to 30. Corners of the rings that are sharper stay.
    pub angle: f64,
    /// Whether the rings' own edges stay whole, so that neighbours fit. Next to long ones triangles may then stay
    /// larger and sharper than asked for.
    pub whole_edges: bool,
}

/// A filled region.
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    /// The points added inside, numbered after those that were given.
    pub added: Vec<Point>,
    /// Triangles, counterclockwise about the plane's normal.
    pub triangles: Vec<[u32; 3]>,
    /// For each ring, whether the region lies to its left.
    pub left: Vec<bool>,
    /// The plane.
    pub plane: Plane,
    /// Whether no triangle is larger than asked for and the refinement came to its end.
    pub refined: bool,
}

/// A corner of the triangulation.
#[derive(Debug, Clone, Copy)]
struct Corner([f64; 2]);

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.0[0], self.0[1])
    }
}

impl From<Point2<f64>> for Corner {
    fn from(p: Point2<f64>) -> Self {
        Self([p.x, p.y])
    }
}

type Triangles = ConstrainedDelaunayTriangulation<Corner>;

/// Fills what closed rings bound, by the even-odd rule: each ring, crossed, changes between inside and outside.
///
/// `rings` give a name (for errors) and the indices of a ring's points among `points`; a ring closes by itself. The
/// triangles are constrained Delaunay (crate spade, exact predicates). About `O(n log n)`.
///
/// # Errors
/// When the rings are not planar, bound no area, or cross or touch themselves or one another.
pub fn fill(points: &[Point], rings: &[(&str, &[u32])], refinement: &Refinement) -> Result<Filled> {
    if let Some(size) = refinement.size.filter(|s| !(s.is_finite() && *s > 0.0)) {
        return Err(RegionError::Number { what: "the size", value: size, wanted: "it must be positive" });
    }
    if !(0.0..=30.0).contains(&refinement.angle) {
        let value = refinement.angle;
        return Err(RegionError::Number { what: "the smallest angle", value, wanted: "0 to 30 degrees" });
    }
    let plane = Plane::of(points, rings)?;
    let net = Rings::new(points, rings, &plane);
    net.check_repeated()?;
    let mut triangles = net.triangulate()?;
    let inside = even_odd(&triangles);
    let left = net.first_edges().map(|(a, b)| {
        let edge = triangles.get_edge_from_neighbors(handle(a), handle(b));
        edge.and_then(|e| e.face().as_inner()).is_some_and(|face| inside[face.fix().index()])
    });
    let left = left.collect();
    let refined = match (refinement.size, refinement.angle > 0.0) {
        (None, false) => true,
        _ => refine(&mut triangles, &inside, refinement, &plane)?,
    };
    let inside = even_odd(&triangles);
    // New corners are numbered by their own first use inside: those that only cut the outside are not wanted.
    let old = net.corners.len();
    let mut number = vec![u32::MAX; triangles.num_vertices()];
    let mut added = Vec::new();
    let mut out = Vec::new();
    for face in triangles.inner_faces().filter(|f| inside[f.fix().index()]) {
        out.push(face.vertices().map(|v| {
            let k = v.fix().index();
            if k < old {
                return net.corners[k].0;
            }
            if number[k] == u32::MAX {
                number[k] = (points.len() + added.len()) as u32;
                added.push(plane.lift(v.data().0));
            }
            number[k]
        }));
    }
    Ok(Filled { added, triangles: out, left, plane, refined })
}

fn handle(index: usize) -> FixedVertexHandle {
    FixedVertexHandle::from_index(index)
}

/// The rings' corners in the plane.
struct Rings<'a> {
    points: &'a [Point],
    rings: &'a [(&'a str, &'a [u32])],
    /// The point, the ring and the place in the plane of each corner, ring after ring.
    corners: Vec<(u32, u32, [f64; 2])>,
}

impl<'a> Rings<'a> {
    fn new(points: &'a [Point], rings: &'a [(&'a str, &'a [u32])], plane: &Plane) -> Self {
        // The triangulation takes no numbers that underflow when squared; in units of the size these are 0.
        let underflow = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
        let corner = |r: usize, i: u32| (i, r as u32, plane.flatten(&points[i as usize]).map(underflow));
        let of_ring = |(r, ring): (usize, &(&str, &'a [u32]))| {
            ring.1.iter().map(move |&i| corner(r, i)).collect::<Vec<_>>()
        };
        let corners = rings.iter().enumerate().flat_map(of_ring).collect();
        Self { points, rings, corners }
    }

    /// Where each ring starts among the corners, and how many it has.
    fn spans(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.rings.iter().scan(0, |start, (_, ring)| {
            let here = *start;
            *start += ring.len();
            Some((here, ring.len()))
        })
    }

    fn first_edges(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.spans().map(|(start, length)| (start, start + usize::from(length > 1)))
    }

    /// Refuses two corners at one place.
    fn check_repeated(&self) -> Result<()> {
        let mut order: Vec<usize> = (0..self.corners.len()).collect();
        let place = |k: &usize| self.corners[*k].2;
        order.sort_by(|a, b| {
            place(a).partial_cmp(&place(b)).unwrap_or(std::cmp::Ordering::Equal).then(a.cmp(b))
        });
        match order.windows(2).find(|w| place(&w[0]) == place(&w[1])) {
            Some(pair) => {
                let at = self.points[self.corners[pair[0]].0 as usize];
                Err(self.meeting(pair[0], pair[1], at))
            }
            None => Ok(()),
        }
    }

    /// The rings of two corners meet at a point.
    fn meeting(&self, a: usize, b: usize, at: Point) -> RegionError {
        let name = |corner: usize| self.rings[self.corners[corner].1 as usize].0.to_owned();
        let (x, y, z) = (at.x, at.y, at.z);
        if self.corners[a].1 == self.corners[b].1 {
            return RegionError::SelfCrossing { object: name(a), x, y, z };
        }
        RegionError::Crossing { first: name(a), second: name(b), x, y, z }
    }

    /// The point of the edge from `a` to `b` on the line through `c` and `d`, which it crosses.
    fn crossing(&self, [a, b]: [usize; 2], [c, d]: [usize; 2]) -> Point {
        let [p, q, r, s] = [a, b, c, d].map(|k| self.corners[k].2);
        let arm = |from: [f64; 2], to: [f64; 2]| [to[0] - from[0], to[1] - from[1]];
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let t = cross(arm(p, r), arm(r, s)) / cross(arm(p, q), arm(r, s));
        let [from, to] = [a, b].map(|k| self.points[self.corners[k].0 as usize]);
        // Nearly parallel edges have no point of their own.
        from + (to - from) * if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn triangulate(&self) -> Result<Triangles> {
        let corners = self.corners.iter().map(|c| Corner(c.2)).collect();
        let mut triangles = Triangles::bulk_load_cdt(corners, Vec::new())
            .map_err(|e| RegionError::Sections(format!("the region cannot be triangulated: {e:?}")))?;
        for (start, length) in self.spans() {
            for k in 0..length {
                let (a, b) = (start + k, start + (k + 1) % length);
                let edges = triangles.try_add_constraint(handle(a), handle(b));
                if edges.is_empty() && !triangles.exists_constraint(handle(a), handle(b)) {
                    let conflict = triangles
                        .get_conflicting_edges_between_vertices(handle(a), handle(b))
                        .next()
                        .map_or([b, a], |edge| edge.vertices().map(|v| v.fix().index()));
                    return Err(self.meeting(a, conflict[0], self.crossing([a, b], conflict)));
                }
                // An edge in pieces runs over another corner.
                if edges.len() > 1 {
                    let over = triangles.directed_edge(edges[0]).to().fix().index();
                    let over = if over == a || over == b {
                        triangles.directed_edge(edges[0]).from().fix().index()
                    } else {
                        over
                    };
                    return Err(self.meeting(over, a, self.points[self.corners[over].0 as usize]));
                }
            }
        }
        Ok(triangles)
    }
}

/// Refines the inside; says whether all triangles came out as asked for.
fn refine(
    triangles: &mut Triangles,
    inside: &[bool],
    refinement: &Refinement,
    plane: &Plane,
) -> Result<bool> {
    let mut parameters = RefinementParameters::<f64>::new()
        .exclude_outer_faces(true)
        .with_angle_limit(AngleLimit::from_deg(refinement.angle))
        .with_max_additional_vertices(MOST);
    if refinement.whole_edges {
        parameters = parameters.keep_constraint_edges();
    }
    let mut most = f64::INFINITY;
    if let Some(size) = refinement.size {
        let side = size / plane.size();
        most = 3_f64.sqrt() / 4.0 * side * side;
        let area: f64 = triangles.inner_faces().filter(|f| inside[f.fix().index()]).map(|f| f.area()).sum();
        let count = area / most;
        if count.is_nan() || count > MOST as f64 {
            return Err(RegionError::TooFine { size, count, most: MOST as f64 });
        }
        parameters = parameters.with_max_allowed_area(most);
    }
    let complete = triangles.refine(parameters).refinement_complete;
    let inside = even_odd(triangles);
    let mut areas = triangles.inner_faces().filter(|f| inside[f.fix().index()]).map(|f| f.area());
    Ok(complete && areas.all(|area| area <= most * (1.0 + 1e-9)))
}

/// For each face, whether an odd number of rings is crossed on the way to it from outside.
fn even_odd(triangles: &Triangles) -> Vec<bool> {
    let mut inside = vec![None; triangles.num_all_faces()];
    let outer = triangles.outer_face().fix();
    inside[outer.index()] = Some(false);
    // From the hull inward, face by face.
    let mut front: Vec<_> = triangles
        .convex_hull()
        .filter_map(|edge| {
            let face = edge.rev().face().as_inner()?.fix();
            Some((face, edge.is_constraint_edge()))
        })
        .collect();
    while let Some((face, odd)) = front.pop() {
        if inside[face.index()].is_some() {
            continue;
        }
        inside[face.index()] = Some(odd);
        for edge in triangles.face(face).adjacent_edges() {
            if let Some(next) = edge.rev().face().as_inner()
                && inside[next.fix().index()].is_none()
            {
                front.push((next.fix(), odd != edge.is_constraint_edge()));
            }
        }
    }
    inside.into_iter().map(|odd| odd == Some(true)).collect()
}
