//! Materials, textures, pictures; and materials made up for colours.

use std::collections::{BTreeMap, HashMap};

use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::Source;
use loftsman_kernel::scene::Scene;
use serde_json::{Map, Value, json};

use super::bin::{Bin, percent_encoded};
use super::schema::Root;
use crate::texture::flipped_back;
use crate::words::{COLOR, EXTRAS, MATERIAL, NONE, PREFIX, SOURCES, UNNAMED, UNNAMED_IMAGE};
use loftsman_kernel::text::counted;

/// The materials that were written, and what they refer to.
pub(super) struct Materials<'a> {
    scene: &'a Scene,
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    used: Vec<String>,
    required: Vec<String>,
    /// A scene's material by its name and the sets of texture coordinates that it may use.
    by_name: HashMap<(&'a str, u32), usize>,
    /// The material of each colour, by its bits; and of colours of vertices.
    by_color: HashMap<Option<[u64; 4]>, usize>,
    by_image: HashMap<&'a str, Option<Shown>>,
    /// Textures by their picture and sampler.
    by_texture: HashMap<(usize, Option<usize>), usize>,
    by_sampler: HashMap<String, usize>,
    /// Where pictures that are files are found; whether they stay files.
    source: Option<&'a dyn Source>,
    text: bool,
    /// Pictures that go out beside the document.
    beside: Vec<(String, Vec<u8>)>,
    pub(super) notes: Vec<String>,
}

/// A picture in the file; with the extension that its type needs.
#[derive(Debug, Clone, Copy)]
struct Shown {
    index: usize,
    extension: Option<&'static str>,
}

/// A colour value within 0 to 1; NaN and -0 become 0.
pub(super) fn shade(value: f64) -> f64 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// Whether single precision, with which glTF is read, holds a number.
fn fits(value: f64) -> bool {
    (value as f32).is_finite()
}

/// Whether a material is no more than a colour, as our writer made it and as it was read: nothing has been changed of it but that.
fn is_paint(material: &Material) -> bool {
    let mut usual = Material::new(material.name(), material.base_color);
    usual.double_sided = true;
    usual.statements.push((MATERIAL.to_owned(), COLOR.to_owned()));
    *material == usual
}

