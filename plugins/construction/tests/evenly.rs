//! Points spread evenly, against another rule for lengths.

use loftsman_construction::{Spread, spread};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

/// A rational curve of degree 5 whose weights differ by a factor of eight, with a sharp turn.
#[test]
fn a_curve_that_nearly_stops_is_divided_evenly() {
    let mut knots = vec![4.0; 6];
    knots.extend([4.798583984375; 2]);
    knots.extend([5.26220703125; 6]);
    let points = [
        [-0.416015625, -0.021484375, -0.697265625],
        [-0.9453125, -0.421875, -0.3671875],
        [-0.681640625, -0.32421875, -0.826171875],
        [0.265625, -0.287109375, 0.0390625],
        [-0.720703125, 0.74609375, 0.98828125],
        [0.05859375, -0.302734375, 0.220703125],
        [-0.791015625, 0.646484375, 0.568359375],
        [-0.232421875, 0.294921875, -0.23046875],
    ];
    let weights = vec![
        2.575439453125,
        2.289794921875,
        3.08447265625,
        0.3818359375,
        3.058837890625,
        2.538818359375,
        1.2021484375,
        2.447265625,
    ];
    let points = points.map(|[x, y, z]| Point::new(x, y, z)).to_vec();
    let curve = Curve::rational(Space::open(5, knots).unwrap(), points, weights).unwrap();
    for count in 3..9 {
        let sampled = spread(&curve, Spread::Count(count)).unwrap();
        for pair in sampled.parameters.windows(2) {
            let length = curve.length_between(pair[0], pair[1], 1e-12).unwrap().value;
            assert!((length - sampled.spacing).abs() < 1e-11, "{length} {sampled:?}");
        }
        for (u, p) in sampled.parameters.iter().zip(&sampled.points) {
            assert!((curve.point(*u).unwrap() - p).norm() < 1e-14);
        }
    }
}
