//! Shapes in boxes: whatever kind they are, edits take them as they come, and give what they give the shape itself.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::any::Any;

use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{curvature, position};
use loftsman_kernel::shape::{Derivative, Domain, Location, Shape, Stencil};
use loftsman_kernel::spline::{CatmullRom, Curve, Space, Spacing, Surface};
use loftsman_kernel::{Point, Vector};

fn points(count: usize) -> Vec<Point> {
    (0..count).map(|k| Point::new(k as f64, (0.8 * k as f64).sin(), 0.1 * (k * k % 7) as f64)).collect()
}

/// One of each kind, and a place on it.
fn shapes() -> Vec<(Box<dyn Shape>, Location)> {
    let curve = Curve::new(Space::clamped_uniform(3, 9).unwrap(), points(9)).unwrap();
    let circle = Curve::circle(Point::new(1.0, 0.0, 0.0), Vector::z(), 2.0).unwrap();
    let (u, v) = (Space::clamped_uniform(2, 5).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    let surface = Surface::build(u, v, points(30), None).unwrap();
    let through = CatmullRom::new(points(8), false, Spacing::Centripetal).unwrap();
    let middle = 0.5 * (through.domain()[0].start + through.domain()[0].end);
    vec![
        (Box::new(curve), 2.3.into()),
        (Box::new(circle), 0.3.into()),
        (Box::new(surface), [1.2, 1.7].into()),
        (Box::new(through), middle.into()),
    ]
}

#[test]
fn a_box_is_edited_as_what_is_in_it() {
    let push = Vector::new(0.1, 0.4, -0.2);
    for (shape, at) in shapes() {
        for metric in [Metric::Least, Metric::Falloff(2.0)] {
            let ask = || Edit::new(&shape).metric(metric.clone()).ask(position(at).by(push));
            let edited = ask().solve().unwrap();
            let before = shape.value(at, Derivative::POSITION).unwrap();
            let after = edited.shape().value(at, Derivative::POSITION).unwrap();
            assert!((after - before - push).norm() < 1e-12);
            assert_eq!(edited.shape().type_name(), shape.type_name());
            // Typed and untyped alike, to the last bit.
            let any: &dyn Any = shape.as_shape();
            if let Some(curve) = any.downcast_ref::<Curve>() {
                let typed =
                    Edit::new(curve).metric(metric.clone()).ask(position(at).by(push)).solve().unwrap();
                assert_eq!(typed.shape().points(), edited.shape().control_vertices());
                assert_eq!(typed.report(), edited.report());
            }
            // The way out of the box, and back to how it was.
            assert_eq!(ask().solve().unwrap().undo().control_vertices(), shape.control_vertices());
            let out: Box<dyn Shape> = edited.into_shape();
            assert_eq!((*out).type_id(), (*shape).type_id());
        }
    }
}

#[test]
fn what_only_curves_can_do_works_in_a_box_and_is_refused_of_others() {
    for (shape, at) in shapes() {
        let any: &dyn Any = shape.as_shape();
        let is_curve = any.is::<Curve>();
        let push = position(at).by(Vector::new(0.0, 0.1, 0.0));
        let interval = shape.domain()[0];
        let (start, end) = (interval.start, interval.end);
        let within = Edit::new(&shape).within(start, end).ask(push).solve();
        assert_eq!(within.is_ok(), is_curve, "{within:?}");
        if let Location::Curve(u) = at {
            let bent = Edit::new(&shape).ask(curvature(u).scale(1.1)).ask(position(u).keep()).solve();
            assert!(bent.is_ok(), "{bent:?}");
        }
    }
}

/// A shape of somebody else's: two vertices and the line through them.
#[derive(Debug, Clone)]
struct Line([Point; 2]);

impl Shape for Line {
    fn control_vertices(&self) -> &[Point] {
        &self.0
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.0
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let u = at.on_curve()?;
        let row = match derivative.u {
            0 => [1.0 - u, u],
            1 => [-1.0, 1.0],
            _ => [0.0, 0.0],
        };
        Ok(row.into_iter().enumerate().collect())
    }

    fn domain(&self) -> Domain {
        [loftsman_kernel::shape::Interval { start: 0.0, end: 1.0, periodic: false }].into_iter().collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}

#[test]
fn nobody_guesses_what_neighbours_a_vertex_has() {
    let line = Line([Point::origin(), Point::new(1.0, 0.0, 0.0)]);
    let push = || position(0.5).by(Vector::y());
    assert!(Edit::new(&line).ask(push()).solve().is_ok());
    let refused = Edit::new(&line).metric(Metric::Falloff(2.0)).ask(push()).solve().unwrap_err().to_string();
    assert!(refused.contains("does not say which these are") && refused.contains("Line"), "{refused}");
    let refused = Edit::new(&line).metric(Metric::Bend).ask(push()).solve().unwrap_err().to_string();
    assert!(refused.contains("no stretch or bend metric"), "{refused}");
}
