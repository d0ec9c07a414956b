//! Bytes that are wrong: an error with its line, or a report; never a panic, never a hang.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use crate::common::{AXES, file, read};
use loftsman_kernel::conformance::{format_conformance, sample_scene};
use loftsman_kernel::plugin::{Format, Memory, Place, ReadOptions};
use loftsman_step::Step;

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/step/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Reads bytes: a scene that is sound, or an error that says something.
fn survives(bytes: &[u8]) -> bool {
    match Step.read(&Memory::new("t.step", bytes), &ReadOptions::default()) {
        Ok((scene, report)) => {
            assert!(report.adds_up());
            scene.check().unwrap();
            let finite = scene.objects().iter().flat_map(|o| o.geometry().points());
            assert!(finite.flat_map(|p| p.iter()).all(|c| c.is_finite()));
            true
        }
        Err(error) => {
            assert!(error.file == "t.step" && !error.problem.is_empty(), "{error}");
            false
        }
    }
}

#[test]
fn it_is_a_format() {
    let verdict = format_conformance(&Step, &sample_scene());
    assert!(verdict.passed(), "{verdict}");
}

#[test]
fn every_beginning_of_a_file_is_refused_as_cut_off() {
    for name in ["revolved_sphere.step", "face.stp"] {
        let bytes = data(name);
        let whole = bytes.len() - bytes.iter().rev().position(|&b| b == b';').unwrap();
        for end in 0..whole - "END-ISO-10303-21;".len() {
            assert!(!survives(&bytes[..end]), "{name} to byte {end}");
        }
        assert!(survives(&bytes));
    }
}

#[test]
fn without_any_one_entity_the_rest_is_read_or_refused() {
    for name in ["revolved_sphere.step", "face.stp", "tet.step", "red_cube_blue_cylinder.step"] {
        let text = String::from_utf8(data(name)).unwrap();
        let starts: Vec<usize> = text.match_indices("\n#").map(|(at, _)| at).collect();
        let mut read = 0;
        for &start in &starts {
            let end = start + text[start..].find(';').unwrap() + 1;
            read += usize::from(survives(format!("{}{}", &text[..start], &text[end..]).as_bytes()));
        }
        assert!(read * 4 > starts.len(), "{name}: {read} of {}", starts.len());
    }
}

#[test]
fn references_that_lead_elsewhere_do_no_harm() {
    for name in ["revolved_sphere.step", "tet.step", "face.stp"] {
        let text = String::from_utf8(data(name)).unwrap();
        let places: Vec<usize> = text.match_indices('#').map(|(at, _)| at).collect();
        for (k, &at) in places.iter().enumerate() {
            let end = at + 1 + text[at + 1..].find(|c: char| !c.is_ascii_digit()).unwrap();
            if text[end..].trim_start().starts_with('=') {
                continue;
            }
            // To itself, to another, to nothing.
            let itself = text[..at].rfind("\n#").map_or("1", |line| {
                let line = &text[line + 2..];
                &line[..line.find(|c: char| !c.is_ascii_digit()).unwrap()]
            });
            let other = (k * 7919 % places.len() + 1).to_string();
            for number in [itself, &other, "999999999999"] {
                survives(format!("{}#{number}{}", &text[..at], &text[end..]).as_bytes());
            }
        }
    }
}

#[test]
fn what_is_broken_in_the_text_is_named_with_its_line() {
    let good = file("#100", "#100=GEOMETRIC_SET('',(#101));\n#101=CARTESIAN_POINT('',(0.,0.,0.));");
    assert!(survives(good.as_bytes()));
    for (from, to, says) in [
        ("ISO-10303-21;", "ISO-10303-28;", "does not begin"),
        ("END-ISO-10303-21;", "", "cut off"),
        ("ENDSEC;\nEND", "END", "END"),
        ("#101=CART", "#101 CART", "behind #101"),
        ("#101=", "#=", "without the number"),
        ("('',(#101));", "('',(#101))", "#101"),
        ("'thing'", "'thing", "text"),
        ("#101=CART", "/* #101=CART", "comment"),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good);
        // Without a point there is nothing left in it; text that ends in the middle is told with its line.
        let error = read(&bad).unwrap_err();
        let told = error.to_string();
        assert!(told.contains(says) || told.contains("nothing in it"), "{from} {to}: {told}");
    }
    let cut = &good[..good.find("(0.,").unwrap()];
    let error = read(cut).unwrap_err();
    assert_eq!(error.place, Place::Line(15), "{error}");
    assert!(error.problem.contains("#101") && error.problem.contains("cut off"), "{error}");
}

