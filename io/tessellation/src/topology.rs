//! What of a surface is one: seams, poles, and the edges and corners that patches share.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Surface;

use crate::patch::{Homogeneous, Patch, Patches, project};
use crate::weld::Welds;

/// Points closer than this fraction of the surface's size are one point. Rounding in two edges that coincide is a
/// hundred times smaller.
const ONE_POINT: f64 = 1e-12;

/// Which sides of the patch are one point. Vertices there are one, however many the tree has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Poles(pub(crate) [bool; 4]);

impl Poles {
    /// Which pairs of neighbouring corners of a triangle are the same point of the surface.
    pub(crate) fn same(&self, [a, b, c]: [[f64; 2]; 3]) -> [bool; 3] {
        if self.0 == [false; 4] {
            return [false; 3];
        }
        let [a, b, c] = [a, b, c].map(|at| self.key(at));
        [(a, b), (b, c), (c, a)].map(|(from, to)| from.is_some() && from == to)
    }

    /// The collapsed side that a place is on; sides that meet at a corner are one point.
    pub(crate) fn key(&self, at: [f64; 2]) -> Option<usize> {
        if self.0 == [false; 4] {
            return None;
        }
        let on = [at[1] <= 0.0, at[0] >= 1.0, at[1] >= 1.0, at[0] <= 0.0];
        let side = (0..4).find(|&k| on[k] && self.0[k])?;
        let mut first = side;
        for back in 1..4 {
            let k = (side + 4 - back) % 4;
            if !self.0[k] {
                break;
            }
            first = k;
        }
        if self.0 == [true; 4] { Some(0) } else { Some(first) }
    }
}

/// The parameter lines between patches, numbered; `ends[k]` are those at the start and end of patch column `k`.
#[derive(Debug, Clone)]
struct Lines {
    ends: Vec<[usize; 2]>,
    count: usize,
}

impl Lines {
    /// Neighbouring patches share a line unless the surface jumps there; a closed direction's last line is its first.
    fn new(patches: usize, jumps: impl Fn(usize) -> bool, closed: bool) -> Self {
        let (mut ends, mut count) = (Vec::with_capacity(patches), 1);
        for k in 0..patches {
            if k > 0 && jumps(k) {
                count += 1;
            }
            let last = closed && k + 1 == patches;
            ends.push([count - 1, if last { 0 } else { count }]);
            count += usize::from(!last);
        }
        Self { ends, count }
    }
}

/// The shared edges and corners.
#[derive(Debug)]
pub(crate) struct Topology {
    pub(crate) counts: [usize; 2],
    lines: [Lines; 2],
    /// Whether the surface closes, by direction.
    pub(crate) closed: [bool; 2],
    corners: Welds,
    uses: Vec<u8>,
}

