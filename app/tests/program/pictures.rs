//! Pictures that files name go along with them; `--meshes-only`.

use loftsman_tests::bench::Bench;

use crate::LOFTSMAN;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nnot much of a picture";

/// A square whose material shows the picture `picture`.
fn square(picture: &str) -> Bench {
    let bench = LOFTSMAN.bench();
    bench.write(
        "in/a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl m\nf 1/1 2/2 3/3\n",
    );
    bench.write("in/a.mtl", format!("newmtl m\nmap_Kd {picture}\n"));
    std::fs::create_dir(bench.path("out")).unwrap();
    bench
}

#[test]
fn pictures_are_copied_beside_the_output_or_put_into_it() {
    let bench = square("tex/wood.png");
    bench.write("in/tex/wood.png", PNG);
    bench.write("recipe.toml", "input = 'in/a.obj'\noutput = ['out/b.gltf', 'out/c.obj']\n");
    for arguments in [
        ["convert", "in/a.obj", "out/a.gltf"].as_slice(),
        &["convert", "in/a.obj", "out/a.obj"],
        &["convert", "in/a.obj", "in/b.gltf"],
        &["run", "recipe.toml"],
        &["convert", "out/a.gltf", "out/d.obj"],
    ] {
        bench.done(arguments);
        assert_eq!(bench.read("out/tex/wood.png"), PNG, "{arguments:?}");
    }
    let said = bench.json(&["convert", "in/a.obj", "out/tex/e.gltf"]);
    assert!(said["siblings"].to_string().contains("wood.png"), "{said}");
    assert_eq!(bench.read("out/tex/tex/wood.png"), PNG);
    std::fs::remove_dir_all(bench.path("out/tex")).unwrap();
    bench.done(&["convert", "in/a.obj", "out/a.glb"]);
    assert!(!bench.path("out/tex").exists());
    assert!(bench.read("out/a.glb").windows(PNG.len()).any(|bytes| bytes == PNG));
}

#[test]
fn pictures_go_along_whatever_their_path_looks_like_and_with_documents_too() {
    for picture in ["./tex/wood.png", "tex//wood.png", "././tex/./wood.png", "tex\\wood.png"] {
        for out in ["a.gltf", "a.obj", "a.loft.json"] {
            let bench = square(picture);
            bench.write("in/tex/wood.png", PNG);
            bench.done(&["convert", "in/a.obj", &format!("out/{out}")]);
            assert_eq!(bench.read("out/tex/wood.png"), PNG, "{picture} {out}");
            // What was written finds it.
            let said = bench.json(&["convert", &format!("out/{out}"), "out/b.glb"]);
            assert!(bench.read("out/b.glb").windows(PNG.len()).any(|bytes| bytes == PNG), "{said}");
        }
    }
    let bench = square("lost.png");
    let said = bench.json(&["convert", "in/a.obj", "out/a.loft.json"]);
    assert!(said["notes"].to_string().contains("missing"), "{said}");
}

#[test]
fn embedded_pictures_leave_files_their_names() {
    let bench = square("wood.png");
    bench.write("in/wood.png", PNG);
    bench.done(&["convert", "in/a.obj", "in/b.loft.json"]);
    let text = String::from_utf8(bench.read("in/b.loft.json")).unwrap();
    let image = "{ \"name\": \"wood\", \"media_type\": \"image/png\", \"base64\": \"iVBORw0KGgo=\" }, {";
    let both = text.replacen("\"images\": [", "\"images\": [@", 1);
    let (head, tail) = both.split_once('@').unwrap();
    let both = format!("{head} {}", tail.replacen('{', image, 1));
    // A second texture shows it.
    let (head, tail) = both.split_once("\"textures\": [").unwrap();
    let emissive = "{ \"channel\": \"emissive\", \"image\": \"wood\" },";
    bench.write("in/b.loft.json", format!("{head}\"textures\": [ {emissive} {tail}"));
    bench.done(&["convert", "in/b.loft.json", "out/b.obj"]);
    assert_eq!(bench.read("out/wood.png"), PNG);
    assert!(bench.read("out/wood.001.png").starts_with(b"\x89PNG"));
    // What is taken out of a document is put beside other files, not in their place.
    bench.write("out/wood.001.png", "another");
    bench.fails(
        &["convert", "in/b.loft.json", "out/c.obj"],
        1,
        &["wood.001.png", "another file has the name"],
    );
}

