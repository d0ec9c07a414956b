//! A file to be read, and its siblings: never outside its folder, whatever names or links a file contains.

use std::borrow::Cow;
use std::fs;
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use loftsman_kernel::plugin::{
    Format, FormatDeclaration, FormatError, FormatErrorKind, ReadOptions, ReadReport, Registry, Source,
};
use loftsman_kernel::scene::Scene;
use loftsman_kernel::text::clip;

use crate::error::{Error, Result};

/// A file's bytes and the folder that its siblings are in.
#[derive(Debug, Clone)]
pub struct Input {
    name: String,
    bytes: Vec<u8>,
    folder: Option<PathBuf>,
    extension: String,
}

impl Input {
    /// Reads a file. `-` is the standard input, which has no siblings.
    ///
    /// # Errors
    /// When there is no such file, it is a directory or a device, or it may not be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let name = path.display().to_string();
        if name == "-" {
            let mut bytes = Vec::new();
            std::io::stdin()
                .lock()
                .read_to_end(&mut bytes)
                .map_err(|e| Error::system("standard input", "read", &e))?;
            return Ok(Self::from_bytes("standard input", bytes));
        }
        let bytes = read_file(path).map_err(|problem| match problem {
            Problem::System(e) => Error::system(&name, "read", &e),
            Problem::NotAFile(what) => Error::file(&name, what),
        })?;
        // A bare name has the empty path as its parent, which the system does not know.
        let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
        let extension = path.file_name().map(|f| f.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Self { name, bytes, folder: folder.map(Path::to_path_buf), extension })
    }

    /// Bytes from elsewhere under a name; without siblings.
    pub fn from_bytes(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { name: name.into(), bytes, folder: None, extension: String::new() }
    }

    /// The same file, to be read as the format of this extension.
    #[must_use]
    pub fn with_extension(mut self, extension: &str) -> Self {
        self.extension = format!("x.{}", extension.trim_start_matches('.'));
        self
    }

    /// Only where its siblings are: what the file itself holds is given up.
    #[must_use]
    pub fn without_bytes(self) -> Self {
        Self { bytes: Vec::new(), ..self }
    }

    /// The format of the file: by its extension where that is known, else by its content.
    ///
    /// # Errors
    /// [`Error::UnknownFormat`], with the extensions that can be read.
    pub fn format<'r>(&self, registry: &'r Registry) -> Result<&'r Arc<dyn Format>> {
        let by_extension = registry.format_of(&self.extension).filter(|f| f.declaration().reads);
        by_extension
            .or_else(|| registry.format_of_bytes(&self.bytes).filter(|f| f.declaration().reads))
            .ok_or_else(|| {
                let known = extensions(registry, |f| f.declaration().reads);
                let problem = if let Some(format) = registry.format_of(&self.extension) {
                    format!(
                        "{} can be written, but not read; readable are {known}",
                        format.declaration().name
                    )
                } else if let Some(name) = foreign(&self.extension) {
                    format!("{name} is not read: save or convert it as one of {known}")
                } else {
                    format!(
                        "neither its name nor its content belongs to a known format; readable are {known}"
                    )
                };
                Error::UnknownFormat { file: self.name.clone(), problem }
            })
    }

    /// Reads the file. One of which nothing could be kept is an error, not an empty scene; one that is rightly empty, with
    /// nothing left out, is none. Where the options name no kinds of shape, the registry's are used.
    ///
    /// # Errors
    /// Those of the format; [`Error::File`] when everything in the file was left out, with the reasons.
    pub fn read(
        &self,
        format: &dyn Format,
        options: &ReadOptions<'_>,
        registry: &Registry,
    ) -> Result<Content> {
        let kinds = if options.kinds.is_empty() { registry.shape_kinds() } else { options.kinds };
        let (scene, report) = format.read(self, &ReadOptions { kinds, ..options.clone() })?;
        if scene.objects().is_empty() && !report.left_out.is_empty() {
            let problem = format!("nothing in it could be read: {}", reasons(&report));
            return Err(Error::file(&self.name, problem));
        }
        Ok(Content { scene, report, format: format.declaration() })
    }
}

/// The name of a format that people have files of and that is not read, by the extension of the file.
pub(super) fn foreign(file: &str) -> Option<&'static str> {
    const FOREIGN: &[(&str, &str)] = &[
        ("3dm", "Rhino's 3DM"),
        ("3ds", "3DS"),
        ("blend", "Blender's own format"),
        ("brep", "OpenCASCADE's BREP"),
        ("dae", "COLLADA"),
        ("dwg", "DWG"),
        ("dxf", "DXF"),
        ("fbx", "FBX"),
        ("off", "OFF"),
        ("ply", "PLY"),
        ("png", "PNG"),
        ("sat", "ACIS"),
        ("sldprt", "SolidWorks' own format"),
        ("stl", "STL"),
        ("svg", "SVG"),
        ("usd", "USD"),
        ("usda", "USD"),
        ("usdc", "USD"),
        ("usdz", "USD"),
        ("x_t", "Parasolid"),
    ];
    let (_, extension) = file.rsplit_once('.')?;
    FOREIGN.iter().find(|(known, _)| extension.eq_ignore_ascii_case(known)).map(|(_, name)| *name)
}

