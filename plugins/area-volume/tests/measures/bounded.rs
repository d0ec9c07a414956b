//! Edits of surface areas end after bounded work, solved or refused.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use loftsman_area_volume::surface_area;
use loftsman_kernel::Result;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Accuracy, Functional, Linearity, Rows, Shapes, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::Surface;

use crate::folded::{area_of_triangles, random, torus};

/// A surface area that counts how often it is asked for.
#[derive(Debug, Clone)]
struct Counted {
    area: Arc<dyn Functional>,
    looks: Arc<AtomicUsize>,
}

impl Counted {
    fn look(&self) -> &dyn Functional {
        self.looks.fetch_add(1, Ordering::Relaxed);
        self.area.as_ref()
    }
}

impl Functional for Counted {
    fn equations(&self) -> usize {
        self.area.equations()
    }

    fn linearity(&self) -> Linearity {
        self.area.linearity()
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.look().rows(shapes, rows)
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        self.look().linearize(shapes, rows, value)
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        self.look().value(shapes, out)
    }

    fn check_target(&self, present: &[f64], wanted: &[f64]) -> Result<()> {
        self.area.check_target(present, wanted)
    }

    fn describe(&self) -> String {
        self.area.describe()
    }

    fn accuracy(&self) -> Accuracy {
        self.area.accuracy()
    }

    fn effort(&self) -> usize {
        self.area.effort()
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let area = self.look().bind(shapes)?.unwrap_or_else(|| Arc::clone(&self.area));
        Ok(Some(Arc::new(Self { area, looks: Arc::clone(&self.looks) })))
    }
}

/// What an edit of a torus came to, and how many evaluations of the surface it may have taken.
fn edited(surface: &Surface, scale: f64, moved: bool) -> (std::result::Result<Surface, String>, usize) {
    let shapes: [&dyn Shape; 1] = [surface];
    let effort = surface_area().bind(&Shapes::new(shapes)).unwrap().unwrap().effort();
    let looks = Arc::new(AtomicUsize::new(0));
    let area = Counted { area: Arc::new(surface_area()), looks: Arc::clone(&looks) };
    let mut edit = Edit::new(surface).ask(if scale == 1.0 { area.keep() } else { area.scale(scale) });
    if moved {
        edit = edit.ask(position([0.5, 0.5]).by([0.5, 0.2, 0.4]));
    }
    let done = edit.solve().map(|edited| edited.shape().clone()).map_err(|e| e.to_string());
    (done, looks.load(Ordering::Relaxed) * effort)
}

/// Evaluations that an edit may take: 30 million of an event and as many to settle, and what it takes to prepare and to
/// measure; where the event does not arrive, a quarter more instead, for shortened steps.
const MOST: usize = 60_000_000;

/// What was done, judged by triangles; or what is said.
fn judge(surface: &Surface, scale: f64, moved: bool, what: &str) -> bool {
    let (done, work) = edited(surface, scale, moved);
    assert!(work <= MOST, "{what}: {work} evaluations");
    match done {
        Ok(after) => {
            let times = area_of_triangles(&after, 6) / area_of_triangles(surface, 6);
            assert!((times / scale - 1.0).abs() < 0.1, "{what}: {times}");
            true
        }
        Err(text) => {
            let (named, advice) = (text.contains("surface area"), text.contains("ask for less at once"));
            assert!(named && (advice || text.contains("has no area")), "{what}: {text}");
            false
        }
    }
}

#[test]
fn edits_of_tori_of_any_proportions_end_soon() {
    let (mut members, mut plain, mut refused) = (0, 0, 0);
    for seed in 0..100 {
        let mut next = random(seed);
        // Mostly small nets.
        let (a, b) = (next(), next());
        let (around, across) = (6 + (14.9 * a * a * a) as usize, 6 + (14.9 * b * b * b) as usize);
        let ring = 0.3 + 2.7 * next();
        let tube = if seed % 5 == 0 { 10_f64.powf(-9.0 * next()) } else { 2.5 * next() };
        let scale = if next() < 0.5 { 1.0 } else { 0.01 + 1.49 * next() };
        let moved = next() < 0.5;
        let what = format!("{seed}: {ring} {tube:e} {around}x{across} by {scale}, {moved}");
        let done = judge(&torus(3, around, across, ring, tube, 1.0), scale, moved, &what);
        members += 1;
        // A tube that is neither a thread nor meets its axis, at an area that it can have without folding.
        if tube < 0.8 * ring && tube > 0.2 && (0.6..=1.5).contains(&scale) {
            plain += 1;
            refused += usize::from(!done);
        }
    }
    assert!(members == 100 && plain >= 20 && refused == 0, "{members} {plain} {refused}");
}

#[test]
fn large_nets_and_threads_end_soon() {
    let cases = [
        (2.0, 2.2, 20, 20, 1.3, false),
        (2.0, 2.2, 20, 20, 0.01, true),
        (1.0, 1.5, 8, 6, 0.01, true),
        (0.5, 2.0, 12, 12, 1.3, false),
        (1.0, 1e-9, 8, 6, 1.0, true),
    ];
    for (ring, tube, around, across, scale, moved) in cases {
        let what = format!("{ring} {tube:e} {around}x{across} by {scale}, {moved}");
        judge(&torus(3, around, across, ring, tube, 1.0), scale, moved, &what);
    }
}

#[test]
fn what_is_refused_says_how_far_it_came() {
    let (done, work) = edited(&torus(3, 8, 6, 1.0, 1.5, 1.0), 0.01, true);
    let text = done.unwrap_err();
    assert!(text.starts_with("not solved after ") && work < MOST, "{work}: {text}");
    let wanted = text.split("(in \"surface area\", ").nth(1).unwrap();
    assert!(wanted.ends_with(" wanted); ask for less at once"), "{text}");
}
