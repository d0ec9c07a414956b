//! Scene objects out of sections, and the account of every entity.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::Point;
use loftsman_kernel::connection::{Connection, Side};
use loftsman_kernel::material::{Image, ImageData};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::{Fate, FormatError, FormatErrorKind, Place, ReadReport, Source};
use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::mesh::{Odd, Uses, colored_chain, colored_points, mesh};
use super::mtl::Materials;
use super::raw::Use;
use super::reader::Reader;
use super::section::{Look, Section, Shape};
use super::tally::Tally;
use super::unbroken::line_of_normal;
use crate::fingerprint;
use crate::text::show;
use loftsman_kernel::text::{Encoding, counted};

/// The name of the material that faces before the first `usemtl` of an object have, where others follow.
const DEFAULT: &str = "default";

/// How an object looks: the names of its materials, or a colour of its own.
#[derive(Debug, Default)]
struct Dress {
    materials: Vec<String>,
    color: Option<[f64; 4]>,
}

impl Dress {
    /// These materials, which are used then; where one of ours that only shows a colour is alone, that colour.
    fn of(places: &[usize], materials: &Materials, used: &mut Vec<usize>) -> Self {
        if places.iter().all(|&at| materials.is_plain(at)) {
            return Self::default();
        }
        if let &[one] = places
            && let Some(color) = materials.paint(one)
        {
            return Self { materials: Vec::new(), color: Some(color) };
        }
        used.extend(places);
        let names = places.iter().map(|&at| materials.list[at].name().to_owned());
        Self { materials: names.collect(), color: None }
    }
}

/// The name of a file without folder and extension.
fn stem(file: &str) -> Cow<'_, str> {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.into(),
        _ => name.into(),
    }
}

/// For each section whose mesh shows a surface, whether the one that comes next of those that it is said to show is as it was written.
fn surfaces_of(sections: &[Section]) -> Vec<Option<bool>> {
    let mut next: BTreeMap<u64, bool> = BTreeMap::new();
    let mut of: Vec<Option<bool>> = sections
        .iter()
        .rev()
        .map(|section| {
            next.extend(section.shown.map(|(_, mesh)| (mesh, section.is_as_written())));
            section.shows.and_then(|mesh| next.get(&mesh).copied())
        })
        .collect();
    of.reverse();
    of
}

