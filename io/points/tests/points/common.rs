//! What the tests share.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Format, FormatError, Memory, Parameters, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_points::Points;

pub(crate) type Read = Result<(Scene, ReadReport), FormatError>;

pub(crate) fn read(name: &str, bytes: impl Into<Vec<u8>>) -> Read {
    Points.read(&Memory::new(name, bytes), &ReadOptions::default())
}

/// Reads with the option `as`.
pub(crate) fn read_as(name: &str, bytes: impl Into<Vec<u8>>, kind: &str) -> Read {
    let own = Parameters::new(serde_json::json!({ "as": kind }), "options").unwrap();
    Points.read(&Memory::new(name, bytes), &ReadOptions { own, ..ReadOptions::default() })
}

/// The one polyline of a file: its points, and whether it is closed.
#[track_caller]
pub(crate) fn polyline(scene: &Scene) -> (&[Point], bool) {
    let [object] = scene.objects() else { panic!("{} objects", scene.objects().len()) };
    match object.geometry() {
        Geometry::Polyline(line) => (&line.points, line.closed),
        other => panic!("a {}", other.kind()),
    }
}

/// The one object's points as plain numbers.
#[track_caller]
pub(crate) fn coordinates(scene: &Scene) -> Vec<[f64; 3]> {
    let [object] = scene.objects() else { panic!("{} objects", scene.objects().len()) };
    object.geometry().points().iter().map(|p| [p.x, p.y, p.z]).collect()
}

#[track_caller]
pub(crate) fn says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is missing in: {message}");
    }
    assert!(message.chars().count() < 400, "too long: {message}");
}
