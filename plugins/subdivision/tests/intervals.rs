//! Catmull-Clark refinement by knot intervals.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::collections::BTreeMap;

use loftsman_kernel::space::Space;
use loftsman_kernel::spline::{Direction, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::Cage;
use loftsman_subdivision::catmull_clark::{Refinement, limit_points, refine, refine_times};

fn apart(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most: f64, (p, q)| most.max((p - q).norm()))
}

/// A torus with an interval for each row and column, and its spline.
fn torus(zero: bool) -> (Cage, Surface, [usize; 2]) {
    let size = [5, 6];
    let [rows, columns] = size;
    let d = |axis: usize, k: usize| {
        if zero && k == 2 { 0.0 } else { 1.0 + 0.9 * crate::shapes::noise((axis * 100 + k) as u64) }
    };
    let mut cage = crate::shapes::grid(rows, columns, [true, true], 0.4);
    let at = |i: usize, j: usize| i % rows * columns + j % columns;
    for i in 0..rows {
        for j in 0..columns {
            cage = cage.with_interval(at(i, j), at(i + 1, j), d(0, i)).unwrap();
            cage = cage.with_interval(at(i, j), at(i, j + 1), d(1, j)).unwrap();
        }
    }
    let [u, v] = [0, 1].map(|axis| {
        let n = size[axis];
        // The support of vertex i starts two intervals before its place.
        let mut knots = vec![0.0];
        (0..n).for_each(|j| knots.push(knots[j] + d(axis, (j + n - 2) % n)));
        Space::periodic(3, knots).unwrap()
    });
    let spline = Surface::new(u, v, cage.points().to_vec()).unwrap();
    (cage, spline, size)
}

fn with_middles(spline: &Surface) -> Surface {
    let mut spline = spline.clone();
    for direction in [Direction::U, Direction::V] {
        let knots = spline.space(direction).breakpoints();
        let middles: Vec<f64> = knots.windows(2).map(|p| 0.5 * (p[0] + p[1])).collect();
        spline = spline.insert_knots(direction, &middles).unwrap();
    }
    spline
}

