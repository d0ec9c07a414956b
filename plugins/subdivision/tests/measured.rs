//! Areas and volumes by the nets of cells: those that rows give, and those of the surface.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_area_volume::{surface_area_of, volume, volume_of};
use loftsman_kernel::functional::{Functional, Shapes, value_of};
use loftsman_kernel::shape::{Cell, Cells, Derivative, Domain, Hole, Location, Shape, Stencil};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Result, Vector};
use loftsman_subdivision::catmull_clark::{limit_points, refine};
use loftsman_subdivision::doo_sabin::DooSabinSurface;
use loftsman_subdivision::{Cage, SubdivisionSurface};

use crate::shapes::{cube, double_fan, noise, quadratic_torus, rowed, tetrahedron, torus};

/// A surface that does not say the nets of its cells.
#[derive(Debug, Clone)]
struct ByRows<S>(S);

impl<S: Shape + Clone> Shape for ByRows<S> {
    fn control_vertices(&self) -> &[Point] {
        self.0.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.0.control_vertices_mut()
    }

    fn stencil(&self, at: Location, by: Derivative) -> Result<Stencil> {
        self.0.stencil(at, by)
    }

    fn domain(&self) -> Domain {
        self.0.domain()
    }

    fn faces(&self) -> Option<usize> {
        self.0.faces()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }
}

impl<S: Shape> Cells for ByRows<S> {
    fn count(&self) -> usize {
        self.0.cells().unwrap().count()
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        self.0.cells()?.cell(index)
    }

    fn holes(&self) -> Vec<Hole> {
        self.0.cells().unwrap().holes()
    }
}

/// The volume as an edit takes it: by rows that are kept.
fn kept(shape: &dyn Shape) -> f64 {
    let shapes = Shapes::one(shape);
    let bound = volume().bind(&shapes).unwrap().unwrap();
    let mut out = [0.0];
    value_of(bound.as_ref(), &shapes, &mut out).unwrap();
    out[0]
}

fn agree<S: Shape + Clone>(surface: &S, what: &str) {
    let (found, rows) = (volume_of(surface).unwrap(), kept(surface));
    assert!((found - rows).abs() <= 1e-13 * rows.abs(), "{what}: {found} {rows}");
    let (found, rows) =
        (surface_area_of(surface).unwrap(), surface_area_of(&ByRows(surface.clone())).unwrap());
    assert!((found - rows).abs() <= 1e-13 * rows, "{what}: {found} {rows}");
}

fn moved(cage: &Cage, by: Vector) -> Cage {
    let mut cage = cage.clone();
    cage.points_mut().iter_mut().for_each(|p| *p += by);
    cage
}

/// Every kind of extraordinary point, creases, corners and knot intervals, and a place away from the origin.
#[test]
fn nets_and_rows_say_the_same() {
    let sharp = cube().with_crease(0, 2, 2.5).unwrap().with_corner(7, f64::INFINITY).unwrap();
    let fine = refine(&cube()).unwrap();
    let uneven = rowed(&fine, |row| 1.0 + 0.5 * noise(row));
    let all = [
        ("cube", cube()),
        ("sharp cube", sharp),
        ("tetrahedron", tetrahedron()),
        ("double fan", double_fan(7, 0.1)),
        ("torus", torus(&[1.0; 5], &[1.0; 6]).0),
        ("intervals", uneven),
        ("far away", moved(&double_fan(5, 0.1), Vector::new(100.0, -70.0, 30.0))),
    ];
    for (what, cage) in all {
        agree(&SubdivisionSurface::new(cage).unwrap(), what);
    }
    for (what, cage) in
        [("tetrahedron", tetrahedron()), ("cube", cube()), ("fan", refine(&double_fan(6, 0.1)).unwrap())]
    {
        agree(&DooSabinSurface::new(cage).unwrap(), what);
    }
}

/// A regular cage round a torus is a periodic spline, whose integrals go another way.
#[test]
fn a_regular_torus_is_its_spline() {
    let spans = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    // Where they turn back over themselves their normals nearly vanish (to 3e-4 of the mean): such areas are told to a part of 1e-7.
    let close = |shape: &dyn Shape, spline: &Surface| {
        let of = |shape: &dyn Shape| [volume_of(shape).unwrap().abs(), surface_area_of(shape).unwrap()];
        for ((found, wanted), within) in of(shape).into_iter().zip(of(spline)).zip([1e-13, 1e-7]) {
            assert!((found - wanted).abs() < within * wanted, "{found} {wanted}");
        }
    };
    let (cage, spline) = torus(&spans, &spans[1..]);
    close(&SubdivisionSurface::new(cage).unwrap(), &spline);
    let (cage, spline) = quadratic_torus(&spans, &spans[1..]);
    close(&DooSabinSurface::new(cage).unwrap(), &spline);
}

