//! Putting several files in place at once, or none of them.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

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
        }
    }
}

/// Writes all files beside their places, then renames them. Process failure cannot leave half a file: a rename
/// replaces its target at once. What a rename replaced is kept under a third name until all are done.
pub(super) fn commit(pending: &[Pending], create_folders: bool) -> Result<Vec<Produced>> {
    let mut undo = Undo::default();
    let files: Vec<&Pending> = pending.iter().flat_map(|p| std::iter::once(p).chain(&p.siblings)).collect();
    for file in files.iter().filter(|file| create_folders || file.is_picture) {
        undo.create_folder(file)?;
    }
    let mut staged = Vec::with_capacity(files.len());
    for file in &files {
        staged.push(stage(file, &mut undo)?);
    }
    for (file, staged) in files.iter().zip(&staged) {
        match staged {
            Some(beside) if file.is_picture => undo.put(file, beside)?,
            Some(beside) => undo.replace(file, beside, files.len() > 1)?,
            // A pipe or a device cannot be replaced; what it takes in cannot be taken back, so it comes last.
            None => continue,
        }
    }
    for (file, _) in files.iter().zip(&staged).filter(|(_, s)| s.is_none()) {
        fs::write(&file.real, &file.bytes).map_err(|e| failed(file, &e))?;
    }
    undo.done();
    Ok(pending.iter().map(Pending::produced).collect())
}

/// Writes a file beside its place; `None` where the place is a pipe or a device.
fn stage(file: &Pending, undo: &mut Undo) -> Result<Option<PathBuf>> {
    let old = fs::metadata(&file.real).ok();
    if old.as_ref().is_some_and(|f| !f.is_file() && !f.is_dir()) {
        return Ok(None);
    }
    let beside = unused_name(&file.real);
    let mut stream =
        OpenOptions::new().write(true).create_new(true).open(&beside).map_err(|e| failed(file, &e))?;
    undo.remove.push(beside.clone());
    stream.write_all(&file.bytes).and_then(|()| stream.flush()).map_err(|e| failed(file, &e))?;
    if let Some(old) = old.filter(fs::Metadata::is_file) {
        // Who may read the old file may read the new one; a file system without permissions is no failure.
        let _ = fs::set_permissions(&beside, old.permissions());
    }
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
    backups: Vec<PathBuf>,
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

    /// Puts a picture where nothing is: what another conversion put there meanwhile stays, and must be the same.
    fn put(&mut self, file: &Pending, beside: &Path) -> Result<()> {
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
        fs::remove_file(beside).map_err(|e| failed(file, &e))
    }

    fn replace(&mut self, file: &Pending, beside: &Path, several: bool) -> Result<()> {
        let existed = file.real.is_file();
        if several && existed {
            // A second name for the old file costs nothing; where the file system has no such thing, a copy does.
            let backup = unused_name(&file.real);
            fs::hard_link(&file.real, &backup)
                .or_else(|_| fs::copy(&file.real, &backup).map(drop))
                .map_err(|e| failed(file, &e))?;
            self.backups.push(backup.clone());
            fs::rename(beside, &file.real).map_err(|e| failed(file, &e))?;
            self.restore.push((backup, file.real.clone()));
        } else {
            fs::rename(beside, &file.real).map_err(|e| failed(file, &e))?;
            if !existed {
                self.remove.push(file.real.clone());
            }
        }
        Ok(())
    }

    fn done(mut self) {
        for backup in std::mem::take(&mut self.backups) {
            let _ = fs::remove_file(backup);
        }
        self.remove.clear();
        self.restore.clear();
        self.folders.clear();
    }
}

impl Drop for Undo {
    fn drop(&mut self) {
        for (backup, real) in &self.restore {
            let _ = fs::rename(backup, real);
        }
        // Some of these are gone already: renamed.
        for path in self.remove.iter().chain(&self.backups) {
            let _ = fs::remove_file(path);
        }
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

fn failed(file: &Pending, error: &std::io::Error) -> Error {
    let shown = file.shown.display().to_string();
    match error.kind() {
        std::io::ErrorKind::PermissionDenied => {
            Error::file(shown, "may not be written: permission denied in its folder")
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
