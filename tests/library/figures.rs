//! The figures of "Smooth constraints for spline variational modeling" (Lenoir and others 2004), from the examples' own recipes: what each of
//! them is there to show.

use loftsman::kernel::scene::{Geometry, Scene};
use loftsman::kernel::shape::{Derivative, Shape};
use loftsman::kernel::spline::{Curve, Surface};
use loftsman::kernel::{Point, Vector};
use loftsman::recipe::{Applied, Recipe, Runner};
use serde_json::json;

/// The recipe of an example.
fn recipe(name: &str) -> Recipe {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    Recipe::read(folder.join("recipe.toml")).unwrap()
}

fn applied(recipe: &Recipe) -> Applied {
    Runner::new(loftsman::registry()).apply(recipe).unwrap()
}

fn curve<'s>(scene: &'s Scene, name: &str) -> &'s Curve {
    match scene.object(name).unwrap().geometry() {
        Geometry::Curve(curve) => curve,
        other => panic!("{name} is a {}", other.kind()),
    }
}

fn frames<'s>(scene: &'s Scene, name: &str) -> &'s [Vec<Point>] {
    &scene.object(name).unwrap().animation.as_ref().unwrap().frames
}

fn at_frame(of: &Curve, frame: &[Point]) -> Curve {
    Curve::new(of.space().clone(), frame.to_vec()).unwrap()
}

/// Where a constraint ended on its shape.
fn location(applied: &Applied, step: usize, name: &str) -> Vec<f64> {
    let all = &applied.steps[step].constraints;
    let found = all.iter().find(|c| c.name == name).unwrap_or_else(|| panic!("{name} of {all:?}"));
    assert!(found.residual < 1e-6, "{found:?}");
    found.location.clone().unwrap()
}

/// Figure 2: through a sliding middle the rope gives way until both sides of it are stretched alike; a fixed one keeps them apart.
#[test]
fn a_sliding_middle_is_stretched_alike_on_both_sides_and_a_fixed_one_is_not() {
    let applied = applied(&recipe("papers/lenoir/figure-2"));
    let scene = &applied.scene;
    let rope = curve(scene, "rope");
    // On the whole between two places: its own length there, and that at rest.
    let stretch = |name: &str, a: f64, b: f64| {
        let long = |curve: &Curve| curve.length_between(a, b, 1e-6).unwrap().value;
        long(curve(scene, name)) / long(rope) / 0.8
    };
    // Between where it is pulled and its middle, and behind that.
    let fixed = [stretch("fixed", 4.0, 6.0), stretch("fixed", 6.0, 12.0)];
    assert!(fixed[0] > 1.2 * fixed[1], "{fixed:?}");
    let middle = location(&applied, 2, "middle")[0];
    let sliding = [stretch("sliding", 4.0, middle), stretch("sliding", middle, 12.0)];
    assert!((sliding[0] / sliding[1] - 1.0).abs() < 0.01, "{sliding:?}");
    // So that what holds the middle has nothing to hold but the corner that the rope makes there.
    let force = |step: usize| {
        let middle = applied.steps[step].constraints.iter().find(|c| c.name == "middle").unwrap();
        Vector::from_column_slice(&middle.multipliers).norm()
    };
    assert!(force(2) < 0.01 * force(1), "{} {}", force(2), force(1));
    // The rope went through the middle to the side where it is pulled, and its middle is still there.
    assert!(middle > 6.5, "{middle}");
    let place = rope.point(6.0).unwrap();
    for (name, at) in [("fixed", 6.0), ("sliding", middle)] {
        assert!((curve(scene, name).point(at).unwrap() - place).norm() < 1e-8, "{name}");
    }
}

/// Figure 3: the loop of the noose closes as its standing part is pulled through the running knot; the peg stays in it.
#[test]
fn a_noose_closes_round_its_peg() {
    let mut recipe = recipe("papers/lenoir/figure-3");
    recipe.steps.truncate(1);
    let applied = applied(&recipe);
    let rope = curve(&applied.scene, "rope");
    let size = 10.0;
    let [slides, stays] = location(&applied, 0, "knot")[..] else { panic!("two places") };
    assert_eq!(stays, 0.0);
    let met = (rope.point(slides).unwrap() - rope.point(0.0).unwrap()).norm();
    assert!(met < 1e-6 * size, "the rope leaves its knot by {met:e}");
    let peg = location(&applied, 0, "peg")[0];
    assert!((rope.point(peg).unwrap() - Point::new(0.0, 0.0, -3.9)).norm() < 1e-6 * size);
    // The loop, from the knot round the peg and back, grows shorter.
    let all = frames(&applied.scene, "rope");
    let loops: Vec<f64> = [0, 24, 48, 72]
        .map(|k| {
            let now = at_frame(rope, &all[k]);
            let end = now.point(0.0).unwrap();
            // The parameter beside the knot, behind the peg: where it comes nearest to the end of the rope.
            let places = (0..=4000).map(|i| 8.0 + f64::from(i) * 0.005);
            let near = |u: f64| (now.point(u).unwrap() - end).norm();
            let at = places.min_by(|a, b| near(*a).total_cmp(&near(*b))).unwrap();
            now.length_between(0.0, at, 1e-6).unwrap().value
        })
        .to_vec();
    assert!(loops[1] < 0.9 * loops[0] && loops[2] < 0.5 * loops[1], "{loops:?}");
    // Then it is tight.
    assert!((loops[3] / loops[2] - 1.0).abs() < 0.01 && loops[3] < 0.4 * loops[0], "{loops:?}");
}

