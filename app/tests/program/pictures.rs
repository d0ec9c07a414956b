//! Pictures that files name go along with them; `--meshes-only`.

use crate::bench::Bench;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nnot much of a picture";

/// A square whose material shows the picture `picture`.
fn square(picture: &str) -> Bench {
    let bench = Bench::new();
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
    let bench = Bench::with_wave();
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
