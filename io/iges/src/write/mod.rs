//! The writer: entities of each object, groups of what hangs under one another, subfigures of what is placed.

mod brep;
mod form;
mod own;
mod print;
mod seams;
mod shape;
mod splines;
mod style;
mod tips;
mod trim;

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Outgoing, Sink, WriteReport, Written};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use nalgebra::Matrix4;

use brep::Looks;
use print::{Look, Printer, Purpose, Record, plain};
use style::Styles;

/// How deep objects and definitions may hang under one another: less than what is read again, as each may be two levels there.
const DEEPEST: usize = 60;
/// What a file without tolerances is exact to, in parts of its largest coordinate: curves on surfaces are.
const RESOLUTION: f64 = 1e-7;

/// Writes a scene.
pub(crate) fn write(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    outgoing.scene().check_hierarchy()?;
    let scene = outgoing.converted()?;
    let (flag, unit, known) = unit(outgoing.unit);
    let scene = match (known, outgoing.unit.metres()) {
        (false, Some(_)) => Cow::Owned(scene.converted(Unit::Millimetre, scene.up)?.into_owned()),
        _ => scene,
    };
    let largest = scene.bounds().map_or(0.0, |(low, high)| low.coords.amax().max(high.coords.amax()));
    let stated = resolution(&scene, largest);
    let mut printer = Printer::default();
    let styles = Styles::new(&scene);
    styles.layers(&mut printer);
    let mut writer = Writer {
        outgoing,
        scene: &scene,
        printer,
        styles,
        definitions: HashMap::new(),
        instances: HashSet::new(),
        report: WriteReport::default(),
        tolerance: stated.max(gap(&scene)?),
    };
    writer.scene()?;
    let Writer { printer, styles, mut report, tolerance, .. } = writer;
    if !known && outgoing.unit.metres().is_some() {
        let name = outgoing.unit.name();
        report.notes.push(format!("lengths are in millimetres: IGES has no unit {name}"));
        report.objects.iter_mut().for_each(|object| object.change("its lengths are in millimetres now"));
    }
    report.say(styles.transparent, "colour[|s] [goes|go] out opaque: IGES has no transparency");
    let bare = scene.layers.iter().filter(|layer| layer.color.is_some() || layer.parent.is_some()).count();
    report.say(bare, "layer[|s] [loses its|lose their] colour or the layer above: IGES has names of layers only; objects keep their colours");
    if tolerance > stated {
        let shown = loftsman_kernel::text::short(tolerance);
        report.notes.push(format!(
            "the file states that it is exact to {shown}: edges are as far off their surfaces, or off the tips of cones"
        ));
    }
    let name = sink.name().rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    for part in printer.file(&name, (flag, unit), tolerance, largest)? {
        sink.main().write_all(&part)?;
    }
    Ok(report)
}

/// The flag and the name of a unit, and whether there is one; millimetres instead.
fn unit(unit: Unit) -> (u8, &'static str, bool) {
    let (flag, name) = match unit {
        Unit::Inch => (1, "IN"),
        Unit::Millimetre => (2, "MM"),
        Unit::Foot => (4, "FT"),
        Unit::Mile => (5, "MI"),
        Unit::Metre => (6, "M"),
        Unit::Kilometre => (7, "KM"),
        Unit::Mil => (8, "MIL"),
        Unit::Micrometre => (9, "UM"),
        Unit::Centimetre => (10, "CM"),
        Unit::Unknown => (3, "UNKNOWN"),
        _ => return (2, "MM", false),
    };
    (flag, name, true)
}

/// The geometries of a scene.
fn geometries(scene: &Scene) -> impl Iterator<Item = &Geometry> {
    let defined = scene.definitions().iter().flat_map(|d| d.objects());
    scene.objects().iter().chain(defined).map(Object::geometry)
}

/// The largest tolerance of Breps, as a file has one; else what curves on surfaces are exact to, a part of the largest coordinate: a
/// file must have a positive one.
fn resolution(scene: &Scene, largest: f64) -> f64 {
    let tolerance = geometries(scene).map(|geometry| tolerances(geometry).1).fold(0.0, f64::max);
    if tolerance > 0.0 {
        return tolerance;
    }
    let size = if largest > 0.0 && largest.is_finite() { largest } else { 1.0 };
    (RESOLUTION * size).max(f64::MIN_POSITIVE)
}

