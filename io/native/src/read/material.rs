//! Materials, their textures, and images.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::named::{Named, NamedList};
use loftsman_kernel::plugin::hint;
use loftsman_kernel::text::clip;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::lists::{Fixed, Index, List, Number, Text};
use super::table::{Table, TableSeed, need};
use super::trail::Trail;
use crate::names;

/// Reads a list of named things, each into the scene as soon as it is read.
pub(super) struct NamedSeed<'s, 't, T, F> {
    pub(super) trail: &'t Trail,
    /// What they are: `"materials"`.
    pub(super) what: &'static str,
    pub(super) list: &'s mut NamedList<T>,
    /// Makes the empty table of one.
    pub(super) table: F,
}

impl<'de, T: Named, B: Table<'de, Out = T>, F: Fn() -> B> DeserializeSeed<'de> for NamedSeed<'_, '_, T, F> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, T: Named, B: Table<'de, Out = T>, F: Fn() -> B> Visitor<'de> for NamedSeed<'_, '_, T, F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}", self.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        for index in 0.. {
            let seed = TableSeed { trail: self.trail, table: (self.table)() };
            let Some(thing) = self.trail.index(index, list.next_element_seed(seed))? else { break };
            let added = self.list.add(thing).map(|_| ());
            let added = added.map_err(|defect| self.trail.refuse_table("name", defect.to_string()));
            self.trail.index(index, added)?;
        }
        Ok(())
    }
}

/// An image.
#[derive(Default)]
pub(super) struct ImageTable {
    name: Option<String>,
    file: Option<String>,
    media_type: Option<String>,
    bytes: Option<Vec<u8>>,
}

impl<'de> Table<'de> for ImageTable {
    type Out = Image;
    const WHAT: &'static str = "an image";
    const FIELDS: &'static [&'static str] = &["name", "file", "media_type", "base64"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            "file" => self.file = Some(map.next_value()?),
            "media_type" => self.media_type = Some(map.next_value()?),
            _ => self.bytes = Some(map.next_value_seed(Base64(trail))?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Image, E> {
        let name = need::<Self, _, _>(self.name, "name", trail)?;
        let data = match (self.file, self.media_type, self.bytes) {
            (Some(file), None, None) => ImageData::File(file),
            (None, Some(media_type), Some(bytes)) => {
                ImageData::Embedded { media_type, bytes: Arc::from(bytes) }
            }
            _ => {
                let problem =
                    "an image is either a \"file\", or a \"media_type\" and its bytes in \"base64\"";
                return Err(trail.refuse_table("", problem));
            }
        };
        Ok(Image::new(name, data))
    }
}

/// Reads bytes from a text in base 64.
struct Base64<'t>(&'t Trail);

impl<'de> DeserializeSeed<'de> for Base64<'_> {
    type Value = Vec<u8>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<u8>, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Base64<'_> {
    type Value = Vec<u8>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bytes in base 64")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Vec<u8>, E> {
        STANDARD.decode(text).map_err(|e| self.0.refuse(format!("this is not base 64: {e}")))
    }
}

/// A material.
pub(super) struct MaterialTable {
    name: Option<String>,
    cutoff: Option<f64>,
    blend: bool,
    /// Everything but the name.
    rest: Material,
}

impl Default for MaterialTable {
    fn default() -> Self {
        Self { name: None, cutoff: None, blend: false, rest: Material::new("", [1.0; 4]) }
    }
}

