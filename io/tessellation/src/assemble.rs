//! The mesh of the patches' cells: one point where patches share it, and what differs by corner beside it.

use std::collections::BTreeMap;

use loftsman_kernel::mesh::{Mesh, NONE};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Error, Point, Result, Vector};

use crate::beside::{Between, BorderSide, Corner, Splits, off};
use crate::distinct::Distinct;
use crate::fineness::Frame;
use crate::normals::normal;
use crate::patch::Patches;
use crate::refine::Cells;
use crate::state::State;
use crate::topology::{Poles, Topology};

/// Normals of one point that differ by less than this angle (as a chord of the unit sphere) are one: the angle below
/// which CAD systems call tangent planes the same.
const CREASE: f64 = 2e-3;

/// A triangle with less area than this part of the square of the mesh's width is a line.
const NO_AREA: f64 = 1e-14;

/// The points' numbers, by where they are.
struct Numbers {
    corners: Vec<u32>,
    edges: Vec<u32>,
    next: u32,
    /// Room for the vertices of a side.
    chain: Vec<u32>,
}

impl Numbers {
    /// Corners first, then the vertices of each edge.
    fn new(topology: &mut Topology, cells: &[Cells], edges: &[Vec<f64>]) -> Self {
        let corners = vec![NONE; topology.corner_count()];
        let mut numbers = Self { corners, edges: vec![NONE; edges.len()], next: 0, chain: Vec::new() };
        for (k, cells) in cells.iter().enumerate() {
            for corner in 0..4 {
                let root = topology.corner(k, corner);
                if numbers.corners[root] == NONE {
                    numbers.corners[root] = numbers.next;
                    numbers.next += 1;
                }
            }
            for side in (0..4).filter(|&side| !cells.poles.0[side]) {
                let edge = topology.edge(k, side);
                if numbers.edges[edge] == NONE {
                    numbers.edges[edge] = numbers.next;
                    numbers.next += edges[edge].len() as u32;
                }
            }
        }
        numbers
    }

    /// The number of a vertex of a side that is no point, counted from its start, of which `inner` are between its ends.
    fn on(
        &self,
        topology: &mut Topology,
        (edge, patch, side): (usize, usize, usize),
        vertex: usize,
        inner: usize,
    ) -> u32 {
        match vertex.checked_sub(1) {
            Some(k) if k < inner => self.edges[edge] + k as u32,
            end => self.corners[topology.corner(patch, ENDS[side][usize::from(end.is_some())])],
        }
    }

    /// Adds the numbers of all vertices of a patch; those inside it get new ones.
    fn of(&mut self, topology: &mut Topology, k: usize, cells: &Cells, out: &mut Vec<u32>) {
        let start = out.len();
        out.resize(start + cells.tree.vertices.len(), NONE);
        let (out, mut chain) = (&mut out[start..], std::mem::take(&mut self.chain));
        for (side, ends) in ENDS.into_iter().enumerate() {
            cells.tree.side(side, &mut chain);
            let [first, last] = ends.map(|corner| self.corners[topology.corner(k, corner)]);
            let base = self.edges[topology.edge(k, side)];
            let end = chain.len() - 1;
            for (at, &vertex) in chain.iter().enumerate() {
                out[vertex as usize] = match at {
                    0 => first,
                    _ if at == end => last,
                    _ if cells.poles.0[side] => first,
                    _ => base + at as u32 - 1,
                };
            }
        }
        for number in out.iter_mut().filter(|number| **number == NONE) {
            *number = self.next;
            self.next += 1;
        }
        self.chain = chain;
    }
}

/// The corners at which each side starts and ends, its direction being its parameter's.
const ENDS: [[usize; 2]; 4] = [[0, 1], [1, 2], [3, 2], [0, 3]];

/// The layers while they grow: distinct values of each point, and which of them each corner has.
struct Corners {
    points: Vec<u32>,
    normals: Distinct<Vector>,
    uvs: Distinct<[f64; 2]>,
    /// Of the vertices of a patch, but for poles, the two that have been found.
    found: Vec<Option<[u32; 2]>>,
}

/// The mesh of a surface in the first of its states.
pub(crate) struct Assembled {
    pub(crate) mesh: Mesh,
    /// The points in each of the other states.
    pub(crate) others: Vec<Vec<Point>>,
    /// How far what was taken from beside is from the chords that it divides, or was put where another one is, at most.
    pub(crate) furthest: f64,
}