/// By how much edges of Breps are off their surfaces, where their tolerances say less.
fn gap(scene: &Scene) -> Result<f64, FormatError> {
    let mut gap = 0.0_f64;
    for geometry in geometries(scene) {
        // Others are refused by name when it is their turn.
        let is_finite = geometry.points().iter().all(|p| p.iter().all(|c| c.is_finite()));
        if let Geometry::Brep(brep) = geometry
            && is_finite
        {
            gap = gap.max(brep.gap()?);
        }
    }
    Ok(gap)
}

/// The smallest and the largest tolerance of a geometry.
fn tolerances(geometry: &Geometry) -> (f64, f64) {
    let Geometry::Brep(brep) = geometry else { return (f64::INFINITY, 0.0) };
    let edges = (0..brep.edge_count()).filter_map(|edge| Some(brep.edge(edge)?.tolerance));
    brep.tolerances()
        .iter()
        .copied()
        .chain(edges)
        .fold((f64::INFINITY, 0.0), |(low, high), t| (low.min(t), high.max(t)))
}

struct Writer<'w, 's> {
    outgoing: &'w Outgoing<'w>,
    scene: &'s Scene,
    printer: Printer,
    styles: Styles,
    /// The subfigures of definitions.
    definitions: HashMap<&'s str, u32>,
    /// The instances that were written.
    instances: HashSet<u32>,
    report: WriteReport,
    tolerance: f64,
}

/// Objects that hang under one another, by the places of those under each.
struct Tree<'s> {
    objects: &'s [Object],
    below: HashMap<&'s str, Vec<usize>>,
    top: Vec<usize>,
    /// Whether they are those of the scene, which are told of.
    told: bool,
}

impl<'s> Tree<'s> {
    fn new(objects: &'s [Object], told: bool) -> Self {
        let (mut below, mut top): (HashMap<_, Vec<usize>>, _) = (HashMap::new(), Vec::new());
        for (place, object) in objects.iter().enumerate() {
            match &object.parent {
                Some(parent) => below.entry(parent.as_str()).or_default().push(place),
                None => top.push(place),
            }
        }
        Self { objects, below, top, told }
    }
}

/// Where what is written belongs.
#[derive(Clone, Copy)]
struct Spot<'m> {
    /// The map of what it is in, where that is no placement.
    baked: Option<&'m Matrix4<f64>>,
    /// Whether another entity has it.
    owned: bool,
    /// Whether that is a subfigure.
    figured: bool,
    depth: usize,
}

