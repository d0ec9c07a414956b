//! Random cages by knot intervals and Doo and Sabin's limits, each against an evaluator that knows nothing of the crate's.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use loftsman_area_volume::surface_area_of;
use loftsman_kernel::conformance::shape_conformance;
use loftsman_kernel::plugin::{Chord, DeclaredShape, Fineness, Splines};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::{limit_points, refine_times};
use loftsman_subdivision::{Cage, SubdivisionSurface, doo_sabin};

use crate::shapes::plain::Plain;
use crate::shapes::wild::{self, Dice};

/// Closed, sharp or open.
fn any(seed: u64) -> Plain {
    let plain = wild::closed(seed);
    match seed % 3 {
        0 => plain,
        1 => wild::sharpened(plain, seed),
        _ => wild::opened(wild::sharpened(plain, seed), seed),
    }
}

fn apart(a: &[Point], b: &[Point]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most: f64, (p, q)| most.max((p - q).norm()))
}

/// The cage with an interval for each edge, and for each end of an edge.
fn with(cage: &Cage, interval: impl Fn(usize, usize) -> f64) -> Cage {
    let topology = cage.topology();
    (0..topology.edge_count()).fold(cage.clone(), |cage, e| {
        let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
        let cage = cage.with_interval(a, b, interval(e, 0)).unwrap();
        cage.with_end_interval(a, b, interval(e, 1)).unwrap().with_end_interval(b, a, interval(e, 2)).unwrap()
    })
}

/// Intervals that are all the same are none, and what counts of those that are not is their ratios.
#[test]
fn only_ratios_of_intervals_count() {
    let mut most = 0.0_f64;
    for seed in 0..150 {
        let plain = any(seed);
        let cage = plain.cage().unwrap();
        let same = with(&cage, |_, _| 1.0);
        // Refinement by hand, in its own order of vertices.
        let by_hand = plain.refined().refined();
        let fine = refine_times(&same, 2).unwrap();
        assert_eq!(fine.points().len(), by_hand.points.len(), "{seed}");
        for p in fine.points() {
            let near = by_hand.points.iter().map(|q| (p.coords - q).norm()).fold(f64::MAX, f64::min);
            assert!(near < 1e-14, "{seed}: {near:e}");
        }
        let (fine, dual) = (doo_sabin::refine_times(&same, 2).unwrap(), plain.dual().dual());
        assert_eq!(fine.points().len(), dual.points.len(), "{seed}");
        for p in fine.points() {
            let near = dual.points.iter().map(|q| (p.coords - q).norm()).fold(f64::MAX, f64::min);
            assert!(near < 1e-14, "{seed}, Doo-Sabin: {near:e}");
        }
        let random =
            |e: usize, k: usize| 3.0_f64.powf(crate::shapes::noise(seed * 1000 + 3 * e as u64 + k as u64));
        let uneven = with(&cage, random);
        for scale in [0.25, 1e-6, 3.7e5] {
            let scaled = with(&cage, |e, k| scale * random(e, k));
            let both = [&uneven, &scaled];
            let [a, b] = both.map(|c| refine_times(c, 2).unwrap());
            most = most.max(apart(a.points(), b.points()));
            let [a, b] = both.map(|c| limit_points(c).unwrap());
            assert!(apart(&a, &b) < 1e-12, "{seed}, {scale}, limits: {:e}", apart(&a, &b));
            let [a, b] = both.map(|c| doo_sabin::refine_times(c, 2).unwrap());
            most = most.max(apart(a.points(), b.points()));
        }
        assert!(most < 1e-13, "{seed}: {most:e}");
        // And they do count.
        assert!(
            apart(refine_times(&uneven, 2).unwrap().points(), refine_times(&same, 2).unwrap().points())
                > 1e-3
        );
    }
}

