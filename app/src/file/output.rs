//! Output files: checked before the work, made in memory, put in place together.
//!
//! A run with five outputs either leaves all five, or none and whatever was there before. So everything that can
//! be refused (a missing folder, a directory, a protected file, the input itself, the same file twice) is refused
//! by [`Outputs::claim`], before any work; and everything that is written goes through [`Outputs::commit`].

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use loftsman_kernel::plugin::{
    Fate, Format, FormatError, FormatErrorKind, Memory, Observer, Quiet, Registry, WriteOptions, WriteReport,
    Written,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::text::clip;

use super::commit::{Pending, TAKEN, commit};
use super::input::{extensions, foreign};
use super::journal::recover_once;
use super::sequence::Sequence;
use crate::error::{Error, Result};

/// Files that are to appear together.
#[derive(Debug, Default)]
pub struct Outputs {
    pending: Vec<Pending>,
    claimed: BTreeMap<PathBuf, String>,
    inputs: BTreeMap<PathBuf, String>,
    /// Pictures that are to be put beside outputs.
    pictures: BTreeMap<PathBuf, Vec<u8>>,
    create_folders: bool,
    /// Files of runs that were killed, which were put in place first.
    completed: Vec<String>,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Produced {
    /// Where it is, as it was asked for.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// Files that came along (`.mtl`, `.bin`).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub siblings: Vec<Self>,
    /// Of the first file: files that a run that was killed had written and not put in place, which was done before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub completed: Vec<String>,
}

impl Produced {
    /// What is to be said of runs that were killed before.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let files = self.completed.join(", ");
        (!files.is_empty()).then(|| {
            format!(
                "an earlier run was killed before it had put all its files in place: {files} followed now"
            )
        })
    }
}

impl Outputs {
    /// No files yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Lets missing folders be made at the [`commit`](Self::commit).
    #[must_use]
    pub fn create_folders(mut self, create: bool) -> Self {
        self.create_folders = create;
        self
    }

    /// Protects a file from being written over: an input.
    pub fn protect(&mut self, input: impl AsRef<Path>) {
        let input = input.as_ref();
        if let Ok(real) = input.canonicalize() {
            self.inputs.insert(real, input.display().to_string());
        }
    }

    /// Checks that a file could be written, and keeps its place. Claiming it again is an error.
    ///
    /// # Errors
    /// When its folder is missing, it is a directory, protected, an input, or claimed already.
    pub fn claim(&mut self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let shown = path.display().to_string();
        let real = self.resolve(path)?;
        if self.inputs.contains_key(&real) {
            return Err(Error::file(shown, "this is the input itself; give the output another name"));
        }
        if let Some(other) = self.claimed.get(&real) {
            let problem = if *other == shown {
                "this output is asked for twice; leave one out".to_owned()
            } else {
                format!("this is the same file as the output {other}; give one of them another name")
            };
            return Err(Error::file(shown, problem));
        }
        self.claimed.insert(real, shown);
        Ok(())
    }

    /// Makes the file of a scene in memory, in the format of the file's extension; returns how each object goes
    /// out. Claims the file unless it was claimed before.
    ///
    /// # Errors
    /// When the file cannot be claimed, the format is unknown, or it cannot hold the scene.
    pub fn scene(
        &mut self,
        scene: &Scene,
        path: impl AsRef<Path>,
        options: &WriteOptions<'_>,
        registry: &Registry,
    ) -> Result<WriteReport> {
        let path = path.as_ref();
        let format = format_for(path, registry)?;
        let (memory, report) = encode(scene, &file_name(path), format.as_ref(), options, registry)?;
        self.add_memory(path, memory)?;
        Ok(report)
    }

    /// As [`scene`](Self::scene), a file for each frame of a sequence; returns how each object goes out, and how many files
    /// there are.
    ///
    /// # Errors
    /// As for [`scene`](Self::scene); also when nothing in the scene is animated.
    pub fn frames(
        &mut self,
        scene: &Scene,
        sequence: &Sequence,
        options: &WriteOptions<'_>,
        registry: &Registry,
    ) -> Result<(WriteReport, usize)> {
        let reports = sequence.each(scene, options.observer, |file, moment| {
            self.scene(&scene.at(moment)?, file, options, registry)
        })?;
        let count = reports.len();
        Ok((Sequence::report(reports), count))
    }

    /// Takes bytes that are to become a file, and its siblings by name.
    ///
    /// # Errors
    /// When the file cannot be claimed and was not before, or a sibling cannot.
    pub fn add(
        &mut self,
        path: impl AsRef<Path>,
        bytes: Vec<u8>,
        siblings: BTreeMap<String, Vec<u8>>,
    ) -> Result<()> {
        let path = path.as_ref();
        let shown = path.display().to_string();
        let real = self.resolve(path)?;
        if self.claimed.get(&real) != Some(&shown) {
            self.claim(path)?;
        }
        let mut beside = Vec::new();
        for (name, bytes) in siblings {
            let sibling = path.with_file_name(name);
            self.claim(&sibling)?;
            let real = self.resolve(&sibling)?;
            beside.push(Pending::new(&sibling, real, bytes));
        }
        self.pending.push(Pending::new(path, real, bytes).with_siblings(beside));
        Ok(())
    }

    /// Takes a file that a format wrote, its siblings, and the pictures that it names. A picture that is there already
    /// stays; folders below the file's own are made for those that are not.
    ///
    /// # Errors
    /// As for [`add`](Self::add); also when a picture's name leads out of the file's folder, or another file has it.
    pub fn add_memory(&mut self, path: impl AsRef<Path>, memory: Memory) -> Result<()> {
        let path = path.as_ref();
        self.add(path, memory.bytes, memory.siblings)?;
        for (name, bytes) in memory.pictures {
            if let Some(picture) = self.picture(path, &name, bytes)?
                && let Some(last) = self.pending.last_mut()
            {
                last.push_sibling(picture);
            }
        }
        Ok(())
    }

    /// The place of a picture below a file's folder; `None` where it is there already.
    fn picture(&mut self, path: &Path, name: &str, bytes: Vec<u8>) -> Result<Option<Pending>> {
        let below = Path::new(name);
        let shown = path.with_file_name(below);
        let fail = |problem: &str| Err(Error::file(shown.display().to_string(), problem.to_owned()));
        let inside = below.components().all(|c| matches!(c, Component::Normal(_)));
        if name.is_empty() || name.contains('\\') || !inside {
            return fail("a picture of this name would not be beside the output");
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        // A folder that will be made below what is there; links must not lead out.
        let deepest = shown.ancestors().skip(1).find(|a| a.exists() || a.as_os_str().is_empty());
        let deepest = deepest.filter(|a| !a.as_os_str().is_empty()).unwrap_or(folder);
        if let (Ok(root), Ok(deepest)) = (folder.canonicalize(), deepest.canonicalize())
            && !deepest.starts_with(&root)
        {
            return fail("a folder on the way to this picture is a link that leads elsewhere");
        }
        if fs::symlink_metadata(&shown).is_ok() {
            return match fs::read(&shown) {
                Ok(there) if there == bytes => Ok(None),
                _ => fail(TAKEN),
            };
        }
        let real = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf()).join(below);
        match self.claimed.get(&real) {
            // Another output of the same folder names it too.
            Some(_) if self.pictures.get(&real) == Some(&bytes) => return Ok(None),
            Some(_) => return fail("another output has the name of a picture that belongs here; rename one"),
            None => {}
        }
        self.claimed.insert(real.clone(), shown.display().to_string());
        self.pictures.insert(real.clone(), bytes.clone());
        Ok(Some(Pending::new(&shown, real, bytes).into_picture()))
    }

    /// Puts all files in place: each is written beside its place under another name and flushed to the disk, then all are
    /// renamed. Where one cannot be, those before it are put back. Where the process is killed between two renames, the
    /// next run that writes to the folder does those that are left.
    ///
    /// # Errors
    /// When a file cannot be written; nothing has changed then.
    pub fn commit(self) -> Result<Vec<Produced>> {
        self.commit_watched(&Quiet)
    }

    /// As [`commit`](Self::commit), watched: it is told of each file that is written beside its place, and may stop it until
    /// the last is; what was written is removed then.
    ///
    /// # Errors
    /// As for [`commit`](Self::commit); [`Error::Cancelled`] where it was stopped.
    pub fn commit_watched(self, observer: &dyn Observer) -> Result<Vec<Produced>> {
        let mut produced = commit(&self.pending, self.create_folders, observer)?;
        if let Some(first) = produced.first_mut() {
            first.completed = self.completed;
        }
        Ok(produced)
    }

    /// The place that a path leads to: links followed, the folder in its canonical form.
    fn resolve(&mut self, path: &Path) -> Result<PathBuf> {
        let shown = || path.display().to_string();
        let Some(name) = path.file_name() else {
            return Err(Error::file(shown(), "this names no file; put a file name at its end"));
        };
        let beside = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        if let Ok(folder) = beside.canonicalize() {
            // What a run that was killed has left to do comes first.
            self.completed.extend(recover_once(&folder).iter().map(|path| path.display().to_string()));
        }
        if let Ok(facts) = fs::symlink_metadata(path) {
            let real = path.canonicalize().map_err(|_| {
                Error::file(
                    shown(),
                    "this is a link to a file that does not exist; remove it or name another",
                )
            })?;
            let facts = if facts.is_symlink() { fs::metadata(&real).ok() } else { Some(facts) };
            if facts.as_ref().is_some_and(fs::Metadata::is_dir) {
                return Err(Error::file(shown(), "this is a folder; name a file in it"));
            }
            if facts.is_some_and(|f| f.is_file() && f.permissions().readonly()) {
                return Err(Error::file(shown(), "this file is read-only; allow writing or name another"));
            }
            return Ok(real);
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        match folder.canonicalize() {
            Ok(real) if real.is_dir() => Ok(real.join(name)),
            Ok(_) => Err(Error::file(shown(), format!("{} is not a folder", folder.display()))),
            Err(_) if self.create_folders => Ok(folder.join(name)),
            Err(_) => {
                let problem = format!(
                    "the folder {} does not exist; create it first, or have it made (create_folders = true in a recipe)",
                    folder.display()
                );
                Err(Error::file(shown(), problem))
            }
        }
    }
}

/// The bytes of a scene in a format, and how each object went out. Where the options name no tessellator, the
/// registry's is used.
///
/// # Errors
/// When the format cannot hold the scene, or nothing of it.
pub fn encode(
    scene: &Scene,
    name: &str,
    format: &dyn Format,
    options: &WriteOptions<'_>,
    registry: &Registry,
) -> Result<(Memory, WriteReport)> {
    let mut memory = Memory::new(name, Vec::new());
    let tessellator = options.tessellator.or_else(|| registry.tessellator());
    let report = format.write(scene, &mut memory, &WriteOptions { tessellator, ..options.clone() })?;
    refuse_empty(scene, &report.objects).map_err(|error| error.in_file(name))?;
    Ok((memory, report))
}

/// A file in which nothing of a scene would be is none that anybody asked for, where there is something in the scene.
fn refuse_empty(scene: &Scene, objects: &[Written]) -> std::result::Result<(), FormatError> {
    if objects.iter().any(|object| object.fate != Fate::LeftOut) {
        return Ok(());
    }
    let is_something = |written: &&Written| {
        scene.object(&written.object).is_ok_and(|object| !object.geometry().points().is_empty())
    };
    let Some(first) = objects.iter().find(is_something) else { return Ok(()) };
    let reason = first.reason.as_deref().unwrap_or("the format cannot hold it");
    let what = match objects.len() {
        1 => format!("\"{}\"", clip(&first.object)),
        count => format!("any of its {count} objects: \"{}\"", clip(&first.object)),
    };
    let problem = format!("nothing would be in it, for it cannot hold {what}: {reason}");
    Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported))
}

