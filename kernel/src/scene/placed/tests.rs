//! What instances show, by matrices by hand.

use super::*;
use crate::mesh::Cloud;
use crate::scene::placement::transform_point;
use crate::scene::{Unit, Up};
use crate::{Point, Vector};

fn instance_of(name: &str, of: &str, by: Option<Matrix4<f64>>) -> Object {
    let mut object = Object::new(name, Geometry::Instance(of.into()));
    object.transform = by;
    object
}

fn dot(name: &str) -> Object {
    Object::new(name, Cloud { points: vec![Point::new(1.0, 0.0, 0.0)] }.into())
}

fn shift(x: f64, y: f64, z: f64) -> Option<Matrix4<f64>> {
    Some(Matrix4::new_translation(&Vector::new(x, y, z)))
}

/// A wheel has a rim and two bolts, a car a body and two wheels under it, one of them turned and twice as large.
fn cars() -> Scene {
    let mut scene = Scene::new();
    let mut bolt = Definition::new("bolt");
    bolt.add(dot("head")).unwrap();
    let mut wheel = Definition::new("wheel");
    let mut rim = dot("rim");
    rim.parent = Some("hub".into());
    wheel.add(rim).unwrap();
    let mut hub = Object::new("hub", Geometry::Group);
    hub.transform = shift(0.0, 0.0, 5.0);
    wheel.add(hub).unwrap();
    for (k, x) in [(1, 10.0), (2, 20.0)] {
        let mut bolt = instance_of(&format!("bolt {k}"), "bolt", shift(x, 0.0, 0.0));
        bolt.parent = Some("hub".into());
        bolt.color = (k == 2).then_some([1.0, 0.0, 0.0, 1.0]);
        wheel.add(bolt).unwrap();
    }
    // Used before it is defined: the order of definitions does not matter.
    scene.define(wheel).unwrap();
    scene.define(bolt).unwrap();
    scene.add(dot("body")).unwrap();
    scene.add(instance_of("left", "wheel", shift(0.0, 100.0, 0.0))).unwrap();
    // (x, y, z) → (-2 y, 2 x, 2 z + 1000).
    #[rustfmt::skip]
    let turned = Matrix4::new(
        0.0, -2.0, 0.0, 0.0,
        2.0,  0.0, 0.0, 0.0,
        0.0,  0.0, 2.0, 1000.0,
        0.0,  0.0, 0.0, 1.0,
    );
    let mut right = instance_of("right", "wheel", Some(turned));
    right.parent = Some("body".into());
    right.layer = Some("wheels".into());
    scene.add(right).unwrap();
    scene.check().unwrap();
    scene
}

/// By hand: (1, 0, 0) goes by the bolt's shift, the hub's, and that of the wheel.
const PLACES: [(&str, &str, Option<[f64; 3]>); 13] = [
    ("", "body", Some([1.0, 0.0, 0.0])),
    ("", "left", None),
    ("left", "rim", Some([1.0, 100.0, 5.0])),
    ("left", "hub", None),
    ("left", "bolt 1", None),
    ("left/bolt 1", "head", Some([11.0, 100.0, 5.0])),
    ("left", "bolt 2", None),
    ("left/bolt 2", "head", Some([21.0, 100.0, 5.0])),
    ("", "right", None),
    ("right", "rim", Some([0.0, 2.0, 1010.0])),
    ("right", "hub", None),
    ("right/bolt 1", "head", Some([0.0, 22.0, 1010.0])),
    ("right/bolt 2", "head", Some([0.0, 42.0, 1010.0])),
];

#[test]
fn instances_show_their_objects_where_matrices_by_hand_say() {
    let scene = cars();
    let mut found: Vec<_> = scene.placed(15).unwrap().collect();
    assert_eq!((found.len(), scene.placed_count().unwrap()), (15, 15));
    assert_eq!(scene.placed(15).unwrap().size_hint(), (15, Some(15)));
    // The bolts of the right wheel come as those of the left do.
    found.retain(|p| !(p.path.to_string() == "right" && p.object.name().starts_with("bolt")));
    for (placed, (path, name, at)) in found.iter().zip(PLACES) {
        assert_eq!((placed.path.to_string().as_str(), placed.object.name()), (path, name));
        assert_eq!(placed.path.depth(), path.split('/').filter(|p| !p.is_empty()).count());
        if let Some([x, y, z]) = at {
            let p = placed.object.geometry().points()[0];
            let p = placed.to_world.map_or(p, |map| transform_point(&map, &p));
            assert_eq!(p, Point::new(x, y, z), "{path}/{name}");
        }
    }
    let red: Vec<_> = found.iter().filter(|p| p.color().is_some()).map(|p| p.path.to_string()).collect();
    assert_eq!(red, ["left", "left/bolt 2", "right/bolt 2"]);
    assert_eq!(found.iter().filter(|p| p.layer() == Some("wheels")).count(), 5);
}

