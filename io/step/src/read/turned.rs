//! Bounds that run the wrong way round.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::Vector;
use loftsman_kernel::brep::{Shell, Use};
use loftsman_kernel::spline::curvature::Normal;

use super::brep::Builder;

/// Where no plane says which way a bound has to run, at most one of so many edges of what hangs together may run the wrong way: of more nobody can say which.
const FEW: usize = 4;
/// Points that are off a plane by no more than this part of their extent are in it.
const FLAT: f64 = 1e-7;
/// Places on each span of an edge, by which the area inside a bound is told.
const EACH: usize = 8;

impl Builder<'_, '_> {
    /// Whether a shell has each edge twice, once in each direction.
    pub(super) fn closes(&self, shell: &Shell) -> bool {
        let mut turns: BTreeMap<usize, [usize; 2]> = BTreeMap::new();
        for one in shell.faces.iter().flat_map(|&face| &self.parts.faces[face].loops).flatten() {
            turns.entry(one.edge).or_default()[usize::from(one.reversed)] += 1;
        }
        turns.values().all(|turns| *turns == [1, 1])
    }

    /// Turns those bounds round that run against what the others around them say, where the shell closes then and not without; says so. Programs
    /// write some of their bounds with the wrong flag, and read them the right way round.
    pub(super) fn turn_loops(&mut self, shell: &Shell, numbers: &[u64], reversed: bool) {
        if self.closes(shell) {
            return;
        }
        let Some(turned) = self.against(shell, numbers, reversed) else { return };
        for (&face, number) in shell.faces.iter().zip(numbers) {
            let loops = &mut self.parts.faces[face].loops;
            let (count, mut some) = (loops.len(), 0);
            for (_, chain) in loops.iter_mut().enumerate().filter(|(k, _)| turned.contains(&(face, *k))) {
                some += 1;
                chain.reverse();
                for one in chain {
                    one.reversed = !one.reversed;
                    // Of a seam each side has its own: they are found anew.
                    one.parameters = None;
                }
            }
            if some == count && count > 0 {
                self.notes.push(format!(
                    "#{number}: its bounds run against those of the faces around it: they are turned round"
                ));
            } else if some > 0 {
                self.notes.push(format!(
                    "#{number}: {some} of its {count} bounds run against those of the faces around it: turned round"
                ));
            }
        }
    }

