//! The figures of the papers: the recipes in `examples/papers` make the pictures that are kept beside them, and what
//! the papers say of each figure is true of the document.

mod miura;

use loftsman::kernel::mesh::Mesh;
use loftsman::kernel::scene::{Geometry, Scene};
use loftsman::kernel::spline::Curve;
use loftsman::kernel::{Point, Vector};

use crate::LOFTSMAN;

/// A recipe's scene before and after.
struct Figure {
    before: Scene,
    after: Scene,
}

impl Figure {
    /// Runs a figure's recipe and holds the picture against the one that is kept.
    fn of(paper: &str, number: usize) -> Self {
        let folder = loftsman_tests::repository().join("examples/papers").join(paper);
        let own = folder.join(format!("figure-{number}"));
        let recipe = own.join("recipe.toml");
        let out = tempfile::tempdir().unwrap();
        let recipe_name = recipe.to_string_lossy();
        LOFTSMAN.done(out.path(), &["run", &recipe_name, "-o", "figure.svg", "-o", "figure.loft.json"]);
        let text = |path: std::path::PathBuf| {
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        };
        let faults = super::labels::faults(&text(out.path().join("figure.svg")));
        assert!(faults.is_empty(), "{recipe_name}: {faults:#?}");
        same_picture(&text(out.path().join("figure.svg")), &text(own.join("figure.svg")), &recipe_name);
        let input = text(recipe.clone());
        let input = input.lines().find_map(|line| line.strip_prefix("input = \"../")).unwrap();
        let before = loftsman::read_scene(folder.join(input.trim_end_matches('"'))).unwrap();
        let after = loftsman::read_scene(out.path().join("figure.loft.json")).unwrap();
        Self { before, after }
    }

    /// The curve of a name before, which copies share with what they were copied of, and after.
    fn curves(&self, name: &str) -> [&Curve; 2] {
        let before = self.before.curve(name).or_else(|_| self.before.curve("curve")).unwrap();
        [before, self.after.curve(name).unwrap()]
    }

    /// The indices of the control vertices that moved at all.
    fn moved(&self, name: &str) -> Vec<usize> {
        let [before, after] = self.curves(name).map(Curve::points);
        (0..before.len()).filter(|&i| before[i] != after[i]).collect()
    }

    /// How a value changed that is taken of the curve before and after.
    fn change(&self, name: &str, value: impl Fn(&Curve) -> Vector) -> Vector {
        let [before, after] = self.curves(name);
        value(after) - value(before)
    }

    /// The knot spans whose curves changed anywhere.
    fn changed_spans(&self, name: &str) -> Vec<usize> {
        let [before, after] = self.curves(name);
        let breaks = before.space().breakpoints();
        let differs = |span: &usize| {
            let (a, b) = (breaks[*span], breaks[span + 1]);
            (1..8).map(|i| a + (b - a) * f64::from(i) / 8.0).any(|u| point(before, u) != point(after, u))
        };
        (0..breaks.len() - 1).filter(differs).collect()
    }
}

/// Two pictures are the same where their words are, and their numbers to what can be seen.
fn same_picture(made: &str, kept: &str, recipe: &str) {
    fn tokens(text: &str) -> Vec<Result<f64, &str>> {
        // A sign or a letter begins a number or ends one.
        let mut out = Vec::new();
        let mut rest = text;
        while !rest.is_empty() {
            let numeric = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
            let first = numeric(rest.chars().next().unwrap());
            let end = rest
                .char_indices()
                .find(|&(i, c)| numeric(c) != first || (first && i > 0 && c == '-'))
                .map_or(rest.len(), |(i, _)| i);
            let (token, tail) = rest.split_at(end);
            out.push(token.parse().map_err(|_| token));
            rest = tail;
        }
        out
    }
    let (made, kept) = (tokens(made), tokens(kept));
    let same = |pair: (&Result<f64, &str>, &Result<f64, &str>)| match pair {
        (Ok(a), Ok(b)) => (a - b).abs() <= 0.003,
        (a, b) => a == b,
    };
    assert!(
        made.len() == kept.len() && made.iter().zip(&kept).all(same),
        "the picture beside {recipe} is not what the recipe makes now: look at it, and keep the new one"
    );
}

