//! Surfaces as meshes: every patch cut into cells, until neighbours agree on their edges.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::parallel;
use loftsman_kernel::plugin::{Chord, Fineness, MovingMesh, Tessellated};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point, Result, Vector};

use crate::assemble::{BorderSide, assemble};
use crate::edge::Border;
use crate::fineness::{Target, over_budget, targets};
use crate::patch::{Patch, project};
use crate::refine::{self, Budget, Cells, PerState, Room};
use crate::state::State;
use crate::topology::{Poles, Topology, poles};
use crate::weights;

/// How far an estimate of the triangles may be beyond the budget before the work is refused without being begun.
const BEYOND: f64 = 3.0;

/// The mesh of a surface, the chord asked for, and the largest certified distance between the two (lengths).
///
/// Borders are cut by their own data only, so that surfaces that share one fit.
pub(crate) fn mesh(surface: &Surface, fineness: &Fineness, budget: usize) -> Result<Tessellated> {
    let Meshes { mesh, tolerance, error, .. } = Meshes::of(std::slice::from_ref(surface), fineness, budget)?;
    Ok(Tessellated { mesh, tolerance, error })
}

/// All states of a surface, cut alike. Those that are one point have no say.
pub(crate) fn moving(surfaces: &[Surface], fineness: &Fineness, budget: usize) -> Result<MovingMesh> {
    let Meshes { mut mesh, others, live, tolerance, error } = Meshes::of(surfaces, fineness, budget)?;
    let mut moved = std::iter::once(mesh.points().to_vec()).chain(others);
    let still = |surface: &Surface| vec![surface.points()[0]; mesh.points().len()];
    let points = surfaces.iter().zip(&live).map(|(surface, &live)| {
        let moved = if live { moved.next() } else { None };
        moved.unwrap_or_else(|| still(surface))
    });
    let states: Vec<Vec<Point>> = points.collect();
    mesh.points_mut().copy_from_slice(&states[0]);
    Ok(MovingMesh { mesh, states, tolerance, error })
}

/// The mesh of a surface in the first of its states that is more than a point.
struct Meshes {
    mesh: Mesh,
    /// The points in the further states of that kind.
    others: Vec<Vec<Point>>,
    /// Which states are.
    live: Vec<bool>,
    /// The largest chord asked for, and the largest certified distance, as lengths.
    tolerance: f64,
    error: f64,
}

impl Meshes {
    fn of(surfaces: &[Surface], fineness: &Fineness, budget: usize) -> Result<Self> {
        let Some(surface) = surfaces.first() else {
            return Err(Error::Invalid("a surface without states cannot be tessellated".into()));
        };
        let alike =
            |s: &Surface| (s.u(), s.v(), s.weights()) == (surface.u(), surface.v(), surface.weights());
        if !surfaces.iter().all(alike) {
            let problem = "the states of a moving surface have other knots or weights: they must be the same";
            return Err(Error::Invalid(problem.into()));
        }
        let mut all = Vec::with_capacity(surfaces.len());
        for surface in surfaces {
            all.push(match State::new(surface) {
                Ok(state) => Some(state),
                Err(Error::NoExtent(_)) if surfaces.len() > 1 => None,
                Err(error) => return Err(error),
            });
        }
        let states: Vec<&State<'_>> = all.iter().flatten().collect();
        if states.is_empty() {
            return Err(Error::NoExtent("all control vertices coincide in every state".into()));
        }
        let mut topology = Topology::new(surface, states.iter().map(|state| &state.patches));
        let [nu, nv] = topology.counts;
        let count = nu * nv;
        let patches = |k: usize| -> PerState<Patch> {
            states.iter().map(|state| state.patches.get(k / nv, k % nv)).collect()
        };
        let rational = surface.weights().is_some();
        let relative = matches!(fineness.chord, Chord::Relative(_));
        let starts = parallel::map(count, |k| Start::new(patches(k), rational, relative));
        let starts: Vec<Start> = starts.into_iter().collect::<Result<_>>()?;
        let samples = states.iter().enumerate().map(|(s, state)| {
            let points = starts.iter().filter_map(|start| start.around.get(s)).flatten();
            (&state.frame, points.map(|p| state.frame.centre + p * state.frame.size).collect())
        });
        let (targets, tolerance) = targets(samples, fineness)?;
        let over = |triangles: Option<f64>| Err(over_budget(fineness, triangles, ("triangles", 1.0), budget));
        // The indices of a mesh are 32 bits wide.
        let limit = (budget / surfaces.len()).clamp(1, u32::MAX as usize / 4);
        let estimate = |s: usize| starts.iter().map(|start| start.estimate(s, &targets[s])).sum::<f64>();
        let estimate = (0..states.len()).map(estimate).fold(0.0, f64::max);
        if estimate > BEYOND * limit as f64 {
            return over(Some(estimate));
        }
        let mut cells: Vec<Cells> = starts.into_iter().map(|start| start.cells).collect();
        for (k, cells) in cells.iter().enumerate() {
            topology.collapse(k, &cells.poles);
        }
        let borders = borders(&states, &topology, &cells);
        let mut edges = vec![Vec::new(); topology.edge_count()];
        for BorderSide { edge, states: borders, .. } in &borders {
            let fractions = borders
                .iter()
                .zip(&targets)
                .flat_map(|(border, target)| border.fractions(target.chord * target.size, target.angle));
            edges[*edge] = fractions.collect();
            sort(&mut edges[*edge]);
        }
        first_cuts(&topology, &cells, &mut edges);

        let spent = Budget::new(limit);
        let mut stale = vec![true; count];
        let mut first = true;
        while stale.iter().any(|s| *s) {
            let shared = &topology;
            let room = || Room::new(states.len() > 1);
            let worked = parallel::map_mut(&mut cells, room, |room, k, cells| {
                if !stale[k] {
                    return true;
                }
                for side in 0..4 {
                    let edge = shared.edge(k, side);
                    cells.cut_side(side, &edges[edge]);
                    if first && shared.is_border(edge) && !cells.poles.0[side] {
                        cells.fix(side);
                    }
                }
                cells.refine(&targets, room, &spent)
            });
            if worked.contains(&false) {
                return over(None);
            }
            first = false;
            merge(&topology, &cells, &mut edges, &mut stale);
        }
        cells.iter_mut().for_each(Cells::finish);
        let worst = cells.iter().map(Cells::error).fold(Default::default(), refine::Error::max);
        if worst.share > 1.0 + 1e-9 {
            return Err(Error::Invalid(format!(
                "the surface is too singular to be tessellated: {:e} is the nearest that could be certified",
                worst.length
            )));
        }
        let (mesh, others) = assemble(surface, &states, &mut topology, cells, &edges, &borders)?;
        let live = all.iter().map(Option::is_some).collect();
        Ok(Self { mesh, others, live, tolerance, error: worst.length })
    }
}

