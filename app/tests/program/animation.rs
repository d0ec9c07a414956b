//! What moves: sequences of files, films, and work that Ctrl-C stops.

use std::fs;
use std::time::{Duration, Instant};

use loftsman_tests::bench::Bench;
use serde_json::{Value, json};

use crate::LOFTSMAN;

/// A bench with a rope of four vertices that moves for so many frames.
fn bench_with_rope(frames: usize) -> Bench {
    let bench = LOFTSMAN.bench();
    let frame = |k: usize| json!([[0, 0, 0], [1, k, 0], [2, 0, k], [3, 0, 0]]);
    let document = json!({ "loftsman": 1, "unit": "m", "objects": [{ "name": "rope",
        "curve": { "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 1, 1, 1], "points": frame(frames - 1) },
        "animation": { "rate": 24, "frames": (0..frames).map(frame).collect::<Vec<_>>() } }] });
    bench.write("rope.loft.json", document.to_string());
    bench
}

/// The control vertices that a file says.
fn vertices(bench: &Bench, file: &str) -> Vec<Vec<f64>> {
    let text = String::from_utf8(bench.read(file)).unwrap();
    let numbers = |line: &str| line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(numbers).collect()
}

#[test]
fn a_name_with_hashes_is_a_file_for_each_frame() {
    let bench = bench_with_rope(12);
    let report = bench.json(&["convert", "rope.loft.json", "out_##.obj", "--up", "keep"]);
    assert_eq!((&report["output"], report["frames"].as_array().unwrap().len()), (&json!("out_##.obj"), 12));
    let sizes = report["frames"].as_array().unwrap().iter().map(|f| f["bytes"].as_u64().unwrap());
    assert_eq!(report["bytes"].as_u64(), Some(sizes.sum()));
    for k in 0..12 {
        let found = vertices(&bench, &format!("out_{k:02}.obj"));
        let high = f64::from(k);
        assert_eq!(found[1..3], [vec![1.0, high, 0.0], vec![2.0, 0.0, high]], "frame {k}");
    }
    assert_eq!(bench.files().len(), 13);
    // A recipe does the same, in any format, and says which files.
    bench.write("r.toml", "input = 'rope.loft.json'\noutput = ['a###.obj', 'b_##.glb', 'whole.glb']\n");
    let report = bench.json(&["run", "r.toml"]);
    let counts: Vec<_> =
        report["outputs"].as_array().unwrap().iter().map(|o| o["frames"].as_array().map(Vec::len)).collect();
    assert_eq!(counts, [Some(12), Some(12), None]);
    assert_eq!(vertices(&bench, "a007.obj").len(), 4);
    assert!(bench.path("b_11.glb").exists() && !bench.path("b_12.glb").exists());
    let text = bench.done(&["run", "r.toml", "-o", "c##.obj"]);
    assert!(text.contains("12 frames: ") && text.contains("c11.obj"), "{text}");
    // One more from before is no frame of these.
    bench.write("c12.obj", "o old");
    let text = bench.done(&["run", "r.toml", "-o", "c##.obj"]);
    assert!(text.contains("c12.obj was there before"), "{text}");
    assert_eq!(bench.read("c12.obj"), b"o old");
}

#[test]
fn a_sequence_is_there_whole_or_not_at_all() {
    let bench = bench_with_rope(5);
    bench.write("out_00.obj", "old");
    fs::create_dir(bench.path("out_03.obj")).unwrap();
    bench.fails(&["convert", "rope.loft.json", "out_##.obj"], 1, &["out_03.obj", "is a folder"]);
    assert_eq!(bench.read("out_00.obj"), b"old");
    assert!(!bench.path("out_01.obj").exists());
    for (out, code, words) in
        [("none/out_##.obj", 1, &["none", "create it"][..]), ("a##b##.obj", 2, &["a##b##.obj", "two runs"])]
    {
        bench.fails(&["convert", "rope.loft.json", out], code, words);
        bench.fails(&["plot", "rope.loft.json", &out.replace("obj", "svg")], code, &words[1..]);
        bench.write("r.toml", format!("input = 'rope.loft.json'\noutput = '{out}'\n"));
        bench.fails(&["run", "r.toml"], 1, words);
        bench.fails(&["run", "r.toml", "-o", out], code, words);
    }
    bench.fails(&["plot", "rope.loft.json", "p##.svg", "--film", "3"], 2, &["one frame", "--film"]);
    let still = LOFTSMAN.bench().with_wave();
    for out in ["out_####.obj", "out_####.svg"] {
        let command = if out.ends_with("obj") { "convert" } else { "plot" };
        still.fails(&[command, "wave.loft.json", out], 1, &[out, "nothing in the scene is animated"]);
    }
}

/// Path data of the curves of a picture.
fn curves(svg: &str) -> Vec<&str> {
    svg.split("class=\"curve\" d=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// In each picture of a film what was asked is marked where the curve is at that moment.
#[test]
fn marks_follow_the_frames_of_a_film() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write(
        "r.json",
        serde_json::json!({
            "input": "wave.loft.json", "output": "film.svg",
            "step": [{ "op": "drag", "object": "wave", "handle": { "kind": "position", "at": 0 },
                "path": [[0, 0.5, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0]], "frames": true }],
            "picture": { "film": 3, "before": false, "polygons": false, "labels": false, "legend": false, "view": "top" },
        })
        .to_string(),
    );
    bench.done(&["run", "r.json"]);
    let svg = String::from_utf8(bench.read("film.svg")).unwrap();
    let number = |text: &str| -> f64 { text.split('"').next().unwrap().parse().unwrap() };
    let marks: Vec<[f64; 2]> = svg
        .split("<g class=\"mark ")
        .skip(1)
        .map(|mark| ["cx=\"", "cy=\""].map(|at| number(mark.split(at).nth(1).unwrap())))
        .collect();
    let starts: Vec<[f64; 2]> = curves(&svg)
        .iter()
        .map(|data| {
            let start = data[1..].split(['C', 'L']).next().unwrap();
            let [x, y] = start.split([' ', ',']).map(|c| c.parse().unwrap()).collect::<Vec<f64>>()[..] else {
                panic!("{start}")
            };
            [x, y]
        })
        .collect();
    assert!(marks.len() == 3 && starts.len() == 3, "{marks:?} {starts:?}");
    for (mark, start) in marks.iter().zip(&starts) {
        assert!((mark[0] - start[0]).hypot(mark[1] - start[1]) < 0.01, "{marks:?} {starts:?}");
    }
    // They are at three heights, and not all where the last is.
    let end = |k: usize| -> f64 { curves(&svg)[k].rsplit([' ', ',']).next().unwrap().parse().unwrap() };
    let offset = |k: usize| starts[k][1] - end(k);
    assert!((offset(0) - offset(1)).abs() > 1.0 && (offset(1) - offset(2)).abs() > 1.0, "{starts:?}");
}

/// A ring through which a rope slides is marked where it hangs in space, in each picture of a film and of a sequence: as far from the nail as
/// at the start.
#[test]
fn a_ring_is_marked_in_its_place_in_all_frames() {
    let bench = bench_with_rope(2);
    for (out, fields) in [("film.svg", serde_json::json!({ "film": 4 })), ("p##.svg", serde_json::json!({}))]
    {
        let mut look = serde_json::json!({ "before": false, "polygons": false, "labels": false, "legend": false, "view": "front" });
        look.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        bench.write(
            "ring.json",
            serde_json::json!({
                "input": "rope.loft.json", "output": out, "picture": look,
                "step": [{ "op": "simulate", "seconds": 0.25, "scheme": "implicit", "gravity": [20, 0, -9.81], "constraints": [
                    { "kind": "fixed", "at": 0 }, { "kind": "sliding", "near": 0.45 },
                ] }],
            })
            .to_string(),
        );
        bench.done(&["run", "ring.json"]);
        let files = match out {
            "film.svg" => vec![out.to_owned()],
            _ => (0..7).map(|k| format!("p{k:02}.svg")).collect(),
        };
        let mut offsets = Vec::new();
        for file in files {
            let svg = String::from_utf8(bench.read(&file)).unwrap();
            let number = |text: &str| -> f64 { text.split('"').next().unwrap().parse().unwrap() };
            let marks: Vec<[f64; 2]> = svg
                .split("<g class=\"mark ")
                .skip(1)
                .map(|mark| ["cx=\"", "cy=\""].map(|at| number(mark.split(at).nth(1).unwrap())))
                .collect();
            offsets.extend(marks.chunks(2).map(|m| [m[1][0] - m[0][0], m[1][1] - m[0][1]]));
        }
        assert_eq!(offsets.len(), if out == "film.svg" { 4 } else { 7 }, "{out}");
        for offset in &offsets {
            let off = (offset[0] - offsets[0][0]).hypot(offset[1] - offsets[0][1]);
            assert!(off < 0.02, "{out}: {offsets:?}");
        }
    }
}

#[test]
fn films_show_frames_side_by_side_and_one_above_the_other() {
    let bench = bench_with_rope(25);
    let bare = ["--no-polygons", "--no-combs", "--no-knots"];
    bench.done(
        &[&["plot", "rope.loft.json", "film.svg", "--film", "5", "--view", "front"][..], &bare].concat(),
    );
    let film = String::from_utf8(bench.read("film.svg")).unwrap();
    assert_eq!(curves(&film).len(), 5);
    for time in ["0 s", "0.25 s", "0.5 s", "0.75 s", "1 s"] {
        assert!(film.contains(&format!(">{time}</text>")), "{time}");
    }
    bench.done(&[&["plot", "rope.loft.json", "onion.svg", "--frames=7"][..], &bare].concat());
    let onion = String::from_utf8(bench.read("onion.svg")).unwrap();
    assert_eq!((curves(&onion).len(), onion.matches("class=\"frame\"").count()), (1, 7));
    let strokes: std::collections::BTreeSet<&str> = onion
        .split("class=\"frame\"")
        .skip(1)
        .filter_map(|rest| rest.split("stroke=\"").nth(1)?.split('"').next())
        .collect();
    assert_eq!(strokes.len(), 7, "each is of a paleness of its own");
    // Of a sequence of pictures each has the rope's ends in the same place.
    bench.done(&[&["plot", "rope.loft.json", "p##.svg", "--view", "isometric"][..], &bare].concat());
    let start = |k: usize| {
        let svg = String::from_utf8(bench.read(&format!("p{k:02}.svg"))).unwrap();
        let data = curves(&svg)[0].to_owned();
        (
            svg.split("viewBox").nth(1).unwrap()[..30].to_owned(),
            data.split(['C', 'L']).next().unwrap().to_owned(),
        )
    };
    assert!((1..25).all(|k| start(k) == start(0)), "{:?} {:?}", start(0), start(24));
    let data = |k: usize| bench.read(&format!("p{k:02}.svg"));
    assert_ne!(data(3), data(4));
    // Recipes have the same fields.
    for (picture, words) in [
        ("film = 3\nframes = true", &["picture.film", "leave `frames` out"][..]),
        ("film = 101", &["frames", "1 to 100"]),
        ("frames = 0", &["frames", "1 to 100"]),
        ("film = 'x'", &["picture.film"]),
    ] {
        bench.write("r.toml", format!("input = 'rope.loft.json'\noutput = 'r.svg'\n[picture]\n{picture}\n"));
        bench.fails(&["run", "r.toml"], 1, words);
    }
    bench.write("r.toml", "input = 'rope.loft.json'\noutput = 'r.png'\n[picture]\nfilm = 4\n");
    bench.done(&["run", "r.toml"]);
    assert!(bench.read("r.png").starts_with(b"\x89PNG"));
    bench.write("s.toml", "input = 'wave.loft.json'\noutput = 'r.svg'\n[picture]\nfilm = 4\n");
    bench.with_wave().fails(&["run", "s.toml"], 1, &["r.svg", "animated"]);
}

/// Starts the program, presses Ctrl-C after a while, and says how it ended and how long that took.
#[cfg(unix)]
fn interrupted(bench: &Bench, arguments: &[&str], after: Duration) -> (Option<i32>, String, Duration) {
    let mut child = bench.command(arguments).spawn().unwrap();
    std::thread::sleep(after);
    assert!(child.try_wait().unwrap().is_none(), "it was done before it could be stopped");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let pressed = Instant::now();
    let end = child.wait_with_output().unwrap();
    (end.status.code(), String::from_utf8(end.stderr).unwrap(), pressed.elapsed())
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_long_work_and_leaves_nothing_half_done() {
    // A drag of many events, each a nonlinear problem; and pictures of many frames.
    let bench = bench_with_rope(3000);
    let path: Vec<Value> = (0..200_000).map(|k| json!([0, 0.001 * f64::from(k % 300), 0])).collect();
    let step = json!({ "op": "drag", "path": path, "relative": true, "handle": { "kind": "position", "at": 0.5 },
        "constraints": [{ "kind": "length", "keep": true }] });
    let recipe = json!({ "input": "rope.loft.json", "output": ["rope.obj", "rope.glb"], "step": [step] });
    bench.write("drag.json", recipe.to_string());
    // A rope that swings for a quarter of an hour, in steps of a microsecond.
    let step = json!({ "op": "simulate", "seconds": 1000, "step": 1e-6, "constraints": [{ "kind": "fixed", "at": 0 }] });
    let recipe =
        json!({ "input": "rope.loft.json", "output": ["rope.obj", "rope.glb", "new.svg"], "step": [step] });
    bench.write("simulate.json", recipe.to_string());
    bench.write("rope.obj", "old").write("p0002.png", "old");
    let before = bench.files();
    for arguments in
        [&["run", "drag.json"][..], &["run", "simulate.json"], &["plot", "rope.loft.json", "p####.png"]]
    {
        let (code, said, took) = interrupted(&bench, arguments, Duration::from_millis(1500));
        assert_eq!(code, Some(130), "{arguments:?}: {said}");
        assert_eq!(said, "error: interrupted: nothing was written\n");
        assert!(took < Duration::from_secs(20), "{took:?}");
        assert_eq!(bench.files(), before, "{arguments:?}");
    }
    assert_eq!((bench.read("rope.obj"), bench.read("p0002.png")), (b"old".to_vec(), b"old".to_vec()));
}

/// At a terminal long work shows how far it is, and Ctrl-C typed there stops it.
#[cfg(target_os = "linux")]
#[test]
fn long_work_shows_its_progress_at_a_terminal() {
    use std::io::{Read, Write};
    use std::process::Stdio;
    let bench = bench_with_rope(3000);
    let step = json!({ "op": "simulate", "seconds": 1000, "step": 1e-6, "constraints": [{ "kind": "fixed", "at": 0 }] });
    let recipe = json!({ "input": "rope.loft.json", "output": "rope.obj", "step": [step] });
    bench.write("simulate.json", recipe.to_string());
    let program = bench.command(&["run", "simulate.json"]);
    let line = format!("'{}' run simulate.json", program.get_program().to_str().unwrap());
    // `script` of util-linux runs it at a terminal of its own.
    let mut command = std::process::Command::new("script");
    command
        .args(["-qec", &line, "/dev/null"])
        .env("TERM", "xterm")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    command.current_dir(program.get_current_dir().unwrap());
    let Ok(mut child) = command.spawn() else {
        eprintln!("SKIPPED: there is no `script` to run the program at a terminal");
        return;
    };
    let (mut keys, mut screen) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    let (mut seen, mut typed, mut part) = (String::new(), false, [0; 4096]);
    while let Ok(count @ 1..) = screen.read(&mut part) {
        seen.push_str(&String::from_utf8_lossy(&part[..count]));
        // The work, a bar, and how much of how much is done.
        if !typed && seen.contains("simulate") && seen.contains('\u{2591}') {
            keys.write_all(b"\x03").unwrap();
            keys.flush().unwrap();
            typed = true;
        }
    }
    let code = child.wait().unwrap().code();
    assert!(typed && seen.contains("/24000"), "{seen:?}");
    assert!(seen.contains("stopping; Ctrl-C again ends at once"), "{seen:?}");
    assert!(seen.contains("interrupted: nothing was written"), "{seen:?}");
    assert_eq!(
        (code, bench.files().iter().any(|file| format!("{file:?}").contains("rope.obj"))),
        (Some(130), false)
    );
}