fn point(curve: &Curve, u: f64) -> Point {
    curve.point(u).unwrap()
}

fn derivative(order: usize, u: f64) -> impl Fn(&Curve) -> Vector {
    move |curve| curve.derivative(u, order).unwrap()
}

/// Signed curvature of a planar curve, from its derivatives.
fn curvature(curve: &Curve, u: f64) -> f64 {
    let (first, second) = (derivative(1, u)(curve), derivative(2, u)(curve));
    first.cross(&second).z / first.norm().powi(3)
}

fn near(a: Vector, b: Vector) -> bool {
    (a - b).norm() < 1e-12
}

mod fowler_bartels {
    use super::*;

    const U: f64 = 2.3;

    fn figure(number: usize) -> Figure {
        let figure = Figure::of("fowler-bartels", number);
        for name in ["a", "b"] {
            // A constraint at 2.3 concerns the vertices 2 to 5 and no others.
            assert_eq!(figure.moved(name), [2, 3, 4, 5]);
            let frames = &figure.after.object(name).unwrap().animation.as_ref().unwrap().frames;
            assert_eq!(frames.len(), 3, "the start and two events");
        }
        figure
    }

    #[test]
    fn figure_1_a_single_constraint() {
        let figure = figure(1);
        let (position, first) = (derivative(0, U), derivative(1, U));
        assert!(near(figure.change("a", &position), Vector::y()));
        assert!(figure.change("a", &first).norm() > 0.1, "derivatives are free to vary");
        assert!(near(figure.change("b", &first), Vector::y() * 2.0));
        assert!(
            figure.change("b", &position).norm() > 0.1,
            "the position varies where a derivative is asked for"
        );
    }

    #[test]
    fn figure_2_a_double_constraint() {
        let figure = figure(2);
        for name in ["a", "b"] {
            assert!(near(figure.change(name, derivative(0, U)), Vector::zeros()), "the position is fixed");
        }
        let first = derivative(1, U);
        let [before, after] = figure.curves("a").map(&first);
        assert!((after.norm() - before.norm()).abs() < 1e-12);
        assert!((before.angle(&after).to_degrees() - 60.0).abs() < 1e-10);
        let [before, after] = figure.curves("b").map(first);
        assert!(near(after, before * 3.0));
    }

    #[test]
    fn figure_3_a_triple_constraint() {
        let figure = figure(3);
        let of = |name: &str, order: usize| figure.change(name, derivative(order, U));
        assert!(near(of("a", 0), Vector::zeros()) && near(of("a", 2), Vector::zeros()));
        assert!(near(of("a", 1), Vector::y() * 1.4));
        assert!(near(of("b", 0), Vector::y() * 0.8));
        assert!(near(of("b", 1), Vector::zeros()) && near(of("b", 2), Vector::zeros()));
        let [before, after] = figure.curves("b").map(|c| curvature(c, U));
        assert!((after - before).abs() < 1e-12, "curvature is preserved");
    }

    #[test]
    fn figure_4_curvature_changes_across_and_stays_along() {
        let figure = figure(4);
        for name in ["a", "b"] {
            assert!(near(figure.change(name, derivative(0, U)), Vector::zeros()));
            assert!(near(figure.change(name, derivative(1, U)), Vector::zeros()));
        }
        let tangent = derivative(1, U)(figure.curves("a")[0]).normalize();
        let (a, b) = (figure.change("a", derivative(2, U)), figure.change("b", derivative(2, U)));
        assert!(a.dot(&tangent).abs() < 1e-12 && a.norm() > 1.0);
        assert!(b.cross(&tangent).norm() < 1e-12 && b.norm() > 1.0);
        let [before, after] = figure.curves("a").map(|c| curvature(c, U));
        // The change across, over the square of the speed, is the change of curvature.
        let speed = derivative(1, U)(figure.curves("a")[0]).norm();
        assert!((before - after - a.norm() / (speed * speed)).abs() < 1e-12);
        let [before, after] = figure.curves("b").map(|c| curvature(c, U));
        assert!((after - before).abs() < 1e-12);
    }
}