/// What is in a file.
#[derive(Debug, Clone)]
pub struct Content {
    /// Its scene.
    pub scene: Scene,
    /// What was kept and what was left out.
    pub report: ReadReport,
    /// Its format.
    pub format: FormatDeclaration,
}

/// What a reader left out, in a line; `None` where it left out nothing.
#[must_use]
pub fn left_out(path: &str, report: &ReadReport) -> Option<String> {
    let number: usize = report.left_out.values().sum();
    (number > 0).then(|| format!("{path}: left out {number} of {}: {}", report.entities, reasons(report)))
}

fn reasons(report: &ReadReport) -> String {
    let all: Vec<String> = report.left_out.iter().map(|(why, number)| format!("{why} ({number})")).collect();
    all.join("; ")
}

/// The extensions of formats, for messages.
pub(crate) fn extensions(registry: &Registry, wanted: impl Fn(&dyn Format) -> bool) -> String {
    let all: Vec<String> = registry
        .formats()
        .iter()
        .filter(|f| wanted(f.as_ref()))
        .flat_map(|f| f.declaration().extensions.iter().map(|e| format!(".{e}")))
        .collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}

enum Problem {
    System(std::io::Error),
    NotAFile(&'static str),
}

fn read_file(path: &Path) -> std::result::Result<Vec<u8>, Problem> {
    let kind = fs::metadata(path).map_err(Problem::System)?.file_type();
    if kind.is_dir() {
        return Err(Problem::NotAFile("this is a folder; name a file in it"));
    }
    // A pipe (as of a shell's process substitution) ends; a device such as /dev/zero may not.
    if !kind.is_file() && !is_pipe(kind) {
        return Err(Problem::NotAFile(
            "this is a device, not a file; name a file, or - for the standard input",
        ));
    }
    fs::read(path).map_err(Problem::System)
}

#[cfg(unix)]
fn is_pipe(kind: fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: fs::FileType) -> bool {
    false
}

impl Source for Input {
    fn name(&self) -> &str {
        &self.name
    }

    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn sibling(&self, name: &str) -> std::result::Result<Cow<'_, [u8]>, FormatError> {
        let fail = |problem: String| FormatError::whole(problem);
        let shown = clip(name);
        let Some(folder) = &self.folder else {
            return Err(fail(format!("it refers to the file \"{shown}\", but has no folder to find it in")));
        };
        let inside =
            Path::new(name).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if name.is_empty() || name.contains(['\0', '\\']) || !inside {
            return Err(fail(format!(
                "it refers to the file \"{shown}\", which is not in its folder; copy that file beside it"
            )));
        }
        let system = |error: std::io::Error| match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => {
                fail(format!("the file \"{shown}\" beside it is missing"))
            }
            _ => fail(format!("the file \"{shown}\" beside it cannot be read: {error}"))
                .as_kind(FormatErrorKind::Io),
        };
        // Links are resolved before the comparison, so that none leads out.
        let root = folder.canonicalize().map_err(system)?;
        let path = root.join(name).canonicalize().map_err(system)?;
        if !path.starts_with(&root) {
            return Err(fail(format!(
                "the file \"{shown}\" beside it is a link that leads out of the folder"
            )));
        }
        if !fs::metadata(&path).map_err(system)?.is_file() {
            return Err(fail(format!("\"{shown}\" beside it is not a file")));
        }
        fs::read(&path).map(Cow::Owned).map_err(system)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn siblings_stay_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).unwrap();
        fs::write(folder.path().join("secret"), "no").unwrap();
        fs::write(inner.join("a.obj"), "x").unwrap();
        fs::write(inner.join("a.mtl"), "yes").unwrap();
        let input = Input::open(inner.join("a.obj")).unwrap();
        assert_eq!(input.sibling("a.mtl").unwrap().as_ref(), b"yes");
        let absolute = folder.path().join("secret").display().to_string();
        for name in ["../secret", &absolute, "", "\0", "..", ".", "missing", "..\\secret", "./../secret"] {
            assert!(input.sibling(name).is_err(), "{name}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../secret", inner.join("link")).unwrap();
            let error = input.sibling("link").unwrap_err();
            assert!(error.problem.contains("leads out"), "{error}");
        }
    }

    #[test]
    fn directories_and_missing_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Input::open(folder.path()).unwrap_err().to_string().contains("folder"));
        assert!(Input::open(folder.path().join("no")).unwrap_err().to_string().contains("no such file"));
    }
}
