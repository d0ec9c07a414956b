//! The limit surface edited, dragged, faired and measured.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use loftsman_area_volume::{surface_area, volume, volume_of};
use loftsman_fairing::{Fair, bend};
use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::functional::{Functional, Shapes, normal, position, symmetry};
use loftsman_kernel::shape::{Chart, Derivative, Location, Shape, cells_of};
use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::{Cage, SubdivisionSurface};

fn area_of(surface: &dyn Shape) -> f64 {
    let mut out = [0.0];
    surface_area().value(&Shapes::one(surface), &mut out).unwrap();
    out[0]
}

fn at(surface: &dyn Shape, vertex: u32, by: [usize; 2]) -> Vector {
    surface.value(Location::Vertex(vertex), Derivative::from(by)).unwrap()
}

fn value(surface: &dyn Shape, at: Location, by: [usize; 2]) -> Vector {
    surface.value(at, Derivative::from(by)).unwrap()
}

#[test]
fn a_limit_is_moved_with_its_normal_and_the_volume_kept() {
    let surface = SubdivisionSurface::new(refine(&crate::shapes::cube()).unwrap()).unwrap();
    let before = at(&surface, 7, [0, 0]);
    let wanted = Point::from(before + Vector::new(0.05, -0.02, 0.03));
    let facing = |s: &SubdivisionSurface| at(s, 7, [1, 0]).cross(&at(s, 7, [0, 1])).normalize();
    let was = volume_of(&surface).unwrap();
    let edited = Edit::new(&surface)
        .ask(position(Location::Vertex(7)).to(wanted))
        .ask(normal(Location::Vertex(7), facing(&surface)).hold())
        .ask(volume().keep())
        .solve()
        .unwrap();
    let after = edited.shape();
    assert!((at(after, 7, [0, 0]) - wanted.coords).norm() < 1e-12);
    assert!((facing(after) - facing(&surface)).norm() < 1e-12);
    assert!((volume_of(after).unwrap() / was - 1.0).abs() < 1e-9);
}

#[test]
fn falloff_moves_what_is_near() {
    let surface = SubdivisionSurface::new(crate::shapes::grid(9, 9, [false, false], 0.0)).unwrap();
    let edited = Edit::new(&surface)
        .metric(Metric::Falloff(3.0))
        .ask(position(Location::Vertex(40)).by(Vector::z()))
        .solve()
        .unwrap();
    let after = edited.shape();
    assert!((at(after, 40, [0, 0]) - at(&surface, 40, [0, 0]) - Vector::z()).norm() < 1e-12);
    let lift = |v: usize| (after.control_vertices()[v] - surface.control_vertices()[v]).norm();
    assert!(lift(40) > lift(41) && lift(41) >= lift(42) && lift(0) < 1e-12);
}

/// OpenSubdiv's issue 1202: points interpolated by limits, fairly.
#[test]
fn fair_interpolation() {
    let twice = |cage: &Cage| refine(&refine(cage).unwrap()).unwrap();
    fairly_interpolated("a cube", refine(&crate::shapes::cube()).unwrap());
    fairly_interpolated("five edges", twice(&crate::shapes::wild::prism(5).cage().unwrap()));
    fairly_interpolated("seven edges", twice(&crate::shapes::double_fan(7, 0.1)));
}

fn fairly_interpolated(name: &str, cage: Cage) {
    let surface = SubdivisionSurface::new(cage).unwrap();
    let wanted: Vec<(u32, Point)> = [0, 3, 5, 7, 9, 14, 21]
        .into_iter()
        .map(|v| (v, Point::from(at(&surface, v, [0, 0]) * (1.2 + 0.2 * crate::shapes::noise(u64::from(v))))))
        .collect();
    let fair = wanted.iter().fold(Fair::new(&surface).energy(bend()), |fair, &(v, p)| {
        fair.ask(position(Location::Vertex(v)).to(p))
    });
    let fair = fair.solve().unwrap();
    let least = wanted
        .iter()
        .fold(Edit::new(&surface), |edit, &(v, p)| edit.ask(position(Location::Vertex(v)).to(p)))
        .solve()
        .unwrap();
    for s in [fair.shape(), least.shape()] {
        for (v, p) in &wanted {
            assert!((at(s, *v, [0, 0]) - p.coords).norm() < 1e-10);
        }
    }
    // The optimum by itself: the quadratic form by quadrature of our own, the equations of Lagrange solved densely.
    let topology = surface.cage().topology();
    let form = thin_plate(
        &surface,
        |face| {
            let corners = topology.face(surface.cage_face(face).unwrap().0);
            let odd: Vec<usize> = (0..4).filter(|&k| topology.valence(corners[k] as usize) != 4).collect();
            match odd[..] {
                [] => None,
                [corner] => Some([(0, 0), (1, 0), (1, 1), (0, 1)][corner]),
                _ => panic!("at most one extraordinary corner a face is needed"),
            }
        },
        &gauss(4, 2),
    );
    let n = form.len();
    let rows: Vec<Vec<f64>> = wanted
        .iter()
        .map(|&(v, _)| {
            let mut row = vec![0.0; n];
            let stencil = surface.stencil(Location::Vertex(v), Derivative::POSITION).unwrap();
            stencil.iter().for_each(|(k, c)| row[k] += c);
            row
        })
        .collect();
    let places: Vec<Vector> = wanted.iter().map(|(_, p)| p.coords).collect();
    let best = least_by(&form, &rows, &places);
    let energy = |vertices: &dyn Fn(usize) -> Vector| -> f64 {
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs.map(|(i, j)| form[i][j] * vertices(i).dot(&vertices(j))).sum()
    };
    let of = |s: &SubdivisionSurface| {
        let points = s.control_vertices().to_vec();
        energy(&|k| points[k].coords)
    };
    let (a, b, c) = (of(fair.shape()), of(least.shape()), energy(&|k| best[k]));
    assert!((a - c).abs() < 1e-10 * c && a < b, "{name}: {a} {b} {c}");
    let off = |k: usize| (fair.shape().control_vertices()[k].coords - best[k]).norm();
    let off = (0..n).map(off).fold(0.0, f64::max);
    assert!(off < 1e-8, "{name}: {off:e}");
}