mod bartels_beatty {
    use super::*;

    fn figure(number: usize) -> Figure {
        Figure::of("bartels-beatty", number)
    }

    /// The Bernstein polynomials of degree five.
    fn bernstein(u: f64) -> [f64; 6] {
        let v = 1.0 - u;
        let all = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
        std::array::from_fn(|i| all[i] * u.powi(i as i32) * v.powi(5 - i as i32))
    }

    /// Equations 4 and 6: every vertex that may move, moves by `B_i / Σ B_j²` of the way, the others not at all.
    fn moves_as_the_paper_says(figure: &Figure, u: f64, by: Vector, free: &[usize]) {
        let basis = bernstein(u);
        let sum: f64 = free.iter().map(|&i| basis[i] * basis[i]).sum();
        let [before, after] = figure.curves("curve");
        for i in 0..6 {
            let moved = after.points()[i] - before.points()[i];
            if free.contains(&i) {
                assert!(near(moved, by * (basis[i] / sum)), "vertex {i}: {moved}");
            } else {
                assert_eq!(moved, Vector::zeros(), "vertex {i}");
            }
        }
        assert!(near(figure.change("curve", derivative(0, u)), by));
    }

    #[test]
    fn figures_3_and_4_a_point_of_a_quintic() {
        let by = Vector::new(0.3, 1.2, 0.0);
        for number in [3, 4] {
            let figure = figure(number);
            moves_as_the_paper_says(&figure, 0.35, by, &[0, 1, 2, 3, 4, 5]);
            let last = figure.change("curve", |c| c.points()[5].coords);
            assert!(last.norm() < 0.03 * by.norm(), "the right end moves hardly at all");
        }
    }

    #[test]
    fn figures_5_and_6_the_ends_are_locked() {
        for number in [5, 6] {
            let by = Vector::new(0.3, 1.2, 0.0);
            moves_as_the_paper_says(&figure(number), 0.35, by, &[1, 2, 3, 4]);
        }
    }

    #[test]
    fn figures_7_and_8_four_vertices_or_one() {
        let by = Vector::new(0.6, 1.0, 0.0);
        let (four, one) = (figure(7), figure(8));
        moves_as_the_paper_says(&four, 0.45, by, &[1, 2, 3, 4]);
        // The vertex of the largest basis function at 0.45.
        moves_as_the_paper_says(&one, 0.45, by, &[2]);
        assert_eq!(four.before, one.before);
    }

    #[test]
    fn figures_10_and_12_nine_segments_of_twelve_vertices() {
        let (uniform, clamped) = (figure(10), figure(12));
        for figure in [&uniform, &clamped] {
            let [before, after] = figure.curves("curve");
            assert_eq!(before, after);
            assert_eq!((after.points().len(), after.space().breakpoints().len()), (12, 10));
            assert_eq!(after.points(), uniform.curves("curve")[0].points());
        }
        let curve = clamped.curves("curve")[1];
        let (start, end) = curve.domain();
        let vertices = curve.points();
        assert_eq!([point(curve, start), point(curve, end)], [vertices[0], vertices[11]]);
        let legs = [(start, vertices[1] - vertices[0]), (end, vertices[11] - vertices[10])];
        for (u, leg) in legs {
            assert!(derivative(1, u)(curve).normalize().cross(&leg.normalize()).norm() < 1e-12);
        }
        let curve = uniform.curves("curve")[1];
        assert!(
            (point(curve, curve.domain().0) - curve.points()[0]).norm() > 0.5,
            "no vertex is interpolated"
        );
    }

    #[test]
    fn figure_11_the_curve_still_points_at_the_last_vertex() {
        let figure = figure(11);
        let by = Vector::new(-0.8, 0.9, 0.0);
        assert_eq!(figure.moved("curve"), [8, 9, 10, 11]);
        assert!(near(figure.change("curve", derivative(0, 11.4)), by));
        assert!(figure.change("curve", |c| c.points()[11].coords).norm() < 0.03 * by.norm());
        let curve = figure.curves("curve")[1];
        let [a, b, c] = [9, 10, 11].map(|i| curve.points()[i]);
        // P = (a + 4b + c) / 6 and D = (c - a) / 2 (the paper has 3 in place of 1/2).
        let end = curve.domain().1;
        assert!(near(point(curve, end).coords, (a.coords + b.coords * 4.0 + c.coords) / 6.0));
        assert!(near(derivative(1, end)(curve), (c - a) / 2.0));
    }