/// The format that a file is to be written in, by its extension.
///
/// # Errors
/// [`Error::UnknownFormat`], with the extensions that can be written.
pub fn format_for<'r>(path: &Path, registry: &'r Registry) -> Result<&'r Arc<dyn Format>> {
    let name = file_name(path);
    let known = || extensions(registry, |f| f.declaration().writes);
    match registry.format_of(&name) {
        Some(format) if format.declaration().writes => Ok(format),
        Some(format) => {
            let problem = format!(
                "{} can be read, but not written; writable are {}",
                format.declaration().name,
                known()
            );
            Err(Error::UnknownFormat { file: path.display().to_string(), problem })
        }
        None => {
            let problem = if crate::picture_name::is_picture(path) {
                "a picture is not a format to convert to: draw it with `loftsman plot`".to_owned()
            } else if path.is_dir() {
                "this is a folder; name a file in it, or convert files into it with `--into`".to_owned()
            } else if let Some(what) = foreign(&name) {
                format!("{what} is not written; writable are {}", writable(known()))
            } else {
                format!("the format of this name is unknown; writable are {}", writable(known()))
            };
            Err(Error::UnknownFormat { file: path.display().to_string(), problem })
        }
    }
}

/// What can be written: the endings of formats, and pictures, where these are drawn.
fn writable(known: String) -> String {
    if cfg!(feature = "picture") {
        format!("{known}; recipes and `loftsman plot` draw .svg and .png")
    } else {
        known
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut all: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        all.sort();
        all
    }

    #[test]
    fn all_files_appear_together() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.obj"), folder.path().join("b.obj"));
        fs::write(&a, "old").unwrap();
        let mut outputs = Outputs::new();
        outputs.add(&a, b"new".to_vec(), BTreeMap::from([("a.mtl".to_owned(), b"m".to_vec())])).unwrap();
        outputs.add(&b, b"other".to_vec(), BTreeMap::new()).unwrap();
        assert_eq!(names(folder.path()), ["a.obj"]);
        let produced = outputs.commit().unwrap();
        assert_eq!(produced[0].siblings[0].bytes, 1);
        assert_eq!(names(folder.path()), ["a.mtl", "a.obj", "b.obj"]);
        assert_eq!(fs::read(&a).unwrap(), b"new");
    }

    #[test]
    fn a_failure_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.obj"), folder.path().join("b.obj"));
        fs::write(&a, "old").unwrap();
        let mut outputs = Outputs::new();
        outputs.add(&a, b"new".to_vec(), BTreeMap::new()).unwrap();
        outputs.add(folder.path().join("c.obj"), b"c".to_vec(), BTreeMap::new()).unwrap();
        outputs.add(&b, b"other".to_vec(), BTreeMap::new()).unwrap();
        // A directory takes the place of the last file after it was claimed: its rename must fail.
        fs::create_dir(&b).unwrap();
        assert!(outputs.commit().is_err());
        assert_eq!(fs::read(&a).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.obj", "b.obj"]);
    }

    #[test]
    fn whoever_watches_may_stop_it_until_the_last_is_written() {
        struct After(std::cell::Cell<usize>);
        impl Observer for After {
            fn cancelled(&self) -> bool {
                self.0.replace(self.0.get().saturating_sub(1)) == 0
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let file = |k: usize| folder.path().join(format!("{k}.obj"));
        fs::write(file(1), "old").unwrap();
        for after in 0..=4 {
            let mut outputs = Outputs::new();
            (0..4).for_each(|k| outputs.add(file(k), vec![7; 9], BTreeMap::new()).unwrap());
            let done = outputs.commit_watched(&After(after.into()));
            if after < 4 {
                assert!(done.is_err_and(|e| e.is_cancelled()), "{after}");
                assert_eq!(names(folder.path()), ["1.obj"], "{after}");
                assert_eq!(fs::read(file(1)).unwrap(), b"old");
            } else {
                assert_eq!((done.unwrap().len(), names(folder.path()).len()), (4, 4));
            }
        }
    }

    #[test]
    fn claims_that_cannot_be_met_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("input.obj"), "x").unwrap();
        fs::write(at("locked.obj"), "x").unwrap();
        let mut permissions = fs::metadata(at("locked.obj")).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(at("locked.obj"), permissions).unwrap();
        let mut outputs = Outputs::new();
        outputs.protect(at("input.obj"));
        outputs.claim(at("a.obj")).unwrap();
        let problem = |outputs: &mut Outputs, path: PathBuf| outputs.claim(path).unwrap_err().to_string();
        assert!(problem(&mut outputs, at("a.obj")).contains("twice"));
        assert!(
            problem(&mut outputs, folder.path().join(".").join("a.obj")).contains("same file")
                || cfg!(windows)
        );
        assert!(problem(&mut outputs, at("input.obj")).contains("input itself"));
        assert!(problem(&mut outputs, at("locked.obj")).contains("read-only"));
        assert!(problem(&mut outputs, folder.path().into()).contains("folder"));
        assert!(problem(&mut outputs, at("no/a.obj")).contains("does not exist"));
        assert!(problem(&mut outputs, at("input.obj/a.obj")).contains("not a folder") || cfg!(windows));
    }

    #[test]
    fn folders_are_made_when_allowed_and_taken_away_after_a_failure() {
        let folder = tempfile::tempdir().unwrap();
        let mut outputs = Outputs::new().create_folders(true);
        outputs.add(folder.path().join("x/y/a.obj"), b"new".to_vec(), BTreeMap::new()).unwrap();
        outputs.commit().unwrap();
        assert_eq!(fs::read(folder.path().join("x/y/a.obj")).unwrap(), b"new");

        let mut outputs = Outputs::new().create_folders(true);
        let last = folder.path().join("b.obj");
        outputs.add(folder.path().join("z/a.obj"), b"new".to_vec(), BTreeMap::new()).unwrap();
        outputs.add(&last, b"new".to_vec(), BTreeMap::new()).unwrap();
        fs::create_dir(&last).unwrap();
        assert!(outputs.commit().is_err());
        assert_eq!(names(folder.path()), ["b.obj", "x"]);
    }
}