impl Reader {
    /// Makes the scene of what was read; `text` is that of the file, decoded.
    pub(crate) fn finish(
        mut self,
        source: &dyn Source,
        text: &[u8],
        scene: &mut Scene,
        report: &mut ReadReport,
    ) -> Result<(), FormatError> {
        self.abandon();
        if let Err(reason) = self.raw.finish_block() {
            self.leave_out(&reason, 1);
        }
        self.empty_before();
        self.without_broken(text);
        let mut uses = Uses {
            points: vec![Use::Nothing; self.raw.points.len()],
            uvs: vec![Use::Nothing; self.raw.uvs.len()],
            normals: vec![Use::Nothing; self.raw.normals.len()],
            rescaled: Odd::default(),
            without_direction: Odd::default(),
            colors_left_out: 0,
        };
        self.used.iter().for_each(|&vertex| uses.points[vertex as usize] = Use::Kept);
        let mut materials = self.materials(source, report);
        let mut sections = std::mem::take(&mut self.sections);
        if sections.is_empty()
            && self.left_out.is_empty()
            && self.left_out_at.is_empty()
            && !self.raw.points.is_empty()
        {
            report.notes.push("the file has vertices and nothing else: they are a cloud".to_owned());
            let mut section = Section::new("");
            section.dots = (0..self.raw.points.len() as u32).collect();
            section.dot_looks.push((0, Look::default()));
            sections.push(section);
        }
        let stem = stem(source.name());
        let mut surfaces = BTreeMap::new();
        let mut used_materials = Vec::new();
        let count = sections.len();
        let surfaces_of = surfaces_of(&sections);
        // Names of meshes whose surfaces come next, by their marks.
        let mut names_of: BTreeMap<u64, String> = BTreeMap::new();
        let (mut pairs, mut parted) = (0, 0);
        for (at, mut section) in sections.into_iter().enumerate() {
            if section.is_empty() {
                continue;
            }
            section.finish();
            let own = if section.name.is_empty() { stem.to_string() } else { section.name.clone() };
            // A surface has the name of the mesh that shows it.
            let name = section.shown.and_then(|(_, mark)| names_of.remove(&mark)).unwrap_or(own);
            let is_named = !section.name.is_empty();
            let named = |e: loftsman_kernel::Error| FormatError::from(e).of(&name);
            let own_color = section.color;
            let mut add = |wanted: &str, geometry: Geometry, Dress { materials, color }: Dress| {
                let unique = scene.unique_name(wanted);
                // Named after the file, it has no name in it.
                let said = if is_named || wanted != name { wanted } else { "" };
                let mut object = Object::new(unique.clone(), geometry).labelled(said);
                object.materials = materials;
                object.color = own_color.or(color);
                scene.add(object).map(|()| unique).map_err(named)
            };
            let mut faces = None;
            if !section.corners.is_empty() {
                let last = at + 1 == count && section.dots.is_empty();
                let mesh = mesh(&mut self.raw, &mut section, last, &mut uses).map_err(named)?;
                let is_same = |mark: &u64| *mark == fingerprint::mesh(&mesh);
                let mark = section.shows.filter(|_| surfaces_of[at] == Some(true)).filter(is_same);
                if let Some(mark) = mark {
                    names_of.insert(mark, name.clone());
                    pairs += 1;
                } else {
                    parted += usize::from(surfaces_of[at].is_some());
                    faces = Some(mesh);
                }
            }
            if let Some(mesh) = faces {
                let dress = self.slots(&section, &mut materials, &mut used_materials);
                // Lines of a mesh look as its first material does, and are in no group.
                let other = section
                    .chain_looks
                    .iter()
                    .filter(|l| l.material != section.slots.first().copied().flatten());
                self.leave_out("materials of lines beside faces of another", other.count());
                let grouped = section.chain_looks.iter().filter(|l| l.group.is_some()).count();
                self.leave_out("groups of lines beside faces", grouped);
                add(&name, mesh.into(), dress)?;
            }
            for (pair, look) in section.chain_starts.windows(2).zip(&section.chain_looks) {
                let chain = &section.chains[pair[0]..pair[1]];
                let geometry = self.polyline(chain, &mut uses).map_err(named)?;
                let (wanted, dress) =
                    self.name_and_materials(look, &section.name, &name, &mut materials, &mut used_materials);
                add(&wanted, geometry, dress)?;
            }
            let ends = section.dot_looks.iter().skip(1).map(|(at, _)| *at).chain([section.dots.len()]);
            let runs = section.dot_looks.iter().zip(ends).filter(|((start, _), end)| start < end);
            for ((start, look), end) in runs {
                let geometry = self.cloud(&section.dots[*start..end], &mut uses).map_err(named)?;
                let (wanted, dress) =
                    self.name_and_materials(look, &section.name, &name, &mut materials, &mut used_materials);
                add(&wanted, geometry, dress)?;
            }
            for element in section.elements {
                let geometry = match element.shape {
                    Shape::Curve(curve) => curve.into(),
                    Shape::Surface(surface) => surface.into(),
                    Shape::Trimmed(trimmed) => trimmed.into(),
                };
                let material = element.material.map(|m| materials.place(&self.materials.list[m]));
                let dress = Dress::of(material.as_slice(), &materials, &mut used_materials);
                let unique = add(element.name.as_deref().unwrap_or(&name), geometry, dress)?;
                surfaces.extend(element.surface.map(|number| (number, unique)));
            }
        }
        if pairs > 0 {
            let what = "[surface stands beside the mesh that was made of it: they are|surfaces stand beside the meshes that were made of them: each is] one object";
            report.notes.push(counted(pairs, what));
        }
        if parted > 0 {
            let what = "mesh that was made of a surface, or this surface, has|meshes that were made of surfaces, or these surfaces, have";
            let what = format!("[{what}] changed since: each is an object of its own");
            report.notes.push(counted(parted, &what));
        }
        // Where nothing is left, what is wrong is all that there is to say.
        if let Some((line, problem)) = self.first_wrong.take().filter(|_| scene.objects().is_empty()) {
            return Err(FormatError::new(Place::Line(line), problem));
        }
        self.connect(&surfaces, scene);
        used_materials.extend((0..materials.list.len()).filter(|&at| materials.is_of_scene(at)));
        used_materials.sort_unstable();
        used_materials.dedup();
        let all = (0..materials.list.len()).filter(|&at| materials.is_own(at)).count();
        let used = used_materials.iter().filter(|&&at| materials.is_own(at)).count();
        for (at, mut material) in materials.list.into_iter().enumerate() {
            if used_materials.binary_search(&at).is_err() {
                continue;
            }
            for texture in material.textures.values_mut() {
                if scene.images.get(&texture.image).is_none() {
                    let data = ImageData::File(texture.image.clone());
                    let image = Image::new(texture.image.clone(), data);
                    scene.images.add(image)?;
                }
            }
            scene.materials.add(material)?;
        }
        self.leave_out("materials that nothing in the scene uses", all - used);
        for (reason, count) in materials.left_out {
            self.leave_out(&reason, count);
        }
        let colored = self.used.iter().filter(|&&v| self.raw.color(v).is_some()).count();
        self.leave_out("vertex colours of lines, points, curves and surfaces that not all vertices have, or that only meshes can have", uses.colors_left_out + colored);
        let used: BTreeSet<u32> = self.used.iter().copied().collect();
        let weights = self.raw.weighted().filter(|v| !used.contains(v)).count();
        self.leave_out("weights of vertices that no curve or surface uses", weights);
        let unused: Vec<usize> =
            (0..self.groups.list.len()).filter(|g| !self.groups_used.contains(g)).collect();
        if let Some(&first) = unused.first() {
            let line = self.group_lines.get(first).copied().unwrap_or_default();
            self.leave_out_at("groups (g) that have no elements", unused.len(), line);
        }
        self.account(&uses, text, report);
        Ok(())
    }

