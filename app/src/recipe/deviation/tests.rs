//! Against closed forms and brute force.

use loftsman_kernel::Vector;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};

use loftsman_kernel::Point;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::{Curve, Space, Surface};

use super::deviation;

pub(crate) fn arch(degree: usize, lift: f64) -> Curve {
    let count = degree + 4;
    let at = |k: usize| Point::new(k as f64, (k * (count - 1 - k)) as f64 / 4.0, lift);
    Curve::new(Space::clamped_uniform(degree, count).unwrap(), (0..count).map(at).collect()).unwrap()
}

pub(crate) fn sheet(lift: f64) -> Surface {
    let space = || Space::clamped_uniform(3, 5).unwrap();
    let at = |k: usize| Point::new((k / 5) as f64, (k % 5) as f64, lift + (k % 3) as f64 / 9.0);
    Surface::new(space(), space(), (0..25).map(at).collect()).unwrap()
}

/// To the nearest point, not the one of the same parameter: a shape that only runs otherwise has not moved.
#[test]
fn the_deviation_is_a_distance_of_shapes() {
    for degree in [1, 2, 3, 5, 7] {
        let old = arch(degree, 0.0);
        for (new, off) in [
            (arch(degree, 0.5), 0.5),
            (old.elevate(1).unwrap(), 0.0),
            (old.insert_knots(&[0.25, 0.5]).unwrap(), 0.0),
            (old.reverse().unwrap(), 0.0),
        ] {
            let found = deviation(&old.clone().into(), &new.into()).unwrap();
            assert!((found - off).abs() < 1e-12, "degree {degree}: {found}, {off}");
        }
    }
    let found = deviation(&sheet(0.0).into(), &sheet(0.125).into()).unwrap();
    assert!((found - 0.125).abs() < 1e-12, "{found}");
    let cloud = |by: Vector| Geometry::from(Cloud { points: vec![Point::origin() + by, Point::origin()] });
    assert_eq!(deviation(&cloud(Vector::zeros()), &cloud(Vector::new(0.0, 3.0, 4.0))), Some(5.0));
    assert_eq!(deviation(&cloud(Vector::new(0.0, 0.0, -0.5)), &arch(3, 0.0).into()), Some(0.5));
    assert_eq!(deviation(&arch(3, 0.0).into(), &cloud(Vector::zeros())), None);
    let fewer = Geometry::from(Cloud { points: vec![Point::origin()] });
    assert_eq!(deviation(&cloud(Vector::zeros()), &fewer), None);
}

/// The furthest place is found, wherever between the places of the grid it is: against half a million places of a bump that one vertex makes, of a
/// curve and of a surface with few and with many spans.
#[test]
fn the_furthest_place_is_found_between_the_places_of_the_grid() {
    for (count, which) in [(6, 1), (6, 3), (40, 17), (600, 301), (4003, 1777)] {
        let space = Space::clamped_uniform(3, count).unwrap();
        let points: Vec<Point> = (0..count).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
        let mut moved = points.clone();
        moved[which].y += 0.3;
        let [old, new] = [points, moved].map(|p| Curve::new(space.clone(), p).unwrap());
        let (a, b) = space.domain();
        let far = (0..=500_000).map(|k| new.point(a + (b - a) * f64::from(k) / 500_000.0).unwrap().y);
        let far = far.fold(0.0, f64::max);
        let found = deviation(&old.into(), &new.into()).unwrap();
        assert!((found - far).abs() < 1e-6 * far, "{count}: {found} {far}");
    }
    for (count, which) in [(4, 6), (7, 15), (30, 317), (123, 7001)] {
        let space = || Space::clamped_uniform(3, count).unwrap();
        let flat: Vec<Point> =
            (0..count * count).map(|k| Point::new((k / count) as f64, (k % count) as f64, 0.0)).collect();
        let mut moved = flat.clone();
        moved[which].z += 0.05;
        let [old, new] = [flat, moved].map(|p| Surface::new(space(), space(), p).unwrap());
        // What a vertex moves is the product of two basis functions, each with a peak of its own.
        let peak = |vertex: usize| {
            let mut high = vec![Point::origin(); count];
            high[vertex].y = 1.0;
            let basis = Curve::new(space(), high).unwrap();
            let (a, b) = space().domain();
            (0..=200_000)
                .map(|k| basis.point(a + (b - a) * f64::from(k) / 200_000.0).unwrap().y)
                .fold(0.0, f64::max)
        };
        let far = 0.05 * peak(which / count) * peak(which % count);
        let found = deviation(&old.into(), &new.into()).unwrap();
        assert!((found - far).abs() < 1e-6 * far, "{count}: {found} {far}");
    }
}