/// A cubic spline by de Boor's recursion, on the span between knots `k` and `k + 1`; vertex `i` has the knots `i - 2 … i + 2`.
fn de_boor(knot: &dyn Fn(isize) -> f64, vertex: &dyn Fn(isize) -> Vector, k: isize, x: f64) -> Vector {
    let mut p: Vec<Vector> = (k - 1..=k + 2).map(vertex).collect();
    for level in 1..=3 {
        for j in (level..4).rev() {
            // Over vertex `k - 1 + j`.
            let low = knot(k - 3 + j as isize);
            let high = knot(k + 1 + j as isize - level as isize);
            let at = (x - low) / (high - low);
            p[j] = p[j - 1] * (1.0 - at) + p[j] * at;
        }
    }
    p[3]
}

/// An open line of vertices with intervals, continued by its point reflection in either end.
struct Line<'a> {
    intervals: &'a [f64],
}

impl Line<'_> {
    fn interval(&self, k: isize) -> f64 {
        let n = self.intervals.len() as isize;
        // `-1` is `0` again, `n` is `n - 1`.
        let k = if k < 0 { -1 - k } else { k };
        self.intervals[(if k >= n { 2 * n - 1 - k } else { k }) as usize]
    }

    fn knot(&self, k: isize) -> f64 {
        if k >= 0 {
            (0..k).map(|j| self.interval(j)).sum()
        } else {
            -(k..0).map(|j| self.interval(j)).sum::<f64>()
        }
    }

    /// A vertex, also beyond the ends.
    fn reflected(&self, vertex: &dyn Fn(usize) -> Vector, i: isize) -> Vector {
        let last = self.intervals.len() as isize;
        match i {
            i if i < 0 => vertex(0) * 2.0 - vertex((-i) as usize),
            i if i > last => vertex(last as usize) * 2.0 - vertex((2 * last - i) as usize),
            i => vertex(i as usize),
        }
    }

    fn point(&self, vertex: &dyn Fn(usize) -> Vector, span: usize, t: f64) -> Vector {
        let k = span as isize;
        de_boor(&|k| self.knot(k), &|i| self.reflected(vertex, i), k, self.knot(k) + t * self.intervals[span])
    }
}

/// An open sheet with an interval for each row and each column of faces; one of each inside is zero where `with_zeros`.
struct Grid {
    plain: Plain,
    size: [usize; 2],
    intervals: [Vec<f64>; 2],
    surface: SubdivisionSurface,
}

impl Grid {
    fn new(seed: u64, with_zeros: bool, by: f64) -> Self {
        let mut dice = Dice::new(seed + 40_000);
        let size = [4 + dice.below(4), 4 + dice.below(4)];
        let plain = wild::sheet(size[0], size[1], by, &mut dice);
        let mut intervals = size.map(|n| (1..n).map(|_| 4.0_f64.powf(dice.number())).collect::<Vec<f64>>());
        for line in intervals.iter_mut().filter(|_| with_zeros) {
            // Not at an end.
            let k = 1 + dice.below(line.len() - 2);
            line[k] = 0.0;
        }
        let at = |i: usize, j: usize| i * size[1] + j;
        let mut cage = plain.cage().unwrap();
        for i in 0..size[0] {
            for j in 0..size[1] {
                if i + 1 < size[0] {
                    cage = cage.with_interval(at(i, j), at(i + 1, j), intervals[0][i]).unwrap();
                }
                if j + 1 < size[1] {
                    cage = cage.with_interval(at(i, j), at(i, j + 1), intervals[1][j]).unwrap();
                }
            }
        }
        let surface = SubdivisionSurface::new(cage).unwrap_or_else(|e| panic!("{seed}: {e}"));
        Self { plain, size, intervals, surface }
    }

    fn lines(&self) -> [Line<'_>; 2] {
        let [rows, columns] = &self.intervals;
        [Line { intervals: rows }, Line { intervals: columns }]
    }

    fn vertex(&self, i: usize, j: usize) -> Vector {
        self.plain.points[i * self.size[1] + j]
    }

