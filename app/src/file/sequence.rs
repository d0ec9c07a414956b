//! One file for each frame: `rope_####.obj`.

use std::path::{Path, PathBuf};

use loftsman_kernel::plugin::{Observer, WriteReport};
use loftsman_kernel::scene::Scene;

use super::output::Produced;
use crate::error::{Error, Result};

/// A file name with a run of two or more `#`, which stands for the number of a frame: from 0 on, with at least so many digits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sequence {
    path: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Sequence {
    /// The sequence that a path names; `None` where it names one file.
    ///
    /// # Errors
    /// When its name has two such runs.
    pub fn of(path: impl AsRef<Path>) -> Result<Option<Self>> {
        let path = path.as_ref();
        let Some(name) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            return Ok(None);
        };
        let Some(start) = name.find("##") else { return Ok(None) };
        let rest = name[start..].trim_start_matches('#');
        if rest.contains("##") {
            let problem = "the name has two runs of #, and one number a frame: leave one out";
            return Err(Error::file(path.display().to_string(), problem));
        }
        let digits = name.len() - start - rest.len();
        let (before, after) = (name[..start].to_owned(), rest.to_owned());
        Ok(Some(Self { path: path.to_path_buf(), before, digits, after }))
    }

    /// As it was asked for.
    pub fn shown(&self) -> String {
        self.path.display().to_string()
    }

    /// The file of a frame.
    pub fn file(&self, frame: usize) -> PathBuf {
        let (before, after, digits) = (&self.before, &self.after, self.digits);
        self.path.with_file_name(format!("{before}{frame:0digits$}{after}"))
    }

    /// Goes through the frames of a scene ([`Scene::moments`]), each with its file and the moment that it shows.
    ///
    /// # Errors
    /// When nothing in the scene is animated, what is done with a frame fails, or the observer stops it.
    pub fn each<T>(
        &self,
        scene: &Scene,
        observer: &dyn Observer,
        mut one: impl FnMut(&Path, f64) -> Result<T>,
    ) -> Result<Vec<T>> {
        let moments = scene.moments()?;
        if moments.is_empty() {
            let hashes = "#".repeat(self.digits);
            return Err(Error::file(
                self.shown(),
                format!(
                    "{hashes} asks for a file for each frame, and nothing in the scene is animated; leave it out, or keep frames (`drag` with `frames = true`)"
                ),
            ));
        }
        let mut all = Vec::with_capacity(moments.len());
        for (frame, &moment) in moments.iter().enumerate() {
            observer.proceed("frames", frame as u64, moments.len() as u64)?;
            all.push(one(&self.file(frame), moment)?);
        }
        Ok(all)
    }

    /// What is to be said of the files of so many frames: which they are, and where there are more from before.
    pub fn notes(&self, count: usize) -> Vec<String> {
        let name = |frame: usize| self.file(frame).display().to_string();
        let mut notes = vec![match count {
            1 => format!("1 frame: {}", name(0)),
            _ => format!("{count} frames: {} to {}", name(0), name(count - 1)),
        }];
        if self.file(count).exists() {
            notes.push(format!("{} was there before, and is no frame of these", name(count)));
        }
        notes
    }

    /// How all frames went out, as one: of each object the worst, and every note once.
    pub fn report(frames: impl IntoIterator<Item = WriteReport>) -> WriteReport {
        let mut frames = frames.into_iter();
        let mut all = frames.next().unwrap_or_default();
        for frame in frames {
            for (whole, one) in all.objects.iter_mut().zip(frame.objects) {
                let most = |a: Option<f64>, b: Option<f64>| match (a, b) {
                    (Some(a), Some(b)) => Some(a.max(b)),
                    (a, b) => a.or(b),
                };
                whole.tolerance = most(whole.tolerance, one.tolerance);
                whole.error = most(whole.error, one.error);
            }
            for note in frame.notes {
                if !all.notes.contains(&note) {
                    all.notes.push(note);
                }
            }
        }
        all
    }

    /// The files that were written, as one: their number of bytes together.
    pub fn produced(&self, files: &[Produced]) -> Produced {
        Produced {
            path: self.shown(),
            bytes: files.iter().map(|file| file.bytes).sum(),
            siblings: Vec::new(),
            completed: files.iter().flat_map(|file| file.completed.iter().cloned()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_hashes_is_a_number() {
        let file = |path: &str, frame: usize| {
            let sequence = Sequence::of(path).unwrap().unwrap();
            sequence.file(frame).to_str().unwrap().to_owned()
        };
        assert_eq!(file("out/rope_####.obj", 7), "out/rope_0007.obj");
        assert_eq!(file("##.glb", 123), "123.glb");
        assert_eq!(file("a###b#.loft.json", 0), "a000b#.loft.json");
        for one in ["rope.obj", "rope#1.obj", "a##b/rope.obj", "..", ""] {
            assert_eq!(Sequence::of(one).unwrap(), None, "{one}");
        }
        let twice = Sequence::of("a##b##.obj").unwrap_err().to_string();
        assert!(twice.contains("a##b##.obj") && twice.contains("two runs"), "{twice}");
    }
}