    fn point(&self, vertex: u32, uses: &mut Uses) -> Point {
        uses.points[vertex as usize] = Use::Kept;
        self.raw.points[vertex as usize]
    }

    /// A chain of lines; a mesh of nothing else where its vertices have colours, which a polyline cannot.
    fn polyline(&self, chain: &[u32], uses: &mut Uses) -> loftsman_kernel::Result<Geometry> {
        // There and back is a closed line of two points.
        let closed = chain.len() > 2 && chain.first() == chain.last();
        let chain = &chain[..chain.len() - usize::from(closed)];
        let points: Vec<Point> = chain.iter().map(|&v| self.point(v, uses)).collect();
        Ok(match self.colors(chain, uses) {
            Some(colors) => colored_chain(points, colors, closed)?.into(),
            None => Polyline { points, closed }.into(),
        })
    }

    /// Loose points; a mesh of nothing else where they have colours, which a cloud cannot.
    fn cloud(&self, dots: &[u32], uses: &mut Uses) -> loftsman_kernel::Result<Geometry> {
        let points: Vec<Point> = dots.iter().map(|&v| self.point(v, uses)).collect();
        Ok(match self.colors(dots, uses) {
            Some(colors) => colored_points(points, colors)?.into(),
            None => Cloud { points }.into(),
        })
    }

