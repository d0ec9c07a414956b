//! Material libraries.
//!
//! `Kd`, `d`/`Tr`, `Ke`, `Pr`, `Pm` and the usual textures go where a [`Material`] has a place for them; roughness
//! follows from `Ns` where there is no `Pr`, as Blender has it. Everything is kept word for word that has no such place.

use std::collections::{HashMap, HashSet};

use loftsman_kernel::material::{Alpha, Channel, Material, Texture, Wrap};
use loftsman_kernel::text::Encoding;

use crate::number::{next_number, number};
use crate::text::{OURS, Statements, decode, keyword, line_length, name, show, uncommented};

/// The materials of libraries, and what was wrong in them.
#[derive(Debug, Default)]
pub(crate) struct Materials {
    pub(crate) list: Vec<Material>,
    index: HashMap<String, usize>,
    /// Those that only show the colour of objects, as a comment of ours says.
    paints: HashSet<usize>,
    /// Those that stand for none.
    plain: HashSet<usize>,
    /// Those of libraries that were written here: of a scene, which may have more than its objects show.
    ours: HashSet<usize>,
    /// Statements left out: the reason, with the library and line of the first.
    pub(crate) left_out: Vec<(String, usize)>,
}

/// The colour of a material that says nothing of it, as Blender has it.
pub(crate) const GREY: [f64; 4] = [0.8, 0.8, 0.8, 1.0];

/// How many different problems are told apart.
const PROBLEMS: usize = 16;

impl Materials {
    /// Where the material of a name is; a grey one where no library has it.
    pub(crate) fn place(&mut self, name: &str) -> usize {
        if let Some(&at) = self.index.get(name) {
            return at;
        }
        let at = self.list.len();
        self.list.push(Material::new(name, GREY));
        self.index.insert(name.to_owned(), at);
        at
    }

    pub(crate) fn known(&self, name: &str) -> bool {
        self.index.contains_key(name)
    }

    /// Whether a material of ours stands for none.
    pub(crate) fn is_plain(&self, at: usize) -> bool {
        self.plain.contains(&at)
    }

    /// Whether a material is one of a scene that was written here, be it used or not.
    pub(crate) fn is_of_scene(&self, at: usize) -> bool {
        self.ours.contains(&at) && self.is_own(at)
    }

    /// Whether a material is one, and no mark of ours.
    pub(crate) fn is_own(&self, at: usize) -> bool {
        self.paint(at).is_none() && !self.is_plain(at)
    }

    /// The colour of objects that a material of ours shows. Where somebody has made it more than that since it is a material.
    pub(crate) fn paint(&self, at: usize) -> Option<[f64; 4]> {
        let material = self.list.get(at).filter(|_| self.paints.contains(&at))?;
        (material.textures.is_empty() && material.statements.is_empty()).then_some(material.base_color)
    }

    /// Reads a library; its name and how it was read, where it is older than UTF-8. A material that an earlier library has stays as it is.
    pub(crate) fn read(&mut self, library: &str, bytes: &[u8]) -> Option<(String, Encoding)> {
        let (text, encoding) = decode(bytes);
        let mut current: Option<usize> = None;
        let mut shininess = None;
        let mut roughness_said = false;
        let ours = text[..line_length(&text)].trim_ascii_end() == OURS.trim_ascii_end();
        for (line, statement) in Statements::new(&text) {
            if let Some(said) = statement.strip_prefix(OURS) {
                let said = said.trim_ascii();
                self.paints.extend(current.filter(|_| said == b"color"));
                self.plain.extend(current.filter(|_| said == b"none"));
                continue;
            }
            let (word, rest) = keyword(uncommented(&statement));
            if word == b"newmtl" {
                let name = name(rest);
                current = None;
                if name.is_empty() {
                    self.problem(format!("{library}, line {line}: newmtl without a name"));
                } else if !self.known(&name) {
                    current = Some(self.place(&name));
                    self.ours.extend(current.filter(|_| ours));
                }
                (shininess, roughness_said) = (None, false);
                continue;
            }
            let Some(at) = current else { continue };
            let material = &mut self.list[at];
            if word == b"Ns" {
                shininess = number(rest.trim_ascii()).ok();
            }
            roughness_said |= word == b"Pr";
            if let Err(problem) = statement_of(material, word, rest) {
                self.problem(format!("{library}, line {line}: {problem}"));
                continue;
            }
            if let Some(shininess) = shininess.filter(|_| !roughness_said) {
                self.list[at].roughness = roughness(shininess);
            }
        }
        encoding.map(|encoding| (library.to_owned(), encoding))
    }

