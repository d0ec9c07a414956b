//! The program `loftsman`, as a user runs it.
//!
//! Cargo builds a program for the tests of the package that owns it, and tells these alone where it is. So whatever runs it is a test of
//! that package, in `app/tests`, and each target there starts with
//! `const LOFTSMAN: Program = Program::at(env!("CARGO_BIN_EXE_loftsman"));`.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::bench::Bench;

/// A program.
#[derive(Debug, Clone, Copy)]
pub struct Program(&'static str);

/// What a run printed and how it ended.
#[derive(Debug)]
pub struct Run {
    /// The exit code; `None` where a signal ended it.
    pub code: Option<i32>,
    /// The standard output.
    pub out: String,
    /// The standard error.
    pub err: String,
}

impl Program {
    /// The program at a path.
    pub const fn at(path: &'static str) -> Self {
        Self(path)
    }

    /// An empty folder to run it in.
    pub fn bench(self) -> Bench {
        Bench::new(self)
    }

    /// A run in a folder, to be started, with all streams as pipes.
    pub fn command(self, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.0);
        command.args(arguments).current_dir(folder);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs it in a folder, whatever comes of it.
    ///
    /// # Panics
    /// When it does not start, or prints what is no UTF-8.
    pub fn run(self, folder: &Path, arguments: &[&str]) -> Run {
        self.feed(folder, arguments, b"")
    }

    /// Runs it in a folder with something on its standard input, whatever comes of it.
    ///
    /// # Panics
    /// When it does not start, or prints what is no UTF-8.
    pub fn feed(self, folder: &Path, arguments: &[&str], input: &[u8]) -> Run {
        let mut child = self
            .command(folder, arguments)
            .spawn()
            .unwrap_or_else(|e| panic!("{} does not start: {e}", self.0));
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

    /// Runs it in a folder; its standard output.
    ///
    /// # Panics
    /// When it fails.
    pub fn done(self, folder: &Path, arguments: &[&str]) -> String {
        let run = self.run(folder, arguments);
        assert_eq!(run.code, Some(0), "loftsman {}:\n{}{}", arguments.join(" "), run.out, run.err);
        run.out
    }

    /// Runs it in a folder with `--json`; the object that it prints.
    ///
    /// # Panics
    /// When it fails or prints anything else.
    pub fn json(self, folder: &Path, arguments: &[&str]) -> Value {
        let out = self.done(folder, &[arguments, &["--json"]].concat());
        let value: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {out}"));
        assert!(value.is_object(), "{arguments:?}: {out}");
        value
    }
}
