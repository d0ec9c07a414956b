//! What belongs to the vertices of a mesh's primitives: layers, and what morph targets add.

use std::collections::{BTreeMap, HashMap};

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::{Layer, NONE};
use loftsman_kernel::plugin::{Fate, FormatError, ReadReport};

use super::file::File;
use super::mesh::{Attribute, Builder, Part};

impl Builder {
    /// What each morph target adds to each point.
    pub(super) fn targets(
        &self,
        file: &File<'_>,
        path: &str,
        count: usize,
    ) -> Result<Vec<Vec<Vector>>, FormatError> {
        let mut targets = Vec::new();
        for k in 0..count {
            let user = format!("{path}: morph target {k}");
            file.take(&user, self.points.len(), size_of::<Vector>())?;
            let mut moves = vec![Vector::zeros(); self.points.len()];
            for part in &self.parts {
                let Some(&Some(accessor)) = part.targets.get(k) else { continue };
                let block = &self.blocks[part.block];
                let values = attribute::<3>(file, accessor, (block.count, 3), 0.0, &user)?;
                let Some(values) = values else {
                    return Err(file.fail(user, "it has numbers that are not finite"));
                };
                for (slot, value) in moves[block.first..].iter_mut().zip(values) {
                    *slot = Vector::from(value);
                }
            }
            targets.push(moves);
        }
        Ok(targets)
    }

    /// A layer: by points where every vertex has one value, else by corners.
    pub(super) fn layer<const N: usize, T: Clone>(
        &self,
        file: &File<'_>,
        path: &str,
        attribute_of: Attribute,
        fill: f64,
        report: &mut ReadReport,
        value: impl Fn([f64; N]) -> T,
    ) -> Result<Layer<T>, FormatError> {
        let user = format!("{path}: {attribute_of:?}");
        // Colours may lack alpha, all else has all its components.
        let least = if attribute_of == Attribute::Color { 3 } else { N };
        // The values of each accessor, read once; `None` where they are not finite.
        let mut read: BTreeMap<(usize, usize), Option<Vec<T>>> = BTreeMap::new();
        let mut broken = 0;
        for part in &self.parts {
            let Some(&accessor) = part.layers.get(&attribute_of) else { continue };
            let count = self.blocks[part.block].count;
            if let std::collections::btree_map::Entry::Vacant(slot) = read.entry((part.block, accessor)) {
                let values = attribute::<N>(file, accessor, (count, least), fill, &user)?;
                broken += usize::from(values.is_none());
                slot.insert(values.map(|v| v.into_iter().map(&value).collect()));
            }
        }
        if broken > 0 {
            let reason = format!("attribute with numbers that are not finite ({attribute_of:?})");
            report.count_many(Fate::LeftOut, &reason, broken);
        }
        let of = |part: &Part| {
            let accessor = part.layers.get(&attribute_of)?;
            let key = (part.block, *accessor);
            read.get(&key)?.as_ref().map(|values| (key, values))
        };
        if self.parts.iter().all(|p| of(p).is_none()) {
            return Ok(Layer::none());
        }
        let mut by_block: Vec<Option<(usize, usize)>> = vec![None; self.blocks.len()];
        let one_a_point = self.parts.iter().all(|part| match (of(part), by_block[part.block]) {
            (None, _) => false,
            (Some((key, _)), Some(known)) => key == known,
            (Some((key, _)), None) => {
                by_block[part.block] = Some(key);
                true
            }
        });
        if one_a_point {
            let mut values = Vec::with_capacity(self.points.len());
            for key in by_block.into_iter().flatten() {
                values.extend(read.remove(&key).flatten().unwrap_or_default());
            }
            return Ok(Layer::per_point(values));
        }
        // Values in the order in which corners use them first, each once: unused ones are of no use.
        let (mut values, mut corners) = (Vec::new(), vec![NONE; self.corners.len()]);
        let mut places: HashMap<((usize, usize), u32), u32> = HashMap::new();
        let mut at_lines = 0;
        for part in &self.parts {
            let Some((key, list)) = of(part) else { continue };
            at_lines += usize::from(part.has_lines);
            let first = self.blocks[part.block].first as u32;
            for corner in part.corners.clone() {
                let vertex = self.corners[corner] - first;
                corners[corner] = *places.entry((key, vertex)).or_insert_with(|| {
                    values.push(list[vertex as usize].clone());
                    values.len() as u32 - 1
                });
            }
        }
        if at_lines > 0 {
            let reason = format!("attribute of lines whose faces differ in it ({attribute_of:?})");
            report.count_many(Fate::LeftOut, &reason, at_lines);
        }
        Ok(Layer::per_corner(values, corners))
    }
}

/// The values of an attribute of `count` vertices, with `least` components at least; `None` where some are not finite.
fn attribute<const N: usize>(
    file: &File<'_>,
    accessor: usize,
    (count, least): (usize, usize),
    fill: f64,
    user: &str,
) -> Result<Option<Vec<[f64; N]>>, FormatError> {
    let elements = file.elements(accessor, user)?;
    if elements.count != count {
        let problem = format!(
            "{} elements for {count} vertices (used by {user}): there must be one each",
            elements.count
        );
        return Err(file.fail(format!("accessors[{accessor}]"), problem));
    }
    if !(least..=N).contains(&elements.components) {
        let found = elements.components;
        let problem = format!("elements of {found} numbers where {N} are needed (used by {user})");
        return Err(file.fail(format!("accessors[{accessor}]"), problem));
    }
    let elements = if N == 4 { elements.normalized() } else { elements };
    let values = file.vectors::<N>(&elements, fill, user)?;
    Ok(values.iter().flatten().all(|x| x.is_finite()).then_some(values))
}
