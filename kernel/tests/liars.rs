//! Functionals and shapes that are not what they say: told by name, in sessions and by the conformance suite; none hangs
//! or panics.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_kernel::conformance::{declared_functional_conformance, functional_conformance, sample_shapes};
use loftsman_kernel::edit::{Ask, Constraint, Edit, EditError, Metric, Wanted};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{
    self, DeclaredFunctional, Functional, Linearity, Rows, ShapeNames, Shapes, position, rows_of,
};
use loftsman_kernel::plugin::{Declaration, Field, ParameterError, Parameters, Registry, constraint_from};
use loftsman_kernel::shape::{Derivative, Domain, Grid, Location, Shape, Stencil};
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, HouseholderQr, SaddlePoint, Solver, Sparse, Symmetric,
};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::json;

type Put = fn(&Shapes<'_>, &mut Rows<'_>);
type Tell = fn(&Shapes<'_>, &mut [f64]);

/// A functional whose every answer can be made wrong. The honest one is `Σ P_i.x / 4` over the first four vertices.
#[derive(Debug, Clone)]
struct Liar {
    equations: usize,
    linearity: Linearity,
    rows: Put,
    value: Option<Tell>,
    vector: bool,
    at: Option<(usize, Location)>,
    completes: Option<usize>,
    linearize: Option<Tell>,
    fails: bool,
    refuses: bool,
}

fn honest(_: &Shapes<'_>, rows: &mut Rows<'_>) {
    rows.equation();
    for vertex in 0..4 {
        rows.term(0, vertex, Vector::x() * 0.25);
    }
}

fn mean(shapes: &Shapes<'_>) -> f64 {
    (0..4).map(|v| shapes.vertex(v).x * 0.25).sum()
}

const HONEST: Liar = Liar {
    equations: 1,
    linearity: Linearity::Linear,
    rows: honest,
    value: None,
    vector: false,
    at: None,
    completes: None,
    linearize: None,
    fails: false,
    refuses: false,
};

impl Functional for Liar {
    fn equations(&self) -> usize {
        self.equations
    }

    fn linearity(&self) -> Linearity {
        self.linearity
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        if self.fails {
            return Err(Error::Invalid("it does not feel like it".into()));
        }
        (self.rows)(shapes, rows);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        match self.value {
            Some(tell) => tell(shapes, out),
            None => {
                let mut store = functional::Store::default();
                self.rows(shapes, &mut store.rows(shapes))?;
                store.evaluate(shapes, out);
            }
        }
        Ok(())
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        self.value(shapes, value)?;
        if let Some(tell) = self.linearize {
            tell(shapes, value);
        }
        self.rows(shapes, rows)
    }

    fn check_target(&self, _: &[f64], _: &[f64]) -> Result<()> {
        if self.refuses { Err(Error::Invalid("whatever".into())) } else { Ok(()) }
    }

    fn describe(&self) -> String {
        "what the liar says".into()
    }

    fn is_vector(&self) -> bool {
        self.vector
    }

    fn location(&self) -> Option<(usize, Location)> {
        self.at
    }

    fn complete(&self, _: &[f64]) -> Option<Vec<f64>> {
        self.completes.map(|count| vec![0.0; count])
    }
}

fn squares(shapes: &Shapes<'_>, rows: &mut Rows<'_>) {
    rows.equation();
    for vertex in 0..4 {
        rows.term(0, vertex, Vector::x() * (2.0 * shapes.vertex(vertex).x));
    }
}

fn sum_of_squares(shapes: &Shapes<'_>, out: &mut [f64]) {
    out[0] = (0..4).map(|v| shapes.vertex(v).x.powi(2)).sum();
}

/// Each with a word of the error that a session must give, where it can know.
fn liars() -> Vec<(&'static str, Liar, Option<&'static str>)> {
    let quadratic = Liar { rows: squares, value: Some(sum_of_squares), ..HONEST };
    vec![
        (
            "names a vertex beyond all",
            Liar {
                rows: |_, r| {
                    r.equation().term(0, 999, Vector::x());
                },
                ..HONEST
            },
            Some("999"),
        ),
        (
            "names the largest number",
            Liar {
                rows: |_, r| {
                    r.equation().term(0, usize::MAX, Vector::x());
                },
                ..HONEST
            },
            Some("not there"),
        ),
        (
            "names a vertex just behind the last",
            Liar {
                rows: |s, r| {
                    r.equation().term(0, s.offset(1), Vector::x());
                },
                ..HONEST
            },
            Some("not there"),
        ),
        (
            "names another shape",
            Liar {
                rows: |_, r| {
                    r.equation().term(7, 0, Vector::x());
                },
                ..HONEST
            },
            Some("shape 7"),
        ),
        (
            "has a stencil that is elsewhere",
            Liar {
                equations: 3,
                rows: |_, r| r.alike(0, &Stencil::from_iter([(0, 1.0), (500, 1.0)])),
                ..HONEST
            },
            Some("500"),
        ),
        (
            "has a difference that is elsewhere",
            Liar {
                equations: 3,
                rows: |_, r| {
                    r.difference((0, &Stencil::from_iter([(0, 1.0)])), (3, &Stencil::from_iter([(0, 1.0)])));
                },
                ..HONEST
            },
            Some("shape 3"),
        ),
        (
            "runs over the end",
            Liar {
                rows: |s, r| {
                    r.equation().terms(0, 2, vec![Vector::x(); s.vertex_count()].into_iter());
                },
                ..HONEST
            },
            Some("not there"),
        ),
        (
            "runs from the largest number",
            Liar {
                rows: |_, r| {
                    r.equation().terms(0, usize::MAX - 1, vec![Vector::x(); 5].into_iter());
                },
                ..HONEST
            },
            Some("not there"),
        ),
        (
            "has a NaN",
            Liar {
                rows: |_, r| {
                    r.equation().term(0, 1, Vector::x() * f64::NAN);
                },
                value: Some(|s, o| o[0] = mean(s)),
                ..HONEST
            },
            Some("finite"),
        ),
        (
            "has an infinity",
            Liar {
                rows: |_, r| {
                    r.equation().term(0, 1, Vector::x() * f64::INFINITY);
                },
                value: Some(|s, o| o[0] = mean(s)),
                ..HONEST
            },
            Some("finite"),
        ),
        (
            "has a stencil with a NaN",
            Liar {
                equations: 3,
                rows: |_, r| r.alike(0, &Stencil::from_iter([(0, f64::NAN)])),
                value: Some(|_, o| o.fill(0.0)),
                ..HONEST
            },
            Some("finite"),
        ),
        (
            "has an infinite constant",
            Liar {
                rows: |s, r| {
                    honest(s, r);
                    r.constant(Vector::x() * f64::INFINITY);
                },
                value: Some(|s, o| o[0] = mean(s)),
                ..HONEST
            },
            Some("constant"),
        ),
        (
            "gives a constant first",
            Liar {
                rows: |s, r| {
                    r.constant(Vector::x());
                    honest(s, r);
                },
                ..HONEST
            },
            Some("before it has opened"),
        ),
        ("says two and appends one", Liar { equations: 2, ..HONEST }, Some("2 equations")),
        (
            "says two, appends one and writes two",
            Liar { equations: 2, value: Some(|s, o| o.fill(mean(s))), ..HONEST },
            Some("appends 1"),
        ),
        (
            "says one and appends three",
            Liar { rows: |_, r| r.alike(0, &Stencil::from_iter([(0, 1.0)])), ..HONEST },
            Some("appends 3"),
        ),
        (
            "says one and appends none",
            Liar { rows: |_, _| {}, value: Some(|s, o| o[0] = mean(s)), ..HONEST },
            Some("appends 0"),
        ),
        (
            "has more equations than there are numbers",
            Liar { equations: usize::MAX, ..HONEST },
            Some("at most"),
        ),
        ("writes nothing", Liar { value: Some(|_, _| {}), ..HONEST }, Some("writes 0 values")),
        (
            "writes half",
            Liar {
                equations: 3,
                rows: |_, r| r.alike(0, &Stencil::from_iter([(0, 1.0)])),
                value: Some(|_, o| o[0] = 1.0),
                ..HONEST
            },
            Some("writes 1 value"),
        ),
        ("writes NaN", Liar { value: Some(|_, o| o[0] = f64::NAN), ..HONEST }, Some("NaN")),
        ("refuses what it has", Liar { refuses: true, ..HONEST }, Some("whatever")),
        ("always fails", Liar { fails: true, ..HONEST }, Some("feel like it")),
        // What only the suite can see: a session measures what comes of it.
        ("is a quadratic and says linear", quadratic.clone(), None),
        (
            "is a cubic and says linear",
            Liar {
                rows: |s, r| {
                    r.equation().term(0, 0, Vector::x() * (3.0 * s.vertex(0).x.powi(2)));
                },
                value: Some(|s, o| o[0] = s.vertex(0).x.powi(3)),
                ..HONEST
            },
            None,
        ),
        (
            "is a quadratic and says multilinear",
            Liar { linearity: Linearity::Multilinear, ..quadratic.clone() },
            None,
        ),
        (
            "has another gradient",
            Liar { linearity: Linearity::Nonlinear, rows: honest, value: Some(sum_of_squares), ..HONEST },
            None,
        ),
        (
            "has another value than its rows",
            Liar { value: Some(|s, o| o[0] = 2.0 * mean(s)), ..HONEST },
            None,
        ),
        ("has a value off by a constant", Liar { value: Some(|s, o| o[0] = mean(s) + 1.0), ..HONEST }, None),
        (
            "has rows that are right at the start only",
            Liar {
                linearity: Linearity::Nonlinear,
                rows: |s, r| {
                    squares(s, r);
                    if s.vertex(0).x != s.get(0).unwrap().control_vertices()[0].x {
                        r.equation();
                    }
                },
                value: Some(|s, o| {
                    sum_of_squares(s, o);
                    o[0] *= 1.1;
                }),
                ..HONEST
            },
            None,
        ),
        ("says that it is a vector", Liar { vector: true, ..HONEST }, None),
        ("is nowhere", Liar { at: Some((0, Location::Curve(1e9))), ..HONEST }, None),
        ("is on no shape", Liar { at: Some((9, Location::Curve(0.5))), ..HONEST }, None),
        (
            "completes to too many",
            Liar {
                equations: 3,
                rows: |_, r| r.alike(0, &Stencil::from_iter([(0, 1.0)])),
                completes: Some(5),
                ..HONEST
            },
            None,
        ),
        ("gives another value with its rows", Liar { linearize: Some(|_, o| o[0] += 1.0), ..HONEST }, None),
        ("panics", Liar { value: Some(|_, _| panic!("out of the window")), ..HONEST }, None),
    ]
}

fn cubic() -> Curve {
    let points =
        (0..8).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.5 * f64::from(i % 3))).collect();
    Curve::new(Space::clamped_uniform(3, 8).unwrap(), points).unwrap()
}

