//! What a step changed: every object before and after, measured where it is another than before. One place for all
//! operations, whoever wrote them.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::{ChangeKind, Measured, ObjectChange, StepReport};
use loftsman_kernel::scene::{Geometry, Object, Scene, Standing};

use super::deviation::{deviation, is_of_points};
use crate::measures::Measures;
use crate::placed::measures;

/// The objects of a scene before a step, and how those stand that are placed. It shares their geometry: no number is copied.
pub(super) struct Before {
    geometries: HashMap<String, Arc<Geometry>>,
    standings: HashMap<String, Standing>,
}

/// Measures of geometries that were taken before, by the geometry: those of a step's end are those of the next one's start.
#[derive(Default)]
pub(super) struct Known(HashMap<usize, Taken>);

/// What was measured of a geometry.
struct Taken {
    /// Held, so that no other one takes its address.
    _geometry: Arc<Geometry>,
    /// From where its volume was taken: what is compared has to be from one place.
    origin: Point,
    /// In its own coordinates.
    own: Measures,
    /// As one of the objects stands that have it, where lengths there do not follow from its own by one number.
    there: Option<(Standing, Measures)>,
}

impl Known {
    /// The measures of a geometry as it stands, and from where its volume was taken: from `origin` where that is given, and not too far.
    fn measures(
        &mut self,
        geometry: &Arc<Geometry>,
        standing: &Standing,
        origin: Option<Point>,
    ) -> (Measures, Point) {
        let id = Arc::as_ptr(geometry).cast::<()>() as usize;
        let Taken { own, there, origin, .. } = self.0.entry(id).or_insert_with(|| {
            let origin = place(geometry.points(), origin);
            let own = Measures::by_quadrature(geometry, Some(origin));
            Taken { _geometry: Arc::clone(geometry), origin, own, there: None }
        });
        // The volume of what is stretched follows from its own.
        let measure =
            || measures(geometry, own, standing, |stretched| Measures::by_quadrature(stretched, None));
        let found = match there {
            _ if standing.scale().is_some() => measure(),
            Some((known, there)) if known == standing => there.clone(),
            _ => {
                let found = measure();
                *there = Some((*standing, found.clone()));
                found
            }
        };
        (found, *origin)
    }
}

/// From where coordinates are taken for the volume of what has these control vertices: from the place that is given where it is no further from their middle than
/// they are, and from the middle elsewhere.
fn place(points: &[Point], given: Option<Point>) -> Point {
    let Some(first) = points.first() else { return given.unwrap_or_default() };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = Point::from(0.5 * low.coords + 0.5 * high.coords);
    given.filter(|given| (given - middle).norm() <= 0.5 * (high - low).norm()).unwrap_or(middle)
}

impl Before {
    /// Looks at a scene. `O(objects)`.
    pub(super) fn of(scene: &Scene) -> Self {
        let objects = scene.objects().iter();
        let geometries = objects.map(|o| (o.name().to_owned(), Arc::clone(o.shared_geometry()))).collect();
        Self { geometries, standings: standings(scene) }
    }

    /// What is called otherwise since: the old names and the new ones. What two objects share cannot be told apart, and is not looked for.
    pub(super) fn renamed(&self, scene: &Scene) -> Vec<(String, String)> {
        let mut new: HashMap<*const Geometry, Option<&str>> = HashMap::new();
        for object in scene.objects().iter().filter(|object| !self.geometries.contains_key(object.name())) {
            let shared = new.entry(Arc::as_ptr(object.shared_geometry())).or_insert(Some(object.name()));
            *shared = shared.filter(|name| *name == object.name());
        }
        let gone = self.geometries.iter().filter(|(name, _)| scene.get(name).is_none());
        let now = |geometry: &Arc<Geometry>| new.get(&Arc::as_ptr(geometry)).copied().flatten();
        gone.filter_map(|(name, geometry)| Some((name.clone(), now(geometry)?.to_owned()))).collect()
    }

    /// The points that have become a curve or a surface in the step, each list as a cloud beside the object.
    pub(super) fn fitted(&self, scene: &Scene) -> Vec<Object> {
        let points = |object: &Object| match (
            self.geometries.get(object.name()).map(Arc::as_ref),
            object.geometry(),
        ) {
            (
                Some(before @ (Geometry::Cloud(_) | Geometry::Polyline(_))),
                Geometry::Curve(_) | Geometry::Surface(_),
            ) => Some(before.points().to_vec()),
            _ => None,
        };
        let beside = |object: &Object| {
            let cloud = Cloud { points: points(object)? };
            let mut beside = Object::new(points_of(object.name()), cloud.into());
            beside.parent.clone_from(&object.parent);
            beside.layer.clone_from(&object.layer);
            beside.transform = object.transform;
            Some(beside)
        };
        scene.objects().iter().filter_map(beside).collect()
    }

