//! How large things are where they stand: measures and boxes of objects that their transforms, and those above them, place.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use loftsman_kernel::nalgebra::{Matrix3, Matrix4};
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::scene::{Definition, Geometry, Scene, Standing, similarity};
use loftsman_kernel::{Point, parallel};

use crate::facts::{ObjectFacts, OwnFacts, bounds, corners, shape};
use crate::measures::Measures;

/// How many objects the instances of a scene may show for what they show to be summed.
const MOST_SUMMED: u64 = 100_000;

/// How many points are looked at, turned this way and that, for boxes around what is placed: what a file of a few bytes places a hundred thousand
/// times must not take minutes.
const MOST_POINTS: usize = 100_000_000;

/// A geometry that something turns or stretches: the box around it, before it is moved, and how large it is where lengths do not go by one number.
#[derive(Clone)]
struct Turned {
    bounds: Option<[[f64; 3]; 2]>,
    measures: Option<Measures>,
}

/// Facts of geometries, each measured once, and once more for each way in which something turns or stretches it.
#[derive(Default)]
pub(crate) struct Placed {
    own: HashMap<usize, (ObjectFacts, Vec<Point>)>,
    turned: HashMap<(usize, [u64; 9]), Turned>,
    /// How many points were looked at for boxes.
    points: usize,
}

fn linear(map: &Matrix4<f64>) -> Matrix3<f64> {
    map.fixed_view::<3, 3>(0, 0).into_owned()
}

impl Placed {
    /// That of the objects of a scene and of its definitions: each geometry is measured once, several of them at a time.
    pub(crate) fn of(scene: &Scene) -> Self {
        let defined = scene.definitions().iter().flat_map(Definition::objects);
        let mut seen = HashSet::new();
        let mut all: Vec<(usize, &Geometry)> =
            scene.objects().iter().chain(defined).map(|o| (o.geometry_id(), o.geometry())).collect();
        all.retain(|(id, _)| seen.insert(*id));
        let known = parallel::map(all.len(), |k| shape(all[k].1));
        let own = all.iter().map(|(id, _)| *id).zip(known).collect();
        Self { own, ..Self::default() }
    }

    /// What is said of a geometry where a map places it. Of one that is not the identity its own coordinates are told, too.
    pub(crate) fn facts(
        &mut self,
        id: usize,
        geometry: &Geometry,
        map: Option<&Matrix4<f64>>,
    ) -> ObjectFacts {
        let (own, around) = self.own.entry(id).or_insert_with(|| shape(geometry));
        let Some(map) = map.filter(|map| **map != Matrix4::identity()) else { return own.clone() };
        let at = |p: [f64; 3]| -> [f64; 3] { transform_point(map, &p.into()).coords.into() };
        let linear = linear(map);
        let scale = similarity(map);
        let turned = if linear == Matrix3::identity() {
            Turned { bounds: own.bounds, measures: None }
        } else {
            match self.turned.entry((id, std::array::from_fn(|k| linear[k].to_bits()))) {
                Entry::Occupied(known) => known.get().clone(),
                Entry::Vacant(new) => {
                    // The box around a spline itself takes as long as that of many more points.
                    let is_spline =
                        matches!(geometry, Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Trimmed(_));
                    let points = around.len().max(geometry.points().len() * if is_spline { 64 } else { 1 });
                    self.points = self.points.saturating_add(points);
                    let bounds = if self.points <= MOST_POINTS {
                        turned_bounds(geometry, around, &linear)
                    } else {
                        None
                    };
                    let measures =
                        scale.is_none().then(|| stretched(geometry, &own.measures, &linear, Measures::of));
                    new.insert(Turned { bounds, measures }).clone()
                }
            }
        };
        let mut facts = own.clone();
        facts.own = Some(Box::new(OwnFacts { measures: own.measures.clone(), bounds: own.bounds }))
            .filter(|own| own.measures != Measures::default() || own.bounds.is_some());
        let shift = [0, 1, 2].map(|k| map[(k, 3)]);
        facts.bounds = turned.bounds.map(|ends| ends.map(|end| std::array::from_fn(|k| end[k] + shift[k])));
        facts.open_at.iter_mut().for_each(|open| open.at = at(open.at));
        // A distance that is stretched unevenly is at most so long.
        let most = scale.unwrap_or_else(|| linear.singular_values().max());
        for off in &mut facts.off_at {
            (off.distance, off.tolerance) = (off.distance * most, off.tolerance * most);
        }
        facts.measures = match (turned.measures, scale) {
            (Some(measures), _) => measures,
            (None, scale) => scaled(&own.measures, scale.unwrap_or(1.0)),
        };
        if own.bounds.is_some() && facts.bounds.is_none() {
            facts.measures.unmeasured.push("the size: too much is placed in too many ways".to_owned());
        }
        facts.measures.leaks = own.measures.leaks.clone();
        facts.measures.watertight = own.measures.watertight;
        facts.measures.open.clone_from(&own.measures.open);
        facts.measures.leaks.iter_mut().for_each(|leaks| leaks.at = at(leaks.at));
        facts
    }
}