/// The edges that only one patch has.
fn borders(states: &[&State<'_>], topology: &Topology, cells: &[Cells]) -> Vec<BorderSide> {
    let mut borders = Vec::new();
    for (k, cells) in cells.iter().enumerate() {
        let sides = (0..4).filter(|&side| topology.is_border(topology.edge(k, side)) && !cells.poles.0[side]);
        for side in sides {
            let edge = topology.edge(k, side);
            let (i, j) = (k / topology.counts[1], k % topology.counts[1]);
            let of = |state: &&State<'_>| Border::new(state.own.get(i, j).side(side).copied().collect());
            borders.push(BorderSide { edge, patch: k, side, states: states.iter().map(of).collect() });
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
    for (k, cells) in cells.iter().enumerate().filter(|(k, _)| stale[*k]) {
        for (side, found) in cells.cuts() {
            let edge = &mut edges[topology.edge(k, side)];
            if found != edge {
                edge.extend_from_slice(found);
                sort(edge);
            }
        }
    }
    for (k, cells) in cells.iter().enumerate() {
        // A side has no vertex that its edge has not, so that equal numbers are equal vertices.
        stale[k] = cells.cuts().any(|(side, found)| found.len() != edges[topology.edge(k, side)].len());
    }
}

fn sort(fractions: &mut Vec<f64>) {
    fractions.sort_unstable_by(f64::total_cmp);
    fractions.dedup();
}

/// A patch as one cell, and what decides how fine it must become.
struct Start {
    cells: Cells,
    /// Where the tolerance is relative, the corners of the box around some points of the patch in each state, which is never
    /// larger than the patch's own.
    around: PerState<[Vector; 2]>,
    /// How much the middle bends across its tangent plane in each state, by direction.
    bends: PerState<[f64; 2]>,
}

impl Start {
    fn new(patches: PerState<Patch>, rational: bool, relative: bool) -> Result<Self> {
        if let Some(patch) = patches.first().filter(|_| rational) {
            weights::resolved_net(&patch.net, patch.columns)?;
        }
        // A side is one point where it is in all states.
        let in_all = patches.iter().map(poles).reduce(|a, b| Poles([0, 1, 2, 3].map(|k| a.0[k] && b.0[k])));
        Ok(Self {
            around: patches.iter().filter(|_| relative).map(around).collect(),
            bends: patches.iter().map(bends).collect(),
            cells: Cells::new(patches, in_all.unwrap_or_default()),
        })
    }

    /// About how many triangles the patch will need in a state.
    fn estimate(&self, state: usize, target: &Target) -> f64 {
        let [u, v] = self.bends[state].map(|bend| (bend / (4.0 * target.chord)).sqrt().max(1.0));
        2.0 * u * v
    }
}

fn around(patch: &Patch) -> [Vector; 2] {
    let (p, q) = (patch.rows, patch.columns);
    let corners = [0, q - 1, (p - 1) * q, p * q - 1].map(|k| project(&patch.net[k]));
    let inside = [patch.point([0.5, 0.5]), patch.point([0.5, 0.0]), patch.point([0.0, 0.5])];
    let first = corners[0];
    corners.iter().chain(&inside).fold([first, first], |[low, high], p| [low.inf(p), high.sup(p)])
}

fn bends(patch: &Patch) -> [f64; 2] {
    let (jet, [uu, _, vv]) = patch.second([0.5, 0.5]);
    let normal = jet.u.cross(&jet.v).try_normalize(0.0).unwrap_or_default();
    [uu, vv].map(|bend| normal.dot(&bend).abs())
}
