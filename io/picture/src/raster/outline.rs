//! Path data, circles and lines as paths of the renderer.

use tiny_skia::{Path, PathBuilder};

/// The path of the data of a `d` attribute; `None` where nothing is drawn.
///
/// Of the commands there are `M`, `L`, `C`, `m`, `h`, `v`, `q` and `Z`: those that the crate writes. Numbers have single spaces in
/// between.
pub(super) fn of_data(data: &str) -> Result<Option<Path>, String> {
    let mut path = PathBuilder::new();
    let (mut start, mut pen) = ([0.0_f64; 2], [0.0_f64; 2]);
    let mut rest = data;
    while let Some(command) = rest.chars().next() {
        let after = &rest[command.len_utf8()..];
        let end = after.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(after.len());
        let (list, next) = after.split_at(end);
        rest = next;
        let unknown = || format!("the path command {command}{list} is unknown");
        let numbers = list.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
        let to = match (command, numbers.map_err(|_| unknown())?.as_slice()) {
            ('M', &[x, y]) => [x, y],
            ('m', &[x, y]) => [pen[0] + x, pen[1] + y],
            ('L', &[x, y]) => [x, y],
            ('h', &[x]) => [pen[0] + x, pen[1]],
            ('v', &[y]) => [pen[0], pen[1] + y],
            ('C', &[a, b, c, d, x, y]) => {
                let [a, b, c, d, x32, y32] = [a, b, c, d, x, y].map(|v| v as f32);
                path.cubic_to(a, b, c, d, x32, y32);
                [x, y]
            }
            ('q', &[a, b, x, y]) => {
                let [a, b] = [pen[0] + a, pen[1] + b].map(|v| v as f32);
                let to = [pen[0] + x, pen[1] + y];
                path.quad_to(a, b, to[0] as f32, to[1] as f32);
                to
            }
            ('Z' | 'z', &[]) => {
                path.close();
                start
            }
            _ => return Err(unknown()),
        };
        let [x, y] = to.map(|v| v as f32);
        match command {
            'M' | 'm' => {
                path.move_to(x, y);
                start = to;
            }
            'L' | 'h' | 'v' => path.line_to(x, y),
            _ => {}
        }
        pen = to;
    }
    Ok(path.finish())
}

/// A segment.
pub(super) fn line(from: [f32; 2], to: [f32; 2]) -> Option<Path> {
    let mut path = PathBuilder::new();
    path.move_to(from[0], from[1]);
    path.line_to(to[0], to[1]);
    path.finish()
}

/// A circle as four cubic pieces, which touch it at their ends and middles: elsewhere they are outside by at most 2.8e-4 of the radius.
pub(super) fn circle([x, y]: [f32; 2], radius: f32) -> Option<Path> {
    if !(radius > 0.0 && radius.is_finite()) {
        return None;
    }
    // 4/3 tan(90°/4), the length of the handles of a quarter of a circle of radius 1.
    let handle = 4.0 / 3.0 * (std::f64::consts::PI / 8.0).tan();
    let at = |across: f64, down: f64| {
        let r = f64::from(radius);
        ((f64::from(x) + across * r) as f32, (f64::from(y) + down * r) as f32)
    };
    let mut path = PathBuilder::new();
    let mut from = (1.0, 0.0);
    let (x0, y0) = at(from.0, from.1);
    path.move_to(x0, y0);
    for to in [(0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)] {
        // The tangent at a place of the circle is the place a quarter further on.
        let (x1, y1) = at(from.0 - handle * from.1, from.1 + handle * from.0);
        let (x2, y2) = at(to.0 + handle * to.1, to.1 - handle * to.0);
        let (x3, y3) = at(to.0, to.1);
        path.cubic_to(x1, y1, x2, y2, x3, y3);
        from = to;
    }
    path.close();
    path.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_commands_go_on_from_the_pen() {
        let path = |data: &str| of_data(data).unwrap();
        assert_eq!(path("M1 2h1.5v-2h-1.5z"), path("M1 2L2.5 2L2.5 0L1 0Z"));
        assert_eq!(path("M1 2h3m0 -0.8v1.6"), path("M1 2L4 2M4 1.2L4 2.8"));
        assert_eq!(path("M1 2h1v1zv5"), path("M1 2L2 2L2 3ZL1 7"));
        assert_eq!(path(""), None);
        for bad in ["M1", "L", "A1 1 0 0 0 2 2", "M1 2 3 4", "M1 x", "é"] {
            assert!(of_data(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn circles_are_round() {
        let path = circle([5.0, 7.0], 2.0).unwrap();
        let mut last = tiny_skia::Point::zero();
        for segment in path.segments() {
            match segment {
                tiny_skia::PathSegment::MoveTo(p) => last = p,
                tiny_skia::PathSegment::CubicTo(a, b, p) => {
                    for i in 0..=16 {
                        let (t, s) = (i as f32 / 16.0, 1.0 - i as f32 / 16.0);
                        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
                        let sum = |of: fn(&tiny_skia::Point) -> f32| -> f32 {
                            [last, a, b, p].iter().zip(weights).map(|(q, w)| of(q) * w).sum()
                        };
                        let radius = (sum(|q| q.x) - 5.0).hypot(sum(|q| q.y) - 7.0);
                        assert!((radius - 2.0).abs() < 6e-4, "{radius}");
                    }
                    last = p;
                }
                _ => {}
            }
        }
        assert!(circle([0.0, 0.0], 0.0).is_none() && circle([0.0, 0.0], f32::NAN).is_none());
    }
}
