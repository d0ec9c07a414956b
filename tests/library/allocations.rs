//! What is promised about cost: an event allocates nothing and does not depend on the size of the curve.

use allocation_counter::measure;
use loftsman::area_volume::{area, volume};
use loftsman::subdivision::{Cage, SubdivisionSurface};
use loftsman_kernel::edit::{Ask, Edit, Metric, Session};
use loftsman_kernel::functional::{curvature, position, tangent};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::solve::{Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Solver, Sparse};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

fn coil(vertices: usize) -> Curve {
    let at = |i: usize| {
        let (sin, cos) = (0.3 * i as f64).sin_cos();
        Point::new(cos, sin, 0.1 * i as f64)
    };
    Curve::new(Space::clamped_uniform(3, vertices).unwrap(), (0..vertices).map(at).collect()).unwrap()
}

fn session(vertices: usize, solver: impl Solver + 'static) -> Session<Curve> {
    let edit = Edit::of(coil(vertices)).ask(position(1.5).keep()).ask(position(7.25).by([0.0, 0.0, 0.1]));
    edit.handle(position(4.5)).prepare(solver).unwrap()
}

#[test]
fn an_event_allocates_nothing() {
    fn check(name: &str, mut session: Session<Curve>) {
        session.to_point(Point::new(1.0, 2.0, 3.0)).unwrap();
        let counted = measure(|| {
            for i in 0..100 {
                session.to_point(Point::new(1.0, 2.0, 3.0 + 0.01 * f64::from(i))).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{name}: {counted:?}");
        let at = session.shape().point(4.5).unwrap();
        assert!((at - Point::new(1.0, 2.0, 3.99)).amax() < 1e-12, "and it is where it was dragged: {at}");
    }
    check("adjoint", session(1000, Adjoint));
    check("sparse", session(1000, Sparse));
    check("householder-qr", session(1000, HouseholderQr));
    check("saddle-point", session(1000, SaddlePoint));
    check("lu", session(1000, DenseLu));
    check("automatic", session(1000, Automatic));
}

#[test]
fn an_event_with_coupled_constraints_allocates_nothing() {
    let edit = Edit::of(coil(100)).ask(tangent(2.5).keep()).ask(curvature(6.5).keep());
    let mut session = edit.handle(position(4.5)).prepare(Automatic).unwrap();
    let counted = measure(|| {
        for i in 0..100 {
            session.to_point(Point::new(1.0, 2.0, 3.0 + 0.01 * f64::from(i))).unwrap();
        }
    });
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

fn turn(i: usize, n: usize) -> (f64, f64) {
    (std::f64::consts::TAU * i as f64 / n as f64).sin_cos()
}

/// A wavy ring, periodic.
fn ring(n: usize) -> Curve {
    let at = |i: usize| {
        let ((sin, cos), (wave, _)) = (turn(i, n), turn(3 * i, n));
        Point::new(cos, sin, 0.0) * (1.0 + 0.2 * wave)
    };
    Curve::new(Space::periodic_uniform(3, n).unwrap(), (0..n).map(at).collect()).unwrap()
}

/// A torus, periodic both ways.
fn torus(n: usize) -> Surface {
    let at = |k: usize| {
        let ((sa, ca), (sb, cb)) = (turn(k / n, n), turn(k % n, n));
        Point::new((1.0 + 0.4 * cb) * ca, (1.0 + 0.4 * cb) * sa, 0.4 * sb)
    };
    let space = Space::periodic_uniform(3, n).unwrap();
    Surface::new(space.clone(), space, (0..n * n).map(at).collect()).unwrap()
}

/// What fifty events allocate after two that have made room, handle at `from`.
fn allocations<S: Shape>(mut session: Session<S>, from: Point) -> u64 {
    let to = |i: u32| from + Vector::new(0.01 * f64::from(i % 7), 0.005 * f64::from(i % 3), 0.0);
    for i in 0..2 {
        session.to_point(to(3 + i)).unwrap();
    }
    let counted = measure(|| {
        for i in 0..50 {
            session.to_point(to(i)).unwrap();
        }
    });
    let adjustment = session.commit().unwrap().report().adjustment;
    assert!(adjustment > 1e-3, "the handle was dragged");
    counted.count_total
}

#[test]
fn an_event_that_keeps_an_area_or_a_volume_allocates_nothing() {
    let curve = ring(200);
    let from = curve.point(20.0).unwrap();
    let edit = Edit::new(&curve).ask(area().keep()).ask(position(120.0).keep()).handle(position(20.0));
    assert_eq!(allocations(edit.prepare(Automatic).unwrap(), from), 0, "area");
    let compound =
        Edit::new(&curve).with(Box::new(ring(30))).ask(area().of([0]).keep()).ask(area().on(1).scale(1.1));
    assert_eq!(
        allocations(compound.handle(position(20.0)).prepare(Automatic).unwrap(), from),
        0,
        "two areas"
    );
    let bent = Edit::new(&curve).ask(area().keep()).metric(Metric::Bend).ask(position(120.0).keep());
    assert_eq!(allocations(bent.handle(position(20.0)).prepare(Automatic).unwrap(), from), 0, "area, bent");
    let surface = torus(12);
    let at = [3.0, 3.0];
    let from = surface.point(3.0, 3.0).unwrap();
    let edit = Edit::new(&surface).ask(volume().keep()).handle(position(at));
    assert_eq!(allocations(edit.prepare(Automatic).unwrap(), from), 0, "volume");
    // Where the axes alternate, every event measures all constraints anew where the shape has come to: each with rows or
    // room of its own, so many whatever the size.
    let alternating = |n: usize| {
        let surface = torus(n);
        let from = surface.point(3.0, 3.0).unwrap();
        let edit = Edit::new(&surface).ask(volume().keep()).handle(position(at)).alternating();
        allocations(edit.prepare(Automatic).unwrap(), from)
    };
    let (few, many) = (alternating(12), alternating(24));
    assert!(few <= 50 * 20 && many <= few, "{few} and {many} in 50 events");
}

/// A cage of `n × n` faces over the plane, with a vertex of valence 3 and one of valence 5 beside its middle.
fn cage(n: usize) -> SubdivisionSurface {
    let at = |i: usize, j: usize| i * (n + 1) + j;
    let height = |i: usize, j: usize| 0.3 * (0.7 * i as f64).sin() * (0.5 * j as f64).cos();
    let all = 0..(n + 1) * (n + 1);
    let points =
        all.map(|k| (k / (n + 1), k % (n + 1))).map(|(i, j)| Point::new(i as f64, j as f64, height(i, j)));
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i, j) == (n / 2, n / 2) {
                faces.extend([quad[..3].to_vec(), vec![quad[0], quad[2], quad[3]]]);
            } else {
                faces.push(quad.to_vec());
            }
        }
    }
    SubdivisionSurface::new(Cage::new(points.collect(), &faces).unwrap()).unwrap()
}

#[test]
fn an_event_on_a_limit_surface_allocates_nothing() {
    let surface = cage(12);
    // A limit of valence 5, a regular one, a place of a face beside the uneven ones, and one within.
    for at in [
        Location::Vertex(84),
        Location::Vertex(45),
        Location::Face(80, 0.3, 0.4),
        Location::Face(79, 0.01, 0.99),
    ] {
        let from = Point::from(surface.value(at, Derivative::POSITION).unwrap());
        for metric in [Metric::Least, Metric::Falloff(3.0)] {
            let edit = Edit::new(&surface).metric(metric.clone()).ask(position(Location::Vertex(20)).keep());
            let session = edit.handle(position(at)).prepare(Automatic).unwrap();
            assert_eq!(allocations(session, from), 0, "{at} {metric:?}");
        }
    }
    let ball =
        SubdivisionSurface::new(loftsman::subdivision::catmull_clark::refine(&box_cage()).unwrap()).unwrap();
    let from = Point::from(ball.value(Location::Vertex(7), Derivative::POSITION).unwrap());
    let edit = Edit::new(&ball).ask(volume().keep()).handle(position(Location::Vertex(7)));
    assert_eq!(allocations(edit.prepare(Automatic).unwrap(), from), 0, "volume");
}

fn box_cage() -> Cage {
    let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Cage::new((0..8).map(corner).collect(), &faces).unwrap()
}

#[test]
fn an_event_on_a_limit_surface_does_not_depend_on_the_size_of_its_cage() {
    // What preparing allocates beyond the copy of the points stands for its work.
    let prepared = |n: usize| {
        let surface = cage(n);
        let mut session = None;
        let edit = Edit::new(&surface).handle(position(Location::Vertex(20)));
        let counted = measure(|| session = Some(edit.prepare(Adjoint).unwrap()));
        counted.count_total
    };
    let (few, many) = (prepared(12), prepared(60));
    assert!(many <= few + 4, "{few} and {many}");
}

/// Cages of 1025 and of 10,001 faces: a row, the first on its face and a second one, and an event round the odd vertices, on a regular vertex and on a
/// face ask for as much memory of either, to the byte; an event for none.
#[test]
fn rows_and_events_of_a_large_cage_allocate_what_those_of_a_small_one_do() {
    let counts = |n: usize| {
        let surface = cage(n);
        let faces = |i: usize, j: usize| ((n / 2 + i - 3) * n + n / 2 + j - 3) as u32;
        let vertex = |i: usize, j: usize| ((n / 2 + i - 3) * (n + 1) + n / 2 + j - 3) as u32;
        let places = [
            Location::Face(faces(0, 0), 0.3, 0.6),
            Location::Face(faces(2, 3), 0.9, 0.99),
            Location::Face(faces(3, 3), 0.01, 0.02),
            Location::Vertex(vertex(0, 0)),
            Location::Vertex(vertex(3, 3)),
            Location::Vertex(vertex(3, 4)),
        ];
        let row = |at: Location| {
            let counted = measure(|| drop(surface.stencil(at, Derivative::POSITION).unwrap()));
            (counted.count_total, counted.bytes_total)
        };
        let rows = places.map(|at| [row(at), row(at)]);
        let events = places.map(|at| {
            let from = Point::from(surface.value(at, Derivative::POSITION).unwrap());
            let session = Edit::new(&surface).handle(position(at)).prepare(Adjoint).unwrap();
            allocations(session, from)
        });
        (rows, events)
    };
    let (few, many) = (counts(32), counts(100));
    assert_eq!(few, many);
    assert_eq!(few.1, [0; 6]);
    assert!(few.0.iter().flatten().all(|(count, _)| *count <= 400), "{few:?}");
}

#[test]
fn preparing_does_not_depend_on_the_size_of_the_curve() {
    // Allocated bytes stand for work here: the same on every machine, and any pass over all vertices would show.
    let bytes = |vertices| {
        let curve = coil(vertices);
        let mut session = None;
        let counted = measure(|| {
            let edit = Edit::of(curve).ask(position(1.5).keep()).handle(position(4.5));
            session = Some(edit.prepare(Automatic).unwrap());
        });
        assert!(session.is_some());
        counted.bytes_total
    };
    assert_eq!(bytes(100), bytes(100_000));
}

#[test]
fn a_mouse_down_and_an_edit_ask_for_memory_a_few_times_only() {
    // Kept in place as far as one place of a cubic goes: what is left are the parts that others hold (rows, columns, the factor)
    // and the report. So many whatever the size of the curve.
    let down = |vertices| {
        let curve = coil(vertices);
        let mut session = None;
        let counted = measure(|| session = Some(Edit::of(curve).handle(position(4.5)).prepare(Automatic)));
        assert!(session.is_some_and(|session| session.is_ok()));
        counted.count_total
    };
    let edit = |vertices| {
        let curve = coil(vertices);
        let mut edited = None;
        let counted = measure(|| {
            let moved = position(4.5).to(Point::new(1.0, 2.0, 3.0));
            edited = Some(Edit::of(curve).ask(moved).solve());
        });
        assert!(edited.is_some_and(|edited| edited.is_ok()));
        counted.count_total
    };
    let (few, many) = ([down(12), edit(12)], [down(100_000), edit(100_000)]);
    assert_eq!(few, many);
    assert!(few[0] <= 16 && few[1] <= 24, "{few:?}");
}

#[test]
fn a_mouse_down_with_many_constraints_asks_for_memory_once_for_all() {
    // Beside what a caller allocates to say them (one functional each).
    let prepare = |constraints: u32, vertices: usize| {
        let at = |k: u32| 1.5 + 4.0 * f64::from(k);
        let edit = Edit::of(coil(vertices)).handle(position(0.5));
        let edit = (0..constraints).fold(edit, |edit, k| edit.ask(position(at(k)).keep()));
        let mut session = None;
        let counted = measure(|| session = Some(edit.prepare(Automatic)));
        assert!(session.is_some_and(|session| session.is_ok()));
        counted.count_total
    };
    let [ten, hundred] = [10, 100].map(|constraints| prepare(constraints, 1000));
    assert_eq!(hundred, prepare(100, 100_000));
    assert!(hundred <= ten + 12 && hundred <= 64, "{ten} and {hundred}");
}

/// A rope through 14 rings, and a sheet on four places: each step and each advance after the first few, explicit and implicit.
#[test]
fn a_step_of_a_simulation_allocates_nothing() {
    use loftsman::dynamics::{Body, Scheme, Setup, fixed, sliding};
    for scheme in [Scheme::Epsilon, Scheme::Exact, Scheme::Implicit] {
        let rope = coil(60);
        let mut setup = Setup::new(Body::new(&rope).mass(0.1).stiffness(50.0)).gravity([0.0, 0.0, -9.81]);
        for i in 0..14 {
            setup = setup.hold(sliding(3.0 + 3.7 * f64::from(i)));
        }
        let mut rope = setup.scheme(scheme).prepare().unwrap();
        let space = Space::clamped_uniform(3, 7).unwrap();
        let points = (0..49).map(|k| Point::new(f64::from(k / 7), f64::from(k % 7), 0.1 * f64::from(k % 5)));
        let sheet = Surface::new(space.clone(), space, points.collect()).unwrap();
        let sheet = Setup::new(Body::new(&sheet)).gravity([0.0, 0.0, -9.81]).hold(fixed([0.0, 0.0]));
        let sheet = sheet.hold(sliding([1.0, 3.0])).hold(sliding([3.0, 1.0])).hold(sliding([2.5, 2.5]));
        let mut sheet = sheet.scheme(scheme).prepare().unwrap();
        for simulation in [&mut rope, &mut sheet] {
            let step = 0.5 * simulation.stable_step();
            for _ in 0..5 {
                simulation.step(step).unwrap();
            }
            let counted = measure(|| (0..50).for_each(|_| simulation.step(step).unwrap()));
            assert_eq!(counted.count_total, 0, "{scheme:?}: {counted:?}");
            // Of many steps each, taken again where constraints drift; rooms have their sizes after a while.
            for _ in 0..25 {
                simulation.advance(1.0 / 60.0).unwrap();
            }
            let before = simulation.sub_steps();
            let counted = measure(|| (0..20).for_each(|_| simulation.advance(1.0 / 60.0).unwrap()));
            assert_eq!(counted.count_total, 0, "{scheme:?}: {counted:?}");
            assert!(simulation.sub_steps() >= before + 20);
        }
    }
}