fn solvers() -> Vec<Arc<dyn Solver>> {
    vec![
        Arc::new(Automatic),
        Arc::new(Sparse),
        Arc::new(Adjoint),
        Arc::new(HouseholderQr),
        Arc::new(SaddlePoint),
        Arc::new(DenseLu),
    ]
}

fn edit(liar: &Liar, wanted: Wanted, solver: Arc<dyn Solver>) -> Result<(), EditError> {
    let constraint = Constraint::new(Arc::new(liar.clone()), wanted);
    Edit::new(&cubic()).ask(constraint).ask(position(0.5).by([0.0, 0.1, 0.0])).solve_with(solver).map(|_| ())
}

#[test]
fn honesty_passes() {
    let verdict = functional_conformance(&HONEST, &[Box::new(cubic())]);
    assert!(verdict.passed(), "{verdict}");
    edit(&HONEST, Wanted::By(0.5.into()), Arc::new(Automatic)).unwrap();
}

#[test]
fn the_suite_sees_every_lie() {
    assert!(liars().len() >= 30);
    for (lie, liar, _) in liars() {
        let mut shapes = sample_shapes(false);
        shapes.truncate(1);
        let verdict = functional_conformance(&liar, &shapes);
        assert!(
            !verdict.passed() && !verdict.failures.is_empty(),
            "a functional that {lie} passes: {verdict}"
        );
        let shown = verdict.to_string();
        assert!(
            shown.contains("liar") || lie == "panics" && shown.contains("out of the window"),
            "{lie}: {shown}"
        );
    }
}

