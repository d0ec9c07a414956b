//! Which entities others are made of: what is left is what the file shows.

use std::collections::{HashMap, HashSet};

use super::curve::{is_chain, is_curve};
use super::entity::{Entity, Reader};
use super::surface::is_surface;

/// Whether a group (402) of a form holds things that belong together.
pub(crate) fn is_group(kind: u32, form: i32) -> bool {
    kind == 402 && matches!(form, 1 | 7 | 14 | 15)
}

/// Whether entities of a type show something themselves.
pub(crate) fn is_shown(kind: u32, form: i32) -> bool {
    is_curve(kind, form)
        || is_surface(kind)
        || is_group(kind, form)
        || (kind == 106 && (is_chain(form) || matches!(form, 1..=3)))
        || matches!(kind, 116 | 142 | 143 | 144 | 184 | 186 | 408 | 430 | 510 | 514)
}

/// Whether an entity owns others, so that these are shown with it.
fn owns(kind: u32, form: i32) -> bool {
    is_group(kind, form)
        || matches!(
            kind,
            102 | 108 | 118 | 120 | 122 | 130 | 140
                ..=144 | 184 | 186 | 190 | 192 | 194 | 196 | 198 | 308 | 408 | 430 | 504 | 508 | 510 | 514
        )
}

/// The places of what an entity is made of; what is malformed in it shows when it is read.
fn owned(entity: &Entity<'_, '_>) -> Vec<usize> {
    let mut all = Vec::new();
    let mut put = |index: usize| all.extend(entity.pointed(index).ok().flatten());
    let count = |index: usize, each: usize| entity.count(index, each).unwrap_or(0);
    match entity.entry.kind {
        102 | 402 => (0..count(1, 1)).for_each(|k| put(2 + k)),
        108 => put(5),
        118 | 120 => [1, 2].into_iter().for_each(put),
        122 | 130 | 408 | 430 => put(1),
        140 => put(5),
        141 => {
            put(3);
            let mut at = 5;
            for _ in 0..count(4, 3) {
                put(at);
                let curves = count(at + 2, 1);
                (0..curves).for_each(|k| put(at + 3 + k));
                at += 3 + curves;
            }
        }
        142 => [2, 3, 4].into_iter().for_each(put),
        143 => {
            put(2);
            (0..count(3, 1)).for_each(|k| put(4 + k));
        }
        144 => {
            [1, 4].into_iter().for_each(&mut put);
            (0..count(3, 1)).for_each(|k| put(5 + k));
        }
        184 => (0..count(1, 2)).for_each(|k| put(2 + k)),
        186 => {
            put(1);
            (0..count(3, 2)).for_each(|k| put(4 + 2 * k));
        }
        190 | 192 | 194 | 196 | 198 => (1..=5).filter(|k| pointer_of(entity.entry.kind, *k)).for_each(put),
        308 => (0..count(3, 1)).for_each(|k| put(4 + k)),
        504 => (0..count(1, 5)).for_each(|k| [2, 3, 5].into_iter().for_each(|of| put(of + 5 * k))),
        508 => {
            let mut at = 2;
            for _ in 0..count(1, 5) {
                put(at + 1);
                let curves = count(at + 4, 2);
                (0..curves).for_each(|k| put(at + 6 + 2 * k));
                at += 5 + 2 * curves;
            }
        }
        510 => {
            put(1);
            (0..count(2, 1)).for_each(|k| put(4 + k));
        }
        514 => (0..count(1, 2)).for_each(|k| put(2 + 2 * k)),
        _ => {}
    }
    all
}

/// Which parameters of the elementary surfaces are numbers of entities.
fn pointer_of(kind: u32, index: usize) -> bool {
    match kind {
        190 => index <= 3,
        192 => matches!(index, 1 | 2 | 4),
        196 => matches!(index, 1 | 3 | 4),
        _ => matches!(index, 1 | 2 | 5),
    }
}

