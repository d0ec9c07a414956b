//! Shapes that are no splines, measured by their cells alone: against closed forms, and against the sums over spans.

use loftsman_area_volume::{area, centroid, closed, gap, length, surface_area, volume};
use loftsman_kernel::conformance::{Patches, functional_conformance};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Functional, On, Shapes, position, value_of};
use loftsman_kernel::shape::{
    BoundaryEdge, Cell, Cells, Derivative, Domain, Edges, Location, Shape, Sides, Stencil, Strip,
};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{CatmullRom, Curve, Space, Spacing, Surface, Trimmed};
use loftsman_kernel::{Point, Result, Vector};

/// A spline that does not say that it is one.
#[derive(Debug, Clone)]
struct Plain<S>(S);

impl<S: Shape + Clone> Shape for Plain<S> {
    fn control_vertices(&self) -> &[Point] {
        self.0.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.0.control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.0.stencil(at, derivative)
    }

    fn stencil_on(&self, at: Location, derivative: Derivative, sides: Sides) -> Result<Stencil> {
        self.0.stencil_on(at, derivative, sides)
    }

    fn domain(&self) -> Domain {
        self.0.domain()
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
}

impl<S: Shape> Cells for Plain<S> {
    fn count(&self) -> usize {
        self.0.cells().unwrap().count()
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        self.0.cells()?.cell(index)
    }
}

impl<S: Shape> Edges for Plain<S> {
    fn count(&self) -> usize {
        self.0.edges().map_or(0, Edges::count)
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        self.0.edges()?.edge(index)
    }

    /// Of a rational one it has to say them; of others they are found.
    fn strips(&self, index: usize, order: usize) -> Option<Result<Vec<Strip>>> {
        if self.0.cells()?.is_rational() { self.0.edges()?.strips(index, order) } else { None }
    }
}

fn value(functional: &dyn Functional, shapes: &Shapes<'_>) -> Vec<f64> {
    let mut out = vec![0.0; functional.equations()];
    value_of(functional, shapes, &mut out).unwrap();
    out
}

/// Values and rows of a functional agree on a spline and on the same that does not say so.
fn agree(functional: &dyn Functional, spline: &dyn Shape, plain: &dyn Shape) {
    let what = functional.describe();
    let both = [spline, plain].map(|shape| value(functional, &Shapes::one(shape)));
    for (a, b) in both[0].iter().zip(&both[1]) {
        assert!((a - b).abs() <= 1e-10 * a.abs().max(1.0), "{what}: {both:?}");
    }
    let verdict = functional_conformance(functional, &[plain.boxed()]);
    assert!(verdict.passed(), "{what}: {verdict}");
}

/// A box over `[0, 2] × [0, 1]` whose lid bulges: `z = 1 + c u (2 - u) v (1 - v)`.
fn chest(c: f64) -> (Patches, Vec<Box<dyn Shape>>) {
    let lid = Patches::of_blossom(|u, v| {
        let over = (u[0] + u[1] - u[0] * u[1]) * (0.5 * (v[0] + v[1]) - v[0] * v[1]);
        Point::new(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]), 1.0 + c * over)
    });
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let side = |corners: [[f64; 3]; 4]| -> Box<dyn Shape> {
        Box::new(Surface::new(line(), line(), corners.map(Point::from).to_vec()).unwrap())
    };
    let walls = vec![
        side([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]),
        side([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0, 0.0], [2.0, 0.0, 1.0]]),
        side([[0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [2.0, 1.0, 0.0], [2.0, 1.0, 1.0]]),
        side([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0]]),
        side([[2.0, 0.0, 0.0], [2.0, 0.0, 1.0], [2.0, 1.0, 0.0], [2.0, 1.0, 1.0]]),
    ];
    (lid, walls)
}

#[test]
fn a_chest_with_a_lid_of_patches_has_its_volume_and_keeps_it() {
    let c = 0.9;
    let (lid, walls) = chest(c);
    let all: Vec<On> = (0..6).map(On::from).collect();
    let shapes = Shapes::new(std::iter::once(&lid as &dyn Shape).chain(walls.iter().map(AsRef::as_ref)));
    let expected = 2.0 + 2.0 * c / 9.0;
    let found = value(&volume().of(all.clone()), &shapes)[0];
    assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    assert!(gap(&shapes, &all).unwrap() < 1e-14);
    // ½ ∫∫ z² of the lid.
    let height = 0.5 * (2.0 + 4.0 * c / 9.0 + c * c * 16.0 / 450.0) / expected;
    let middle = value(&centroid().of(all.clone()), &shapes);
    assert!((middle[0] - 1.0).abs() < 1e-13 && (middle[1] - 0.5).abs() < 1e-13, "{middle:?}");
    assert!((middle[2] - height).abs() < 1e-13, "{middle:?} {height}");
    // An edit keeps it, and the lid on its walls.
    let mut edit = Edit::new(&lid);
    for wall in &walls {
        edit = edit.with(wall.boxed());
    }
    let push = Vector::new(0.0, 0.0, 0.2);
    let edited =
        edit.ask(volume().of(all.clone()).keep()).ask(position([1.0, 0.5]).by(push)).solve().unwrap();
    let after = Shapes::new((0..6).map(|k| edited.shape_at(k).unwrap()));
    assert!((value(&volume().of(all.clone()), &after)[0] - expected).abs() < 1e-11);
    assert!(gap(&after, &all).unwrap() < 1e-11);
}

