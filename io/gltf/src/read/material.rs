//! Materials, their textures and pictures.

use std::sync::Arc;

use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};
use loftsman_kernel::scene::Scene;
use serde_json::Value;

use super::buffers::{data, relative, string};
use super::file::{File, clip, parse};
use super::report::LARGEST;
use super::schema;
use crate::texture::flipped;
use crate::words::{COLOR, EXTRAS, NONE, PREFIX, SOURCES, UNNAMED, UNNAMED_IMAGE};

/// What a material of the file became.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Look {
    /// The scene's material of this name.
    Material(String),
    /// The colour of an object, for which our writer made the material of this name.
    Color(String, [f64; 4]),
    /// Nothing: our writer made the material for an object that has neither colour nor material.
    Nothing,
}

/// Puts the pictures and materials of the file into the scene, and says what each material became.
pub(super) fn read(
    file: &File<'_>,
    scene: &mut Scene,
    report: &mut ReadReport,
) -> Result<Vec<Look>, FormatError> {
    let images = images(file, scene, report)?;
    let mut looks = Vec::with_capacity(file.root.materials.len());
    for index in 0..file.root.materials.len() {
        let path = format!("materials[{index}]");
        file.take(&path, 1, 512)?;
        let raw: schema::Material<'_> = file.entry("materials", &file.root.materials, index)?;
        let reader = Reader { file, images: &images, path };
        looks.push(reader.material(raw, index, scene, report)?);
    }
    Ok(looks)
}

/// The names that the pictures of the file have in the scene; `None` for those that are left out.
fn images(
    file: &File<'_>,
    scene: &mut Scene,
    report: &mut ReadReport,
) -> Result<Vec<Option<String>>, FormatError> {
    let mut names = Vec::with_capacity(file.root.images.len());
    for index in 0..file.root.images.len() {
        let path = format!("images[{index}]");
        let raw: schema::Image<'_> = file.entry("images", &file.root.images, index)?;
        super::report::extensions(raw.extensions.as_ref(), "image", report);
        let noted = usize::from(raw.extras.0);
        report.count_many(Fate::LeftOut, "extras of an image: data of other programs", noted);
        let fail = |problem: String| file.fail(&path, problem);
        let (data, from) = match (raw.uri, raw.buffer_view) {
            (Some(uri), _) => {
                let text = string(uri).map_err(&fail)?;
                match data(&text).map_err(&fail)? {
                    Some((kind, bytes)) => (Ok((raw.mime_type.unwrap_or(kind), bytes)), None),
                    None => (Err(relative(&text).and_then(inside)), Some(text.into_owned())),
                }
            }
            (None, Some(view)) => {
                let bytes = file.view(view.index())?.bytes;
                file.take(&path, bytes.len(), 1)?;
                (Ok((raw.mime_type.unwrap_or_default(), bytes.to_vec())), None)
            }
            (None, None) => {
                report.count(Fate::LeftOut, "image without a uri or bufferView");
                names.push(None);
                continue;
            }
        };
        let data = match data {
            Ok((media_type_said, bytes)) => {
                let found = ImageData::media_type_of(&bytes).map(str::to_owned);
                let media_type =
                    if media_type_said.is_empty() { found.unwrap_or_default() } else { media_type_said };
                ImageData::Embedded { media_type, bytes: Arc::from(bytes) }
            }
            Err(Ok(name)) => ImageData::File(name),
            Err(Err(problem)) => {
                report.count(Fate::LeftOut, &format!("image: {problem}"));
                names.push(None);
                continue;
            }
        };
        let stem = from.as_deref().map(|f| f.rsplit('/').next().unwrap_or(f).to_owned());
        let said = raw.name.filter(|n| !n.is_empty());
        // One that is embedded has no name but this.
        let is_unnamed = said.is_none() && stem.is_none();
        let wanted = said.or(stem).unwrap_or_else(|| format!("image {index}"));
        let name = scene.images.unique_name(&wanted);
        if is_unnamed {
            scene.statements.push((UNNAMED_IMAGE.to_owned(), name.clone()));
        }
        scene.images.add(Image::new(&name, data)).map_err(|e| fail(e.to_string()))?;
        report.count(Fate::Kept, "");
        names.push(Some(name));
    }
    Ok(names)
}

/// A name that does not lead out of the folder.
fn inside(name: String) -> Result<String, String> {
    let out = name.is_empty() || name.starts_with('/') || name.contains(['\\', '\0']);
    if out || name.split('/').any(|part| part == "..") {
        return Err(format!("\"{}\" leads out of the folder; copy the picture beside the file", clip(&name)));
    }
    Ok(name)
}

struct Reader<'r, 'a> {
    file: &'r File<'a>,
    images: &'r [Option<String>],
    path: String,
}