#[test]
fn a_flat_scene_shows_the_same_and_shares_geometry() {
    let scene = cars();
    let flat = scene.flattened(100).unwrap();
    flat.check().unwrap();
    assert!(flat.definitions().is_empty() && flat.objects().len() == 15);
    let maps = flat.world_transforms().unwrap();
    for (placed, (object, map)) in scene.placed(100).unwrap().zip(flat.objects().iter().zip(maps)) {
        let within = if placed.path.depth() > 0 { format!("{}/", placed.path) } else { String::new() };
        assert_eq!(object.name(), format!("{within}{}", placed.object.name()));
        assert_eq!(map, placed.to_world, "{}", object.name());
        let points = placed.object.geometry().points();
        assert_eq!(object.geometry().points(), points);
        assert!(points.is_empty() || object.geometry_id() == placed.object.geometry_id());
    }
    let head = flat.object("right/bolt 2/head").unwrap();
    assert_eq!((head.color, head.layer.as_deref()), (Some([1.0, 0.0, 0.0, 1.0]), Some("wheels")));
    assert_eq!(head.parent.as_deref(), Some("right/bolt 2"));
    assert_eq!(flat.object("right/bolt 2").unwrap().parent.as_deref(), Some("right/hub"));
    assert_eq!(flat.object("right").unwrap().parent.as_deref(), Some("body"));
    // Labels go along, with those of the instances.
    let mut labelled = scene.clone();
    let wheel = labelled.definition_mut("wheel").unwrap();
    for name in ["bolt 1", "bolt 2"] {
        wheel.object_mut(name).unwrap().label = Some("bolt".into());
    }
    labelled.object_mut("body").unwrap().label = Some("car".into());
    let flat = labelled.flattened(100).unwrap();
    let labels = |name: &str| flat.object(name).unwrap().label();
    assert_eq!((labels("right/bolt 2/head"), labels("right/bolt 1")), ("right/bolt/head", "right/bolt"));
    assert_eq!((labels("body"), labels("right/rim")), ("car", "right/rim"));
    assert_eq!(flat.object("right/rim").unwrap().label, None);
    // A name that is taken already.
    let mut scene = scene;
    scene.add(dot("left/rim")).unwrap();
    let flat = scene.flattened(100).unwrap();
    assert!(flat.get("left/rim").is_some() && flat.get("left/rim.001").is_some());
    assert_eq!(flat.get("left/rim").unwrap().parent, None);
    // Definitions go along into another unit.
    let there = scene.converted(Unit::Millimetre, Up::Y).unwrap();
    for (a, b) in scene.placed(100).unwrap().zip(there.placed(100).unwrap()) {
        let Some(p) = a.object.geometry().points().first() else { continue };
        let at = |placed: &Placed<'_>, p: &Point| placed.to_world.map_or(*p, |m| transform_point(&m, p));
        let (p, q) = (at(&a, p), at(&b, &b.object.geometry().points()[0]));
        assert!((Point::new(p.x, p.z, -p.y) * 1000.0 - q).norm() < 1e-9, "{p} {q}");
    }
}

