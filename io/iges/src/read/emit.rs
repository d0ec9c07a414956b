//! From entities to the objects of a scene: groups with what is in them, subfigures as definitions and instances.

mod layers;

use std::collections::BTreeMap;

use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{FormatError, ReadOptions};
use loftsman_kernel::scene::{Definition, Geometry, Layer, Object, Scene, Up};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use super::brep::Builder;
use super::curve::{chain, is_chain, is_curve, moved_points};
use super::entity::{Got, Problem, Reader};
use super::report::{Account, LEFT_OUT};
use super::style::Styles;
use super::surface::is_surface;
use super::tree::{Tree, is_group, is_shown};

/// How deep groups and subfigures may hang under one another.
const DEEPEST: usize = 200;

/// Makes the scene.
pub(crate) struct Emitter<'a, 'r, 'f> {
    reader: &'a Reader<'r, 'f>,
    styles: &'a Styles,
    tree: Tree,
    account: &'a mut Account<'r, 'f>,
    /// What things are called that have no name.
    stem: &'a str,
    /// Whether the file was written here.
    own: bool,
    /// What is in the scene already: an entity in two groups is in the first.
    seen: Vec<bool>,
    /// The definition of each subfigure that is shown more than once.
    definitions: BTreeMap<usize, String>,
    /// How many of each layer are seen, and how many hidden.
    shown: BTreeMap<Option<String>, [usize; 2]>,
    done: u64,
}

/// Something that becomes an object.
struct Spot<'n> {
    name: Option<&'n str>,
    parent: Option<&'n str>,
    transform: Option<Matrix4<f64>>,
}

/// The colour and the layer of an object.
type Looks = (Option<[f64; 4]>, Option<String>);

/// Points without names, by layer and colour: a cloud of each.
type Loose = BTreeMap<(Option<String>, Option<[u64; 4]>), Vec<Point>>;

impl<'a, 'r, 'f> Emitter<'a, 'r, 'f> {
    pub(crate) fn new(
        reader: &'a Reader<'r, 'f>,
        styles: &'a Styles,
        account: &'a mut Account<'r, 'f>,
        stem: &'a str,
    ) -> Self {
        let tree = Tree::new(reader);
        let own = reader.file.global.system == crate::SYSTEM;
        let seen = vec![false; reader.file.len()];
        let mut shown: BTreeMap<_, [usize; 2]> = BTreeMap::new();
        for (place, entry) in reader.file.entries().iter().enumerate() {
            if is_shown(entry.kind, entry.form) && !is_group(entry.kind, entry.form) && !tree.part[place] {
                shown.entry(styles.layer(reader, place)).or_default()[usize::from(entry.blank)] += 1;
            }
        }
        Self { reader, styles, tree, account, stem, own, seen, definitions: BTreeMap::new(), shown, done: 0 }
    }

    /// The scene of all that is shown.
    pub(crate) fn scene(mut self, options: &ReadOptions<'_>) -> Result<Scene, FormatError> {
        let mut scene = Scene::new();
        scene.up = Up::Z;
        // Names first: definitions show one another, in any order.
        let mut names = Definition::new("names");
        for place in (0..self.reader.file.len()).filter(|&place| self.tree.uses[place] > 0) {
            if self.reader.file.entry(place).kind == 308 && self.is_defined(place) {
                let name = names.unique_name(&self.figure_name(place));
                names.add(Object::new(name.clone(), Geometry::Group))?;
                self.definitions.insert(place, name);
            }
        }
        for (place, name) in self.definitions.clone() {
            let mut list = Definition::new(name);
            let members = self.members(place);
            self.list(&mut list, &members, None, 0, options)?;
            scene.define(list)?;
        }
        let mut all = Definition::new("scene");
        let roots = std::mem::take(&mut self.tree.roots);
        self.list(&mut all, &roots, None, 0, options)?;
        // What only holds itself hangs from nothing.
        if all.objects().is_empty() {
            let text = "it is in itself, and nothing else shows it: take it out of what it holds";
            let held = self.tree.circles.iter().map(|(_, inner)| Problem::new(*inner, text));
            self.account.problems(held.collect());
        }
        for object in all.objects() {
            scene.add(object.clone())?;
        }
        for name in self.hidden_layers() {
            if scene.layers.get(&name).is_none() {
                scene.layers.add(Layer::new(name).hidden())?;
            }
        }
        Ok(scene)
    }

    /// Whether a subfigure is a definition: one that is shown more than once; in files that were written here, each that has a name.
    fn is_defined(&self, place: usize) -> bool {
        let named = || self.reader.glance(place).is_ok_and(|entity| !entity.text(2).is_empty());
        self.tree.uses[place] > 1 || (self.own && named())
    }

