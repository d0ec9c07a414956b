//! One cell: the triangles it is made of, and how far they are from the surface at most.

mod corners;

use loftsman_kernel::Vector;

use self::corners::{angle, bounds, crossing, leg};
use crate::bezier::{less, more, restrict};
use crate::fineness::Target;
use crate::flat::Chord;
use crate::form::Ranges;
use crate::forms::Forms;
use crate::patch::{Homogeneous, Patch, project, xyz};
use crate::topology::Poles;
use crate::tree::{Cell, Cut, Tree, Vertex};
use crate::triangulation::{Costs, HOPELESS_EDGE, Plane, Triangle, Triangulation};

/// Where the patch is further (in tolerances) from one of a cell's edges, the cell is cut without a closer look.
const HOPELESS: f64 = 8.0;
/// Cells are not cut beyond this part of a patch: a power of two, far above where fractions cease to be exact.
const SMALLEST: f64 = 1.0 / (1_u64 << 40) as f64;
/// Into so many strips a cell along an edge is divided, so that the hulls of their control points are narrow.
const STRIPS: u32 = 8;

/// What a cell comes to.
pub(crate) enum Verdict {
    /// It is close enough: its triangles are in [`Judge::triangles`].
    Meets {
        /// The certified distance between triangles and surface.
        error: f64,
    },
    /// It must be cut.
    Cut(Cut),
}

/// A cell as one state of its patch shows it.
struct View<'t> {
    corners: [&'t Vertex; 4],
    /// The box of its parameters.
    low: [f64; 2],
    high: [f64; 2],
    /// Whether it is too small to be cut.
    tiny: bool,
    /// The second derivatives across the cell.
    ranges: Ranges,
    /// How far the patch is from its edges' chords, across the cell.
    bends: [f64; 4],
    /// The only edge that must stay whole.
    whole: Option<usize>,
}

/// Judges cells of one patch; its room is used again from cell to cell.
#[derive(Default)]
pub(crate) struct Judge {
    forms: Forms,
    strip: Vec<Homogeneous>,
    /// Whether it must be certain that the patch does not turn over within a triangle: where the triangles are chosen for one
    /// state of a moving patch, and have to do for others, the normals at the corners say too little.
    strict: bool,
    /// The control points of the cell, where that is asked.
    hull: Vec<Homogeneous>,
    /// The triangles of the last cell that was looked at closely.
    triangulation: Triangulation,
}

impl Judge {
    /// One that must be certain that nothing turns over within a triangle, or one that goes by the normals at its corners.
    pub(crate) fn new(strict: bool) -> Self {
        Self { strict, ..Self::default() }
    }

    /// The number of vertices around a cell.
    pub(crate) fn look(&mut self, tree: &Tree, cell: &Cell) -> usize {
        self.triangulation.look(tree, cell)
    }