#[test]
fn an_entity_at_fault_is_left_out_with_its_number_and_line() {
    let item = |bad: &str| {
        let data = format!("{AXES}#100=GEOMETRIC_SET('',(#101,#102));\n#101=CIRCLE('',#10,1.);\n#102={bad};");
        let (scene, report) = read(&file("#100", &data)).unwrap();
        assert_eq!(scene.objects().len(), 1, "{bad}");
        report.left_out.into_keys().chain(report.notes).collect::<Vec<_>>().join("\n")
    };
    for (bad, says) in [
        ("CARTESIAN_POINT('',(1.,2.))", "2 coordinates where 3 are needed"),
        ("CARTESIAN_POINT('',(1.,2.,.T.))", ".T. where a coordinate is needed"),
        ("CARTESIAN_POINT('',(1.,2.,1.E999))", "is no number that can be computed with"),
        ("CIRCLE('',#10)", "2 attributes where 3"),
        ("CIRCLE('',#10,-1.)", "must be positive"),
        ("CIRCLE('',#10,#11)", "where a number is needed"),
        ("CIRCLE('',#11,1.)", "AXIS2_PLACEMENT_3D is needed"),
        ("CIRCLE('',#4711,1.)", "is not in the file"),
        ("LINE('',#11,#103)", "is not in the file"),
        ("TRIMMED_CURVE('',#102,(#11),(#11),.T.,.CARTESIAN.)", "lies in itself"),
        ("COMPOSITE_CURVE('',(#102),.F.)", "needed"),
        ("COMPOSITE_CURVE('',(),.F.)", "without segments"),
        ("POLYLINE('',(#11,7))", "a list of entities"),
        ("B_SPLINE_CURVE_WITH_KNOTS('',3,(#11,#11),.U.,.F.,.F.,(4,4),(0.,1.),.U.)", "8 knots do not fit"),
        ("B_SPLINE_CURVE_WITH_KNOTS('',1,(#11,#11),.U.,.F.,.F.,(2,999999999),(0.,1.),.U.)", "do not fit"),
        ("B_SPLINE_CURVE_WITH_KNOTS('',1,(#11,#11),.U.,.F.,.F.,(2,2),(1.,0.),.U.)", "knot"),
        ("B_SPLINE_CURVE_WITH_KNOTS('',999999999,(#11,#11),.U.,.F.,.F.,(2,2),(0.,1.),.U.)", "do not fit"),
        ("QUASI_UNIFORM_CURVE('',999999999,(#11,#11),.U.,.F.,.F.)", "degree"),
        ("OFFSET_SURFACE('',#102,1.,.F.)", "lies in itself"),
        ("PLANE('',#10)", "without ends"),
        ("SPHERICAL_SURFACE('',#10,0.)", ""),
        ("CIRCLE('',#10,(((1.))))", "a list"),
        ("CIRCLE('',#10,1.", "needed"),
        ("CIRCLE '',#10,1.)", "needed"),
    ] {
        let told = item(bad);
        let line = told.lines().find(|line| line.contains(says)).unwrap_or_else(|| panic!("{bad}: {told}"));
        assert!(line.contains(", line ") || line.contains("#4711") || line.contains("#103"), "{bad}: {line}");
    }
    let deep = format!("CIRCLE('',#10,{}1.{})", "(".repeat(100_000), ")".repeat(100_000));
    assert!(item(&deep).contains("deep in one another"));
}

