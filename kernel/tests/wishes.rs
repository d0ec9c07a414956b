//! What may be wanted of what, as recipes write it: conditions hold when they are kept, numbers that cannot be are refused with
//! the reason, and nothing is swallowed.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{
    ShapeNames, curvature, magnitude, normal, orthogonal, position, present_normal, tangent,
};
use loftsman_kernel::plugin::{Parameters, Registry, constraint_from};
use loftsman_kernel::shape::{Derivative, Shape};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use serde_json::{Value, json};

/// The curve of the reproduction.
fn curve() -> Curve {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 2.0, 0.0],
        [2.0, -1.0, 1.0],
        [3.0, 2.0, 0.0],
        [4.0, 0.0, -1.0],
        [5.0, 2.0, 0.0],
        [6.0, 0.0, 0.0],
        [7.0, 1.0, 0.0],
    ];
    Curve::new(Space::clamped(3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap(), points.map(Point::from).to_vec())
        .unwrap()
}

fn surface() -> Surface {
    let space = || Space::clamped(2, &[0.0, 1.0, 2.0]).unwrap();
    let net = (0..16).map(|k| {
        let (i, j) = (f64::from(k / 4), f64::from(k % 4));
        Point::new(i, j, 0.3 * (i * 1.3).sin() + 0.2 * j * j)
    });
    Surface::build(space(), space(), net.collect(), None).unwrap()
}

struct Nobody;

impl ShapeNames for Nobody {
    fn shape(&mut self, _: &str) -> Result<usize> {
        Err(Error::Invalid("there is but one object".into()))
    }
}

fn solved<S: Shape + Clone>(shape: &S, constraints: &[Value]) -> Result<S, String> {
    let mut registry = Registry::new();
    loftsman_kernel::plugin::register_functionals(&mut registry);
    let mut edit = Edit::new(shape);
    for constraint in constraints {
        let table = Parameters::new(constraint.clone(), "step[0].constraints[0]").unwrap();
        edit = edit.ask(constraint_from(&registry, &table, &mut Nobody).map_err(|e| e.to_string())?);
    }
    Ok(edit.solve().map_err(|e| e.to_string())?.shape().clone())
}

#[test]
fn a_tangent_with_a_direction_is_made_parallel_when_it_is_kept() {
    for u in [0.0, 0.7, 2.0, 2.5, 5.0] {
        for direction in [[1.0, 0.0, 0.0], [0.3, -2.0, 1.0], [0.0, 0.0, 7.0]] {
            let way = Vector::from(direction).normalize();
            let kept = json!({ "kind": "tangent", "at": u, "direction": direction, "keep": true });
            let said = json!({ "kind": "tangent", "at": u, "direction": direction });
            let [kept, said] = [kept, said].map(|c| solved(&curve(), &[c]).unwrap());
            let first = kept.derivative(u, 1).unwrap();
            assert!(first.cross(&way).norm() < 1e-13, "{first}");
            assert!(curve().derivative(u, 1).unwrap().normalize().cross(&way).norm() > 0.1);
            assert_eq!(kept, said, "keep = true is how conditions are said, too");
            let from_rust = Edit::new(&curve()).ask(tangent(u).direction(direction).keep()).solve().unwrap();
            assert_eq!(from_rust.shape(), &kept);
        }
    }
}