    /// The point of a face, by the spline.
    fn point(&self, [i, j]: [usize; 2], [u, v]: [f64; 2]) -> Vector {
        let [rows, columns] = self.lines();
        rows.point(&|k| columns.point(&|l| self.vertex(k, l), j, v), i, u)
    }

    /// All of it as a spline of the kernel's, with the vertices beyond the sides.
    fn spline(&self) -> Surface {
        let [rows, columns] = self.lines();
        let [u, v] = [&rows, &columns].map(|line| {
            let knots = (-3..=line.intervals.len() as isize + 3).map(|k| line.knot(k)).collect();
            Space::open(3, knots).unwrap()
        });
        let [m, n] = self.size.map(|n| n as isize);
        let at = |i: isize, j: isize| rows.reflected(&|k| columns.reflected(&|l| self.vertex(k, l), j), i);
        let points = (-1..=m).flat_map(|i| (-1..=n).map(move |j| (i, j)));
        Surface::new(u, v, points.map(|(i, j)| Point::from(at(i, j))).collect()).unwrap()
    }
}

/// An open grid with an interval for each row and column of faces is a tensor-product spline that is continued by reflection in its sides; an interval
/// of zero inside is a double knot.
#[test]
fn random_open_grids_are_tensor_product_splines() {
    for seed in 0..120 {
        let grid = Grid::new(seed, seed % 2 == 1, 0.3);
        let [rows, columns] = &grid.intervals;
        for face in 0..rows.len() * columns.len() {
            let (i, j) = (face / columns.len(), face % columns.len());
            assert!(grid.surface.is_regular(face as u32).unwrap(), "{seed}, face {i}, {j}");
            if rows[i] * columns[j] == 0.0 {
                continue;
            }
            for (u, v) in [(0.3, 0.8), (0.0, 0.5), (1.0, 0.25), (0.6, 0.0), (0.9, 1.0)] {
                let wanted = grid.point([i, j], [u, v]);
                let own =
                    grid.surface.value(Location::Face(face as u32, u, v), Derivative::POSITION).unwrap();
                let off = (own - wanted).norm();
                assert!(off < 1e-12, "{seed}, face {i}, {j} at {u}, {v}: {off:e}");
            }
        }
    }
}

/// What has double knots as far as its sides is a shape like any other: its area is the spline's, its triangles are within their tolerance, its splines are
/// all of it, and it is read as it was written.
#[test]
fn open_grids_with_double_knots_are_shapes() {
    for seed in 0..12 {
        let grid = Grid::new(seed + 500, true, 0.1);
        let (surface, spline) = (&grid.surface, grid.spline());
        let area = surface_area_of(&spline).unwrap();
        let own = surface_area_of(surface).unwrap();
        assert!((own / area - 1.0).abs() < 1e-9, "{seed}: {own} {area}");
        assert_eq!(surface.left_out().unwrap().count, 0);
        let fineness = Fineness { chord: Chord::Absolute(0.01), angle: 0.5 };
        let cut = SubdivisionSurface::tessellate(&[surface], &fineness).unwrap();
        assert!(cut.certified && cut.error <= 0.01, "{seed}: {}", cut.error);
        for p in cut.states[0].iter().step_by(7) {
            let near = spline.closest(*p).unwrap().distance;
            assert!(near < 1e-9, "{seed}: {near:e}");
        }
        let Some(Splines::Surfaces(all)) = surface.splines() else { panic!("{seed}: it is all splines") };
        let sum: f64 = all.iter().map(|s| surface_area_of(s).unwrap()).sum();
        assert!((sum / area - 1.0).abs() < 1e-9, "{seed}: {sum} {area}");
        let again = SubdivisionSurface::from_parameters(&surface.fields()).unwrap();
        assert_eq!(surface.cage(), again.cage());
    }
    for seed in 0..40 {
        let grid = Grid::new(seed + 900, true, 0.1);
        let verdict = shape_conformance(&grid.surface);
        assert!(verdict.passed(), "{seed}, {:?}: {verdict}", grid.intervals);
    }
    // A row of zeros at the boundary has no other beyond it.
    let cage = (0..5).try_fold(crate::shapes::grid(5, 5, [false, false], 0.2), |cage, k| {
        cage.with_interval(k, 5 + k, 0.0)
    });
    let error = SubdivisionSurface::new(cage.unwrap()).unwrap_err().to_string();
    assert!(error.contains("knot interval 0") && error.contains("along the boundary"), "{error}");
}