    /// What a subfigure is called.
    fn figure_name(&self, place: usize) -> String {
        let own = self.reader.glance(place).map(|entity| entity.text(2)).unwrap_or_default();
        let name = if own.is_empty() { self.styles.property_name(self.reader, place) } else { Some(own) };
        name.unwrap_or_else(|| self.stem.to_owned())
    }

    /// The members of a subfigure (308) or a group (402).
    fn members(&mut self, place: usize) -> Vec<usize> {
        let found = self.reader.entity(place).and_then(|entity| {
            let from = if entity.entry.kind == 308 { 3 } else { 1 };
            entity.pointers(from + 1, entity.count(from, 1)?)
        });
        let mut found = found.unwrap_or_else(|problem| {
            self.account.problems(vec![problem]);
            Vec::new()
        });
        if !self.tree.circles.is_empty() {
            found.retain(|&member| {
                let circle = self.tree.circles.contains(&(place, member));
                if circle {
                    self.account.problems(vec![Problem::new(
                        place,
                        "it is in itself: one of its members is left out",
                    )]);
                }
                !circle
            });
        }
        found
    }

    /// Objects of a list of entities.
    fn list(
        &mut self,
        list: &mut Definition,
        places: &[usize],
        parent: Option<&str>,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<(), FormatError> {
        let mut loose = Loose::new();
        for &place in places {
            self.done += 1;
            options.observer.proceed("reading", self.done, self.reader.file.len() as u64)?;
            self.reader.take_used();
            let spot = Spot { name: None, parent, transform: None };
            if let Err(problem) = self.one(list, place, &spot, &mut loose, depth, options)? {
                self.fail(place, problem);
            }
        }
        for ((layer, color), points) in loose {
            let cloud = Geometry::from(Cloud { points });
            let color = color.map(|bits| bits.map(f64::from_bits));
            let spot = Spot { name: None, parent, transform: None };
            self.put(list, cloud, None, (color, layer), &spot)?;
        }
        Ok(())
    }

    fn fail(&mut self, place: usize, problem: Problem) {
        self.reader.take_used();
        if problem.place != place {
            let text = format!("D{}{LEFT_OUT}", self.reader.file.number(problem.place));
            self.account.problems(vec![Problem::new(place, text)]);
        }
        self.account.problems(vec![problem]);
    }

    /// One entity as an object with all that is in it; what is wrong with it is given back.
    fn one(
        &mut self,
        list: &mut Definition,
        place: usize,
        spot: &Spot<'_>,
        loose: &mut Loose,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<Got<()>, FormatError> {
        if depth >= DEEPEST {
            let text = format!("groups hang more than {DEEPEST} deep under one another, or in themselves");
            return Ok(Err(Problem::new(place, text)));
        }
        let entry = self.reader.file.entry(place);
        let (kind, form) = (entry.kind, entry.form);
        if kind != 430 && std::mem::replace(&mut self.seen[place], true) {
            self.account.note(format!(
                "D{} is in more than one group: it is kept in the first",
                self.reader.file.number(place)
            ));
            return Ok(Ok(()));
        }
        match (kind, form) {
            (402, _) if is_group(kind, form) => self.group(list, place, spot, depth, options),
            (408, _) => self.instance(list, place, spot, depth, options),
            (184, _) => self.assembly(list, place, spot, depth, options),
            (430, _) => {
                let found = self
                    .reader
                    .entity(place)
                    .and_then(|entity| Ok((entity.pointer(1)?, self.reader.placed(place)?)));
                let (of, transform) = match found {
                    Ok(found) => found,
                    Err(problem) => return Ok(Err(problem)),
                };
                if !matches!(self.reader.file.entry(of).kind, 184 | 186) {
                    return Ok(Err(Problem::new(place, "an instance of what is no solid that is read")));
                }
                self.seen[of] = false;
                let spot = Spot { transform, ..*spot };
                self.one(list, of, &spot, loose, depth + 1, options)
            }
            (116, _) if spot.name.is_none() && spot.transform.is_none() && self.name(place).is_none() => {
                match self.point(place) {
                    Ok(point) => {
                        let color = self.styles.color(self.reader, place).map(|c| c.map(f64::to_bits));
                        loose.entry((self.layer(place), color)).or_default().push(point);
                        self.keep(place);
                        Ok(Ok(()))
                    }
                    Err(problem) => Ok(Err(problem)),
                }
            }
            _ => {
                let geometry = match self.geometry(place) {
                    Ok(geometry) => geometry,
                    Err(problem) => return Ok(Err(problem)),
                };
                let name = self.name(place);
                let looks = (self.styles.color(self.reader, place), self.layer(place));
                self.put(list, geometry, name.as_deref(), looks, spot)?;
                self.keep(place);
                Ok(Ok(()))
            }
        }
    }

    fn name(&self, place: usize) -> Option<String> {
        self.styles.name(self.reader, place)
    }

    /// Everything that was looked at for an entity is in the scene.
    fn keep(&mut self, place: usize) {
        self.account.keep(&[place]);
        self.account.keep(&self.reader.take_used());
        self.account.changed(self.reader.take_changed());
        self.account.set_aside(&self.reader.take_aside());
    }

    fn group(
        &mut self,
        list: &mut Definition,
        place: usize,
        spot: &Spot<'_>,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<Got<()>, FormatError> {
        let members = self.members(place);
        let name = self.name(place);
        let looks = (self.styles.color(self.reader, place), self.layer(place));
        self.keep(place);
        let points = |entry: &crate::text::Entry| entry.kind == 116;
        let all_points =
            members.iter().all(|&at| points(self.reader.file.entry(at)) && self.name(at).is_none());
        if self.own && !members.is_empty() && all_points {
            // Points together are a cloud.
            let mut cloud = Vec::with_capacity(members.len());
            for &at in &members {
                self.seen[at] = true;
                match self.point(at) {
                    Ok(point) => cloud.push(point),
                    Err(problem) => self.fail(at, problem),
                }
                self.keep(at);
            }
            self.put(list, Cloud { points: cloud }.into(), name.as_deref(), looks, spot)?;
            return Ok(Ok(()));
        }
        self.gathered(list, &members, (name.as_deref(), looks), spot, depth, options)
    }

    /// What is in a group, under one object.
    fn gathered(
        &mut self,
        list: &mut Definition,
        members: &[usize],
        (name, looks): (Option<&str>, Looks),
        spot: &Spot<'_>,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<Got<()>, FormatError> {
        // In files that were written here the first member without a name is what the others hang under.
        let head = members.first().copied().filter(|&at| self.own && self.name(at).is_none());
        let head = head.filter(|&at| {
            let entry = self.reader.file.entry(at);
            !is_group(entry.kind, entry.form) || !self.members(at).is_empty()
        });
        let called = match head {
            Some(at) => {
                let own = spot.name.or(name).unwrap_or(self.stem);
                let inner = Spot { name: Some(own), ..*spot };
                let before = list.objects().len();
                if let Err(problem) = self.one(list, at, &inner, &mut Loose::new(), depth + 1, options)? {
                    self.fail(at, problem);
                }
                list.objects().get(before).map(|object| object.name().to_owned())
            }
            None => Some(self.put(list, Geometry::Group, name, looks, spot)?),
        };
        let rest = if head.is_some() { &members[1..] } else { members };
        let parent = called.as_deref().or(spot.parent);
        self.list(list, rest, parent, depth + 1, options)?;
        Ok(Ok(()))
    }

    /// An instance (408) of a subfigure (308).
    fn instance(
        &mut self,
        list: &mut Definition,
        place: usize,
        spot: &Spot<'_>,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<Got<()>, FormatError> {
        let found = (|| {
            let entity = self.reader.entity(place)?;
            let of = entity.pointer(1)?;
            self.reader.of(of, &[308], "a subfigure (308)")?;
            if self.tree.circles.contains(&(place, of)) {
                return Err(Problem::new(place, "it shows a subfigure within itself"));
            }
            let shift = Vector::from(entity.triple(2)?);
            // A scale of nothing is that of writers that leave it out.
            let scale = Some(entity.real(5)?).filter(|scale| *scale != 0.0).unwrap_or(1.0);
            let own = Matrix4::new_translation(&shift) * Matrix4::new_scaling(scale);
            let map = self.reader.placed(place)?.map_or(own, |map| map * own);
            if map.iter().all(|x| x.is_finite()) {
                return Ok((of, map));
            }
            Err(Problem::new(place, "a number of its place overflows"))
        })();
        let (of, map) = match found {
            Ok(found) => found,
            Err(problem) => return Ok(Err(problem)),
        };
        let transform =
            Some(spot.transform.map_or(map, |outer| outer * map)).filter(|m| *m != Matrix4::identity());
        let name = spot.name.map(str::to_owned).or_else(|| self.name(place));
        let looks = (self.styles.color(self.reader, place), self.layer(place));
        self.keep(place);
        let inner = Spot { name: None, parent: spot.parent, transform };
        if let Some(definition) = self.definitions.get(&of).cloned() {
            let name = name.as_deref().unwrap_or(&definition);
            self.put(list, Geometry::Instance(definition.clone()), Some(name), looks, &inner)?;
            return Ok(Ok(()));
        }
        // Shown once it needs no definition.
        let members = self.members(of);
        let called = name.unwrap_or_else(|| self.figure_name(of));
        if let [only] = members[..] {
            let inner = Spot { name: Some(&called), ..inner };
            return self.one(list, only, &inner, &mut Loose::new(), depth + 1, options);
        }
        self.gathered(list, &members, (Some(&called), looks), &inner, depth, options)
    }

    /// A solid assembly (184): solids, each with its matrix.
    fn assembly(
        &mut self,
        list: &mut Definition,
        place: usize,
        spot: &Spot<'_>,
        depth: usize,
        options: &ReadOptions<'_>,
    ) -> Result<Got<()>, FormatError> {
        let found = (|| {
            let entity = self.reader.entity(place)?;
            let count = entity.count(1, 2)?;
            let mut all = Vec::with_capacity(count);
            for k in 0..count {
                if self.tree.circles.contains(&(place, entity.pointer(2 + k)?)) {
                    return Err(Problem::new(place, "it is in itself"));
                }
                let map = entity.pointed(2 + count + k)?.map(|at| self.reader.matrix(at)).transpose()?;
                all.push((entity.pointer(2 + k)?, map));
            }
            Ok((all, self.reader.placed(place)?))
        })();
        let (items, own) = match found {
            Ok(found) => found,
            Err(problem) => return Ok(Err(problem)),
        };
        let transform = match (spot.transform, own) {
            (Some(outer), Some(own)) => Some(outer * own),
            (outer, own) => outer.or(own),
        };
        let (name, looks) = (self.name(place), (self.styles.color(self.reader, place), self.layer(place)));
        self.keep(place);
        let group = self.put(list, Geometry::Group, name.as_deref(), looks, &Spot { transform, ..*spot })?;
        for (item, transform) in items {
            let spot = Spot { name: None, parent: Some(&group), transform };
            if let Err(problem) = self.one(list, item, &spot, &mut Loose::new(), depth + 1, options)? {
                self.fail(item, problem);
            }
        }
        Ok(Ok(()))
    }

    fn point(&self, place: usize) -> Got<Point> {
        self.reader.point(place)
    }

    /// What an entity is.
    fn geometry(&mut self, place: usize) -> Got<Geometry> {
        let reader = self.reader;
        let entry = reader.file.entry(place);
        Ok(match (entry.kind, entry.form) {
            (106, form) if is_chain(form) || matches!(form, 1..=3) => {
                let entity = reader.entity(place)?;
                let (mut points, closed) = chain(&entity)?;
                moved_points(&mut points, reader.placed(place)?.as_ref());
                if let Some(p) = points.iter().find(|p| !p.iter().all(|c| c.is_finite())) {
                    return Err(Problem::new(place, format!("the coordinates {p} overflow")));
                }
                if !is_chain(form) {
                    return Ok(Cloud { points }.into());
                }
                if closed && points.len() > 1 && points.first() == points.last() {
                    points.pop();
                }
                Polyline { points, closed }.into()
            }
            (116, _) => Cloud { points: vec![reader.point(place)?] }.into(),
            (kind, form) if is_curve(kind, form) => reader.curve(place, 0)?.formed().into(),
            (kind, _) if is_surface(kind) => self.surface(place)?,
            (142, _) => {
                let entity = reader.entity(place)?;
                match entity.pointed(4)? {
                    Some(model) => reader.curve(model, 0)?.formed().into(),
                    None => {
                        let text = "a curve on a surface that has no curve in space is read with a face only";
                        return Err(Problem::new(place, text));
                    }
                }
            }
            (143 | 144, _) => reader.trimmed(place)?,
            (186 | 510 | 514, _) => {
                let model = Builder::build(reader, self.styles, place)?;
                self.account.problems(model.problems);
                model.notes.into_iter().for_each(|note| self.account.note(note));
                model.brep.into()
            }
            (kind, form) => {
                return Err(Problem::new(place, format!("type {kind}, form {form} is not read")));
            }
        })
    }

    /// A surface by itself: a plane is as large as its boundary says.
    fn surface(&self, place: usize) -> Got<Geometry> {
        let reader = self.reader;
        let entry = reader.file.entry(place);
        if entry.kind == 108 && entry.form == 1 {
            return reader.bounded_plane(place);
        }
        Ok(reader.sheet(place, 0)?.whole(place)?.into())
    }

    /// Adds an object, under a name of its own, which is given back.
    fn put(
        &self,
        list: &mut Definition,
        geometry: Geometry,
        name: Option<&str>,
        (color, layer): Looks,
        spot: &Spot<'_>,
    ) -> Result<String, FormatError> {
        let wanted = spot.name.or(name).unwrap_or(self.stem);
        let called = list.unique_name(wanted);
        let mut object = Object::new(called.clone(), geometry).labelled(wanted);
        (object.color, object.layer) = (color, layer);
        object.parent = spot.parent.map(str::to_owned);
        object.transform = spot.transform;
        list.add(object)?;
        Ok(called)
    }
}
