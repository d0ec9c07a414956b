//! A folder to run the program in, and what a run leaves behind.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// An open cubic with eight vertices, a wave over [0, 5].
pub(crate) const WAVE: &str = r#"{ "loftsman": 1, "unit": "mm", "up": "z", "objects": [
  { "name": "wave", "curve": { "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5],
    "points": [[0, 0, 0], [1, 1, 0], [2, -1, 0], [3, 1, 0], [4, -1, 0], [5, 1, 0], [6, -1, 0], [7, 0, 0]] } } ] }"#;

/// A folder of its own for one test.
pub(crate) struct Bench {
    folder: tempfile::TempDir,
}

/// What a run printed and how it ended.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Bench {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// A folder with the wave in it, `wave.loft.json`.
    pub(crate) fn with_wave() -> Self {
        let bench = Self::new();
        bench.write("wave.loft.json", WAVE);
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// All files, sorted, hidden ones included.
    pub(crate) fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, all: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                all.push(path.strip_prefix(root).unwrap().display().to_string());
                if path.is_dir() {
                    walk(&path, root, all);
                }
            }
        }
        let mut all = Vec::new();
        walk(self.folder.path(), self.folder.path(), &mut all);
        all.sort();
        all
    }

    /// Runs the program here.
    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        self.feed(arguments, b"")
    }

    /// Runs the program here with something on its standard input.
    pub(crate) fn feed(&self, arguments: &[&str], input: &[u8]) -> Run {
        let mut child = self.command(arguments).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let input = input.to_vec();
        let feeder = std::thread::spawn(move || {
            // A program that does not read its input closes it.
            let _ = stdin.write_all(&input);
        });
        let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
        feeder.join().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run { code: status.code(), out: text(stdout), err: text(stderr) }
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_loftsman"));
        command.args(arguments).current_dir(self.folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// A run that must succeed; its standard output.
    pub(crate) fn done(&self, arguments: &[&str]) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.err);
        run.out
    }

    /// A run that must succeed and print one JSON object.
    pub(crate) fn json(&self, arguments: &[&str]) -> Value {
        let out = self.done(&[arguments, &["--json"]].concat());
        let value: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {out}"));
        assert!(value.is_object(), "{arguments:?}: {out}");
        value
    }

    /// A run that must fail with one clear error that has all of these words, print nothing else and change
    /// nothing on the disk.
    pub(crate) fn fails(&self, arguments: &[&str], code: i32, words: &[&str]) -> String {
        let before = self.snapshot();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(code), "{arguments:?}: {} {}", run.out, run.err);
        assert_eq!(run.out, "", "{arguments:?} printed on the standard output");
        assert!(run.err.starts_with("error: "), "{arguments:?}: {}", run.err);
        assert_eq!(run.err.matches("error: ").count(), 1, "{arguments:?}: {}", run.err);
        assert!(!run.err.contains("panicked"), "{arguments:?}: {}", run.err);
        for word in words {
            assert!(run.err.contains(word), "{arguments:?}: \"{word}\" is not in: {}", run.err);
        }
        assert_eq!(self.snapshot(), before, "{arguments:?} changed files");
        run.err
    }

    fn snapshot(&self) -> Vec<(String, Option<Vec<u8>>)> {
        let files = self.files();
        files.into_iter().map(|f| (f.clone(), std::fs::read(self.path(&f)).ok())).collect()
    }
}