/// Triangles on a ball that is not quite round: `8 · 4^levels` of them, more than 4096 pieces from the first level on.
fn triangles(levels: u32) -> Cage {
    let unit = [Vector::x(), Vector::y(), Vector::z()];
    let mut points: Vec<Vector> = unit.iter().flat_map(|v| [*v, -v]).collect();
    let mut faces = Vec::new();
    for k in 0..8_usize {
        let [a, b, c] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2)];
        faces.push(if k.count_ones().is_multiple_of(2) { vec![a, b, c] } else { vec![a, c, b] });
    }
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for face in &faces {
            let middle: Vec<usize> = (0..3)
                .map(|k| {
                    let (a, b) = (face[k], face[(k + 1) % 3]);
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        points.push((points[a] + points[b]).normalize());
                        points.len() - 1
                    })
                })
                .collect();
            finer.extend((0..3).map(|k| vec![face[k], middle[k], middle[(k + 2) % 3]]));
            finer.push(middle);
        }
        faces = finer;
    }
    let rough = |(k, p): (usize, &Vector)| Point::from(p * (1.0 + 0.05 * noise(k as u64)));
    Cage::new(points.iter().enumerate().map(rough).collect(), &faces).unwrap()
}

/// Area and volume of quads whose corners are on the surface, each as four triangles round its middle.
fn of_limits(cage: &Cage) -> [f64; 2] {
    let limits = limit_points(cage).unwrap();
    let (mut area, mut volume) = (0.0, 0.0);
    for face in 0..cage.topology().face_count() {
        let corners: Vec<Vector> =
            cage.topology().face(face).iter().map(|&v| limits[v as usize].coords).collect();
        let middle = corners.iter().sum::<Vector>() / corners.len() as f64;
        for k in 0..corners.len() {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            area += 0.5 * (a - middle).cross(&(b - middle)).norm();
            volume += middle.dot(&a.cross(&b)) / 6.0;
        }
    }
    [area, volume]
}

/// A cage of triangles, against explicit refinement: points on the surface, level by level, extrapolated. What is left out is within its bounds.
#[test]
fn triangles_are_measured_as_their_refinements() {
    let cage = triangles(2);
    let surface = SubdivisionSurface::new(cage.clone()).unwrap();
    assert!(Cells::count(&surface) > 4096);
    let mut finer = cage;
    let mut levels = Vec::new();
    for _ in 0..5 {
        finer = refine(&finer).unwrap();
        levels.push(of_limits(&finer));
    }
    let found = [surface_area_of(&surface).unwrap(), volume_of(&surface).unwrap()];
    let left = surface.left_out().unwrap();
    for (k, (found, left)) in found.into_iter().zip([left.area, left.volume]).enumerate() {
        let [a, b, c] = [2, 3, 4].map(|level| levels[level][k]);
        let [coarse, fine] = [b + (b - a) / 3.0, c + (c - b) / 3.0];
        // What extrapolation is off by is less than its last change.
        let slack = (fine - coarse).abs();
        assert!(slack < 2e-5 * fine, "{slack:e}");
        assert!((found - fine).abs() <= slack + left, "{k}: {found} {fine} {slack:e} {left:e}");
        assert!(left < 1e-3 * fine);
    }
}

/// Runs side by side are the same to the last bit, whichever is ready first.
#[test]
fn measures_are_the_same_every_time() {
    let surface = SubdivisionSurface::new(triangles(2)).unwrap();
    let both = || [surface_area_of(&surface).unwrap(), volume_of(&surface).unwrap()].map(f64::to_bits);
    let first = both();
    assert!((0..4).all(|_| both() == first));
    let again = SubdivisionSurface::new(triangles(2)).unwrap();
    assert_eq!(volume_of(&again).unwrap().to_bits(), first[1]);
}

/// Stretch and bend of a regular cage are those of the spline that it is, whatever the number of its faces, and of cages twice as fine almost the same: a shift of the
/// whole is as cheap beside bending.
#[test]
fn metrics_of_cages_are_those_of_splines() {
    let form = |shape: &dyn Shape, order: usize| {
        let matrix = shape.smoothness(order).unwrap();
        let x: Vec<f64> = shape.control_vertices().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let mut image = vec![0.0; x.len()];
        matrix.multiply(&x, 3, &mut image);
        // What is added so that the form is definite: a part of the mean diagonal.
        let trace: f64 = (0..matrix.size()).map(|k| matrix.entry(k, k)).sum();
        let added = 1e-9 * trace / matrix.size() as f64 * x.iter().map(|x| x * x).sum::<f64>();
        (x.iter().zip(&image).map(|(a, b)| a * b).sum::<f64>(), added)
    };
    let mut forms = Vec::new();
    for n in [6, 12, 24] {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        let torus = |k: usize| {
            let (a, b) = (angle(k / n), angle(k % n));
            let r = 3.0 + b.cos();
            Point::new(r * a.cos(), r * a.sin(), b.sin())
        };
        let points: Vec<Point> = (0..n * n).map(torus).collect();
        let mut cage = crate::shapes::grid(n, n, [true, true], 0.0);
        cage.points_mut().copy_from_slice(&points);
        let surface = SubdivisionSurface::new(cage).unwrap();
        let space = Space::periodic_uniform(3, n).unwrap();
        let spline = Surface::new(space.clone(), space, points).unwrap();
        let own = [1, 2].map(|order| form(&surface, order)).map(|(sum, added)| sum - added);
        for (k, a) in own.iter().enumerate() {
            let (b, _) = form(&spline, k + 1);
            assert!((a / b - 1.0).abs() < 1e-10, "{n}, order {}: {a} {b}", k + 1);
        }
        forms.push(own);
    }
    for k in 0..2 {
        let (coarse, fine) = (forms[1][k], forms[2][k]);
        assert!((coarse / fine - 1.0).abs() < 0.2, "{coarse} {fine}");
    }
}