/// What makes a quadratic form least of all that have given values of some rows: the equations of Lagrange, solved densely.
pub(crate) fn least_by(form: &[Vec<f64>], rows: &[Vec<f64>], wanted: &[Vector]) -> Vec<Vector> {
    let n = form.len();
    let largest = form.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let size = n + rows.len();
    let mut matrix = vec![vec![0.0; size + 3]; size];
    for i in 0..n {
        (0..n).for_each(|j| matrix[i][j] = form[i][j] / largest);
        for (k, row) in rows.iter().enumerate() {
            (matrix[i][n + k], matrix[n + k][i]) = (row[i], row[i]);
        }
    }
    for (k, p) in wanted.iter().enumerate() {
        (0..3).for_each(|axis| matrix[n + k][size + axis] = p[axis]);
    }
    let mut best = solved(matrix);
    best.truncate(n);
    best
}

/// `∫∫ |S_xx|² + 2 |S_xy|² + |S_yy|²` over all faces but the quadrants of the eighth level at the extraordinary corner of each that has one, as a matrix, by
/// Gauss points in each quadrant; the derivatives are those that solve the equations of the chain rule.
pub(crate) fn thin_plate(
    surface: &dyn Shape,
    extraordinary: impl Fn(u32) -> Option<(i32, i32)>,
    gauss: &[(f64, f64)],
) -> Vec<Vec<f64>> {
    let n = surface.control_vertices().len();
    let mut form = vec![vec![0.0; n]; n];
    let cells = cells_of(surface, "a chart").unwrap();
    for face in 0..surface.faces().unwrap() as u32 {
        let odd = extraordinary(face);
        let (cu, cv) = odd.unwrap_or((0, 0));
        for level in 1..=8_i32 {
            let side = 0.5_f64.powi(level);
            // Counted from the corner: three quadrants of the four there.
            let rest = (level == 8 && odd.is_none()).then_some((0, 0));
            for (i, j) in [(1, 0), (1, 1), (0, 1)].into_iter().chain(rest) {
                for (x, wx) in gauss {
                    for (y, wy) in gauss {
                        let from = |at: i32, x: f64, end: i32| {
                            let t = (f64::from(at) + x) * side;
                            if end == 1 { 1.0 - t } else { t }
                        };
                        let at = Location::Face(face, from(i, *x, cu), from(j, *y, cv));
                        let (rows, area) = second_derivatives(surface, at, cells.chart(at));
                        for (row, share) in rows.iter().zip([1.0, 2.0, 1.0]) {
                            let weight = share * wx * wy * side * side * area;
                            for (k, a) in row {
                                row.iter().for_each(|(l, b)| form[*k][*l] += weight * a * b);
                            }
                        }
                    }
                }
            }
        }
    }
    form
}

/// Places and weights of Gauss's rule of `n` points on each of so many parts of `[0, 1]`: the zeros of Legendre's polynomial by Newton's method.
pub(crate) fn gauss(n: usize, parts: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        (now, n as f64 * (before - x * now) / (1.0 - x * x))
    };
    let own = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..20 {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * legendre(x).1.powi(2)))
    };
    let share = 1.0 / parts as f64;
    (0..parts).flat_map(|i| (0..n).map(own).map(move |(x, w)| (share * (i as f64 + x), share * w))).collect()
}

