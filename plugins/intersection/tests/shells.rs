//! Sections of Breps and of trimmed surfaces, against closed forms and against the triangles of real parts.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::{PI, TAU};

use loftsman_intersection::{
    Options, Plane, ShellSection, brep_section, mesh_section, mesh_section_area, trimmed_section,
};
use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::plugin::{Chord, Fineness, Format, Memory, ReadOptions, Tessellator};
use loftsman_kernel::scene::{Definition, Geometry, Object};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use loftsman_tessellation::Adaptive;

fn p(x: f64, y: f64, z: f64) -> Point {
    Point::new(x, y, z)
}

fn plane(point: Point, normal: Vector) -> Plane {
    Plane::new(point, normal).unwrap()
}

fn cut(brep: &Brep, at: &Plane) -> ShellSection {
    let cut = brep_section(brep, at, &Options::default()).unwrap();
    assert!(cut.undecided.is_empty(), "{:?}", cut.undecided);
    for branch in &cut.curves {
        assert!(branch.distance <= cut.tolerance);
        let (a, b) = branch.curve.domain();
        let ends = (branch.curve.points().first(), branch.curve.points().last());
        assert!(!branch.closed || branch.curve.is_periodic() || ends.0 == ends.1, "{ends:?}");
        for k in 0..=100 {
            let q = branch.curve.point((a + (b - a) * f64::from(k) / 100.0).min(b)).unwrap();
            assert!(at.distance(&q).abs() <= cut.tolerance, "{}", at.distance(&q));
        }
    }
    cut
}

fn length(cut: &ShellSection) -> f64 {
    cut.curves.iter().map(|c| c.curve.length(1e-10).unwrap().value).sum()
}

#[track_caller]
fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within * expected.abs().max(1.0), "{found} instead of {expected}");
}

#[test]
fn a_block_is_cut_in_polygons() {
    for scale in [1e-6, 1.0, 1e6] {
        let block = Brep::block(Point::origin(), p(3.0, 2.0, 1.0) * scale).unwrap();
        let at = |x: f64, y: f64, z: f64, n: [f64; 3]| cut(&block, &plane(p(x, y, z) * scale, n.into()));
        let side = at(0.0, 0.0, 0.5, [0.0, 0.0, 2.0]);
        assert_eq!((side.curves.len(), side.curves[0].closed, side.curves[0].faces.len()), (1, true, 4));
        near(side.area.unwrap() / scale / scale, 6.0, 1e-9);
        near(length(&side) / scale, 10.0, 1e-9);
        // Seen from the other side it is as large.
        near(at(0.0, 0.0, 0.5, [0.0, 0.0, -1.0]).area.unwrap() / scale / scale, 6.0, 1e-9);
        // A hexagon, the corner of a block, and its diagonal: through vertices.
        let hexagon = at(1.5, 1.0, 0.5, [2.0, 3.0, 6.0]);
        assert_eq!(hexagon.curves[0].faces.len(), 6);
        let corner = at(0.25, 0.0, 0.0, [1.0, 1.0, 1.0]);
        near(corner.area.unwrap() / scale / scale, 3.0_f64.sqrt() / 2.0 * 0.0625, 1e-6);
        let diagonal = at(0.0, 0.0, 0.0, [2.0, -3.0, 0.0]);
        near(diagonal.area.unwrap() / scale / scale, 13.0_f64.sqrt(), 1e-5);
        // Beside it; in a face; along an edge.
        assert_eq!(at(0.0, 0.0, 1.5, [0.0, 0.0, 1.0]).curves.len(), 0);
        let bottom = at(0.0, 0.0, 0.0, [0.0, 0.0, 1.0]);
        assert_eq!(bottom.coincident.len(), 1);
        near(bottom.area.unwrap() / scale / scale, 6.0, 1e-5);
        let top = at(0.0, 0.0, 1.0, [0.0, 0.0, 1.0]);
        assert_eq!((top.coincident.len(), top.curves.len()), (1, 0));
        assert!(at(0.0, 0.0, 0.0, [0.0, -1.0, -1.0]).area.is_none_or(|a| a < 1e-5 * scale * scale));
    }
}

fn along(edge: usize) -> Use {
    Use { edge, reversed: false, parameters: None }
}