    /// The colours of vertices that all have one; where only some have, those are left out.
    fn colors(&self, vertices: &[u32], uses: &mut Uses) -> Option<Vec<[f64; 4]>> {
        if !self.raw.colored() {
            return None;
        }
        let colors: Vec<[f64; 4]> = vertices.iter().filter_map(|&v| self.raw.color(v)).collect();
        if colors.len() == vertices.len() {
            return Some(colors);
        }
        uses.colors_left_out += colors.len();
        None
    }

    /// The name and the materials of lines or points: the group's name where the section has none.
    fn name_and_materials(
        &mut self,
        look: &Look,
        section: &str,
        name: &str,
        materials: &mut Materials,
        used: &mut Vec<usize>,
    ) -> (String, Dress) {
        let place = look.material.map(|m| materials.place(&self.materials.list[m]));
        let dress = Dress::of(place.as_slice(), materials, used);
        match look.group {
            Some(group) if section.is_empty() => (self.groups.list[group].clone(), dress),
            Some(_) => {
                self.leave_out("groups of lines and points that have a name already", 1);
                (name.to_owned(), dress)
            }
            None => (name.to_owned(), dress),
        }
    }

    /// A section's materials, slot by slot; none where no face has one.
    fn slots(&self, section: &Section, materials: &mut Materials, used: &mut Vec<usize>) -> Dress {
        if section.slots.iter().all(Option::is_none) {
            return Dress::default();
        }
        let name = |slot: &Option<usize>| match slot {
            Some(material) => self.materials.list[*material].as_str(),
            None => DEFAULT,
        };
        let mut places: Vec<usize> = section.slots.iter().map(|slot| materials.place(name(slot))).collect();
        if places.len() > 1 {
            for at in &mut places {
                if materials.is_plain(*at) {
                    *at = materials.place(DEFAULT);
                }
            }
        }
        Dress::of(&places, materials, used)
    }

    fn connect(&mut self, surfaces: &BTreeMap<usize, String>, scene: &mut Scene) {
        for meeting in std::mem::take(&mut self.meetings) {
            let [first, second] = meeting.sides.map(|(number, curve)| {
                surfaces.get(&number).map(|object| Side { object: object.clone(), curve })
            });
            let made = first.zip(second).map(|(first, second)| scene.connect(Connection { first, second }));
            if !matches!(made, Some(Ok(()))) {
                self.kept -= 1;
                self.leave_out(
                    &format!("the connection (con) of line {}: its surfaces are not there", meeting.line),
                    1,
                );
            }
        }
    }

    /// The materials of all libraries that can be found.
    fn materials(&mut self, source: &dyn Source, report: &mut ReadReport) -> Materials {
        let mut materials = Materials::default();
        for (library, line) in std::mem::take(&mut self.libraries) {
            // One name, perhaps with blanks; or several names.
            let text = String::from_utf8_lossy(&library).into_owned();
            let clean =
                |name: &str| name.trim_matches('"').replace('\\', "/").trim_start_matches("./").to_owned();
            let whole = clean(&text);
            let mut missing = Vec::new();
            match source.sibling(&whole) {
                Ok(bytes) => self.old.extend(materials.read(&whole, &bytes)),
                Err(e) if e.kind == FormatErrorKind::Io => missing.push((whole, e.problem)),
                Err(_) => {
                    let names: Vec<String> = text.split_ascii_whitespace().take(64).map(clean).collect();
                    for name in names {
                        match source.sibling(&name) {
                            Ok(bytes) => self.old.extend(materials.read(&name, &bytes)),
                            Err(e) => missing.push((name, e.problem)),
                        }
                    }
                }
            }
            if missing.is_empty() {
                self.kept += 1;
                continue;
            }
            // A name with blanks of which no word is a file is one name.
            let problem = match missing.as_slice() {
                [(_, problem)] => problem.clone(),
                _ => format!("{} is not there", show(&library)),
            };
            self.leave_out(&format!("the material library of line {line}: {problem}"), 1);
        }
        for encoding in self.old.iter().map(|(_, encoding)| *encoding).collect::<BTreeSet<Encoding>>() {
            let files = self
                .old
                .iter()
                .filter(|(_, other)| *other == encoding)
                .map(|(file, _)| show(file.as_bytes()));
            let files: Vec<String> = files.collect();
            let be = if files.len() == 1 { "is not UTF-8: it was" } else { "are not UTF-8: they were" };
            report.notes.push(format!("{} {be} read as {encoding}", files.join(", ")));
        }
        let unknown = self.materials.list.iter().filter(|name| !materials.known(name)).count();
        if unknown > 0 {
            report.notes.push(counted(
                unknown,
                "material[|s] [is|are] in no library that was found: [it is|they are] grey",
            ));
        }
        materials
    }

