//! The reader: one object a node, its mesh with material slots.

mod accessor;
mod animation;
mod body;
mod buffers;
mod container;
mod file;
mod layers;
mod material;
mod mesh;
mod nodes;
mod noted;
mod report;
mod schema;
mod shared;
mod tree;

use loftsman_kernel::named::NamedList;
use loftsman_kernel::plugin::{Fate, FormatError, FormatErrorKind, Place, ReadOptions, ReadReport, Source};
use loftsman_kernel::scene::{Layer, Scene, Unit, Up};
use serde::Deserialize;
use serde_json::Value;

use buffers::Buffers;
use file::{Budget, File, clip, parse};
use schema::Root;

use crate::extras::LayerFields;
use crate::words::{ASSET_DATA, COPYRIGHT, DATA, EXTRAS, SOURCES};

/// `asset.extras`, as far as they are ours.
#[derive(Debug, Deserialize)]
struct AssetExtras {
    loftsman: Noted,
}

/// The unit and up axis that our writer notes, and the layers.
#[derive(Debug, Deserialize)]
struct Noted {
    unit: Option<Unit>,
    up: Option<Up>,
    layers: Option<Value>,
}

/// The layers that our writer notes; none where they cannot be.
fn layers(noted: Option<Value>, report: &mut ReadReport) -> NamedList<Layer> {
    let Some(noted) = noted else { return NamedList::default() };
    let made = serde_json::from_value(noted)
        .map_err(|e| e.to_string())
        .and_then(|list| LayerFields::make(list).map_err(|e| e.to_string()));
    made.unwrap_or_else(|problem| {
        report.count(Fate::LeftOut, "layers in asset.extras.loftsman that cannot be");
        report.notes.push(format!("asset.extras.loftsman.layers: {}", clip(&problem)));
        NamedList::default()
    })
}

/// Reads a file.
pub(crate) fn read(
    source: &dyn Source,
    options: &ReadOptions<'_>,
) -> Result<(Scene, ReadReport), FormatError> {
    let parts = container::parts(source.bytes())?;
    let mut report = ReadReport { notes: parts.notes, ..ReadReport::default() };
    report.count_many(Fate::LeftOut, "chunk of a type that the standard does not know", parts.unknown_chunks);
    let root: Root<'_> = parse("", parts.json)?;
    check_version(&root)?;
    check_required(&root)?;
    let buffers = Buffers::load(&root.buffers, parts.binary, source);
    let budget = Budget::of(source.bytes().len() as u64 + buffers.len());
    options.limits.check_entities(root.nodes.len())?;
    let file = File { root, buffers, budget };
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Metre, Up::Y);
    let extras = file.root.asset.as_ref().and_then(|asset| asset.extras);
    let noted = extras.and_then(|extras| serde_json::from_str::<AssetExtras>(extras.get()).ok());
    let noted = noted.map(|noted| noted.loftsman);
    let (unit, up) = noted.as_ref().map_or((None, None), |noted| (noted.unit, noted.up));
    let said = unit.is_some() || up.is_some();
    // Who says what the file's numbers are means these as they stand there.
    let told = options.unit.is_some() || options.up.is_some();
    let of_asset = (unit.unwrap_or(scene.unit), up.unwrap_or(scene.up));
    let frames = noted::Frames {
        of_file: of_asset,
        of_scene: if told {
            (scene.unit, scene.up)
        } else if said {
            of_asset
        } else {
            noted::common(&file.root.nodes, &mut report).unwrap_or(of_asset)
        },
    };
    scene.layers = layers(noted.and_then(|noted| noted.layers), &mut report);
    if let Some(copyright) = file.root.asset.as_ref().and_then(|asset| asset.copyright.clone()) {
        scene.statements.push((COPYRIGHT.to_owned(), copyright));
    }
    report::keep(extras, "asset", &[EXTRAS], ASSET_DATA, &mut scene.statements, &mut report);
    report::keep(file.root.extras, "file", &[], DATA, &mut scene.statements, &mut report);
    report::inner(&file.root, &mut report);
    let looks = material::read(&file, &mut scene, &mut report)?;
    let scene = nodes::read(&file, scene, frames, &looks, options, &mut report)?;
    for (count, what) in [
        (file.root.skins.len(), "skin: meshes are in their rest position"),
        (file.root.cameras.len(), "camera"),
    ] {
        report.count_many(Fate::LeftOut, what, count);
    }
    report::extensions(file.root.extensions.as_ref(), "file", &mut report);
    scene.check()?;
    Ok((scene, report))
}

fn unsupported(path: String, problem: String) -> FormatError {
    FormatError::new(Place::Path(path), problem).as_kind(FormatErrorKind::Unsupported)
}

fn check_version(root: &Root<'_>) -> Result<(), FormatError> {
    let Some(asset) = &root.asset else {
        let problem =
            "a glTF document says its version in asset.version, this one has no asset: it is another JSON";
        return Err(FormatError::new(Place::Path("asset".to_owned()), problem));
    };
    // A file may be of a later minor version as long as it needs no later one.
    let needed = asset.min_version.as_deref().unwrap_or(&asset.version);
    if asset.version.split('.').next() == Some("2") && (asset.min_version.is_none() || needed == "2.0") {
        return Ok(());
    }
    let problem = format!(
        "glTF {} is needed to read it, and only 2.0 is read: convert it to glTF 2.0 first (glTF 1: `gltf-pipeline -i in.gltf -o out.gltf`)",
        clip(needed)
    );
    Err(unsupported("asset.version".to_owned(), problem))
}

/// Extensions that a file may need: those that are read, and those without which shapes and colours are still right.
fn is_known(extension: &str) -> bool {
    matches!(
        extension,
        "KHR_mesh_quantization" | "KHR_texture_transform" | "KHR_lights_punctual" | "KHR_xmp_json_ld"
    ) || extension.starts_with("KHR_materials_")
        || extension.starts_with("EXT_materials_")
        || SOURCES.iter().any(|(name, _)| *name == extension)
}

fn check_required(root: &Root<'_>) -> Result<(), FormatError> {
    let Some((at, extension)) = root.extensions_required.iter().enumerate().find(|(_, e)| !is_known(e))
    else {
        return Ok(());
    };
    let advice = match extension.as_str() {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "write it again without compression (gltf-transform: `gltf-transform copy in.glb out.glb`)"
        }
        "EXT_mesh_gpu_instancing" => "write it again with a node for each instance",
        _ => "write it again without this extension",
    };
    let problem = format!(
        "the file cannot be read without the extension {}, which is not known here: {advice}",
        clip(extension)
    );
    Err(unsupported(format!("extensionsRequired[{at}]"), problem))
}
