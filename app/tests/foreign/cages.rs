//! Random control cages, the same on every run: any valence, faces of any size, open and closed, in several parts, sharp in all ways.

use std::collections::{BTreeMap, BTreeSet};

use loftsman::subdivision::{BoundaryRule, Cage};
use loftsman_kernel::Point;
use loftsman_tests::curves::Sequence;
use serde_json::{Value, json};

/// A cage as documents and recipes say it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wild {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) faces: Vec<Vec<usize>>,
    pub(crate) creases: Vec<(usize, usize, f64)>,
    pub(crate) corners: Vec<(usize, f64)>,
    pub(crate) rounded: bool,
}

fn edge(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

impl Wild {
    /// The faces at each edge.
    pub(crate) fn edges(&self) -> BTreeMap<(usize, usize), Vec<usize>> {
        let mut all: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..face.len() {
                all.entry(edge(face[k], face[(k + 1) % face.len()])).or_default().push(f);
            }
        }
        all
    }

    /// The numbers of the edges and of the faces of each vertex.
    pub(crate) fn valences(&self) -> Vec<[usize; 2]> {
        let mut all = vec![[0; 2]; self.points.len()];
        self.edges().keys().for_each(|&(a, b)| [a, b].into_iter().for_each(|v| all[v][0] += 1));
        self.faces.iter().flatten().for_each(|&v| all[v][1] += 1);
        all
    }

    /// How many parts hang together by edges.
    pub(crate) fn parts(&self) -> usize {
        let mut part: Vec<usize> = (0..self.points.len()).collect();
        // The least number goes round each face until nothing changes.
        loop {
            let before = part.clone();
            for face in &self.faces {
                let least = face.iter().map(|&v| part[v]).min().unwrap();
                face.iter().for_each(|&v| part[v] = least);
            }
            if part == before {
                return part.iter().collect::<BTreeSet<_>>().len();
            }
        }
    }

    pub(crate) fn boundary(&self) -> &'static str {
        if self.rounded { "edge-only" } else { "edge-and-corner" }
    }

    pub(crate) fn mesh(&self) -> Value {
        json!({ "points": self.points, "faces": self.faces })
    }

    /// As the library takes it; it says what is wrong with it.
    pub(crate) fn cage(&self) -> loftsman::subdivision::Result<Cage> {
        let rule = if self.rounded { BoundaryRule::EdgeOnly } else { BoundaryRule::EdgeAndCorner };
        let points = self.points.iter().map(|p| Point::from(*p)).collect();
        let mut cage = Cage::new(points, &self.faces)?.with_boundary(rule);
        for &(a, b, sharpness) in &self.creases {
            cage = cage.with_crease(a, b, sharpness)?;
        }
        for &(v, sharpness) in &self.corners {
            cage = cage.with_corner(v, sharpness)?;
        }
        Ok(cage)
    }

    /// Whether it is a cage without vertices that nothing uses, no two faces of which have all vertices in common.
    fn is_sound(&self) -> bool {
        let used: BTreeSet<usize> = self.faces.iter().flatten().copied().collect();
        let sets: BTreeSet<BTreeSet<usize>> =
            self.faces.iter().map(|f| f.iter().copied().collect()).collect();
        !self.faces.is_empty()
            && used.len() == self.points.len()
            && sets.len() == self.faces.len()
            && self.cage().is_ok()
    }

    /// Itself and another one, which is moved aside.
    fn beside(mut self, other: Self) -> Self {
        let first = self.points.len();
        self.points.extend(other.points.iter().map(|[x, y, z]| [x + 4.0, y + 1.0, *z]));
        self.faces.extend(other.faces.iter().map(|f| f.iter().map(|v| v + first).collect()));
        self
    }
}

/// A number below `count`.
fn below(random: &mut Sequence, count: usize) -> usize {
    // The lower bits of the sequence repeat soon.
    (random.next_number() * count as f64) as usize
}

