//! What rows and drags cost, counted: the same whatever the size of the cage.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use loftsman_kernel::edit::{Edit, Metric};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Cells, Derivative, Domain, Location, Neighbours, Shape, Stencil};
use loftsman_kernel::solve::Adjoint;
use loftsman_kernel::{Point, Result, Vector};
use loftsman_subdivision::{Cage, SubdivisionSurface};

use crate::shapes::noise;

/// A sheet of `n × n` quads of which the middle one is two triangles: two vertices of five edges, nothing else being odd. 1024 and 10,000 faces are alike
/// round it.
fn sheet(n: usize) -> SubdivisionSurface {
    let at = |i: usize, j: usize| i * (n + 1) + j;
    // Heights by the distance from the middle, so that they are the same ones, too.
    let from_middle = |i: usize| i as i64 - (n / 2) as i64;
    let point = |k: usize| {
        let (x, y) = (from_middle(k / (n + 1)), from_middle(k % (n + 1)));
        Point::new(x as f64, y as f64, 0.3 * noise((1_000_000 + 1000 * x + y) as u64))
    };
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for k in 0..n * n {
        let (i, j) = (k / n, k % n);
        let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if (i, j) == (n / 2, n / 2) {
            faces.extend([quad[..3].to_vec(), vec![quad[0], quad[2], quad[3]]]);
        } else {
            faces.push(quad.to_vec());
        }
    }
    SubdivisionSurface::new(Cage::new((0..(n + 1) * (n + 1)).map(point).collect(), &faces).unwrap()).unwrap()
}

const SIZES: [usize; 2] = [32, 100];

/// The vertex so many steps from the middle.
fn vertex(n: usize, i: i64, j: i64) -> u32 {
    let at = |k: i64| ((n / 2) as i64 + k) as u32;
    at(i) * (n as u32 + 1) + at(j)
}

/// Faces round the middle, in order.
fn faces(surface: &SubdivisionSurface, n: usize) -> Vec<u32> {
    let middle = |k: usize| k.abs_diff(n / 2) <= 3;
    let topology = surface.cage().topology();
    let is_near = |f: &usize| {
        topology.face(*f).iter().all(|v| {
            let v = *v as usize;
            middle(v / (n + 1)) && middle(v % (n + 1))
        })
    };
    let near = (0..topology.face_count()).filter(is_near);
    near.flat_map(|f| (0..topology.face(f).len()).filter_map(move |c| surface.face_of(f, c).unwrap()))
        .collect()
}

/// Rows have as many entries on a large cage as on a small one: sixteen where all is regular, and no more than the vertices of the face and of those that
/// touch it where it is not.
#[test]
fn rows_cost_what_is_near() {
    let entries = SIZES.map(|n| {
        let surface = sheet(n);
        assert!(faces(&surface, n).iter().filter(|&&f| !surface.is_regular(f).unwrap()).count() > 10);
        let topology = surface.cage().topology();
        let mut all = Vec::new();
        for face in faces(&surface, n) {
            let (of, _) = surface.cage_face(face).unwrap();
            let corners = topology.face(of).iter();
            let mut near: Vec<u32> = corners
                .flat_map(|&v| topology.vertex_faces(v as usize))
                .flat_map(|f| topology.face(f as usize).iter().copied())
                .collect();
            near.sort_unstable();
            near.dedup();
            for (u, v) in [(0.3, 0.6), (0.01, 0.99), (1e-6, 1e-7), (0.0, 0.0)] {
                for by in [[0, 0], [1, 0], [1, 1], [0, 2]] {
                    // Second derivatives may be infinite at a vertex.
                    let Ok(row) = surface.stencil(Location::Face(face, u, v), Derivative::from(by)) else {
                        assert!(u == 0.0 && by != [0, 0], "{face} {u} {v} {by:?}");
                        all.push(0);
                        continue;
                    };
                    assert!(row.vertices().iter().all(|k| near.contains(&(*k as u32))), "{face}");
                    assert!(!surface.is_regular(face).unwrap() || row.vertices().len() <= 16, "{face}");
                    all.push(row.vertices().len());
                }
            }
        }
        all
    });
    assert_eq!(entries[0], entries[1]);
    assert!(entries[0].len() > 600, "{}", entries[0].len());
}

/// Cells are so many a face, however many there are: one where it is regular.
#[test]
fn cells_are_so_many_a_face() {
    let cells = SIZES.map(|n| {
        let surface = sheet(n);
        let all = Cells::count(&surface);
        assert_eq!(surface.cells().unwrap().iter().count(), all);
        all - surface.faces().unwrap()
    });
    // What is beyond one a face belongs to the odd ones.
    assert_eq!(cells[0], cells[1]);
    assert!(cells[0] > 0);
}