fn against(edge: usize) -> Use {
    Use { reversed: true, ..along(edge) }
}

fn ring(height: f64, radius: f64, vertex: usize) -> Edge {
    let curve = Curve::circle(p(0.0, 0.0, height), Vector::z(), radius).unwrap();
    let range = curve.domain();
    Edge { curve, range, ends: [vertex; 2], tolerance: 1e-12, form: CurveForm::Spline }
}

fn face(form: SurfaceForm, points: &[Point], reversed: bool, loops: Vec<Vec<Use>>) -> Face {
    let surface = form.covering(points).unwrap();
    Face { name: None, color: None, surface, form, reversed, loops, points: vec![] }
}

fn frame(origin: Point) -> Frame {
    Frame::new(origin, Vector::z(), Vector::y()).unwrap()
}

/// A pipe around z from 0 to 5, of an outer radius 2 and an inner one 1: no edge of it runs along its walls.
fn pipe() -> Brep {
    let edges = vec![ring(0.0, 2.0, 0), ring(5.0, 2.0, 1), ring(0.0, 1.0, 2), ring(5.0, 1.0, 3)];
    let vertices =
        edges.iter().map(|e| Vertex { point: e.curve.point(e.range.0).unwrap(), tolerance: 1e-12 }).collect();
    let rim = [p(2.0, 2.0, 0.0), p(-2.0, -2.0, 5.0)];
    let wall = |radius: f64| SurfaceForm::Cylinder { frame: frame(Point::origin()), radius };
    let cap = |z: f64| SurfaceForm::Plane { frame: frame(p(0.0, 0.0, z)) };
    let faces = vec![
        face(cap(0.0), &rim, true, vec![vec![against(0)], vec![along(2)]]),
        face(cap(5.0), &rim, false, vec![vec![along(1)], vec![against(3)]]),
        face(wall(2.0), &rim, false, vec![vec![along(0)], vec![against(1)]]),
        face(wall(1.0), &rim, true, vec![vec![against(2)], vec![along(3)]]),
    ];
    let (shells, solids) = (vec![Shell { faces: (0..4).collect() }], vec![Solid::default()]);
    Brep::new(Parts { vertices, edges, faces, shells, solids }).unwrap()
}

#[test]
fn a_pipe_is_cut_in_rings_and_rectangles() {
    let pipe = pipe();
    for height in [0.001, 1.0, 2.5, 4.999] {
        let ring = cut(&pipe, &plane(p(0.0, 0.0, height), Vector::z()));
        assert_eq!(ring.curves.iter().filter(|c| c.closed).count(), 2);
        near(ring.area.unwrap(), 3.0 * PI, 1e-5);
        near(length(&ring), 3.0 * TAU, 1e-5);
    }
    // Along the axis: two rectangles, or one beside the bore.
    let both = cut(&pipe, &plane(Point::origin(), Vector::new(0.6, 0.8, 0.0)));
    assert_eq!(both.curves.len(), 2);
    near(both.area.unwrap(), 10.0, 1e-5);
    let one = cut(&pipe, &plane(p(1.5, 0.0, 0.0), Vector::x()));
    assert_eq!((one.curves.len(), one.curves[0].closed), (1, true));
    near(one.area.unwrap(), 10.0 * (4.0_f64 - 2.25).sqrt(), 1e-5);
    // Across: two ellipses, wholly on the walls.
    let normal = Vector::new(0.3, 0.0, 1.0).normalize();
    let across = cut(&pipe, &plane(p(0.0, 0.0, 2.5), normal));
    near(across.area.unwrap(), 3.0 * PI / normal.z, 1e-5);
    // Through the rims: where it goes out by the caps.
    let steep = cut(&pipe, &plane(p(0.0, 0.0, 2.5), Vector::new(3.0, 0.0, 1.0)));
    assert!(steep.curves.iter().all(|c| c.closed) && steep.area.is_some());
    assert!(cut(&pipe, &plane(p(0.0, 0.0, 7.0), Vector::z())).curves.is_empty());
}