    /// The triangles of the last cell that met the target.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangulation.triangles.iter().map(|triangle| triangle.corners)
    }

    /// Makes ready for the cells of another patch.
    pub(crate) fn start(&mut self) {
        self.forms.clear();
    }

    /// Judges the cell last [looked at](Self::look).
    pub(crate) fn judge(
        &mut self,
        tree: &Tree,
        patch: &Patch,
        poles: &Poles,
        target: &Target,
        cell: &Cell,
    ) -> Verdict {
        let corners = cell.corners.map(|c| &tree.vertices[c as usize]);
        let bounds = bounds(&corners);
        self.take(patch, bounds);
        let verdict = self.judge_taken(tree, patch, poles, target, cell, (corners, bounds));
        if let (Verdict::Cut(cut @ (Cut::Even | Cut::Odd)), false) = (&verdict, self.strict) {
            // The first of the halves has the first corner of the edges that are cut.
            let first = usize::from(*cut == Cut::Odd);
            let [from, to] = [corners[first].at, corners[first + 1].at];
            let direction = usize::from(from[0] == to[0]);
            self.forms.halve(direction, from[direction] > to[direction]);
        }
        verdict
    }

    fn judge_taken(
        &mut self,
        tree: &Tree,
        patch: &Patch,
        poles: &Poles,
        target: &Target,
        cell: &Cell,
        (corners, bounds): ([&Vertex; 4], [[f64; 2]; 2]),
    ) -> Verdict {
        // Where both opposite edges are cut, cutting the cell adds no vertex.
        let cut = cell.edges.map(|edge| tree.middle(edge).is_some());
        if cut[0] && cut[2] {
            return Verdict::Cut(Cut::Even);
        }
        if cut[1] && cut[3] {
            return Verdict::Cut(Cut::Odd);
        }
        let view = self.view(tree, cell, corners, bounds);
        // Whichever way such a cell is triangulated, it is far from the target.
        let far = |k: usize| view.bends[k] > if cut[k] { HOPELESS } else { HOPELESS_EDGE } * target.chord;
        if (0..4).any(far) && !view.tiny && self.hugging_view(patch, &view, target).is_none() {
            return self.divide(tree, cell, &view, target);
        }
        let costs =
            Costs { form: self.forms.now(), ranges: view.ranges, vertices: &tree.vertices, poles, target };
        // What could be cut, and is not near enough by its edge alone, need not be triangulated where no way would do.
        if !self.triangulation.choose(&costs, view.whole.is_none() && !view.tiny) {
            return self.divide(tree, cell, &view, target);
        }
        self.settle(tree, patch, poles, target, cell, &view)
    }

    /// Judges the triangles last chosen, of the same cell in another state.
    pub(crate) fn check(
        &mut self,
        tree: &Tree,
        patch: &Patch,
        poles: &Poles,
        target: &Target,
        cell: &Cell,
    ) -> Verdict {
        let corners = cell.corners.map(|c| &tree.vertices[c as usize]);
        let bounds = bounds(&corners);
        self.take(patch, bounds);
        let view = self.view(tree, cell, corners, bounds);
        self.triangulation.move_on();
        self.settle(tree, patch, poles, target, cell, &view)
    }

    /// Takes the form of a cell.
    fn take(&mut self, patch: &Patch, [low, high]: [[f64; 2]; 2]) {
        if self.strict {
            // The patch is another one in each state.
            self.forms.clear();
            self.hull.clone_from(&patch.net);
            restrict(&mut self.hull, patch.rows, patch.columns, low, high);
        }
        self.forms.take(patch, low, high);
    }

    /// The cell last taken. (It is where it is needed at once: a view is too large to be handed over.)
    #[inline(always)]
    fn view<'t>(
        &mut self,
        tree: &Tree,
        cell: &Cell,
        corners: [&'t Vertex; 4],
        [low, high]: [[f64; 2]; 2],
    ) -> View<'t> {
        let tiny = (0..2).any(|k| high[k] - low[k] < SMALLEST);
        self.forms.arrange();
        let ranges = self.forms.now().across(&crossing(&corners), &corners[0].point);
        let bends = [0, 1, 2, 3].map(|k| ranges.along(corners[k].at, corners[(k + 1) % 4].at));
        let whole = whole_edge(tree, cell, &corners, low, high);
        View { corners, low, high, tiny, ranges, bends, whole }
    }

    fn hugging_view(&mut self, patch: &Patch, view: &View<'_>, target: &Target) -> Option<f64> {
        let View { corners, low, high, whole, .. } = view;
        whole.and_then(|k| self.hugging(patch, corners, k, [*low, *high], target.chord))
    }

    /// What the chosen triangles come to.
    fn settle(
        &mut self,
        tree: &Tree,
        patch: &Patch,
        poles: &Poles,
        target: &Target,
        cell: &Cell,
        view: &View<'_>,
    ) -> Verdict {
        let mut error = self.certify(patch, &tree.vertices, poles, target);
        if error.is_nan() || error > target.chord {
            error = self.hugging_view(patch, view, target).unwrap_or(error);
        }
        if error.is_nan() || error > target.chord {
            error = self.level(patch, &tree.vertices, view, target.chord).unwrap_or(error);
        }
        if (error.is_nan() || error > target.chord) && !view.tiny {
            return self.divide(tree, cell, view, target);
        }
        if let Some(cut) = turn(tree, cell, &view.corners, poles, target).filter(|_| !view.tiny) {
            return Verdict::Cut(cut);
        }
        Verdict::Meets { error }
    }

    /// The certified distance of the chosen triangles from the surface, or of the first found to be too far.
    ///
    /// A point of the patch is within `N` of its triangle's plane, and its foot there is within `T` of the triangle
    /// where the patch's edges are within `T` of the triangle's (measured in the plane): what is bounded by curves in
    /// a convex set is in that set. That takes a patch that does not turn over, seen along the normal; where the normals at
    /// the corners say otherwise, the whole distance between points of equal parameters is bounded instead.
    fn certify(&self, patch: &Patch, vertices: &[Vertex], poles: &Poles, target: &Target) -> f64 {
        let mut worst = 0.0_f64;
        let (triangles, form) = (&self.triangulation.triangles, self.forms.now());
        for (index, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.corners.map(|k| &vertices[k as usize]);
            let same = poles.same([a.at, b.at, c.at]);
            let Plane { normal, error: across } = match same.iter().filter(|s| **s).count() {
                0 => triangle.plane.unwrap_or_else(|| Plane::of([a, b, c], form)),
                1 => match self.triangulation.neighbour(vertices, index, poles) {
                    // The triangle is an edge only, which its neighbour has too: what belongs to it is near that one.
                    Some(normal) => Plane::with([a, b, c], form, normal),
                    None => continue,
                },
                _ => continue,
            };
            if across > target.chord {
                return across;
            }
            let turned = [a, b, c].iter().any(|v| v.normal.dot(&normal) <= 0.0 && poles.key(v.at).is_none());
            let error = if turned || self.strict && !self.unfolded(patch, [a, b, c], &normal) {
                let along = leg(a, b).or_else(|| leg(a, c)).unwrap_or_default();
                let more = [along, normal.cross(&along)].map(|d| form.across(&d, &a.point));
                // Along an edge the interpolation is exact at its ends only: all three directions count in full.
                let slack = |k: usize| more[k].triangle([a.at, b.at, c.at]);
                Vector::new(across, slack(0), slack(1)).norm()
            } else {
                let mut within = 0.0_f64;
                for (k, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
                    if !same[k] {
                        let side = normal.cross(&(to.point - from.point));
                        within = more(within, form.along(&side, &from.point, from.at, to.at));
                    }
                }
                (across * across + within * within).sqrt()
            };
            worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        }
        worst
    }

    /// How far the chosen triangles are from the cell, and back, where both are nearly in one plane, if that is within `limit`: a certificate that does not mind how the
    /// patch runs within that plane, where a triangle's own image may reach over the diagonal to its neighbour.
    ///
    /// Seen along the plane's normal the patch nowhere turns over, and no triangle does. So both cover, as often, what their borders wind around; and
    /// these are the chords of the cell's edges and the edges, which are within `T` of one another at equal shares. What is further than `T` from the one border is wound
    /// around as often by the other: a point of either is within `T` of the other, in the plane, and across it within what both are apart at most.
    fn level(&mut self, patch: &Patch, vertices: &[Vertex], view: &View<'_>, limit: f64) -> Option<f64> {
        let normal = crossing(&view.corners).try_normalize(0.0)?;
        // Not the patch, nor the room for its points, before its corners say that it may be.
        let origin = view.corners[0].point;
        if !view.corners.iter().all(|c| normal.dot(&(c.point - origin)).abs() <= limit) {
            return None;
        }
        self.hull.clone_from(&patch.net);
        restrict(&mut self.hull, patch.rows, patch.columns, view.low, view.high);
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for h in &self.hull {
            let height = normal.dot(&(project(h) - origin));
            if !height.is_finite() {
                return None;
            }
            (low, high) = (less(low, height), more(high, height));
        }
        if high - low > limit {
            return None;
        }
        let stands = |triangle: &Triangle| {
            let [a, b, c] = triangle.corners.map(|k| vertices[k as usize].point);
            (b - a).cross(&(c - a)).dot(&normal) > 0.0
        };
        let [a, b, c, _] = view.corners;
        if !self.triangulation.triangles.iter().all(stands) || !self.unfolded(patch, [a, b, c], &normal) {
            return None;
        }
        let mut within = 0.0_f64;
        for (from, to) in self.triangulation.border() {
            let (from, to) = (&vertices[from as usize], &vertices[to as usize]);
            let along = leg(from, to)?;
            let off = [normal.cross(&along), along]
                .map(|way| self.forms.now().along(&way, &from.point, from.at, to.at));
            within = more(within, off[0].hypot(off[1]));
        }
        let error = (high - low).hypot(within);
        (error <= limit).then_some(error)
    }

    /// Whether the cell, seen along the normal of a triangle, nowhere turns over: the Jacobian of `(F / W, G / W)`, which are its
    /// coordinates along two axes in the triangle's plane, is
    ///
    /// ```text
    /// | F  F_u  F_v |
    /// | G  G_u  G_v | / W³
    /// | W  W_u  W_v |
    /// ```
    ///
    /// and all nine lie between the least and the largest of their Bézier coefficients over the cell.
    fn unfolded(&self, patch: &Patch, [a, b, c]: [&Vertex; 3], normal: &Vector) -> bool {
        let along = leg(a, b).or_else(|| leg(a, c)).unwrap_or_default();
        let (axes, origin) = ([&along, &normal.cross(&along)], &a.point);
        let (rows, columns) = (patch.rows, patch.columns);
        let of = |axis: Option<&Vector>, k: usize| {
            let h = &self.hull[k];
            axis.map_or(h[3], |e| e.dot(&(xyz(h) - origin * h[3])))
        };
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)])
        };
        let row = |axis: Option<&Vector>| {
            let all = 0..rows * columns;
            [
                range(&mut all.clone().map(|k| of(axis, k))),
                range(&mut (0..(rows - 1) * columns).map(|k| of(axis, k + columns) - of(axis, k))),
                range(&mut all.filter(|k| (k + 1) % columns > 0).map(|k| of(axis, k + 1) - of(axis, k))),
            ]
        };
        let [f, g, w] = [row(Some(axes[0])), row(Some(axes[1])), row(None)];
        let times = |a: [f64; 2], b: [f64; 2]| {
            let all = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
            range(&mut all.into_iter())
        };
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[1], a[1] - b[0]];
        let plus = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let minor = |a: &[[f64; 2]; 3], b: &[[f64; 2]; 3]| minus(times(a[1], b[2]), times(a[2], b[1]));
        let [low, high] = if patch.rational {
            let all = [times(w[0], minor(&f, &g)), times(f[0], minor(&g, &w)), times(g[0], minor(&w, &f))];
            plus(plus(all[0], all[1]), all[2])
        } else {
            minor(&f, &g)
        };
        low > 0.0 || high < 0.0
    }

    /// Which way to cut a cell: across the edges along which it bends more. Where that is all one (a twist), across the
    /// longer ones. Where what bends out of the plane is no reason to cut, what bends within it is, and at last what
    /// runs unevenly along the edges.
    fn divide(&self, tree: &Tree, cell: &Cell, view: &View<'_>, target: &Target) -> Verdict {
        let View { corners, ranges, mut bends, .. } = *view;
        let length = |a: usize, b: usize| (corners[a].point - corners[b].point).norm();
        let long = [length(0, 1) + length(2, 3), length(1, 2) + length(3, 0)];
        let most = |bends: &[f64; 4]| bends.iter().copied().fold(0.0, f64::max);
        let diagonal = |a: usize, b: usize| ranges.along(corners[a].at, corners[b].at);
        let diagonal = diagonal(0, 2).max(diagonal(1, 3));
        let twist = most(&bends) < 0.25 * diagonal;
        if most(&bends).max(diagonal) <= target.chord {
            let normal = crossing(&corners);
            for across in [true, false] {
                for (k, bend) in bends.iter_mut().enumerate() {
                    let (from, to) = (corners[k], corners[(k + 1) % 4]);
                    let along = leg(from, to).unwrap_or_default();
                    let direction = if across { normal.cross(&along) } else { along };
                    let within = self.forms.now().along(&direction, &from.point, from.at, to.at);
                    *bend = (*bend * *bend + within * within).sqrt();
                }
                if most(&bends) > target.chord {
                    break;
                }
            }
        }
        let bend = [bends[0].max(bends[2]), bends[1].max(bends[3])];
        let even = if twist || most(&bends) == 0.0 { long[0] >= long[1] } else { bend[0] >= bend[1] };
        Verdict::Cut(allowed(tree, cell, if even { Cut::Even } else { Cut::Odd }))
    }

    /// How far a cell that is thin along its edge `k` is from that edge's chord, and back, if that is within `limit`: a
    /// certificate that does not mind how the patch turns there, so that an edge of the surface never has to be cut finer
    /// than its own data asks.
    ///
    /// Every point of the cell is within `R` of the chord (the hulls of control points, strip by strip); so are the
    /// corners of its triangles, which are such points, and what is between them. Every point of the chord is within
    /// `r` of the edge itself, whose foot runs over all of the chord. So mesh and patch are within `R + r` of each other.
    /// As the cell gets thin, `R` tends to `r`, which is less than half the tolerance.
    fn hugging(
        &mut self,
        patch: &Patch,
        corners: &[&Vertex; 4],
        k: usize,
        [low, high]: [[f64; 2]; 2],
        limit: f64,
    ) -> Option<f64> {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let chord = Chord { from: a.point, to: b.point, reach: limit, half: 0.0 };
        let along = usize::from(a.at[0] == b.at[0]);
        let at_end = a.at[1 - along] > low[1 - along];
        let (rows, columns) = (patch.rows, patch.columns);
        let (mut all, mut own) = (0.0_f64, 0.0_f64);
        for strip in 0..STRIPS {
            let at = |s: u32| low[along] + (high[along] - low[along]) * f64::from(s) / f64::from(STRIPS);
            let (mut from, mut to) = (low, high);
            (from[along], to[along]) = (at(strip), at(strip + 1));
            self.strip.clone_from(&patch.net);
            restrict(&mut self.strip, rows, columns, from, to);
            for (index, h) in self.strip.iter().enumerate() {
                let distance = chord.distance(&project(h));
                if distance.is_nan() || distance > limit {
                    return None;
                }
                all = all.max(distance);
                let (place, count) =
                    if along == 0 { (index % columns, columns) } else { (index / columns, rows) };
                if place == if at_end { count - 1 } else { 0 } {
                    own = own.max(distance);
                }
            }
        }
        (all + own <= limit).then_some(all + own)
    }
}

