//! Putting several files in place at once, or none of them.
//!
//! Every file is written whole beside its place and flushed to the disk; then all are renamed, back to back. What each point of
//! this leaves behind if the process is killed there, or the power fails:
//!
//! * before the [journal] is there: everything is as it was. Hidden files `.loftsman-….part` may be left; nothing needs them;
//! * from then on until the last rename: each file is whole, the old one or the new one. The next run that writes to one of the
//!   folders finds the journal and does the renames that are left, so that all are new; unless a person or program changed one
//!   of the files meanwhile, which is then left as it is, with all others;
//! * after the last rename: everything is new. The next run in the folder removes what the journal names.
//!
//! Where a rename fails (a folder took the place of a file) those before it are taken back from second names of the old files. To
//! be killed just then, between taking back one and the next, may leave some old and some new. A single file needs no
//! journal: its rename is all or nothing. Pipes and devices cannot be put in place or taken back; they are written last.

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use loftsman_kernel::plugin::Observer;

use super::journal::{self, Entry, Journals, flush_folder};
use super::output::Produced;
use crate::error::{Error, Result};

/// A file that waits in memory.
#[derive(Debug)]
pub(super) struct Pending {
    /// As it was asked for.
    shown: PathBuf,
    /// Where it really goes: links followed.
    real: PathBuf,
    bytes: Vec<u8>,
    siblings: Vec<Self>,
    /// Whether it is a picture: missing folders are made for it, and it takes no other file's place.
    is_picture: bool,
}

impl Pending {
    pub(super) fn new(shown: &Path, real: PathBuf, bytes: Vec<u8>) -> Self {
        Self { shown: shown.to_path_buf(), real, bytes, siblings: Vec::new(), is_picture: false }
    }

    /// Another file beside it.
    pub(super) fn push_sibling(&mut self, sibling: Self) {
        self.siblings.push(sibling);
    }

    /// The same as a picture, with the folders that it needs; it takes no other file's place.
    pub(super) fn into_picture(self) -> Self {
        Self { is_picture: true, ..self }
    }

    pub(super) fn with_siblings(self, siblings: Vec<Self>) -> Self {
        Self { siblings, ..self }
    }

    fn produced(&self) -> Produced {
        Produced {
            path: self.shown.display().to_string(),
            bytes: self.bytes.len() as u64,
            siblings: self.siblings.iter().map(Self::produced).collect(),
            completed: Vec::new(),
        }
    }
}

/// What is about to be done, for tests that stop there.
type Step<'s> = &'s mut dyn FnMut(&str) -> io::Result<()>;