/// A torus of radii 3 and 1 without the part between four of its isoparametric curves.
fn torus_with_a_window() -> (Brep, Surface, [f64; 4]) {
    let form = SurfaceForm::Torus { frame: frame(Point::origin()), major: 3.0, minor: 1.0 };
    let surface = form.covering(&[]).unwrap();
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let window = [a + 0.3 * (b - a), a + 0.45 * (b - a), c + 0.05 * (d - c), c + 0.25 * (d - c)];
    let [u0, u1, v0, v1] = window;
    let corner = |u: f64, v: f64| Vertex { point: surface.point(u, v).unwrap(), tolerance: 1e-12 };
    let vertices = vec![corner(u0, v0), corner(u1, v0), corner(u1, v1), corner(u0, v1)];
    let of_v = |v: f64| surface.isocurve(Direction::V, v).unwrap();
    let of_u = |u: f64| surface.isocurve(Direction::U, u).unwrap();
    let edge = |curve: Curve, range: (f64, f64), ends: [usize; 2]| {
        let at = curve.point(range.0).unwrap();
        assert!((at - vertices[ends[0]].point).norm() < 1e-9);
        Edge { curve, range, ends, tolerance: 1e-12, form: CurveForm::Spline }
    };
    let edges = vec![
        edge(of_v(v0), (u0, u1), [0, 1]),
        edge(of_u(u1), (v0, v1), [1, 2]),
        edge(of_v(v1), (u0, u1), [3, 2]),
        edge(of_u(u0), (v0, v1), [0, 3]),
    ];
    // The face is to the left: clockwise around the window.
    let hole = vec![along(3), along(2), against(1), against(0)];
    let faces = vec![face(form, &[], false, vec![hole])];
    let shells = vec![Shell { faces: vec![0] }];
    (Brep::new(Parts { vertices, edges, faces, shells, solids: vec![] }).unwrap(), surface, window)
}

#[test]
fn a_window_in_a_torus_is_left_out() {
    let (brep, surface, [u0, u1, v0, v1]) = torus_with_a_window();
    let middle = surface.point(0.5 * (u0 + u1), 0.5 * (v0 + v1)).unwrap();
    // Across the axis: the outer circle lacks what is in the window, the inner one is whole.
    let level = cut(&brep, &plane(middle, Vector::z()));
    let radius = middle.coords.xy().norm();
    let sides = [u0, u1].map(|u| surface.point(u, 0.5 * (v0 + v1)).unwrap().coords.xy());
    let lacks = radius * sides[0].angle(&sides[1]);
    let inner = 6.0 - radius;
    near(length(&level), TAU * (radius + inner) - lacks, 1e-4);
    assert_eq!(level.curves.iter().filter(|c| c.closed).count(), 1);
    assert_eq!(level.area, None);
    // Along the axis, through the window: one of the two circles lacks an arc.
    let through = cut(&brep, &plane(Point::origin(), middle.coords.cross(&Vector::z())));
    let quarter = [v0, v1].map(|v| surface.point(0.5 * (u0 + u1), v).unwrap());
    let tube = Vector::new(middle.x, middle.y, 0.0).normalize() * 3.0;
    let angle = (quarter[0].coords - tube).angle(&(quarter[1].coords - tube));
    near(length(&through), 2.0 * TAU - angle, 1e-4);
    // Below it: two whole circles, of which it must be found out that they are inside.
    let below = cut(&brep, &plane(p(0.0, 0.0, -0.5), Vector::z()));
    assert_eq!((below.curves.len(), below.curves.iter().filter(|c| c.closed).count()), (2, 2));
    near(length(&below), 6.0 * TAU, 1e-5);
}

#[test]
fn a_ball_without_edges_is_cut_whole() {
    let form = SurfaceForm::Sphere { frame: frame(Point::origin()), radius: 2.0 };
    let (shells, solids) = (vec![Shell { faces: vec![0] }], vec![Solid::default()]);
    let ball =
        Brep::new(Parts { faces: vec![face(form, &[], false, vec![])], shells, solids, ..Parts::default() })
            .unwrap();
    for normal in [Vector::z(), Vector::x(), Vector::new(1.0, -2.0, 0.5)] {
        let found = cut(&ball, &plane(Point::from(normal.normalize()), normal));
        assert_eq!(found.curves.len(), 1);
        near(found.area.unwrap(), 3.0 * PI, 1e-5);
    }
    assert_eq!(cut(&ball, &plane(p(0.0, 0.0, 2.0), Vector::z())).curves.len(), 0);
    assert_eq!(
        brep_section(
            &Brep::new(Parts::default()).unwrap(),
            &plane(Point::origin(), Vector::z()),
            &Options::default()
        )
        .unwrap(),
        ShellSection::default()
    );
}

