//! Files that were cut off: one clear error each, or what is left of them, told as it is; never a crash.

use std::path::{Path, PathBuf};

use crate::LOFTSMAN;

/// Cuts of each file.
const CUTS: usize = 24;

/// All files below a folder that a format may read, in order.
fn files(folder: &Path, extensions: &[String], all: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().to_lowercase();
        if path.is_dir() {
            files(&path, extensions, all);
        } else if extensions.iter().any(|e| name.ends_with(&format!(".{e}"))) {
            all.push(path);
        }
    }
}

#[test]
fn cut_files_of_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let known = LOFTSMAN.json(folder.path(), &["plugins"]);
    let mut extensions: Vec<String> = Vec::new();
    for format in known["formats"].as_array().unwrap().iter().filter(|f| f["reads"] == true) {
        extensions
            .extend(format["extensions"].as_array().unwrap().iter().map(|e| e.as_str().unwrap().to_owned()));
    }
    let mut sources = Vec::new();
    files(&loftsman_tests::repository().join("tests/data"), &extensions, &mut sources);
    // Documents of what the other files hold.
    let documents = folder.path().join("documents");
    std::fs::create_dir(&documents).unwrap();
    for (k, source) in sources.iter().enumerate().step_by(4) {
        for extension in ["loft.json", "glb"] {
            let document = documents.join(format!("{k}.{extension}"));
            let (from, to) = (source.to_string_lossy(), document.to_string_lossy());
            LOFTSMAN.run(folder.path(), &["convert", &from, &to]);
        }
    }
    files(&documents, &extensions, &mut sources);
    assert!(sources.len() >= 50, "{} files", sources.len());

    let (mut kept, mut refused) = (0, 0);
    for source in &sources {
        let bytes = std::fs::read(source).unwrap();
        let name = source.file_name().unwrap().to_string_lossy();
        let work = tempfile::tempdir().unwrap();
        std::fs::create_dir(work.path().join("out")).unwrap();
        let mut arguments = vec!["convert".to_owned()];
        for k in 0..CUTS {
            // Unevenly, so that cuts fall within words and numbers too.
            let at = (bytes.len() * k / CUTS + 7 * k).min(bytes.len().saturating_sub(1));
            arguments.push(format!("{k}-{name}"));
            std::fs::write(work.path().join(&arguments[k + 1]), &bytes[..at]).unwrap();
        }
        arguments.extend(["--to", "loft.json", "--into", "out", "--json"].map(str::to_owned));
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let run = LOFTSMAN.run(work.path(), &arguments);
        let messages = &run.err;
        assert!(matches!(run.code, Some(0 | 1)), "{name}: {:?}\n{messages}", run.code);
        assert!(!messages.contains("panicked"), "{name}: {messages}");
        let summary: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        let all = summary["files"].as_array().unwrap();
        assert_eq!(all.len(), CUTS, "{name}");
        for (k, file) in all.iter().enumerate() {
            let input = file["input"].as_str().unwrap();
            match file["error"].as_str() {
                Some(error) => {
                    assert!(error.starts_with(input), "{input}: {error}");
                    assert!(error.lines().count() == 1 && error.len() < 1000, "{input}: {error}");
                    refused += 1;
                }
                None => {
                    // What is left is told: every entity is kept, approximated or left out.
                    let report = &file["report"];
                    let sum = |field: &str| -> u64 {
                        report[field].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum()
                    };
                    let told = report["kept"].as_u64().unwrap() + sum("approximated") + sum("left_out");
                    assert_eq!(report["entities"].as_u64(), Some(told), "{input}: {report}");
                    let output = work.path().join(file["output"].as_str().unwrap());
                    assert!(output.exists(), "{input}");
                    // What was written is whole.
                    if k % 12 == 5 {
                        LOFTSMAN.json(work.path(), &["info", &output.to_string_lossy()]);
                    }
                    kept += 1;
                }
            }
        }
        let written = std::fs::read_dir(work.path().join("out")).unwrap().count() as u64;
        assert_eq!(Some(written), summary["converted"].as_u64(), "{name}: nothing else is written");
        assert_eq!(run.code, Some(i32::from(summary["failed"] != 0)), "{name}");
    }
    assert!(kept > 100 && refused > 100, "{kept} kept, {refused} refused");
}

#[test]
fn a_degree_beyond_all_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.csv"), "0,0\n1,1\n2,0\n3,1\n4,0\n").unwrap();
    for degree in ["1000000000", "26", "0"] {
        let run = LOFTSMAN.run(folder.path(), &["fit", "p.csv", "out.loft.json", "--degree", degree]);
        let message = &run.err;
        assert_eq!(run.code, Some(2), "{message}");
        let said = message.contains(&format!("not {degree}")) && message.contains("1 to 25");
        assert!(said && message.lines().count() == 1, "{message}");
        assert!(!folder.path().join("out.loft.json").exists() && run.out.is_empty());
    }
}