    fn account(&self, uses: &Uses, text: &[u8], report: &mut ReadReport) {
        report.count_many(Fate::Kept, "", self.kept);
        for (reason, tally) in &self.mended {
            report.count_many(Fate::Approximated, &tally.told(reason), tally.count);
        }
        for (reason, tally) in &self.left_out_at {
            report.count_many(Fate::LeftOut, &tally.told(reason), tally.count);
        }
        for (reason, &count) in &self.left_out {
            report.count_many(Fate::LeftOut, reason, count);
        }
        for (name, tally) in &self.unknown {
            let what = tally.told(&format!("unknown statement \"{name}\""));
            report.count_many(Fate::LeftOut, &what, tally.count);
        }
        let unused = self.freeform.plane_curves.iter().filter(|c| !c.used).count();
        report.count_many(
            Fate::LeftOut,
            "curves of the parameter plane (curv2) that no surface uses",
            unused,
        );
        report.count_many(Fate::Kept, "", self.freeform.plane_curves.len() - unused);
        let mut parameters = self.parameter_uses.clone();
        for curve in self.freeform.plane_curves.iter().filter(|c| c.used) {
            curve.vertices.iter().for_each(|&v| parameters[v as usize] = Use::Kept);
        }
        // Vertices that are wrong have been counted as statements that are.
        let [points, uvs, normals] = self.broken_counts;
        for (list, what, broken) in [
            (&uses.points, "vertices", points),
            (&uses.uvs, "texture vertices", uvs),
            (&uses.normals, "normals", normals),
            (&parameters, "parameter vertices", 0),
        ] {
            let kept = list.iter().filter(|&&u| u == Use::Kept).count();
            let reason = format!("{what} that nothing in the scene uses");
            report.count_many(Fate::LeftOut, &reason, (list.len() - kept).saturating_sub(broken));
            let of = |odd: &Odd, most: usize| if what == "normals" { odd.count.min(most) } else { 0 };
            let changed = of(&uses.rescaled, kept);
            let third = if what == "texture vertices" { self.third.min(kept) } else { 0 };
            let told = |odd: &Odd, count: usize, what: &str| {
                let line = odd.first.filter(|_| count > 0).and_then(|first| line_of_normal(text, first));
                line.map_or(what.to_owned(), |line| Tally::new(count, line).told(what))
            };
            let what = told(&uses.rescaled, changed, "normals that were not of length 1");
            report.count_many(Fate::Approximated, &what, changed);
            let gone = of(&uses.without_direction, kept - changed - third);
            let what = told(&uses.without_direction, gone, "normals of length 0");
            report.count_many(Fate::LeftOut, &what, gone);
            report.count_many(
                Fate::Approximated,
                "texture vertices: their third coordinate is left out",
                third,
            );
            report.count_many(Fate::Kept, "", kept - changed - third - gone);
        }
        if self.restored > 0 {
            let what = "curve[|s] [has its|have their] own knots, as they were noted beside the Bézier form";
            report.notes.push(counted(self.restored, what));
        }
        if self.periodic > 0 {
            let what = "spline[|s] whose control vertices and knots wrap around [is|are] periodic";
            report.notes.push(counted(self.periodic, what));
        }
        if self.raw.colored() {
            report.notes.push("vertex colours were taken as sRGB and made linear".to_owned());
        }
    }
}
