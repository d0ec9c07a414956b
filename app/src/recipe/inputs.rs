//! The inputs of a recipe: none, one, or several that become one scene.

use loftsman_kernel::material::{Image, ImageData};
use loftsman_kernel::named::{Named, NamedList};
use loftsman_kernel::plugin::{FormatDeclaration, Observer, Registry, Source};
use loftsman_kernel::scene::{Scene, Side};

use super::Recipe;
use super::report::InputReport;
use crate::error::{Error, Result};
use crate::file::{Content, Input};

/// What was read.
pub(super) struct Inputs {
    /// The one scene.
    pub(super) scene: Scene,
    /// The input, where there was one; the first of several.
    pub(super) first: Option<InputReport>,
    /// The inputs after the first.
    pub(super) more: Vec<InputReport>,
    /// The format of the first input.
    pub(super) format: Option<FormatDeclaration>,
    /// The first input without its bytes, for its pictures; those of the others are in the scene.
    pub(super) source: Option<Input>,
}

impl Inputs {
    /// Reads a recipe's inputs. Those after the first join it in its unit and with its axis up ([`Scene::merge`]).
    ///
    /// # Errors
    /// When one cannot be read or cannot join the others; with its place in the recipe where the recipe is wrong.
    pub(super) fn read(recipe: &Recipe, observer: &dyn Observer, registry: &Registry) -> Result<Self> {
        let conversion = &recipe.conversion;
        let Some((first, others)) = recipe.inputs.split_first() else {
            if !conversion.read.is_empty() {
                let problem = "there is no input to be read so: name one, or leave this out";
                return Err(recipe.error("read", problem));
            }
            // Nothing is read that could say another unit.
            let mut scene = Scene::new();
            scene.unit = conversion.unit.unwrap_or_default();
            return Ok(Self { scene, first: None, more: Vec::new(), format: None, source: None });
        };
        let place = |i: usize| if others.is_empty() { "input".to_owned() } else { format!("input[{i}]") };
        let open = |name: &str, place: String| {
            Input::open(recipe.resolve(name)).map_err(|e| match e {
                Error::File { path, problem, .. } => recipe.error(place, format!("{path}: {problem}")),
                other => other,
            })
        };
        let source = open(first, place(0))?;
        let Content { mut scene, report, format } = conversion.read(&source, observer, registry)?;
        let path = Source::name(&source).to_owned();
        let first = Some(InputReport { path, format: format.name, report, notes: Vec::new() });
        let mut more = Vec::with_capacity(others.len());
        for (number, name) in others.iter().enumerate() {
            observer.proceed("inputs", number as u64 + 1, recipe.inputs.len() as u64)?;
            let place = place(number + 1);
            let next = open(name, place.clone())?;
            let mut content = conversion.read_beside(format.name, &next, observer, registry)?;
            let mut notes = embed_pictures(&mut content.scene, &next, Some(&source))?;
            let merged = scene.merge(&content.scene).map_err(|e| recipe.error(place, e.to_string()))?;
            notes.extend(merged.notes(|side| match side {
                Side::First => "give the recipe a `unit`",
                // The recipe's own would be that of the first input, whose numbers it would take for others than they are.
                Side::Other => {
                    "leave it out of `input` and add it by a step `merge`, which has a `unit` of its own"
                }
            }));
            let (path, report) = (Source::name(&next).to_owned(), content.report);
            more.push(InputReport { path, format: content.format.name, report, notes });
        }
        Ok(Self { scene, first, more, format: Some(format), source: Some(source.without_bytes()) })
    }
}

/// Takes along the pictures that a scene names by file, where the first input has not the same beside it: files of other inputs
/// may lie in another folder. What is said of those that cannot be read.
pub(super) fn embed_pictures(
    scene: &mut Scene,
    source: &Input,
    first: Option<&Input>,
) -> Result<Vec<String>> {
    let known = |file: &str| first.and_then(|first| first.sibling(file).ok());
    let mut notes = Vec::new();
    let mut images = NamedList::default();
    for image in &scene.images {
        let mut data = image.data.clone();
        if let ImageData::File(file) = &image.data {
            match source.sibling(file) {
                Ok(bytes) if known(file).is_some_and(|known| known == bytes) => {}
                Ok(bytes) => {
                    let found = ImageData::media_type_of(&bytes);
                    let media_type = found.unwrap_or("application/octet-stream").to_owned();
                    data = ImageData::Embedded { media_type, bytes: bytes.into() };
                }
                Err(e) => notes.push(e.to_string()),
            }
        }
        images.add(Image::new(image.name(), data))?;
    }
    scene.images = images;
    Ok(notes)
}