/// Of several bumps the highest, although a lower one is where a grid has its places, or where the vertex is that has moved most.
#[test]
fn of_several_bumps_the_highest_is_found() {
    let mut state = 3_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX)
    };
    for (count, bumps) in [(50, 3), (400, 7), (2503, 12)] {
        let space = Space::clamped_uniform(3, count).unwrap();
        let points: Vec<Point> = (0..count).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
        let mut moved = points.clone();
        // One vertex far, beside others that move further together.
        moved[count / 3].y += 1.0;
        for _ in 0..bumps {
            let k = (noise() * (count - 4) as f64) as usize;
            let height = 0.5 + 0.4 * noise();
            moved[k..k + 4].iter_mut().for_each(|p| p.y = height);
        }
        let [old, new] = [points, moved].map(|p| Curve::new(space.clone(), p).unwrap());
        let (a, b) = space.domain();
        let far = (0..=800_000).map(|k| new.point(a + (b - a) * f64::from(k) / 800_000.0).unwrap().y);
        let far = far.fold(0.0, f64::max);
        let found = deviation(&old.into(), &new.into()).unwrap();
        assert!((found - far).abs() < 1e-5 * far, "{count}: {found} {far}");
    }
    for (count, bumps) in [(20, 3), (60, 8)] {
        let space = || Space::clamped_uniform(2, count).unwrap();
        let flat: Vec<Point> =
            (0..count * count).map(|k| Point::new((k / count) as f64, (k % count) as f64, 0.0)).collect();
        let mut moved = flat.clone();
        moved[count * 7 + 9].z += 1.0;
        for _ in 0..bumps {
            let [i, j] = [(); 2].map(|()| (noise() * (count - 3) as f64) as usize);
            let height = 0.6 + 0.35 * noise();
            for k in (i..i + 3).flat_map(|i| (j..j + 3).map(move |j| i * count + j)) {
                moved[k].z = height;
            }
        }
        let [old, new] = [flat, moved].map(|p| Surface::new(space(), space(), p).unwrap());
        let (a, b) = space().domain();
        let at = |k: u32| a + (b - a) * f64::from(k) / 1200.0;
        let far = (0..=1200 * 1201).map(|k: u32| new.point(at(k / 1201), at(k % 1201)).unwrap().z);
        let far = far.fold(0.0, f64::max);
        let found = deviation(&old.into(), &new.into()).unwrap();
        // At a flat top but for rounding.
        assert!(found > far * (1.0 - 1e-12) && found < far * (1.0 + 1e-3), "{count}: {found} {far}");
    }
}