#[test]
fn products_that_hold_themselves_are_cut_where_they_do() {
    let product = |k: usize, name: &str| {
        format!(
            "#{}=PRODUCT('{name}','{name}','',());#{}=PRODUCT_DEFINITION_FORMATION('','',#{});\
             #{}=PRODUCT_DEFINITION('','',#{},$);#{}=PRODUCT_DEFINITION_SHAPE('','',#{});\
             #{}=SHAPE_DEFINITION_REPRESENTATION(#{},#6);",
            k,
            k + 1,
            k,
            k + 2,
            k + 1,
            k + 3,
            k + 2,
            k + 4,
            k + 3
        )
    };
    let data = format!(
        "{}{}#100=GEOMETRIC_SET('',(#101));#101=CARTESIAN_POINT('',(0.,0.,0.));\
         #300=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','in','',#202,#212,$);\
         #301=NEXT_ASSEMBLY_USAGE_OCCURRENCE('2','out','',#212,#202,$);\
         #302=NEXT_ASSEMBLY_USAGE_OCCURRENCE('3','self','',#202,#202,$);",
        product(200, "a"),
        product(210, "b")
    );
    let (scene, report) = read(&file("#100", &data)).unwrap();
    scene.check().unwrap();
    let told = report.left_out.keys().filter(|why| why.contains("puts a product into itself")).count();
    assert_eq!(told, 2, "{report:?}");
}

/// A set that lies in itself is read once, and told so; what is in it is there once.
#[test]
fn a_set_in_itself_is_read_once() {
    for others in ["#100", "#100,#100", "#102,#100"] {
        let data = format!(
            "#100=GEOMETRIC_SET('',({others},#101));#101=CARTESIAN_POINT('',(1.,2.,3.));#102=GEOMETRIC_SET('',(#100,#101));"
        );
        let (scene, report) = read(&file("#100", &data)).unwrap();
        let points: usize = scene.objects().iter().map(|o| o.geometry().points().len()).sum();
        let own = 1 + usize::from(others.contains("#102"));
        assert_eq!(points, own, "{others}: {:?}", scene.objects());
        let told = format!("{report:?}");
        assert!(told.contains("lies in itself") && !told.contains("CARTESIAN_POINT"), "{others}: {told}");
    }
}

#[test]
fn what_names_itself_many_times_over_ends() {
    // Sets in sets, composites of composites, and a curve that a hundred thousand edges have.
    let selves = |list: &str| vec![list; 50].join(",");
    let nested =
        |k: usize| format!("#{}=GEOMETRIC_SET('',({}));\n", 100 + k, selves(&format!("#{}", 101 + k)));
    let sets: String = (0..20).map(nested).collect();
    let sets = format!("{sets}#120=CARTESIAN_POINT('',(0.,0.,0.));");
    assert!(survives(file("#100", &sets).as_bytes()));
    let composite = |k: usize| {
        let (of, segment) = (101 + k, 201 + k);
        format!(
            "#{}=COMPOSITE_CURVE('',({}),.F.);#{segment}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{of});\n",
            100 + k,
            selves(&format!("#{segment}"))
        )
    };
    let all: String = (0..20).map(composite).collect();
    let all = format!("{all}#120=POLYLINE('',(#121,#121));#121=CARTESIAN_POINT('',(0.,0.,0.));");
    assert!(!survives(file("#100", &all).as_bytes()));
    let points: String =
        (0..5000).map(|k| format!("#{}=CARTESIAN_POINT('',({k}.,0.,0.));\n", 1000 + k)).collect();
    let list: Vec<String> = (0..5000).map(|k| format!("#{}", 1000 + k)).collect();
    let set = selves(&selves("#101"));
    let many = format!(
        "#100=GEOMETRIC_SET('',({set}));#101=QUASI_UNIFORM_CURVE('',3,({}),.U.,.F.,.F.);{points}",
        list.join(",")
    );
    let (scene, report) = read(&file("#100", &many)).unwrap();
    assert!(scene.objects().len() < 2500, "{}", scene.objects().len());
    assert!(report.left_out.keys().any(|why| why.contains("more than 50 times")), "{:?}", report.left_out);
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(400))]

    /// Numbers that are other ones, of files that are read: sound or refused.
    #[test]
    fn any_numbers_do_no_harm(which in 0_usize..5, places in proptest::collection::vec((0.0..1.0_f64, 0_usize..12), 1..6)) {
        let name = ["revolved_sphere.step", "face.stp", "tet.step", "red_cube_blue_cylinder.step", "sliced_cylinder.step"][which];
        let mut text = String::from_utf8(data(name)).unwrap();
        for (at, what) in places {
            let start = text.find("DATA;").unwrap();
            let from = start + ((text.len() - start) as f64 * at) as usize;
            let Some(from) = text[from..].find(|c: char| c.is_ascii_digit()).map(|k| from + k) else { continue };
            let end = text[from..].find(|c: char| !(c.is_ascii_digit() || ".E+-".contains(c))).map_or(text.len(), |k| from + k);
            let new = ["0.", "0", "-1.", "1.E300", "1.E-300", "-0.", "1.E999", "NaN", "999999999", "$", "()", "1.5"][what];
            text.replace_range(from..end, new);
        }
        survives(text.as_bytes());
    }
}