/// Puts the mesh together, as the first state has it; and its points in each of the others.
pub(crate) fn assemble(
    surface: &Surface,
    states: &[&State<'_>],
    topology: &mut Topology,
    cells: Vec<Cells>,
    edges: &[Vec<f64>],
    borders: &[BorderSide],
) -> Result<Assembled> {
    let mut numbers = Numbers::new(topology, &cells, edges);
    let mut all = Vec::with_capacity(cells.iter().map(|cells| cells.tree.vertices.len()).sum());
    cells.iter().enumerate().for_each(|(k, cells)| numbers.of(topology, k, cells, &mut all));
    let mut rest = all.as_slice();
    let maps = cells.iter().map(|cells| rest.split_off(..cells.tree.vertices.len()).unwrap_or_default());
    let maps: Vec<&[u32]> = maps.collect();
    let count = numbers.next as usize;
    let (splits, extras) = between(topology, &mut numbers, states, edges, borders);
    let mut furthest = 0.0_f64;
    let mut moved = Vec::with_capacity(states.len());
    for (s, state) in states.iter().enumerate() {
        let mut points = points(&state.frame, s, &cells, &maps, count);
        for BorderSide { edge, patch, side, states, taken } in borders {
            let (base, border) = (numbers.edges[*edge] as usize, &states[s]);
            for (at, &fraction) in edges[*edge].iter().enumerate() {
                points[base + at] = border.point(fraction);
            }
            for (fraction, corner) in [0.0, 1.0].into_iter().zip(ENDS[*side]) {
                points[numbers.corners[topology.corner(*patch, corner)] as usize] = border.point(fraction);
            }
            for &(vertex, point) in &taken.snaps {
                let number = numbers.on(topology, (*edge, *patch, *side), vertex, edges[*edge].len());
                furthest = furthest.max((points[number as usize] - point).norm());
                points[number as usize] = point;
            }
        }
        let snapped = furthest;
        for &([from, to], point) in &extras {
            furthest = furthest.max(snapped + off(&point, &points[from as usize], &points[to as usize]));
            points.push(point);
        }
        moved.push(points);
    }
    let scale = Scale::new(surface, &states[0].patches);
    let corner_count = 3 * cells.iter().map(|cells| cells.triangles().len()).sum::<usize>();
    let mut corners = Corners {
        points: Vec::with_capacity(corner_count),
        normals: Distinct::new(count + extras.len()),
        uvs: Distinct::new(count + extras.len()),
        found: Vec::new(),
    };
    let poles = poles(&cells, &maps);
    for (k, (cells, map)) in cells.iter().zip(&maps).enumerate() {
        let (i, j) = (k / topology.counts[1], k % topology.counts[1]);
        let uv = |at: [f64; 2]| scale.uv(i, j, at);
        corners.add(cells, map, &poles, &splits, uv);
    }
    // What is allocated from here on finds room where they were.
    drop(cells);
    let (mesh, others) = corners.into_mesh(moved)?;
    Ok(Assembled { mesh, others, furthest })
}

/// The vertices that the border takes from beside it, between those that it has, and where they are: between which, and the point. Their numbers
/// are those after all others.
fn between(
    topology: &mut Topology,
    numbers: &mut Numbers,
    states: &[&State<'_>],
    edges: &[Vec<f64>],
    borders: &[BorderSide],
) -> (Splits, Vec<([u32; 2], Point)>) {
    let (mut splits, mut extras) = (Splits::default(), Vec::new());
    let Some(state) = states.first() else { return (splits, extras) };
    for BorderSide { edge, patch, side, taken, .. } in borders {
        if taken.extras.is_empty() {
            continue;
        }
        let of = state.patches.get(patch / topology.counts[1], patch % topology.counts[1]);
        for run in taken.extras.chunk_by(|a, b| a.0 == b.0) {
            let place = (*edge, *patch, *side);
            let ends = [run[0].0, run[0].0 + 1].map(|k| numbers.on(topology, place, k, edges[*edge].len()));
            let all = run.iter().map(|&(_, t, point)| {
                let at = match side {
                    0 => [t, 0.0],
                    1 => [1.0, t],
                    2 => [t, 1.0],
                    _ => [0.0, t],
                };
                extras.push((ends, point));
                numbers.next += 1;
                Between { number: numbers.next - 1, at, normal: normal(&of, at, &of.jet(at)) }
            });
            splits.put(ends[0], ends[1], all.collect());
        }
    }
    (splits, extras)
}

/// The points in the surface's own coordinates; where patches share one, as the first of them has it.
fn points(frame: &Frame, state: usize, cells: &[Cells], maps: &[&[u32]], count: usize) -> Vec<Point> {
    let mut points = vec![Point::from([f64::NAN; 3]); count];
    for (cells, map) in cells.iter().zip(maps) {
        let tree = if state == 0 { &cells.tree } else { &cells.others[state - 1] };
        for (vertex, &number) in tree.vertices.iter().zip(*map) {
            let point = &mut points[number as usize];
            if point.x.is_nan() {
                *point = frame.centre + vertex.point * frame.size;
            }
        }
    }
    points
}

/// The normal of every pole at which all that ends there agrees; `None` at the others (the apex of a cone).
fn poles(cells: &[Cells], maps: &[&[u32]]) -> BTreeMap<u32, Option<Vector>> {
    let mut poles = BTreeMap::new();
    for (cells, map) in cells.iter().zip(maps).filter(|(cells, _)| cells.poles != Poles::default()) {
        for (vertex, &number) in cells.tree.vertices.iter().zip(*map) {
            if cells.poles.key(vertex.at).is_some() {
                let normal = Some(vertex.normal).filter(|n| *n != Vector::zeros());
                let known = poles.entry(number).or_insert(normal);
                *known = known.zip(normal).filter(|(a, b)| (a - b).norm() <= CREASE).map(|(a, _)| a);
            }
        }
    }
    poles
}

impl Corners {
    /// The triangles of a patch. Those that a pole or a seam has made edges are left out.
    fn add(
        &mut self,
        cells: &Cells,
        map: &[u32],
        poles: &BTreeMap<u32, Option<Vector>>,
        splits: &Splits,
        uv: impl Fn([f64; 2]) -> [f64; 2],
    ) {
        self.find_plain(cells, map, &uv);
        for triangle in cells.triangles() {
            let numbers = triangle.map(|v| map[v as usize]);
            let [a, b, c] = numbers;
            if a == b || b == c || c == a {
                continue;
            }
            let parts = if splits.is_empty() { Vec::new() } else { splits.of(numbers) };
            if parts.is_empty() {
                for at in 0..3 {
                    self.add_own(cells, poles, &uv, (triangle, &numbers, at));
                }
            }
            for corner in parts.into_iter().flatten() {
                match corner {
                    Corner::Own(at) => self.add_own(cells, poles, &uv, (triangle, &numbers, at)),
                    Corner::Between(between) => {
                        self.add_value(between.number, uv(between.at), between.normal);
                    }
                }
            }
        }
    }

    /// That corner of a triangle of a patch.
    #[inline]
    fn add_own(
        &mut self,
        cells: &Cells,
        poles: &BTreeMap<u32, Option<Vector>>,
        uv: impl Fn([f64; 2]) -> [f64; 2],
        (triangle, numbers, at): (&[u32; 3], &[u32; 3], usize),
    ) {
        let number = numbers[at];
        if let Some([uv, normal]) = self.found[triangle[at] as usize] {
            self.points.push(number);
            self.uvs.add_corner(uv);
            self.normals.add_corner(normal);
            return;
        }
        let [vertex, next, last] =
            [0, 1, 2].map(|step| &cells.tree.vertices[triangle[(at + step) % 3] as usize]);
        let (mut place, mut normal) = (vertex.at, vertex.normal);
        let pole = cells.poles.key(vertex.at);
        if let Some(side) = pole {
            // A fan: every triangle takes what lies between its two other corners.
            let along = side % 2;
            place[along] = 0.5 * (next.at[along] + last.at[along]);
            let between = || (next.normal + last.normal).try_normalize(1e-3).unwrap_or_default();
            normal = poles.get(&number).copied().flatten().unwrap_or_else(between);
        }
        let found = self.add_value(number, uv(place), normal);
        if pole.is_none() {
            self.found[triangle[at] as usize] = found;
        }
    }

    /// A corner at a point with these values, and which of the point's they are; `None` where the normal is none.
    #[inline]
    fn add_value(&mut self, number: u32, uv: [f64; 2], normal: Vector) -> Option<[u32; 2]> {
        let uv = self.uvs.find(number, uv, &self.points, |x, y| x == y);
        self.uvs.add_corner(uv);
        let found = if normal == Vector::zeros() {
            self.normals.add_corner_without(&self.points);
            None
        } else {
            let normal = self.normals.find(number, normal, &self.points, same_normal);
            self.normals.add_corner(normal);
            Some([uv, normal])
        };
        self.points.push(number);
        found
    }

    /// Finds, of a patch without poles, the values of all vertices that have a normal, so that corners need not ask.
    fn find_plain(&mut self, cells: &Cells, map: &[u32], uv: impl Fn([f64; 2]) -> [f64; 2]) {
        self.found.clear();
        if cells.poles != Poles::default() {
            self.found.resize(map.len(), None);
            return;
        }
        let Self { points, normals, uvs, found } = self;
        found.extend(cells.tree.vertices.iter().zip(map).map(|(vertex, &number)| {
            (vertex.normal != Vector::zeros()).then(|| {
                let uv = uvs.find(number, uv(vertex.at), points, |x, y| x == y);
                [uv, normals.find(number, vertex.normal, points, same_normal)]
            })
        }));
    }

    /// The mesh, its points being those of the first of the states; and the points of the others.
    fn into_mesh(mut self, mut states: Vec<Vec<Point>>) -> Result<(Mesh, Vec<Vec<Point>>)> {
        let is_thin = |points: &Vec<Point>| {
            let widest = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
            self.points.chunks_exact(3).all(|face| {
                let corner = |k: usize| points[face[k] as usize];
                let (s, t) = ((corner(1) - corner(0)) / widest, (corner(2) - corner(0)) / widest);
                s.cross(&t).norm() <= NO_AREA
            })
        };
        if states.iter().all(is_thin) {
            return Err(Error::NoExtent(
                "the surface has no area: all of it is on one curve or at one point".into(),
            ));
        }
        self.fill_normals(&states[0]);
        let kept = compact(&mut states, &mut self.points);
        let starts = (0..=self.points.len() / 3).map(|f| 3 * f).collect();
        let others = states.split_off(1);
        let mut mesh = Mesh::from_parts(states.pop().unwrap_or_default(), self.points, starts)?;
        mesh.normals = self.normals.into_layer(&kept);
        mesh.uvs = self.uvs.into_layer(&kept);
        Ok((mesh, others))
    }

    /// Where the surface has no normal, nor a limit: the mean of the faces around, by their angles there.
    fn fill_normals(&mut self, points: &[Point]) {
        if !self.normals.lacks() {
            return;
        }
        let mut sums = vec![Vector::zeros(); points.len()];
        for face in self.points.chunks_exact(3) {
            for k in 0..3 {
                let corner = |step: usize| points[face[(k + step) % 3] as usize];
                let (s, t) = (corner(1) - corner(0), corner(2) - corner(0));
                let size = s.amax().max(t.amax());
                if size > 0.0 {
                    let (s, t) = (s / size, t / size);
                    sums[face[k] as usize] +=
                        s.cross(&t).try_normalize(0.0).unwrap_or_default() * s.angle(&t);
                }
            }
        }
        let mean = |point: u32| sums[point as usize].try_normalize(1e-9).unwrap_or_else(Vector::z);
        self.normals.fill(&self.points, mean, same_normal);
    }
}

/// Whether two normals of a point are one.
fn same_normal(a: &Vector, b: &Vector) -> bool {
    (a - b).norm() <= CREASE
}

/// Takes out points that no triangle has; the old numbers of those that stay.
fn compact(states: &mut [Vec<Point>], corners: &mut [u32]) -> Vec<u32> {
    let count = states.first().map_or(0, Vec::len);
    let mut number = vec![NONE; count];
    corners.iter().for_each(|&c| number[c as usize] = 0);
    let kept: Vec<u32> = (0..count as u32).filter(|&k| number[k as usize] == 0).collect();
    for (new, &old) in kept.iter().enumerate() {
        number[old as usize] = new as u32;
        states.iter_mut().for_each(|points| points[new] = points[old as usize]);
    }
    states.iter_mut().for_each(|points| points.truncate(kept.len()));
    corners.iter_mut().for_each(|c| *c = number[*c as usize]);
    kept
}

/// Parameters of the surface scaled to `[0, 1]²`.
struct Scale {
    ends: [Vec<(f64, f64)>; 2],
}

impl Scale {
    fn new(surface: &Surface, patches: &Patches<'_>) -> Self {
        let domains = [surface.u().domain(), surface.v().domain()];
        let counts = patches.counts();
        let ends = [0, 1].map(|d| {
            let (start, end) = domains[d];
            let scaled = |x: f64| (x - start) / (end - start);
            (0..counts[d]).map(|k| patches.ends(d, k)).map(|(a, b)| (scaled(a), scaled(b))).collect()
        });
        Self { ends }
    }

    fn uv(&self, i: usize, j: usize, at: [f64; 2]) -> [f64; 2] {
        let mix = |(a, b): (f64, f64), t: f64| if t >= 1.0 { b } else { a + (b - a) * t };
        [mix(self.ends[0][i], at[0]), mix(self.ends[1][j], at[1])]
    }
}