#[test]
fn circles_and_what_is_missing_are_refused_by_name() {
    let mut scene = cars();
    scene.definition_mut("bolt").unwrap().add(instance_of("inner", "wheel", None)).unwrap();
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("\"wheel\" → \"bolt\" → \"wheel\""), "{error}");
    assert!(scene.placed(100).is_err() && scene.flattened(100).is_err() && scene.placed_count().is_err());
    let mut scene = cars();
    scene.definition_mut("bolt").unwrap().add(instance_of("nut", "nut", None)).unwrap();
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("in the definition \"bolt\": \"nut\" shows the definition \"nut\""), "{error}");
    let mut scene = Scene::new();
    scene.add(instance_of("a", "b", None)).unwrap();
    assert!(scene.check().unwrap_err().to_string().contains("\"a\" shows the definition \"b\""));
    let mut definition = Definition::new("b");
    let mut lost = dot("lost");
    lost.parent = Some("a".into());
    definition.add(lost).unwrap();
    scene.define(definition).unwrap();
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("in the definition \"b\": the parent \"a\" of \"lost\""), "{error}");
    assert!(scene.define(Definition::new("b")).is_err() && scene.define(Definition::new("")).is_err());
    assert!(scene.definition("c").is_err());
}

#[test]
fn doubling_is_counted_and_not_done() {
    // Each shows the one before it twice: 2^100 dots.
    let mut scene = Scene::new();
    for k in 0..100 {
        let mut definition = Definition::new(format!("{k}"));
        if k == 0 {
            definition.add(dot("dot")).unwrap();
        } else {
            let below = format!("{}", k - 1);
            definition.add(instance_of("a", &below, shift(1.0, 0.0, 0.0))).unwrap();
            definition.add(instance_of("b", &below, None)).unwrap();
        }
        scene.define(definition).unwrap();
    }
    scene.add(instance_of("all", "99", None)).unwrap();
    scene.check().unwrap();
    assert_eq!(scene.placed_count().unwrap(), u64::MAX);
    let error = scene.placed(1_000_000).unwrap_err().to_string();
    assert!(error.contains("more than 10^19") && error.contains("1000000"), "{error}");
    scene.object_mut("all").unwrap().set_geometry(Geometry::Instance("3".into()));
    // 8 dots and 1 + 2 + 4 + 8 instances.
    assert_eq!(scene.placed_count().unwrap(), 8 + 15);
    assert!(scene.placed(22).unwrap_err().to_string().contains("show 23 objects"));
    assert_eq!(scene.placed(23).unwrap().count(), 23);
}

#[test]
fn nesting_may_be_deeper_than_a_stack() {
    let (deep, mut scene) = (100_000, Scene::new());
    for k in 0..deep {
        let mut definition = Definition::new(format!("{k}"));
        let next = if k + 1 < deep {
            instance_of("i", &format!("{}", k + 1), shift(1.0, 0.0, 0.0))
        } else {
            dot("d")
        };
        definition.add(next).unwrap();
        scene.define(definition).unwrap();
    }
    scene.add(instance_of("top", "0", None)).unwrap();
    scene.check().unwrap();
    let last = scene.placed(1_000_000).unwrap().last().unwrap();
    assert_eq!((last.object.name(), last.path.depth()), ("d", deep));
    assert_eq!(last.to_world.unwrap()[(0, 3)], (deep - 1) as f64);
    assert_eq!(last.path.inside_out().count(), deep);
    // Their names would be the square of that.
    assert!(scene.flattened(1_000).is_err());
    assert!(scene.flattened(200_000).unwrap_err().to_string().contains("names"));
    // Of the first, the paths that lead to all others go with the last of them.
    drop(last);
    assert!(format!("{:?}", scene.placed(1_000_000).unwrap().nth(1000).unwrap().path).len() > 1000);
}

/// What says nothing of its looks has the colour of the nearest instance; a colour, a material or coloured points of its own
/// are something.
#[test]
fn colours_come_from_above_where_nothing_of_ones_own_is_said() {
    let [red, blue] = [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    let mut scene = Scene::new();
    let mut bolt = Definition::new("bolt");
    bolt.add(dot("plain")).unwrap();
    let mut own = dot("own");
    own.color = Some(blue);
    bolt.add(own).unwrap();
    let mut steel = dot("steel");
    steel.materials = vec!["steel".into()];
    bolt.add(steel).unwrap();
    scene.define(bolt).unwrap();
    let mut shown = instance_of("shown", "bolt", None);
    shown.color = Some(red);
    scene.add(shown).unwrap();
    let colors: Vec<_> = scene.placed(9).unwrap().map(|p| (p.object.name().to_owned(), p.color())).collect();
    let color = |name: &str| colors.iter().find(|(n, _)| n == name).unwrap().1;
    assert_eq!((color("plain"), color("own"), color("steel")), (Some(red), Some(blue), None));
}