    /// Says in a step's report what is not as it was.
    pub(super) fn tell(self, scene: &Scene, known: &mut Known, report: &mut StepReport) {
        let mut unchanged = 0;
        let standings = standings(scene);
        let stood = |all: &HashMap<String, Standing>, name: &str| all.get(name).copied().unwrap_or_default();
        let mut gone: Vec<_> = self.geometries.iter().filter(|(name, _)| scene.get(name).is_none()).collect();
        let left_over: HashSet<*const Geometry> =
            gone.iter().map(|(_, geometry)| Arc::as_ptr(geometry)).collect();
        let known_after: HashSet<*const Geometry> =
            scene.objects().iter().map(|object| Arc::as_ptr(object.shared_geometry())).collect();
        for object in scene.objects() {
            let after = object.shared_geometry();
            let before = self.geometries.get(object.name());
            match before {
                Some(before) if Arc::ptr_eq(before, after) || before == after => unchanged += 1,
                None if matches!(**after, Geometry::Group | Geometry::Instance(_)) => {}
                // Under another name.
                None if left_over.contains(&Arc::as_ptr(after)) => {}
                before => {
                    let name = object.name();
                    let (was, is) = (stood(&self.standings, name), stood(&standings, name));
                    let mut change = change(name, before.map(|b| (b, was)), Some((after, is)), known);
                    if let Some(warning) = collapsed(&change, before.map(Arc::as_ref), after) {
                        // What is a line or a point has no area, whatever its quadrature could not tell.
                        change.unmeasured.clear();
                        change.area.after = change.area.after.or(change.area.before.map(|_| 0.0));
                        report.warnings.push(warning);
                    }
                    report.objects.push(change);
                }
            }
        }
        gone.retain(|(_, before)| {
            let shown = matches!(***before, Geometry::Group | Geometry::Instance(_));
            !shown && !known_after.contains(&Arc::as_ptr(before))
        });
        gone.sort_unstable_by_key(|(name, _)| *name);
        for (name, before) in gone {
            report.objects.push(change(name, Some((before, stood(&self.standings, name))), None, known));
        }
        report.unchanged = Some(unchanged);
        // Only the state after this step is asked for again.
        let there: HashSet<usize> = scene.objects().iter().map(|object| object.geometry_id()).collect();
        known.0.retain(|id, _| there.contains(id));
    }
}

/// Of its length or area no more than this share is left of what has collapsed.
const COLLAPSED: f64 = 1e-9;

/// What is left of a surface that was more: a point, where its points are where rounding puts those of one, or a line.
fn left_of(before: &Geometry, after: &Geometry) -> Option<&'static str> {
    let is_surface = |g: &Geometry| matches!(g, Geometry::Surface(_) | Geometry::Trimmed(_));
    if !is_surface(before) || !is_surface(after) {
        return None;
    }
    // How long and how wide the points lie.
    let extent = |geometry: &Geometry| {
        let points = geometry.points();
        let first = points.first()?;
        let along = points.iter().map(|p| p - first).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let length = along.norm();
        let across = points.iter().map(|p| (p - first).cross(&along).norm() / length).fold(0.0, f64::max);
        Some((length, if length > 0.0 { across } else { 0.0 }))
    };
    let (was, is) = (extent(before)?, extent(after)?);
    if is.0 <= COLLAPSED * was.0 && was.0 > 0.0 {
        return Some("a point");
    }
    (is.1 <= COLLAPSED * is.0 && was.1 > COLLAPSED * was.0).then_some("a line")
}

/// That nothing is left of an object but a point or a line.
fn collapsed(change: &ObjectChange, before: Option<&Geometry>, after: &Geometry) -> Option<String> {
    let gone = |measured: Measured| {
        measured
            .before
            .zip(measured.after)
            .is_some_and(|(before, after)| after.abs() <= COLLAPSED * before.abs() && before != 0.0)
    };
    let left =
        match (gone(change.length), gone(change.area), before.and_then(|before| left_of(before, after))) {
            (true, ..) => "a point",
            (.., Some(left)) => left,
            (_, true, None) => "a line or a point",
            _ => return None,
        };
    Some(format!(
        "{:?} has shrunk to {left}, which also meets what is asked: ask for something else, or, where constraints are asked for, for something of its size as well (`length`, `area`, its ends)",
        change.name
    ))
}

