//! What is left to do when several files are put in place, on the disk: so that a run that is killed in between is completed
//! by a later one.
//!
//! A journal names, for every file, the whole and flushed file beside its place (`part`), the place (`target`), what was there
//! before, and where that is kept (`backup`). It is written and flushed before the first rename, in every folder that is written
//! to, and is removed after the last. Its owner holds a lock on it as long as it lives. Whoever later writes to the folder
//! and gets the lock does what is left, unless a target was changed since, which is then left as it is.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

/// How journals end.
const ENDING: &str = ".journal";

/// One file of a journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Entry {
    part: Name,
    target: Name,
    /// What the target was: nothing, or a file of this length and time of change.
    before: Option<Facts>,
    backup: Option<Name>,
    /// Whether it may take no other file's place.
    fresh: bool,
}

/// A path, as text where it is any.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Name {
    Text(String),
    Bytes(Vec<u8>),
}

/// How a file is told from a changed one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Facts {
    bytes: u64,
    /// Nanoseconds since 1970; 0 where the system does not say.
    changed: u64,
}

#[derive(Debug, Serialize, Deserialize)]
struct Content {
    #[serde(rename = "loftsman journal")]
    version: u32,
    entries: Vec<Entry>,
}

impl Name {
    fn of(path: &Path) -> io::Result<Self> {
        let path = std::path::absolute(path)?;
        match path.to_str() {
            Some(text) => Ok(Self::Text(text.to_owned())),
            None => Self::raw(&path),
        }
    }

    #[cfg(unix)]
    #[allow(clippy::unnecessary_wraps, reason = "other systems have names without bytes")]
    fn raw(path: &Path) -> io::Result<Self> {
        use std::os::unix::ffi::OsStrExt as _;
        Ok(Self::Bytes(path.as_os_str().as_bytes().to_vec()))
    }

    #[cfg(not(unix))]
    fn raw(_: &Path) -> io::Result<Self> {
        Err(io::Error::other("its name is not Unicode, which several files at once need: rename it"))
    }

    fn path(&self) -> Option<PathBuf> {
        match self {
            Self::Text(text) => Some(PathBuf::from(text)),
            #[cfg(unix)]
            Self::Bytes(bytes) => {
                use std::os::unix::ffi::OsStringExt as _;
                Some(PathBuf::from(std::ffi::OsString::from_vec(bytes.clone())))
            }
            #[cfg(not(unix))]
            Self::Bytes(_) => None,
        }
    }
}

impl Facts {
    fn of(path: &Path) -> Option<Self> {
        let facts = fs::symlink_metadata(path).ok()?;
        let changed = facts.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        Some(Self { bytes: facts.len(), changed: changed.map_or(0, |time| time.as_nanos() as u64) })
    }
}

impl Entry {
    /// The file at `part` is to be at `target`, whose old content is kept at `backup`.
    pub(super) fn new(part: &Path, target: &Path, backup: Option<&Path>, fresh: bool) -> io::Result<Self> {
        Ok(Self {
            part: Name::of(part)?,
            target: Name::of(target)?,
            before: Facts::of(target),
            backup: backup.map(Name::of).transpose()?,
            fresh,
        })
    }
}

/// Journals on the disk, and the locks that say that their owner lives.
#[derive(Debug, Default)]
pub(super) struct Journals {
    open: Vec<(PathBuf, File)>,
}

impl Journals {
    /// Writes a journal at each of `places`: first under the name in `beside`, since what is not whole must not be taken
    /// for a journal.
    pub(super) fn write(&mut self, entries: &[Entry], places: &[(PathBuf, PathBuf)]) -> io::Result<()> {
        let content = Content { version: 1, entries: entries.to_vec() };
        let text = serde_json::to_vec(&content)?;
        for (beside, journal) in places {
            let mut file = OpenOptions::new().write(true).create_new(true).open(beside)?;
            // Where there are no locks nobody else gets one either, and the journal stays for a person to read.
            let _ = file.try_lock();
            let written = file.write_all(&text).and_then(|()| file.sync_all());
            if let Err(error) = written.and_then(|()| fs::rename(beside, journal)) {
                let _ = fs::remove_file(beside);
                return Err(error);
            }
            self.open.push((journal.clone(), file));
        }
        Ok(())
    }

    /// The work is done, or taken back.
    pub(super) fn remove(&mut self) {
        for (journal, file) in self.open.drain(..) {
            let _ = fs::remove_file(journal);
            drop(file);
        }
    }
}

/// The name of a journal for a name that nobody else uses.
pub(super) fn name_for(unused: &Path) -> PathBuf {
    unused.with_extension(&ENDING[1..])
}

/// Flushes what a folder knows of its files; systems that cannot do that do it by themselves.
pub(super) fn flush_folder(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Completes what runs that were killed left in a folder, each folder once in a process; the files put in place.
pub(super) fn recover_once(folder: &Path) -> Vec<PathBuf> {
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let new = SEEN.lock().map_or(true, |mut seen| seen.insert(folder.to_path_buf()));
    if new { recover(folder) } else { Vec::new() }
}

/// Completes what runs that were killed left in a folder; the files put in place.
pub(super) fn recover(folder: &Path) -> Vec<PathBuf> {
    let mut placed = Vec::new();
    let Ok(list) = fs::read_dir(folder) else { return placed };
    for entry in list.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(".loftsman-") && name.ends_with(ENDING) {
            // What cannot be done now is left to the next run.
            let _ = complete(&entry.path(), &mut placed);
        }
    }
    placed
}

/// Does what a journal has left, if its owner is gone.
fn complete(journal: &Path, placed: &mut Vec<PathBuf>) -> io::Result<()> {
    let file = OpenOptions::new().read(true).write(true).open(journal)?;
    if file.try_lock().is_err() {
        return Ok(());
    }
    // Between the listing and the lock its owner, or another run, may have done all of it.
    let Ok(bytes) = fs::read(journal) else { return Ok(()) };
    let Ok(Content { version: 1, entries }) = serde_json::from_slice::<Content>(&bytes) else {
        // Another version's, or none: for a person to look at.
        return Ok(());
    };
    let left: Vec<(PathBuf, PathBuf, &Entry)> = entries
        .iter()
        .filter_map(|entry| Some((entry.part.path()?, entry.target.path()?, entry)))
        .filter(|(part, ..)| part.exists())
        .collect();
    let unchanged = |(part, target, entry): &(PathBuf, PathBuf, &Entry)| {
        let now = Facts::of(target);
        now == entry.before || entry.fresh && now.is_some() && same(part, target)
    };
    let all = left.iter().all(unchanged);
    let mut folders = BTreeSet::new();
    for (part, target, entry) in &left {
        // A file that was changed since is somebody's: then nothing more is done, and what waits is thrown away.
        if all && !(entry.fresh && same(part, target)) {
            fs::rename(part, target)?;
            placed.push(target.clone());
            folders.extend(target.parent().map(Path::to_path_buf));
        } else {
            fs::remove_file(part)?;
        }
    }
    folders.iter().for_each(|folder| flush_folder(folder));
    for backup in entries.iter().filter_map(|entry| entry.backup.as_ref()?.path()) {
        let _ = fs::remove_file(backup);
    }
    fs::remove_file(journal)
}

/// Whether two files have the same content.
fn same(a: &Path, b: &Path) -> bool {
    matches!((fs::read(a), fs::read(b)), (Ok(a), Ok(b)) if a == b)
}