/// Where the parameters of an entity end, behind which stands what it is associated with and its properties.
pub(crate) fn end(entity: &Entity<'_, '_>) -> Option<usize> {
    let count = |index: usize| entity.count(index, 1).ok();
    Some(match entity.entry.kind {
        100 => 7,
        102 | 402 => 1 + count(1)?,
        104 => 11,
        106 => match entity.whole(1).ok()? {
            1 => 3 + 2 * count(2)?,
            2 => 2 + 3 * count(2)?,
            _ => 2 + 6 * count(2)?,
        },
        108 => 9,
        110 => 6,
        112 => {
            let pieces = count(4)?;
            5 + pieces + 12 * pieces + 12
        }
        114 => {
            let (m, n) = (count(3)?, count(4)?);
            6 + m + n + 48 * (m + 1) * (n + 1)
        }
        116 => 4,
        118 => 4,
        120 => 4,
        122 => 4,
        126 => super::spline::curve_end(entity)?,
        128 => super::spline::surface_end(entity)?,
        130 => 14,
        140 => 5,
        142 => 5,
        143 => 3 + count(3)?,
        144 => 4 + count(3)?,
        184 => 1 + 2 * count(1)?,
        186 => 3 + 2 * count(3)?,
        190 => 2 + usize::from(entity.entry.form == 1),
        192 => 3 + usize::from(entity.entry.form == 1),
        194 => 4 + usize::from(entity.entry.form == 1),
        196 => 2 + 2 * usize::from(entity.entry.form == 1),
        198 => 4 + usize::from(entity.entry.form == 1),
        308 => 3 + count(3)?,
        408 => 5,
        430 => 1,
        510 => 3 + count(2)?,
        514 => 1 + 2 * count(1)?,
        _ => return None,
    })
}

/// What is shown of a file.
pub(crate) struct Tree {
    /// The entities that nothing owns and that show something, in their order.
    pub(crate) roots: Vec<usize>,
    /// How often each subfigure (308) is shown.
    pub(crate) uses: Vec<u32>,
    /// Groups and subfigures, each with one that it would be in itself: in a circle.
    pub(crate) circles: HashSet<(usize, usize)>,
    /// Whether each is a part of another one that is neither a group nor a subfigure.
    pub(crate) part: Vec<bool>,
}

impl Tree {
    /// Who owns whom. `O(parameters of those that own)`.
    pub(crate) fn new(reader: &Reader<'_, '_>) -> Self {
        let entries = reader.file.entries();
        let (mut uses, mut all) = (vec![0; entries.len()], vec![false; entries.len()]);
        let mut part = all.clone();
        let mut holds: HashMap<usize, Vec<usize>> = HashMap::new();
        for (place, entry) in entries.iter().enumerate().filter(|(_, entry)| owns(entry.kind, entry.form)) {
            let Ok(entity) = reader.glance(place) else { continue };
            let inner = owned(&entity);
            if matches!(entry.kind, 184 | 308 | 402 | 408 | 430) {
                holds.insert(place, inner.clone());
            }
            for of in inner {
                // What names itself would be shown by nobody.
                if of != place {
                    all[of] = true;
                    part[of] |= !matches!(entry.kind, 184 | 308 | 402 | 408 | 430);
                }
                if entry.kind == 408 {
                    uses[of] += 1;
                }
            }
        }
        let roots = entries.iter().enumerate();
        // Curves in parameters, definitions and annotations are none, wherever they are.
        let roots = roots
            .filter(|(_, entry)| is_shown(entry.kind, entry.form) && !matches!(entry.purpose, 1 | 2 | 5));
        let roots = roots.map(|(place, _)| place).filter(|&place| !all[place]).collect();
        Self { roots, uses, circles: circles(entries.len(), &holds), part }
    }
}

/// What closes a circle in what holds what, found on the way down from each. `O(what is held)`.
fn circles(count: usize, holds: &HashMap<usize, Vec<usize>>) -> HashSet<(usize, usize)> {
    let mut found = HashSet::new();
    // 0: not seen; 1: on the way down; 2: done.
    let mut state = vec![0_u8; count];
    for root in 0..count {
        if state[root] != 0 || !holds.contains_key(&root) {
            continue;
        }
        state[root] = 1;
        let mut path = vec![(root, 0)];
        while let Some((at, next)) = path.pop() {
            let Some(&inner) = holds.get(&at).and_then(|all| all.get(next)) else {
                state[at] = 2;
                continue;
            };
            path.push((at, next + 1));
            match state[inner] {
                0 => {
                    state[inner] = 1;
                    path.push((inner, 0));
                }
                1 => drop(found.insert((at, inner))),
                _ => {}
            }
        }
    }
    found
}