#[test]
fn patches_have_their_area() {
    for slope in [0.0, 0.75] {
        let tilted = Patches::of_blossom(|u, v| {
            let x = 0.5 * (u[0] + u[1]);
            Point::new(x, 0.5 * (v[0] + v[1]), slope * x)
        });
        let found = value(&surface_area(), &Shapes::one(&tilted))[0];
        assert!((found - 2.0 * (1.0 + slope * slope).sqrt()).abs() < 1e-13, "{found}");
        let verdict = functional_conformance(&surface_area(), &[tilted.boxed()]);
        assert!(verdict.passed(), "{verdict}");
    }
}

#[test]
fn a_curve_through_its_vertices_is_measured_as_its_spline() {
    let ring: Vec<Point> = (0..9)
        .map(|k| f64::from(k) * 0.7)
        .map(|t| Point::new((2.0 + (3.0 * t).sin()) * t.cos(), 1.5 * t.sin(), 0.0))
        .collect();
    let through = CatmullRom::new(ring, true, Spacing::Centripetal).unwrap();
    let spline = through.to_curve().unwrap();
    for functional in [&area() as &dyn Functional, &length(), &centroid()] {
        let (a, b) = (value(functional, &Shapes::one(&spline)), value(functional, &Shapes::one(&through)));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
        let verdict = functional_conformance(functional, &[through.boxed()]);
        assert!(verdict.passed(), "{verdict}");
    }
    let push = Vector::new(0.3, 0.1, 0.0);
    let edited = Edit::new(&through).ask(area().keep()).ask(position(1.0).by(push)).solve().unwrap();
    let [before, after] = [&through, edited.shape()].map(|s| value(&area(), &Shapes::one(s))[0]);
    assert!((before - after).abs() < 1e-12 * before);
}

#[test]
fn what_does_not_say_that_it_is_a_spline_is_measured_alike() {
    let circle = Curve::circle(Point::new(1.0, 0.0, 0.0), Vector::z(), 2.0).unwrap();
    let wave = (0..7).map(|k| f64::from(k) * 0.9).map(|t| Point::new(3.0 * t.cos(), t.sin(), 0.0)).collect();
    let wave = Curve::new(Space::periodic_uniform(4, 7).unwrap(), wave).unwrap();
    for curve in [circle, wave] {
        for functional in [&area() as &dyn Functional, &length(), &centroid()] {
            agree(functional, &curve, &Plain(curve.clone()));
        }
    }
    let sphere = crate::samples::sphere(1.5);
    agree(&volume(), &sphere, &Plain(sphere.clone()));
    agree(&centroid(), &sphere, &Plain(sphere.clone()));
    assert!(
        (value(&surface_area(), &Shapes::one(&Plain(sphere)))[0] - 9.0 * std::f64::consts::PI).abs() < 1e-9
    );
    // A tube of degree 3 whose ends are points: poles, and edges found by interpolation.
    let radii = [0.0, 1.0, 1.4, 0.8, 0.0];
    let net = radii.iter().enumerate().flat_map(|(i, r)| {
        let turn = move |j: usize| f64::from(j as u32) * 1.1;
        (0..6).map(move |j| Point::new(r * turn(j).cos(), r * turn(j).sin(), i as f64))
    });
    let (u, v) = (Space::clamped_uniform(3, 5).unwrap(), Space::periodic_uniform(2, 6).unwrap());
    let tube = Surface::new(u, v, net.collect()).unwrap();
    agree(&volume(), &tube, &Plain(tube.clone()));
    agree(&surface_area(), &tube, &Plain(tube.clone()));
    let ties = |shape: &dyn Shape| closed().bind(&Shapes::one(shape)).unwrap().unwrap().equations();
    assert_eq!(ties(&tube), ties(&Plain(tube)));
}

#[test]
fn what_cannot_be_measured_says_why() {
    let patches = Patches::flat();
    let error = |functional: &dyn Functional, shape: &dyn Shape| {
        let mut out = [0.0; 3];
        value_of(functional, &Shapes::one(shape), &mut out[..functional.equations()]).unwrap_err().to_string()
    };
    assert!(error(&area(), &patches).contains("is a surface"));
    assert!(error(&volume(), &patches).contains("the boundary is open"));
}

/// Half of a square, by the loop around it.
#[test]
fn what_loops_leave_is_measured() {
    let line = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let at = |x: f64, y: f64| Point::new(x, y, 0.0);
    let square =
        Surface::new(line(), line(), vec![at(0.0, 0.0), at(0.0, 1.0), at(1.0, 0.0), at(1.0, 1.0)]).unwrap();
    let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
    let side =
        |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 3]).unwrap()).unwrap();
    let outer = (0..3).map(side).collect();
    let trimmed = Trimmed::new(square, vec![Region { outer, holes: vec![] }], vec![], vec![]).unwrap();
    let mut out = [0.0];
    value_of(&surface_area(), &Shapes::one(&trimmed), &mut out).unwrap();
    assert!((out[0] - 0.5).abs() < 1e-13, "{out:?}");
}