fn turned_bounds(geometry: &Geometry, around: &[Point], linear: &Matrix3<f64>) -> Option<[[f64; 3]; 2]> {
    if !around.is_empty() {
        return bounds(&around.iter().map(|p| linear * p).collect::<Vec<_>>());
    }
    let map = linear.to_homogeneous();
    match geometry.transformed(&map).ok()? {
        Geometry::Curve(curve) => Some(corners(curve.bounds())),
        Geometry::Surface(surface) => Some(corners(surface.bounds())),
        Geometry::Trimmed(trimmed) => trimmed.bounds().ok().map(corners),
        other => bounds(other.points()),
    }
}

/// Measures of what is longer in some directions than in others. A mirror does not turn the inside out of what stands.
fn stretched(
    geometry: &Geometry,
    own: &Measures,
    linear: &Matrix3<f64>,
    measure: fn(&Geometry) -> Measures,
) -> Measures {
    let found = geometry.transformed(&linear.to_homogeneous()).map(|there| measure(&there));
    let volume = own.volume.map(|volume| volume * linear.determinant().abs());
    Measures { volume, ..found.unwrap_or_default() }
}

/// Measures of what is so many times as long in all directions.
fn scaled(own: &Measures, scale: f64) -> Measures {
    let power =
        |number: Option<f64>, power: i32| number.map(|x| x * scale.powi(power)).filter(|x| x.is_finite());
    Measures {
        length: power(own.length, 1),
        area: power(own.area, 2),
        volume: power(own.volume, 3),
        within: power(own.within, 1),
        ..own.clone()
    }
}

/// How large a geometry is where it stands, as large as it is in its own coordinates: by a `measure` of its own where lengths do not go by one number.
pub(crate) fn measures(
    geometry: &Geometry,
    own: &Measures,
    standing: &Standing,
    measure: fn(&Geometry) -> Measures,
) -> Measures {
    match (standing.to_world(), standing.scale()) {
        (None, _) => own.clone(),
        (_, Some(scale)) => scaled(own, scale),
        (Some(map), None) => stretched(geometry, own, &linear(map), measure),
    }
}