#[test]
fn size_costs_in_proportion() {
    let points = |n: usize| {
        let list: Vec<String> = (0..n).map(|k| format!("#{}", 1000 + k)).collect();
        let all: String =
            (0..n).map(|k| format!("#{}=CARTESIAN_POINT('',({k}.,0.,1.E-3));\n", 1000 + k)).collect();
        file("#100", &format!("#100=GEOMETRIC_SET('',({}));\n{all}", list.join(",")))
    };
    let (scene, report) = read(&points(100_000)).unwrap();
    assert_eq!(scene.objects()[0].geometry().points().len(), 100_000);
    assert!(report.entities > 100_000);
    // Numbers that are far apart, in any order, need no more room.
    let far = points(3).replace("#1001", "#18446744073709551615").replace("#1002", "#17");
    assert_eq!(read(&far).unwrap().0.objects()[0].geometry().points().len(), 3);
    // So do things of the same name.
    let same: String = (0..20_000).map(|k| format!("#{}=POLYLINE('same',(#10,#11));\n", 1000 + k)).collect();
    let list: Vec<String> = (0..20_000).map(|k| format!("#{}", 1000 + k)).collect();
    let ends = "#10=CARTESIAN_POINT('',(0.,0.,0.));#11=CARTESIAN_POINT('',(1.,0.,0.));";
    let (scene, _) =
        read(&file("#100", &format!("#100=GEOMETRIC_SET('',({}));{ends}{same}", list.join(",")))).unwrap();
    assert_eq!(scene.objects().len(), 20_000);
}

