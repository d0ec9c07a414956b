//! Colours to the last bit, and definitions in their order, from a document through a file back to it.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Polyline;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use nalgebra::Matrix4;

fn there_and_back(scene: &Scene) -> (String, Scene) {
    let mut memory = Memory::new("t.step", Vec::new());
    Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    let (back, report) =
        Step.read(&Memory::new("t.step", memory.bytes.as_slice()), &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    (String::from_utf8(memory.bytes).unwrap(), back)
}

fn block() -> Geometry {
    Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0)).unwrap().into()
}

fn colored(name: String, geometry: Geometry, color: [f64; 4]) -> Object {
    let mut object = Object::new(name, geometry);
    object.color = Some(color);
    object
}

/// Instances of definitions where they stand, each of another colour.
fn instance(name: &str, of: &str, at: f64) -> Object {
    let mut object = Object::new(name, Geometry::Instance(of.to_owned()));
    object.transform = Some(Matrix4::new_translation(&Vector::new(at, 0.0, 0.0)));
    object
}

fn told(scene: &Scene) -> Vec<String> {
    let list = |objects: &[Object]| -> Vec<String> {
        let one = |o: &Object| format!("{} {:?} {:?} {:?}", o.name(), o.color, o.layer, o.transform);
        objects.iter().map(one).collect()
    };
    let mut all = list(scene.objects());
    for definition in scene.definitions().iter() {
        all.push(format!("definition {}", definition.name()));
        all.extend(list(definition.objects()));
    }
    let layer = |l: &Layer| format!("layer {} {:?} {} {:?}", l.name(), l.color, l.visible, l.parent);
    all.extend(scene.layers.iter().map(layer));
    all
}

#[test]
fn a_document_of_definitions_colours_and_layers_comes_back_as_it_was() {
    let mut scene = Scene::new();
    // The first shows the last, and is shown after the second.
    let mut pair = Definition::new("pair");
    pair.add(instance("one", "bolt", 0.5)).unwrap();
    pair.add(instance("other", "bolt", 4.0)).unwrap();
    let mut nut = Definition::new("nut");
    nut.add(colored("nut".to_owned(), block(), [0.1, 0.7, 0.9, 1.0])).unwrap();
    let mut bolt = Definition::new("bolt");
    let mut first = colored("shaft".to_owned(), block(), [0.3, 1.0 / 3.0, 0.8, 0.3]);
    first.layer = Some("a".to_owned());
    bolt.add(first).unwrap();
    bolt.add(colored("head".to_owned(), block(), [0.123_456_789_012_345_67, 0.99, 0.01, 0.05])).unwrap();
    for definition in [pair, nut, bolt] {
        scene.define(definition).unwrap();
    }
    scene.layers.add(Layer::new("a").colored([0.2, 0.4, 0.6, 1.0])).unwrap();
    for object in [
        instance("right", "nut", 9.0),
        instance("left", "nut", -9.0),
        instance("both", "pair", 1.0),
        instance("again", "pair", 2.0),
        instance("single", "bolt", 3.0),
    ] {
        scene.add(object).unwrap();
    }
    let (_, back) = there_and_back(&scene);
    assert_eq!(told(&back), told(&scene));
}

#[test]
fn colours_come_back_to_the_bit() {
    let mut scene = Scene::new();
    let line = || Polyline { points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0)], closed: false };
    for k in 0..500 {
        let light = |by: f64| (f64::from(k) * by).fract();
        // Golden and silver ratios, e: they hit nothing twice; then tenths.
        let [r, g, b] =
            [0.618_033_988_749_894_9, 0.414_213_562_373_095_1, 0.718_281_828_459_045_1].map(light);
        let alpha = 1.0 - 0.9 * g;
        let color =
            if k % 2 == 0 { [r, g, b, alpha] } else { [r, g, b, alpha].map(|c| (10.0 * c).round() / 10.0) };
        scene.add(colored(format!("solid {k}"), block(), color)).unwrap();
        // Curves have no opacity.
        let opaque = [color[0], color[1], color[2], 1.0];
        scene.add(colored(format!("line {k}"), line().into(), opaque)).unwrap();
    }
    let (text, back) = there_and_back(&scene);
    for (before, after) in scene.objects().iter().zip(back.objects()) {
        assert_eq!(before.color, after.color, "{}", before.name());
    }
    // Where the numbers alone say it, as most of those that files have, nothing is added.
    assert!(text.contains("COLOUR_RGB('',") && text.contains("COLOUR_RGB('linear "));
    let (again, _) = there_and_back(&back);
    assert_eq!(again, text, "a second writing");
}

#[test]
fn a_colour_that_somebody_changed_is_the_one_that_its_numbers_say() {
    let mut scene = Scene::new();
    scene.add(colored("block".to_owned(), block(), [0.3, 0.3, 0.3, 0.2])).unwrap();
    let (text, _) = there_and_back(&scene);
    let at = text.find("COLOUR_RGB('linear 0.3 0.3 0.3 0.2',").unwrap();
    let end = at + text[at..].find(';').unwrap();
    let changed = format!("{}COLOUR_RGB('linear 0.3 0.3 0.3 0.2',1.,0.,0.){}", &text[..at], &text[end..]);
    let (back, _) = Step.read(&Memory::new("t.step", changed.as_bytes()), &ReadOptions::default()).unwrap();
    assert_eq!(back.objects()[0].color, Some([1.0, 0.0, 0.0, 0.2]));
}
