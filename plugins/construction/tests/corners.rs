//! Offsets of polygons with sharp corners: against areas of their own making, line by line.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should panic")]

use std::f64::consts::PI;

use loftsman_construction::{Corners, Offset, OffsetOptions, offset};
use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};

type Place = [f64; 2];

fn polygon(corners: &[Place]) -> Curve {
    let points: Vec<Point> =
        corners.iter().chain(&corners[..1]).map(|c| Point::new(c[0], c[1], 0.0)).collect();
    Curve::new(Space::clamped_uniform(1, points.len()).unwrap(), points).unwrap()
}

fn sharp(corners: &[Place], away: f64) -> Offset {
    let options = OffsetOptions { corners: Corners::Sharp, ..OffsetOptions::default() };
    offset(&polygon(corners), away, &options).unwrap_or_else(|error| panic!("{away}: {error}: {corners:?}"))
}

fn area(corners: &[Place]) -> f64 {
    let next = corners.iter().skip(1).chain(corners);
    corners.iter().zip(next).map(|(p, q)| 0.5 * (p[0] * q[1] - q[0] * p[1])).sum()
}

/// The corners of each curve, which are closed polygons.
fn outlines(found: &Offset) -> Vec<Vec<Place>> {
    let outline = |curve: &Curve| {
        assert!(curve.degree() == 1 && curve.points().first() == curve.points().last(), "{curve:?}");
        curve.points().iter().skip(1).map(|p| [p.x, p.y]).collect()
    };
    found.curves.iter().map(outline).collect()
}

/// Where a line at a height is inside a polygon, by its crossings in pairs.
fn across(corners: &[Place], y: f64) -> Vec<(f64, f64)> {
    let next = corners.iter().skip(1).chain(corners);
    let mut at: Vec<f64> = corners
        .iter()
        .zip(next)
        .filter(|(p, q)| (p[1] > y) != (q[1] > y))
        .map(|(p, q)| p[0] + (q[0] - p[0]) * (y - p[1]) / (q[1] - p[1]))
        .collect();
    at.sort_by(f64::total_cmp);
    at.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()
}

/// The length of a union, and of what it has in common with parts that are apart.
fn union(mut parts: Vec<(f64, f64)>, within: &[(f64, f64)]) -> (f64, f64) {
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut whole, mut common, mut end) = (0.0, 0.0, f64::NEG_INFINITY);
    for (a, b) in parts {
        let from = a.max(end);
        if b > from {
            whole += b - from;
            common += within.iter().map(|w| (b.min(w.1) - from.max(w.0)).max(0.0)).sum::<f64>();
            end = b;
        }
    }
    (whole, common)
}

/// The area of what a polygon becomes, run counterclockwise: with the strips beside its sides and the quadrangles at its corners, or without them.
fn wanted(corners: &[Place], away: f64, lines: usize) -> f64 {
    let n = corners.len();
    let unit = |k: usize| {
        let (p, q) = (corners[k % n], corners[(k + 1) % n]);
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        [(q[0] - p[0]) / length, (q[1] - p[1]) / length]
    };
    let arm = |k: usize| [unit(k)[1] * away, -unit(k)[0] * away];
    let plus = |p: Place, v: Place| [p[0] + v[0], p[1] + v[1]];
    let mut shapes = Vec::new();
    for k in 0..n {
        let (p, q) = (corners[k], corners[(k + 1) % n]);
        shapes.push(vec![p, q, plus(q, arm(k)), plus(p, arm(k))]);
        let (u, v) = (unit(k), unit(k + 1));
        if (u[0] * v[1] - u[1] * v[0]) * away > 0.0 {
            let cosine = u[0] * v[0] + u[1] * v[1];
            let (a, b) = (arm(k), arm(k + 1));
            let tip = [(a[0] + b[0]) / (1.0 + cosine), (a[1] + b[1]) / (1.0 + cosine)];
            shapes.push(vec![q, plus(q, a), plus(q, tip), plus(q, b)]);
        }
    }
    // What starts or ends level does so between lines.
    let mut heights: Vec<f64> = shapes.iter().flatten().chain(corners).map(|c| c[1]).collect();
    heights.sort_by(f64::total_cmp);
    let widest = (heights[heights.len() - 1] - heights[0]) / lines as f64;
    let mut sum = 0.0;
    for level in heights.windows(2) {
        let count = ((level[1] - level[0]) / widest).ceil();
        let step = (level[1] - level[0]) / count;
        for k in 0..count as usize {
            let y = level[0] + step * (k as f64 + 0.5);
            let own = across(corners, y);
            let mut parts: Vec<(f64, f64)> = shapes.iter().flat_map(|shape| across(shape, y)).collect();
            sum += step
                * if away > 0.0 {
                    parts.extend(&own);
                    union(parts, &[]).0
                } else {
                    own.iter().map(|(a, b)| b - a).sum::<f64>() - union(parts, &own).1
                };
        }
    }
    sum
}