/// How the objects of a scene stand that are placed. `O(objects)`.
fn standings(scene: &Scene) -> HashMap<String, Standing> {
    let maps = scene.world_transforms().unwrap_or_default();
    let placed = scene.objects().iter().zip(maps).filter_map(|(object, map)| Some((object.name(), map?)));
    placed.map(|(name, map)| (name.to_owned(), Standing::by(Some(map)))).collect()
}

/// What the points are called that an object was fitted to.
pub(super) fn points_of(name: &str) -> String {
    format!("points of {name}")
}

fn change(
    name: &str,
    before: Option<(&Arc<Geometry>, Standing)>,
    after: Option<(&Arc<Geometry>, Standing)>,
    known: &mut Known,
) -> ObjectChange {
    let old = before.map(|(geometry, standing)| known.measures(geometry, &standing, None));
    let origin = old.as_ref().map(|(_, origin)| *origin);
    let new = after.map(|(geometry, standing)| known.measures(geometry, &standing, origin));
    let [old, new] = [old, new].map(|one| one.map(|(measures, _)| measures).unwrap_or_default());
    let kind = match (before, after) {
        (Some(_), Some(_)) => ChangeKind::Changed,
        (None, _) => ChangeKind::New,
        (_, None) => ChangeKind::Gone,
    };
    let pair = |of: fn(&Measures) -> Option<f64>| Measured { before: of(&old), after: of(&new) };
    ObjectChange {
        name: name.to_owned(),
        change: kind,
        length: pair(|m| m.length),
        area: pair(|m| m.area),
        volume: pair(|m| m.volume),
        deviation: before.zip(after).and_then(|(before, after)| moved(before, after)),
        of_points: before.zip(after).is_some_and(|((before, _), (after, _))| is_of_points(before, after)),
        unmeasured: new.unmeasured,
    }
}