#[test]
fn sessions_name_the_liar() {
    for (lie, liar, word) in liars() {
        if lie == "panics" {
            continue;
        }
        for solver in solvers() {
            for wanted in [Wanted::Keep, Wanted::By(vec![0.1; liar.equations.min(3)].into())] {
                let result = edit(&liar, wanted.clone(), Arc::clone(&solver));
                let Some(word) = word else { continue };
                let error = result.expect_err(lie).to_string();
                assert!(error.contains(word), "{lie} ({}): {error}", solver.name());
                assert!(
                    error.contains("what the liar says")
                        || lie == "always fails"
                        || lie == "refuses what it has",
                    "{lie}: {error}"
                );
            }
        }
    }
}

/// A liar as the handle, among inequalities, and beside others that it must not touch.
#[test]
fn wherever_a_liar_comes_in() {
    for (lie, liar, word) in liars() {
        if lie == "panics" || lie == "refuses what it has" {
            continue;
        }
        let shared: Arc<dyn Functional> = Arc::new(liar.clone());
        let dragged = Edit::new(&cubic()).shared_handle(Arc::clone(&shared)).prepare(Automatic);
        let limit =
            Constraint::new(Arc::clone(&shared), Wanted::AtLeast(vec![-9.0; liar.equations.min(3)].into()));
        let bounded = Edit::new(&cubic()).ask(limit).ask(position(0.5).by([0.0, 0.1, 0.0])).solve();
        let curved = Edit::new(&cubic())
            .ask(functional::magnitude(0.3).scale(1.2))
            .ask(Constraint::new(shared, Wanted::Keep))
            .solve();
        if let Some(word) = word {
            for error in [
                dragged.map(|_| ()).expect_err(lie),
                bounded.map(|_| ()).expect_err(lie),
                curved.map(|_| ()).expect_err(lie),
            ] {
                assert!(error.to_string().contains(word), "{lie}: {error}");
            }
        }
    }
}