    fn problem(&mut self, text: String) {
        let full = self.left_out.len() >= PROBLEMS;
        match self.left_out.last_mut() {
            Some((_, count)) if full => *count += 1,
            _ => self.left_out.push((text, 1)),
        }
    }
}

/// The roughness that a specular exponent stands for in Blender: `1 - √(Ns / 1000)`.
pub(crate) fn roughness(shininess: f64) -> f64 {
    1.0 - (shininess.clamp(0.0, 1000.0) / 1000.0).sqrt()
}

/// What each texture statement stands for; others are kept by their own names.
pub(crate) const CHANNELS: [(&str, Channel); 3] =
    [("map_Kd", Channel::BaseColor), ("map_Ke", Channel::Emissive), ("norm", Channel::Normal)];

/// Takes one statement of a material.
fn statement_of(material: &mut Material, word: &[u8], rest: &[u8]) -> Result<(), String> {
    let keyword = String::from_utf8_lossy(word).into_owned();
    let text = String::from_utf8_lossy(rest.trim_ascii()).into_owned();
    match keyword.as_str() {
        "Kd" | "Ke" if !text.starts_with("spectral") && !text.starts_with("xyz") => {
            let [r, g, b] = color(rest)?;
            if keyword == "Kd" {
                let [r, g, b] = [r, g, b].map(|x| x.clamp(0.0, 1.0));
                material.base_color = [r, g, b, material.base_color[3]];
                if [r, g, b] != color(rest)? {
                    return Err(format!(
                        "the colour \"{}\" is not between 0 and 1: it is cut there",
                        show(rest)
                    ));
                }
            } else {
                material.emissive = [r, g, b];
            }
        }
        "d" | "Tr" if !text.starts_with('-') => {
            let value = unit(rest)?;
            let alpha = if keyword == "d" { value } else { 1.0 - value };
            material.base_color[3] = alpha;
            material.alpha = if alpha < 1.0 { Alpha::Blend } else { Alpha::Opaque };
        }
        "Pr" => material.roughness = unit(rest)?,
        "Pm" => material.metallic = unit(rest)?,
        _ if keyword.starts_with("map_")
            || ["bump", "disp", "decal", "norm", "refl"].contains(&keyword.as_str()) =>
        {
            let known = CHANNELS.iter().find(|(name, _)| *name == keyword);
            let channel = known.map_or_else(|| Channel::Other(format!("mtl {keyword}")), |(_, c)| c.clone());
            match texture(&text)? {
                Some(texture) => _ = material.textures.insert(channel, texture),
                // With options that a texture has no place for it is kept as it is.
                None => material.statements.push((format!("mtl {keyword}"), text)),
            }
        }
        _ => material.statements.push((format!("mtl {keyword}"), text)),
    }
    Ok(())
}

/// Red, green and blue; one number is all three.
fn color(mut rest: &[u8]) -> Result<[f64; 3], String> {
    let r = next_number(&mut rest)?.ok_or("a colour has three numbers")?;
    let g = next_number(&mut rest)?.unwrap_or(r);
    let b = next_number(&mut rest)?.unwrap_or(g);
    Ok([r, g, b])
}

/// One number from 0 to 1.
fn unit(rest: &[u8]) -> Result<f64, String> {
    let value = number(rest.trim_ascii())?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(format!("{value} is not between 0 and 1")) }
}

