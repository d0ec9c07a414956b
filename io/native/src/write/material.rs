//! Materials and images.

use std::io;

use loftsman_kernel::material::{Alpha, Channel, Filter, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::named::{Named, NamedList};

use super::layout::Layout;
use crate::names;

/// Writes the field `images`, where there are any.
pub(super) fn write_images(images: &NamedList<Image>, out: &mut Layout<'_>) -> io::Result<()> {
    list("images", images, out, |image, out| {
        out.key("name")?;
        out.text(image.name())?;
        match &image.data {
            ImageData::File(file) => {
                out.key("file")?;
                out.text(file)
            }
            ImageData::Embedded { media_type, bytes } => {
                out.key("media_type")?;
                out.text(media_type)?;
                out.key("base64")?;
                out.bytes(bytes)
            }
        }
    })
}

/// Writes the field `materials`, where there are any.
pub(super) fn write_materials(materials: &NamedList<Material>, out: &mut Layout<'_>) -> io::Result<()> {
    list("materials", materials, out, material)
}

/// Writes a field with a list of tables, where there are any.
pub(super) fn list<T>(
    key: &str,
    things: &NamedList<T>,
    out: &mut Layout<'_>,
    write: impl Fn(&T, &mut Layout<'_>) -> io::Result<()>,
) -> io::Result<()>
where
    T: Named,
{
    if things.is_empty() {
        return Ok(());
    }
    out.key(key)?;
    out.open_list()?;
    for thing in things {
        out.entry()?;
        out.open_table()?;
        write(thing, out)?;
        out.close_table()?;
    }
    out.close_list()
}

fn material(material: &Material, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("name")?;
    out.text(material.name())?;
    out.key("base_color")?;
    out.row(&material.base_color)?;
    out.key("metallic")?;
    out.number(material.metallic)?;
    out.key("roughness")?;
    out.number(material.roughness)?;
    if material.emissive.map(f64::to_bits) != [0; 3] {
        out.key("emissive")?;
        out.row(&material.emissive)?;
    }
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask(cutoff) => {
            out.key("alpha_cutoff")?;
            out.number(cutoff)?;
        }
        Alpha::Blend => {
            out.key("blend")?;
            out.flag(true)?;
        }
    }
    if material.double_sided {
        out.key("double_sided")?;
        out.flag(true)?;
    }
    if !material.textures.is_empty() {
        out.key("textures")?;
        out.open_list()?;
        for (channel, shown) in &material.textures {
            out.entry()?;
            out.open_table()?;
            match names::of(&names::CHANNELS, channel) {
                Some(name) => {
                    out.key("channel")?;
                    out.text(name)?;
                }
                None => {
                    out.key("other")?;
                    out.text(if let Channel::Other(name) = channel { name } else { "" })?;
                }
            }
            texture(shown, out)?;
            out.close_table()?;
        }
        out.close_list()?;
    }
    statements(&material.statements, out)
}

/// What formats said word for word, as pairs; nothing where there is none.
pub(super) fn statements(list: &[(String, String)], out: &mut Layout<'_>) -> io::Result<()> {
    if list.is_empty() {
        return Ok(());
    }
    out.key("statements")?;
    out.open_list()?;
    for (what, value) in list {
        out.entry()?;
        out.texts([what.as_str(), value].into_iter())?;
    }
    out.close_list()
}

/// The fields of a texture; those that are as usual are left out.
fn texture(texture: &Texture, out: &mut Layout<'_>) -> io::Result<()> {
    out.key("image")?;
    out.text(&texture.image)?;
    if texture.set != 0 {
        out.key("set")?;
        out.count(u64::from(texture.set))?;
    }
    // By their bits: minus zero is not as usual.
    let mut number = |key: &str, value: f64, usual: f64| {
        if value.to_bits() == usual.to_bits() {
            return Ok(());
        }
        out.key(key)?;
        out.number(value)
    };
    number("strength", texture.strength, 1.0)?;
    number("rotation", texture.rotation, 0.0)?;
    for (key, value, usual) in [("offset", texture.offset, 0.0_f64), ("tiling", texture.tiling, 1.0)] {
        if value.map(f64::to_bits) != [usual.to_bits(); 2] {
            out.key(key)?;
            out.row(&value)?;
        }
    }
    if texture.wrap != [Wrap::Repeat; 2] {
        out.key("wrap")?;
        out.texts(texture.wrap.iter().map(|wrap| names::of(&names::WRAPS, wrap).unwrap_or_default()))?;
    }
    let mut filter = |key: &str, filter: Option<Filter>| match filter {
        Some(filter) => {
            out.key(key)?;
            out.text(names::of(&names::FILTERS, &filter).unwrap_or_default())
        }
        None => Ok(()),
    };
    filter("magnify", texture.magnify)?;
    filter("minify", texture.minify)
}
