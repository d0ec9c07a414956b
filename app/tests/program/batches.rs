//! Many conversions at once.

use loftsman_tests::bench::WAVE;

use crate::LOFTSMAN;

#[test]
fn one_that_fails_does_not_stop_the_rest() {
    let bench = LOFTSMAN.bench().with_wave();
    bench
        .write("more/b.loft.json", WAVE.replace("wave", "more"))
        .write("broken.loft.json", "{")
        .write("out/x", "");
    let arguments =
        ["convert", "wave.loft.json", "broken.loft.json", "more/b.loft.json", "--to", "obj", "--into", "out"];
    for jobs in ["1", "3"] {
        let run = bench.run(&[&arguments[..], &["--jobs", jobs]].concat());
        assert_eq!(run.code, Some(1));
        assert!(run.err.starts_with("error: broken.loft.json"), "{}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);
        assert!(run.out.contains("2 files converted, 1 failed"), "{}", run.out);
    }
    assert!(bench.path("out/b.obj").exists() && bench.path("out/wave.obj").exists());
    let run = bench.run(&[&arguments[..], &["--json"]].concat());
    let summary: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((summary["converted"].as_u64(), summary["failed"].as_u64()), (Some(2), Some(1)));
    let inputs: Vec<_> = summary["files"].as_array().unwrap().iter().map(|f| f["input"].clone()).collect();
    assert_eq!(inputs, ["wave.loft.json", "broken.loft.json", "more/b.loft.json"]);
}

#[test]
fn two_inputs_never_become_one_file() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("more/wave.loft.json", WAVE).write("out/x", "");
    let run =
        bench.run(&["convert", "wave.loft.json", "more/wave.loft.json", "--to", ".obj", "--into", "out"]);
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("same file") && run.out.contains("1 file converted, 1 failed"), "{}", run.err);
    let into = |folder| ["convert", "wave.loft.json", "--into", folder];
    bench.fails(&into("out/x"), 1, &["out/x", "this is a file"]);
    // The folder is made, and what is written is glb unless told otherwise.
    bench.done(&into("new/folder"));
    assert!(bench.read("new/folder/wave.glb").starts_with(b"glTF"));
}
