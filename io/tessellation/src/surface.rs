//! Surfaces as meshes: every patch cut into cells, until neighbours agree on their edges.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::parallel;
use loftsman_kernel::plugin::Fineness;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Result, Vector};

use crate::assemble::{BorderSide, assemble};
use crate::cell::Judge;
use crate::edge::Border;
use crate::fineness::{Frame, Target, over_budget};
use crate::patch::{Patch, Patches, project};
use crate::refine::{Budget, Cells};
use crate::topology::{Topology, poles};

/// How far an estimate of the triangles may be beyond the budget before the work is refused without being begun.
const BEYOND: f64 = 8.0;

/// The mesh of a surface, and the largest certified distance between the two (a length).
///
/// Borders are cut by their own data only, so that surfaces that share one fit.
pub(crate) fn mesh(surface: &Surface, fineness: &Fineness, budget: usize) -> Result<(Mesh, f64)> {
    let frame = Frame::of(surface.points())?;
    let patches = Patches::new(surface, &frame);
    let mut topology = Topology::new(surface, &patches);
    let [nu, nv] = topology.counts;
    let count = nu * nv;
    let patch = |k: usize| patches.get(k / nv, k % nv);
    let starts = parallel::map(count, |k| Start::new(&patch(k)));
    let samples = starts.iter().flat_map(|start| start.around).map(|p| frame.centre + p * frame.size);
    let target = frame.target(fineness, samples)?;
    let over = |triangles: Option<f64>| Err(over_budget(fineness, triangles, ("triangles", 1.0), budget));
    // The indices of a mesh are 32 bits wide.
    let limit = budget.min(u32::MAX as usize / 4);
    let estimate: f64 = starts.iter().map(|start| start.estimate(&target)).sum();
    if estimate > BEYOND * limit as f64 {
        return over(Some(estimate));
    }
    let mut cells: Vec<Cells> = starts.into_iter().map(|start| start.cells).collect();
    for (k, cells) in cells.iter().enumerate() {
        topology.collapse(k, &cells.poles);
    }
    let borders = borders(surface, &topology, &cells);
    let mut edges = vec![Vec::new(); topology.edge_count()];
    for BorderSide { edge, border, .. } in &borders {
        edges[*edge] = border.fractions(target.chord * frame.size, target.angle);
    }
    first_cuts(&topology, &cells, &mut edges);

    let spent = Budget::new(limit);
    let mut stale = vec![true; count];
    let mut first = true;
    while stale.iter().any(|s| *s) {
        let shared = &topology;
        let worked = parallel::map_mut(&mut cells, Judge::default, |judge, k, cells| {
            if !stale[k] {
                return true;
            }
            let patch = patch(k);
            for side in 0..4 {
                let edge = shared.edge(k, side);
                for &at in &edges[edge] {
                    cells.tree.cut_side(&patch, side, at);
                }
                if first && shared.is_border(edge) && !cells.poles.0[side] {
                    cells.tree.fix(side);
                }
            }
            cells.refine(&patch, &target, judge, &spent)
        });
        if worked.contains(&false) {
            return over(None);
        }
        first = false;
        merge(&topology, &cells, &mut edges, &mut stale);
    }
    let error = cells.iter().map(Cells::error).fold(0.0, f64::max) * frame.size;
    if error > target.chord * frame.size * (1.0 + 1e-9) {
        return Err(Error::Invalid(format!(
            "the surface is too singular to be tessellated: {error:e} is the nearest that could be certified"
        )));
    }
    let mesh = assemble(surface, &frame, &patches, &mut topology, &cells, &edges, &borders)?;
    Ok((mesh, error))
}

/// The edges that only one patch has.
fn borders(surface: &Surface, topology: &Topology, cells: &[Cells]) -> Vec<BorderSide> {
    let own = Patches::new(surface, &Frame::absolute());
    let mut borders = Vec::new();
    for (k, cells) in cells.iter().enumerate() {
        let sides = (0..4).filter(|&side| topology.is_border(topology.edge(k, side)) && !cells.poles.0[side]);
        for side in sides {
            let patch = own.get(k / topology.counts[1], k % topology.counts[1]);
            let (edge, border) = (topology.edge(k, side), Border::new(patch.side(side)));
            borders.push(BorderSide { edge, patch: k, side, border });
        }
    }
    borders
}

/// A closed direction must have three cells at least, or triangles of its two halves would have the same corners.
fn first_cuts(topology: &Topology, cells: &[Cells], edges: &mut [Vec<f64>]) {
    for direction in 0..2 {
        let cuts: &[f64] = match topology.counts[direction] {
            _ if !topology.closed[direction] => continue,
            1 => &[0.25, 0.5, 0.75],
            2 => &[0.5],
            _ => continue,
        };
        for k in 0..cells.len() {
            for side in [direction, direction + 2] {
                let edge = &mut edges[topology.edge(k, side)];
                edge.extend_from_slice(cuts);
                sort(edge);
            }
        }
    }
}

/// Gathers from the patches where each edge is cut; those that lack a cut are stale.
fn merge(topology: &Topology, cells: &[Cells], edges: &mut [Vec<f64>], stale: &mut [bool]) {
    let mut lengths = vec![[0_usize; 4]; cells.len()];
    for (k, cells) in cells.iter().enumerate() {
        for side in (0..4).filter(|&side| stale[k] && !cells.poles.0[side]) {
            let found = cells.fractions(side);
            let edge = &mut edges[topology.edge(k, side)];
            if found != *edge {
                edge.extend(found);
                sort(edge);
            }
        }
    }
    for (k, cells) in cells.iter().enumerate() {
        for side in (0..4).filter(|&side| !cells.poles.0[side]) {
            lengths[k][side] = cells.tree.side(side).len() - 2;
        }
        // A side has no vertex that its edge has not, so that equal numbers are equal vertices.
        stale[k] = (0..4)
            .any(|side| !cells.poles.0[side] && lengths[k][side] != edges[topology.edge(k, side)].len());
    }
}

fn sort(fractions: &mut Vec<f64>) {
    fractions.sort_unstable_by(f64::total_cmp);
    fractions.dedup();
}

/// A patch as one cell, and what decides how fine it must become.
struct Start {
    cells: Cells,
    /// The corners of the box around some points of the patch, which is never larger than the patch's own.
    around: [Vector; 2],
    /// How much the middle bends across its tangent plane, by direction.
    bends: [f64; 2],
}

impl Start {
    fn new(patch: &Patch) -> Self {
        let (p, q) = (patch.rows, patch.columns);
        let corners = [0, q - 1, (p - 1) * q, p * q - 1].map(|k| project(&patch.net[k]));
        let middle = [0.5, 0.5];
        let jet = patch.jet(middle);
        let inside = [jet.point, patch.point([0.5, 0.0]), patch.point([0.0, 0.5])];
        let first = corners[0];
        let around =
            corners.iter().chain(&inside).fold([first, first], |[low, high], p| [low.inf(p), high.sup(p)]);
        let bends = jet.u.cross(&jet.v).try_normalize(0.0).map_or([0.0; 2], |normal| {
            let [uu, _, vv] = patch.second(middle);
            [uu, vv].map(|bend| normal.dot(&bend).abs())
        });
        Self { cells: Cells::new(patch, poles(patch)), around, bends }
    }

    /// About how many triangles the patch will need.
    fn estimate(&self, target: &Target) -> f64 {
        let [u, v] = self.bends.map(|bend| (bend / (4.0 * target.chord)).sqrt().max(1.0));
        2.0 * u * v
    }
}