/// How far an object is from what it was, as it stands in the scene.
fn moved((before, was): (&Arc<Geometry>, Standing), (after, is): (&Arc<Geometry>, Standing)) -> Option<f64> {
    // Less is rounding.
    let off = |before: &Geometry, after: &Geometry| {
        let size = after.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        deviation(before, after).map(|found| if found <= 1e-13 * size { 0.0 } else { found })
    };
    match is.scale().filter(|_| was == is) {
        Some(scale) => off(before, after).map(|found| scale * found),
        None => off(was.seen(before).ok()?.as_ref(), is.seen(after).ok()?.as_ref()),
    }
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Point;
    use loftsman_kernel::mesh::Polyline;
    use loftsman_kernel::spline::{Curve, Space};

    use super::super::deviation::tests::{arch, sheet};
    use super::*;

    fn told(before: &Scene, after: &Scene) -> StepReport {
        let mut report = StepReport::default();
        Before::of(before).tell(after, &mut Known::default(), &mut report);
        report
    }

    /// A line of 7 that has shrunk to the point where it starts is 7 off the old one: what is far from the new shape counts, too; and it is warned of.
    #[test]
    fn what_has_collapsed_is_warned_of() {
        let line = |end: f64| {
            let points = [0.0, end].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
            let mut scene = Scene::new();
            scene
                .add(Object::new(
                    "line",
                    Curve::new(Space::clamped_uniform(1, 2).unwrap(), points).unwrap().into(),
                ))
                .unwrap();
            scene
        };
        for (end, collapses) in [(1e-12, true), (1.0, false)] {
            let report = told(&line(7.0), &line(end));
            assert_eq!(report.warnings.len(), usize::from(collapses), "{:?}", report.warnings);
            assert!(
                report.warnings.iter().all(|w| w.starts_with("\"line\" has shrunk to a point")),
                "{:?}",
                report.warnings
            );
            assert!(
                (report.objects[0].deviation.unwrap() - (7.0 - end)).abs() < 1e-9,
                "{:?}",
                report.objects
            );
        }
    }

    /// Surfaces of which rounding is all that is left are points, whatever directions that has; and have no area.
    #[test]
    fn surfaces_that_have_collapsed_are_told_as_what_is_left() {
        let scene = |at: &dyn Fn(f64, f64, f64) -> Point| {
            let side = || Space::clamped_uniform(2, 4).unwrap();
            let points = (0..16).map(|k| {
                let (i, j) = (f64::from(k / 4), f64::from(k % 4));
                at(i, j, (f64::from(k) * 1.7).sin())
            });
            let surface = loftsman_kernel::spline::Surface::new(side(), side(), points.collect()).unwrap();
            let mut scene = Scene::new();
            scene.add(Object::new("s", surface.into())).unwrap();
            scene
        };
        let before = scene(&|i, j, noise| Point::new(i, j, 0.3 * noise));
        for (after, left) in [
            (
                scene(&|i, j, noise| Point::new(1.0 + 1e-15 * i, 2.0 + 1e-15 * j, 1e-15 * noise)),
                Some("a point"),
            ),
            (scene(&|i, j, _| Point::new(i + 0.5 * j, 2.0 * i + j, -i - 0.5 * j)), Some("a line")),
            (scene(&|i, j, noise| Point::new(i, 1e-3 * j, 1e-4 * noise)), None),
        ] {
            let report = told(&before, &after);
            let said = left.map(|left| format!("\"s\" has shrunk to {left},"));
            assert_eq!(report.warnings.len(), usize::from(left.is_some()), "{:?}", report.warnings);
            assert!(
                report.warnings.iter().zip(&said).all(|(told, said)| told.starts_with(said)),
                "{report:?}"
            );
            let change = &report.objects[0];
            assert!(left.is_none() || change.unmeasured.is_empty(), "{change:?}");
            assert!(left.is_none() || change.area.after.is_some_and(|area| area.abs() < 1e-6), "{change:?}");
        }
    }

    #[test]
    fn what_is_new_gone_changed_and_as_before_is_told() {
        let mut before = Scene::new();
        for name in ["stays", "moves", "goes", "turns"] {
            before.add(Object::new(name, arch(3, 0.0).into())).unwrap();
        }
        let mut after = before.clone();
        after.remove("goes").unwrap();
        after.add(Object::new("comes", sheet(0.0).into())).unwrap();
        after.object_mut("moves").unwrap().set_geometry(arch(3, 0.25));
        after
            .object_mut("turns")
            .unwrap()
            .set_geometry(Polyline { points: vec![Point::origin(); 3], closed: false });
        let report = told(&before, &after);
        let kinds: Vec<(&str, ChangeKind)> =
            report.objects.iter().map(|o| (o.name.as_str(), o.change)).collect();
        let (changed, new, gone) = (ChangeKind::Changed, ChangeKind::New, ChangeKind::Gone);
        assert_eq!(kinds, [("moves", changed), ("turns", changed), ("comes", new), ("goes", gone)]);
        assert_eq!(report.unchanged, Some(1));
        let [moves, turns, comes, goes] = &report.objects[..] else { panic!("{report:?}") };
        assert!((moves.deviation.unwrap() - 0.25).abs() < 1e-12, "{moves:?}");
        assert_eq!((turns.deviation, comes.deviation, goes.deviation), (None, None, None));
        assert!((moves.length.before.unwrap() - moves.length.after.unwrap()).abs() < 1e-9);
        assert!(comes.area.before.is_none() && comes.area.after.unwrap() > 16.0, "{comes:?}");
        assert!(goes.length.before.is_some() && goes.length.after.is_none(), "{goes:?}");
        // The other name of one thing is no change.
        let mut renamed = before.clone();
        renamed.rename("goes", "went").unwrap();
        let report = told(&before, &renamed);
        assert!(report.objects.is_empty() && report.unchanged == Some(3), "{report:?}");
    }

    #[test]
    fn fitted_points_are_kept_and_new_names_are_found() {
        let mut before = Scene::new();
        let points: Vec<Point> = (0..9).map(|k| Point::new(f64::from(k), 0.0, 0.0)).collect();
        before.add(Object::new("scan", Cloud { points: points.clone() }.into())).unwrap();
        before.add(Object::new("rail", arch(3, 0.0).into())).unwrap();
        let mut after = before.clone();
        after.object_mut("scan").unwrap().set_geometry(arch(3, 0.0));
        let fitted = Before::of(&before).fitted(&after);
        assert_eq!(fitted.len(), 1);
        assert_eq!((fitted[0].name(), fitted[0].geometry().points()), (&*points_of("scan"), &points[..]));
        let mut renamed = after.clone();
        renamed.rename("scan", "hull").unwrap();
        renamed.add(Object::new("other", sheet(0.0).into())).unwrap();
        assert_eq!(Before::of(&after).renamed(&renamed), [("scan".to_owned(), "hull".to_owned())]);
        assert!(Before::of(&after).renamed(&after).is_empty());
    }
}