/// What instances of a scene show together, by their names: the areas of surfaces, meshes and solids, volumes, and the box around all of it, in
/// the scene. Nothing where there is too much of it.
pub(crate) fn instances(scene: &Scene, placed: &mut Placed) -> HashMap<String, OwnFacts> {
    let mut sums: HashMap<String, OwnFacts> = HashMap::new();
    if scene.definitions().is_empty() {
        return sums;
    }
    let Ok(all) = scene.placed(MOST_SUMMED) else { return sums };
    for shown in all {
        let Some(instance) = shown.path.inside_out().last() else { continue };
        let object = shown.object;
        let facts = placed.facts(object.geometry_id(), object.geometry(), shown.to_world.as_ref());
        let OwnFacts { measures: sum, bounds: around } = sums.entry(instance.name().to_owned()).or_default();
        let encloses = matches!(object.geometry(), Geometry::Curve(_) | Geometry::Polyline(_));
        let add =
            |sum: Option<f64>, more: Option<f64>| more.map_or(sum, |more| Some(sum.unwrap_or(0.0) + more));
        if !encloses {
            sum.area = add(sum.area, facts.measures.area);
        }
        sum.volume = add(sum.volume, facts.measures.volume);
        sum.within = facts.measures.within.map_or(sum.within, |w| Some(sum.within.unwrap_or(0.0).max(w)));
        if let Some([low, high]) = facts.bounds {
            let [below, above] = around.get_or_insert([low, high]);
            for k in 0..3 {
                (below[k], above[k]) = (below[k].min(low[k]), above[k].max(high[k]));
            }
        }
    }
    if placed.points > MOST_POINTS {
        sums.values_mut().for_each(|sum| sum.bounds = None);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::Vector;
    use loftsman_kernel::mesh::{Mesh, Polyline};
    use loftsman_kernel::scene::Object;

    fn cube() -> Geometry {
        let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Mesh::new((0..8).map(corner).collect(), &faces).unwrap().into()
    }

    fn near(found: Option<f64>, wanted: f64) {
        assert!((found.unwrap() / wanted - 1.0).abs() < 1e-12, "{found:?} is not {wanted}");
    }

    #[test]
    fn what_is_scaled_turned_mirrored_and_stretched_is_as_large_as_it_stands() {
        let mut placed = Placed::default();
        let cube = cube();
        let turn = Matrix4::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_4);
        let cases = [
            (Matrix4::new_scaling(2.0), 24.0, 8.0, [2.0, 2.0, 2.0]),
            (Matrix4::new_scaling(-0.5), 1.5, 0.125, [0.5, 0.5, 0.5]),
            (turn, 6.0, 1.0, [2.0_f64.sqrt(), 2.0_f64.sqrt(), 1.0]),
            (Matrix4::new_nonuniform_scaling(&Vector::new(1.0, 2.0, -3.0)), 22.0, 6.0, [1.0, 2.0, 3.0]),
        ];
        for (map, area, volume, size) in cases {
            let found = placed.facts(1, &cube, Some(&map));
            near(found.measures.area, area);
            near(found.measures.volume, volume);
            let [low, high] = found.bounds.unwrap();
            (0..3).for_each(|k| near(Some(high[k] - low[k]), size[k]));
            near(found.own.unwrap().measures.volume, 1.0);
        }
        let line: Geometry =
            Polyline { points: vec![Point::origin(), Point::new(1.0, 0.0, 0.0)], closed: false }.into();
        let stretched = Matrix4::new_nonuniform_scaling(&Vector::new(5.0, 2.0, 3.0));
        near(placed.facts(2, &line, Some(&stretched)).measures.length, 5.0);
        let moved = placed.facts(1, &cube, Some(&Matrix4::new_translation(&Vector::new(5.0, 0.0, -1.0))));
        assert_eq!(moved.bounds, Some([[5.0, 0.0, -1.0], [6.0, 1.0, 0.0]]));
        // What was looked at for these boxes: each way of turning once.
        assert_eq!(placed.points, 4 * 8 + 2);
        assert!(placed.facts(2, &line, Some(&Matrix4::identity())).own.is_none());
    }

    #[test]
    fn an_instance_is_as_large_as_what_it_shows_where_it_stands() {
        let mut pair = Definition::new("pair");
        let mut second = Object::new("second", cube());
        second.transform = Some(Matrix4::new_translation(&Vector::new(4.0, 0.0, 0.0)));
        pair.add(Object::new("first", cube())).unwrap();
        pair.add(second).unwrap();
        let mut scene = Scene::new();
        scene.define(pair).unwrap();
        let mut twice = Object::new("twice", Geometry::Instance("pair".to_owned()));
        twice.transform = Some(Matrix4::new_scaling(2.0));
        scene.add(twice).unwrap();
        let all = instances(&scene, &mut Placed::default());
        let OwnFacts { measures, bounds: around } = &all["twice"];
        near(measures.area, 48.0);
        near(measures.volume, 16.0);
        assert_eq!(*around, Some([[0.0; 3], [10.0, 2.0, 2.0]]));
    }
}