#[test]
fn so_are_normals_and_what_is_orthogonal() {
    let to = Vector::new(0.4, -0.3, 1.0);
    let kept = solved(
        &surface(),
        &[json!({ "kind": "normal", "at": [0.7, 1.2], "to": [0.4, -0.3, 1.0], "keep": true })],
    );
    let kept = kept.unwrap();
    for order in [[1, 0], [0, 1]] {
        let along = Shape::value(&kept, [0.7, 1.2].into(), Derivative::from(order)).unwrap();
        assert!(along.dot(&to).abs() < 1e-13, "{along}");
    }
    let from_rust = Edit::new(&surface()).ask(normal([0.7, 1.2], to).keep()).solve().unwrap();
    assert_eq!(from_rust.shape(), &kept);

    // A normal without a direction keeps the one that it has, while its place and others move.
    let normal_of = |s: &Surface| {
        let [u, v] =
            [[1, 0], [0, 1]].map(|o| Shape::value(s, [0.7, 1.2].into(), Derivative::from(o)).unwrap());
        u.cross(&v).normalize()
    };
    let moved = [
        json!({ "kind": "position", "at": [0.7, 1.2], "by": [0, 0.2, 0.5] }),
        json!({ "kind": "position", "at": [0.5, 1.0], "by": [0, 0, -0.2] }),
    ];
    let kept = json!({ "kind": "normal", "at": [0.7, 1.2], "keep": true });
    let turned = (normal_of(&solved(&surface(), &moved).unwrap()) - normal_of(&surface())).norm();
    assert!(turned > 0.05, "{turned}");
    let both = solved(&surface(), &[moved[0].clone(), moved[1].clone(), kept]).unwrap();
    assert!((normal_of(&both) - normal_of(&surface())).norm() < 1e-12);
    let from_rust = Edit::new(&surface())
        .ask(position([0.7, 1.2]).by([0.0, 0.2, 0.5]))
        .ask(position([0.5, 1.0]).by([0.0, 0.0, -0.2]))
        .ask(present_normal([0.7, 1.2]).keep())
        .solve()
        .unwrap();
    assert_eq!(from_rust.shape(), &both);

    let kept = solved(&curve(), &[json!({ "kind": "orthogonal", "at": 2.5, "to": [1, 0, 0], "keep": true })])
        .unwrap();
    assert!(kept.derivative(2.5, 1).unwrap().x.abs() < 1e-14);
    let from_rust = Edit::new(&curve()).ask(orthogonal(2.5, [1.0, 0.0, 0.0]).keep()).solve().unwrap();
    assert_eq!(from_rust.shape(), &kept);
    // A tangent without a direction keeps the one that it has.
    let kept = solved(
        &curve(),
        &[
            json!({ "kind": "tangent", "at": 2.5, "keep": true }),
            json!({ "kind": "position", "at": 2.2, "by": [0, 1, 0] }),
        ],
    );
    let (old, new) = (curve().derivative(2.5, 1).unwrap(), kept.unwrap().derivative(2.5, 1).unwrap());
    assert!(old.cross(&new).norm() < 1e-13);
}

#[test]
fn a_tangent_holds_or_does_not() {
    for (wish, value) in [
        ("by", json!([0.1, 0.2])),
        ("by", json!(0.1)),
        ("scale", json!(2)),
        ("to", json!([1, 0, 0])),
        ("to", json!([0, 0])),
        ("at_least", json!([0, 0])),
        ("at_most", json!([1, 1])),
    ] {
        for direction in [None, Some([1.0, 0.0, 0.0])] {
            let mut table = json!({ "kind": "tangent", "at": 2.5 });
            table[wish] = value.clone();
            if let Some(direction) = direction {
                table["direction"] = json!(direction);
            }
            let error = solved(&curve(), &[table]).unwrap_err();
            assert!(
                error.contains("tangent at 2.5")
                    && error.contains(&format!("\"{wish}\""))
                    && error.contains("`direction`"),
                "{error}"
            );
        }
    }
}

#[test]
fn magnitudes_are_positive() {
    for table in [
        json!({ "kind": "magnitude", "at": 2.5, "to": 0 }),
        json!({ "kind": "magnitude", "at": 2.5, "to": -1 }),
        json!({ "kind": "magnitude", "at": 2.5, "scale": -1 }),
        json!({ "kind": "magnitude", "at": 2.5, "scale": 0 }),
        json!({ "kind": "magnitude", "at": 2.5, "by": -1000 }),
        json!({ "kind": "magnitude", "at": 2.5, "at_most": -1 }),
    ] {
        let error = solved(&curve(), &[table]).unwrap_err();
        assert!(error.contains("tangent magnitude at 2.5") && error.contains("a length of"), "{error}");
    }
    let longer = Edit::new(&curve()).ask(magnitude(2.5).to(3.0)).solve().unwrap();
    assert!((longer.shape().derivative(2.5, 1).unwrap().norm() - 3.0).abs() < 1e-12);
}

