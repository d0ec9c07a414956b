//! The way out, which is the same for all formats: what the declaration says that the files of a format do not hold is
//! taken care of before the format sees the scene, and said of it afterwards.

use std::borrow::Cow;

use super::declaration::{Holds, UnitRule};
use super::error::{FormatError, FormatErrorKind};
use super::options::{UpChoice, WriteOptions};
use super::report::WriteReport;
use super::stream::Sink;
use crate::plugin::operation::Cancelled;
use crate::scene::placement::Change;
use crate::scene::{Geometry, MOST_PLACED, Object, Scene, Unit, Up};

/// A scene on its way out.
pub struct Outgoing<'a> {
    scene: Cow<'a, Scene>,
    /// How it is to be written; options of the format's own are known to be its own.
    pub options: &'a WriteOptions<'a>,
    /// The unit of the file.
    pub unit: Unit,
    /// The axis that points up in the file.
    pub up: Up,
}

impl<'a> Outgoing<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        holds: &Holds,
        options: &'a WriteOptions<'a>,
    ) -> Result<Self, FormatError> {
        let usual = match holds.unit {
            UnitRule::Fixed(unit) => unit,
            UnitRule::Stated | UnitRule::None => scene.unit,
        };
        let up = match options.up {
            UpChoice::Usual => holds.up.unwrap_or(scene.up),
            UpChoice::Keep => scene.up,
            UpChoice::To(up) => up,
        };
        let flat = if holds.instances() { Ok(Cow::Borrowed(scene)) } else { scene.flattened(MOST_PLACED) };
        let mut scene = flat.map_err(|e| FormatError::from(e).as_kind(FormatErrorKind::Limit))?;
        if holds.colors && !holds.layers && scene.colored_layers() > 0 {
            scene.to_mut().color_by_layer()?;
        }
        let unit = options.unit.unwrap_or(usual);
        if scene.unit == Unit::Unknown && unit != Unit::Unknown {
            // From here on its numbers are of that unit.
            scene.to_mut().unit = unit;
        }
        Ok(Self { scene, options, unit, up })
    }

    /// The scene in its own unit and axes; where the format has no instances, with groups of what they show.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The same in the unit and axes of the file.
    ///
    /// # Errors
    /// When a coordinate overflows.
    pub fn converted(&self) -> Result<Cow<'_, Scene>, FormatError> {
        Ok(self.scene.converted(self.unit, self.up)?)
    }

    /// Lengths in the scene to lengths in the file.
    pub fn scale(&self) -> f64 {
        Change::between((self.scene.unit, self.scene.up), (self.unit, self.up)).scale
    }

    /// Tells the observer that so many of so many objects are written.
    ///
    /// # Errors
    /// Where it wants no more.
    pub fn proceed(&self, done: usize, total: usize) -> Result<(), Cancelled> {
        self.options.observer.proceed("writing", done as u64, total as u64)
    }

    /// Each object of a scene that is [this one](Self::scene), [converted](Self::converted) or not, where it is in the world: for
    /// formats that have no hierarchy. Tells the observer; one object at a time is moved.
    ///
    /// # Errors
    /// When the hierarchy is broken, and for an object when a coordinate overflows, or the observer wants no more.
    pub fn in_world<'s>(
        &self,
        scene: &'s Scene,
    ) -> Result<impl Iterator<Item = Result<InWorld<'s>, FormatError>>, FormatError> {
        let world = scene.world_transforms()?;
        let total = world.len();
        Ok(scene.objects().iter().zip(world).enumerate().map(move |(done, (object, place))| {
            self.proceed(done, total)?;
            let geometry = match &place {
                Some(map) if !object.geometry().is_unknown() => {
                    let moved = object.geometry().transformed(map);
                    Cow::Owned(moved.map_err(|e| FormatError::from(e).of(object.name()))?)
                }
                _ => Cow::Borrowed(object.geometry()),
            };
            let is_mirrored = place.is_some_and(|m| m.fixed_view::<3, 3>(0, 0).determinant() < 0.0);
            Ok(InWorld { object, geometry, is_mirrored })
        }))
    }

    /// Puts pictures that the file names beside it, from where the scene's pictures are; notes which are not there.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn pictures<'n>(
        &self,
        names: impl IntoIterator<Item = &'n str>,
        sink: &mut dyn Sink,
        report: &mut WriteReport,
    ) -> Result<(), FormatError> {
        let (mut named, mut missing) = (0, 0);
        for name in names {
            match self.options.pictures.map(|source| source.sibling(name)) {
                Some(Ok(bytes)) => sink.picture(name, &bytes)?,
                Some(Err(error)) if error.kind == FormatErrorKind::Io => {
                    report
                        .notes
                        .push(format!("a picture is named, but does not go along: {}", error.problem));
                }
                Some(Err(_)) => missing += 1,
                None => named += 1,
            }
        }
        report.say(
            named,
            "picture file[|s] [is|are] named, not copied: [it belongs|they belong] beside the new file too",
        );
        report
            .say(missing, "picture file[|s] [is|are] named, but missing beside the source: not there either");
        Ok(())
    }
}

/// An object, where it is in the world.
#[derive(Debug)]
pub struct InWorld<'s> {
    /// The object.
    pub object: &'s Object,
    /// Its geometry, moved by all transforms from it up; that of a shape whose plug-in is not here is as it was.
    pub geometry: Cow<'s, Geometry>,
    /// Whether the transforms together mirror it.
    pub is_mirrored: bool,
}
