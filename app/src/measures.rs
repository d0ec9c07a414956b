//! How long, how large and how full a geometry is: the quantities that people ask of it first.

mod leaks;

use std::collections::HashSet;

pub use self::leaks::Leaks;
use loftsman_area_volume::{area_of, surface_area_of, volume_from, volume_of};
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::{Mesh, Polyline};
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::shape::{Cells, Shape};
use loftsman_kernel::spline::{Curve, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::Adaptive;

/// Length, area and volume of a geometry, in its own coordinates. What does not apply is left out when it is serialised.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Measures {
    /// The length of a curve or polyline, or of the loose lines of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// The area of a surface or mesh; of a curve or polyline that is closed and planar, the area inside it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
    /// The volume inside a closed surface, a watertight mesh or the solids of a Brep; negative where it is inside out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<f64>,
    /// Whether a mesh is watertight: along each edge of it as many faces run one way as run the other way; of a surface, whether each of its edges meets
    /// another or is a point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub watertight: Option<bool>,
    /// The edges of a surface where it is open: `u0`, `u1`, `v0`, `v1`, or `border` where loops cut it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<&'static str>,
    /// Where a mesh is not watertight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub leaks: Option<Leaks>,
    /// Where area and volume are those of triangles: how far these are from the shape at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
    /// What was not measured, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unmeasured: Vec<String>,
}

/// The most polynomial pieces of a surface whose area and volume are integrated where each has to be asked for rows.
const CELLS: usize = 4096;
/// The most of a Brep that was edited. A face that goes along with its neighbours is given knots: some five thousand pieces are usual, and triangles tell the
/// volume to a few 10⁻⁴ only.
const EDITED: usize = 1 << 16;
/// The most where the surface says its pieces as they are: of irregular triangles, each face unlike the others, half a minute of processor time.
const NETS: usize = 1 << 20;
/// The most spans of a curve whose area is integrated.
const SPANS: usize = 100_000;

impl Measures {
    /// The measures of a geometry. `O(n)` for curves, polylines and surfaces, by quadrature on every polynomial piece; for
    /// meshes `O(e log e)` in their edges. Points of a mesh that have the same coordinates count as one. Surfaces of more
    /// than 4096 pieces, and those that say them as nets (subdivision surfaces) of more than a million, are not integrated, and it is said with what
    /// to do instead. Breps are measured by their triangles.
    pub fn of(geometry: &Geometry) -> Self {
        match geometry {
            Geometry::Curve(curve) => of_curve(curve),
            Geometry::Surface(surface) => of_surface(surface),
            Geometry::Trimmed(trimmed) => of_trimmed(trimmed),
            Geometry::Brep(brep) => of_brep(brep).0,
            Geometry::Custom(custom) => custom.shape().map_or_else(|_| Self::default(), of_shape),
            Geometry::Mesh(mesh) => of_mesh(mesh),
            Geometry::Polyline(line) => {
                Self { length: of_polyline(line), area: inside_of_polyline(line), ..Self::default() }
            }
            _ => Self::default(),
        }
    }
}

impl Measures {
    /// The same, of a Brep by quadrature on its faces instead of triangles: it takes longer, and tells apart what an edit keeps from what it
    /// nearly keeps. Where a face cannot be integrated, or there are very many pieces, those of its triangles. The volume, which depends a little on it where
    /// faces meet but for gaps, is taken from `origin`, or from the middle.
    pub(crate) fn by_quadrature(geometry: &Geometry, origin: Option<Point>) -> Self {
        match geometry {
            Geometry::Brep(brep) if brep.face_count() > 0 => {
                let volume = |brep: &dyn Shape| match origin {
                    Some(origin) => volume_from(brep, origin).ok(),
                    None => volume_of(brep).ok(),
                };
                let mut found = measured_to(brep, Cells::count(brep), EDITED, volume);
                if brep.solids().is_empty() {
                    found.volume = None;
                }
                let whole = found.area.is_some() && found.volume.is_some() != brep.solids().is_empty();
                if whole { found } else { of_brep(brep).0 }
            }
            other => Self::of(other),
        }
    }
}

fn of_curve(curve: &Curve) -> Measures {
    let length = curve.length(1e-10).ok().map(|length| length.value);
    let spans = curve.space().spans().count();
    let measurable = spans <= SPANS;
    let area = if measurable && closed(curve) { finite(area_of(curve).ok()) } else { None };
    let unmeasured =
        if measurable { Vec::new() } else { vec![format!("the area inside: there are {spans} spans")] };
    Measures { length, area, unmeasured, ..Measures::default() }
}