impl Reader<'_, '_> {
    fn material(
        &self,
        raw: schema::Material<'_>,
        index: usize,
        scene: &mut Scene,
        report: &mut ReadReport,
    ) -> Result<Look, FormatError> {
        let pbr = raw.pbr_metallic_roughness.unwrap_or_default();
        super::report::extensions(pbr.extensions.as_ref(), "pbrMetallicRoughness", report);
        let noted = usize::from(pbr.extras.0);
        report.count_many(Fate::LeftOut, "extras of a pbrMetallicRoughness: data of other programs", noted);
        let said = raw.name.filter(|n| !n.is_empty());
        let is_unnamed = said.is_none();
        let wanted = said.unwrap_or_else(|| format!("material {index}"));
        let name = scene.materials.unique_name(&wanted);
        let mut material = Material::new(&name, pbr.base_color_factor.unwrap_or([1.0; 4]));
        material.metallic = pbr.metallic_factor.unwrap_or(1.0);
        material.roughness = pbr.roughness_factor.unwrap_or(1.0);
        material.emissive = raw.emissive_factor.unwrap_or([0.0; 3]);
        material.double_sided = raw.double_sided;
        material.alpha = match raw.alpha_mode.as_deref() {
            None | Some("OPAQUE") => Alpha::Opaque,
            Some("MASK") => Alpha::Mask(raw.alpha_cutoff.unwrap_or(0.5)),
            Some("BLEND") => Alpha::Blend,
            Some(other) => {
                let problem = format!("\"{}\" is none of OPAQUE, MASK and BLEND", clip(other));
                return Err(self.file.fail(format!("{}.alphaMode", self.path), problem));
            }
        };
        let textures = [
            (Channel::BaseColor, pbr.base_color_texture),
            (Channel::MetallicRoughness, pbr.metallic_roughness_texture),
            (Channel::Normal, raw.normal_texture),
            (Channel::Occlusion, raw.occlusion_texture),
            (Channel::Emissive, raw.emissive_texture),
        ];
        for (channel, info) in textures {
            if let Some(info) = info
                && let Some(texture) = self.texture(&info, report)?
            {
                material.textures.insert(channel, texture);
            }
        }
        for (extension, value) in raw.extensions.iter().flatten() {
            self.extension(extension, value.get(), &mut material, report)?;
        }
        let large = raw.extras.is_some_and(|extras| extras.get().len() > LARGEST);
        report.count_many(Fate::LeftOut, "extras of a material, larger than a megabyte", usize::from(large));
        let own =
            raw.extras.filter(|_| !large).and_then(|extras| serde_json::from_str::<Value>(extras.get()).ok());
        match own.as_ref().and_then(|e| e.get(EXTRAS)).and_then(Value::as_str) {
            // Whoever changed the material since then wants a material.
            Some(mark @ (COLOR | NONE)) if is_plain(&material) => {
                report.count(Fate::Kept, "");
                return Ok(if mark == COLOR {
                    Look::Color(material.name().to_owned(), material.base_color)
                } else {
                    Look::Nothing
                });
            }
            Some(_) => {}
            None => {
                if let Some(extras) = &own {
                    material.statements.push((format!("{PREFIX}extras"), extras.to_string()));
                }
            }
        }
        if is_unnamed {
            material.statements.push((UNNAMED.to_owned(), name.clone()));
        }
        report.count(Fate::Kept, "");
        scene.materials.add(material).map_err(|e| self.file.fail(&self.path, e.to_string()))?;
        Ok(Look::Material(name))
    }

    /// An extension of a material: what the kernel has a field for, or else a statement and textures of other channels.
    fn extension(
        &self,
        name: &str,
        text: &str,
        material: &mut Material,
        report: &mut ReadReport,
    ) -> Result<(), FormatError> {
        let path = format!("{}.extensions.{}", self.path, clip(name));
        if text.len() > LARGEST {
            report.count(
                Fate::LeftOut,
                &format!("extension {} of a material, larger than a megabyte", clip(name)),
            );
            return Ok(());
        }
        let mut value: Value = parse(&path, text)?;
        if name == "KHR_materials_emissive_strength" {
            let strength = value.get("emissiveStrength").and_then(Value::as_f64).unwrap_or(1.0);
            material.emissive = material.emissive.map(|e| e * strength);
            report.count(Fate::Kept, "");
            return Ok(());
        }
        if let Some(fields) = value.as_object_mut() {
            let shown: Vec<String> = fields
                .iter()
                .filter(|(key, value)| key.ends_with("Texture") && value.get("index").is_some())
                .map(|(key, _)| key.clone())
                .collect();
            for key in shown {
                let Some(info) = fields.shift_remove(&key) else { continue };
                let info = info.to_string();
                let info: schema::TextureInfo<'_> = parse(&format!("{path}.{key}"), &info)?;
                if let Some(texture) = self.texture(&info, report)? {
                    material.textures.insert(Channel::Other(format!("{name}.{key}")), texture);
                }
            }
        }
        material.statements.push((format!("{PREFIX}{name}"), value.to_string()));
        report.count(Fate::Kept, "");
        Ok(())
    }

