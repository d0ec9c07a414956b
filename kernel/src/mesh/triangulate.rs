//! Polygons as triangles.

use crate::{Point, Vector};

/// Above this many corners a face is cut as a fan from its first corner: cutting ears costs the square of it.
pub const EARS: usize = 2048;

/// Appends the triangles of a face. Quadrilaterals are cut so that both halves look the same way, along the
/// shorter diagonal if both ways do; larger faces by their ears (Meisters 1975), seen along their area vector.
/// Triangles that use a point twice are left out. `corners` are numbers of `points`; three are appended for each triangle. `O(corners²)` up to
/// [`EARS`] corners, else `O(corners)`.
pub fn face(points: &[Point], corners: &[u32], out: &mut Vec<u32>) {
    let mut push = |a: u32, b: u32, c: u32| {
        if a != b && b != c && c != a {
            out.extend([a, b, c]);
        }
    };
    match *corners {
        [] | [_] | [_, _] => {}
        [a, b, c] => push(a, b, c),
        _ if corners.len() > EARS => {
            for pair in corners[1..].windows(2) {
                push(corners[0], pair[0], pair[1]);
            }
        }
        _ => {
            let place = |k: u32| points[k as usize];
            let normal = area(points, corners);
            let turn =
                |a: u32, b: u32, c: u32| (place(b) - place(a)).cross(&(place(c) - place(b))).dot(&normal);
            if let [a, b, c, d] = *corners {
                let good = |t: [f64; 2]| t[0] > 0.0 && t[1] > 0.0;
                let (ac, bd) = (good([turn(a, b, c), turn(a, c, d)]), good([turn(a, b, d), turn(b, c, d)]));
                let shorter = (place(d) - place(b)).norm_squared() < (place(c) - place(a)).norm_squared();
                if bd && (shorter || !ac) {
                    push(a, b, d);
                    push(b, c, d);
                } else {
                    push(a, b, c);
                    push(a, c, d);
                }
                return;
            }
            ears(corners, &turn, &mut push);
        }
    }
}

fn ears(corners: &[u32], turn: &dyn Fn(u32, u32, u32) -> f64, push: &mut dyn FnMut(u32, u32, u32)) {
    let mut ring: Vec<u32> = corners.to_vec();
    let mut at = 0;
    let mut since = 0;
    while ring.len() > 3 {
        let n = ring.len();
        at %= n;
        let (a, b, c) = (ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]);
        let inside = |p: u32| {
            p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
        };
        let ear = turn(a, b, c) > 0.0 && !ring.iter().any(|&p| inside(p));
        // A face that crosses itself or has no area may have no ear left: cut one corner anyway and go on.
        if ear || since >= n {
            push(a, b, c);
            ring.remove(at);
            since = 0;
            // Going on at the corner after the next makes rounder triangles than a fan.
            at += 1;
        } else {
            at += 1;
            since += 1;
        }
    }
    if let [a, b, c] = ring[..] {
        push(a, b, c);
    }
}

/// Newell's area vector, about the first corner, scaled so that nothing overflows.
fn area(points: &[Point], corners: &[u32]) -> Vector {
    let origin = points[corners[0] as usize];
    let offset = |k: u32| points[k as usize] - origin;
    let size = corners.iter().map(|&k| offset(k).amax()).fold(0.0, f64::max);
    if !(size > 0.0 && size.is_finite()) {
        return Vector::zeros();
    }
    let sum = corners
        .windows(2)
        .fold(Vector::zeros(), |sum, pair| sum + (offset(pair[0]) / size).cross(&(offset(pair[1]) / size)));
    sum.try_normalize(0.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f64; 2]]) -> (usize, f64, f64) {
        let points: Vec<Point> = points.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect();
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut out = Vec::new();
        face(&points, &corners, &mut out);
        let areas = out.chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|k| points[k as usize]);
            0.5 * (b - a).cross(&(c - a)).z
        });
        (out.len() / 3, areas.clone().sum(), areas.fold(f64::MAX, f64::min))
    }

    #[test]
    fn concave_faces_are_covered_once() {
        // An L, a dart, a comb: exact areas, no triangle turned over.
        assert_eq!(cut(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]).1, 3.0);
        let (n, area, least) = cut(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]);
        assert!(n == 2 && (area - 0.5).abs() < 1e-15 && least > 0.0);
        let mut comb = vec![[9.0, 2.0], [0.0, 2.0]];
        for i in 0..9 {
            comb.push([f64::from(i), if i % 2 == 0 { 0.0 } else { 1.5 }]);
        }
        comb.push([9.0, 0.0]);
        let (n, area, least) = cut(&comb);
        let shoelace: f64 = (0..comb.len())
            .map(|i| {
                let (p, q) = (comb[i], comb[(i + 1) % comb.len()]);
                0.5 * (p[0] * q[1] - p[1] * q[0])
            })
            .sum();
        assert!(n == comb.len() - 2 && (area - shoelace).abs() < 1e-14 && least > 0.0);
    }

    #[test]
    fn faces_without_ears_end() {
        assert_eq!(cut(&[[0.0, 0.0]; 50]).0, 48);
        assert_eq!(cut(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.5, 2.0]]).0, 3);
    }
}
