//! It is a format.

use loftsman_example_format::Dots;
use loftsman_kernel::conformance::{format_conformance, sample_scene};

#[test]
fn it_conforms() {
    let verdict = format_conformance(&Dots, &sample_scene());
    assert!(verdict.passed() && verdict.checks > 100, "{verdict}");
}
