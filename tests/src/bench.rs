//! A folder to run the program in, and what a run leaves behind.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::program::{Program, Run};

/// An open cubic with eight vertices, a wave over [0, 5].
pub const WAVE: &str = r#"{ "loftsman": 1, "unit": "mm", "up": "z", "objects": [
  { "name": "wave", "curve": { "degree": 3, "periodic": false, "knots": [0, 0, 0, 0, 1, 2, 3, 4, 5, 5, 5, 5],
    "points": [[0, 0, 0], [1, 1, 0], [2, -1, 0], [3, 1, 0], [4, -1, 0], [5, 1, 0], [6, -1, 0], [7, 0, 0]] } } ] }"#;

/// A folder of its own for one test.
#[derive(Debug)]
pub struct Bench {
    program: Program,
    folder: tempfile::TempDir,
}

impl Bench {
    /// An empty folder.
    pub(crate) fn new(program: Program) -> Self {
        Self { program, folder: tempfile::tempdir().unwrap() }
    }

    /// The same with the wave in it, `wave.loft.json`.
    #[must_use]
    pub fn with_wave(self) -> Self {
        self.write("wave.loft.json", WAVE);
        self
    }

    /// The path of a file here.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file, and the folders that it needs.
    ///
    /// # Panics
    /// When it cannot be written.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        self
    }

    /// The bytes of a file.
    ///
    /// # Panics
    /// When there is none.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// All files, sorted, hidden ones included.
    pub fn files(&self) -> Vec<String> {
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
    pub fn run(&self, arguments: &[&str]) -> Run {
        self.program.run(self.folder.path(), arguments)
    }

    /// Runs the program here with something on its standard input.
    pub fn feed(&self, arguments: &[&str], input: &[u8]) -> Run {
        self.program.feed(self.folder.path(), arguments, input)
    }

    /// A run here, to be started.
    pub fn command(&self, arguments: &[&str]) -> Command {
        self.program.command(self.folder.path(), arguments)
    }

    /// A run that must succeed; its standard output.
    pub fn done(&self, arguments: &[&str]) -> String {
        self.program.done(self.folder.path(), arguments)
    }

    /// A run that must succeed and print one JSON object.
    pub fn json(&self, arguments: &[&str]) -> Value {
        self.program.json(self.folder.path(), arguments)
    }

    /// A run that must fail with one clear error that has all of these words, print nothing else (with `--json`, the
    /// error as JSON) and change nothing on the disk.
    pub fn fails(&self, arguments: &[&str], code: i32, words: &[&str]) -> String {
        let before = self.snapshot();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(code), "{arguments:?}: {} {}", run.out, run.err);
        if arguments.contains(&"--json") {
            let told: Value = serde_json::from_str(&run.out).unwrap_or_default();
            let message = told["error"]["message"].as_str().unwrap_or_default();
            let lines = run.err.lines().next().unwrap_or_default();
            assert!(
                !message.is_empty() && lines.contains(message.lines().next().unwrap_or_default()),
                "{told} {}",
                run.err
            );
            assert_eq!(told["error"]["status"], code, "{told}");
        } else {
            assert_eq!(run.out, "", "{arguments:?} printed on the standard output");
        }
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
