//! What edits of faces tell, and what they refuse.

use loftsman_kernel::Vector;
use loftsman_kernel::brep::{Brep, Moving, SurfaceForm};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::Surface;

use super::edits::pulled;
use super::family::{block, cylinder, parted_ball};

/// The largest angle in degrees, by differences of points, between normals at places of a face that are so many two-hundredths of its domain apart in one direction.
fn turn(brep: &Brep, face: u32, apart: usize) -> f64 {
    let surface = brep.surface(face as usize).unwrap();
    let part = brep.part(face as usize).unwrap();
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let count = 200;
    let place = |i: usize, j: usize| {
        let share = |k: usize| (k as f64 + 0.5) / count as f64;
        [a + (b - a) * share(i), c + (d - c) * share(j)]
    };
    let normal = |[u, v]: [f64; 2]| {
        let (h, k) = (1e-5 * (b - a), 1e-5 * (d - c));
        let along = surface.point(u + h, v).unwrap() - surface.point(u - h, v).unwrap();
        let across = surface.point(u, v + k).unwrap() - surface.point(u, v - k).unwrap();
        along.cross(&across).normalize()
    };
    let all: Vec<Option<Vector>> = (0..count * count)
        .map(|k| place(k / count, k % count))
        .map(|at| part.has(at).then(|| normal(at)))
        .collect();
    let mut worst = 0.0_f64;
    for i in 0..count - apart {
        for j in 0..count - apart {
            for there in [(i + apart) * count + j, i * count + j + apart] {
                if let (Some(m), Some(n)) = (all[i * count + j], all[there]) {
                    worst = worst.max(m.cross(&n).norm().atan2(m.dot(&n)).to_degrees());
                }
            }
        }
    }
    worst
}

/// What is pulled along its own face farther than this reaches lies on itself, which the report tells with the face and the place; what bulges, or goes
/// along a little, does not.
#[test]
fn a_face_that_lies_on_itself_is_told() {
    let (mut folded, mut sound) = (0, 0);
    let far = [Vector::new(1.9, 0.3, 0.0), Vector::new(0.0, 1.4, 1.6), Vector::new(-1.7, 0.1, -1.2)];
    let short = [Vector::new(0.05, 0.03, 0.04), Vector::new(-0.02, 0.06, 0.3)];
    for brep in [block(), cylinder(1.5, 2.0), parted_ball(Vector::new(0.4, 0.2, 1.0), 0.0)] {
        for face in 0..brep.face_count() as u32 {
            let (surface, part) = (brep.surface(face as usize).unwrap(), brep.part(face as usize).unwrap());
            let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
            let places = [[0.5, 0.5], [0.25, 0.75], [0.75, 0.25], [0.4, 0.8], [0.6, 0.2]]
                .map(|[s, t]| [a + (b - a) * s, c + (d - c) * t]);
            let [u, v] = places.into_iter().find(|at| part.has(*at)).unwrap();
            let at = Location::Face(face, u, v);
            for by in far.into_iter().chain(short) {
                let edited = pulled(&brep, at, by);
                let report = edited.report().to_string();
                let told = report.contains(&format!("face {face} is folded over: its normal turns by"));
                // What turns in less than what is looked at does, what does not turn in more does not.
                let near = turn(edited.shape(), face, 1);
                let far = [2, 3, 4].map(|apart| turn(edited.shape(), face, apart));
                let far = far.into_iter().fold(near, f64::max);
                if near > 130.0 {
                    assert!(told, "{face}, {by}: turns by {near}°\n{report}");
                    folded += 1;
                } else if far < 110.0 {
                    assert!(!told, "{face}, {by}: turns by {far}°\n{report}");
                    sound += 1;
                }
            }
        }
    }
    assert!(folded >= 10 && sound >= 39, "{folded} folded, {sound} not");
}

/// A ball in two parts whose poles are points but for what files leave: faces keep what reaches to them beyond their loops.
#[test]
fn poles_with_noise_are_poles() {
    for noise in [0.0, 1e-9, 2e-8] {
        let mut parts = parted_ball(Vector::new(0.4, 0.2, 1.0), 0.0).parts();
        for face in &mut parts.faces {
            let (rows, columns) = (face.surface.u().len(), face.surface.v().len());
            let (u, v, mut points, weights) = face.surface.clone().into_parts();
            for (k, point) in points.iter_mut().enumerate() {
                if [0, columns - 1].contains(&(k % columns)) {
                    // The seam's two sides are one, so that it can be put elsewhere.
                    let row = k / columns % (rows - 1);
                    let wave = |by: f64| noise * (by * row as f64).sin();
                    *point += Vector::new(wave(1.7), wave(2.9), wave(0.6));
                }
            }
            face.surface = Surface::build(u, v, points, weights).unwrap();
            face.form = SurfaceForm::Spline;
        }
        // As files say how exact they are.
        parts.edges[0].tolerance = 8.0 * noise;
        let ball = Brep::new(parts).unwrap();
        for face in 0..2 {
            let ends = ball.surface(face as usize).unwrap().v().domain();
            for neighbours in [0, 1] {
                let free = ball.clone().moving(Moving::new().sharp().neighbours(neighbours));
                let part = ball.part(face as usize).unwrap();
                let pole = [ends.0, ends.1]
                    .into_iter()
                    .find(|end| part.has([1.0, 0.9 * end + 0.1 * 0.5 * (ends.0 + ends.1)]));
                let pole = pole.unwrap();
                let at = Location::Face(face, 1.0, 0.8 * pole + 0.2 * 0.5 * (ends.0 + ends.1));
                let asked = position(at).by(Vector::new(0.05, -0.1, 0.08));
                let edited = Edit::new(&free).smooth(0).ask(asked).solve().unwrap();
                let after = edited.shape().surface(face as usize).unwrap();
                let (low, high) = after.v().domain();
                assert!([low, high].contains(&pole), "{noise:e}: [{low}, {high}] and the pole is at {pole}");
                let points = [0.0, 0.3, 0.7].map(|share| {
                    let (a, b) = after.u().domain();
                    after.point(a + share * (b - a), pole).unwrap()
                });
                let wide = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
                assert!(wide <= 4.0 * noise + 1e-12, "{noise:e}: a pole is {wide:e} wide");
            }
        }
    }
}

/// The corners of a cap's rectangle are in its surface's domain and not on the face: nothing can be asked of them. Its rim is on it.
#[test]
fn places_outside_loops_are_refused() {
    let cylinder = cylinder(1.5, 2.0);
    for face in 1..3 {
        let surface = cylinder.surface(face as usize).unwrap();
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        for (s, t) in [(0.01, 0.01), (0.99, 0.02), (0.03, 0.97), (0.98, 0.98)] {
            let at = Location::Face(face, a + (b - a) * s, c + (d - c) * t);
            for neighbours in [0, 1] {
                let free = cylinder.clone().moving(Moving::new().neighbours(neighbours));
                let asked = position(at).by(Vector::new(0.0, 0.0, 0.1));
                let told = Edit::new(&free).ask(asked).solve().unwrap_err().to_string();
                assert!(told.contains(&format!("a place on face {face}: (u, v) = (")), "{told}");
                assert!(told.contains("is outside its loops"), "{told}");
            }
        }
        let rim = cylinder.parameter_curves(face as usize).unwrap();
        let on = rim[0][0].curve.curve().point(0.7).unwrap();
        let free = cylinder.clone().moving(Moving::new().neighbours(1));
        pulled(&free, Location::Face(face, on.x, on.y), Vector::new(0.02, 0.0, 0.05));
    }
}
