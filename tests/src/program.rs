//! The program `loftsman`, as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::SystemTime;

use serde_json::Value;

/// The top folder of the repository.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or_else(|| panic!("tests/ lies inside the repository"))
}

/// The program: the one that the same `cargo test` has built beside the tests, or, where that is missing or older than
/// its sources, one compiled now. (Cargo tells only the package that owns a program where it is. Asking for it always
/// would compile half of the workspace anew: alone, the program unifies features differently.)
pub fn path() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| beside_the_tests().unwrap_or_else(compile))
}

fn beside_the_tests() -> Option<PathBuf> {
    let tests = std::env::current_exe().ok()?;
    let program = tests.parent()?.parent()?.join(format!("loftsman{}", std::env::consts::EXE_SUFFIX));
    let built = program.metadata().ok()?.modified().ok()?;
    let sources = ["kernel", "io", "plugins", "app", "Cargo.toml", "Cargo.lock"];
    sources
        .iter()
        .all(|source| newest(&repository().join(source)).is_some_and(|time| time <= built))
        .then_some(program)
}

/// When the newest file of a folder (or the file itself) was changed.
fn newest(path: &Path) -> Option<SystemTime> {
    if path.is_file() {
        return path.metadata().ok()?.modified().ok();
    }
    let entries = std::fs::read_dir(path).ok()?;
    entries.map(|entry| newest(&entry.ok()?.path())).try_fold(SystemTime::UNIX_EPOCH, |a, b| Some(a.max(b?)))
}

fn compile() -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .current_dir(repository())
        .args(["build", "--package", "loftsman", "--bin", "loftsman", "--message-format", "json"])
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .unwrap_or_else(|e| panic!("cargo does not start: {e}"));
    assert!(built.status.success(), "the program does not compile");
    serde_json::Deserializer::from_slice(&built.stdout)
        .into_iter::<Value>()
        .filter_map(Result::ok)
        .filter(|message| message["reason"] == "compiler-artifact" && message["target"]["name"] == "loftsman")
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .unwrap_or_else(|| panic!("cargo does not say where the program is"))
}

/// Runs the program in a folder, whatever comes of it.
///
/// # Panics
/// When it does not start.
pub fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(path());
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command.output().unwrap_or_else(|e| panic!("loftsman does not start: {e}"))
}

/// Runs the program in a folder; its standard output.
///
/// # Panics
/// When it fails.
pub fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = run_in(folder, arguments);
    assert!(
        output.status.success(),
        "loftsman {} fails ({}):\n{}{}",
        arguments.join(" "),
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs the program with `--json`; the object it prints.
///
/// # Panics
/// When it fails or prints anything else.
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let text = succeed(folder, &[arguments, &["--json"]].concat());
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("not one JSON object ({e}):\n{text}"))
}