impl Topology {
    /// Looks at the sides of patches that may coincide, and are one where they do in all `states`. `O(patches along the
    /// border and along knots at which the surface may jump)` for each.
    pub(crate) fn new<'p, 's: 'p>(
        surface: &Surface,
        states: impl Iterator<Item = &'p Patches<'s>> + Clone,
    ) -> Self {
        let spaces = [surface.u(), surface.v()];
        let counts = states.clone().next().map_or([0; 2], Patches::counts);
        let ends =
            |d: usize, k: usize| states.clone().next().map_or((0.0, 0.0), |patches| patches.ends(d, k));
        let patch = |patches: &Patches<'_>, direction: usize, along: usize, across: usize| {
            if direction == 0 { patches.get(along, across) } else { patches.get(across, along) }
        };
        // The sides at the start and at the end of a direction.
        let sides = [[3, 1], [0, 2]];
        let side = |patch: &Patch, k: usize| patch.side(k).copied().collect::<Vec<_>>();
        let meet = |d: usize, before: usize, after: usize| {
            states.clone().all(|patches| {
                (0..counts[1 - d]).all(|across| {
                    let (a, b) = (patch(patches, d, before, across), patch(patches, d, after, across));
                    coincide(&side(&a, sides[d][1]), &side(&b, sides[d][0]))
                })
            })
        };
        let closed = [0, 1].map(|d| spaces[d].is_periodic() || meet(d, counts[d] - 1, 0));
        let lines = [0, 1].map(|d| {
            let jumps = |k: usize| {
                let (start, _) = ends(d, k);
                spaces[d].multiplicity(start) > spaces[d].degree() && !meet(d, k - 1, k)
            };
            Lines::new(counts[d], jumps, closed[d])
        });
        let corners = Welds::new(lines[0].count * lines[1].count);
        let mut topology = Self { counts, lines, closed, corners, uses: Vec::new() };
        topology.uses = vec![0; topology.edge_count()];
        for patch in 0..counts[0] * counts[1] {
            for side in 0..4 {
                let edge = topology.edge(patch, side);
                topology.uses[edge] = topology.uses[edge].saturating_add(1);
            }
        }
        topology
    }

    /// Makes the corners at the ends of collapsed sides one.
    pub(crate) fn collapse(&mut self, patch: usize, poles: &Poles) {
        for side in (0..4).filter(|&side| poles.0[side]) {
            let [a, b] = [side, (side + 1) % 4].map(|k| self.corner_place(patch, k));
            self.corners.join(a, b);
        }
    }

    /// The number of edges (sides of patches, each counted once).
    pub(crate) fn edge_count(&self) -> usize {
        self.lines[1].count * self.counts[0] + self.lines[0].count * self.counts[1]
    }

    /// The number of places for corners: every corner is less.
    pub(crate) fn corner_count(&self) -> usize {
        self.lines[0].count * self.lines[1].count
    }

    /// The edge that is a side of a patch.
    pub(crate) fn edge(&self, patch: usize, side: usize) -> usize {
        let (i, j) = (patch / self.counts[1], patch % self.counts[1]);
        match side {
            0 => self.lines[1].ends[j][0] * self.counts[0] + i,
            2 => self.lines[1].ends[j][1] * self.counts[0] + i,
            _ => {
                let line = self.lines[0].ends[i][usize::from(side == 1)];
                self.lines[1].count * self.counts[0] + line * self.counts[1] + j
            }
        }
    }

    /// Whether only one patch has an edge.
    pub(crate) fn is_border(&self, edge: usize) -> bool {
        self.uses[edge] == 1
    }

    /// The corner of a patch: 0 at `(0, 0)`, 1 at `(1, 0)`, 2 at `(1, 1)`, 3 at `(0, 1)`.
    pub(crate) fn corner(&mut self, patch: usize, corner: usize) -> usize {
        let place = self.corner_place(patch, corner);
        self.corners.root(place)
    }

    fn corner_place(&self, patch: usize, corner: usize) -> usize {
        let (i, j) = (patch / self.counts[1], patch % self.counts[1]);
        let (u, v) = (usize::from(corner == 1 || corner == 2), usize::from(corner >= 2));
        self.lines[0].ends[i][u] * self.lines[1].count + self.lines[1].ends[j][v]
    }
}

/// The sides of a patch that are one point.
pub(crate) fn poles(patch: &Patch) -> Poles {
    let one = |side: usize| {
        let mut points = patch.side(side).map(project);
        points.next().is_some_and(|first| points.all(|p| (p - first).norm() <= ONE_POINT))
    };
    Poles([0, 1, 2, 3].map(one))
}

/// Whether two edges are the same curve run through alike: control points equal, weights proportional.
fn coincide(a: &[Homogeneous], b: &[Homogeneous]) -> bool {
    let near = |(x, y): (&Homogeneous, &Homogeneous)| {
        let shift: Vector = project(x) - project(y);
        let (wx, wy) = (x[3] * b[0][3], y[3] * a[0][3]);
        shift.norm() <= ONE_POINT && (wx - wy).abs() <= ONE_POINT * wx.max(wy)
    };
    a.len() == b.len() && a.iter().zip(b).all(near)
}
