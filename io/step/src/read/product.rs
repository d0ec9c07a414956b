//! Products: what belongs to which, what is placed where, and what is shown more than once.

use std::collections::{BTreeMap, HashMap, HashSet};

use loftsman_kernel::brep::Frame;
use nalgebra::Matrix4;

use super::entity::{Args, Got, Problem, entity};
use super::place::Space;
use super::units::Contexts;
use crate::part21::{Entity, File, Value};

/// A product, or a representation that is shown without being one.
#[derive(Debug, Default)]
pub(crate) struct Node {
    pub(crate) name: String,
    /// What it is called where names may be equal.
    pub(crate) label: String,
    /// Its representations.
    pub(crate) representations: Vec<u64>,
    /// What it is put together of.
    pub(crate) children: Vec<Child>,
    pub(crate) role: Role,
    /// Whether it is a representation that no product has.
    pub(crate) is_lone: bool,
    /// How often others show it.
    pub(crate) uses: usize,
    /// Its PRODUCT, where it has one.
    pub(crate) product: u64,
}

/// What a product stands for, as files say that were written here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Role {
    #[default]
    Part,
    /// The scene as a whole, which is no object.
    Scene,
    /// A definition, whether it is shown once or more often.
    Definition,
    /// A group, whether anything is in it or not.
    Group,
    /// A geometry that several objects share.
    Shared,
}

/// A product in another one.
#[derive(Debug)]
pub(crate) struct Child {
    /// The entity that says so.
    pub(crate) number: u64,
    pub(crate) node: usize,
    pub(crate) name: String,
    pub(crate) label: String,
    pub(crate) place: Matrix4<f64>,
    /// The colour that its part has here, whatever it has elsewhere.
    pub(crate) color: Option<[f64; 4]>,
}

/// All products of a file.
#[derive(Debug, Default)]
pub(crate) struct Products {
    pub(crate) nodes: Vec<Node>,
    /// Of each PRODUCT_DEFINITION and each representation the node.
    definitions: HashMap<u64, usize>,
    of_representation: HashMap<u64, usize>,
    /// Of each representation or definition of the shape of an occurrence that occurrence.
    of_occurrences: HashMap<u64, u64>,
    /// The entities that were understood.
    pub(crate) read: Vec<u64>,
    pub(crate) problems: Vec<Problem>,
    /// Representations of parts of shapes, for dimensions and notes: what they hold is elsewhere too.
    aside: HashSet<u64>,
}

/// The entities that products are read from, by type, ascending.
#[derive(Debug, Default)]
pub(crate) struct Sources {
    /// SHAPE_DEFINITION_REPRESENTATION.
    pub(crate) shapes: Vec<u64>,
    /// SHAPE_REPRESENTATION_RELATIONSHIP and REPRESENTATION_RELATIONSHIP, alone.
    pub(crate) relations: Vec<u64>,
    /// CONTEXT_DEPENDENT_SHAPE_REPRESENTATION.
    pub(crate) placements: Vec<u64>,
    /// NEXT_ASSEMBLY_USAGE_OCCURRENCE.
    pub(crate) usages: Vec<u64>,
    /// PROPERTY_DEFINITION_REPRESENTATION.
    pub(crate) properties: Vec<u64>,
    /// Everything that may be a representation of a shape.
    pub(crate) representations: Vec<u64>,
}

/// The attributes of a representation: name, items, context.
pub(crate) fn representation<'e, 'f>(entity: &'e Entity<'f>) -> Got<Args<'e, 'f>> {
    if entity.only().is_empty() { entity.of("REPRESENTATION") } else { Ok(entity.args()) }
}

impl Products {
    pub(crate) fn read(file: &File<'_>, sources: &Sources, contexts: &mut Contexts) -> Self {
        let mut products = Self::default();
        let related = products.related(file, &sources.relations);
        for &number in &sources.shapes {
            if let Err(problem) = products.shape(file, number, &related) {
                products.problems.push(problem);
            }
        }
        let mut placements = HashMap::new();
        for &number in &sources.placements {
            match products.placement(file, number, contexts) {
                Ok(Some((usage, place))) => {
                    placements.entry(usage).or_insert((number, place));
                }
                Ok(None) => {}
                Err(problem) => products.problems.push(problem),
            }
        }
        for &number in &sources.usages {
            if let Err(problem) = products.usage(file, number, &placements) {
                products.problems.push(problem);
            }
        }
        products.lone(file, sources, &related);
        products.mapped(file, contexts);
        products.untie();
        for node in 0..products.nodes.len() {
            for child in 0..products.nodes[node].children.len() {
                let of = products.nodes[node].children[child].node;
                products.nodes[of].uses += 1;
            }
        }
        products
    }