/// Rows at random: vertices, shapes, counts and numbers of all sorts.
#[derive(Debug)]
struct Hostile {
    seed: u64,
    equations: usize,
    linearity: Linearity,
}

impl Functional for Hostile {
    fn equations(&self) -> usize {
        self.equations
    }

    fn linearity(&self) -> Linearity {
        self.linearity
    }

    fn rows(&self, _: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let mut state = self.seed;
        let mut below = |limit: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % limit
        };
        let numbers = [0.0, 1.0, -2.5, 1e-300, 1e300, f64::NAN, f64::INFINITY, -0.0, 3.0, 0.1, 7.0, -1.0];
        let vertices = [0, 1, 2, 3, 4, 5, 6, 7, 0, 3, 8, 9, 100, usize::MAX, usize::MAX - 1, 1 << 40];
        let shapes = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, usize::MAX];
        // Most members are sound but for a thing or two.
        let sound = below(3) > 0;
        for _ in 0..below(6) {
            let vertex = |below: &mut dyn FnMut(usize) -> usize| vertices[below(if sound { 10 } else { 16 })];
            let number =
                |below: &mut dyn FnMut(usize) -> usize| numbers[if sound { 8 + below(4) } else { below(12) }];
            let shape = shapes[below(if sound { 8 } else { 12 })];
            match below(6) {
                0 => {
                    let terms = below(5);
                    let stencil: Stencil =
                        (0..terms).map(|_| (vertex(&mut below), number(&mut below))).collect();
                    rows.alike(shape, &stencil);
                }
                1 => {
                    let one = Stencil::from_iter([(vertex(&mut below), number(&mut below))]);
                    let two = Stencil::from_iter([(vertex(&mut below), number(&mut below))]);
                    rows.difference((shape, &one), (0, &two));
                }
                2 => {
                    let run = vec![Vector::repeat(number(&mut below)); below(12)];
                    rows.terms(shape, vertex(&mut below), run.into_iter());
                }
                3 => {
                    rows.constant(Vector::repeat(number(&mut below)));
                }
                _ => {
                    rows.equation();
                    for _ in 0..below(6) {
                        let v = vertex(&mut below);
                        let vector = Vector::new(number(&mut below), number(&mut below), number(&mut below));
                        rows.term(shape, v, vector);
                    }
                }
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("hostile {}", self.seed)
    }
}