impl<'a> Materials<'a> {
    pub(super) fn new(scene: &'a Scene, source: Option<&'a dyn Source>, text: bool) -> Self {
        Self {
            scene,
            materials: Vec::new(),
            textures: Vec::new(),
            images: Vec::new(),
            samplers: Vec::new(),
            used: Vec::new(),
            required: Vec::new(),
            by_name: HashMap::new(),
            by_color: HashMap::new(),
            by_image: HashMap::new(),
            by_texture: HashMap::new(),
            by_sampler: HashMap::new(),
            source,
            text,
            beside: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Puts everything into the document; the notes, and the pictures that belong beside it.
    pub(super) fn finish(self, root: &mut Root) -> (Vec<String>, Vec<(String, Vec<u8>)>) {
        (root.materials, root.textures) = (self.materials, self.textures);
        (root.images, root.samplers) = (self.images, self.samplers);
        root.extensions_used.extend(self.used);
        root.extensions_required.extend(self.required);
        (self.notes, self.beside)
    }

    /// The slots whose material has a texture of normals, and the set of texture coordinates that it uses: of such the
    /// validator wants tangents.
    pub(super) fn normal_maps(&self, names: &[String]) -> BTreeMap<u32, u32> {
        let of = |name: &String| {
            let textures = &self.scene.materials.get(name)?.textures;
            let tangent = |channel: &Channel| match channel {
                Channel::Other(name) => {
                    name.ends_with("NormalTexture") || name.ends_with(".anisotropyTexture")
                }
                channel => *channel == Channel::Normal,
            };
            // Normal comes before all others.
            textures.iter().find(|(channel, _)| tangent(channel)).map(|(_, texture)| texture.set)
        };
        (0..).zip(names).filter_map(|(slot, name)| Some((slot, of(name)?))).collect()
    }

    /// The material of a colour, where there is one. What has neither that nor colours at its vertices gets none. Those of vertices are
    /// multiplied by white, and are no metal's.
    pub(super) fn color(&mut self, color: Option<[f64; 4]>, has_vertex_colors: bool) -> Option<usize> {
        if color.is_none() && !has_vertex_colors {
            return None;
        }
        let shown = color.unwrap_or([1.0; 4]).map(shade);
        let next = self.materials.len();
        let index = *self.by_color.entry(color.map(|_| shown.map(f64::to_bits))).or_insert(next);
        if index == next {
            let (name, mark) = match color {
                None => ("vertex colors".to_owned(), NONE),
                Some(_) => (format!("color {}", next + 1), COLOR),
            };
            let mut material = json!({
                "name": name,
                "pbrMetallicRoughness": { "baseColorFactor": shown, "metallicFactor": 0.0, "roughnessFactor": 0.5 },
                "doubleSided": true,
                "extras": { EXTRAS: mark },
            });
            if shown[3] < 1.0 {
                material["alphaMode"] = json!("BLEND");
            }
            self.materials.push(material);
        }
        Some(index)
    }

    /// Whether a material only says what glTF means where none is named, as it was read.
    pub(super) fn is_unsaid(&self, name: &str) -> bool {
        self.scene.materials.get(name).is_some_and(|m| {
            m.statements.iter().any(|(key, text)| key == MATERIAL && text == NONE)
                && (m.base_color, m.metallic, m.roughness) == ([1.0; 4], 1.0, 1.0)
                && (m.emissive, m.alpha, m.textures.is_empty()) == ([0.0; 3], Alpha::Opaque, true)
        })
    }

    /// The scene's material of a name, for vertices that have so many sets of texture coordinates: textures that need
    /// more are left out.
    pub(super) fn named(&mut self, name: &'a str, sets: u32, bin: &mut Bin<'a>) -> Option<usize> {
        let material = self.scene.materials.get(name)?;
        if is_paint(material) {
            return self.color(Some(material.base_color), false);
        }
        let needed = material.textures.values().map(|t| t.set.saturating_add(1)).max().unwrap_or(0);
        let sets = sets.min(needed);
        if let Some(&index) = self.by_name.get(&(name, sets)) {
            return Some(index);
        }
        if sets < needed {
            self.notes.push(format!(
                "textures of the material \"{name}\" are left out where the mesh lacks their texture coordinates"
            ));
        }
        let value = self.material(material, sets, bin);
        self.materials.push(value);
        self.by_name.insert((name, sets), self.materials.len() - 1);
        Some(self.materials.len() - 1)
    }

    fn material(&mut self, material: &'a Material, sets: u32, bin: &mut Bin<'a>) -> Value {
        let mut pbr = Map::new();
        pbr.insert("baseColorFactor".into(), json!(material.base_color.map(shade)));
        // Left out it would mean 1.
        pbr.insert("metallicFactor".into(), shade(material.metallic).into());
        pbr.insert("roughnessFactor".into(), shade(material.roughness).into());
        let mut out = Map::new();
        // What has no name in the file that it comes from has none here, unless it was given one since.
        let is_unnamed = |(key, text): &(String, String)| key == UNNAMED && text == material.name();
        if !material.statements.iter().any(is_unnamed) {
            out.insert("name".into(), material.name().into());
        }
        let mut extensions = Map::new();
        let mut later = Vec::new();
        for (channel, texture) in &material.textures {
            if texture.set >= sets {
                continue;
            }
            let Some(mut info) = self.texture(texture, bin) else { continue };
            match channel {
                Channel::BaseColor => _ = pbr.insert("baseColorTexture".into(), info.into()),
                Channel::MetallicRoughness => _ = pbr.insert("metallicRoughnessTexture".into(), info.into()),
                Channel::Normal => {
                    self.scale(texture.strength, material, &mut info);
                    out.insert("normalTexture".into(), info.into());
                }
                Channel::Occlusion => {
                    if texture.strength != 1.0 {
                        info.insert("strength".into(), shade(texture.strength).into());
                    }
                    out.insert("occlusionTexture".into(), info.into());
                }
                Channel::Emissive => _ = out.insert("emissiveTexture".into(), info.into()),
                Channel::Other(name) => later.push((name.as_str(), texture.strength, info)),
                _ => {}
            }
        }
        out.insert("pbrMetallicRoughness".into(), pbr.into());
        self.emissive(material, &mut out, &mut extensions);
        match material.alpha {
            Alpha::Opaque => {}
            Alpha::Mask(cutoff) => {
                out.insert("alphaMode".into(), "MASK".into());
                if fits(cutoff) {
                    out.insert("alphaCutoff".into(), cutoff.max(0.0).into());
                } else {
                    self.beyond("cutoff", material);
                }
            }
            Alpha::Blend => _ = out.insert("alphaMode".into(), "BLEND".into()),
        }
        if material.double_sided {
            out.insert("doubleSided".into(), true.into());
        }
        for (what, text) in &material.statements {
            let Some(name) = what.strip_prefix(PREFIX).filter(|_| what != UNNAMED) else { continue };
            let Ok(value) = serde_json::from_str::<Value>(text) else { continue };
            if name == "extras" {
                out.insert("extras".into(), value);
            } else {
                extensions.insert(name.to_owned(), value);
            }
        }
        let mut elsewhere = 0;
        for (name, strength, mut info) in later {
            let place = name.split_once('.').and_then(|(extension, key)| {
                extensions.get_mut(extension)?.as_object_mut().map(|fields| (key, fields))
            });
            match place {
                Some((key, fields)) => {
                    self.scale(strength, material, &mut info);
                    fields.insert(key.to_owned(), info.into());
                }
                None => elsewhere += 1,
            }
        }
        if elsewhere > 0 {
            let (name, textures) = (material.name(), counted(elsewhere, "texture[|s]"));
            let mean = if elsewhere == 1 { "means" } else { "mean" };
            self.notes.push(format!("{textures} of the material \"{name}\" {mean} what glTF has not"));
        }
        if !extensions.is_empty() {
            self.used.extend(extensions.keys().cloned());
            out.insert("extensions".into(), extensions.into());
        }
        out.into()
    }

    /// Notes a number that glTF cannot hold, and that is left out.
    fn beyond(&mut self, what: &str, material: &Material) {
        let name = material.name();
        self.notes.push(format!(
            "the {what} of the material \"{name}\" is beyond single precision, and is left out"
        ));
    }

    /// The strength of a texture, where it is not the usual one.
    fn scale(&mut self, strength: f64, material: &Material, info: &mut Map<String, Value>) {
        if !fits(strength) {
            self.beyond("strength of a texture", material);
        } else if strength != 1.0 {
            info.insert("scale".into(), strength.into());
        }
    }

    /// Light beyond 1 needs an extension. A power of two as its strength leaves every bit of the colour as it is.
    fn emissive(
        &mut self,
        material: &Material,
        out: &mut Map<String, Value>,
        extensions: &mut Map<String, Value>,
    ) {
        // 2¹²⁷ is the largest power that single precision has.
        let fits = |e: f64| e <= 127_f64.exp2();
        if !material.emissive.iter().all(|e| fits(*e)) {
            self.beyond("light", material);
        }
        let light = material.emissive.map(|e| if e > 0.0 && fits(e) { e } else { 0.0 });
        let largest = light.into_iter().fold(0.0, f64::max);
        if largest <= 0.0 {
            return;
        }
        let strength = if largest > 1.0 { largest.log2().ceil().min(127.0).exp2() } else { 1.0 };
        out.insert("emissiveFactor".into(), json!(light.map(|e| shade(e / strength))));
        if strength > 1.0 {
            let name = "KHR_materials_emissive_strength";
            extensions.insert(name.into(), json!({ "emissiveStrength": strength }));
        }
    }

    /// What a material says of a texture; `None` where its picture cannot go out.
    fn texture(&mut self, texture: &'a Texture, bin: &mut Bin<'a>) -> Option<Map<String, Value>> {
        let image = self.image(&texture.image, bin)?;
        let sampler = self.sampler(texture);
        let next = self.textures.len();
        let index = *self.by_texture.entry((image.index, sampler)).or_insert(next);
        if index == next {
            let mut value = Map::new();
            if let Some(sampler) = sampler {
                value.insert("sampler".into(), sampler.into());
            }
            match image.extension {
                None => _ = value.insert("source".into(), image.index.into()),
                Some(name) => {
                    value.insert("extensions".into(), json!({ name: { "source": image.index } }));
                    self.used.push(name.to_owned());
                    self.required.push(name.to_owned());
                }
            }
            self.textures.push(value.into());
        }
        let mut info = Map::new();
        info.insert("index".into(), index.into());
        if texture.set != 0 {
            info.insert("texCoord".into(), texture.set.into());
        }
        let offset = flipped_back(texture.offset, texture.rotation, texture.tiling);
        let numbers = [offset[0], offset[1], texture.rotation, texture.tiling[0], texture.tiling[1]];
        if !numbers.iter().all(|x| fits(*x)) {
            let note = "a transform of texture coordinates that is beyond single precision is left out";
            self.notes.push(note.to_owned());
        } else if offset != [0.0; 2] || texture.rotation != 0.0 || texture.tiling != [1.0; 2] {
            let name = "KHR_texture_transform";
            let mut transform = Map::new();
            transform.insert("offset".into(), json!(offset));
            if texture.rotation != 0.0 {
                transform.insert("rotation".into(), texture.rotation.into());
            }
            transform.insert("scale".into(), json!(texture.tiling));
            info.insert("extensions".into(), json!({ name: transform }));
            self.used.push(name.to_owned());
        }
        Some(info)
    }

    fn sampler(&mut self, texture: &Texture) -> Option<usize> {
        let filter = |filter: Filter| match filter {
            Filter::Nearest => 9728,
            Filter::Linear => 9729,
            Filter::NearestOfNearest => 9984,
            Filter::LinearOfNearest => 9985,
            Filter::NearestOfMixed => 9986,
            Filter::LinearOfMixed => 9987,
        };
        let mut value = Map::new();
        if let Some(magnify) = texture.magnify {
            // Seen from close by there is no smaller picture.
            let nearest =
                matches!(magnify, Filter::Nearest | Filter::NearestOfNearest | Filter::NearestOfMixed);
            value.insert("magFilter".into(), if nearest { 9728 } else { 9729 }.into());
        }
        if let Some(minify) = texture.minify {
            value.insert("minFilter".into(), filter(minify).into());
        }
        for (key, wrap) in ["wrapS", "wrapT"].into_iter().zip(texture.wrap) {
            match wrap {
                Wrap::Repeat => {}
                Wrap::Mirror => _ = value.insert(key.into(), 33648.into()),
                Wrap::Clamp => _ = value.insert(key.into(), 33071.into()),
            }
        }
        if value.is_empty() {
            return None;
        }
        let value = Value::Object(value);
        let next = self.samplers.len();
        let index = *self.by_sampler.entry(value.to_string()).or_insert(next);
        if index == next {
            self.samplers.push(value);
        }
        Some(index)
    }

    fn image(&mut self, name: &'a str, bin: &mut Bin<'a>) -> Option<Shown> {
        if let Some(known) = self.by_image.get(name) {
            return *known;
        }
        let image = self.scene.images.get(name);
        let shown = image.and_then(|image| self.new_image(image, bin));
        self.by_image.insert(name, shown);
        shown
    }

    fn new_image(&mut self, image: &'a Image, bin: &mut Bin<'a>) -> Option<Shown> {
        let mut found = None;
        if let (ImageData::File(file), Some(source)) = (&image.data, self.source) {
            match source.sibling(file) {
                Ok(bytes) => found = Some(bytes.into_owned()),
                Err(error) => {
                    let (name, problem) = (image.name(), error.problem);
                    self.notes.push(format!(
                        "the image \"{name}\" is left out, and what textures show of it: {problem}"
                    ));
                    return None;
                }
            }
        }
        let kind = self.media(image, found.as_deref());
        let Some(kind) = kind else {
            let name = image.name();
            self.notes.push(format!(
                "the image \"{name}\" is left out: glTF shows PNG, JPEG, WebP, AVIF and KTX2 only"
            ));
            return None;
        };
        let extension = SOURCES.iter().find(|(_, media)| *media == kind).map(|(name, _)| *name);
        let mut value = match (&image.data, found) {
            (ImageData::File(_), Some(bytes)) if !self.text => {
                json!({ "name": image.name(), "mimeType": kind, "bufferView": bin.owned(bytes) })
            }
            (ImageData::File(file), found) => {
                match found {
                    Some(bytes) => self.beside.push((file.clone(), bytes)),
                    None => self
                        .notes
                        .push(format!("the image \"{}\" stays a file of its own: {file}", image.name())),
                }
                json!({ "name": image.name(), "uri": percent_encoded(file) })
            }
            (ImageData::Embedded { bytes, .. }, _) => {
                json!({ "name": image.name(), "mimeType": kind, "bufferView": bin.bytes(bytes) })
            }
        };
        let is_unnamed = |(key, text): &(String, String)| key == UNNAMED_IMAGE && text == image.name();
        if self.scene.statements.iter().any(is_unnamed)
            && let Some(fields) = value.as_object_mut()
        {
            fields.remove("name");
        }
        self.images.push(value);
        Some(Shown { index: self.images.len() - 1, extension })
    }

    /// The media type of a picture, whose bytes were `found` where it is a file.
    fn media(&self, image: &Image, found: Option<&[u8]>) -> Option<&'static str> {
        match (&image.data, found) {
            (ImageData::File(_), Some(bytes)) => ImageData::media_type_of(bytes),
            (ImageData::File(file), None) => {
                let ending = file.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
                match ending.as_str() {
                    "png" => Some("image/png"),
                    "jpg" | "jpeg" => Some("image/jpeg"),
                    "webp" => Some("image/webp"),
                    "avif" => Some("image/avif"),
                    "ktx2" => Some("image/ktx2"),
                    _ => None,
                }
            }
            // What the bytes say counts, whatever they are called.
            (ImageData::Embedded { bytes, .. }, _) => ImageData::media_type_of(bytes),
        }
    }
}
