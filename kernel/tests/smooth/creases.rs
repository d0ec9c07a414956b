//! Corners along knot lines of surfaces are told where they are sharpest: held against many places of an evaluator of the tests' own.

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::spline::{Space, Surface};

use super::Dice;
use super::evaluator::{angle, joints, on_surface, turned};

/// A net of any heights with a corner along `u = 1`, some of it rational, some of it periodic along that.
fn creased(dice: &mut Dice) -> Surface {
    let (p, q) = (1 + dice.below(4), 1 + dice.below(4));
    let mut knots = vec![0.0; p + 1];
    knots.extend(vec![1.0; p]);
    knots.extend(vec![2.0; p + 1]);
    let u = Space::open(p, knots).unwrap();
    let along = [0.0, 0.3, 1.0, 2.5, 2.7, 4.0];
    let v = if dice.below(3) == 0 {
        Space::periodic(q, along.to_vec()).unwrap()
    } else {
        Space::clamped(q, &along).unwrap()
    };
    let at = |i: usize, j: usize, dice: &mut Dice| Point::new(i as f64, j as f64, 0.0) + dice.vector(0.45);
    let net: Vec<Point> =
        (0..u.len()).flat_map(|i| (0..v.len()).map(move |j| (i, j))).map(|(i, j)| at(i, j, dice)).collect();
    let weights = (dice.below(2) == 0).then(|| net.iter().map(|_| dice.between(0.5, 2.0)).collect());
    Surface::build(u, v, net, weights).unwrap()
}

/// The angle between the normals on both sides at `2000` places of each span of `u = 1`, in degrees.
fn angles(surface: &Surface) -> Vec<f64> {
    let [left, right] = joints(surface.u(), surface.u().degree(), false)[0];
    let other = turned(surface);
    let (t, q) = (surface.v().flat(), surface.v().degree());
    let mut all = Vec::new();
    for s in (q..t.len() - q - 1).filter(|&s| t[s] < t[s + 1]) {
        for k in 0..=2000 {
            let along = (s, t[s] + (t[s + 1] - t[s]) * f64::from(k) / 2000.0);
            let normal = |side| {
                let (across, along) =
                    (on_surface(surface, side, along)[1], on_surface(&other, along, side)[1]);
                across.cross(&along)
            };
            all.push(angle(normal(left), normal(right)).to_degrees());
        }
    }
    all
}

#[test]
fn a_corner_along_a_line_is_told_where_it_is_sharpest() {
    let (mut told, mut between, mut exact) = (0, 0, 0);
    for seed in 0..80 {
        let mut dice = Dice(91_000 + seed);
        let surface = creased(&mut dice);
        let at = [dice.between(0.5, 1.5), dice.between(0.0, 4.0)];
        let Ok(edited) = Edit::new(&surface).ask(position(at).by(dice.vector(1.5))).solve() else { continue };
        let (before, after) = (angles(&surface), angles(edited.shape()));
        let largest = before
            .iter()
            .zip(&after)
            .filter(|(b, a)| (*a - *b).abs() > 1e-3)
            .map(|(_, a)| *a)
            .fold(0.0, f64::max);
        let corners = &edited.report().smooth.corners;
        let Some(corner) = corners.iter().find(|c| c.place.starts_with("along u = 1")) else {
            assert!(largest < 1e-3, "{seed}: {largest} untold");
            continue;
        };
        let found = corner.degrees.unwrap();
        told += 1;
        between += usize::from(
            !["0)", "0.3)", "1)", "2.5)", "2.7)", "4)"]
                .iter()
                .any(|end| corner.place.ends_with(&format!("= {end}"))),
        );
        // A thousandth may be told less (an end or the middle of a span, where it is as sharp), and between two places it may be sharper: where a normal
        // turns over because it is nearly none, much.
        assert!(found >= largest * (1.0 - 1e-3), "{seed}: {found} told, {largest}: {}", corner.place);
        exact += usize::from(found <= largest * 1.01 + 0.1);
    }
    assert!(told > 60 && between > 20 && told - exact < 6, "{told}, {between}, {exact}");
}
