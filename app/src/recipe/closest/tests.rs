//! Places that are pointed at: found on the right object, told, and refused.

use loftsman_kernel::plugin::{Context, Declaration, OperationError, StepReport, editable, object_name};
use loftsman_kernel::scene::Object;
use loftsman_kernel::spline::{Curve, Space};

use super::*;

fn scene() -> Scene {
    let mut scene = Scene::new();
    let arch = |y: f64| {
        let points =
            [(-1.0, 0.0), (-1.0, y), (1.0, y), (1.0, 0.0)].map(|(x, y)| Point::new(x, y, 0.0)).to_vec();
        Curve::new(Space::clamped_uniform(3, 4).unwrap(), points).unwrap()
    };
    scene.add(Object::new("arch", arch(2.0).into())).unwrap();
    scene.add(Object::new("low", arch(-1.0).into())).unwrap();
    scene
}

/// An operation that takes some fields, or points beside them.
struct Takes(&'static [Field], bool);

impl Operation for Takes {
    fn declaration(&self) -> Declaration {
        Declaration { name: "takes", help: "", fields: self.0 }
    }

    fn object(&self, scene: &Scene, p: &Parameters) -> std::result::Result<String, ParameterError> {
        let fits = editable(scene);
        let fits = |g: &Geometry| if self.1 { matches!(g, Geometry::Polyline(_)) } else { fits(g) };
        object_name(scene, p, fits, "polyline or curve")
    }

    fn apply(
        &self,
        _: &mut Scene,
        _: &Parameters,
        _: &Context<'_>,
    ) -> std::result::Result<StepReport, OperationError> {
        Ok(StepReport::default())
    }
}

const DECLARED: Takes = Takes(FIELDS_OF_IT, false);
const FIELDS_OF_IT: &[Field] = &[
    Field::optional("at", "number, or { closest = [x, y, z] }", "", ""),
    Field::optional("u", "number, { closest = [x, y, z] }, or a list", "", ""),
    Field::optional("v", "number, { closest = [x, y, z] }, or a list", "", ""),
    Field::optional("within", "[from, to], each a number or { closest = [x, y, z] }", "", ""),
    Field::optional("knots", "[number or { closest = [x, y, z] }, …]", "", ""),
    Field::optional("range", "[[from, to], [from, to]], each a number or { closest = [x, y, z] }", "", ""),
];

fn resolved(step: Value) -> std::result::Result<(Value, Vec<String>), String> {
    let mut notes = Vec::new();
    let fields = Parameters::new(step, "step[0]").unwrap();
    let found = resolve(&scene(), &fields, &DECLARED, &mut notes).map_err(|e| e.to_string())?;
    Ok((Value::Object(found.into_map()), notes))
}

#[test]
fn a_place_is_found_on_the_object_that_its_table_names() {
    let step = json!({ "object": "arch", "constraints": [
        { "at": { "closest": [0, 9, 0] }, "to": { "closest": [0, 0, 0] } },
        { "at": 0.25, "with": { "object": "low", "at": { "closest": [-1, 0.1, 0] } } },
        { "near": [{ "closest": [1, -1, 0] }, 0.5] },
    ] });
    let (found, notes) = resolved(step).unwrap();
    let constraints = &found["constraints"];
    assert_eq!(constraints[0]["at"], json!(0.5));
    // What is no location is left for the operation to refuse.
    assert_eq!(constraints[0]["to"], json!({ "closest": [0, 0, 0] }));
    assert_eq!((&constraints[1]["at"], &constraints[1]["with"]["at"]), (&json!(0.25), &json!(0.0)));
    assert_eq!(constraints[2]["near"], json!([1.0, 0.5]));
    assert_eq!(notes.len(), 3, "{notes:?}");
    assert!(notes[1].contains("constraints[1].with.at = 0 on \"low\""), "{notes:?}");
    assert!(notes.iter().all(|note| !note.contains("as near")), "{notes:?}");
}

/// What slides starts near its shape: a point farther off than that is large is a mistake, told with the distance; of other places the nearest is meant wherever the point is.
#[test]
fn what_starts_near_is_not_far_off() {
    for (x, y, far) in [(0.0, 2.9, false), (50.0, 1.0, true), (1e9, 0.0, true)] {
        for field in ["near", "other_near", "at"] {
            let mut constraint = json!({ "kind": "tied" });
            constraint[field] = json!({ "closest": [x, y, 0] });
            let found = resolved(json!({ "object": "arch", "constraints": [constraint] }));
            assert_eq!(found.is_err(), far && field != "at", "{field} {x}: {found:?}");
            if let Err(message) = found {
                let told = [
                    if x < 100.0 { "49" } else { "999999999" },
                    " away from (",
                    "farther than all of it is large (2 ",
                ];
                assert!(told.iter().all(|told| message.contains(told)), "{message}");
            }
        }
    }
}

/// Where the operation's declaration takes a coordinate or something else, what is pointed at is left for it to refuse.
#[test]
fn what_is_declared_otherwise_is_no_location() {
    let step = json!({ "object": "arch", "range": [{ "closest": [0.5, 0, 0] }, 1] });
    let fields = Parameters::new(step.clone(), "step[0]").unwrap();
    const RANGE: &[Field] = &[Field::optional("range", "[low, high]", "", "")];
    let curvatures = Takes(RANGE, false);
    let mut notes = Vec::new();
    let found = Value::Object(resolve(&scene(), &fields, &curvatures, &mut notes).unwrap().into_map());
    assert_eq!((&found, notes.len()), (&step, 0));
    // In the tables of a step names say what is a location.
    let step = json!({ "object": "arch", "constraints": [{ "axis": "x", "at": { "closest": [0, 9, 0] } }] });
    assert_eq!(resolved(step).unwrap().0["constraints"][0]["at"], json!(0.5));
}

#[test]
fn intervals_and_knots_may_be_pointed_at() {
    let step = json!({ "object": "arch", "within": [{ "closest": [-1, 0.1, 0] }, { "closest": [0, 9, 0] }],
        "knots": [{ "closest": [0, 9, 0] }, 0.75] });
    let (found, notes) = resolved(step).unwrap();
    assert_eq!((&found["within"][1], &found["knots"]), (&json!(0.5), &json!([0.5, 0.75])), "{notes:?}");
    assert!(notes[1].starts_with("within[1] = 0.5 on \"arch\""), "{notes:?}");
}

/// Of a surface the location is both parameters, along a direction one.
#[test]
fn a_place_of_a_surface_has_two_parameters_or_one() {
    let mut scene = Scene::new();
    let points = (0..16).map(|k| Point::new((k / 4) as f64, (k % 4) as f64, 0.0)).collect();
    let space = || Space::clamped_uniform(3, 4).unwrap();
    let sheet = loftsman_kernel::spline::Surface::new(space(), space(), points).unwrap();
    scene.add(Object::new("sheet", sheet.into())).unwrap();
    let at = json!({ "closest": [0.75, 2.25, 5] });
    for (step, wanted) in [
        (json!({ "at": at }), json!([0.25, 0.75])),
        (json!({ "at": at, "direction": "u" }), json!(0.25)),
        (json!({ "at": at, "direction": "v" }), json!(0.75)),
        (json!({ "range": [[0, at], [at, 1]] }), json!([[0, 0.25], [0.75, 1]])),
        // An isocurve's own field is one parameter.
        (json!({ "u": at }), json!(0.25)),
        (json!({ "v": [at], "direction": "u" }), json!([0.75])),
    ] {
        let mut notes = Vec::new();
        let fields = Parameters::new(step, "step[0]").unwrap();
        let found = resolve(&scene, &fields, &DECLARED, &mut notes).unwrap();
        let place = found.names().next().unwrap().to_owned();
        assert_eq!(found.value(&place), Some(&wanted), "{notes:?}");
        // The sheet is 3 wide.
        let told =
            format!("(0.75, 2.25, 5), {} away, farther than all of it is large", scene.unit.quantity(5.0, 1));
        assert!(notes[0].ends_with(&told), "{notes:?}");
    }
}

/// Of points that are to be fitted: by the length of their polygon.
#[test]
fn a_place_among_points_is_one_along_their_polygon() {
    let points = [[0.0, 0.0], [3.0, 0.0], [3.0, 0.0], [3.0, 4.0]].map(|[x, y]| Point::new(x, y, 0.0));
    for (closed, length) in [(false, 7.0), (true, 12.0)] {
        // With a curve beside them, which is not what is fitted.
        let mut scene = scene();
        let line = Polyline { points: points.to_vec(), closed };
        scene.add(Object::new("p", line.into())).unwrap();
        for (place, so_far, away) in [([3.5, 1.0], 4.0, 0.5), ([1.0, -2.0], 1.0, 2.0), ([9.0, 4.0], 7.0, 6.0)]
        {
            let mut notes = Vec::new();
            let step = json!({ "constraints": [{ "at": { "closest": [place[0], place[1], 0] } }] });
            let fields = Parameters::new(step, "step[0]").unwrap();
            let found = Value::Object(
                resolve(&scene, &fields, &Takes(FIELDS_OF_IT, true), &mut notes).unwrap().into_map(),
            );
            let at = found["constraints"][0]["at"].as_f64().unwrap();
            assert!((at - so_far / length).abs() < 1e-9, "{at} {notes:?}");
            assert!(notes[0].contains(&scene.unit.quantity(away, 1)), "{notes:?}");
        }
    }
    let mut scene = Scene::new();
    let still = Polyline { points: vec![Point::origin(); 3], closed: false };
    scene.add(Object::new("p", still.into())).unwrap();
    let step = json!({ "at": { "closest": [0, 0, 0] } });
    let fields = Parameters::new(step, "step[0]").unwrap();
    let refused =
        resolve(&scene, &fields, &Takes(FIELDS_OF_IT, true), &mut Vec::new()).unwrap_err().to_string();
    assert!(refused.contains("no length"), "{refused}");
}

#[test]
fn places_as_near_are_told() {
    let (found, notes) = resolved(json!({ "object": "arch", "at": { "closest": [0, 0.2, 0] } })).unwrap();
    assert!(found["at"].is_number() && notes[0].contains("as near"), "{found} {notes:?}");
}

#[test]
fn what_is_no_place_says_why() {
    for (at, object, words) in [
        (json!({ "closest": [1, 2] }), "arch", "step[0].at.closest: [1,2] where [x, y, z] is needed"),
        (json!({ "closest": [1, 2, 3], "u": 1 }), "arch", "step[0].at: \"u\" stands beside closest"),
        (json!({ "closest": [1, 2, 3] }), "arc", "arc"),
    ] {
        let error = resolved(json!({ "object": object, "at": at })).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    let error = resolved(json!({ "at": { "closest": [1, 2, 3] } })).unwrap_err();
    assert!(error.contains("say which object it is about"), "{error}");
}

/// A place that is a knot is that knot, to the last bit, and is told as it is: another one beside it would be a corner. Others have nine digits.
#[test]
fn a_knot_that_is_pointed_at_stays_that_knot() {
    for inner in [2.0 / 9.0, 1.0 / 3.0, 0.7] {
        let knots = [0.0, 0.0, 0.0, 0.0, inner, 1.0, 1.0, 1.0, 1.0].map(|u: f64| 100.0 * u - 3.0);
        let inner = knots[4];
        let points = [(0.0, 0.0), (1.0, 2.0), (3.0, 2.5), (5.0, 1.0), (6.0, 0.0)];
        let points: Vec<Point> = points.iter().map(|(x, y)| Point::new(*x, *y, 0.3 * x)).collect();
        let curve = Curve::new(Space::open(3, knots.to_vec()).unwrap(), points).unwrap();
        let at = |u: f64| {
            let found = nearest(&curve.clone().into(), curve.point(u).unwrap()).unwrap();
            let Location::Curve(found) = found.at else { panic!("a curve") };
            found
        };
        assert_eq!(at(inner), inner);
        let beside = inner + 1.234_567_890_123e-3;
        assert!(at(beside) != inner && (at(beside) - beside).abs() < 1e-7, "{} {beside}", at(beside));
        assert_eq!([knots[0], knots[8]].map(at), [knots[0], knots[8]]);
        let surface =
            loftsman_kernel::spline::Surface::extrusion(&curve, loftsman_kernel::Vector::z()).unwrap();
        let found = nearest(&surface.clone().into(), surface.point(inner, 0.5).unwrap()).unwrap();
        assert!(matches!(found.at, Location::Surface(u, _) if u == inner), "{:?}", found.at);
    }
}