    /// Which representations are of the same thing.
    fn related(&mut self, file: &File<'_>, relations: &[u64]) -> BTreeMap<u64, Vec<u64>> {
        let mut related: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        for &number in relations {
            let both = entity(file, number).and_then(|relation| {
                let args = relation.args();
                Ok([args.reference(2)?, args.reference(3)?])
            });
            match both {
                Ok([a, b]) => {
                    related.entry(a).or_default().push(b);
                    related.entry(b).or_default().push(a);
                    self.read.push(number);
                }
                Err(problem) => self.problems.push(problem),
            }
        }
        related
    }

    /// A SHAPE_DEFINITION_REPRESENTATION: a product's shape.
    fn shape(&mut self, file: &File<'_>, number: u64, related: &BTreeMap<u64, Vec<u64>>) -> Got<()> {
        let shape = entity(file, number)?;
        let (property, first) = (shape.args().reference(0)?, shape.args().reference(1)?);
        let property_entity = entity(file, property)?;
        let definition = property_entity.args().reference(2)?;
        let about = entity(file, definition)?;
        if !about.only().starts_with(b"PRODUCT_DEFINITION") || about.only() == b"PRODUCT_DEFINITION_SHAPE" {
            self.aside.insert(first);
            if about.only() == b"NEXT_ASSEMBLY_USAGE_OCCURRENCE" {
                self.of_occurrences.insert(first, definition);
            }
            return Ok(());
        }
        let node = self.product(file, &about);
        self.read.extend([number, property]);
        self.add_representations(node, first, related);
        Ok(())
    }

    /// A representation, with all that are of the same thing.
    fn add_representations(&mut self, node: usize, first: u64, related: &BTreeMap<u64, Vec<u64>>) {
        let mut waiting = vec![first];
        while let Some(number) = waiting.pop() {
            if self.of_representation.contains_key(&number) {
                continue;
            }
            self.of_representation.insert(number, node);
            self.nodes[node].representations.push(number);
            waiting.extend(related.get(&number).into_iter().flatten());
        }
    }