/// The cut that a cell needs because normals at the ends of an edge differ by more than the angle. Edges no longer
/// than twice the chord tolerance are left alone: what turns there is smaller than what the tolerance lets go.
fn turn(tree: &Tree, cell: &Cell, corners: &[&Vertex; 4], poles: &Poles, target: &Target) -> Option<Cut> {
    if target.angle >= std::f64::consts::PI {
        return None;
    }
    let mut turns = [0.0_f64; 2];
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let known = |v: &Vertex| v.normal != Vector::zeros() && poles.key(v.at).is_none();
        if known(a) && known(b) && (a.point - b.point).norm() > 2.0 * target.chord {
            turns[k % 2] = turns[k % 2].max(angle(&a.normal, &b.normal));
        }
    }
    let worst = turns[0].max(turns[1]);
    // Rounding must not decide where the angle is met exactly.
    if worst <= target.angle * (1.0 + 1e-9) {
        return None;
    }
    let wish = if turns[0] >= turns[1] { Cut::Even } else { Cut::Odd };
    let cut = allowed(tree, cell, wish);
    // Where an edge must stay whole, cells along it are cut towards it, but not without end.
    let length = |a: usize, b: usize| (corners[a].point - corners[b].point).norm();
    let long = [length(0, 1).max(length(2, 3)), length(1, 2).max(length(3, 0))];
    let (along, over) = if wish == Cut::Even { (long[0], long[1]) } else { (long[1], long[0]) };
    (cut == wish || over > 0.25 * along).then_some(cut)
}

