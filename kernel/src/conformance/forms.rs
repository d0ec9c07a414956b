//! A scene of lines, conics and elementary surfaces that are these beside splines.

use std::f64::consts::TAU;

use nalgebra::Matrix4;

use super::Verdict;
use crate::brep::{CurveForm, Frame, SurfaceForm};
use crate::error::Result;
use crate::scene::{Geometry, Object, Scene, Unit};
use crate::spline::{Curve, CurvePiece, Space, Surface, SurfacePiece};
use crate::{Point, Vector};

/// A scene in millimetres of curves and surfaces with what they are [beside splines](Curve::form): one of each form, whole and in part, in planes of the axes and
/// across them, one at a distance, one placed, and one of a definition that is shown twice.
///
/// # Errors
/// None that is known.
pub fn sample_forms() -> Result<Scene> {
    let mut scene = Scene::new();
    scene.unit = Unit::Millimetre;
    let flat = Frame { origin: Point::new(4.0, -3.0, 2.0), x: Vector::x(), z: Vector::z() };
    let turned =
        Frame::new(Point::new(-1.0, 2.0, 0.5), Vector::new(0.3, -0.5, 0.8), Vector::new(1.0, 0.2, 0.1));
    let turned = turned.unwrap_or(flat);
    let far = Frame { origin: Point::new(1e6, -2e6, 3e5), ..turned };
    let circle = |frame: Frame, radius: f64, range: [f64; 2]| {
        round(CurveForm::Circle { frame, radius }, &frame, [radius; 2], range)
    };
    let ellipse = |frame: Frame, radii: [f64; 2], range: [f64; 2]| {
        round(CurveForm::Ellipse { frame, radii }, &frame, radii, range)
    };
    let shown = circle(turned, 0.75, [0.1, 2.2])?;
    let all = [
        (
            "line",
            Curve::line(Point::new(0.1, 0.2, 0.3), Point::new(7.0, -1.0 / 3.0, 5.0))?
                .with_form(CurvePiece::LINE)?,
        ),
        (
            "short line",
            Curve::line(Point::new(1e5, 0.0, 0.0), Point::new(1e5, 1e-3, 0.0))?
                .with_form(CurvePiece::LINE)?,
        ),
        ("circle", circle(flat, 3.0, [0.0, TAU])?),
        ("turned circle", circle(turned, 1.0 / 3.0, [0.7, 0.7 + TAU])?),
        ("flat arc", circle(flat, 2.5, [0.4, 1.9])?),
        ("arc", circle(turned, 2.0, [-0.3, 4.9])?),
        ("far arc", circle(far, 40.0, [0.2, 3.0])?),
        ("ellipse", ellipse(flat, [3.0, 1.0], [0.0, TAU])?),
        ("ellipse arc", ellipse(turned, [1.7, 0.4], [-2.0, 1.0])?),
        ("upright ellipse arc", ellipse(turned, [0.4, 1.7], [0.3, 5.0])?),
        ("parabola", parabola(turned, 0.7, [-1.0, 2.0])?),
        ("half parabola", parabola(flat, 12.5, [0.25, 1.5])?),
        ("hyperbola", hyperbola(turned, [2.0, 0.5], [-0.5, 1.5])?),
        ("steep hyperbola", hyperbola(flat, [0.3, 4.0], [-1.0, 0.75])?),
    ];
    for (name, curve) in all {
        scene.add(Object::new(name, curve.into()))?;
    }
    let half = std::f64::consts::FRAC_PI_2;
    for (name, form, ranges) in [
        ("plane", SurfaceForm::Plane { frame: turned }, [[-1.0, 2.0], [0.5, 4.0]]),
        ("cylinder", SurfaceForm::Cylinder { frame: turned, radius: 2.0 }, [[0.3, 2.9], [-1.0, 4.0]]),
        ("pipe", SurfaceForm::Cylinder { frame: flat, radius: 1.5 }, [[0.0, TAU], [0.0, 7.0]]),
        (
            "sunk pipe",
            SurfaceForm::Cylinder { frame: turned, radius: 1.0 / 3.0 },
            [[1.0, 1.0 + TAU], [3.0, -1.0]],
        ),
        ("cone", SurfaceForm::Cone { frame: turned, radius: 2.0, angle: 0.4 }, [[-1.0, 2.0], [0.25, 3.0]]),
        ("sphere", SurfaceForm::Sphere { frame: turned, radius: 2.5 }, [[0.0, TAU], [-half, half]]),
        ("piece of a sphere", SurfaceForm::Sphere { frame: turned, radius: 2.5 }, [[0.5, 2.0], [-0.2, 1.1]]),
        ("torus", SurfaceForm::Torus { frame: flat, major: 5.0, minor: 2.0 }, [[0.0, TAU]; 2]),
        ("bend", SurfaceForm::Torus { frame: turned, major: 5.0, minor: 2.0 }, [[1.0, 2.0], [3.0, 5.5]]),
    ] {
        scene.add(Object::new(name, form.patch(ranges)?.with_form(SurfacePiece { form, ranges })?.into()))?;
    }
    let mut placed = Object::new("placed", shown.clone().into());
    placed.transform = Some(
        Matrix4::new_translation(&Vector::new(5.0, 6.0, 7.0)) * Matrix4::from_euler_angles(0.1, 0.2, 0.3),
    );
    scene.add(placed)?;
    let mut definition = crate::scene::Definition::new("bracket");
    definition.add(Object::new("bend", shown.into()))?;
    definition.add(Object::new(
        "edge",
        Curve::line(Point::origin(), Point::new(0.0, 0.0, 9.0))?.with_form(CurvePiece::LINE)?.into(),
    ))?;
    scene.define(definition)?;
    for (name, along) in [("left", -20.0), ("right", 20.0)] {
        let mut instance = Object::new(name, Geometry::Instance("bracket".into()));
        instance.transform = Some(Matrix4::new_translation(&Vector::new(along, 0.0, 0.0)));
        scene.add(instance)?;
    }
    Ok(scene)
}

