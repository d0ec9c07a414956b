//! The writer: a product for each object, assemblies of what hangs under one another.

mod brep;
mod context;
mod facets;
mod form;
mod item;
mod occurrence;
mod paint;
mod parameters;
mod print;
mod spline;
mod style;
mod swept;
mod trimmed;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use loftsman_kernel::brep::Frame;
use loftsman_kernel::plugin::{Fate, FormatError, FormatErrorKind, Outgoing, Sink, WriteReport, Written};
use loftsman_kernel::scene::{Geometry, Object, Scene, Unit};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use crate::part21::encode;
use context::{Common, END, header};
use item::Put;
use occurrence::{Key, shared};
use paint::Paint;
use print::{Printer, references};
use style::{Carrier, Looks};

/// How deep objects and definitions may hang under one another: as deep as they are read again.
const DEEPEST: usize = 200;
/// The axes at the origin.
const START: Frame =
    Frame { origin: Point::new(0.0, 0.0, 0.0), x: Vector::new(1.0, 0.0, 0.0), z: Vector::new(0.0, 0.0, 1.0) };
/// So much is kept before it goes to the file.
const BUFFER: usize = 1 << 20;

/// Writes a scene.
pub(crate) fn write(outgoing: &Outgoing<'_>, sink: &mut dyn Sink) -> Result<WriteReport, FormatError> {
    outgoing.scene().check_hierarchy()?;
    let scene = outgoing.converted()?;
    let name = sink.name().to_owned();
    let mut printer = Printer::default();
    printer.millimetres = outgoing.unit == Unit::Millimetre;
    printer.out.extend_from_slice(header(&name).as_bytes());
    let common = Common::new(&mut printer, outgoing.unit);
    let numbers = scene.definitions().iter().map(|of| (of.name(), printer.reserve())).collect();
    let mut writer = Writer {
        outgoing,
        scene: &scene,
        sink,
        printer,
        common,
        looks: Looks::default(),
        origin: 0,
        definitions: HashMap::new(),
        numbers,
        shared: shared(&scene),
        report: WriteReport::default(),
        inside: BTreeMap::new(),
    };
    writer.scene()?;
    let Writer { mut printer, mut common, looks, mut report, sink, inside, .. } = writer;
    // Those of definitions that are as they were are not listed: what shows them is.
    report.objects.extend(inside.into_values().filter(|told| told.fate != Fate::Kept));
    let context = common.context(&mut printer, 0.0);
    let lost = looks.finish(&mut printer, &scene, context);
    report.say(lost, "layer[|s] that nothing is on [is|are] lost");
    printer.out.extend_from_slice(END.as_bytes());
    sink.main().write_all(&printer.out)?;
    Ok(report)
}

/// A product that was written.
#[derive(Debug, Clone)]
struct Product {
    definition: u64,
    representation: u64,
    /// What in it has no colour, and takes that of an occurrence.
    plain: Rc<[(u64, Carrier)]>,
}

/// An object that was written as a product: as what, and what comes back changed.
#[derive(Debug, Clone)]
struct Out {
    product: Product,
    form: &'static str,
    changes: Vec<&'static str>,
}

/// A product in another one.
struct Component<'s> {
    product: Product,
    name: &'s str,
    label: &'s str,
    place: Option<Frame>,
    color: Option<[f64; 4]>,
}

struct Writer<'w, 's> {
    outgoing: &'w Outgoing<'w>,
    scene: &'s Scene,
    sink: &'w mut dyn Sink,
    printer: Printer,
    common: Common,
    looks: Looks,
    /// The placement at the origin.
    origin: u64,
    /// The products of definitions; none where nothing of one goes out.
    definitions: HashMap<&'s str, Option<Product>>,
    /// The numbers of the PRODUCTs of definitions: in their order, however they show one another.
    numbers: HashMap<&'s str, u64>,
    /// The products of geometries that several objects share, once they are written.
    shared: HashMap<Key<'s>, Option<Result<Out, Cow<'static, str>>>>,
    report: WriteReport,
    /// What is told of objects of definitions.
    inside: BTreeMap<(&'s str, usize), Written>,
}

/// Objects that hang under one another, by the places of those under each.
struct Tree<'s> {
    objects: &'s [Object],
    below: HashMap<&'s str, Vec<usize>>,
    top: Vec<usize>,
    /// The definition that they are in; none of those of the scene.
    of: Option<&'s str>,
}

impl<'s> Tree<'s> {
    fn new(objects: &'s [Object], of: Option<&'s str>) -> Self {
        let (mut below, mut top): (HashMap<_, Vec<usize>>, _) = (HashMap::new(), Vec::new());
        for (place, object) in objects.iter().enumerate() {
            match &object.parent {
                Some(parent) => below.entry(parent.as_str()).or_default().push(place),
                None => top.push(place),
            }
        }
        Self { objects, below, top, of }
    }
}