/// What loops cut away has not moved, whatever its surface does there; a border that cuts a bump in two is where it is highest. A Brep's faces are such parts.
#[test]
fn what_is_cut_away_does_not_count() {
    let space = || Space::clamped_uniform(3, 12).unwrap();
    let (_, end) = space().domain();
    let greville = |k: usize| space().greville(k);
    let flat: Vec<Point> = (0..144).map(|k| Point::new(greville(k / 12), greville(k % 12), 0.0)).collect();
    let corners = [[0.0, 0.0], [0.5 * end, 0.0], [0.5 * end, end], [0.0, end]];
    let at = |k: usize| Point::new(corners[k % 4][0], corners[k % 4][1], 0.0);
    let outer =
        (0..4).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap()).collect();
    let regions = vec![Region { outer, holes: Vec::new() }];
    for (row, counts) in [(10, false), (6, true), (2, true)] {
        let mut moved = flat.clone();
        moved[row * 12 + 5].z = 0.25;
        let [old, new] = [&flat, &moved].map(|p| Surface::new(space(), space(), p.clone()).unwrap());
        let places = |k: u32| end * f64::from(k) / 1000.0;
        let far = (0..=500)
            .flat_map(|i| (0..=1000).map(move |j| (i, j)))
            .map(|(i, j)| new.point(places(i), places(j)).unwrap().z)
            .fold(0.0, f64::max);
        assert_eq!(far > 0.0, counts);
        let [old, new] = [old, new]
            .map(|s| Geometry::from(Trimmed::new(s, regions.clone(), Vec::new(), Vec::new()).unwrap()));
        let found = deviation(&old, &new).unwrap();
        // What has not moved is where it was to rounding, on a sheet of 9.
        assert!((found - far).abs() <= 1e-4 * far + 1e-13 * end, "{row}: {found} {far}");
    }
    let block =
        |by: f64| Geometry::from(Brep::block(Point::new(by, 0.0, 0.0), Point::new(2.0, 3.0, 4.0)).unwrap());
    let found = deviation(&block(0.0), &block(0.5)).unwrap();
    assert!((found - 0.5).abs() < 1e-9, "{found}");
    assert_eq!(deviation(&block(0.5), &block(0.5)), Some(0.0));
}

/// A surface all of which is about as far from each place of the other: how far that is comes out all the same, and no search looks at all of it for each.
#[test]
fn a_surface_round_another_is_as_far_as_it_is() {
    let arc = |radius: f64| {
        let at = |k: i32| {
            Point::new(
                radius * [0.0, 1.0, 1.0, 1.0, 0.0][k as usize],
                0.0,
                radius * [-1.0, -1.0, 0.0, 1.0, 1.0][k as usize],
            )
        };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let space = Space::clamped(2, &[0.0, 1.0, 1.0, 2.0]).unwrap();
        let arc = Curve::rational(space, (0..5).map(at).collect(), vec![1.0, half, 1.0, half, 1.0]).unwrap();
        Surface::revolution(&arc, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap()
    };
    for small in [1e-3, 0.5] {
        let found = deviation(&arc(1.0).into(), &arc(small).into()).unwrap();
        assert!((found - (1.0 - small)).abs() < 1e-9, "{small}: {found}");
    }
}

/// Of a solid that is moved as a whole no distance is looked for, and it is known from one of which a part has moved.
#[test]
fn what_is_moved_as_a_whole_is_known() {
    let block = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0)).unwrap();
    let points = block.points().to_vec();
    // Twice as large, turned and mirrored; and with one face pulled out, which an affine map does to a block.
    let turned = |p: &Point| Point::new(2.0 * p.y - 1.0, 5.0 - 2.0 * p.x, 2.0 * p.z);
    let mapped: Vec<Point> = points.iter().map(turned).collect();
    let pulled: Vec<Point> = points.iter().map(|p| Point::new(1.1 * p.x, p.y, p.z)).collect();
    let mut bent = mapped.clone();
    bent[points.len() - 1].x += 1e-3;
    assert!(super::is_similar(&points, &mapped) && super::is_similar(&points, &points));
    for other in [&bent, &pulled, &mapped[1..].to_vec()] {
        assert!(!super::is_similar(&points, other));
    }
    // Points of one plane have no map of their own.
    let flat: Vec<Point> = points.iter().map(|p| Point::new(p.x, p.y, 0.0)).collect();
    assert!(!super::is_similar(&flat, &flat) && !super::is_similar(&[], &[]));
}