/// How often sides that are no neighbours cross.
fn crossings(outlines: &[Vec<Place>]) -> usize {
    let sides: Vec<(Place, Place)> =
        outlines.iter().flat_map(|o| (0..o.len()).map(|k| (o[k], o[(k + 1) % o.len()]))).collect();
    let side = |(p, q): (Place, Place), r: Place| {
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) / length
    };
    let apart = |s: (Place, Place), t: (Place, Place)| {
        let (a, b) = (side(s, t.0), side(s, t.1));
        a.abs() > 1e-7 && b.abs() > 1e-7 && a * b < 0.0
    };
    let mut count = 0;
    for (k, &s) in sides.iter().enumerate() {
        count += sides[k + 1..].iter().filter(|&&t| apart(s, t) && apart(t, s)).count();
    }
    count
}

/// Closed, without crossings, of the right area: told is how many curves there are.
fn checked(corners: &[Place], away: f64, lines: usize) -> usize {
    let found = sharp(corners, away);
    assert_eq!(found.blunted, 0, "{away}: {corners:?}");
    let outlines = outlines(&found);
    let own: f64 = outlines.iter().map(|outline| area(outline)).sum();
    let wanted = wanted(corners, away, lines);
    assert!((own - wanted).abs() < 2e-5 * area(corners).max(own), "{away}: {own}, not {wanted}: {corners:?}");
    assert_eq!(crossings(&outlines), 0, "{away}: {corners:?}");
    outlines.len()
}

#[test]
fn prolonged_corners_are_cut_against_one_another() {
    // Two triangles that meet in a waist 4 wide, whose corners meet before the sides do.
    let hourglass = [[0.0, 0.0], [20.0, 0.0], [12.0, 10.0], [20.0, 20.0], [0.0, 20.0], [8.0, 10.0]];
    // Its tips run through one another; no sides are twice the distance apart, and none is said to be.
    for away in [-1.75, -1.8, -1.95, -2.1] {
        assert!(!sharp(&hourglass, away).strips, "{away}");
    }
    let found = outlines(&sharp(&hourglass, -1.8));
    assert_eq!(found.len(), 2);
    // Of lines `x = 2 + 0.8 y` to both sides of the middle, moved inwards, up to `y = 8.2`.
    let height = 8.2 + (2.0 - 1.8 * 1.64_f64.sqrt()) / 0.8;
    for triangle in &found {
        assert!(triangle.len() == 3 && (area(triangle) - 0.8 * height * height).abs() < 1e-9, "{triangle:?}");
    }
    assert_eq!(checked(&hourglass, -1.8, 20_000), 2);
    // Two jaws whose tips meet before they do: around the throat there is a second outline, run backwards.
    let jaws = [
        [0.0, 0.0],
        [20.0, 0.0],
        [20.0, 4.0],
        [10.0, 9.0],
        [9.0, 4.0],
        [4.0, 4.0],
        [4.0, 20.0],
        [9.0, 20.0],
        [10.0, 15.0],
        [20.0, 20.0],
        [20.0, 24.0],
        [0.0, 24.0],
    ];
    assert_eq!(checked(&jaws, 2.3, 20_000), 2);
    assert_eq!(checked(&jaws, 1.0, 20_000), 1);
}