    #[test]
    fn figures_13_and_14_the_end_stays_or_goes() {
        let (stays, goes) = (figure(13), figure(14));
        let by = Vector::new(0.2, 1.3, 0.0);
        let end = |curve: &Curve| point(curve, 4.0).coords;
        for figure in [&stays, &goes] {
            assert!(near(figure.change("curve", derivative(0, 3.7)), by));
            assert_eq!(figure.curves("curve")[1].space().breakpoints().len(), 5);
        }
        assert_eq!(stays.moved("curve"), [3, 4, 5]);
        assert_eq!(stays.change("curve", end), Vector::zeros());
        let [before, after] = stays.curves("curve").map(derivative(1, 4.0));
        assert!(before.angle(&after).to_degrees() > 20.0, "the curve turns about its end");
        assert_eq!(goes.moved("curve"), [3, 4, 5, 6]);
        assert!(goes.change("curve", end).norm() > 0.5);
    }

    #[test]
    fn figure_15_one_vertex_changes_four_segments_and_four_change_seven() {
        let figure = figure(15);
        let by = Vector::new(-0.2, 1.4, 0.0);
        for name in ["one vertex", "four vertices"] {
            assert!(near(figure.change(name, derivative(0, 5.1)), by));
        }
        assert_eq!(figure.moved("one vertex"), [6]);
        assert_eq!(figure.moved("four vertices"), [5, 6, 7, 8]);
        assert_eq!(figure.changed_spans("one vertex"), [3, 4, 5, 6]);
        // One segment more to the left and two to the right, the last of them by less than can be seen.
        assert_eq!(figure.changed_spans("four vertices"), [2, 3, 4, 5, 6, 7, 8]);
        let last = figure.change("four vertices", derivative(0, 8.3));
        assert!(last.norm() < 1e-3, "{last}");
    }

    #[test]
    fn figure_16_two_vertices_balance() {
        let figure = figure(16);
        assert_eq!(figure.moved("left, one vertex"), [5]);
        assert_eq!(figure.moved("right, one vertex"), [6]);
        let apart = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| figure.curves(name)[1]);
            let samples = (0..=900).map(|i| f64::from(i) / 100.0);
            samples.map(|u| (point(a, u) - point(b, u)).norm()).fold(0.0, f64::max)
        };
        let one = apart("left, one vertex", "right, one vertex");
        assert_eq!(figure.moved("left, two vertices"), [5, 6]);
        assert_eq!(figure.moved("right, two vertices"), [5, 6]);
        let two = apart("left, two vertices", "right, two vertices");
        assert!(one > 1.0 && two < 0.05 * one, "{one} {two}");
    }

    #[test]
    fn figure_17_two_equations() {
        let figure = figure(17);
        assert_eq!(figure.moved("curve"), [0, 1, 2, 3]);
        assert!(near(figure.change("curve", derivative(0, 3.6)), Vector::new(0.3, 1.0, 0.0)));
        assert!(near(figure.change("curve", derivative(0, 3.0)), Vector::zeros()));
        assert!(
            figure.change("curve", |c| c.points()[0].coords).norm() > 0.1,
            "vertices move, the point stays"
        );
    }

    #[test]
    fn figure_18_the_curve_overshoots() {
        let figure = figure(18);
        let by = Vector::new(1.0, 1.0, 0.0);
        assert!(near(figure.change("curve", derivative(0, 0.08)), by));
        assert_eq!(figure.change("curve", derivative(0, 0.0)), Vector::zeros());
        let samples = (0..=400).map(|i| f64::from(i) / 100.0);
        let furthest = samples.map(|u| figure.change("curve", derivative(0, u)).norm()).fold(0.0, f64::max);
        assert!(furthest > 2.0 * by.norm(), "{furthest}");
    }
}
