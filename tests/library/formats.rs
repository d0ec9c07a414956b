//! What all formats have in common: kinds of errors, limits, cancellation, what is lost and said beforehand.

use std::borrow::Cow;
use std::io::{self, Write};

use loftsman::kernel::conformance::sample_scene;
use loftsman::kernel::mesh::Cloud;
use loftsman::kernel::plugin::{
    Format, FormatError, FormatErrorKind, Limits, Memory, Observer, Parameters, ReadOptions, Sink, Source,
    WriteOptions,
};
use loftsman::kernel::scene::{Object, Scene, Unit};
use loftsman::kernel::{Point, Result};
use serde_json::json;

/// Each format that comes with Loftsman, and what it makes of the sample scene.
fn written() -> Vec<(&'static dyn Format, Memory)> {
    let each = loftsman::registry().formats().iter().map(|format| {
        let mut memory = Memory::new(format!("a.{}", format.declaration().extensions[0]), "");
        format.write(&sample_scene(), &mut memory, &WriteOptions::default()).unwrap();
        (format.as_ref(), memory)
    });
    each.collect()
}

fn options() -> ReadOptions<'static> {
    ReadOptions::default()
}

/// Wants nothing from the start.
struct Never;

impl Observer for Never {
    fn cancelled(&self) -> bool {
        true
    }
}

/// A file on a disk that is full.
struct Full;

impl Write for Full {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        Err(io::Error::new(io::ErrorKind::StorageFull, "the disk is full"))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for Full {
    fn name(&self) -> &str {
        "full"
    }

    fn main(&mut self) -> &mut dyn Write {
        self
    }

    fn sibling(&mut self, _: &str) -> Result<&mut dyn Write, FormatError> {
        Ok(self)
    }
}

#[test]
fn errors_say_of_which_kind_they_are_and_name_the_file() {
    for (format, memory) in written() {
        let name = format.declaration().name;
        let check = |error: FormatError, kind: FormatErrorKind, file: &str| {
            assert_eq!((error.kind, error.file.as_str()), (kind, file), "{name}: {error}");
            error.problem
        };
        let read = |options: &ReadOptions<'_>| format.read(&memory, options).unwrap_err();
        let own = Parameters::new(json!({ "no such": 1 }), "options").unwrap();
        let problem = check(read(&ReadOptions { own, ..options() }), FormatErrorKind::Option, &memory.name);
        assert!(problem.contains(name) && problem.contains("no such"), "{problem}");
        for limits in [
            Limits { bytes: 10, ..Limits::default() },
            Limits { entities: 2, ..Limits::default() },
            Limits { depth: 0, ..Limits::default() },
        ] {
            check(read(&ReadOptions { limits, ..options() }), FormatErrorKind::Limit, &memory.name);
        }
        let watched = ReadOptions { observer: &Never, ..options() };
        assert_eq!(check(read(&watched), FormatErrorKind::Cancelled, &memory.name), "cancelled");
        let watched = WriteOptions { observer: &Never, ..WriteOptions::default() };
        let stopped = format.write(&sample_scene(), &mut memory.clone(), &watched).unwrap_err();
        check(stopped, FormatErrorKind::Cancelled, &memory.name);
        let mut empty = memory.clone();
        empty.bytes.clear();
        check(format.read(&empty, &options()).unwrap_err(), FormatErrorKind::Malformed, &memory.name);
        let full = format.write(&sample_scene(), &mut Full, &WriteOptions::default()).unwrap_err();
        assert!(check(full, FormatErrorKind::Io, "full").contains("the disk is full"));
        let wide = Memory::new("wide", [0xFF, 0xFE, b'v', 0, b' ', 0, b'1', 0]);
        if name != "obj" {
            check(format.read(&wide, &options()).unwrap_err(), FormatErrorKind::Unsupported, "wide");
        }
    }
}

/// A file whose siblings may not be read.
struct Locked(Memory);

impl Source for Locked {
    fn name(&self) -> &str {
        &self.0.name
    }

    fn bytes(&self) -> &[u8] {
        &self.0.bytes
    }

    fn sibling(&self, name: &str) -> Result<Cow<'_, [u8]>, FormatError> {
        Err(FormatError::whole(format!("{name}: permission denied")).as_kind(FormatErrorKind::Io))
    }
}

#[test]
fn a_sound_scene_is_refused_as_what_the_format_cannot_hold() {
    let mut scene = Scene::new();
    let far = Cloud { points: vec![Point::new(f64::NAN, 0.0, 0.0)] };
    scene.add(Object::new("dust", far.into())).unwrap();
    for (format, mut memory) in written() {
        let error = format.write(&scene, &mut memory, &WriteOptions::default()).unwrap_err();
        assert_eq!(error.kind, FormatErrorKind::Unsupported, "{error}");
        assert!(error.to_string().contains("\"dust\""), "{error}");
    }
    scene.object_mut("dust").unwrap().parent = Some("nobody".into());
    for (format, mut memory) in written() {
        let error = format.write(&scene, &mut memory, &WriteOptions::default()).unwrap_err();
        assert_eq!(error.kind, FormatErrorKind::Malformed, "{error}");
    }
}

#[test]
fn a_library_that_may_not_be_read_is_said_to_be_that() {
    let text = "mtllib my own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let source = Locked(Memory::new("a.obj", text));
    let (_, report) = loftsman::obj::Obj.read(&source, &options()).unwrap();
    assert!(report.left_out.keys().any(|why| why.contains("permission denied")), "{report:?}");
}

#[test]
fn units_are_noted_as_they_were_asked_for() {
    for (format, memory) in written() {
        let (stated, _) = format.read(&memory, &options()).unwrap();
        let other = if stated.unit == Unit::Inch { Unit::Foot } else { Unit::Inch };
        let asked = ReadOptions { unit: Some(other), ..options() };
        let (noted, report): (Scene, _) = format.read(&memory, &asked).unwrap();
        assert_eq!(noted.unit, other);
        let said = report.notes.iter().any(|note| note.contains("as asked for"));
        // Nothing is contradicted where the file says nothing.
        assert_eq!(said, stated.unit == Unit::Millimetre, "{}: {report:?}", format.declaration().name);
    }
}