/// Whether all curves and surfaces that a scene shows are there in another, as the same lines, conics and elementary surfaces, in the same order and at the
/// same places but for some roundings; a circle may be counted from elsewhere, and an ellipse from the end of its other half diameter.
pub fn same_forms(before: &Scene, after: &Scene) -> Verdict {
    let mut verdict = Verdict::default();
    let surfaces = [sheets(before), sheets(after)];
    if let [Ok(before), Ok(after)] = &surfaces {
        same_sheets(before, after, &mut verdict);
    }
    let (before, after) = match (shown(before), shown(after)) {
        (Ok(before), Ok(after)) => (before, after),
        (before, after) => {
            let why = before.err().or(after.err()).map(|e| e.to_string()).unwrap_or_default();
            verdict.check(false, || why);
            return verdict;
        }
    };
    verdict.check(before.len() == after.len(), || format!("{} curves became {}", before.len(), after.len()));
    for ((name, before), (_, after)) in before.iter().zip(&after) {
        let (Some(was), Some(is)) = (before.form(), after.form()) else {
            let told = after.form().map_or("a spline", CurvePiece::noun);
            verdict
                .check(before.form().is_none() == after.form().is_none(), || format!("\"{name}\" is {told}"));
            continue;
        };
        verdict
            .check(was.noun() == is.noun(), || format!("\"{name}\", {}, became {}", was.noun(), is.noun()));
        let size = before.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let [one, other] = [before, after].map(places);
        let off = one.iter().zip(&other).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
        verdict.check(off <= 1e-13 * size, || format!("\"{name}\" is {off:e} off"));
        let [one, other] = [was, is].map(sizes);
        let same = one.iter().zip(&other).all(|(a, b)| (a - b).abs() <= 1e-13 * size.max(*a));
        verdict.check(same, || format!("the sizes of \"{name}\" were {one:?} and are {other:?}"));
    }
    verdict
}

fn same_sheets(before: &[(String, Surface)], after: &[(String, Surface)], verdict: &mut Verdict) {
    verdict
        .check(before.len() == after.len(), || format!("{} surfaces became {}", before.len(), after.len()));
    for ((name, before), (_, after)) in before.iter().zip(after) {
        let [was, is] = [before, after].map(|surface| surface.form().map_or("spline", SurfacePiece::noun));
        verdict.check(was == is, || format!("\"{name}\", a {was}, became a {is}"));
        let size = before.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let share = |(a, b): (f64, f64), k: u32| a + (b - a) * f64::from(k) / 4.0;
        let mut off = 0.0_f64;
        for k in 0..25 {
            let at = |s: &Surface| s.point(share(s.u().domain(), k / 5), share(s.v().domain(), k % 5));
            let apart = at(before).and_then(|p| Ok((p - at(after)?).amax()));
            off = off.max(apart.unwrap_or(f64::INFINITY));
        }
        verdict.check(off <= 1e-12 * size, || format!("\"{name}\" is {off:e} off"));
    }
}

