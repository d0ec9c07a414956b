//! Surfaces as meshes: every patch cut into cells, until neighbours agree on their edges.

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::parallel;
use loftsman_kernel::plugin::{Beside, Chord, Fineness, MovingMesh, Tessellated};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point, Result, Vector};

use crate::assemble::{Assembled, assemble};
use crate::beside::{self, BorderSide, Taken};
use crate::edge::{Border, SHARE};
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
/// Borders are cut by their own data only, so that surfaces that share one fit; where one is another's as points only, by what is `beside`, too.
pub(crate) fn mesh(
    surface: &Surface,
    fineness: &Fineness,
    budget: usize,
    beside: Option<Beside<'_>>,
) -> Result<Tessellated> {
    let finer = beside.map_or(*fineness, |_| for_others(fineness));
    let Meshes { mesh, tolerance, error, .. } =
        Meshes::of(std::slice::from_ref(surface), &finer, budget, beside)?;
    let tolerance = if beside.is_some() { tolerance * (1.0 + SHARE) } else { tolerance };
    Ok(Tessellated { mesh, tolerance, error })
}

/// Where the border of a surface is cut that has others beside it.
pub(crate) fn border(surface: &Surface, fineness: &Fineness, budget: usize) -> Result<Vec<Point>> {
    let fineness = for_others(fineness);
    let states = States::of(std::slice::from_ref(surface))?;
    let Begun { borders, edges, .. } = Begun::of(&states.all(), surface, &fineness, (budget, 1))?;
    let mut points = Vec::new();
    for BorderSide { edge, states, .. } in &borders {
        let ends = [0.0, 1.0];
        let all = edges[*edge].iter().chain(&ends);
        points.extend(states.iter().flat_map(|border| all.clone().map(|&fraction| border.point(fraction))));
    }
    Ok(points)
}

/// The fineness of a surface whose triangles are divided along the border at points that are off their sides: by no more than the share of
/// the chord by which borders may be off theirs.
fn for_others(fineness: &Fineness) -> Fineness {
    let chord = match fineness.chord {
        Chord::Absolute(length) => Chord::Absolute(length / (1.0 + SHARE)),
        Chord::Relative(share) => Chord::Relative(share / (1.0 + SHARE)),
    };
    Fineness { chord, ..*fineness }
}

/// All states of a surface, cut alike. Those that are one point have no say.
pub(crate) fn moving(surfaces: &[Surface], fineness: &Fineness, budget: usize) -> Result<MovingMesh> {
    let Meshes { mut mesh, others, live, tolerance, error } = Meshes::of(surfaces, fineness, budget, None)?;
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

/// A surface in all its states; `None` for those that are one point.
struct States<'a>(Vec<Option<State<'a>>>);

impl<'a> States<'a> {
    fn of(surfaces: &'a [Surface]) -> Result<Self> {
        let mut all = Vec::with_capacity(surfaces.len());
        for surface in surfaces {
            all.push(match State::new(surface) {
                Ok(state) => Some(state),
                Err(Error::NoExtent(_)) if surfaces.len() > 1 => None,
                Err(error) => return Err(error),
            });
        }
        if all.iter().all(Option::is_none) {
            return Err(Error::NoExtent("all control vertices coincide in every state".into()));
        }
        Ok(Self(all))
    }

    fn all(&self) -> Vec<&State<'a>> {
        self.0.iter().flatten().collect()
    }
}

/// A surface of which every patch is one cell, and only its borders are cut.
struct Begun {
    topology: Topology,
    cells: Vec<Cells>,
    targets: Vec<Target>,
    /// The largest chord asked for, as a length.
    tolerance: f64,
    borders: Vec<BorderSide>,
    /// Where each edge is cut.
    edges: Vec<Vec<f64>>,
    /// How many triangles there may be.
    limit: usize,
}

impl Begun {
    /// The triangles of all `shares` states together are within the budget.
    fn of(
        states: &[&State<'_>],
        surface: &Surface,
        fineness: &Fineness,
        (budget, shares): (usize, usize),
    ) -> Result<Self> {
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
        // The indices of a mesh are 32 bits wide.
        let limit = (budget / shares).clamp(1, u32::MAX as usize / 4);
        let estimate = |s: usize| starts.iter().map(|start| start.estimate(s, &targets[s])).sum::<f64>();
        let estimate = (0..states.len()).map(estimate).fold(0.0, f64::max);
        if estimate > BEYOND * limit as f64 {
            return Err(over_budget(fineness, Some(estimate), ("triangles", 1.0), budget));
        }
        let cells: Vec<Cells> = starts.into_iter().map(|start| start.cells).collect();
        for (k, cells) in cells.iter().enumerate() {
            topology.collapse(k, &cells.poles);
        }
        let borders = borders(states, &topology, &cells);
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
        Ok(Self { topology, cells, targets, tolerance, borders, edges, limit })
    }
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
    fn of(
        surfaces: &[Surface],
        fineness: &Fineness,
        budget: usize,
        beside: Option<Beside<'_>>,
    ) -> Result<Self> {
        let Some(surface) = surfaces.first() else {
            return Err(Error::Invalid("a surface without states cannot be tessellated".into()));
        };
        let alike =
            |s: &Surface| (s.u(), s.v(), s.weights()) == (surface.u(), surface.v(), surface.weights());
        if !surfaces.iter().all(alike) {
            let problem = "the states of a moving surface have other knots or weights: they must be the same";
            return Err(Error::Invalid(problem.into()));
        }
        let all = States::of(surfaces)?;
        let states = all.all();
        let begun = Begun::of(&states, surface, fineness, (budget, surfaces.len()))?;
        let Begun { mut topology, mut cells, targets, tolerance, mut borders, mut edges, limit } = begun;
        if let Some(beside) = beside {
            beside::take(beside, &mut borders, &edges);
        }
        let spent = Budget::new(limit);
        let mut stale = vec![true; cells.len()];
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
                return Err(over_budget(fineness, None, ("triangles", 1.0), budget));
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
        let Assembled { mesh, others, furthest } =
            assemble(surface, &states, &mut topology, cells, &edges, &borders)?;
        let live = all.0.iter().map(Option::is_some).collect();
        Ok(Self { mesh, others, live, tolerance, error: worst.length + furthest })
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
            borders.push(BorderSide {
                edge,
                patch: k,
                side,
                states: states.iter().map(of).collect(),
                taken: Taken::default(),
            });
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