#[test]
fn a_trimmed_surface_is_cut_inside_its_loops() {
    let line = || Space::clamped(1, &[0.0, 4.0]).unwrap();
    let net = vec![p(0.0, 0.0, 0.0), p(0.0, 4.0, 0.0), p(4.0, 0.0, 0.0), p(4.0, 4.0, 0.0)];
    let surface = Surface::new(line(), line(), net).unwrap();
    let disc = |radius: f64| {
        let curve = Curve::circle(p(2.0, 2.0, 0.0), Vector::z(), radius).unwrap();
        vec![ParameterCurve::whole(curve).unwrap()]
    };
    let trimmed = |outer: Vec<ParameterCurve>| {
        let region = Region { outer, holes: vec![disc(1.0)] };
        Trimmed::new(surface.clone(), vec![region], vec![], vec![]).unwrap()
    };
    let at = |y: f64, t: &Trimmed| {
        trimmed_section(t, &plane(p(0.0, y, 0.0), Vector::y()), &Options::default()).unwrap()
    };
    let chord = |radius: f64, y: f64| 2.0 * (radius * radius - (y - 2.0) * (y - 2.0)).sqrt();
    let annulus = trimmed(disc(1.5));
    for y in [1.1, 2.0, 2.7] {
        let found = at(y, &annulus);
        assert_eq!((found.curves.len(), found.area), (2, None));
        near(length(&found), chord(1.5, y) - chord(1.0, y), 1e-6);
    }
    near(length(&at(0.7, &annulus)), chord(1.5, 0.7), 1e-6);
    assert!(at(0.2, &annulus).curves.is_empty());
    // Without an outer loop all of the surface is there but for the hole.
    near(length(&at(2.5, &trimmed(vec![]))), 4.0 - chord(1.0, 2.5), 1e-6);
    near(length(&at(0.2, &trimmed(vec![]))), 4.0, 1e-6);
    let bare = Trimmed::new(surface.clone(), vec![], vec![], vec![]).unwrap();
    near(length(&at(0.2, &bare)), 4.0, 1e-6);
    let flat = trimmed_section(&annulus, &plane(Point::origin(), Vector::z()), &Options::default()).unwrap();
    assert_eq!((flat.coincident, flat.curves.len()), (vec![0], 0));
}