/// The only edge of a cell that must stay whole, where the cell's box is no wider than it.
fn whole_edge(
    tree: &Tree,
    cell: &Cell,
    corners: &[&Vertex; 4],
    low: [f64; 2],
    high: [f64; 2],
) -> Option<usize> {
    let mut blocked = (0..4).filter(|&k| tree.blocked(cell.edges[k]));
    let k = blocked.next().filter(|_| blocked.next().is_none())?;
    let (a, b) = (corners[k].at, corners[(k + 1) % 4].at);
    let along = usize::from(a[0] == b[0]);
    let ends = [a[along].min(b[along]), a[along].max(b[along])];
    (ends == [low[along], high[along]]).then_some(k)
}

/// The wished cut, or the next best that leaves whole what must stay whole.
fn allowed(tree: &Tree, cell: &Cell, wish: Cut) -> Cut {
    let blocked = cell.edges.map(|edge| tree.blocked(edge));
    let (even, odd) = (!blocked[0] && !blocked[2], !blocked[1] && !blocked[3]);
    match (wish, even, odd) {
        (Cut::Even, true, _) | (_, true, false) => Cut::Even,
        (_, _, true) => Cut::Odd,
        _ if blocked.iter().filter(|b| **b).count() == 2 => {
            // Two neighbouring edges: k is the corner where they meet, edges k and k - 1.
            Cut::Corner((0..4).find(|&k| blocked[k] && blocked[(k + 3) % 4]).unwrap_or(0))
        }
        _ => Cut::Inset,
    }
}
