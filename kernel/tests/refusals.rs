//! What is refused, and what is said then to do.
#![allow(missing_docs, clippy::unwrap_used, reason = "these are tests")]

use loftsman_kernel::Point;
use loftsman_kernel::Vector;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{
    Functional, Shapes, curvature, linear, position, signed_curvature, vertex,
};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space};

fn twelve() -> Curve {
    let space = Space::clamped(3, &(0..=9).map(f64::from).collect::<Vec<_>>()).unwrap();
    let points = (0..12)
        .map(|i| Point::new(f64::from(i), (f64::from(i) * 0.9).sin(), 0.1 * f64::from(i % 3)))
        .collect();
    Curve::new(space, points).unwrap()
}

#[test]
fn vertices_named_by_number_are_refused_within_an_interval() {
    let curve = twelve();
    let push = || Edit::new(&curve).within(3.5, 6.0).ask(position(4.5).by([0.0, 0.5, 0.0]));
    let one = || linear([(4, Vector::x())]);
    let cases: [(Edit<Curve>, &str); 4] = [
        (push().ask(vertex(4).keep()), "\"vertex 4\""),
        (push().ask(vertex(-1).by([0.0, 1.0, 0.0])), "\"vertex -1\""),
        (push().ask(one().keep()), "\"linear in vertices 4\""),
        (push().handle(vertex(4)), "\"vertex 4\""),
    ];
    for (edit, name) in cases {
        let message = edit.prepare(Automatic).unwrap_err().to_string();
        let why = format!("renumbers control vertices, so that {name} would mean others: ask for a position");
        assert!(message.contains(&why), "{message}");
    }
    // Those of another shape keep their numbers.
    let other: Box<dyn Shape> = Box::new(twelve());
    push().with(other).ask(vertex(4).on(1).keep()).ask(one().on(1).keep()).solve().unwrap();
}

#[test]
fn what_stands_still_unasked_is_told_and_let_go() {
    let curve = twelve();
    let end = 9.0;
    let lift = [0.0, 0.3, 0.1];
    let ask = || Edit::new(&curve).ask(curvature(end).scale(1.5)).ask(vertex(-1).by(lift));
    let message = ask().solve().unwrap_err().to_string();
    let told = "(\"position at 9\" stands still beside \"curvature at 9\" unless asked for: to let it go, ask for it and say";
    assert!(message.contains(told), "{message}");
    let freed = ask().ask(position(end).by(lift)).solve().unwrap();
    let moved = freed.shape().point(end).unwrap() - curve.point(end).unwrap();
    assert!((moved - Vector::from(lift)).norm() < 1e-12, "{moved}");
    // What the user asks for himself is not called a companion.
    let own = ask().ask(position(end).keep()).solve().unwrap_err().to_string();
    assert!(own.contains("\"position at 9\"") && !own.contains("stands still"), "{own}");
}

#[test]
fn a_bound_on_a_curvature_says_what_to_use() {
    let bounded = Edit::new(&twelve()).ask(curvature(4.5).at_most(0.2)).solve().unwrap_err().to_string();
    assert!(bounded.contains("\"at_most\" gives 1 number where 2 are needed; it is a vector"), "{bounded}");
    assert!(bounded.contains("ask for the signed-curvature, which takes bounds"), "{bounded}");
    let flat = [0.0, 0.0, 1.0];
    let mut planar = twelve();
    planar.control_vertices_mut().iter_mut().for_each(|p| p.z = 0.0);
    let edited = Edit::new(&planar).ask(signed_curvature(4.5, flat).at_most(-5.0)).solve().unwrap();
    let shapes: [&dyn Shape; 1] = [edited.shape()];
    let mut value = [0.0];
    signed_curvature(4.5, flat).value(&Shapes::new(shapes), &mut value).unwrap();
    assert!(value[0] <= -5.0 + 1e-9, "{value:?}");
    let vector = Edit::new(&twelve()).ask(position(4.5).at_most(0.2)).solve().unwrap_err().to_string();
    assert!(vector.ends_with("where 3 are needed; to bound one of them, narrow it to an axis"), "{vector}");
}

/// A word that is nearly right in a location's table is told as such, whichever of the words it is.
#[test]
fn a_location_s_words_are_known_by_their_neighbours() {
    for (typed, meant) in [("closst", "closest"), ("vertx", "vertex"), ("fac", "face")] {
        let fields = serde_json::json!({ "at": { typed: [0.0, 1.0, 2.0] } });
        let parameters = loftsman_kernel::plugin::Parameters::new(fields, "step[0]").unwrap();
        let refused = parameters.location("at").unwrap_err().to_string();
        assert!(refused.contains(&format!("did you mean \"{meant}\"?")), "{refused}");
    }
}
