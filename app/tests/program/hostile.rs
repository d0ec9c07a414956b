//! Bytes that nobody should send: one clear error, exit status 1, nothing written.

use loftsman_tests::bench::WAVE;

use crate::LOFTSMAN;

#[test]
fn one_byte_files_of_every_format() {
    let bench = LOFTSMAN.bench();
    let known = bench.json(&["plugins"]);
    let mut tried = 0;
    for format in known["formats"].as_array().unwrap().iter().filter(|f| f["reads"] == true) {
        for extension in format["extensions"].as_array().unwrap() {
            for byte in [b"x", b"{", b"\0", b"\xff", b"1"] {
                let name = format!("tiny.{}", extension.as_str().unwrap());
                bench.write(&name, byte);
                bench.fails(&["convert", &name, "out.loft.json"], 1, &[&name]);
                bench.fails(&["info", &name, "--json"], 1, &[&name]);
                tried += 1;
            }
        }
    }
    assert!(tried >= 25, "{tried}");
    for byte in ["", "x", "{", "[", "\0"] {
        bench.write("tiny.toml", byte).write("tiny.json", byte);
        bench.fails(&["run", "tiny.json"], 1, &["tiny.json"]);
        if !byte.is_empty() {
            bench.fails(&["run", "tiny.toml"], 1, &["tiny.toml"]);
        }
    }
    bench.write("empty.unknown", "");
    bench.fails(&["info", "empty.unknown"], 1, &["empty.unknown", ".obj"]);
}

#[test]
fn two_hundred_thousand_brackets() {
    let bench = LOFTSMAN.bench();
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let open = open.repeat(200_000);
        for text in [open.clone(), format!("{open}1{}", close.repeat(200_000))] {
            bench.write("deep.json", &text).write("deep.loft.json", &text);
            bench.write("objects.loft.json", format!("{{\"loftsman\": 1, \"objects\": {text}}}"));
            bench.write("step.json", format!("{{\"step\": {text}}}"));
            bench.fails(&["run", "deep.json"], 1, &["deep.json"]);
            bench.fails(&["run", "step.json"], 1, &["step.json", "line 1"]);
            bench.fails(&["info", "deep.loft.json"], 1, &["deep.loft.json"]);
            bench.fails(&["info", "objects.loft.json"], 1, &["objects.loft.json"]);
        }
    }
    for text in [format!("step = {}", "[".repeat(200_000)), format!("step = {}", "{a=".repeat(200_000))] {
        bench.write("deep.toml", text);
        bench.fails(&["run", "deep.toml"], 1, &["deep.toml, line 1"]);
    }
}

#[test]
fn recipes_that_are_not_text() {
    let bench = LOFTSMAN.bench();
    bench.write("latin.toml", b"input = 'a.obj'\n# \xe9\n");
    bench.fails(&["run", "latin.toml"], 1, &["latin.toml, line 2, column 3", "UTF-8"]);
    bench.write("blob.json", [0_u8, 159, 146, 150]);
    bench.fails(&["run", "blob.json"], 1, &["blob.json"]);
}

#[test]
fn documents_that_contradict_themselves() {
    let bench = LOFTSMAN.bench();
    let wave = WAVE.find("{ \"name\"").map(|at| WAVE[at..WAVE.len() - 4].to_owned()).unwrap();
    let cases = [
        (WAVE.replace(&wave, &format!("{wave}, {wave}")), "wave"),
        (WAVE.replace("\"degree\": 3", "\"degree\": 1000000000"), "degree"),
        (WAVE.replace("4, 5, 5, 5, 5]", "4, 5, 5, 5]"), "knots"),
        (WAVE.replace("[0, 0, 0, 0, 1, 2", "[0, 0, 0, 0, 2, 1"), "decrease"),
        (WAVE.replace("\"points\"", "\"weights\": [1, 1, 1, 1, -1, 1, 1, 1], \"points\""), "weight"),
        (WAVE.replace("\"points\"", "\"ponts\""), "points"),
        (WAVE.replace("\"unit\": \"mm\"", "\"unit\": \"furlong\""), "furlong"),
        (WAVE.replace("\"name\": \"wave\"", "\"name\": \"wave\", \"parent\": \"wave\""), "wave"),
        (WAVE.replace("\"loftsman\": 1", "\"loftsman\": 99"), "99"),
    ];
    for (text, word) in cases {
        bench.write("bad.loft.json", &text);
        bench.fails(&["convert", "bad.loft.json", "out.obj"], 1, &["bad.loft.json", word]);
    }
}

#[test]
fn a_file_of_which_nothing_can_be_kept_is_an_error() {
    let bench = LOFTSMAN.bench();
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
    let surface = "bzp 1 2 3 4 1 2 3 4 1 2 3 4 1 2 3 4\n";
    bench.write("old.obj", format!("{points}{surface}")).write("out.glb", "precious");
    bench.write("r.toml", "input = \"old.obj\"\noutput = \"out.glb\"\n");
    bench.fails(&["convert", "old.obj", "out.glb"], 1, &["old.obj", "nothing", "superseded"]);
    bench.fails(&["run", "r.toml"], 1, &["old.obj", "nothing", "superseded"]);

    bench.write("both.obj", format!("{points}f 1 2 4 3\n{surface}"));
    let run = bench.run(&["convert", "both.obj", "out.glb", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.starts_with("warning: both.obj: left out 1 of"), "{}", run.err);
    assert!(run.err.contains("superseded"), "{}", run.err);
}