/// `[-s u v w] [-o u v w] [-bm m] [-clamp on] file name`; nothing where there are other options.
fn texture(text: &str) -> Result<Option<Texture>, String> {
    let mut texture = Texture::new("");
    let mut rest = text.trim();
    while let Some(option) = rest.strip_prefix('-') {
        let (name, mut after) = option.split_at(option.find(char::is_whitespace).unwrap_or(option.len()));
        let mut numbers = Vec::new();
        if name != "clamp" {
            // As many numbers as follow, at most three.
            while numbers.len() < 3 {
                let trimmed = after.trim_start();
                let end = trimmed.find(char::is_whitespace).unwrap_or(trimmed.len());
                // The last word is the file, even where it looks like a number.
                let Some(value) = number(&trimmed.as_bytes()[..end]).ok().filter(|_| end < trimmed.len())
                else {
                    break;
                };
                numbers.push(value);
                after = &trimmed[end..];
            }
        }
        match (name, numbers.as_slice()) {
            ("s", [u, v] | [u, v, 1.0]) => texture.tiling = [*u, *v],
            ("o", [u, v] | [u, v, 0.0]) => texture.offset = [*u, *v],
            ("bm", [strength]) => texture.strength = *strength,
            ("clamp", _) => {
                let trimmed = after.trim_start();
                let end = trimmed.find(char::is_whitespace).unwrap_or(trimmed.len());
                match &trimmed[..end] {
                    "on" => texture.wrap = [Wrap::Clamp; 2],
                    "off" => {}
                    _ => return Ok(None),
                }
                after = &trimmed[end..];
            }
            _ => return Ok(None),
        }
        rest = after.trim_start();
    }
    texture.image = path(rest)?;
    Ok(Some(texture))
}

/// A file name as it is kept: relative, with slashes, inside the folder.
fn path(text: &str) -> Result<String, String> {
    let text = text.trim().trim_matches('"').replace('\\', "/");
    let outside = text.starts_with('/') || text.contains(':') || text.split('/').any(|part| part == "..");
    if text.is_empty() || outside || text.chars().any(char::is_control) {
        return Err(format!("the texture \"{}\" is not in the folder of the file", show(text.as_bytes())));
    }
    Ok(text.trim_start_matches("./").to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_has_a_place_or_is_kept_word_for_word() {
        let mut materials = Materials::default();
        materials.read(
            "a.mtl",
            b"Kd 1 0 0\nnewmtl a b\nKd 0.1 0.2 0.3\nKs 1 1 1\nNs 250\nTr 0.25\nillum 2\nKe 1\nNi 1.45 # glass\n\
              map_Kd -s 2 3 1 -o 0.5 0 0 -clamp on tex\\a b.png\nmap_Bump -bm 0.5 n.png\nmap_Ks -imfchan r k.png\n\
              map_d ../../etc/passwd\nnewmtl c\nPr 0.3\nPm 1\nNs 10\nKd x\nd -halo 0.5\nKd spectral file.rfl\nunknown \\\n1 2",
        );
        let [a, c] = &materials.list[..] else { unreachable!() };
        assert_eq!((loftsman_kernel::named::Named::name(a), a.base_color), ("a b", [0.1, 0.2, 0.3, 0.75]));
        assert_eq!((a.alpha, a.roughness, a.emissive), (Alpha::Blend, 0.5, [1.0; 3]));
        let base = &a.textures[&Channel::BaseColor];
        assert_eq!((base.image.as_str(), base.tiling, base.offset), ("tex/a b.png", [2.0, 3.0], [0.5, 0.0]));
        assert_eq!(base.wrap, [Wrap::Clamp; 2]);
        assert_eq!(a.textures[&Channel::Other("mtl map_Bump".into())].strength, 0.5);
        let kept: Vec<_> = a.statements.iter().map(|(k, v)| format!("{k} {v}")).collect();
        let expected =
            ["mtl Ks 1 1 1", "mtl Ns 250", "mtl illum 2", "mtl Ni 1.45", "mtl map_Ks -imfchan r k.png"];
        assert_eq!(kept, expected);
        assert_eq!((c.roughness, c.metallic, c.base_color), (0.3, 1.0, GREY));
        assert_eq!(c.statements.len(), 4, "{:?}", c.statements);
        let problems: Vec<_> = materials.left_out.iter().map(|(why, _)| why.as_str()).collect();
        assert!(problems[0].contains("line 13") && problems[0].contains("passwd"), "{problems:?}");
        assert!(problems[1].contains("a.mtl, line 18"), "{problems:?}");
    }
}