/// A grid of quads, either direction perhaps closed: a sheet, a tube, a torus.
fn grid([rows, columns]: [usize; 2], closed: [bool; 2]) -> Wild {
    let turn = |k: usize, n: usize| (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
    let point = |k: usize| {
        let (i, j) = (k / columns, k % columns);
        let (x, y) = (i as f64 - 0.5 * rows as f64, j as f64 - 0.5 * columns as f64);
        let ((s, c), (t, d)) = (turn(i, rows), turn(j, columns));
        match closed {
            [false, false] => [x, y, 0.2 * x * y],
            [false, true] => [d, t, x],
            [true, false] => [c, s, y],
            [true, true] => [(1.5 + 0.6 * d) * c, (1.5 + 0.6 * d) * s, 0.6 * t],
        }
    };
    let at = |i: usize, j: usize| i % rows * columns + j % columns;
    let [r, c] = [rows - usize::from(!closed[0]), columns - usize::from(!closed[1])];
    let quad = |k: usize| {
        let (i, j) = (k / c, k % c);
        vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    };
    Wild {
        points: (0..rows * columns).map(point).collect(),
        faces: (0..r * c).map(quad).collect(),
        ..Wild::default()
    }
}

/// A ring of `n` vertices between two ends: each end a face of `n` corners or a fan of triangles round a vertex.
fn barrel(n: usize, tips: [bool; 2]) -> Wild {
    let mut wild = grid([2, n], [false, true]);
    for (end, tip) in tips.into_iter().enumerate() {
        let ring: Vec<usize> = (0..n).map(|k| if end == 0 { k } else { n + n - 1 - k }).collect();
        if tip {
            let middle = wild.points.len();
            wild.points.push([0.1, 0.0, if end == 0 { -2.0 } else { 1.0 }]);
            wild.faces.extend((0..n).map(|k| vec![middle, ring[k], ring[(k + 1) % n]]));
        } else {
            wild.faces.push(ring);
        }
    }
    wild
}

/// Two neighbours become one face.
fn merged(wild: &mut Wild, random: &mut Sequence) {
    let inner: Vec<_> = wild.edges().into_iter().filter(|(_, f)| f.len() == 2).collect();
    if inner.is_empty() {
        return;
    }
    let ((a, b), faces) = inner[below(random, inner.len())].clone();
    let from = |f: usize| {
        let face = &wild.faces[f];
        let k = (0..face.len()).find(|&k| edge(face[k], face[(k + 1) % face.len()]) == (a, b)).unwrap();
        // Without the edge's first end.
        (1..face.len()).map(|j| face[(k + j) % face.len()]).collect::<Vec<_>>()
    };
    let all = [from(faces[0]), from(faces[1])].concat();
    wild.faces[faces[0]] = all;
    wild.faces.remove(faces[1]);
}

/// A change of the mesh, of one of five kinds.
fn change(wild: &mut Wild, random: &mut Sequence) {
    let face = below(random, wild.faces.len());
    let corners = wild.faces[face].clone();
    let n = corners.len();
    let middle = |wild: &Wild| {
        let sum = |k: usize| corners.iter().map(|&v| wild.points[v][k]).sum::<f64>() / n as f64;
        [0, 1, 2].map(|k| sum(k) + 0.1)
    };
    match below(random, 5) {
        // A vertex in the middle of a face, with an edge to each of its corners.
        0 => {
            wild.points.push(middle(wild));
            let tip = wild.points.len() - 1;
            wild.faces.remove(face);
            wild.faces.extend((0..n).map(|k| vec![tip, corners[k], corners[(k + 1) % n]]));
        }
        1 => merged(wild, random),
        // A face is taken away.
        2 => drop(wild.faces.remove(face)),
        // A face is cut in two.
        3 if n > 3 => {
            let to = 2 + below(random, n - 3);
            wild.faces[face] = corners[..=to].to_vec();
            wild.faces.push([&corners[to..], &corners[..1]].concat());
        }
        // An edge is cut in two, by a vertex of two edges.
        4 => {
            let (a, b) = (corners[0], corners[1]);
            wild.points.push([0, 1, 2].map(|k| 0.5 * (wild.points[a][k] + wild.points[b][k]) + 0.07));
            let new = wild.points.len() - 1;
            for face in &mut wild.faces {
                let place =
                    (0..face.len()).find(|&k| edge(face[k], face[(k + 1) % face.len()]) == edge(a, b));
                if let Some(k) = place {
                    face.insert(k + 1, new);
                }
            }
        }
        _ => {}
    }
}

/// A sharpness of `10 c²`, where `c` is a number of 64ths: what Blender says by `c` in single precision is the same then, to the last bit.
fn sharpness(random: &mut Sequence) -> f64 {
    if below(random, 5) == 0 {
        return 10.0;
    }
    let c = (1 + below(random, 63)) as f64 / 64.0;
    10.0 * c * c
}

fn sharpen(wild: &mut Wild, random: &mut Sequence) {
    let edges: Vec<_> = wild.edges().into_keys().collect();
    for _ in 0..below(random, 6) {
        let (mut a, mut b) = edges[below(random, edges.len())];
        let sharpness = sharpness(random);
        // On along the mesh, as far as it goes.
        for _ in 0..=below(random, 4) {
            if wild.creases.iter().all(|c| edge(c.0, c.1) != edge(a, b)) {
                wild.creases.push((a, b, sharpness));
            }
            let next: Vec<usize> = edges
                .iter()
                .filter(|e| e.0 == b || e.1 == b)
                .map(|e| e.0 + e.1 - b)
                .filter(|&v| v != a)
                .collect();
            if next.is_empty() {
                break;
            }
            (a, b) = (b, next[below(random, next.len())]);
        }
    }
    for _ in 0..below(random, 4) {
        let v = below(random, wild.points.len());
        if wild.corners.iter().all(|c| c.0 != v) {
            wild.corners.push((v, sharpness(random)));
        }
    }
}

/// The cage with this number.
pub(crate) fn wild(number: u32) -> Wild {
    let mut random = Sequence::new(7919 * number + 1);
    for _ in 0..5 {
        random.next_number();
    }
    let base = |kind: usize, random: &mut Sequence| {
        let n = 3 + below(random, 6);
        let size = [3 + below(random, 3), 3 + below(random, 3)];
        match kind {
            0 => grid(size, [true, true]),
            1 => grid(size, [false, true]),
            2 => grid(size, [false, false]),
            3 => barrel(n, [true, true]),
            4 => barrel(n, [true, false]),
            _ => barrel(n, [false, false]),
        }
    };
    let mut wild = base(number as usize % 6, &mut random);
    if number % 4 == 3 {
        let kind = below(&mut random, 6);
        wild = wild.beside(base(kind, &mut random));
    }
    wild.rounded = number % 8 < 4;
    for _ in 0..below(&mut random, 8) {
        let mut changed = wild.clone();
        change(&mut changed, &mut random);
        if changed.is_sound() {
            wild = changed;
        }
    }
    for p in &mut wild.points {
        *p = p.map(|x| x + 0.2 * (random.next_number() - 0.5));
    }
    if !number.is_multiple_of(7) {
        sharpen(&mut wild, &mut random);
    }
    wild
}