/// Whether a curve's end meets its start, to rounding of its size.
pub(crate) fn closed(curve: &Curve) -> bool {
    let (start, end) = curve.domain();
    let (low, high) = curve.hull_bounds();
    let size = (high - low).amax();
    let gap = curve.point(start).and_then(|a| Ok(distance(&curve.point(end)?, &a)));
    curve.is_periodic() || gap.is_ok_and(|gap| gap.is_finite() && gap <= 1e-12 * size)
}

fn of_surface(surface: &Surface) -> Measures {
    let cells = surface.u().spans().count().saturating_mul(surface.v().spans().count());
    let found = measured(surface, cells);
    let open = if found.volume.is_some() { Some(Vec::new()) } else { open_edges(surface) };
    Measures { watertight: open.as_ref().map(Vec::is_empty), open: open.unwrap_or_default(), ..found }
}

/// Ends of a surface that are no further apart than this part of its size are one.
const MEETS: f64 = 1e-12;

/// The edges of a surface that meet no other one and are no points; `None` where its numbers are too large to tell.
fn open_edges(surface: &Surface) -> Option<Vec<&'static str>> {
    let points = surface.points();
    let size = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
    let sides = surface.parameter_sides(MEETS * size).ok().filter(|_| size.is_finite())?;
    let edges = sides.iter().zip([["u0", "u1"], ["v0", "v1"]]).filter(|(side, _)| !side.closed);
    let open =
        edges.flat_map(|(side, names)| (0..2).filter(|&end| !side.poles[end]).map(move |end| names[end]));
    Some(open.collect())
}

/// What its loops leave of a surface.
fn of_trimmed(trimmed: &Trimmed) -> Measures {
    let cells = Cells::count(trimmed);
    let mut found = measured(trimmed, cells);
    // What was not integrated may close.
    if cells <= CELLS {
        found.watertight = Some(found.volume.is_some());
        found.open = if found.volume.is_some() { Vec::new() } else { vec!["border"] };
    }
    found
}

/// A shape of a plug-in.
fn of_shape(shape: &dyn Shape) -> Measures {
    match shape.cells() {
        Some(cells) if shape.domain().len() == 2 => measured(shape, cells.count()),
        _ => Measures::default(),
    }
}

/// The area of a surface of so many pieces, or why it is not told, and the volume inside where it is closed.
fn measured(surface: &dyn Shape, cells: usize) -> Measures {
    measured_to(surface, cells, CELLS, |surface| volume_of(surface).ok())
}

/// The same, integrated up to so many pieces where each has to be asked for rows, with the volume inside.
fn measured_to(
    surface: &dyn Shape,
    cells: usize,
    most: usize,
    volume: impl Fn(&dyn Shape) -> Option<f64>,
) -> Measures {
    let says_nets =
        surface.cells().is_some_and(|own| own.nets(0..0, &Point::origin(), &mut |_| {}).is_some());
    let most = if says_nets { NETS } else { most };
    if cells > most {
        let fewer = if says_nets { "; with a smaller \"depth\" there are fewer" } else { "" };
        let why = format!(
            "area and volume: there are {cells} polynomial pieces, and no more than {most} are integrated here; convert it to triangles (an OBJ \
             file), whose area and volume are told{fewer}"
        );
        return Measures { unmeasured: vec![why], ..Measures::default() };
    }
    let (area, unmeasured) = match surface_area_of(surface) {
        Ok(area) => (Some(area), Vec::new()),
        Err(why) => (None, vec![format!("area: {why}")]),
    };
    Measures { area, volume: finite(volume(surface)), unmeasured, ..Measures::default() }
}

/// How far the triangles of a Brep may be from it, as a part of its size.
const CHORD: f64 = 2e-4;