#[test]
fn many_conversions_at_once_never_take_the_place_of_a_picture() {
    let bench = LOFTSMAN.bench();
    std::fs::create_dir(bench.path("out")).unwrap();
    let mut arguments = vec!["convert".to_owned()];
    for k in 0..16 {
        let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl m\nf 1 2 3\n";
        bench.write(&format!("in{k}/{k}.obj"), text);
        bench.write(&format!("in{k}/a.mtl"), "newmtl m\nmap_Kd tex/wood.png\n");
        bench.write(&format!("in{k}/tex/wood.png"), [PNG, &[k / 8]].concat());
        arguments.push(format!("in{k}/{k}.obj"));
    }
    arguments.extend(["--to", "obj", "--into", "out"].map(str::to_owned));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    // Eight show one picture, eight another of the same name: whichever came first is what all that were written show.
    let run = bench.run(&arguments);
    assert_eq!(run.code, Some(1), "{}", run.err);
    let refused = (run.out + &run.err).matches("has the name of a picture").count();
    let there = bench.read("out/tex/wood.png");
    assert_eq!(refused, 8);
    let first = 8 * usize::from(there[PNG.len()]);
    for k in 0..16 {
        assert_eq!(bench.path(&format!("out/{k}.obj")).exists(), (first..first + 8).contains(&k), "{k}");
    }
    assert!(bench.files().iter().all(|f| !f.contains(".part")), "{:?}", bench.files());
}

#[test]
fn what_the_standard_output_leaves_out_is_said() {
    let bench = square("wood.png");
    bench.write("in/wood.png", PNG);
    let run = bench.run(&["convert", "in/a.obj", "-", "--to", "obj"]);
    assert!(run.code == Some(0) && run.err.contains("output.mtl, wood.png left out"), "{}", run.err);
}

#[test]
fn other_files_of_a_pictures_name_stay() {
    let bench = square("wood.png");
    bench.write("in/wood.png", PNG);
    bench.write("out/wood.png", "another");
    for out in ["out/a.gltf", "out/a.obj"] {
        bench.fails(&["convert", "in/a.obj", out], 1, &["wood.png", "another file has the name"]);
    }
    // The output itself is none either.
    let bench = square("a.gltf");
    bench.write("in/a.gltf", PNG);
    bench.fails(&["convert", "in/a.obj", "out/a.gltf"], 1, &["a.gltf"]);
}

#[test]
fn pictures_outside_of_the_folder_or_missing_are_said() {
    for picture in ["../secret.png", "/etc/hostname", "missing.png"] {
        let bench = square(picture);
        bench.write("secret.png", PNG);
        let said = bench.json(&["convert", "in/a.obj", "out/a.gltf"]);
        let gltf = String::from_utf8(bench.read("out/a.gltf")).unwrap();
        assert!(!gltf.contains("\"uri\": \"..") && !gltf.contains(picture), "{picture}: {gltf}");
        let said = said.to_string();
        assert!(said.contains("left out") || said.contains("is not in the folder"), "{picture}: {said}");
        assert!(bench.files().iter().filter(|f| f.starts_with("out/")).all(|f| f.starts_with("out/a.")));
    }
    #[cfg(unix)]
    {
        let bench = square("tex/wood.png");
        bench.write("in/tex/wood.png", PNG);
        std::fs::create_dir(bench.path("elsewhere")).unwrap();
        std::os::unix::fs::symlink("../elsewhere", bench.path("out/tex")).unwrap();
        bench.fails(&["convert", "in/a.obj", "out/a.gltf"], 1, &["link that leads elsewhere"]);
        assert!(!bench.path("elsewhere/wood.png").exists());
    }
}

#[test]
fn meshes_alone_where_asked_for() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("line.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\no face\nf 1 2 3\no line\nl 1 2\n");
    let objects = |bench: &Bench, arguments: &[&str]| {
        bench.done(arguments);
        bench.json(&["info", "a.glb"])["objects"].as_array().unwrap().len()
    };
    assert_eq!(objects(&bench, &["convert", "line.obj", "a.glb"]), 2);
    assert_eq!(objects(&bench, &["convert", "line.obj", "a.glb", "--meshes-only"]), 1);
    std::fs::create_dir(bench.path("many")).unwrap();
    bench.done(&["convert", "line.obj", "--to", "glb", "--into", "many", "--meshes-only"]);
    assert_eq!(bench.json(&["info", "many/line.glb"])["objects"].as_array().unwrap().len(), 1);
    bench.fails(&["convert", "line.obj", "b.obj", "--meshes-only"], 2, &["--meshes-only", "obj"]);
    bench.fails(
        &["convert", "line.obj", "--to", "obj", "--into", "many", "--meshes-only"],
        2,
        &["--meshes-only"],
    );
    assert!(bench.done(&["convert", "--help"]).contains("--meshes-only"));
}