/// Sections of real parts close, and have the lengths and areas of those of their triangles.
#[test]
fn real_parts_are_cut_as_their_triangles_are() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/step/");
    let names = [
        "NIST_MBE_PMI_11.stp",
        "NIST_MBE_PMI_1.stp",
        "NIST_MBE_PMI_3.stp",
        "base_interface_AP214.STEP",
        "featuretype.STEP",
        "io1-cm-214.stp",
        "sliced_cylinder.step",
        "MAINBODY_FRONT.stp",
        "as1-oc-214.stp",
        "red_cube_blue_cylinder.step",
    ];
    let (mut sections, mut solids, mut areas) = (0, 0, 0);
    for name in names {
        let file = Memory::new(name, std::fs::read(format!("{folder}{name}")).unwrap());
        let (scene, _) = Step.read(&file, &ReadOptions::default()).unwrap();
        let objects = scene.definitions().iter().flat_map(Definition::objects).chain(scene.objects());
        for object in objects.collect::<Vec<&Object>>() {
            let Geometry::Brep(brep) = object.geometry() else { continue };
            let all: Vec<usize> = (0..brep.face_count()).collect();
            if !brep.is_closed(&all) {
                continue;
            }
            solids += 1;
            let fineness = Fineness { chord: Chord::Relative(2e-4), angle: 0.2 };
            let mesh = Adaptive::default().measured_brep(brep, &fineness).unwrap().mesh;
            let first = mesh.points()[0];
            let (low, high) = mesh.points().iter().fold((first, first), |(l, h), q| (l.inf(q), h.sup(q)));
            let size = (high - low).norm();
            for (normal, share) in [
                (Vector::x(), 0.37),
                (Vector::y(), 0.52),
                (Vector::z(), 0.61),
                (Vector::new(1.0, 2.0, -1.5), 0.44),
            ] {
                let through = low + (high - low) * share;
                let at = plane(through, normal);
                let found = brep_section(brep, &at, &Options::default()).unwrap();
                let told = format!("{name} {} {normal:?}", object.name());
                assert!(found.undecided.is_empty(), "{told}: faces {:?}", found.undecided);
                assert!(found.curves.iter().all(|c| c.distance <= found.tolerance), "{told}");
                let open = found.curves.iter().filter(|c| !c.closed).count();
                assert_eq!(open, 0, "{told}: of {} curves", found.curves.len());
                let lines = mesh_section(&mesh, &at);
                let expected: f64 = lines
                    .iter()
                    .map(|l| {
                        let back = l.points.first().zip(l.points.last()).filter(|_| l.closed);
                        l.points.windows(2).map(|s| (s[1] - s[0]).norm()).sum::<f64>()
                            + back.map_or(0.0, |(a, b)| (b - a).norm())
                    })
                    .sum();
                let length = length(&found);
                assert!((length - expected).abs() <= 4e-3 * (size + expected), "{told}: {length} {expected}");
                // Twice the area vector of closed polygons, which run any way round: nested ones take from one another.
                if lines.len() == 1 {
                    let points = &lines[0].points;
                    let n = points.len();
                    let vector: Vector = (0..n)
                        .map(|k| (points[k] - points[0]).cross(&(points[(k + 1) % n] - points[0])))
                        .sum();
                    let (area, expected) = (found.area.unwrap(), 0.5 * vector.norm());
                    assert!((area - expected).abs() <= 2e-3 * size * size, "{told}: {area} {expected}");
                }
                let none = found.curves.is_empty();
                assert_eq!(none, lines.is_empty(), "{told}: {} and {}", found.curves.len(), lines.len());
                assert!(none || found.area.unwrap() > 0.0, "{told}: {:?}", found.area);
                // Several loops too: the mesh's own area, by which of them lie in one another.
                if let (Some(area), Some(expected)) = (found.area, mesh_section_area(&lines, &at)) {
                    assert!((area - expected).abs() <= 2e-3 * size * size, "{told}: {area} {expected}");
                    areas += 1;
                }
                sections += found.curves.len();
            }
        }
    }
    assert!(
        solids >= 12 && sections >= 60 && areas >= 30,
        "{solids} solids, {sections} loops, {areas} areas"
    );
}

/// Through the middles of parts, where edges lie in the plane and others only touch it: as close beside the plane, or closed at least.
#[test]
fn middle_planes_are_cut_in_loops() {
    let folders = ["../../tests/data/step", "../../../shared/data/step"];
    let mut count = 0;
    for (name, object, normal, area) in [
        ("io1-cm-214.stp", "io1", Vector::z(), 953.6),
        ("MAINBODY_FRONT.stp", "MAINBODY_FRONT", Vector::y(), 0.6782),
        // One that is too large to go along.
        ("boxed_sphere.step", "box", Vector::y(), f64::NAN),
        ("boxed_sphere.step", "box", Vector::z(), f64::NAN),
    ] {
        let root = env!("CARGO_MANIFEST_DIR");
        let Some(bytes) = folders.iter().find_map(|f| std::fs::read(format!("{root}/{f}/{name}")).ok())
        else {
            assert!(area.is_nan(), "{name}");
            continue;
        };
        let (scene, _) = Step.read(&Memory::new(name, bytes), &ReadOptions::default()).unwrap();
        let Geometry::Brep(brep) = scene.object(object).unwrap().geometry() else { unreachable!() };
        let found = brep_section(brep, &plane(Point::origin(), normal), &Options::default()).unwrap();
        assert!(found.undecided.is_empty(), "{name}: {:?}", found.undecided);
        assert!(!found.curves.is_empty() && found.curves.iter().all(|c| c.closed), "{name} {normal:?}");
        let whole = found.area.unwrap();
        if area.is_nan() {
            let beside = plane(Point::origin() + normal * (100.0 * found.tolerance), normal);
            let beside = brep_section(brep, &beside, &Options::default()).unwrap().area.unwrap();
            near(whole, beside, 1e-3);
        } else {
            near(whole / area, 1.0, 1e-3);
        }
        count += 1;
    }
    assert!(count >= 2);
}