/// The middle of a face is a point of the limit: what twenty refinements by hand make of the face comes to it, and so do those of all faces that are there
/// after two.
#[test]
fn middles_of_faces_are_limits_of_doo_and_sabin() {
    for seed in 0..200 {
        let plain = any(seed);
        let frames = doo_sabin::limit_frames(&plain.cage().unwrap()).unwrap();
        // Faces of faces come first and keep their numbers.
        let fine = plain.dual().dual();
        for (f, frame) in frames.iter().enumerate() {
            let mut face = Plain {
                points: plain.faces[f].iter().map(|&v| plain.points[v]).collect(),
                ..Plain::default()
            };
            face.faces = vec![(0..face.points.len()).collect()];
            for _ in 0..50 {
                face = face.dual();
            }
            let off = face.points.iter().map(|p| (p - frame.point.coords).norm()).fold(0.0, f64::max);
            assert!(off < 1e-13, "{seed}, face {f}: {off:e}");
            let middle = fine.middle(&fine.faces[f]);
            assert!((middle - frame.point.coords).norm() < 1e-14, "{seed}, face {f}");
        }
    }
}

/// Zeros in the first and last rows and columns, which no places between vertices are known of, are clamped ends: what is refined instead, as the refusal advises,
/// comes to the bicubic whose knots there are fourfold.
#[test]
fn zeros_at_the_boundary_are_clamped_ends_of_what_is_refined() {
    for seed in 0..20 {
        let mut dice = Dice::new(seed + 45_000);
        let size = [5 + dice.below(3), 5 + dice.below(3)];
        let plain = wild::sheet(size[0], size[1], 0.2, &mut dice);
        let intervals = size.map(|n| {
            let mut line: Vec<f64> = (1..n).map(|_| 4.0_f64.powf(dice.number())).collect();
            (line[0], line[n - 2]) = (0.0, 0.0);
            line
        });
        let mut cage = plain.cage().unwrap();
        for e in 0..cage.topology().edge_count() {
            let [v, w] = cage.topology().edge(e).unwrap().map(|v| v as usize);
            let (low, columns) = (v.min(w), size[1]);
            let d = if v / columns == w / columns {
                intervals[1][low % columns]
            } else {
                intervals[0][low / columns]
            };
            cage = cage.with_interval(v, w, d).unwrap();
        }
        let refused = SubdivisionSurface::new(cage.clone()).unwrap_err().to_string();
        assert!(
            refused.contains("knot interval 0") && refused.contains("refine the cage instead"),
            "{refused}"
        );
        let [u, v] = intervals.each_ref().map(|line| {
            let mut knots = vec![0.0; 3];
            line.iter().for_each(|d| knots.push(knots[knots.len() - 1] + d));
            // Of a spline that is continued by reflection two more; those of the row of zeros and its own are two already.
            knots.extend([knots[knots.len() - 1]; 2]);
            Space::open(3, knots).unwrap()
        });
        let points = plain.points.iter().map(|p| Point::from(*p)).collect();
        let spline = Surface::new(u, v, points).unwrap();
        for levels in 0..3 {
            for (k, p) in limit_points(&refine_times(&cage, levels).unwrap()).unwrap().iter().enumerate() {
                let off = spline.closest(*p).unwrap().distance;
                assert!(off < 1e-12, "{seed}, level {levels}, vertex {k}: {off:e}");
            }
        }
    }
}
