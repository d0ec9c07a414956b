//! Curves as SVG paths: exact where a cubic Bézier segment is, within a twentieth of a pixel elsewhere.

use loftsman_kernel::Vector;

use crate::labels::Ink;
use crate::layout::Layout;
use crate::path::{Path, Spot};
use crate::stage::piece::{Jet, Piece};

/// The largest error of an approximated piece: a twentieth of a pixel (1/96 inch), in millimetres.
const TOLERANCE: f64 = 25.4 / 96.0 / 20.0;

/// A piece within this of its chord is drawn as a segment, in millimetres.
const STRAIGHT: f64 = 0.003;

/// The path data of pieces, those joined that follow one another.
pub(crate) fn trace<'p>(
    pieces: impl IntoIterator<Item = &'p Piece>,
    closed: bool,
    layout: &Layout,
    ink: &mut Ink,
) -> String {
    let mut path = Path::default();
    for piece in pieces {
        let spots: Vec<Spot> = (0..=piece.degree()).map(|i| layout.spot(&piece.vertex(i))).collect();
        let (Some(&start), Some(&end)) = (spots.first(), spots.last()) else { continue };
        if path.pen() != Some(start) {
            path.move_to(start);
        }
        let length: f64 = spots.windows(2).map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1])).sum();
        let steps = (length / 0.8).ceil().clamp(1.0, 512.0) as usize;
        let mut from = start;
        for i in 1..=steps {
            let to = layout.spot(&piece.point(i as f64 / steps as f64));
            ink.segment(from, to, 6);
            from = to;
        }
        // The curve is within the hull of its vertices (weights are positive), so their distance bounds its own.
        if spots.iter().all(|spot| distance(*spot, start, end) <= STRAIGHT) {
            path.line_to(end);
            continue;
        }
        // Through a central projection a polynomial piece is rational.
        match (piece.rational || !layout.is_parallel(), &spots[..]) {
            (false, [a, b, c]) => path.cubic_to(toward(*a, *b), toward(*c, *b), *c),
            (false, [_, b, c, d]) => path.cubic_to(*b, *c, *d),
            _ => approximate(piece, layout, &mut path),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// Points along pieces, closer than half a millimetre on the page or about that: what faces hide of them can be caption. A
/// chain for each part of a torn curve.
pub(crate) fn flattened(pieces: &[Piece], layout: &Layout) -> Vec<Vec<Vector>> {
    let parts = pieces.chunk_by(Piece::meets);
    parts.map(|part| chain(part, layout)).collect()
}

fn chain(pieces: &[Piece], layout: &Layout) -> Vec<Vector> {
    let mut chain: Vec<Vector> = pieces.first().map(|piece| piece.point(0.0)).into_iter().collect();
    for piece in pieces {
        let spots: Vec<Spot> = (0..=piece.degree()).map(|i| layout.spot(&piece.vertex(i))).collect();
        let length: f64 = spots.windows(2).map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1])).sum();
        let steps = (length / 0.4).ceil().clamp(2.0, 512.0) as usize;
        chain.extend((1..=steps).map(|i| piece.point(i as f64 / steps as f64)));
    }
    chain
}

/// Two thirds of the way: the cubic control point of a quadratic Bézier segment.
fn toward(end: Spot, middle: Spot) -> Spot {
    [0, 1].map(|i| end[i] + (middle[i] - end[i]) * (2.0 / 3.0))
}

/// The distance of a point from a segment.
fn distance(p: Spot, a: Spot, b: Spot) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let v = [p[0] - a[0], p[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let t = if square > 0.0 { ((v[0] * d[0] + v[1] * d[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (v[0] - t * d[0]).hypot(v[1] - t * d[1])
}

/// Cubic Hermite segments, halved until three points between their ends are within the tolerance. Twelve
/// halvings make pieces of a 4096th; the error falls with the fourth power, so that is far more than is needed.
fn approximate(piece: &Piece, layout: &Layout, path: &mut Path) {
    let mut todo = vec![(0.0, 1.0, 12_u32)];
    while let Some((a, b, left)) = todo.pop() {
        let h = b - a;
        let (start, end) = (piece.jet(a), piece.jet(b));
        let arm = |jet: &Jet, by: f64| {
            let (spot, shift) = (layout.spot(&jet.point), layout.shift(&jet.point, &jet.first));
            [0, 1].map(|i| spot[i] + shift[i] * by)
        };
        let spots = [arm(&start, 0.0), arm(&start, h / 3.0), arm(&end, -h / 3.0), arm(&end, 0.0)];
        let off = |t: f64| {
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let [x, y] = [0, 1].map(|i| spots.iter().zip(weights).map(|(p, w)| p[i] * w).sum::<f64>());
            let exact = layout.spot(&piece.point(a + h * t));
            (x - exact[0]).hypot(y - exact[1])
        };
        // NaN (a curve that overflows) compares false and ends the halving.
        if left > 0 && [0.25, 0.5, 0.75].into_iter().any(|t| off(t) > 0.5 * TOLERANCE) {
            let middle = 0.5 * (a + b);
            todo.push((middle, b, left - 1));
            todo.push((a, middle, left - 1));
        } else {
            path.cubic_to(spots[1], spots[2], spots[3]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Rect;
    use crate::view::Lens;
    use nalgebra::Vector4;

    fn layout() -> Layout {
        let content = Rect { low: [0.0, 0.0], high: [1.0, 1.0] };
        Layout::new(&content, 100.0, Lens::PARALLEL, Rect { low: [10.0; 2], high: [110.0; 2] })
    }

    fn trace_of(piece: Piece) -> String {
        let mut ink = Ink::new(Rect { low: [0.0; 2], high: [120.0; 2] });
        trace([&piece], false, &layout(), &mut ink)
    }

    #[test]
    fn a_parabola_is_one_exact_cubic() {
        let control = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)].map(|(x, y)| Vector4::new(x, y, 0.0, 1.0));
        let data = trace_of(Piece { control: control.to_vec(), rational: false });
        assert_eq!(data, "M10 110C43.333 43.333 76.667 43.333 110 110");
    }

    #[test]
    fn a_quarter_circle_is_within_a_twentieth_of_a_pixel() {
        let w = 0.5_f64.sqrt();
        let control = vec![
            Vector4::new(1.0, 0.0, 0.0, 1.0),
            Vector4::new(w, w, 0.0, w),
            Vector4::new(0.0, 1.0, 0.0, 1.0),
        ];
        let data = trace_of(Piece { control, rational: true });
        let numbers: Vec<f64> =
            data.split(['M', 'C', ' ']).filter(|part| !part.is_empty()).map(|n| n.parse().unwrap()).collect();
        let spots: Vec<Spot> = numbers.chunks(2).map(|xy| [xy[0], xy[1]]).collect();
        assert!((spots.len() - 1).is_multiple_of(3) && spots.len() > 4);
        for cubic in (0..spots.len() - 1).step_by(3) {
            for i in 0..=20 {
                let t = f64::from(i) / 20.0;
                let s = 1.0 - t;
                let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
                let [x, y]: [f64; 2] = [0, 1].map(|c| (0..4).map(|k| spots[cubic + k][c] * weights[k]).sum());
                let radius = (x - 10.0).hypot(110.0 - y);
                assert!((radius - 100.0).abs() < TOLERANCE, "{radius}");
            }
        }
    }
}