#[test]
fn hostile_rows_by_the_thousand() {
    let (mut solved, mut named, mut other) = (0, 0, 0);
    for seed in 0..2000 {
        let linearity = [Linearity::Linear, Linearity::Multilinear, Linearity::Nonlinear][seed as usize % 3];
        let hostile = |equations| Hostile { seed, equations, linearity };
        // Half of them count right.
        let curve = cubic();
        let shapes = Shapes::one(&curve);
        let mut store = functional::Store::default();
        let _ = hostile(0).rows(&shapes, &mut store.rows(&shapes));
        let count = store
            .equations()
            .map(|e| if matches!(e, functional::Equation::Alike { .. }) { 3 } else { 1 })
            .sum();
        let liar = hostile(if seed % 2 == 0 { count } else { seed as usize % 7 });
        let sound = rows_of(&liar, &shapes, &mut functional::Store::default().rows(&shapes)).is_ok();
        let solver = Arc::clone(&solvers()[seed as usize % 5]);
        let edit = Edit::new(&curve).ask(Constraint::new(Arc::new(liar), Wanted::Keep));
        match edit.ask(position(0.5).by([0.0, 0.1, 0.0])).solve_with(solver) {
            Ok(_) => {
                assert!(sound, "{seed}: unsound rows are solved");
                solved += 1;
            }
            Err(error) if error.to_string().contains(&format!("hostile {seed}")) => named += 1,
            Err(error) => {
                assert!(sound, "{seed}: {error}");
                other += 1;
            }
        }
    }
    println!("{solved} solved, {named} named, {other} refused for other reasons");
    assert!(solved > 200 && named > 600 && other < 500, "{solved} solved, {named} named, {other} other");
}

#[test]
fn the_suite_survives_hostile_rows() {
    let mut passed = 0;
    for seed in 0..300 {
        let liar = Hostile { seed, equations: seed as usize % 5, linearity: Linearity::Linear };
        let verdict = functional_conformance(&liar, &[Box::new(cubic())]);
        passed += usize::from(verdict.passed());
        assert!(verdict.passed() || verdict.failures.iter().any(|f| f.contains("hostile")), "{verdict}");
        assert!(!verdict.to_string().contains("panics"), "{verdict}");
    }
    assert!(passed < 100, "{passed} pass");
}

/// A curve that lies about what it is made of.
#[derive(Debug, Clone)]
struct Crooked {
    inner: Curve,
    short: Vec<Point>,
    lie: usize,
}

impl Shape for Crooked {
    fn control_vertices(&self) -> &[Point] {
        self.inner.points()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        if self.lie == 0 { &mut self.short } else { self.inner.control_vertices_mut() }
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let mut stencil = self.inner.stencil(at, derivative)?;
        match self.lie {
            1 => stencil.add(8, 0.5),
            2 => stencil.add(usize::MAX, 0.5),
            3 => stencil.add(2, f64::NAN),
            4 => stencil.add(2, f64::INFINITY),
            _ => {}
        }
        Ok(stencil)
    }

    fn domain(&self) -> Domain {
        let mut domain = Shape::domain(&self.inner);
        match self.lie {
            5 => domain.clear(),
            6 => domain[0].end = f64::NAN,
            7 => domain[0].end = domain[0].start,
            8 => (0..3).for_each(|_| domain.push(domain[0])),
            _ => {}
        }
        domain
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn grid(&self) -> Option<Grid> {
        let own = self.inner.grid()?;
        Some(match self.lie {
            9 => Grid { rows: 3, ..own },
            10 => Grid { rows: usize::MAX, columns: usize::MAX, ..own },
            _ => own,
        })
    }

    fn smoothness(&self, order: usize) -> Option<Symmetric> {
        if self.lie == 11 {
            return Some(Symmetric::from_entries(20, (0..20).map(|i| (i, i, 1.0)).collect::<Vec<_>>()));
        }
        self.inner.smoothness(order)
    }
}

#[test]
fn crooked_shapes_are_named() {
    for lie in 0..13 {
        let shape = Crooked { inner: cubic(), short: vec![Point::origin(); 3], lie };
        for metric in [Metric::Least, Metric::Bend, Metric::Falloff(2.0)] {
            let edits = [
                Edit::new(&shape).ask(position(0.5).by([0.0, 1.0, 0.0])),
                Edit::new(&shape)
                    .ask(functional::curvature(0.5).keep())
                    .ask(position(0.2).by([0.0, 1.0, 0.0])),
                Edit::new(&shape).ask(functional::magnitude(0.5).scale(2.0)).locality(3),
                Edit::new(&shape).handle(position(0.5)).locality(2),
            ];
            for edit in edits {
                let result = edit.metric(metric.clone()).solve();
                match lie {
                    12 => drop(result.unwrap()),
                    // Only where somebody asks for the metric.
                    11 if metric != Metric::Bend => drop(result.unwrap()),
                    _ => {
                        let error = result.expect_err("a lie").to_string();
                        assert!(error.contains("Crooked"), "{lie}: {error}");
                    }
                }
            }
        }
        let verdict = functional_conformance(&position(0.5), &[Box::new(shape)]);
        assert!((1..=4).contains(&lie) != verdict.passed() || lie == 0, "{lie}: {verdict}");
    }
}

struct Nobody;

impl ShapeNames for Nobody {
    fn shape(&mut self, _: &str) -> Result<usize> {
        Ok(0)
    }
}

macro_rules! declared {
    ($name:ident, $kind:literal, [$($field:literal),*], $condition:literal) => {
        #[derive(Debug)]
        struct $name;

        impl Functional for $name {
            fn equations(&self) -> usize {
                1
            }

            fn linearity(&self) -> Linearity {
                Linearity::Linear
            }

            fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
                honest(shapes, rows);
                Ok(())
            }

            fn describe(&self) -> String {
                $kind.into()
            }

            fn is_condition(&self) -> bool {
                $condition
            }
        }

        impl DeclaredFunctional for $name {
            const DECLARATION: Declaration = Declaration {
                name: $kind,
                help: "for a test",
                fields: &[$(Field::optional($field, "number", "0", "a field")),*],
            };

            fn from_parameters(_: &Parameters, _: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
                Ok(Self)
            }
        }
    };
}

