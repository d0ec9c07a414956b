//! Basis functions and their derivatives against a dense numpy reference (`golden/README.md`).

use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

#[test]
fn basis_functions_agree_with_the_reference() {
    let text = include_str!("golden/basis.json");
    let golden: serde_json::Value = serde_json::from_str(text).unwrap();
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let cases = golden["cases"].as_array().unwrap();
    assert!(cases.len() >= 500, "only {} cases", cases.len());
    for (number, case) in cases.iter().enumerate() {
        let degree = case["space"]["degree"].as_u64().unwrap() as usize;
        let knots = numbers(&case["space"]["knots"]);
        let space = if case["space"]["periodic"].as_bool().unwrap() {
            Space::periodic(degree, knots).unwrap()
        } else {
            Space::open(degree, knots).unwrap()
        };
        let (u, order) = (case["u"].as_f64().unwrap(), case["order"].as_u64().unwrap() as usize);
        let (expected, mut found) = (numbers(&case["row"]), vec![0.0; space.len()]);
        let u = space.locate(u).unwrap();
        let span = space.span(u);
        let mut row = [0.0; MAX_ORDER];
        space.basis_into(span, u, order, &mut row);
        for (j, value) in row[..=degree].iter().enumerate() {
            found[space.vertex(span - degree + j)] += value;
        }
        let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
        assert_eq!(expected.len(), found.len(), "case {number}");
        for (e, f) in expected.iter().zip(&found) {
            assert!((e - f).abs() <= 1e-12 * scale, "case {number}: {expected:?} but {found:?}");
        }
    }
}