/// A block with a cavity that is one face, bounded by nothing but its seams: a plane through the cavity's axis cuts two circles, and one that
/// meets no seam a loop all the same.
#[test]
fn a_cavity_bounded_by_its_seams_alone_is_cut() {
    let mut parts = Brep::block(p(-4.0, -4.0, -2.0), p(4.0, 4.0, 2.0)).unwrap().parts();
    let frame = Frame::new(Point::origin(), Vector::z(), Vector::x()).unwrap();
    let form = SurfaceForm::Torus { frame, major: 2.0, minor: 0.5 };
    let surface = form.covering(&[]).unwrap();
    let (vertex, first) = (parts.vertices.len(), parts.edges.len());
    let start = surface.point(surface.u().domain().0, surface.v().domain().0).unwrap();
    parts.vertices.push(Vertex { point: start, tolerance: 0.0 });
    for (direction, at) in [(Direction::V, surface.v().domain().0), (Direction::U, surface.u().domain().0)] {
        let curve = surface.isocurve(direction, at).unwrap();
        let range = curve.domain();
        let form = CurveForm::Spline;
        parts.edges.push(Edge { curve, range, ends: [vertex; 2], tolerance: 0.0, form });
    }
    let one = |k: usize, reversed: bool| Use { edge: first + k, reversed, parameters: None };
    // The cavity's face looks into the torus: its loop runs the other way round.
    let seams = vec![one(1, false), one(0, false), one(1, true), one(0, true)];
    let face = Face {
        name: None,
        color: None,
        surface,
        form,
        reversed: true,
        loops: vec![seams],
        points: Vec::new(),
    };
    parts.faces.push(face);
    parts.shells.push(Shell { faces: vec![6] });
    parts.solids[0].voids.push(1);
    let brep = Brep::new(parts).unwrap();
    for degrees in [17.0_f64, 40.0, 111.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let found = cut(&brep, &plane(Point::origin(), Vector::new(sin, -cos, 0.0)));
        assert_eq!((found.curves.len(), found.curves.iter().all(|c| c.closed)), (3, true), "{degrees}");
        let across = 8.0 / sin.abs().max(cos.abs());
        near(found.area.unwrap(), 4.0 * across - 0.5 * PI, 1e-6);
    }
    let beside = cut(&brep, &plane(p(-2.1, 0.0, 0.0), Vector::x()));
    assert_eq!((beside.curves.len(), beside.curves.iter().all(|c| c.closed)), (2, true));
    let flat = cut(&brep, &plane(p(0.0, 0.0, 0.3), Vector::z()));
    // A ring between two circles of 2 ± 0.4.
    near(flat.area.unwrap(), 64.0 - PI * (2.4_f64.powi(2) - 1.6_f64.powi(2)), 1e-6);
}

/// A section lies in its plane to rounding, also where the plane passes vertices and is moved a little to be cut: then its area is one to whatever asks.
#[test]
fn sections_lie_in_their_planes() {
    let block = Brep::block(Point::new(-1.0, -2.0, -0.5), Point::new(3.0, 2.0, 1.0)).unwrap();
    let normal = Vector::new(1.0, 1.0, 2.0);
    // Through vertices of the block, and between.
    for point in [Point::new(-1.0, 2.0, -0.5), Point::new(3.0, -2.0, -0.5), Point::new(0.3, 0.2, 0.1)] {
        for tolerance in [1e-3, 1e-6] {
            let plane = Plane::new(point, normal).unwrap();
            let cut = brep_section(&block, &plane, &Options::within(tolerance)).unwrap();
            assert!(cut.curves.len() == 1 && cut.curves[0].closed, "{point}: {cut:?}");
            let leaves =
                cut.curves[0].curve.points().iter().map(|p| plane.distance(p).abs()).fold(0.0, f64::max);
            assert!(leaves < 1e-14, "{point}: {leaves:e}");
            assert!(cut.curves[0].distance <= tolerance, "{point}: {}", cut.curves[0].distance);
        }
    }
}