/// A Brep by its triangles: the area of its faces, the volume of its solids, and their points.
pub(crate) fn of_brep(brep: &Brep) -> (Measures, Vec<Point>) {
    if brep.face_count() == 0 {
        return (Measures::default(), Vec::new());
    }
    let fineness = Fineness { chord: Chord::Relative(CHORD), ..Fineness::default() };
    let cut = match Adaptive::default().measured_brep(brep, &fineness) {
        Ok(cut) => cut,
        Err(why) => {
            let unmeasured = vec![format!("area and volume: {why}")];
            return (Measures { unmeasured, ..Measures::default() }, Vec::new());
        }
    };
    let points = cut.mesh.points();
    if let Some(missing) = cut.remark(brep) {
        let unmeasured = vec![format!("area and volume: {missing}")];
        return (Measures { unmeasured, ..Measures::default() }, points.to_vec());
    }
    let shells = brep.solids().iter().flat_map(|solid| solid.voids.iter().chain([&solid.outer]));
    let bounds: HashSet<usize> =
        shells.filter_map(|&shell| brep.shells().get(shell)).flat_map(|s| &s.faces).copied().collect();
    let origin = points.first().copied().unwrap_or_default();
    let (mut area, mut volume) = (0.0, 0.0);
    for (triangle, face) in cut.mesh.faces().zip(&cut.faces) {
        let [a, b, c] = [0, 1, 2].map(|k| points[triangle[k] as usize] - origin);
        area += (b - a).cross(&(c - a)).norm() / 2.0;
        if bounds.contains(face) {
            volume += a.dot(&b.cross(&c)) / 6.0;
        }
    }
    let measures = Measures {
        area: finite(Some(area)),
        volume: finite((!bounds.is_empty()).then_some(volume)),
        within: Some(cut.error),
        ..Measures::default()
    };
    (measures, points.to_vec())
}

fn of_polyline(line: &Polyline) -> Option<f64> {
    let open: f64 = line.points.windows(2).map(|p| distance(&p[0], &p[1])).sum();
    let back = match (line.closed, line.points.first(), line.points.last()) {
        (true, Some(first), Some(last)) => distance(first, last),
        _ => 0.0,
    };
    finite(Some(open + back))
}

/// How far from a plane a closed polyline may be, as a part of its size, and still have an area inside.
const PLANAR: f64 = 1e-9;

/// The area inside a polyline that is closed and planar, positive; parts that it goes around the other way are taken away.
fn inside_of_polyline(line: &Polyline) -> Option<f64> {
    let first = line.points.first()?;
    if !line.closed && line.points.last() != Some(first) {
        return None;
    }
    // By its size, so that squares are numbers; relative to a point of its own: far from the origin nothing cancels.
    let size = line.points.iter().map(|p| (p - first).amax()).fold(0.0, f64::max);
    let at = |p: &Point| (p - first) / size;
    let mut normal = Vector::zeros();
    for pair in line.points.windows(2) {
        normal += at(&pair[0]).cross(&at(&pair[1]));
    }
    let doubled = normal.norm();
    let flat = line.points.iter().all(|p| at(p).dot(&normal).abs() <= PLANAR * doubled);
    let encloses = doubled > 1e-12 && flat;
    finite(encloses.then_some(0.5 * doubled * size * size))
}

fn of_mesh(mesh: &Mesh) -> Measures {
    let at = |index: u32| mesh.points()[index as usize];
    let lines = mesh.lines().map(|line| line.windows(2).map(|p| distance(&at(p[0]), &at(p[1]))).sum::<f64>());
    let length = (mesh.lines().next().is_some()).then(|| lines.sum());
    if mesh.face_count() == 0 {
        return Measures { length: finite(length), ..Measures::default() };
    }
    // Relative to a point of its own: far from the origin nothing cancels then.
    let origin = mesh.points().first().copied().unwrap_or_default();
    let (mut area, mut volume) = (0.0, 0.0);
    for face in mesh.faces() {
        let first = at(face[0]) - origin;
        let mut normal = Vector::zeros();
        for pair in face[1..].windows(2) {
            let (a, b) = (at(pair[0]) - origin, at(pair[1]) - origin);
            normal += (a - first).cross(&(b - first));
            volume += first.dot(&a.cross(&b));
        }
        // The area vector is right for faces that are not convex, too.
        area += normal.norm() / 2.0;
    }
    let leaks = Leaks::of(mesh);
    let watertight = leaks.is_none();
    Measures {
        length: finite(length),
        area: finite(Some(area)),
        volume: finite(watertight.then_some(volume / 6.0)),
        watertight: Some(watertight),
        open: Vec::new(),
        leaks,
        within: None,
        unmeasured: Vec::new(),
    }
}

fn finite(measure: Option<f64>) -> Option<f64> {
    measure.filter(|measure| measure.is_finite())
}