    /// The node of a PRODUCT_DEFINITION.
    fn product(&mut self, file: &File<'_>, definition: &Entity<'_>) -> usize {
        if let Some(&known) = self.definitions.get(&definition.number) {
            return known;
        }
        let mut chain = vec![definition.number];
        let name = (|| {
            let formation = entity(file, definition.args().reference(2)?)?;
            let product = entity(file, formation.args().reference(2)?)?;
            chain.extend([formation.number, product.number]);
            let args = product.of("PRODUCT")?;
            let roles = [
                (crate::SCENE, Role::Scene),
                (crate::DEFINITION, Role::Definition),
                (crate::GROUP, Role::Group),
                (crate::SHARED, Role::Shared),
            ];
            let own = roles.into_iter().filter(|_| file.header.system == crate::SYSTEM);
            let role = own
                .into_iter()
                .find(|(about, _)| args.name(2) == *about)
                .map_or(Role::Part, |(_, role)| role);
            Ok((called(file, &args), role, product.number))
        })();
        self.read.extend(chain);
        let ((name, label), role, product) = name.unwrap_or_else(|problem| {
            self.problems.push(problem);
            Default::default()
        });
        self.nodes.push(Node { name, label, role, product, ..Node::default() });
        self.definitions.insert(definition.number, self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// A CONTEXT_DEPENDENT_SHAPE_REPRESENTATION: where an occurrence is.
    fn placement(
        &mut self,
        file: &File<'_>,
        number: u64,
        contexts: &mut Contexts,
    ) -> Got<Option<(u64, Matrix4<f64>)>> {
        let placed = entity(file, number)?;
        let relation = entity(file, placed.args().reference(0)?)?;
        let property = entity(file, placed.args().reference(1)?)?;
        let usage = property.args().reference(2)?;
        self.read.extend([relation.number, property.number]);
        self.of_occurrences.extend([(number, usage), (property.number, usage), (relation.number, usage)]);
        if relation.part("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION").is_none() {
            return Ok(None);
        }
        let both = relation.of("REPRESENTATION_RELATIONSHIP")?;
        let (first, second) = (both.reference(2)?, both.reference(3)?);
        let by = relation.of("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION")?.reference(0)?;
        let operator = entity(file, by)?;
        let args = operator.of("ITEM_DEFINED_TRANSFORMATION")?;
        let mut frame = |index: usize, of: u64| {
            let units = units(file, of, contexts)?;
            Space { file, units }.frame(args.reference(index)?)
        };
        let (from, to) = (frame(2, first)?, frame(3, second)?);
        // The first is the part's and the second the assembly's, but for writers that have them the other way.
        let usage_entity = entity(file, usage)?;
        let usage_args = usage_entity.of("NEXT_ASSEMBLY_USAGE_OCCURRENCE")?;
        let node = |index| Ok(self.definitions.get(&usage_args.reference(index)?).copied());
        let (whole, part) = (node(3)?, node(4)?);
        let of = |representation| self.of_representation.get(&representation).copied();
        let swapped = whole.is_some() && whole != part && of(first) == whole && of(second) == part;
        let place = if swapped { placed_at(&to, &from) } else { placed_at(&from, &to) };
        self.read.push(by);
        Ok(Some((usage, place)))
    }

    /// A NEXT_ASSEMBLY_USAGE_OCCURRENCE: a product in another one.
    fn usage(
        &mut self,
        file: &File<'_>,
        number: u64,
        placements: &HashMap<u64, (u64, Matrix4<f64>)>,
    ) -> Got<()> {
        let usage = entity(file, number)?;
        let args = usage.args();
        let (whole, part) = (entity(file, args.reference(3)?)?, entity(file, args.reference(4)?)?);
        let (whole, part) = (self.product(file, &whole), self.product(file, &part));
        let (name, label) = called_occurrence(file, &args);
        let place = match placements.get(&number) {
            Some((by, place)) => {
                self.read.push(*by);
                *place
            }
            None => Matrix4::identity(),
        };
        self.nodes[whole].children.push(Child { number, node: part, name, label, place, color: None });
        self.read.push(number);
        Ok(())
    }

    /// The occurrence whose shape, representation of it, or place something is.
    pub(crate) fn occurrence(&self, number: u64) -> Option<u64> {
        self.of_occurrences.get(&number).copied()
    }

    /// Representations that no product has.
    fn lone(&mut self, file: &File<'_>, sources: &Sources, related: &BTreeMap<u64, Vec<u64>>) {
        for &number in &sources.properties {
            if let Ok(of) = entity(file, number).and_then(|property| property.args().reference(1)) {
                self.aside.insert(of);
            }
        }
        for &number in &sources.representations {
            if self.of_representation.contains_key(&number) || self.aside.contains(&number) {
                continue;
            }
            let Ok(found) = entity(file, number) else { continue };
            let Ok(args) = representation(&found) else { continue };
            let name = args.name(0);
            self.nodes.push(Node { label: name.clone(), name, is_lone: true, ..Node::default() });
            self.add_representations(self.nodes.len() - 1, number, related);
        }
    }

    /// MAPPED_ITEMs among the items of representations: what is mapped is shown there, unless an occurrence says so already.
    fn mapped(&mut self, file: &File<'_>, contexts: &mut Contexts) {
        for node in 0..self.nodes.len() {
            let known: HashSet<usize> = self.nodes[node].children.iter().map(|child| child.node).collect();
            for number in self.nodes[node].representations.clone() {
                let Ok(found) = entity(file, number) else { continue };
                let items = representation(&found).and_then(|args| args.references(1)).unwrap_or_default();
                for item in
                    items.into_iter().filter(|item| super::entity::kind(file, *item) == b"MAPPED_ITEM")
                {
                    match self.mapped_item(file, item, number, contexts) {
                        Ok((of, _)) if of == node || known.contains(&of) => self.read.push(item),
                        Ok((of, place)) => {
                            let (name, label) = (self.nodes[of].name.clone(), self.nodes[of].label.clone());
                            self.nodes[node].children.push(Child {
                                number: item,
                                node: of,
                                name,
                                label,
                                place,
                                color: None,
                            });
                            self.read.push(item);
                        }
                        Err(problem) => self.problems.push(problem),
                    }
                }
            }
        }
    }

    fn mapped_item(
        &mut self,
        file: &File<'_>,
        number: u64,
        within: u64,
        contexts: &mut Contexts,
    ) -> Got<(usize, Matrix4<f64>)> {
        let item = entity(file, number)?;
        let map = entity(file, item.args().reference(1)?)?;
        let args = map.of("REPRESENTATION_MAP")?;
        let of = args.reference(1)?;
        let origin = Space { file, units: units(file, of, contexts)? }.frame(args.reference(0)?)?;
        let target =
            Space { file, units: units(file, within, contexts)? }.frame(item.args().reference(2)?)?;
        let node = self.of_representation.get(&of).copied();
        let node =
            node.ok_or_else(|| Problem::new(of, "it is mapped, but is no representation of a shape"))?;
        self.read.push(map.number);
        Ok((node, placed_at(&origin, &target)))
    }

    /// Takes out what would put a product into itself, however far down.
    fn untie(&mut self) {
        // 0: not seen; 1: on the way down; 2: done.
        let mut state = vec![0_u8; self.nodes.len()];
        for root in 0..self.nodes.len() {
            let mut path = vec![(root, 0)];
            if state[root] == 0 {
                state[root] = 1;
            } else {
                continue;
            }
            while let Some((node, next)) = path.pop() {
                let Some(child) = self.nodes[node].children.get(next) else {
                    state[node] = 2;
                    continue;
                };
                let (of, number) = (child.node, child.number);
                if state[of] == 1 {
                    self.problems.push(Problem::new(number, "it puts a product into itself"));
                    self.nodes[node].children.remove(next);
                    path.push((node, next));
                    continue;
                }
                path.push((node, next + 1));
                if state[of] == 0 {
                    state[of] = 1;
                    path.push((of, 0));
                }
            }
        }
    }
}

/// Name and label of a product: its name, else its number. Files that were written here have the name in the number's place, and
/// the label in that of the name.
fn called(file: &File<'_>, args: &Args<'_, '_>) -> (String, String) {
    let (id, name) = (args.name(0), args.name(1));
    if name.is_empty() {
        return (id.clone(), id);
    }
    if file.header.system == crate::SYSTEM && !id.is_empty() { (id, name) } else { (name.clone(), name) }
}

/// The same of an occurrence, whose number is nothing that anybody calls it.
fn called_occurrence(file: &File<'_>, args: &Args<'_, '_>) -> (String, String) {
    let name = args.name(1);
    if file.header.system == crate::SYSTEM { called(file, args) } else { (name.clone(), name) }
}

/// The units of a representation.
pub(crate) fn units(file: &File<'_>, number: u64, contexts: &mut Contexts) -> Got<super::place::Units> {
    let found = entity(file, number)?;
    match representation(&found)?.values.get(2) {
        Some(Value::Reference(context)) => contexts.units(file, *context),
        _ => Err(Problem::new(number, "a representation without a context, so without units")),
    }
}

/// The map that brings one frame to another.
fn placed_at(from: &Frame, to: &Frame) -> Matrix4<f64> {
    if from == to {
        return Matrix4::identity();
    }
    let matrix = |frame: &Frame| {
        let mut matrix = Matrix4::identity();
        for (k, axis) in [frame.x, frame.y(), frame.z, frame.origin.coords].iter().enumerate() {
            matrix.fixed_view_mut::<3, 1>(0, k).copy_from(axis);
        }
        matrix
    };
    let start = Frame {
        origin: loftsman_kernel::Point::origin(),
        x: nalgebra::Vector3::x(),
        z: nalgebra::Vector3::z(),
    };
    if *from == start {
        return matrix(to);
    }
    // The inverse of a turn and a shift.
    let turn = matrix(from).fixed_view::<3, 3>(0, 0).transpose();
    let mut back = Matrix4::identity();
    back.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
    back.fixed_view_mut::<3, 1>(0, 3).copy_from(&(-(turn * from.origin.coords)));
    matrix(to) * back
}