/// A surface that counts how often it is asked for rows and for neighbours.
#[derive(Debug, Clone)]
struct Counted(SubdivisionSurface, Arc<[AtomicUsize; 2]>);

impl Counted {
    fn add(&self, what: usize) {
        self.1[what].fetch_add(1, Ordering::Relaxed);
    }
}

impl Shape for Counted {
    fn control_vertices(&self) -> &[Point] {
        self.0.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.0.control_vertices_mut()
    }

    fn stencil(&self, at: Location, by: Derivative) -> Result<Stencil> {
        self.add(0);
        self.0.stencil(at, by)
    }

    fn domain(&self) -> Domain {
        self.0.domain()
    }

    fn faces(&self) -> Option<usize> {
        self.0.faces()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        Some(self)
    }
}

impl Neighbours for Counted {
    fn around(&self, vertex: usize) -> smallvec::SmallVec<[usize; 8]> {
        self.add(1);
        self.0.neighbours().unwrap().around(vertex)
    }
}

/// What a drag asked and moved.
#[derive(Debug, PartialEq)]
struct Cost {
    /// Rows and neighbours asked for when the mouse goes down.
    prepared: [usize; 2],
    /// The same while it is dragged.
    events: [usize; 2],
    /// The vertices that an event moves, the same at every event.
    moved: usize,
}

fn cost(n: usize, at: Location, metric: &Metric) -> Cost {
    let surface = sheet(n);
    let counts: Arc<[AtomicUsize; 2]> = Arc::default();
    let asked = || [0, 1].map(|k| counts[k].swap(0, Ordering::Relaxed));
    let own = surface.stencil(at, Derivative::POSITION).unwrap();
    let from = Point::from(surface.value(at, Derivative::POSITION).unwrap());
    let counted = Counted(surface.clone(), counts.clone());
    let edit = Edit::new(&counted).metric(metric.clone());
    let mut session = edit.handle(position(at)).prepare(Adjoint).unwrap();
    let prepared = asked();
    let mut before = surface.control_vertices().to_vec();
    let mut moved = None;
    for k in 1..=200 {
        let to = from + Vector::new(0.003, -0.001, 0.01) * f64::from(k);
        session.to_point(to).unwrap();
        let after = session.shape().control_vertices();
        let those: Vec<usize> = (0..after.len()).filter(|&v| after[v] != before[v]).collect();
        if *metric == Metric::Least {
            assert_eq!(those, own.vertices(), "{at}: an event moves the vertices of the row, and no others");
        }
        assert_eq!(*moved.get_or_insert(those.len()), those.len(), "{at}, event {k}");
        before = after.to_vec();
    }
    let end = own.apply(session.shape().control_vertices());
    assert!(
        (end - from.coords - Vector::new(0.6, -0.2, 2.0)).norm() < 1e-12,
        "{at}: it is where it was dragged to"
    );
    Cost { prepared, events: asked(), moved: moved.unwrap() }
}

/// An event asks the shape nothing and moves the vertices of its handle's row, and with a falloff those that are near, of a cage of any size.
#[test]
fn dragging_costs_what_is_touched() {
    // A regular vertex, one with five edges, one beside it; a place of a regular face, and one in a triangle.
    type Place = fn(usize) -> Location;
    let triangle = |n: usize| Location::Face((n / 2 * n + n / 2) as u32, 0.4, 0.2);
    let places: [Place; 5] = [
        |n| Location::Vertex(vertex(n, -6, -5)),
        |n| Location::Vertex(vertex(n, 0, 0)),
        |n| Location::Vertex(vertex(n, 1, 0)),
        |n| Location::Face(((n / 2 - 5) * n + n / 2) as u32, 0.3, 0.8),
        triangle,
    ];
    // The row of a regular vertex has nine entries, with two triangles among five faces there are as many, with one of four one less; that of a
    // face has sixteen.
    let entries = [9, 9, 8, 16, 16];
    for (place, entries) in places.into_iter().zip(entries) {
        for metric in [Metric::Least, Metric::Falloff(3.0)] {
            let [few, many] = SIZES.map(|n| cost(n, place(n), &metric));
            assert_eq!(few, many, "{} {metric:?}", place(32));
            assert_eq!(few.events, [0, 0], "{} {metric:?}", place(32));
            let fits = few.moved <= entries || metric != Metric::Least && few.moved < 100;
            assert!(few.prepared[0] <= 4 && fits, "{} {few:?}", place(32));
        }
    }
}