/// Teeth of one height with gaps narrower than twice the distance, and than the distance: prolonged sides run along one another, and along the teeth.
#[test]
fn sides_in_one_line_are_one() {
    for gap in [0.3, 0.9, 1.5] {
        let mut teeth = vec![[0.0, 0.0], [4.0 + 3.0 * gap, 0.0]];
        for k in (0..4).rev() {
            let x = f64::from(k) * (1.0 + gap);
            teeth.extend([[x + 1.0, 5.0], [x, 5.0]]);
            if k > 0 {
                teeth.extend([[x, 2.0], [x - gap, 2.0]]);
            }
        }
        assert_eq!(checked(&teeth, 1.0, 20_000), 1, "{gap}");
        let box_of = area(&outlines(&sharp(&teeth, 1.0))[0]);
        assert!((box_of - (6.0 + 3.0 * gap) * 7.0).abs() < 1e-9, "{gap}: {box_of}");
    }
}

/// Polygons seen whole from the origin, by numbers that look like chance.
#[test]
fn stars_have_the_area_of_their_strips_and_tips() {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut made = 0;
    while made < 60 {
        let n = 5 + (8.0 * random()) as usize;
        let star: Vec<Place> = (0..n)
            .map(|k| {
                let angle = std::f64::consts::TAU * (k as f64 + 0.8 * random()) / n as f64;
                // With a waist.
                let radius = (4.0 + 6.0 * random()) * (0.15 + 0.85 * angle.cos().abs());
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let away = [0.23, -0.23, 0.57, -0.57, 1.37, -0.83][made % 6];
        let options = OffsetOptions { corners: Corners::Sharp, ..OffsetOptions::default() };
        // Those of which nothing is left, or with corners too sharp for a tip, are others' matter.
        let fits = |found: Offset| found.blunted == 0 && found.cut > 0;
        if area(&star) > 0.0 && offset(&polygon(&star), away, &options).is_ok_and(fits) {
            checked(&star, away, 20_000);
            made += 1;
        }
    }
}

/// The outline of letters, by 137 points: where tips met, ever shorter steps were tried for half a minute and more.
#[test]
fn an_outline_of_letters_is_moved_at_once() {
    let place = |line: &str| {
        let mut numbers = line.split(' ').map(|word| word.parse::<f64>().unwrap());
        [numbers.next().unwrap(), numbers.next().unwrap()]
    };
    let mut word: Vec<Place> = include_str!("golden/word.txt").lines().map(place).collect();
    if area(&word) < 0.0 {
        word.reverse();
    }
    let begin = std::time::Instant::now();
    for (away, curves) in [(0.04, 1), (0.05, 2), (-0.045, 2), (-0.06, 1), (-0.08, 1)] {
        let found = sharp(&word, away);
        assert_eq!(found.curves.len(), curves, "{away}");
        let outlines = outlines(&found);
        let (own, wanted) = (outlines.iter().map(|o| area(o)).sum::<f64>(), wanted(&word, away, 20_000));
        assert!((own - wanted).abs() < 1e-6, "{away}: {own}, not {wanted}");
        assert_eq!(crossings(&outlines), 0, "{away}");
    }
    let took = begin.elapsed();
    assert!(took.as_secs() < 20, "{took:?}");
}

fn polyline(corners: &[Place]) -> Curve {
    let points: Vec<Point> = corners.iter().map(|c| Point::new(c[0], c[1], 0.0)).collect();
    Curve::new(Space::clamped_uniform(1, points.len()).unwrap(), points).unwrap()
}

/// How long the offset is, with corners sharp and round, and in how many curves each.
fn lengths(source: &Curve, away: f64) -> [(f64, usize); 2] {
    [Corners::Sharp, Corners::Round].map(|corners| {
        let options = OffsetOptions { corners, ..OffsetOptions::default() };
        let found =
            offset(source, away, &options).unwrap_or_else(|error| panic!("{corners:?} {away}: {error}"));
        for curve in &found.curves {
            let (a, b) = curve.domain();
            for k in 0..=400 {
                let place = curve.point((a + (b - a) * f64::from(k) / 400.0).min(b)).unwrap();
                let near = source.closest(place).unwrap().distance;
                assert!(near > away.abs() - found.tolerance, "{corners:?} {away}: {near} at {place}");
            }
        }
        (found.curves.iter().map(|c| c.length(1e-12).unwrap().value).sum(), found.curves.len())
    })
}

/// A spike at a sharp corner is gone round, and the tip of the corner at its root is whole: a curve that comes back to its corner has the other side there, too.
#[test]
fn spikes_at_sharp_corners_are_gone_round() {
    let (away, long) = (0.1, 3.0);
    for degrees in (20..=150).step_by(10) {
        let turn = f64::from(degrees).to_radians();
        let root = [1.7, -0.4];
        let spike = [root[0] + long * turn.cos(), root[1] + long * turn.sin()];
        let source = polyline(&[[0.7, -0.4], root, spike, root]);
        // Within the angle the sides end where they meet the first leg's circle of that radius; outside the tip prolongs two of them.
        let beside = away * (0.5 * turn).tan();
        let whole = 1.0 + 2.0 * long + PI * away;
        let [(sharp, parts), (round, _)] = lengths(&source, away);
        assert!((sharp - whole - beside).abs() < 1e-5 && parts == 1, "{degrees}: {sharp} in {parts}");
        assert!((round - whole + beside - away * turn).abs() < 1e-5, "{degrees}: {round}");
        let [(inner, parts), _] = lengths(&source, -away);
        assert!((inner - whole + 2.0 * beside).abs() < 1e-5 && parts == 1, "{degrees}: {inner} in {parts}");
    }
}

/// A tip that comes to the other side of the curve at once is not there, and what ended there ends: nothing begins in its stead.
#[test]
fn tips_beyond_the_curve_are_left_out() {
    let away = 0.1;
    for degrees in [30.0_f64, 45.0, 60.0, 80.0, 100.0, 120.0] {
        // Back half way along the spike, and across it: only the tip at the root is there, if it is no further than four distances.
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let source =
            polyline(&[[-1.0, 0.0], [0.0, 0.0], [-cosine, sine], [-0.5 * cosine, 0.5 * sine], [2.0, 1.0]]);
        let turn = (180.0 - degrees).to_radians();
        let [(sharp, parts), (round, rounds)] = lengths(&source, away);
        let more = away * (2.0 * (0.5 * turn).tan() - turn);
        assert!((sharp - round - more).abs() < 1e-5, "{degrees}: {sharp}, {round}, {more}");
        assert_eq!(parts, rounds, "{degrees}");
    }
    for degrees in [30.0_f64, 45.0] {
        // A spike out of a corner, moved inwards: the tip is there as far as the corner is nearest.
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let spike = [-0.8 * cosine, 0.8 * sine];
        let source = polygon(&[[-1.0, 0.0], [0.0, 0.0], spike, [0.0, 0.0], [1.0, -1.0], [-1.0, -2.0]]);
        let [(sharp, parts), (round, rounds)] = lengths(&source, -away);
        let left = (45.0 - degrees).to_radians();
        let more = away * (left.tan() - left);
        assert!((sharp - round - more).abs() < 1e-5 && parts == rounds, "{degrees}: {sharp}, {round}");
    }
    // A tip that comes by the curve's own start is cut round that, and not where it is nearest.
    let away = 0.26;
    let [start, corner, end] = [[-0.1, -0.9], [0.0, -1.0], [-2.1, -2.4]];
    let source = polyline(&[start, [0.2, -1.6], corner, end]);
    let unit = |p: Place, q: Place| {
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        [(q[0] - p[0]) / length, (q[1] - p[1]) / length]
    };
    let (u, v) = (unit([0.2, -1.6], corner), unit(corner, end));
    let turn = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
    let side = away * (0.5 * turn).tan();
    let tip = [corner[0] + u[1] * away + u[0] * side, corner[1] - u[0] * away + u[1] * side];
    let foot = (start[0] - tip[0]) * v[0] + (start[1] - tip[1]) * v[1];
    let height = (start[0] - tip[0]) * v[1] - (start[1] - tip[1]) * v[0];
    let second = foot - (away * away - height * height).sqrt();
    // Of the arc about the corner what is no nearer to the start: to where both circles meet.
    let apart = (start[0] - corner[0]).hypot(start[1] - corner[1]);
    let towards = (start[1] - corner[1]).atan2(start[0] - corner[0]);
    let arc = towards - (-u[0]).atan2(u[1]) - (0.5 * apart / away).acos();
    let [(sharp, parts), (round, rounds)] = lengths(&source, away);
    let more = side + second - away * arc;
    assert!((sharp - round - more).abs() < 1e-5, "{sharp}, {round}, {more}");
    assert_eq!(parts, rounds);
}
