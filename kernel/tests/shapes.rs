//! What shapes say that they can do, and what can be done with one that is no spline.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::ops::Range;

use loftsman_kernel::conformance::{Patches, Verdict, shape_conformance};
use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Edge, Shapes, join, position};
use loftsman_kernel::shape::{
    Border, Cell, CellNet, Cells, Derivative, Domain, Edges, Hole, Location, Neighbours, Refine, Shape,
    Stencil, Strip, rows_at, strips,
};
use loftsman_kernel::spline::trimmed::Region;
use loftsman_kernel::spline::{CatmullRom, Curve, Space, Spacing, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

fn points(count: usize) -> Vec<Point> {
    (0..count).map(|k| Point::new(k as f64, (0.8 * k as f64).sin(), 0.1 * (k * k % 7) as f64)).collect()
}

fn weights(count: usize) -> Vec<f64> {
    (0..count).map(|k| 1.0 + 0.4 * (k % 4) as f64).collect()
}

fn passes(shape: &dyn Shape, what: &str) {
    let verdict: Verdict = shape_conformance(shape);
    assert!(verdict.passed() && verdict.checks > 40, "{what}: {verdict}");
}

/// Open and periodic spaces of a degree: clamped, floating, with knots repeated up to `p + 1` times.
fn spaces(p: usize) -> Vec<Space> {
    let mut repeated = vec![0.0; p + 1];
    for (k, times) in [1, p.div_ceil(2), p, p + 1].into_iter().enumerate() {
        repeated.extend(std::iter::repeat_n(1.0 + k as f64, times));
    }
    repeated.extend(vec![5.5; p + 1]);
    let around: Vec<f64> = (0..p + 4).map(|k| k as f64 + 0.3 * (k % 3) as f64).collect();
    vec![
        Space::clamped_uniform(p, p + 3).unwrap(),
        Space::floating_uniform(p, p + 3).unwrap(),
        Space::open(p, repeated).unwrap(),
        Space::periodic(p, around).unwrap(),
        Space::periodic_uniform(p, 2).unwrap(),
    ]
}

#[test]
fn splines_are_what_they_say() {
    for p in [1, 2, 3, 4, 5, 6, 7, 25] {
        for space in spaces(p) {
            let n = space.len();
            passes(&Curve::new(space.clone(), points(n)).unwrap(), &format!("degree {p}"));
            passes(&Curve::rational(space, points(n), weights(n)).unwrap(), &format!("rational, degree {p}"));
        }
    }
    for (p, q) in [(1, 1), (2, 3), (3, 1), (5, 2), (7, 3)] {
        for (u, v) in spaces(p).into_iter().zip(spaces(q).into_iter().cycle().skip(2)) {
            let n = u.len() * v.len();
            let surface = Surface::new(u.clone(), v.clone(), points(n)).unwrap();
            passes(&surface, &format!("degrees {p} and {q}"));
            passes(
                &Surface::rational(u, v, points(n), weights(n)).unwrap(),
                &format!("rational, {p} and {q}"),
            );
            passes(&Trimmed::new(surface.clone(), vec![], vec![], vec![]).unwrap(), "untrimmed");
            passes(&Trimmed::new(surface, vec![Region::default()], vec![], vec![]).unwrap(), "trimmed");
        }
    }
}

#[test]
fn other_shapes_are_what_they_say() {
    for closed in [false, true] {
        for count in [3, 4, 9] {
            passes(&CatmullRom::new(points(count), closed, Spacing::Centripetal).unwrap(), "Catmull-Rom");
        }
    }
    passes(&CatmullRom::new(points(2), false, Spacing::Uniform).unwrap(), "a segment");
    passes(&Patches::flat(), "patches");
    let boxed: Box<dyn Shape> = Box::new(Patches::flat());
    passes(&boxed, "patches in a box");
    assert!(boxed.edges().is_some() && boxed.neighbours().is_some() && boxed.refine().is_none());
}

/// Patches, or a curve, that lie in one thing.
#[derive(Debug, Clone)]
struct Liar {
    inner: Patches,
    lie: usize,
}

impl Shape for Liar {
    fn control_vertices(&self) -> &[Point] {
        self.inner.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.inner.control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let stencil = self.inner.stencil(at, derivative)?;
        let first = derivative == Derivative::from([1, 0]);
        Ok(match self.lie {
            0 if derivative == Derivative::POSITION => stencil.scaled(0.9),
            1 if first => stencil.scaled(2.0),
            2 => stencil.iter().map(|(v, c)| (v + 19, c)).collect(),
            // The left patch is another one.
            14 if at.on_surface()?.0 < 1.0 => stencil.iter().map(|(v, c)| ((v + 1) % 19, c)).collect(),
            _ => stencil,
        })
    }

    fn domain(&self) -> Domain {
        self.inner.domain()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn edges(&self) -> Option<&dyn Edges> {
        Some(self)
    }

    fn neighbours(&self) -> Option<&dyn Neighbours> {
        Some(self)
    }

    fn refine(&self) -> Option<&dyn Refine> {
        (self.lie == 10).then_some(self)
    }
}

impl Cells for Liar {
    fn count(&self) -> usize {
        if self.lie == 3 { 2 } else { 3 }
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let mut cell = self.inner.cell(index)?;
        match self.lie {
            4 => cell.sides[1].end = 1.0,
            5 => cell.vertices.pop().map_or((), drop),
            6 => cell.vertices = (0..19).collect(),
            7 => cell.sides[0].degree = 1,
            _ => {}
        }
        Some(cell)
    }

    fn always_meet(&self) -> bool {
        self.lie == 14
    }

    fn holes(&self) -> Vec<Hole> {
        let border = vec![Border { from: [0.5, 0.0], to: [0.0, 0.5], degree: 3 }];
        if self.lie == 11 { vec![Hole { face: None, apex: [0.0, 0.0], border }] } else { Vec::new() }
    }

    fn nets(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Option<Result<()>> {
        let numbers = if self.lie == 12 { numbers.start..numbers.end.min(2) } else { numbers };
        self.inner.nets(numbers, origin, &mut |net| {
            let mut points = net.points.to_vec();
            points[4] *= if self.lie == 13 { 1.1 } else { 1.0 };
            each(CellNet { points: &points, ..net });
        })
    }
}

impl Edges for Liar {
    fn count(&self) -> usize {
        4
    }

    fn edge(&self, index: usize) -> Option<loftsman_kernel::shape::BoundaryEdge> {
        self.inner.edge(index)
    }

    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        let mut own = strips(&self.inner, index, order);
        if let (8, Ok(strips)) = (self.lie, &mut own) {
            strips.iter_mut().for_each(|strip| strip.coefficients.reverse());
        }
        Some(own)
    }
}

impl Neighbours for Liar {
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let mut all = self.inner.around(vertex);
        all.retain(|&mut other| self.lie != 9 || other > vertex);
        all
    }
}

impl Refine for Liar {
    fn refined(&self, _: usize, _: &[f64]) -> Result<Box<dyn Shape>> {
        let mut finer = self.inner.clone();
        finer.control_vertices_mut()[0].z += 1.0;
        Ok(Box::new(finer))
    }
}

#[test]
fn lies_are_found() {
    for lie in 0..16 {
        let verdict = shape_conformance(&Liar { inner: Patches::flat(), lie });
        let says = [
            "sums to 0.9",
            "is not the rate",
            "is not one",
            "its domain 2",
            "is in 2 of its cells",
            "not on those that it names",
            "not on those that it names",
            "no polynomial of its degree",
            "is not its strip's",
            "not the other way round",
            "another shape",
            "the holes in them 0.125",
            "not one net for each",
            "is not the shape there",
            "always meet",
        ];
        match says.get(lie) {
            Some(says) => assert!(verdict.failures.iter().any(|f| f.contains(says)), "{lie}: {verdict}"),
            None => assert!(verdict.passed(), "{lie}: {verdict}"),
        }
    }
}

/// What a cell without vertices has is not taken for nothing.
#[test]
fn rows_of_a_cell_that_names_no_vertices_are_refused() {
    let flat = Patches::flat();
    let mut cell = flat.cells().unwrap().cell(0).unwrap();
    cell.vertices.clear();
    let points = cell.gauss_points([2, 2]);
    let refused = rows_at(&flat, &cell, &points, Derivative::POSITION).unwrap_err().to_string();
    assert!(refused.contains("does not name"), "{refused}");
}

#[test]
fn patches_are_edited_and_take_their_neighbours_along() {
    let flat = Patches::flat();
    let at = [1.4, 0.3];
    let push = Vector::new(0.0, 0.1, 0.5);
    for metric in [Metric::Least, Metric::Falloff(2.5), Metric::Stretch, Metric::Bend] {
        let edited = Edit::new(&flat).metric(metric.clone()).ask(position(at).by(push)).solve().unwrap();
        let moved = edited.shape().value(at.into(), Derivative::POSITION).unwrap();
        assert!((moved - Vector::new(1.4, 0.3, 0.0) - push).norm() < 1e-13, "{metric:?}");
    }
    // One vertex pulled: a radius of 2 reaches its neighbours, and no others; nearer ones move more than farther ones.
    let pulled = |radius: f64| {
        let ask = loftsman_kernel::functional::vertex(4).by(Vector::z());
        Edit::new(&flat).metric(Metric::Falloff(radius)).ask(ask).solve().unwrap().into_shape()
    };
    let heights: Vec<f64> = pulled(2.0).control_vertices().iter().map(|p| p.z).collect();
    for (vertex, z) in heights.iter().enumerate() {
        let near = flat.around(4).contains(&vertex);
        assert!(
            if vertex == 4 { (z - 1.0).abs() < 1e-14 } else { near == (*z > 0.0) && *z < 0.9 },
            "{heights:?}"
        );
    }
    assert_eq!(pulled(1.0).control_vertices().iter().filter(|p| p.z != 0.0).count(), 1);
    let refused =
        Edit::new(&Liar { inner: flat, lie: 9 }).metric(Metric::Falloff(2.0)).ask(position(at).by(push));
    assert!(refused.solve().unwrap_err().to_string().contains("mutual"));
}

#[test]
fn patches_are_joined_to_a_spline() {
    let patches = Patches::of_blossom(|u, v| {
        let (x, y) = (0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        Point::new(x, y, 0.2 * u[0] * u[1] - 0.1 * v[0] * v[1])
    });
    let v = Space::clamped(2, &[0.0, 0.5, 1.0]).unwrap();
    let net =
        (0..4).flat_map(|i| (0..4).map(move |j| Point::new(2.1 + f64::from(i), f64::from(j) / 3.0, 0.5)));
    let surface = Surface::new(Space::clamped_uniform(3, 4).unwrap(), v, net.collect()).unwrap();
    for (edge, continuity) in [(Edge::UEnd, 0), (Edge::UEnd, 1), (Edge::Number(1), 1)] {
        let ask = join(edge, 1, Edge::UStart, continuity);
        let edited =
            Edit::new(&patches).with(Box::new(surface.clone())).ask(ask.clone().hold()).solve().unwrap();
        let gaps =
            ask.gaps(&Shapes::new([edited.shape() as &dyn Shape, edited.shape_at(1).unwrap()])).unwrap();
        assert!(gaps.iter().all(|gap| *gap < 1e-12), "{gaps:?}");
    }
    // What has no such edge says which it has; what is no surface, that.
    let ask = |edge: Edge| {
        Edit::new(&patches).with(Box::new(surface.clone())).ask(join(edge, 1, Edge::UStart, 0).hold())
    };
    let refused = ask(Edge::Number(4)).solve().unwrap_err().to_string();
    assert!(refused.contains("there is no edge") && refused.contains("u0, u1, v0, v1"), "{refused}");
}