#[test]
fn a_grid_is_the_spline_with_knots_inserted() {
    let (cage, spline, [rows, columns]) = torus(false);
    let once = with_middles(&spline);
    let fine = refine(&cage).unwrap();
    // Vertex i is vertex 2i + 2 of the spline, the edge after it 2i + 3.
    let at = |i: usize, j: usize| once.points()[i % (2 * rows) * 2 * columns + j % (2 * columns)];
    let (vertices, edges) = (rows * columns, cage.topology().edge_count());
    for v in 0..vertices {
        assert!((fine.points()[v] - at(2 * (v / columns) + 2, 2 * (v % columns) + 2)).norm() < 1e-14);
    }
    for face in 0..cage.topology().face_count() {
        let (i, j) = (face / columns, face % columns);
        assert!((fine.points()[vertices + edges + face] - at(2 * i + 3, 2 * j + 3)).norm() < 1e-14);
        // The first edge of a face runs along u.
        let edge = cage.topology().face_edges(face)[0] as usize;
        assert!((fine.points()[vertices + edge] - at(2 * i + 3, 2 * j + 2)).norm() < 1e-14);
    }
    // And again, so that intervals are handed on rightly.
    let finer = refine(&fine).unwrap();
    let twice = with_middles(&once);
    for point in finer.points() {
        let near = twice.points().iter().map(|p| (p - point).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}

/// Zero intervals are split into zeros: all of it still lies on the spline with a double knot.
#[test]
fn zero_intervals_make_double_knots() {
    let (cage, spline, _) = torus(true);
    let fine = refine(&cage).unwrap();
    let once = with_middles(&spline);
    // Every vertex of the spline is there.
    for p in once.points() {
        let near = fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}

#[test]
fn equal_intervals_are_none() {
    for (name, cage) in crate::shapes::all() {
        for interval in [1.0, 3.7e-3] {
            let mut same = cage.clone();
            for edge in 0..cage.topology().edge_count() {
                let [a, b] = cage.topology().edge(edge).unwrap();
                same = same.with_interval(a as usize, b as usize, interval).unwrap();
            }
            let (a, b) = (refine_times(&cage, 2).unwrap(), refine_times(&same, 2).unwrap());
            assert!(apart(a.points(), b.points()) < 1e-14, "{name}: {:e}", apart(a.points(), b.points()));
            assert!(apart(&limit_points(&cage).unwrap(), &limit_points(&same).unwrap()) < 1e-14);
        }
    }
}

#[test]
fn any_intervals_give_affine_rows() {
    for (name, cage) in crate::shapes::all().into_iter().step_by(2) {
        let mut uneven = cage.clone();
        for edge in 0..cage.topology().edge_count() {
            let [a, b] = cage.topology().edge(edge).unwrap();
            // A third of them zero.
            let d = (1.0 + 1.5 * crate::shapes::noise(edge as u64)).max(0.0);
            uneven = uneven.with_interval(a as usize, b as usize, d).unwrap();
        }
        let refinement = Refinement::new(uneven, 2).unwrap();
        for level in 1..=2 {
            for (v, row) in refinement.stencils(level).unwrap().iter().enumerate() {
                let total: f64 = row.coefficients().iter().sum();
                assert!((total - 1.0).abs() < 1e-14, "{name}: {total}");
                let p = refinement.levels()[level].points()[v];
                assert!((row.apply(cage.points()) - p.coords).norm() < 1e-13, "{name}");
            }
        }
    }
}

/// The edge of a grid is the cubic spline of its own vertices, by their intervals.
#[test]
fn the_boundary_is_a_spline_of_its_own() {
    use loftsman_subdivision::{BoundaryRule, Polygon, Scheme};
    let n = 7;
    let mut cage = crate::shapes::grid(n, 3, [true, false], 0.3).with_boundary(BoundaryRule::EdgeOnly);
    let d: Vec<f64> = (0..n).map(|k| 1.0 + 0.8 * crate::shapes::noise(k as u64)).collect();
    for i in 0..n {
        for j in 0..3 {
            cage = cage.with_interval(3 * i + j, 3 * ((i + 1) % n) + j, d[i]).unwrap();
        }
    }
    let rim: Vec<Point> = (0..n).map(|i| cage.points()[3 * i]).collect();
    let polygon = Polygon::new(Scheme::Cubic, rim, true).unwrap().with_intervals(d).unwrap().refine_times(2);
    let fine = refine_times(&cage, 2).unwrap();
    for p in polygon.points() {
        let near = fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
        assert!(near < 1e-14, "{near:e}");
    }
}

/// A closed cage of which nothing is known but its faces and the intervals of its edges: the rules of Sederberg, Zheng, Sewell and Sabin (1998,
/// equations 14 to 16), written down once more.
struct Plain<'a> {
    points: &'a [Point],
    faces: Vec<Vec<usize>>,
    intervals: BTreeMap<[usize; 2], f64>,
}

impl<'a> Plain<'a> {
    fn new(cage: &'a Cage) -> Self {
        let topology = cage.topology();
        let face = |f: usize| topology.face(f).iter().map(|&v| v as usize).collect();
        let edge = |e: usize| {
            let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
            ([a.min(b), a.max(b)], cage.interval(e))
        };
        Self {
            points: cage.points(),
            faces: (0..topology.face_count()).map(face).collect(),
            intervals: (0..topology.edge_count()).map(edge).collect(),
        }
    }

    fn d(&self, a: usize, b: usize) -> f64 {
        self.intervals[&[a.min(b), a.max(b)]]
    }

    /// The face that runs from one vertex to another, from these two on.
    fn face(&self, a: usize, b: usize) -> Vec<usize> {
        let starts = |f: &Vec<usize>| (0..f.len()).find(|&k| f[k] == a && f[(k + 1) % f.len()] == b);
        let (f, k) = self.faces.iter().find_map(|f| Some((f, starts(f)?))).unwrap();
        (0..f.len()).map(|j| f[(k + j) % f.len()]).collect()
    }

    /// The ends of the edges at a vertex, counterclockwise, from one on.
    fn around(&self, vertex: usize, first: usize) -> Vec<usize> {
        let mut all = vec![first];
        loop {
            let next = *self.face(vertex, all[all.len() - 1]).last().unwrap();
            if next == first {
                return all;
            }
            all.push(next);
        }
    }

    /// The interval of the edge from a vertex to another, turned about the vertex by so many.
    fn turned(&self, vertex: usize, to: usize, by: i64) -> f64 {
        let all = self.around(vertex, to);
        self.d(vertex, all[by.rem_euclid(all.len() as i64) as usize])
    }

    /// An edge's interval with the two beyond its end at a vertex.
    fn with_beyond(&self, vertex: usize, to: usize) -> f64 {
        self.d(vertex, to) + self.turned(vertex, to, 2) + self.turned(vertex, to, -2)
    }

    fn mean(&self, all: &[(usize, f64)]) -> Vector {
        let total: f64 = all.iter().map(|(_, w)| w).sum();
        all.iter().map(|&(v, w)| self.points[v].coords * (w / total)).sum()
    }

    fn face_point(&self, f: &[usize]) -> Vector {
        let n = f.len();
        let at = |k: usize| f[k % n];
        let weight = |i: usize| {
            let i = i + 2 * n;
            let forwards = self.with_beyond(at(i + 1), at(i)) + self.with_beyond(at(i - 2), at(i - 1));
            let back = self.with_beyond(at(i - 1), at(i)) + self.with_beyond(at(i + 2), at(i + 1));
            forwards * back
        };
        self.mean(&(0..n).map(|i| (at(i), weight(i))).collect::<Vec<_>>())
    }

    /// Of an edge by itself.
    fn middle(&self, a: usize, b: usize) -> Vector {
        self.mean(&[(a, self.with_beyond(b, a)), (b, self.with_beyond(a, b))])
    }

    fn edge_point(&self, a: usize, b: usize) -> Vector {
        let (left, right) =
            (self.turned(b, a, -1) + self.turned(a, b, 1), self.turned(b, a, 1) + self.turned(a, b, -1));
        let (to_left, to_right) = (right / (2.0 * (left + right)), left / (2.0 * (left + right)));
        self.middle(a, b) * (1.0 - to_left - to_right)
            + self.face_point(&self.face(a, b)) * to_left
            + self.face_point(&self.face(b, a)) * to_right
    }

    fn vertex_point(&self, vertex: usize) -> Vector {
        let first = self.faces.iter().find(|f| f.contains(&vertex)).unwrap();
        let place = first.iter().position(|&v| v == vertex).unwrap();
        let all = self.around(vertex, first[(place + 1) % first.len()]);
        let n = all.len() as f64;
        let (mut sum, mut total) = (Vector::zeros(), 0.0);
        for (k, &to) in all.iter().enumerate() {
            let next = all[(k + 1) % all.len()];
            let d = |by| self.turned(vertex, to, by);
            let (m, f) = ((d(1) + d(-1)) * (d(2) + d(-2)) / 2.0, d(-1) * self.turned(vertex, next, 1));
            sum += self.middle(vertex, to) * m + self.face_point(&self.face(vertex, to)) * f;
            total += m + f;
        }
        self.points[vertex].coords * ((n - 3.0) / n) + sum * (3.0 / (n * total))
    }
}

/// Any positive intervals, opposite edges unlike, on vertices and faces of 3 to 12 edges: two levels are what the paper's rules say, intervals handed on
/// as it says, too.
#[test]
fn intervals_that_differ_across_faces_are_refined_by_the_rules() {
    let mut cages = vec![crate::shapes::cube(), crate::shapes::tetrahedron()];
    cages.push(crate::shapes::grid(4, 5, [true, true], 0.3));
    for n in 3..=12 {
        cages.push(crate::shapes::double_fan(n, 0.1));
        // A prism: two faces of n corners.
        let at = |k: usize| {
            let t = std::f64::consts::TAU * (k % n) as f64 / n as f64;
            Point::new(t.cos(), t.sin(), if k < n { 0.0 } else { 1.0 })
        };
        let mut faces: Vec<Vec<usize>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
        faces.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
        cages.push(Cage::new((0..2 * n).map(at).collect(), &faces).unwrap());
    }
    let mut unlike = 0;
    for (seed, cage) in cages.into_iter().enumerate() {
        let mut level = (0..cage.topology().edge_count()).fold(cage.clone(), |uneven, e| {
            let [a, b] = cage.topology().edge(e).unwrap();
            let d = 5.0_f64.powf(crate::shapes::noise(1000 * seed as u64 + e as u64));
            uneven.with_interval(a as usize, b as usize, d).unwrap()
        });
        for _ in 0..2 {
            let (plain, fine) = (Plain::new(&level), refine(&level).unwrap());
            let topology = level.topology();
            let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
            let near = |k: usize, p: Vector, what: &str| {
                let off = (fine.points()[k].coords - p).norm();
                assert!(off < 1e-14, "cage {seed}, {what} {k}: {off:e}");
            };
            (0..vertices).for_each(|v| near(v, plain.vertex_point(v), "vertex"));
            for e in 0..edges {
                let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
                near(vertices + e, plain.edge_point(a, b), "edge");
                for v in [a, b] {
                    let child = fine.topology().edge_between(v, vertices + e).unwrap();
                    assert!((fine.interval(child) - plain.d(a, b) / 2.0).abs() < 1e-15);
                }
                // Between the points of the edge and of a face: the mean of half the edges on either side.
                for (a, b) in [(a, b), (b, a)] {
                    let f = plain.face(a, b);
                    let number = (0..topology.face_count())
                        .find(|&k| {
                            let own: Vec<usize> = topology.face(k).iter().map(|&v| v as usize).collect();
                            own.len() == f.len() && f.iter().all(|v| own.contains(v)) && {
                                let at = own.iter().position(|&v| v == a).unwrap();
                                own[(at + 1) % own.len()] == b
                            }
                        })
                        .unwrap();
                    let child =
                        fine.topology().edge_between(vertices + e, vertices + edges + number).unwrap();
                    let (before, after) = (plain.d(f[f.len() - 1], a), plain.d(b, f[2]));
                    assert!((fine.interval(child) - (before + after) / 4.0).abs() < 1e-15);
                    unlike += usize::from((before / after).ln().abs() > 0.1);
                }
            }
            for (k, f) in plain.faces.iter().enumerate() {
                near(vertices + edges + k, plain.face_point(f), "face");
            }
            level = fine;
        }
    }
    assert!(unlike > 500, "{unlike}");
}