/// Figure 4: at each of the times at which the handle comes by a place of its path, the curve passes it, by whichever part suits best.
#[test]
fn a_curve_follows_the_handle_that_slides_along_it() {
    let applied = applied(&recipe("papers/lenoir/figure-4"));
    let object = applied.scene.objects()[0].name().to_owned();
    let wave = curve(&applied.scene, &object);
    let all = frames(&applied.scene, &object);
    let path = [[0.0, 0.0], [-1.0, 1.4], [0.5, 2.2], [2.0, 1.6]].map(|[x, z]| Point::new(x, 0.0, z));
    let mut places = Vec::new();
    // Four places in 2.5 seconds of 24 frames; the first is drawn in, the last is kept.
    for (frame, place) in [(20, 1), (40, 2), (60, 3), (72, 3)] {
        let near = at_frame(wave, &all[frame]).closest(path[place]).unwrap();
        assert!(near.distance < 1e-5 * 8.0, "frame {frame}: {:e} from {}", near.distance, path[place]);
        places.push(near.at);
    }
    let most = places.iter().fold(0.0_f64, |most, u| most.max((u - places[0]).abs()));
    assert!(most > 0.2, "it does not slide: {places:?}");
    assert!((location(&applied, 0, "handle")[0] - places[3]).abs() < 1e-4, "{places:?}");
}

/// Figure 5: the sheet slides through its three points, so that it bends and hardly stretches; where they are fixed on it, it stretches.
#[test]
fn a_sheet_slides_through_its_points() {
    let mut recipe = recipe("papers/lenoir/figure-5");
    let stretch = |applied: &Applied| {
        let Geometry::Surface(after) = applied.scene.objects()[0].geometry() else { panic!("no surface") };
        let Geometry::Surface(before) = applied.before.objects()[0].geometry() else { panic!("no surface") };
        let speed =
            |of: &Surface, u: f64, v: f64, way: Derivative| of.value([u, v].into(), way).unwrap().norm();
        let mut most = 0.0_f64;
        for (i, j) in (0..=16).flat_map(|i| (0..=16).map(move |j| (i, j))) {
            let (u, v) = (0.25 * f64::from(i), 0.25 * f64::from(j));
            for way in [Derivative { u: 1, v: 0 }, Derivative { u: 0, v: 1 }] {
                most = most.max((speed(after, u, v, way) / speed(before, u, v, way) - 1.0).abs());
            }
        }
        most
    };
    let slid = applied(&recipe);
    let Geometry::Surface(sheet) = slid.scene.objects()[0].geometry() else { panic!("no surface") };
    let mut moved = 0.0_f64;
    for (name, near, place) in [
        ("first", [1.0, 3.0], [1.5, 4.5, 1.2]),
        ("second", [3.0, 1.0], [4.5, 1.5, 1.2]),
        ("third", [2.33, 2.33], [3.5, 3.5, 0.2]),
    ] {
        let [u, v] = location(&slid, 0, name)[..] else { panic!("two parameters") };
        let off = (sheet.point(u, v).unwrap() - Point::from(place)).norm();
        assert!(off < 1e-6 * 6.0, "{name}: {off:e}");
        moved = moved.max((u - near[0]).abs()).max((v - near[1]).abs());
    }
    assert!(moved > 0.02, "nothing slides: {moved}");
    let corner = sheet.point(0.0, 0.0).unwrap();
    assert!(corner.coords.norm() < 1e-8, "{corner}");
    // It bends: it is far from flat.
    let high = sheet.points().iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(high > 1.2, "{high}");
    for table in recipe.steps[0]["constraints"].as_array_mut().unwrap() {
        if table["kind"] == "sliding" {
            table["kind"] = json!("fixed");
            table["at"] = table["near"].clone();
            table.as_object_mut().unwrap().remove("near");
        }
    }
    let held = applied(&recipe);
    let (slid, held) = (stretch(&slid), stretch(&held));
    assert!(slid < 0.9 * held, "{slid} sliding, {held} fixed");
}

/// Figure 1: the far end passes the twelfth hole first and the first last, and the lace is in none of them after that.
#[test]
fn a_lace_leaves_its_holes_in_their_order() {
    let mut recipe = recipe("shoelace");
    recipe.steps.truncate(1);
    let applied = applied(&recipe);
    let report = &applied.steps[0];
    let left: Vec<(f64, &str)> = report
        .notes
        .iter()
        .filter_map(|note| {
            let (time, rest) = note.split_once(" s: \"")?;
            Some((time.parse().ok()?, rest.strip_suffix("\": it left the shape")?))
        })
        .collect();
    let wanted: Vec<String> = (1..=12).rev().map(|k| format!("hole {k}")).collect();
    let names: Vec<&str> = left.iter().map(|(_, name)| *name).collect();
    assert_eq!(names, wanted, "{:?}", report.notes);
    assert!(left.windows(2).all(|pair| pair[0].0 < pair[1].0), "{left:?}");
    // None of them holds any more, and the hand does.
    for constraint in &report.constraints {
        assert_eq!(constraint.location.is_some(), constraint.name == "hand", "{constraint:?}");
    }
    // All of the lace is on the hand's side of the first hole: it was drawn out.
    let lace = curve(&applied.scene, "lace");
    let last = lace.points().iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
    assert!(last < -0.11, "{last}");
    let hand: Vector = lace.point(0.0).unwrap() - Point::new(-0.9, -24.0, 0.0);
    assert!(hand.norm() < 1e-4, "{hand}");
}