/// What is wrong with a whole file is one message each: what, in which line, and what to do.
#[test]
fn faults_of_files_are_told_with_line_and_advice() {
    let good = file(
        "#100",
        "#100=GEOMETRIC_SET('',(#101,#102));\n#101=CARTESIAN_POINT('',(0.,0.,0.));\n#102=CARTESIAN_POINT('',(1.,0.,0.));",
    );
    let all = |text: &str| {
        let (scene, report) = read(text).unwrap();
        assert!(scene.objects().len() == 1 && report.adds_up(), "{report:?}");
        report.left_out.into_keys().chain(report.notes).collect::<Vec<_>>()
    };
    assert_eq!(all(&good), ["schema AP242".to_owned()]);
    let line = |text: &str, of: &str| 1 + text[..text.find(of).unwrap()].matches('\n').count();
    let one = |text: &str, says: &[&str]| {
        let told = all(text);
        let found: Vec<&String> =
            told.iter().filter(|told| says.iter().all(|says| told.contains(says))).collect();
        assert_eq!(found.len(), 1, "{says:?}: {told:?}");
    };
    // A number that is taken: both lines.
    let twice = good.replace("#102=CART", "#101=CART").replace(",#102)", ")");
    let lines = (line(&twice, "#101=CARTESIAN_POINT('',(1."), line(&twice, "#101=CARTESIAN_POINT('',(0."));
    one(
        &twice,
        &[
            &format!(
                "#101 (CARTESIAN_POINT), line {}: its number is that of the entity in line {}",
                lines.0, lines.1
            ),
            "give one of them another number",
        ],
    );
    // A number that nothing has: who names it, and where.
    let missing = good.replace("(#101,#102)", "(#101,#102,#4711)");
    let at = line(&missing, "#100=");
    one(
        &missing,
        &[
            &format!("#100 (GEOMETRIC_SET), line {at}: #4711 is named, but is not in the file"),
            "get the file again",
        ],
    );
    let nothing = good.replace("(#101,#102)", "(#4711)");
    let error = read(&nothing).unwrap_err().to_string();
    assert!(error.contains(&format!("#100 (GEOMETRIC_SET), line {at}: #4711 is named")), "{error}");
    // An entity that names itself.
    let itself = good.replace("(#101,#102)", "(#101,#102,#100)");
    one(&itself, &["#100 (GEOMETRIC_SET), line ", "lies in itself"]);
    let shell = format!("{AXES}#100=SHELL_BASED_SURFACE_MODEL('',(#100));");
    let error = read(&file("#100", &shell)).unwrap_err().to_string();
    assert!(
        error.contains("#100 (SHELL_BASED_SURFACE_MODEL), line ")
            && error.contains("name an OPEN_SHELL or a CLOSED_SHELL"),
        "{error}"
    );
    // A context without units.
    let unitless = good.replace("GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#2))", "");
    one(
        &unitless,
        &[
            &format!("#5, line {}, says no unit of length", line(&unitless, "#5=")),
            "name the unit of the input",
        ],
    );
    let astray = good.replace("),#5);", "),#999);");
    assert_ne!(astray, good);
    one(&astray, &[&format!("#6, line {}, says no unit of length", line(&astray, "#6="))]);
    // A loop without edges.
    let bare = format!(
        "{AXES}#100=OPEN_SHELL('',(#101));\n#101=ADVANCED_FACE('',(#102),#104,.T.);\n#102=FACE_OUTER_BOUND('',#103,.T.);\n\
         #103=EDGE_LOOP('',());\n#104=PLANE('',#10);\n"
    );
    let error = read(&file("#100", &bare)).unwrap_err().to_string();
    assert!(error.contains("#103: a loop without edges bounds nothing: name its edges"), "{error}");
    // Schemas.
    one(
        &good.replace("('AP242')", "('IFC4')"),
        &["the schema IFC4 is none that is known", "export it as AP203, AP214 or AP242"],
    );
    one(&good.replace("('AP242')", "('')"), &["the header names no schema"]);
    for known in [
        "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
        "CONFIG_CONTROL_DESIGN",
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF",
    ] {
        assert!(
            !all(&good.replace("AP242", known)).iter().any(|told| told.contains("none that is known")),
            "{known}"
        );
    }
    let empty = good.replace("('AP242')", "('IFC4')").replace("GEOMETRIC_SET('',(#101,#102))", "IFCWALL('')");
    let error = read(&empty).unwrap_err().to_string();
    assert!(error.contains("no geometry") && error.contains("the schema IFC4"), "{error}");
    // A file that ends within an entity: that, its line, and what to do.
    let cut = &good[..good.find("(1.,0").unwrap()];
    let error = read(cut).unwrap_err();
    assert_eq!(error.place, Place::Line(line(&good, "#102=CART")), "{error}");
    assert!(error.problem.contains("within #102: it was cut off, get it again"), "{error}");
}