/// Writes all files beside their places, then renames them. Process failure cannot leave half a file: a rename
/// replaces its target at once. What a rename replaced is kept under a third name until all are done.
///
/// Until the last is written beside its place the observer may stop it, and all of them go.
pub(super) fn commit(
    pending: &[Pending],
    create_folders: bool,
    observer: &dyn Observer,
) -> Result<Vec<Produced>> {
    let total: usize = pending.iter().map(|file| 1 + file.siblings.len()).sum();
    let (mut done, mut stopped) = (0, false);
    let mut step = |step: &str| {
        if step == "stage" {
            stopped = observer.proceed("writing", done, total as u64).is_err();
            done += 1;
        }
        if stopped { Err(io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    };
    let committed = commit_by_steps(pending, create_folders, &mut step);
    if stopped { Err(Error::Cancelled) } else { committed }
}

fn commit_by_steps(pending: &[Pending], create_folders: bool, step: Step<'_>) -> Result<Vec<Produced>> {
    let mut undo = Undo::default();
    let files: Vec<&Pending> = pending.iter().flat_map(|p| std::iter::once(p).chain(&p.siblings)).collect();
    for file in files.iter().filter(|file| create_folders || file.is_picture) {
        undo.create_folder(file)?;
    }
    let mut staged = Vec::with_capacity(files.len());
    for file in &files {
        step("stage").map_err(|e| failed(file, &e))?;
        staged.push(stage(file, &mut undo, step)?);
    }
    // A pipe or a device cannot be replaced; what it takes in cannot be taken back, so it comes last.
    let placed: Vec<(&Pending, &PathBuf)> =
        files.iter().zip(&staged).filter_map(|(file, staged)| Some((*file, staged.as_ref()?))).collect();
    let folders: BTreeSet<&Path> = placed.iter().filter_map(|(file, _)| file.real.parent()).collect();
    folders.iter().for_each(|folder| flush_folder(folder));
    if placed.len() > 1 {
        undo.journal(&placed, &folders, step)?;
    }
    for (k, (file, beside)) in placed.iter().enumerate() {
        step("rename").map_err(|e| failed(file, &e))?;
        if file.is_picture { undo.put(file, beside, step)? } else { undo.replace(file, beside, k)? }
    }
    for (file, _) in files.iter().zip(&staged).filter(|(_, s)| s.is_none()) {
        fs::write(&file.real, &file.bytes).map_err(|e| failed(file, &e))?;
    }
    folders.iter().for_each(|folder| flush_folder(folder));
    // From here on nothing is taken back.
    undo.done(step);
    Ok(pending.iter().map(Pending::produced).collect())
}

/// Writes a file beside its place and flushes it; `None` where the place is a pipe or a device.
fn stage(file: &Pending, undo: &mut Undo, step: Step<'_>) -> Result<Option<PathBuf>> {
    let old = fs::metadata(&file.real).ok();
    if old.as_ref().is_some_and(|f| !f.is_file() && !f.is_dir()) {
        return Ok(None);
    }
    let beside = unused_name(&file.real);
    let mut stream =
        OpenOptions::new().write(true).create_new(true).open(&beside).map_err(|e| failed(file, &e))?;
    undo.remove.push(beside.clone());
    let half = file.bytes.len() / 2;
    stream
        .write_all(&file.bytes[..half])
        .and_then(|()| step("write"))
        .and_then(|()| stream.write_all(&file.bytes[half..]))
        .map_err(|e| failed(file, &e))?;
    if let Some(old) = old.filter(fs::Metadata::is_file) {
        // Who may read the old file may read the new one; a file system without permissions is no failure.
        let _ = fs::set_permissions(&beside, old.permissions());
    }
    step("flush").and_then(|()| stream.sync_all()).map_err(|e| failed(file, &e))?;
    Ok(Some(beside))
}

/// Why a picture is not put in place.
pub(super) const TAKEN: &str =
    "another file has the name of a picture that belongs here; write to another folder, or rename one";

/// What has to be undone where a later file fails; undoes it when dropped.
#[derive(Default)]
struct Undo {
    folders: Vec<PathBuf>,
    remove: Vec<PathBuf>,
    restore: Vec<(PathBuf, PathBuf)>,
    /// The second name of the old file of each that is placed, where there is one.
    backups: Vec<Option<PathBuf>>,
    journals: Journals,
}

impl Undo {
    fn create_folder(&mut self, file: &Pending) -> Result<()> {
        let folder = file.real.parent().unwrap_or_else(|| Path::new(""));
        let missing: Vec<_> =
            folder.ancestors().take_while(|a| !a.as_os_str().is_empty() && !a.exists()).collect();
        for folder in missing.into_iter().rev() {
            match fs::create_dir(folder) {
                Ok(()) => self.folders.push(folder.to_path_buf()),
                // Another conversion was faster.
                Err(_) if folder.is_dir() => {}
                Err(e) => return Err(Error::system(folder.display().to_string(), "created", &e)),
            }
        }
        Ok(())
    }

    /// Keeps the old files under second names, and writes down what is to be renamed.
    fn journal(
        &mut self,
        placed: &[(&Pending, &PathBuf)],
        folders: &BTreeSet<&Path>,
        step: Step<'_>,
    ) -> Result<()> {
        let mut entries = Vec::with_capacity(placed.len());
        for (file, beside) in placed {
            step("keep").map_err(|e| failed(file, &e))?;
            let mut backup = None;
            if !file.is_picture && file.real.is_file() {
                // A second name for the old file costs nothing; where the file system has no such thing, a copy does.
                let second = unused_name(&file.real);
                fs::hard_link(&file.real, &second)
                    .or_else(|_| fs::copy(&file.real, &second).map(drop))
                    .map_err(|e| failed(file, &e))?;
                backup = Some(second);
            }
            self.backups.push(backup.clone());
            let entry = Entry::new(beside, &file.real, backup.as_deref(), file.is_picture);
            entries.push(entry.map_err(|e| failed(file, &e))?);
        }
        let Some((first, _)) = placed.first() else { return Ok(()) };
        for folder in folders {
            let beside = unused_name(&folder.join("journal"));
            let journal = journal::name_for(&beside);
            step("journal")
                .and_then(|()| self.journals.write(&entries, &[(beside, journal)]))
                .map_err(|e| failed(first, &e))?;
            flush_folder(folder);
        }
        Ok(())
    }

    /// Puts a picture where nothing is: what another conversion put there meanwhile stays, and must be the same.
    fn put(&mut self, file: &Pending, beside: &Path, step: Step<'_>) -> Result<()> {
        // Unlike a rename, a second name never takes another file's place.
        match fs::hard_link(beside, &file.real) {
            Ok(()) => self.remove.push(file.real.clone()),
            Err(_) if fs::symlink_metadata(&file.real).is_ok() => {
                if fs::read(&file.real).ok().as_ref() != Some(&file.bytes) {
                    return Err(Error::file(file.shown.display().to_string(), TAKEN));
                }
            }
            // The file system has no second names.
            Err(_) => {
                fs::rename(beside, &file.real).map_err(|e| failed(file, &e))?;
                self.remove.push(file.real.clone());
                return Ok(());
            }
        }
        step("unlink").and_then(|()| fs::remove_file(beside)).map_err(|e| failed(file, &e))
    }

    /// Renames the `k`th of the files that are placed.
    fn replace(&mut self, file: &Pending, beside: &Path, k: usize) -> Result<()> {
        let existed = file.real.is_file();
        fs::rename(beside, &file.real).map_err(|e| failed(file, &e))?;
        match self.backups.get(k).cloned().flatten() {
            Some(backup) => self.restore.push((backup, file.real.clone())),
            None if !existed => self.remove.push(file.real.clone()),
            None => {}
        }
        Ok(())
    }

    fn done(mut self, step: Step<'_>) {
        self.remove.clear();
        self.restore.clear();
        self.folders.clear();
        // What a journal names is still there to be removed after a crash: so the journal goes last.
        for backup in std::mem::take(&mut self.backups).into_iter().flatten() {
            let _ = step("forget").and_then(|()| fs::remove_file(backup));
        }
        let _ = step("close");
        self.journals.remove();
    }
}

impl Drop for Undo {
    fn drop(&mut self) {
        // First, or a later run would go on with it.
        self.journals.remove();
        for (backup, real) in &self.restore {
            let _ = fs::rename(backup, real);
        }
        // Some of these are gone already: renamed.
        for path in self.remove.iter().chain(self.backups.iter().flatten()) {
            let _ = fs::remove_file(path);
        }
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

fn failed(file: &Pending, error: &io::Error) -> Error {
    let shown = file.shown.display().to_string();
    match error.kind() {
        kind @ io::ErrorKind::PermissionDenied => {
            let problem = "may not be written: permission denied in its folder".into();
            Error::File { path: shown, problem, kind }
        }
        _ => Error::system(shown, "written", error),
    }
}

/// A short name in the same folder that nobody else uses: the process and a count make it so.
fn unused_name(real: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    real.with_file_name(format!(".loftsman-{}-{count}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    /// Outputs in two folders: `a` and `sub/c` replace old files, `b` is new, and `p` is a picture beside `a`.
    fn outputs(folder: &Path) -> Vec<Pending> {
        let file = |name: &str| {
            let path = folder.join(name);
            Pending::new(&path, path.clone(), format!("new {name}").into_bytes())
        };
        let mut a = file("a");
        a.push_sibling(file("p").into_picture());
        vec![a, file("b"), file("sub/c")]
    }

    fn fresh() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        for name in ["a", "sub/c", "other"] {
            fs::write(folder.path().join(name), format!("old {name}")).unwrap();
        }
        folder
    }

    /// All files with their contents.
    fn state(folder: &Path) -> Vec<(String, String)> {
        let mut all = Vec::new();
        for folder in [folder.to_path_buf(), folder.join("sub")] {
            for entry in fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file()) {
                let name = entry.file_name().unwrap().to_string_lossy().into_owned();
                all.push((name, fs::read_to_string(entry).unwrap()));
            }
        }
        all.sort();
        all
    }

    fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
        list.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
    }

    fn old() -> Vec<(String, String)> {
        pairs(&[("a", "old a"), ("c", "old sub/c"), ("other", "old other")])
    }

    fn new() -> Vec<(String, String)> {
        pairs(&[("a", "new a"), ("b", "new b"), ("c", "new sub/c"), ("other", "old other"), ("p", "new p")])
    }

    fn visible(state: &[(String, String)]) -> Vec<(String, String)> {
        state.iter().filter(|(name, _)| !name.starts_with('.')).cloned().collect()
    }

    const CRASH: &str = "LOFTSMAN_TEST_CRASH";

    /// Run by the tests below in a process of its own, which dies at a step.
    #[test]
    fn child_that_dies() {
        let Ok(order) = std::env::var(CRASH) else { return };
        let (at, folder) = order.split_once(' ').unwrap();
        let (at, mut count) = (at.parse::<usize>().unwrap(), 0);
        let done = commit_by_steps(&outputs(Path::new(folder)), false, &mut |_| {
            count += 1;
            if count > at { std::process::abort() } else { Ok(()) }
        });
        assert!(done.is_ok());
    }

    /// Whether a process that commits these outputs lives to the end, though it is to die after so many steps.
    fn survives(at: usize, folder: &Path) -> bool {
        let status = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "file::commit::tests::child_that_dies", "--nocapture"])
            .env(CRASH, format!("{at} {}", folder.display()))
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .status()
            .unwrap();
        status.success()
    }

    #[test]
    fn a_process_killed_at_any_step_leaves_all_old_or_all_new_to_the_next_run() {
        let (mut died, mut completed, mut mixed) = (0, 0, 0);
        for at in 0.. {
            let folder = fresh();
            let lived = survives(at, folder.path());
            let left = state(folder.path());
            assert!(visible(&left).iter().all(|(name, text)| {
                // Every file is whole.
                old().iter().chain(&new()).any(|(n, t)| (n, t) == (name, text))
            }));
            if lived {
                assert_eq!(left, new());
                break;
            }
            died += 1;
            mixed += usize::from(visible(&left) != old() && visible(&left) != new());
            // The next run writes something else to one of the folders.
            let next = if at % 2 == 0 { folder.path().to_path_buf() } else { folder.path().join("sub") };
            journal::recover(&next);
            let found = state(folder.path());
            let seen = visible(&found);
            assert!(seen == old() || seen == new(), "{at}: {found:?}");
            completed += usize::from(seen == new());
            if seen == new() {
                // The journal in the other folder has nothing more to do.
                journal::recover(folder.path());
                journal::recover(&folder.path().join("sub"));
                assert_eq!(state(folder.path()), new(), "{at}");
            } else {
                // Where only the other folder's journal was written a run there goes on with it; else parts are left.
                journal::recover(folder.path());
                journal::recover(&folder.path().join("sub"));
                let found = state(folder.path());
                let only_parts =
                    found.iter().all(|(name, _)| !name.starts_with('.') || name.ends_with(".part"));
                assert!(found == new() || visible(&found) == old() && only_parts, "{at}: {found:?}");
            }
        }
        assert!(died > 20 && completed >= 8 && mixed >= 3, "{died} {completed} {mixed}");
    }

    #[test]
    fn a_step_that_fails_leaves_everything_as_it_was() {
        let mut at = 0;
        loop {
            let folder = fresh();
            let mut count = 0;
            let done = commit_by_steps(&outputs(folder.path()), false, &mut |_| {
                count += 1;
                if count == at + 1 { Err(io::Error::other("a fault")) } else { Ok(()) }
            });
            match done {
                Err(_) => assert_eq!(state(folder.path()), old(), "{at}"),
                // Nothing is taken back once all files are in place; then a fault may leave a hidden file.
                Ok(_) => assert_eq!(visible(&state(folder.path())), new(), "{at}"),
            }
            if count < at + 1 {
                break;
            }
            at += 1;
        }
        assert!(at > 20, "{at}");
    }

    #[test]
    fn what_was_changed_meanwhile_is_left_as_it_is() {
        for (name, text) in [("sub/c", "mine"), ("b", "mine"), ("a", "mine")] {
            let mut tried = 0;
            for at in 0.. {
                let folder = fresh();
                if survives(at, folder.path()) {
                    break;
                }
                let left = visible(&state(folder.path()));
                if left == old() || left == new() {
                    continue;
                }
                tried += 1;
                let path = folder.path().join(name);
                let renamed = fs::read_to_string(&path).is_ok_and(|t| t.starts_with("new"));
                fs::write(&path, text).unwrap();
                journal::recover(folder.path());
                journal::recover(&folder.path().join("sub"));
                let found = state(folder.path());
                // A file that was new already may be changed: it is the others that wait.
                assert_eq!(fs::read_to_string(&path).unwrap(), text, "{name} {at}: {found:?} {renamed}");
                assert!(found.iter().all(|(name, _)| !name.starts_with('.')), "{name} {at}: {found:?}");
            }
            assert!(tried >= 3, "{tried}");
        }
    }

    #[test]
    fn the_journal_of_a_run_that_goes_on_is_left_alone() {
        let folder = fresh();
        let mut seen = false;
        let done = commit_by_steps(&outputs(folder.path()), false, &mut |step| {
            if step == "rename" {
                let before = state(folder.path());
                journal::recover(folder.path());
                assert_eq!(state(folder.path()), before);
                seen |= before.iter().any(|(name, _)| name.ends_with(".journal"));
            }
            Ok(())
        });
        assert!(done.is_ok() && seen);
        assert_eq!(state(folder.path()), new());
    }
}