/// Rows of `f_xx`, `f_xy` and `f_yy`, and the area of the coordinates for that of the parameters; of these where there is no chart.
fn second_derivatives(
    surface: &dyn Shape,
    at: Location,
    chart: Option<Chart>,
) -> ([Vec<(usize, f64)>; 3], f64) {
    let of = |by: [usize; 2]| surface.stencil(at, Derivative::from(by)).unwrap();
    let given = [of([1, 0]), of([0, 1]), of([2, 0]), of([1, 1]), of([0, 2])];
    let Some(Chart { first: [[a, b], [c, d]], second: [p, q, r] }) = chart else {
        return ([2, 3, 4].map(|k| given[k].iter().collect()), 1.0);
    };
    // f_u, f_v, f_uu, f_uv and f_vv of f_x, f_y, f_xx, f_xy and f_yy; one column after another is solved for what a unit of each makes.
    let rule = [
        [a, b, 0.0, 0.0, 0.0],
        [c, d, 0.0, 0.0, 0.0],
        [p[0], p[1], a * a, 2.0 * a * b, b * b],
        [q[0], q[1], a * c, a * d + b * c, b * d],
        [r[0], r[1], c * c, 2.0 * c * d, d * d],
    ];
    let mut rows = [Vec::new(), Vec::new(), Vec::new()];
    for (unit, stencil) in given.iter().enumerate() {
        let side = |k: usize| if k == unit { 1.0 } else { 0.0 };
        let system = (0..5).map(|k| rule[k].iter().copied().chain([side(k), 0.0, 0.0]).collect()).collect();
        let share = solved(system);
        for (k, row) in rows.iter_mut().enumerate() {
            row.extend(stencil.iter().map(|(v, x)| (v, share[2 + k].x * x)));
        }
    }
    (rows, (a * d - b * c).abs())
}

/// The solution of a square system with three right-hand sides behind it, by elimination with the largest pivot of each column.
fn solved(mut rows: Vec<Vec<f64>>) -> Vec<Vector> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap();
        rows.swap(k, pivot);
        let own = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let by = row[k] / own[k];
            if by != 0.0 && i != k {
                row.iter_mut().zip(&own).skip(k).for_each(|(x, o)| *x -= by * o);
            }
        }
    }
    (0..n).map(|k| Vector::new(rows[k][n], rows[k][n + 1], rows[k][n + 2]) / rows[k][k]).collect()
}

/// A torus as a cage and as the kernel's periodic bicubic surface.
#[test]
fn a_grid_is_the_kernels_spline() {
    let (rows, columns) = (8, 6);
    let torus = |k: usize| {
        let [a, b] = [(k / columns, rows), (k % columns, columns)]
            .map(|(i, n)| std::f64::consts::TAU * i as f64 / n as f64);
        let r = 3.0 + b.cos();
        Point::new(r * a.cos(), r * a.sin(), b.sin())
    };
    let points: Vec<Point> = (0..rows * columns).map(torus).collect();
    let mut cage = crate::shapes::grid(rows, columns, [true, true], 0.0);
    cage.points_mut().copy_from_slice(&points);
    let surface = SubdivisionSurface::new(cage).unwrap();
    let spaces = [rows, columns].map(|n| Space::periodic_uniform(3, n).unwrap());
    let [u, v] = spaces;
    let spline = Surface::new(u, v, points).unwrap();
    let (a, b) = (area_of(&surface), area_of(&spline));
    assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
    let (a, b) = (volume_of(&surface).unwrap(), volume_of(&spline).unwrap());
    assert!((a.abs() / b.abs() - 1.0).abs() < 1e-12, "{a} {b}");
    for by in [[0, 0], [1, 0], [1, 1], [0, 2]] {
        let a = value(&surface, Location::Face(0, 0.3, 0.8), by);
        // Vertex (0, 0) has most influence at some knot: it is found among them.
        let near = (0..rows * columns).map(|k| {
            let at = Location::Surface((k / columns) as f64 + 0.3, (k % columns) as f64 + 0.8);
            (value(&spline, at, by) - a).norm()
        });
        assert!(near.fold(f64::INFINITY, f64::min) < 1e-12);
    }
    let [a, b] = [
        Fair::new(&surface)
            .energy(bend())
            .ask(position(Location::Vertex(0)).keep())
            .solve()
            .unwrap()
            .report()
            .energy_before,
        Fair::new(&spline)
            .energy(bend())
            .ask(position([0.0, 0.0]).keep())
            .solve()
            .unwrap()
            .report()
            .energy_before,
    ];
    assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
}

#[test]
fn symmetry_holds_beside_a_move() {
    let surface = SubdivisionSurface::new(refine(&crate::shapes::cube()).unwrap()).unwrap();
    let wanted = at(&surface, 7, [0, 0]) + Vector::new(0.1, 0.0, 0.2);
    let edited = Edit::new(&surface)
        .ask(position(Location::Vertex(7)).to(Point::from(wanted)))
        .ask(symmetry(Vector::x(), Point::new(0.5, 0.5, 0.5)).hold())
        .solve()
        .unwrap();
    let after = edited.shape();
    let mirrored = Vector::new(1.0 - wanted.x, wanted.y, wanted.z);
    assert!((at(after, 7, [0, 0]) - wanted).norm() < 1e-12);
    assert!((at(after, 6, [0, 0]) - mirrored).norm() < 1e-12);
}
