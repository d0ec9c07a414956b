//! Solids that stand in a file exactly and as triangles: they are in the scene once.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use crate::common::read;
use loftsman_kernel::scene::Scene;

/// A tetrahedron with what stands beside it: in place of `WITH` in its representation, and as data.
fn tetrahedron(beside: &str, data: &str) -> (Vec<String>, String) {
    let path = format!("{}/../../tests/data/step/tet.step", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let (list, end) = ("(#11,#150)", "ENDSEC;\nEND-ISO");
    assert!(text.contains(list) && text.contains(end));
    let text = text.replace(list, &format!("(#11,#150{beside})"));
    let (scene, report) = read(&text.replace(end, &format!("{data}{end}"))).unwrap();
    assert!(report.adds_up());
    let told = report.notes.into_iter().chain(report.left_out.into_keys()).collect::<Vec<_>>().join("\n");
    (kinds(&scene), told)
}

fn kinds(scene: &Scene) -> Vec<String> {
    scene
        .objects()
        .iter()
        .map(|object| object.geometry().kind().to_owned())
        .filter(|kind| kind != "group")
        .collect()
}

/// Its triangles, so many times as large, with what the solid and the face say that they stand for.
fn triangles(size: f64, solid: &str, face: &str) -> String {
    let c = |x: f64| format!("{:?}", size * x);
    let (a, b) = (c(-1.0), c(1.0));
    format!(
        "#901=TESSELLATED_SOLID('',(#902),{solid});\n\
         #902=TRIANGULATED_FACE('',#903,4,(),{face},(),((1,2,3),(1,3,4),(1,4,2),(2,4,3)));\n\
         #903=COORDINATES_LIST('',4,(({a},{a},{b}),({b},{a},{a}),({b},{b},{b}),({a},{b},{a})));\n"
    )
}

/// The same in a representation of its own, which no product has.
fn alone() -> &'static str {
    "#904=TESSELLATED_SHAPE_REPRESENTATION('',(#901),#143);\n"
}

#[test]
fn the_tessellation_of_a_solid_that_is_read_exactly_is_left_out_and_told() {
    // As Open CASCADE writes it: in the product's representation, and again in one that no product has.
    let (found, told) = tetrahedron(",#901", &(triangles(1.0, "#11", "$") + alone()));
    assert_eq!(found, ["brep"], "{told}");
    assert!(told.contains("#901 (TESSELLATED_SOLID), line "), "{told}");
    assert!(told.contains("the tessellation of #11, which it names and which is read exactly"), "{told}");
    assert!(told.contains("tessellations of what is read exactly"), "{told}");
    // In either place alone.
    let (found, told) = tetrahedron(",#901", &triangles(1.0, "#11", "$"));
    assert_eq!(found, ["brep"], "{told}");
    let (found, told) = tetrahedron("", &(triangles(1.0, "#11", "$") + alone()));
    assert_eq!(found, ["brep"], "{told}");
    // Through a relation with the product's own representation.
    let related = format!("{}#905=SHAPE_REPRESENTATION_RELATIONSHIP('','',#144,#904);\n", alone());
    let (found, told) = tetrahedron("", &(triangles(1.0, "$", "$") + &related));
    assert_eq!(found, ["brep"], "{told}");
    assert!(told.contains("what its product has exactly, too, and is as large"), "{told}");
}

#[test]
fn triangles_that_stand_for_something_else_are_kept() {
    // Half as large as the solid of their product.
    let (found, told) = tetrahedron(",#901", &triangles(0.5, "$", "$"));
    assert_eq!(found, ["brep", "mesh"], "{told}");
    // In the product and in a representation of no product: once.
    let (found, told) = tetrahedron(",#901", &(triangles(0.5, "$", "$") + alone()));
    assert_eq!(found, ["brep", "mesh"], "{told}");
    // Of no product, and with no word of what they stand for.
    let (found, told) = tetrahedron("", &(triangles(1.0, "$", "$") + alone()));
    assert_eq!(found, ["brep", "mesh"], "{told}");
}

#[test]
fn the_tessellation_of_a_solid_that_is_not_read_whole_is_kept() {
    let path = format!("{}/../../tests/data/step/tet.step", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let end = "ENDSEC;\nEND-ISO";
    let data = triangles(1.0, "#11", "$") + alone() + end;
    let text = text.replace(end, &data);
    // A face on no surface; then the whole shell missing.
    for (from, to, wanted) in [
        (
            "#14=ADVANCED_FACE('',(#18),#54,.T.);",
            "#14=ADVANCED_FACE('',(#18),#14,.T.);",
            vec!["brep", "mesh"],
        ),
        ("#13=CLOSED_SHELL", "#913=CLOSED_SHELL", vec!["mesh"]),
    ] {
        assert!(text.contains(from));
        let (scene, report) = read(&text.replace(from, to)).unwrap();
        assert!(report.adds_up());
        assert_eq!(kinds(&scene), wanted, "{report:?}");
    }
}