impl<'s> Writer<'_, 's> {
    fn scene(&mut self) -> Result<(), FormatError> {
        self.origin = self.printer.frame(&START);
        let objects = self.scene.objects();
        self.report.objects =
            objects.iter().map(|object| Written::kept(object, object.geometry().kind())).collect();
        let tree = Tree::new(objects, None);
        // What stands by itself is a product by itself; what is placed needs one that it is placed in.
        let placed = |object: &Object| {
            object.transform.is_some()
                || matches!(object.geometry(), Geometry::Instance(_))
                || !tree.below.contains_key(object.name())
                    && self.shared.contains_key(&Key::of(self.scene, object))
        };
        let assembly = tree.top.iter().any(|&place| placed(&objects[place]));
        let mut components = Vec::new();
        for (done, &place) in tree.top.iter().enumerate() {
            self.outgoing.proceed(done, tree.top.len())?;
            components.extend(self.component(&tree, place, None, 0)?);
        }
        if assembly && !components.is_empty() {
            self.assembly(["scene", "scene", crate::SCENE], None, None, &components);
        }
        Ok(())
    }

    /// An object with all that hangs under it, and where it is; `baked` is the map of what it is in, where that is no placement.
    fn component(
        &mut self,
        tree: &Tree<'s>,
        at: usize,
        baked: Option<&Matrix4<f64>>,
        depth: usize,
    ) -> Result<Option<Component<'s>>, FormatError> {
        if depth > DEEPEST {
            let problem =
                format!("objects hang more than {DEEPEST} deep under one another: take some levels out");
            return Err(FormatError::whole(problem).as_kind(FormatErrorKind::Limit));
        }
        let object = &tree.objects[at];
        let (name, label) = (object.name(), object.label());
        let (place, inner) = match (baked, object.transform) {
            (None, Some(map)) => match rigid(&map) {
                Some(place) => (Some(place), None),
                None => (None, Some(map)),
            },
            (baked, own) => (None, baked.map(|map| map * own.unwrap_or_else(Matrix4::identity))),
        };
        if inner.is_some() {
            self.told(tree, at).change("its transform is baked in, as it is no turn and shift");
        }
        let mut components = Vec::new();
        for &below in tree.below.get(name).into_iter().flatten() {
            components.extend(self.component(tree, below, inner.as_ref(), depth + 1)?);
        }
        let product = match object.geometry() {
            Geometry::Instance(of) => self.instance(tree, at, of, inner.as_ref(), components, depth)?,
            _ => self.own(tree, at, inner.as_ref(), &components).map_err(|e| e.of(name))?,
        };
        self.flush()?;
        let color = object.color.filter(|_| matches!(object.geometry(), Geometry::Instance(_)));
        // What others called this one of a part.
        let label = object.statement(crate::OCCURRENCE).unwrap_or(label);
        Ok(product.map(|product| Component { product, name, label, place, color }))
    }

    /// What is told of an object.
    fn told(&mut self, tree: &Tree<'s>, at: usize) -> &mut Written {
        let object = &tree.objects[at];
        match tree.of {
            None => &mut self.report.objects[at],
            Some(of) => self.inside.entry((of, at)).or_insert_with(|| {
                let told = Written::kept(object, object.geometry().kind());
                Written { object: format!("{of}/{}", object.name()), ..told }
            }),
        }
    }

    /// Tells as what an object went out, and what comes back changed.
    fn tell(&mut self, tree: &Tree<'s>, at: usize, out: &Result<Out, Cow<'static, str>>) {
        let told = self.told(tree, at);
        match out {
            Ok(out) => {
                out.form.clone_into(&mut told.form);
                out.changes.iter().for_each(|change| told.change(change));
            }
            Err(why) => told.leave_out(why.clone()),
        }
    }

    /// The product of what an instance shows.
    fn instance(
        &mut self,
        tree: &Tree<'s>,
        at: usize,
        of: &'s str,
        baked: Option<&Matrix4<f64>>,
        mut under: Vec<Component<'s>>,
        depth: usize,
    ) -> Result<Option<Product>, FormatError> {
        let object = &tree.objects[at];
        let told = self.told(tree, at);
        told.form = "occurrence of a product".to_owned();
        if object.layer.is_some() {
            told.change("its layer is left out: an occurrence has none");
        }
        let product = match baked {
            None => self.definition(of, depth)?,
            Some(map) => {
                let list = Tree::new(self.scene.definition(of)?.objects(), Some(of));
                let mut components = Vec::new();
                for &top in &list.top {
                    components.extend(self.component(&list, top, Some(map), depth + 1)?);
                }
                (!components.is_empty())
                    .then(|| self.assembly([object.name(), object.label(), ""], None, None, &components))
            }
        };
        let plain = product.as_ref().map(|product| &*product.plain);
        if let Some(change) = object.color.and_then(|color| occurrence::told(plain?, color)) {
            self.told(tree, at).change(change);
        }
        if under.is_empty() {
            if product.is_none() {
                self.told(tree, at).leave_out("nothing of what it shows goes out");
            }
            return Ok(product);
        }
        // Objects hang under the instance: both are in a product of its own, in which it alone has the colour.
        if let Some(product) = product {
            let (name, label) = (object.name(), object.label());
            under.insert(0, Component { product, name, label, place: None, color: object.color });
        }
        Ok(Some(self.assembly([object.name(), object.label(), ""], None, None, &under)))
    }

    /// The product of a definition, written once.
    fn definition(&mut self, name: &'s str, depth: usize) -> Result<Option<Product>, FormatError> {
        if let Some(known) = self.definitions.get(name) {
            return Ok(known.clone());
        }
        let tree = Tree::new(self.scene.definition(name)?.objects(), Some(name));
        let product = match tree.objects {
            // A single thing needs no assembly around it.
            [only]
                if only.transform.is_none()
                    && !matches!(only.geometry(), Geometry::Instance(_) | Geometry::Group) =>
            {
                let out = self.product(only, None, &[], [name, name, crate::DEFINITION])?;
                self.tell(&tree, 0, &out);
                out.ok().map(|out| out.product)
            }
            _ => {
                let mut components = Vec::new();
                for &top in &tree.top {
                    components.extend(self.component(&tree, top, None, depth + 1)?);
                }
                (!components.is_empty())
                    .then(|| self.assembly([name, name, crate::DEFINITION], None, None, &components))
            }
        };
        self.definitions.insert(name, product.clone());
        Ok(product)
    }

    /// The product of an object that is no instance; told of, where it is one of the scene.
    fn own(
        &mut self,
        tree: &Tree<'s>,
        at: usize,
        baked: Option<&Matrix4<f64>>,
        under: &[Component<'_>],
    ) -> Result<Option<Product>, FormatError> {
        let object = &tree.objects[at];
        let key = Key::of(self.scene, object);
        let is_shared = baked.is_none() && under.is_empty() && self.shared.contains_key(&key);
        let out = match self.shared.get(&key) {
            Some(Some(known)) if is_shared => known.clone(),
            _ => {
                let about = if is_shared { crate::SHARED } else { "" };
                self.product(object, baked, under, [object.name(), object.label(), about])?
            }
        };
        if is_shared {
            self.shared.insert(key, Some(out.clone()));
        }
        self.tell(tree, at, &out);
        Ok(out.ok().map(|out| out.product).or_else(|| {
            // It goes out as what holds the others.
            (!under.is_empty()).then(|| self.assembly([object.name(), object.label(), ""], None, None, under))
        }))
    }

    /// The product of an object and what is in it, or why there is none.
    fn product(
        &mut self,
        object: &Object,
        baked: Option<&Matrix4<f64>>,
        under: &[Component<'_>],
        [name, label, about]: [&str; 3],
    ) -> Result<Result<Out, Cow<'static, str>>, FormatError> {
        let moved = baked.map(|map| object.geometry().transformed(map)).transpose()?;
        let geometry = moved.as_ref().unwrap_or(object.geometry());
        check_finite(geometry).map_err(|error| error.of(object.name()))?;
        let paint = Paint::of(self.scene, object);
        let color = paint.all;
        match item::put(&mut self.printer, geometry, object.name(), &paint)? {
            Put::LeftOut(why) => Ok(Err(why)),
            Put::Nothing => {
                // A group has nothing to colour but a placement of its own.
                let looks = color.is_some() || object.layer.is_some();
                let mark = looks.then(|| self.printer.frame(&START));
                if let (Some(mark), Some(color)) = (mark, color) {
                    self.looks.color(&mut self.printer, mark, color, Carrier::Surface);
                }
                if let (Some(mark), Some(layer)) = (mark, &object.layer) {
                    self.looks.layer(mark, layer);
                }
                let about = if under.is_empty() && about.is_empty() { crate::GROUP } else { about };
                let product = self.assembly([name, label, about], mark, None, under);
                Ok(Ok(Out { product, form: "assembly", changes: Vec::new() }))
            }
            Put::Items(mut items) => {
                for &(face, color) in &items.faces {
                    self.looks.color(&mut self.printer, face, color, Carrier::Surface);
                }
                items.has_color = color.is_some();
                for &number in &items.colored {
                    if let Some(color) = color {
                        self.looks.color(&mut self.printer, number, color, items.carrier);
                    }
                }
                if color.is_some_and(|color| color[3] < 1.0) && items.carrier != Carrier::Surface {
                    items.changes.push("opaque: curves and points have no transparency");
                }
                for &number in &items.items {
                    if let Some(layer) = &object.layer {
                        self.looks.layer(number, layer);
                    }
                }
                let product = self.assembly([name, label, about], None, Some(&items), under);
                Ok(Ok(Out { product, form: items.form, changes: items.changes }))
            }
        }
    }

    /// A product of some items and of others in it: its name, label and description; `mark` is one more placement.
    fn assembly(
        &mut self,
        [name, label, about]: [&str; 3],
        mark: Option<u64>,
        items: Option<&item::Items>,
        components: &[Component<'_>],
    ) -> Product {
        let context = self.common.context(&mut self.printer, items.map_or(0.0, |items| items.uncertainty));
        let p = &mut self.printer;
        let mut all = vec![mark.unwrap_or(self.origin)];
        let places: Vec<u64> =
            components.iter().map(|c| c.place.map_or(self.origin, |place| p.frame(&place))).collect();
        all.extend(items.into_iter().flat_map(|items| &items.items));
        all.extend(places.iter().filter(|place| **place != self.origin));
        let kind = items.map_or("SHAPE_REPRESENTATION", |items| items.representation);
        let reserved = self.numbers.get(name).copied().filter(|_| about == crate::DEFINITION);
        let (name, label, about) = (encode(name), encode(label), encode(about));
        let representation = p.put(&format!("{kind}({label},{},#{context})", references(&all)));
        let product = reserved.unwrap_or_else(|| p.reserve());
        p.put_as(product, &format!("PRODUCT({name},{label},{about},(#{}))", self.common.product));
        p.put(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))"));
        let formation = p.put(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
        let definition =
            p.put(&format!("PRODUCT_DEFINITION('design','',#{formation},#{})", self.common.definition));
        let shape = p.put(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
        p.put(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})"));
        for (component, place) in components.iter().zip(places) {
            let Component { product: part, name, label, color, .. } = component;
            let (name, label) = (encode(name), encode(label));
            let usage = p.put(&format!(
                "NEXT_ASSEMBLY_USAGE_OCCURRENCE({name},{label},'',#{definition},#{},$)",
                part.definition
            ));
            let of = p.put(&format!("PRODUCT_DEFINITION_SHAPE('','',#{usage})"));
            let map = p.put(&format!("ITEM_DEFINED_TRANSFORMATION('','',#{},#{place})", self.origin));
            let relation = p.put(&format!(
                "(REPRESENTATION_RELATIONSHIP('','',#{},#{representation})\
                 REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{map})SHAPE_REPRESENTATION_RELATIONSHIP())",
                part.representation
            ));
            p.put(&format!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{of})"));
            if let Some(color) = color.filter(|_| !part.plain.is_empty()) {
                let within = p.put(&format!("SHAPE_REPRESENTATION('',(#{place}),#{context})"));
                p.put(&format!("SHAPE_DEFINITION_REPRESENTATION(#{of},#{within})"));
                for &(item, carrier) in &*part.plain {
                    self.looks.color_within(p, within, item, color, carrier);
                }
            }
        }
        Product { definition, representation, plain: occurrence::plain(items, components) }
    }

    fn flush(&mut self) -> Result<(), FormatError> {
        if self.printer.out.len() > BUFFER {
            self.sink.main().write_all(&self.printer.out)?;
            self.printer.out.clear();
        }
        Ok(())
    }
}

/// Refuses a geometry whose numbers cannot be written, with the first of these.
fn check_finite(geometry: &Geometry) -> Result<(), FormatError> {
    let points = geometry.points();
    match points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some((k, p)) => {
            let problem =
                format!("point {k} is at ({}, {}, {}): every coordinate must be finite", p.x, p.y, p.z);
            Err(FormatError::whole(problem).as_kind(FormatErrorKind::Unsupported))
        }
    }
}

/// The place that a map brings the axes to, where it turns and shifts only.
fn rigid(map: &Matrix4<f64>) -> Option<Frame> {
    let column = |k: usize| Vector::new(map[(0, k)], map[(1, k)], map[(2, k)]);
    let [x, y, z] = [column(0), column(1), column(2)];
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12;
    let units = [x, y, z].iter().all(|axis| near(axis.norm_squared(), 1.0));
    let square = near(x.dot(&y), 0.0) && near(y.dot(&z), 0.0) && near(z.dot(&x), 0.0);
    let turns = units && square && x.cross(&y).dot(&z) > 0.0;
    turns.then(|| Frame { origin: Point::from(column(3)), x, z })
}