    fn texture(
        &self,
        info: &schema::TextureInfo<'_>,
        report: &mut ReadReport,
    ) -> Result<Option<Texture>, FormatError> {
        let (file, index) = (self.file, info.index.index());
        let Some(texture) = file.root.textures.get(index) else {
            return Err(file.missing("textures", index, file.root.textures.len()));
        };
        // The plain picture is for readers that do not know an extension's, which shows the same.
        let mut source = texture.source;
        for (name, value) in texture.extensions.iter().flat_map(|e| e.iter()) {
            if !SOURCES.iter().any(|(known, _)| known == name) {
                report.count(Fate::LeftOut, &format!("extension {} of a texture", clip(name)));
            } else if source.is_some() {
                let what = format!("further picture of a texture ({name}): the plain one is taken");
                report.count(Fate::LeftOut, &what);
            } else {
                let path = format!("textures[{index}].extensions.{name}");
                let other: schema::Texture<'_> = parse(&path, value.get())?;
                source = other.source;
            }
        }
        let image = match source.map(schema::Whole::index) {
            None => {
                report.count(Fate::LeftOut, "texture without a picture");
                return Ok(None);
            }
            Some(source) => match self.images.get(source) {
                None => return Err(file.missing("images", source, self.images.len())),
                Some(None) => {
                    report.count(Fate::LeftOut, "texture whose picture was left out");
                    return Ok(None);
                }
                Some(Some(name)) => name,
            },
        };
        let noted = usize::from(info.extras.0);
        report.count_many(Fate::LeftOut, "extras of a texture in a material: data of other programs", noted);
        for name in info.extensions.iter().flat_map(|e| e.keys()).filter(|e| *e != "KHR_texture_transform") {
            report.count(Fate::LeftOut, &format!("extension {} of a texture in a material", clip(name)));
        }
        let set = |set: schema::Whole| u32::try_from(set.0).unwrap_or(u32::MAX);
        let mut out = Texture::new(image);
        out.set = info.tex_coord.map_or(0, set);
        out.strength = info.scale.or(info.strength).unwrap_or(1.0);
        if let Some(transform) = info.extensions.as_ref().and_then(|e| e.get("KHR_texture_transform")) {
            let path = format!("{}: KHR_texture_transform", self.path);
            let transform: schema::TextureTransform = parse(&path, transform.get())?;
            out.rotation = transform.rotation.unwrap_or(0.0);
            out.tiling = transform.scale.unwrap_or([1.0; 2]);
            out.offset = flipped(transform.offset.unwrap_or([0.0; 2]), out.rotation, out.tiling);
            out.set = transform.tex_coord.map_or(out.set, set);
        }
        if let Some(sampler) = texture.sampler.map(schema::Whole::index) {
            let Some(sampler) = file.root.samplers.get(sampler) else {
                return Err(file.missing("samplers", sampler, file.root.samplers.len()));
            };
            let fail = |field: &str, code: u64| {
                let place = format!("samplers: {field} of textures[{index}]");
                Err(file.fail(place, format!("the value {code} does not exist")))
            };
            for (axis, wrap) in [sampler.wrap_s, sampler.wrap_t].into_iter().enumerate() {
                out.wrap[axis] = match wrap.map_or(10497, |w| w.0) {
                    10497 => Wrap::Repeat,
                    33648 => Wrap::Mirror,
                    33071 => Wrap::Clamp,
                    code => return fail("wrap", code),
                };
            }
            for (filter, slot) in
                [(sampler.mag_filter, &mut out.magnify), (sampler.min_filter, &mut out.minify)]
            {
                *slot = match filter.map(|f| f.0) {
                    None => None,
                    Some(9728) => Some(Filter::Nearest),
                    Some(9729) => Some(Filter::Linear),
                    Some(9984) => Some(Filter::NearestOfNearest),
                    Some(9985) => Some(Filter::LinearOfNearest),
                    Some(9986) => Some(Filter::NearestOfMixed),
                    Some(9987) => Some(Filter::LinearOfMixed),
                    Some(code) => return fail("filter", code),
                };
            }
        }
        Ok(Some(out))
    }
}

/// Whether a material is of one colour, as our writer makes them for objects.
fn is_plain(material: &Material) -> bool {
    let usual = Material::new(material.name(), material.base_color);
    material.textures.is_empty()
        && material.statements.is_empty()
        && material.metallic == usual.metallic
        && material.roughness == usual.roughness
        && material.emissive == usual.emissive
}