#[test]
fn numbers_that_do_not_fit_name_the_field() {
    let of = |table: Value| solved(&curve(), &[table]).unwrap_err();
    let error = of(json!({ "kind": "position", "at": 2.5, "to": [1, 2] }));
    assert!(error.contains("\"to\" gives 2 numbers where 3 are needed"), "{error}");
    let error = of(json!({ "kind": "derivative", "at": 2.5, "by": 1 }));
    assert!(error.contains("\"by\" gives 1 number where 3 are needed"), "{error}");
    let error = of(json!({ "kind": "curvature", "at": 2.5, "to": [1, 2, 3] }));
    assert!(error.contains("\"to\" gives 3 numbers where 2 are needed"), "{error}");
    let error = of(json!({ "kind": "curvature", "at": 2.5, "at_least": 1 }));
    assert!(error.contains("\"at_least\" gives 1 number where 2 are needed"), "{error}");
}

#[test]
fn kinds_of_curves_say_so_on_surfaces() {
    for kind in ["tangent", "magnitude", "curvature", "signed-curvature", "orthogonal"] {
        let mut table = json!({ "kind": kind, "at": [0.5, 0.5], "keep": true });
        if kind == "orthogonal" {
            table["to"] = json!([1, 0, 0]);
        }
        let error = solved(&surface(), &[table]).unwrap_err();
        assert!(error.contains("asked of a curve") && error.contains("[0.5, 0.5]"), "{kind}: {error}");
    }
    let error = solved(&curve(), &[json!({ "kind": "normal", "at": 0.5, "to": [1, 0, 0] })]).unwrap_err();
    assert!(error.contains("surface's normal"), "{error}");
}

#[test]
fn a_curvature_may_be_one_number() {
    let kappa = |c: &Curve| {
        let (first, second) = (c.derivative(2.5, 1).unwrap(), c.derivative(2.5, 2).unwrap());
        first.cross(&second) / first.norm().powi(3)
    };
    let old = kappa(&curve());
    for to in [0.7, 3.0, -1.5, 0.0] {
        for stretched in [false, true] {
            let mut asked = vec![json!({ "kind": "curvature", "at": 2.5, "to": to })];
            if stretched {
                asked.push(json!({ "kind": "derivative", "at": 2.5, "scale": 1.7 }));
            }
            let new = kappa(&solved(&curve(), &asked).unwrap());
            assert!((new - old.normalize() * to).norm() < 1e-11, "{to}: {new} of {old}");
            let from_rust = Edit::new(&curve()).ask(curvature(2.5).to(to)).solve().unwrap();
            assert!((kappa(from_rust.shape()) - old.normalize() * to).norm() < 1e-11);
        }
    }
}

#[test]
fn a_location_is_given_or_floats() {
    let to = [3.1, 0.4, 0.2];
    let ask = |places: Value| {
        let mut table = json!({ "kind": "position", "to": to });
        for (name, value) in places.as_object().unwrap() {
            table[name] = value.clone();
        }
        solved(&curve(), &[table])
    };
    let (at, near) = (ask(json!({ "at": 2.4 })).unwrap(), ask(json!({ "near": 2.4 })).unwrap());
    assert!((at.point(2.4).unwrap() - Point::from(to)).norm() < 1e-13 && at != near);
    let both = ask(json!({ "at": 2.4, "near": 2.4 })).unwrap_err();
    assert!(both.contains("\"at\"") && both.contains("give one of them"), "{both}");
    assert!(ask(json!({})).unwrap_err().contains("a location is needed"));
}