/// All surfaces that a scene shows, in its world.
fn sheets(scene: &Scene) -> Result<Vec<(String, Surface)>> {
    let mut all = Vec::new();
    for placed in scene.placed(1000)? {
        if let Geometry::Surface(surface) = placed.object.geometry() {
            let surface =
                placed.to_world.map_or_else(|| Ok(surface.clone()), |map| surface.transformed(&map))?;
            all.push((placed.object.name().to_owned(), surface));
        }
    }
    Ok(all)
}

/// All curves that a scene shows, in its world.
fn shown(scene: &Scene) -> Result<Vec<(String, Curve)>> {
    let mut all = Vec::new();
    for placed in scene.placed(1000)? {
        if let Geometry::Curve(curve) = placed.object.geometry() {
            let curve = placed.to_world.map_or_else(|| Ok(curve.clone()), |map| curve.transformed(&map))?;
            all.push((placed.object.name().to_owned(), curve));
        }
    }
    Ok(all)
}

/// Places along a curve that do not depend on how it is counted: of a conic by its own parameter.
fn places(curve: &Curve) -> Vec<Point> {
    let ends = [curve.points().first(), curve.points().last()].into_iter().flatten().copied();
    let along = |k: f64| {
        let piece = curve.form()?;
        piece.form.point(piece.range[0] + k * (piece.range[1] - piece.range[0]))
    };
    ends.chain([0.0, 0.25, 0.5, 0.75, 1.0].into_iter().filter_map(along)).collect()
}

fn sizes(piece: &CurvePiece) -> Vec<f64> {
    match piece.form {
        CurveForm::Spline | CurveForm::Line => Vec::new(),
        CurveForm::Circle { radius, .. } => vec![radius],
        CurveForm::Ellipse { radii: [a, b], .. } => vec![a.min(b), a.max(b)],
        CurveForm::Parabola { focal, .. } => vec![focal],
        CurveForm::Hyperbola { radii, .. } => radii.to_vec(),
    }
}

fn round(form: CurveForm, frame: &Frame, radii: [f64; 2], range: [f64; 2]) -> Result<Curve> {
    let (x, y) = (frame.x * radii[0], frame.y() * radii[1]);
    Curve::elliptic_arc(frame.origin, x, y, range[0], (range[1] - range[0]).min(TAU))?
        .with_form(CurvePiece { form, range })
}

fn parabola(frame: Frame, focal: f64, range: [f64; 2]) -> Result<Curve> {
    let [a, b] = range;
    let at = |a: f64, b: f64| frame.origin + frame.x * (focal * a * b) + frame.y() * (focal * (a + b));
    let space = Space::clamped(2, &range)?;
    let form = CurveForm::Parabola { frame, focal };
    Curve::new(space, vec![at(a, a), at(a, b), at(b, b)])?.with_form(CurvePiece { form, range })
}

/// One rational piece: its middle vertex is where the tangents at its ends meet, with the weight `cosh` of half its range.
fn hyperbola(frame: Frame, radii: [f64; 2], range: [f64; 2]) -> Result<Curve> {
    let (middle, half) = (0.5 * (range[0] + range[1]), 0.5 * (range[1] - range[0]));
    let at = |t: f64, by: f64| {
        frame.origin + frame.x * (radii[0] * t.cosh() * by) + frame.y() * (radii[1] * t.sinh() * by)
    };
    let points = vec![at(range[0], 1.0), at(middle, 1.0 / half.cosh()), at(range[1], 1.0)];
    let form = CurveForm::Hyperbola { frame, radii };
    Curve::rational(Space::clamped(2, &range)?, points, vec![1.0, half.cosh(), 1.0])?
        .with_form(CurvePiece { form, range })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_made_and_each_of_it_has_a_form() {
        let scene = sample_forms().unwrap();
        let curves = scene.objects().iter().filter_map(|object| match object.geometry() {
            Geometry::Curve(curve) => Some(curve.form().is_some()),
            _ => None,
        });
        assert_eq!(curves.collect::<Vec<_>>(), [true; 15]);
    }
}
