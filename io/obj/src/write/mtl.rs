//! The material library beside the file, and the pictures that the scene holds.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt::Write as _;

use loftsman_kernel::material::{Channel, Image, ImageData, Material, Texture, Wrap};
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::{FormatError, Outgoing, Sink, WriteReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::print::{self, Names};
use crate::read::{CHANNELS, GREY, roughness};

/// The library of a scene.
#[derive(Debug)]
pub(super) struct Library {
    /// Its file's name.
    pub(super) file: String,
    /// Names in the library by names in the scene.
    names: HashMap<String, String>,
    /// All names in the library.
    taken: Names,
    /// Materials that stand for colours of objects, as they were met, and their names by the colours' bits.
    paints: Vec<(String, [f64; 4])>,
    painted: HashMap<[u64; 4], usize>,
    /// The material of what has none, once something has had one before it.
    plain: Option<String>,
    /// Whether objects have colours that are to be seen.
    has_paints: bool,
    /// Where the pictures are, by their names.
    pictures: HashMap<String, String>,
    /// Pictures that are written: file name and name.
    embedded: Vec<(String, String)>,
    left_out: usize,
}

/// A name without what a file's name may not hold anywhere.
fn file_name(name: &str, extension: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "._- ".contains(c) { c } else { '_' };
    let clean: String = name.chars().map(plain).take(80).collect();
    let clean = clean.trim_matches(|c: char| c == '.' || c.is_whitespace());
    let clean = if clean.is_empty() { "picture" } else { clean };
    match clean.rsplit_once('.') {
        Some((stem, old)) if old.eq_ignore_ascii_case(extension) && !stem.is_empty() => {
            format!("{stem}.{extension}")
        }
        _ => format!("{clean}.{extension}"),
    }
}

/// Whether a picture's name only says which one of its file it is, as readers call those without a name; where files were merged, with a
/// number behind it.
fn is_made_up(name: &str) -> bool {
    let number = name.strip_prefix("image ").or_else(|| name.strip_prefix("picture "));
    let is_number = |n: &str| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
    number.is_some_and(|n| n.split('.').all(is_number)) || !name.chars().any(char::is_alphanumeric)
}

/// The name itself, or with a number before its extension where it is taken.
fn unique(name: String, taken: &mut HashSet<String>) -> String {
    let (stem, end) = match name.rfind('.') {
        Some(at) => name.split_at(at),
        None => (name.as_str(), ""),
    };
    let mut wanted = name.clone();
    let mut number = 1;
    // Names that differ in case only are one file on some systems.
    while !taken.insert(wanted.to_lowercase()) {
        wanted = format!("{stem}.{number:03}{end}");
        number += 1;
    }
    wanted
}

/// Whether a path stays in the folder.
fn stays(path: &str) -> bool {
    let odd = |c: char| c.is_control() || c == '\\' || c == ':';
    !path.is_empty()
        && !path.starts_with('/')
        && !path.contains(odd)
        && path.split('/').all(|part| part != "..")
}

/// The library of a scene that goes out as `file`, as far as its objects do.
pub(super) fn library(scene: &Scene, file: &str, goes_out: impl Fn(&Object) -> bool) -> Library {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let mut taken = HashSet::from([file.to_lowercase()]);
    let own = unique(format!("{stem}.mtl"), &mut taken);
    let mut names = HashMap::new();
    let mut taken_names = Names::default();
    for material in &scene.materials {
        names.insert(material.name().to_owned(), taken_names.unique(material.name()));
    }
    let mut library = Library {
        file: own,
        names,
        taken: taken_names,
        paints: Vec::new(),
        painted: HashMap::new(),
        plain: None,
        has_paints: scene
            .objects()
            .iter()
            .filter(|object| goes_out(object))
            .any(|object| paint(scene, object).is_some() || has_painted_faces(object)),
        pictures: HashMap::new(),
        embedded: Vec::new(),
        left_out: 0,
    };
    // Files keep their names, which embedded pictures must not take.
    taken.extend(scene.images.iter().filter_map(|image| match &image.data {
        ImageData::File(path) => Some(path.trim_start_matches("./").to_lowercase()),
        ImageData::Embedded { .. } => None,
    }));
    let shown: HashSet<&str> =
        scene.materials.iter().flat_map(|m| m.textures.values()).map(|t| t.image.as_str()).collect();
    for image in scene.images.iter().filter(|image| shown.contains(image.name())) {
        match &image.data {
            ImageData::File(path) if stays(path) => {
                library.pictures.insert(image.name().to_owned(), path.clone());
            }
            ImageData::File(_) => library.left_out += 1,
            ImageData::Embedded { media_type, .. } => {
                let extension = match media_type.as_str() {
                    "image/png" => "png",
                    "image/jpeg" => "jpg",
                    "image/webp" => "webp",
                    _ => "bin",
                };
                // A name that only counts is that of another picture, too, beside another file of the folder.
                let wanted = if is_made_up(image.name()) {
                    format!("{stem} {}", image.name())
                } else {
                    image.name().to_owned()
                };
                let name = unique(file_name(&wanted, extension), &mut taken);
                library.pictures.insert(image.name().to_owned(), name.clone());
                library.embedded.push((name, image.name().to_owned()));
            }
        }
    }
    library
}

/// The colour that an object is to be seen in, where no material says how it looks.
pub(super) fn paint(scene: &Scene, object: &Object) -> Option<[f64; 4]> {
    let color = scene.color_of(object).filter(|_| object.materials.is_empty());
    color.filter(|color| color.iter().all(|x| x.is_finite()))
}

/// Whether faces of a Brep have colours of their own.
fn has_painted_faces(object: &Object) -> bool {
    matches!(object.geometry(), Geometry::Brep(b) if (0..b.face_count()).any(|face| b.face_color(face).is_some()))
}

impl Library {
    pub(super) fn is_empty(&self) -> bool {
        self.names.is_empty() && !self.has_paints
    }

    /// The name in the library of a material of the scene.
    pub(super) fn name(&self, material: &str) -> Option<&String> {
        self.names.get(material)
    }

    /// The name of the material that stands for none.
    pub(super) fn plain(&mut self) -> String {
        let Self { plain, taken, .. } = self;
        plain.get_or_insert_with(|| taken.unique("plain")).clone()
    }

    /// The name of the material that shows a colour; one for all objects of that colour.
    pub(super) fn paint(&mut self, color: [f64; 4]) -> String {
        let next = self.paints.len();
        let index = *self.painted.entry(color.map(f64::to_bits)).or_insert(next);
        if index == next {
            self.paints.push((self.taken.unique(&format!("color-{}", next + 1)), color));
        }
        self.paints[index].0.clone()
    }

    /// Writes the library and the pictures beside the file.
    pub(super) fn write(
        &self,
        scene: &Scene,
        outgoing: &Outgoing<'_>,
        sink: &mut dyn Sink,
        report: &mut WriteReport,
    ) -> Result<(), FormatError> {
        if self.is_empty() {
            return Ok(());
        }
        let mut text = "# Loftsman\n".to_owned();
        let mut unplaced = 0;
        for material in &scene.materials {
            let name = self.names.get(material.name()).map_or("", String::as_str);
            _ = writeln!(text, "newmtl {name}");
            unplaced += self.material(material, &mut text);
        }
        for (name, color) in &self.paints {
            // The mark says that this is the colour of objects, and no material of theirs.
            _ = writeln!(text, "newmtl {name}\n# Loftsman color");
            let shown = Material::new(name.clone(), color.map(|x| x.clamp(0.0, 1.0)));
            unplaced += self.material(&shown, &mut text);
        }
        if let Some(name) = &self.plain {
            _ = writeln!(text, "newmtl {name}\n# Loftsman none");
            unplaced += self.material(&Material::new(name.clone(), GREY), &mut text);
        }
        sink.sibling(&self.file)?.write_all(text.as_bytes())?;
        for (name, image) in &self.embedded {
            if let Some(ImageData::Embedded { bytes, .. }) = scene.images.get(image).map(|i: &Image| &i.data)
            {
                sink.picture(name, bytes)?;
            }
        }
        report.say(
            self.left_out,
            "[picture lies|pictures lie] outside of the folder: textures that show [it|them] are left out",
        );
        report.say(
            unplaced,
            "[texture or setting of a texture has|textures or settings of textures have] no place in a material library and [is|are] left out",
        );
        let embedded: HashSet<&str> = self.embedded.iter().map(|(_, name)| name.as_str()).collect();
        let files = self.pictures.iter().filter(|(name, _)| !embedded.contains(name.as_str()));
        let files: BTreeSet<&str> = files.map(|(_, file)| file.as_str()).collect();
        outgoing.pictures(files, sink, report)
    }

    /// One material; how many of its textures (or their settings) have no place here.
    fn material(&self, material: &Material, text: &mut String) -> usize {
        let mut line = |keyword: &str, numbers: &[f64]| {
            text.push_str(keyword);
            numbers.iter().for_each(|&x| print::number(text, x));
            text.push('\n');
        };
        let [r, g, b, alpha] = material.base_color;
        line("Kd", &[r, g, b]);
        if material.emissive != [0.0; 3] {
            line("Ke", &material.emissive);
        }
        if alpha != 1.0 {
            line("d", &[alpha]);
        }
        let mut said = None;
        for (_, value) in material.statements.iter().filter(|(key, _)| key == "mtl Ns") {
            said = crate::number::number(value.as_bytes()).ok().map(roughness);
        }
        // What a reader takes where nothing else is said.
        if said.unwrap_or(0.5) != material.roughness {
            line("Pr", &[material.roughness]);
        }
        if material.metallic != 0.0 {
            line("Pm", &[material.metallic]);
        }
        for (key, value) in &material.statements {
            if let Some(keyword) = key.strip_prefix("mtl ") {
                let clean =
                    |s: &str| -> String { s.chars().map(|c| if c.is_control() { ' ' } else { c }).collect() };
                _ = writeln!(text, "{} {}", clean(keyword), clean(value).trim_end_matches('\\'));
            }
        }
        let mut unplaced = 0;
        for (channel, texture) in &material.textures {
            let keyword = match channel {
                Channel::Other(name) => name.strip_prefix("mtl "),
                known => CHANNELS.iter().find(|(_, c)| c == known).map(|(keyword, _)| *keyword),
            };
            let (Some(keyword), Some(path)) = (keyword, self.pictures.get(&texture.image)) else {
                unplaced += 1;
                continue;
            };
            unplaced += usize::from(texture.set != 0 || texture.rotation != 0.0);
            _ = writeln!(text, "{keyword}{} {path}", options(texture));
        }
        unplaced
    }
}

/// The settings of a texture, as options before its file.
fn options(texture: &Texture) -> String {
    let mut text = String::new();
    let mut add = |name: &str, numbers: &[f64]| {
        text.push_str(name);
        numbers.iter().for_each(|&x| print::number(&mut text, x));
    };
    if texture.tiling != [1.0; 2] {
        add(" -s", &[texture.tiling[0], texture.tiling[1], 1.0]);
    }
    if texture.offset != [0.0; 2] {
        add(" -o", &[texture.offset[0], texture.offset[1], 0.0]);
    }
    if texture.strength != 1.0 {
        add(" -bm", &[texture.strength]);
    }
    if texture.wrap == [Wrap::Clamp; 2] {
        text.push_str(" -clamp on");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_stay_in_the_folder() {
        assert_eq!(file_name("../../etc/passwd", "png"), "_.._etc_passwd.png");
        assert_eq!(file_name("wood.PNG", "png"), "wood.png");
        assert_eq!(file_name("..", "jpg"), "picture.jpg");
        assert!(
            ["image 0", "image 12", "", "..", "picture 3", "image 0.001", "image 2.001.002"]
                .into_iter()
                .all(is_made_up)
        );
        assert!(
            ["image", "image 0b", "wood 1", "2", "image 0.", "image .1", "image 0.png"]
                .into_iter()
                .all(|name| !is_made_up(name))
        );
        let mut taken = HashSet::from(["a.png".to_owned()]);
        assert_eq!(unique("A.png".into(), &mut taken), "A.001.png");
        for outside in ["/a", "../a", "a/../b", "c:/a", "a\\b", ""] {
            assert!(!stays(outside), "{outside}");
        }
        assert!(stays("tex/a..b.png"));
    }
}