/// A distance whose squares neither overflow nor vanish.
fn distance(p: &Point, q: &Point) -> f64 {
    let d = q - p;
    d.x.hypot(d.y).hypot(d.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::spline::Space;

    /// A cube of edge `size`, each face with points of its own, as formats with a normal for each point have them.
    fn cube(size: f64, shift: f64) -> (Vec<Point>, Vec<[usize; 4]>) {
        const FACES: [[usize; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let corner = |k: usize| {
            Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64) * size + Vector::repeat(shift)
        };
        let points = FACES.iter().flatten().map(|&k| corner(k)).collect();
        (points, (0..6).map(|f| [4 * f, 4 * f + 1, 4 * f + 2, 4 * f + 3]).collect())
    }

    fn of(points: Vec<Point>, faces: &[[usize; 4]]) -> Measures {
        Measures::of(&Geometry::Mesh(Mesh::new(points, faces).unwrap()))
    }

    #[test]
    fn a_cube_is_watertight_whatever_points_its_faces_share() {
        for (size, shift) in [(2.0, 0.0), (2e-6, 1.0), (2e6, -3e6)] {
            let (points, faces) = cube(size, shift);
            let all = of(points, &faces);
            // What the coordinates themselves hold.
            let near = |found: Option<f64>, wanted: f64| {
                (found.unwrap() / wanted - 1.0).abs() < 1e-14 + 1e-15 * (shift / size).abs()
            };
            assert!(near(all.area, 6.0 * size * size) && near(all.volume, size.powi(3)), "{all:?}");
            assert_eq!((all.watertight, all.leaks), (Some(true), None));
        }
    }

    /// A surface says where it is open: a quarter of a tube everywhere, a tube at its ends, a ball nowhere; one beyond what numbers hold says nothing.
    #[test]
    fn a_surface_is_watertight_or_says_where_not() {
        let (o, x, z) = (Point::origin(), Vector::x(), Vector::z());
        let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, 5.0)).unwrap();
        let meridian = Curve::elliptic_arc(o, -z, x, 0.0, std::f64::consts::PI).unwrap();
        let turned = |profile: &Curve, angle: f64| Surface::revolution(profile, o, z, angle).unwrap();
        let told = |surface: &Surface| {
            let found = of_surface(surface);
            (found.watertight, found.open)
        };
        let tau = std::f64::consts::TAU;
        assert_eq!(told(&turned(&line, 1.0)), (Some(false), vec!["u0", "u1", "v0", "v1"]));
        assert_eq!(told(&turned(&line, tau)), (Some(false), vec!["v0", "v1"]));
        assert_eq!(told(&turned(&meridian, 1.0)), (Some(false), vec!["u0", "u1"]));
        assert_eq!(told(&turned(&meridian, tau)), (Some(true), vec![]));
        let huge = turned(&line, 1.0);
        let points =
            huge.points().iter().map(|p| (p - Point::new(1.0, 1.0, 1.0)) * 4e307).map(Point::from).collect();
        let huge = Surface::build(huge.u().clone(), huge.v().clone(), points, None).unwrap();
        assert_eq!(told(&huge), (None, vec![]));
    }

    #[test]
    fn a_brep_has_the_area_of_its_faces_and_the_volume_of_its_solids() {
        let block = Brep::block(Point::new(1e6, 0.0, 0.0), Point::new(1e6 + 3.0, 2.0, 1.0)).unwrap();
        let (all, around) = of_brep(&block);
        assert!(
            (all.area.unwrap() - 22.0).abs() < 1e-8 && (all.volume.unwrap() - 6.0).abs() < 1e-8,
            "{all:?}"
        );
        assert!(all.within.unwrap() < 1e-9);
        let (low, high) =
            around.iter().fold((around[0], around[0]), |(low, high), p| (low.inf(p), high.sup(p)));
        assert!((low - Point::new(1e6, 0.0, 0.0)).norm() < 1e-9 && (high.x - low.x - 3.0).abs() < 1e-9);
        // A shell that bounds no solid has an area.
        let mut parts = block.parts();
        parts.solids.clear();
        let shell = of_brep(&Brep::new(parts).unwrap()).0;
        assert_eq!((shell.area, shell.volume), (all.area, None));
        assert_eq!(of_brep(&Brep::new(Default::default()).unwrap()), (Measures::default(), Vec::new()));
        // A ball: inscribed triangles are within what is said of it.
        let frame = loftsman_kernel::brep::Frame::new(Point::origin(), Vector::z(), Vector::x()).unwrap();
        let form = loftsman_kernel::brep::SurfaceForm::Sphere { frame, radius: 2.0 };
        let face = loftsman_kernel::brep::Face {
            name: None,
            color: None,
            surface: form.covering(&[]).unwrap(),
            form,
            reversed: false,
            loops: vec![],
            points: vec![],
        };
        let ball = loftsman_kernel::brep::Parts {
            faces: vec![face],
            shells: vec![loftsman_kernel::brep::Shell { faces: vec![0] }],
            solids: vec![loftsman_kernel::brep::Solid::default()],
            ..Default::default()
        };
        let all = of_brep(&Brep::new(ball).unwrap()).0;
        let (area, volume) = (16.0 * std::f64::consts::PI, 32.0 / 3.0 * std::f64::consts::PI);
        assert!((all.volume.unwrap() - volume).abs() <= 1.01 * area * all.within.unwrap(), "{all:?}");
        assert!((all.area.unwrap() / area - 1.0).abs() < 1e-2);
    }

    #[test]
    fn what_is_not_watertight_says_where() {
        let (points, mut faces) = cube(1.0, 0.0);
        let top = faces.remove(1);
        let leaks = of(points.clone(), &faces).leaks.unwrap();
        assert_eq!((leaks.open_edges, leaks.rims, leaks.turned_edges), (4, 1, 0));
        assert!((leaks.at[2] - 1.0).abs() < 1e-15, "{leaks:?}");
        // Two opposite faces are missing, or one is turned over, or there twice.
        faces.remove(0);
        assert_eq!(of(points.clone(), &faces).leaks.unwrap().rims, 2);
        let (_, mut faces) = cube(1.0, 0.0);
        faces[1].reverse();
        let turned = of(points.clone(), &faces);
        assert_eq!((turned.volume, turned.leaks.unwrap().turned_edges), (None, 4));
        faces[1].reverse();
        faces.push(top);
        assert_eq!(of(points, &faces).leaks.unwrap().crowded_edges, 4);
    }

    #[test]
    fn a_face_that_is_not_convex_has_its_own_area() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (1.0, 1.0), (0.0, 4.0)];
        let points = corners.map(|(x, y)| Point::new(x, y, 7.0)).to_vec();
        // As seen from any corner: a fan without signs would say 8 from the second.
        for first in 0..4 {
            let all = of(points.clone(), &[[0, 1, 2, 3].map(|k| (k + first) % 4)]);
            assert!((all.area.unwrap() - 4.0).abs() < 1e-14, "{all:?}");
        }
    }

    #[test]
    fn a_closed_planar_curve_has_an_area_and_others_have_none() {
        let square = |lift: f64| {
            let points =
                [(0.0, 0.0, 0.0), (2.0, 0.0, lift), (2.0, 3.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 0.0)];
            let points = points.map(|(x, y, z)| Point::new(x, y, z)).to_vec();
            Geometry::Curve(Curve::new(Space::clamped_uniform(1, 5).unwrap(), points).unwrap())
        };
        let flat = Measures::of(&square(0.0));
        assert!((flat.area.unwrap() - 6.0).abs() < 1e-13 && (flat.length.unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(Measures::of(&square(1.0)).area, None);
    }

    /// Closed planar polylines by closed forms: whichever way round, wherever and however large; what is open, bent or goes nowhere has no area.
    #[test]
    fn a_closed_planar_polyline_has_an_area() {
        let ell = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let tilted = |size: f64, away: f64, lift: f64| -> Vec<Point> {
            let at = |(k, [x, y]): (usize, &[f64; 2])| {
                let up = if k == 2 { lift } else { 0.0 };
                Point::new(0.6 * x - 0.8 * up, *y, 0.8 * x + 0.6 * up) * size + Vector::repeat(away)
            };
            ell.iter().enumerate().map(at).collect()
        };
        let area = |points: Vec<Point>, closed: bool| Measures::of(&Polyline { points, closed }.into()).area;
        for size in [1e-100, 1e-9, 1.0, 1e9, 1e100] {
            let points = tilted(size, 0.0, 0.0);
            for points in [points.clone(), points.iter().rev().copied().collect()] {
                let found = area(points, true).unwrap();
                assert!((found / size / size - 6.0).abs() < 1e-12, "{size}: {found}");
            }
        }
        assert!((area(tilted(1.0, 1e4, 0.0), true).unwrap() - 6.0).abs() < 1e-10);
        let mut repeated = tilted(1.0, 0.0, 0.0);
        repeated.push(repeated[0]);
        assert!((area(repeated, false).unwrap() - 6.0).abs() < 1e-12);
        assert_eq!(area(tilted(1.0, 0.0, 0.0), false), None);
        assert_eq!(area(tilted(1.0, 0.0, 1e-3), true), None);
        let line = (0..4).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
        assert_eq!(area(line, true), None);
        assert_eq!(area(vec![Point::origin(); 3], true), None);
        assert_eq!(area(Vec::new(), true), None);
    }
}