impl<'de> Table<'de> for MaterialTable {
    type Out = Material;
    const WHAT: &'static str = "a material";
    const FIELDS: &'static [&'static str] = &[
        "name",
        "base_color",
        "metallic",
        "roughness",
        "emissive",
        "alpha_cutoff",
        "blend",
        "double_sided",
        "textures",
        "statements",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let rest = &mut self.rest;
        match name {
            "name" => self.name = Some(map.next_value()?),
            "base_color" => {
                rest.base_color = map.next_value_seed(Fixed { trail, what: "[red, green, blue, alpha]" })?;
            }
            "metallic" => rest.metallic = map.next_value_seed(Number)?,
            "roughness" => rest.roughness = map.next_value_seed(Number)?,
            "emissive" => rest.emissive = map.next_value_seed(Fixed { trail, what: "[red, green, blue]" })?,
            "alpha_cutoff" => self.cutoff = Some(map.next_value_seed(Number)?),
            "blend" => self.blend = map.next_value()?,
            "double_sided" => rest.double_sided = map.next_value()?,
            "textures" => map.next_value_seed(TexturesSeed { trail, textures: &mut rest.textures })?,
            _ => rest.statements = statements(map, trail)?,
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Material, E> {
        let mut material = Material::new(need::<Self, _, _>(self.name, "name", trail)?, self.rest.base_color);
        material.alpha = match (self.cutoff, self.blend) {
            (None, false) => Alpha::Opaque,
            (Some(cutoff), false) => Alpha::Mask(cutoff),
            (None, true) => Alpha::Blend,
            (Some(_), true) => {
                let problem = "a material has either an \"alpha_cutoff\" or \"blend\": take one away";
                return Err(trail.refuse_table("blend", problem));
            }
        };
        (material.metallic, material.roughness) = (self.rest.metallic, self.rest.roughness);
        (material.emissive, material.double_sided) = (self.rest.emissive, self.rest.double_sided);
        (material.textures, material.statements) = (self.rest.textures, self.rest.statements);
        Ok(material)
    }
}

/// Reads what formats said word for word: pairs of texts.
pub(super) fn statements<'de, A: MapAccess<'de>>(
    map: &mut A,
    trail: &Trail,
) -> Result<Vec<(String, String)>, A::Error> {
    let pair = List { trail, what: "two texts", item: Text };
    let pairs = map.next_value_seed(List { trail, what: "pairs of texts", item: pair })?;
    let mut statements = Vec::with_capacity(pairs.len());
    for (i, pair) in pairs.into_iter().enumerate() {
        let pair = <[String; 2]>::try_from(pair)
            .map_err(|pair| trail.refuse(format!("{} texts where two are needed", pair.len())));
        let [what, value] = trail.index(i, pair)?;
        statements.push((what, value));
    }
    Ok(statements)
}

/// Reads the textures of a material.
struct TexturesSeed<'s, 't> {
    trail: &'t Trail,
    textures: &'s mut BTreeMap<Channel, Texture>,
}

impl<'de> DeserializeSeed<'de> for TexturesSeed<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for TexturesSeed<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of textures")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        for index in 0.. {
            let table = TextureTable { channel: None, image: None, rest: Texture::new("") };
            let seed = TableSeed { trail: self.trail, table };
            let Some((channel, texture)) = self.trail.index(index, list.next_element_seed(seed))? else {
                break;
            };
            if self.textures.insert(channel, texture).is_some() {
                let problem = "a material has one texture for each channel, and this is the second: keep one";
                return self.trail.index(index, Err(self.trail.refuse_table("", problem)));
            }
        }
        Ok(())
    }
}

/// A texture of a material.
struct TextureTable {
    channel: Option<Channel>,
    image: Option<String>,
    /// Everything but the image.
    rest: Texture,
}

/// The value of a word; the error lists those that there are.
fn word<T: Clone, E: Error>(
    what: &str,
    table: &[(&'static str, T)],
    word: &str,
    trail: &Trail,
) -> Result<T, E> {
    table.iter().find(|(name, _)| *name == word).map(|(_, value)| value.clone()).ok_or_else(|| {
        let names = table.iter().map(|(name, _)| *name);
        let known = || format!("known are {}", names.clone().collect::<Vec<_>>().join(", "));
        let hint = hint(word, names.clone(), known);
        trail.refuse(format!("unknown {what} \"{}\"; {hint}", clip(word)))
    })
}

impl<'de> Table<'de> for TextureTable {
    type Out = (Channel, Texture);
    const WHAT: &'static str = "a texture";
    const FIELDS: &'static [&'static str] = &[
        "channel", "other", "image", "set", "strength", "offset", "tiling", "rotation", "wrap", "magnify",
        "minify",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let rest = &mut self.rest;
        let pair = Fixed { trail, what: "[u, v]" };
        let filter = |text: String| word::<Filter, _>("filter", &names::FILTERS, &text, trail).map(Some);
        match name {
            "channel" | "other" => {
                if self.channel.is_some() {
                    let problem = "a texture has either a \"channel\" or an \"other\": take one away";
                    return Err(trail.refuse(problem));
                }
                let text: String = map.next_value()?;
                self.channel = Some(match name {
                    "channel" => word("channel", &names::CHANNELS, &text, trail)?,
                    _ => Channel::Other(text),
                });
            }
            "image" => self.image = Some(map.next_value()?),
            "set" => rest.set = map.next_value_seed(Index(trail))?,
            "strength" => rest.strength = map.next_value_seed(Number)?,
            "offset" => rest.offset = map.next_value_seed(pair)?,
            "tiling" => rest.tiling = map.next_value_seed(pair)?,
            "rotation" => rest.rotation = map.next_value_seed(Number)?,
            "wrap" => {
                let words = map.next_value_seed(List { trail, what: "two words", item: Text })?;
                let [u, v] = words.as_slice() else {
                    return Err(trail.refuse(format!("{} words where two are needed", words.len())));
                };
                let wrap = |text: &str| word::<Wrap, _>("way to wrap", &names::WRAPS, text, trail);
                rest.wrap = [wrap(u)?, wrap(v)?];
            }
            "magnify" => rest.magnify = filter(map.next_value()?)?,
            _ => rest.minify = filter(map.next_value()?)?,
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Self::Out, E> {
        let channel = need::<Self, _, _>(self.channel, "channel", trail)?;
        let image = need::<Self, _, _>(self.image, "image", trail)?;
        Ok((channel, Texture { image, ..self.rest }))
    }
}
