//! Files appear whole or not at all, and never where they should not.

use crate::LOFTSMAN;

#[test]
fn what_stands_in_the_way_is_said() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("folder/inner.obj", "# inner");
    bench.write("locked.obj", "# old");
    let mut permissions = std::fs::metadata(bench.path("locked.obj")).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(bench.path("locked.obj"), permissions).unwrap();
    let to = |out: &'static str| ["convert", "wave.loft.json", out];
    bench.fails(&to("missing/a.obj"), 1, &["missing", "create it"]);
    bench.fails(&to("folder/inner.obj/a.obj"), 1, &["not a folder"]);
    bench.fails(&to("locked.obj"), 1, &["read-only"]);
    bench.fails(&to("wave.loft.json"), 1, &["input itself"]);
    bench.fails(&to("./wave.loft.json"), 1, &["input itself"]);
    bench.fails(&["convert", "none.obj", "a.loft.json"], 1, &["none.obj", "no such file"]);
    bench.fails(&["convert", "folder", "a.loft.json"], 1, &["folder: this is a folder"]);
    std::fs::create_dir(bench.path("taken.obj")).unwrap();
    bench.fails(&to("taken.obj"), 1, &["is a folder"]);
}

#[test]
fn an_existing_output_survives_a_run_that_fails() {
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("a.obj", "# old");
    let recipe =
        |step: &str| format!("input = 'wave.loft.json'\noutput = ['a.obj', 'b.glb']\n[[step]]\n{step}\n");
    bench.write(
        "bad.toml",
        recipe("op = 'edit'\nobject = 'wave'\nconstraints = [{ kind = 'position', at = 9, by = [0, 1, 0] }]"),
    );
    bench.fails(&["run", "bad.toml"], 1, &["bad.toml, line 6", "constraints[0]"]);
    bench.write(
        "good.toml",
        recipe("op = 'edit'\nobject = 'wave'\nconstraints = [{ kind = 'position', at = 2, by = [0, 1, 0] }]"),
    );
    bench.done(&["run", "good.toml"]);
    assert!(bench.read("a.obj").len() > 10);
    assert_eq!(bench.files(), ["a.obj", "b.glb", "bad.toml", "good.toml", "wave.loft.json"]);
}

#[test]
fn outputs_of_a_recipe_stay_apart_from_each_other_and_from_the_input() {
    let bench = LOFTSMAN.bench().with_wave();
    let run = |outputs: &str, words: &[&str]| {
        bench.write("r.toml", format!("input = 'wave.loft.json'\noutput = {outputs}\n"));
        bench.fails(&["run", "r.toml"], 1, words);
    };
    run("['a.obj', 'a.obj']", &["twice"]);
    run("['a.obj', './a.obj']", &["twice"]);
    run("['a.obj', 'wave.loft.json']", &["input itself"]);
    run("['a.obj', 'out/b.obj']", &["out", "create it"]);
    run("['a.obj', 'b.nothing']", &["b.nothing", ".obj"]);
    bench.write("r.toml", "input = 'wave.loft.json'\noutput = 'new/out/b.obj'\ncreate_folders = true\n");
    bench.done(&["run", "r.toml"]);
    assert!(bench.files().contains(&"new/out/b.obj".to_owned()));
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_permissions_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let bench = LOFTSMAN.bench().with_wave();
    bench.write("real.obj", "# old");
    std::fs::set_permissions(bench.path("real.obj"), PermissionsExt::from_mode(0o640)).unwrap();
    symlink("real.obj", bench.path("link.obj")).unwrap();
    bench.done(&["convert", "wave.loft.json", "link.obj"]);
    assert!(std::fs::symlink_metadata(bench.path("link.obj")).unwrap().is_symlink());
    assert!(bench.read("real.obj").len() > 10);
    let mode = std::fs::metadata(bench.path("real.obj")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
    symlink("nowhere.obj", bench.path("dangling.obj")).unwrap();
    bench.fails(&["convert", "wave.loft.json", "dangling.obj"], 1, &["link"]);
}
