//! Shapes of plug-ins that are not here: kept word for word, or refused where they are no shapes.

use std::fmt::Write as _;

use loftsman_kernel::scene::{Geometry, Scene};

use super::common::{read, write};

/// A document with shapes of two kinds that nobody knows, shared, animated, in a definition and at the top.
fn document() -> String {
    let mut points = String::new();
    for k in 0..40 {
        let comma = if k == 0 { "" } else { "," };
        let _ = write!(points, "{comma}\n            [{k}, -0.0, 1e-400]");
    }
    format!(
        r#"{{
  "loftsman": 1,
  "unit": "mm",
  "up": "z",
  "definitions": [
    {{
      "name": "part",
      "objects": [
        {{
          "name": "first",
          "shape": {{ "kind": "loop \"é\"", "points": [{points}
          ],  "deep": {{"a": [null, true, {{}}]}} , "b": 123456789012345678901234567890 }}
        }},
        {{
          "name": "second",
          "same_as": {{
            "object": "first"
          }}
        }}
      ]
    }}
  ],
  "objects": [
    {{
      "name": "third",
      "color": [0.5, 0.25, 1, 1],
      "shape": {{"kind":"net"}},
      "animation": {{
        "rate": 24,
        "frames": [
          [
            [1, 2, 3],
            [4, 5, 6]
          ]
        ]
      }}
    }}
  ]
}}
"#
    )
}

fn unknown(scene: &Scene) -> Vec<&str> {
    let defined = scene.definitions().iter().flat_map(|d| d.objects());
    let custom = defined.chain(scene.objects()).filter(|o| o.geometry().is_unknown());
    custom.map(|o| o.geometry().kind()).collect()
}

#[test]
fn they_come_out_as_they_went_in() {
    let text = document();
    let (scene, report) = read(text.as_str()).unwrap();
    assert_eq!(unknown(&scene), ["loop \"é\"", "loop \"é\"", "net"]);
    assert!(report.adds_up() && report.kept == 3);
    assert_eq!(report.notes.len(), 2, "{report:?}");
    assert!(report.notes.iter().all(|note| note.contains("word for word")));
    assert_eq!(String::from_utf8(write(&scene)).unwrap(), text);
    // A copy shares it, and another one of the same words is equal.
    let (again, _) = read(write(&scene)).unwrap();
    assert_eq!(again, scene);
    let mut copies = scene.clone();
    let copy = scene.object("third").unwrap().renamed("fourth");
    copies.add(copy).unwrap();
    let (twice, _) = read(write(&copies)).unwrap();
    assert_eq!(twice, copies);
    let Geometry::Custom(custom) = scene.object("third").unwrap().geometry() else {
        panic!("a custom shape")
    };
    assert_eq!(custom.text(), Some(r#"{"kind":"net"}"#));
    assert!(custom.fields().unwrap_err().to_string().contains("\"net\", whose plug-in is not here"));
}

#[test]
fn what_is_no_shape_is_refused() {
    let many: String = (0..2000).map(|k| format!(", \"f{k}\": {k}")).collect();
    let deep = format!("{}1{}", "[".repeat(300), "]".repeat(300));
    for (shape, words) in [
        ("3".to_owned(), "expected a shape"),
        ("{}".to_owned(), "needs the field \"kind\""),
        (r#"{ "kind": "" }"#.to_owned(), "needs the field \"kind\""),
        (r#"{ "kind": ["a"] }"#.to_owned(), "name of a kind of shape is needed"),
        (r#"{ "kind": "a", "x": 1, "x": 2 }"#.to_owned(), "\"x\" is there twice"),
        (format!(r#"{{ "kind": "a"{many} }}"#), "more fields"),
        (r#"{ "kind": "a", "x": NaN }"#.to_owned(), "NaN"),
        (r#"{ "kind": "a", "x": [1, }"#.to_owned(), "not JSON"),
    ] {
        let text = format!(r#"{{ "loftsman": 1, "objects": [{{ "name": "o", "shape": {shape} }}] }}"#);
        let error = read(text).unwrap_err().to_string();
        assert!(error.contains("objects[0].shape") && error.contains(words), "{error}");
    }
    // Nobody looks into what is deep: it is kept, or refused, but read without end.
    let text = format!(
        r#"{{ "loftsman": 1, "objects": [{{ "name": "o", "shape": {{ "kind": "a", "x": {deep} }} }}] }}"#
    );
    match read(text) {
        Ok((scene, _)) => assert_eq!(unknown(&scene), ["a"]),
        Err(error) => assert!(error.to_string().contains("too deeply"), "{error}"),
    }
    let both = r#"{ "loftsman": 1, "objects": [{ "name": "o", "group": {}, "shape": { "kind": "a" } }] }"#;
    assert!(read(both).unwrap_err().to_string().contains("an object of its own"));
}