impl<'s> Writer<'_, 's> {
    fn scene(&mut self) -> Result<(), FormatError> {
        let objects = self.scene.objects();
        self.report.objects =
            objects.iter().map(|object| Written::kept(object, object.geometry().kind())).collect();
        let tree = Tree::new(objects, true);
        for (done, &place) in tree.top.iter().enumerate() {
            self.outgoing.proceed(done, tree.top.len())?;
            self.object(&tree, place, Spot { baked: None, owned: false, figured: false, depth: 0 })?;
        }
        Ok(())
    }

    /// An object with all that hangs under it: the entity, if anything goes out.
    fn object(&mut self, tree: &Tree<'s>, at: usize, spot: Spot<'_>) -> Result<Option<u32>, FormatError> {
        if spot.depth > DEEPEST {
            let problem =
                format!("objects hang more than {DEEPEST} deep under one another: take some levels out");
            return Err(FormatError::whole(problem).as_kind(FormatErrorKind::Limit));
        }
        let object = &tree.objects[at];
        let (place, inner) = match (spot.baked, object.transform) {
            (None, Some(map)) => match similar(&map) {
                Some(place) => (Some(place), None),
                None => (None, Some(map)),
            },
            (baked, own) => (None, baked.map(|map| map * own.unwrap_or_else(Matrix4::identity))),
        };
        if inner.is_some() && tree.told {
            self.report.objects[at].change(
                "its transform is baked in, as it is not a turn, a mirror, a scale and a shift alone",
            );
        }
        let below = tree.below.get(object.name()).map(Vec::as_slice).unwrap_or_default();
        let instance = match object.geometry() {
            Geometry::Instance(of) => Some(of.as_str()),
            _ => None,
        };
        let grouped = !below.is_empty() || matches!(object.geometry(), Geometry::Group);
        // In a subfigure a group is one, too, that stays where it is: of groups in subfigures OpenCASCADE shows second ones, unplaced.
        let still = Similar { turn: Matrix4::identity(), scale: 1.0 };
        let place = place.or((spot.figured && grouped).then_some(still));
        let figured = place.is_some();
        let under = Spot { baked: inner.as_ref(), owned: true, figured, depth: spot.depth + 1 };
        // Its name stands with what is the whole of it.
        let named = place.is_none() && !grouped;
        let owned = spot.owned || grouped || place.is_some();
        let mut own = Vec::new();
        match instance {
            Some(of) if place.is_some() && !grouped && inner.is_none() => {
                let number = self.definition(of, under)?;
                self.told(tree, at, "subfigure instance");
                return self.place(object, number, place, spot.owned).map(Some);
            }
            Some(of) => {
                self.told(tree, at, "subfigure instance");
                match &inner {
                    None => {
                        let number = self.definition(of, under)?;
                        let name = named.then(|| object.name());
                        own.push(self.placed_figure(number, None, name, object, owned)?);
                    }
                    Some(_) => {
                        let list = Tree::new(self.scene.definition(of)?.objects(), false);
                        let mut all = Vec::new();
                        for &top in &list.top {
                            all.extend(self.object(&list, top, under)?);
                        }
                        let name = named.then(|| object.name());
                        own.push(self.group(&all, name, object, owned));
                    }
                }
            }
            None => {
                let out = self.own(object, inner.as_ref(), named, owned).map_err(|e| e.of(object.name()))?;
                match out {
                    Ok(out) => {
                        if tree.told {
                            let told = &mut self.report.objects[at];
                            out.form.clone_into(&mut told.form);
                            out.changes.iter().for_each(|change| told.change(change));
                        }
                        own = out.items;
                    }
                    Err(why) => {
                        if tree.told {
                            self.report.objects[at].leave_out(why);
                        }
                    }
                }
            }
        }
        if tree.told && plain(object.name()) != object.name() {
            self.report.objects[at].change("its name loses line breaks and outer blanks");
        }
        let mut members = Vec::new();
        for &child in below {
            let found = self.object(tree, child, under)?;
            members.extend(found.map(|found| (found, tree.objects[child].name())));
        }
        // What is first and has no name is what the others hang under: that stays as it is.
        let members = if place.is_some() && own.is_empty() {
            self.evened(members, spot.depth)
        } else {
            members.into_iter().map(|(member, _)| member).collect()
        };
        if grouped {
            if own.is_empty() && members.is_empty() && !matches!(object.geometry(), Geometry::Group) {
                return Ok(None);
            }
            // Several entities of one object are a group of their own.
            if own.len() > 1 {
                own = vec![self.group(&own, None, object, true)];
            }
            own.extend(members);
        }
        let alone = own.len() == 1 && !grouped;
        match (place, &own[..]) {
            (_, []) if !grouped => Ok(None),
            (None, &[only]) if alone => Ok(Some(only)),
            (None, all) => Ok(Some(self.group(all, Some(object.name()), object, spot.owned))),
            (Some(_), all) => {
                // Several are in the subfigure as they are: of a group that is all of a subfigure, OpenCASCADE shows a second one,
                // unplaced. One alone would be the object itself without a group around it.
                let single = !alone && all.len() < 2;
                let inside = if single { vec![self.group(all, None, object, true)] } else { all.to_vec() };
                // Without a name: definitions have one, by which they are told from what is only placed.
                let figure = self.figure("", &inside, spot.depth);
                self.place(object, figure, place, spot.owned).map(Some)
            }
        }
    }

    fn told(&mut self, tree: &Tree<'s>, at: usize, form: &str) {
        if tree.told {
            form.clone_into(&mut self.report.objects[at].form);
        }
    }

    /// A group (402) of entities.
    fn group(&mut self, members: &[u32], name: Option<&str>, object: &Object, owned: bool) -> u32 {
        let properties = self.properties(name);
        let color =
            matches!(object.geometry(), Geometry::Group).then(|| self.scene.color_of(object)).flatten();
        let look = self.styles.look(&mut self.printer, object, color);
        let record = Record::new(402).count(members.len()).entities(members).properties(&properties);
        self.printer.put(record, Look { owned, ..look.form(7) })
    }

    /// The name of an object as a property.
    fn properties(&mut self, name: Option<&str>) -> Vec<u32> {
        name.map(|name| self.styles.name(&mut self.printer, name)).into_iter().collect()
    }

    /// A subfigure (308) of entities.
    fn figure(&mut self, name: &str, members: &[u32], depth: usize) -> u32 {
        let record = Record::new(308).count(depth).text(name).count(members.len()).entities(members);
        self.printer.put(record, Look::default().purpose(Purpose::Definition))
    }

    /// The members of a subfigure, with their names: where some are instances and others are not, these become instances, too, that stay where
    /// they are. OpenCASCADE's reader of assemblies shows a subfigure of both a second time, unplaced.
    fn evened(&mut self, members: Vec<(u32, &str)>, depth: usize) -> Vec<u32> {
        let placed: Vec<bool> = members.iter().map(|(member, _)| self.instances.contains(member)).collect();
        let mixed = placed.contains(&true) && placed.contains(&false);
        let mut all = Vec::with_capacity(members.len());
        for ((member, name), placed) in members.into_iter().zip(placed) {
            if placed || !mixed {
                all.push(member);
                continue;
            }
            let figure = self.figure("", &[member], depth);
            let properties = self.properties(Some(name));
            let record = Record::new(408).entity(figure).reals(&[0.0; 3]).real(1.0).properties(&properties);
            all.push(self.printer.put(record, Look { owned: true, ..Look::default() }));
        }
        all
    }

    /// An instance (408) of a subfigure under the name of the object.
    fn place(
        &mut self,
        object: &Object,
        figure: u32,
        place: Option<Similar>,
        owned: bool,
    ) -> Result<u32, FormatError> {
        self.placed_figure(figure, place, Some(object.name()), object, owned)
    }

    fn placed_figure(
        &mut self,
        figure: u32,
        place: Option<Similar>,
        name: Option<&str>,
        object: &Object,
        owned: bool,
    ) -> Result<u32, FormatError> {
        let properties = self.properties(name);
        let bare = matches!(object.geometry(), Geometry::Instance(_) | Geometry::Group);
        let color = bare.then(|| self.scene.color_of(object)).flatten();
        let look = self.styles.look(&mut self.printer, object, color);
        let (shift, scale, turn) = match place {
            Some(Similar { turn, scale }) => {
                // What only shifts needs no matrix.
                let shift = turn.fixed_view::<3, 1>(0, 3).into_owned();
                let only = turn.fixed_view::<3, 3>(0, 0).into_owned() == nalgebra::Matrix3::identity();
                if only { (shift, scale, None) } else { (nalgebra::Vector3::zeros(), scale, Some(turn)) }
            }
            None => (nalgebra::Vector3::zeros(), 1.0, None),
        };
        let matrix = turn.map(|turn| self.printer.matrix(&turn));
        let record = Record::new(408).entity(figure).reals(shift.iter()).real(scale).properties(&properties);
        let number = self.printer.put(record, Look { matrix, owned, ..look });
        self.instances.insert(number);
        Ok(number)
    }

    /// The subfigure of a definition, written once.
    fn definition(&mut self, name: &'s str, spot: Spot<'_>) -> Result<u32, FormatError> {
        if let Some(known) = self.definitions.get(name) {
            return Ok(*known);
        }
        let tree = Tree::new(self.scene.definition(name)?.objects(), false);
        let mut members = Vec::new();
        for &top in &tree.top {
            let inner = Spot { baked: None, owned: true, figured: true, depth: spot.depth + 1 };
            let found = self.object(&tree, top, inner)?;
            members.extend(found.map(|found| (found, tree.objects[top].name())));
        }
        let members = self.evened(members, spot.depth);
        let figure = self.figure(name, &members, spot.depth);
        self.definitions.insert(name, figure);
        Ok(figure)
    }
}

/// A map that turns, mirrors and shifts, behind one that scales.
#[derive(Clone, Copy)]
struct Similar {
    turn: Matrix4<f64>,
    scale: f64,
}

/// A map as such a one, where it is.
fn similar(map: &Matrix4<f64>) -> Option<Similar> {
    let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
    let largest = linear.amax();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let squared = (linear / largest).transpose() * (linear / largest);
    let size = squared.trace() / 3.0;
    if (squared - nalgebra::Matrix3::identity() * size).amax() > 1e-12 * size {
        return None;
    }
    let scale = largest * size.sqrt();
    let scale = if (scale - 1.0).abs() <= 4e-16 { 1.0 } else { scale };
    let mut turn = *map;
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&(linear / scale));
    Some(Similar { turn, scale })
}