    /// The bounds (face and place there) that have to be turned for each edge of a shell to be used once in each direction. Of all that hang together there are
    /// two choices: the outer bounds of planes run counterclockwise in one of them; where there are none, those of other faces do in the parameters that the file has; where
    /// it has none either, it is that which turns a few. `None` where no choice is enough, or it is not clear which ones are wrong.
    fn against(&self, shell: &Shell, numbers: &[u64], reversed: bool) -> Option<BTreeSet<(usize, usize)>> {
        let loops = |face: usize| self.parts.faces[face].loops.iter().enumerate();
        let bounds: Vec<(usize, usize)> =
            shell.faces.iter().flat_map(|&face| loops(face).map(move |(k, _)| (face, k))).collect();
        let edges = |bound: usize| &self.parts.faces[bounds[bound].0].loops[bounds[bound].1];
        let mut uses: BTreeMap<usize, Vec<(usize, bool)>> = BTreeMap::new();
        for bound in 0..bounds.len() {
            edges(bound).iter().for_each(|one| uses.entry(one.edge).or_default().push((bound, one.reversed)));
        }
        // What lies beside each, and whether one of the two has to be turned.
        let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); bounds.len()];
        for list in uses.values() {
            let [(a, one), (b, other)] = list[..] else { return None };
            beside[a].push((b, one == other));
            beside[b].push((a, one == other));
        }
        // Once for each face: a plate may have thousands of holes.
        let planes: BTreeMap<(usize, usize), bool> = shell
            .faces
            .iter()
            .filter_map(|&face| self.outer(face).map(|(bound, is_wrong)| ((face, bound), is_wrong)))
            .collect();
        let mut others: Option<BTreeMap<(usize, usize), bool>> = None;
        let mut found = BTreeSet::new();
        let mut turned: Vec<Option<bool>> = vec![None; bounds.len()];
        for first in 0..bounds.len() {
            if turned[first].is_some() {
                continue;
            }
            turned[first] = Some(false);
            let (mut open, mut together, mut counts) = (vec![first], Vec::new(), [0, 0]);
            while let Some(bound) = open.pop() {
                let own = turned[bound] == Some(true);
                together.push((bound, own));
                counts[usize::from(own)] += edges(bound).len();
                for &(other, against) in &beside[bound] {
                    match turned[other] {
                        None => {
                            turned[other] = Some(own != against);
                            open.push(other);
                        }
                        Some(said) if said != (own != against) => return None,
                        Some(_) => {}
                    }
                }
            }
            let said = |known: &BTreeMap<(usize, usize), bool>| -> Vec<bool> {
                let all = together.iter();
                all.filter_map(|&(bound, own)| Some(*known.get(&bounds[bound])? == own)).collect()
            };
            let mut all = said(&planes);
            if all.is_empty() {
                all = said(others.get_or_insert_with(|| self.others(shell, numbers, reversed)));
            }
            let wrong = match all.first() {
                Some(&first) if all.iter().all(|other| *other == first) => first,
                Some(_) => return None,
                None => {
                    let fewer = counts[1] < counts[0];
                    if counts[usize::from(fewer)] * FEW > counts[0] + counts[1] {
                        return None;
                    }
                    fewer
                }
            };
            found.extend(together.iter().filter(|one| one.1 == wrong).map(|one| bounds[one.0]));
        }
        Some(found)
    }

    /// The outer bounds of the faces of a shell by their parameter curves, and whether they run the wrong way round.
    fn others(&self, shell: &Shell, numbers: &[u64], reversed: bool) -> BTreeMap<(usize, usize), bool> {
        let faces = shell.faces.iter().zip(numbers);
        let outer = |(&face, &number)| {
            let (bound, is_wrong) = self.outer_in_parameters(face, number, reversed)?;
            Some(((face, bound), is_wrong))
        };
        faces.filter_map(outer).collect()
    }

    /// The outer bound of a plane, also of one that is a spline, and whether it runs clockwise about the normal of its face; `None` of another face.
    fn outer(&self, face: usize) -> Option<(usize, bool)> {
        let own = &self.parts.faces[face];
        let corner = (own.surface.u().domain().0, own.surface.v().domain().0);
        let Normal::Regular(normal) = own.surface.normal(corner.0, corner.1).ok()? else { return None };
        let first = own.surface.points().first()?;
        let (mut flat, mut size) = (0.0_f64, 0.0_f64);
        for p in own.surface.points() {
            let way = p - first;
            (flat, size) = (flat.max(way.dot(&normal).abs()), size.max(way.norm()));
        }
        if flat > FLAT * size {
            return None;
        }
        let areas: Vec<f64> =
            own.loops.iter().map(|chain| self.inside(chain, &normal)).collect::<Option<_>>()?;
        let (bound, area) = areas.into_iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        (area != 0.0 && area.is_finite()).then_some((bound, (area < 0.0) != own.reversed))
    }

    /// About twice the area inside a chain of edges, as seen against a direction.
    fn inside(&self, chain: &[Use], normal: &Vector) -> Option<f64> {
        let mut points = Vec::new();
        for one in chain {
            let edge = &self.parts.edges[one.edge];
            let spans = edge.curve.space().breakpoints().len();
            let count = EACH * spans;
            let (from, to) = if one.reversed { (edge.range.1, edge.range.0) } else { edge.range };
            for k in 0..count {
                points.push(edge.curve.point(from + (to - from) * (k as f64 / count as f64)).ok()?);
            }
        }
        let first = *points.first()?;
        let turned = points.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first)));
        Some(turned.sum::<Vector>().dot(normal))
    }
}