declared!(Fine, "fine", ["width", "at"], false);
declared!(Aligned, "aligned", ["to"], true);
declared!(WithAxis, "with-axis", ["axis"], false);
declared!(WithKind, "with-kind", ["kind"], false);
declared!(WithTo, "with-to", ["to"], false);
declared!(WithKeep, "with-keep", ["keep"], false);
declared!(WithBound, "with-bound", ["at_least"], false);
declared!(Twice, "twice", ["width", "width"], false);
declared!(Spaced, "two words", ["width"], false);
declared!(Odd, "odd", ["Width"], false);

#[test]
fn reserved_fields_are_found() {
    fn failures<F: DeclaredFunctional>() -> String {
        let parameters = Parameters::empty("test");
        let verdict = declared_functional_conformance::<F>(&parameters, &mut Nobody, &[Box::new(cubic())]);
        assert!(verdict.checks > 20);
        verdict.failures.join("; ")
    }
    assert_eq!(failures::<Fine>(), "");
    assert_eq!(failures::<Aligned>(), "");
    for (found, field) in [
        (failures::<WithAxis>(), "axis"),
        (failures::<WithKind>(), "kind"),
        (failures::<WithTo>(), "to"),
        (failures::<WithKeep>(), "keep"),
        (failures::<WithBound>(), "at_least"),
    ] {
        assert!(found.contains(&format!("\"{field}\" is reserved")), "{field}: {found}");
    }
    assert!(failures::<Twice>().contains("declared twice"));
    assert!(failures::<Spaced>().contains("no name"));
    assert!(failures::<Odd>().contains("no field's name"));
}

#[test]
fn recipes_name_the_plug_in_that_takes_a_reserved_field() {
    let mut registry = Registry::new();
    registry.functional::<WithAxis>();
    let table = Parameters::new(json!({ "kind": "with-axis", "axis": 3, "keep": true }), "step[0]").unwrap();
    let error = constraint_from(&registry, &table, &mut Nobody).unwrap_err().to_string();
    assert!(error.contains("with-axis") && error.contains("\"axis\"") && error.contains("rename"), "{error}");
}

/// The length of a vertex's way to another: its value is its rows' at every place, but these turn.
#[derive(Debug)]
struct Distance;

impl Functional for Distance {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let way = (shapes.vertex(1) - shapes.vertex(0)).normalize();
        rows.equation().term(0, 0, -way).term(0, 1, way);
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        out[0] = (shapes.vertex(1) - shapes.vertex(0)).norm();
        Ok(())
    }

    fn describe(&self) -> String {
        "distance".into()
    }
}

#[test]
fn rows_of_what_calls_itself_linear_are_constant() {
    let mut shapes = sample_shapes(false);
    shapes.truncate(1);
    let verdict = functional_conformance(&Distance, &shapes);
    assert!(!verdict.passed() && verdict.to_string().contains("its rows change by"), "{verdict}");
}
