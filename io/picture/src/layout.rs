//! Where the stage goes on the page.

use loftsman_kernel::Vector;

use crate::path::Spot;
use crate::view::Lens;

/// A rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) low: Spot,
    pub(crate) high: Spot,
}

impl Rect {
    /// A rectangle that holds nothing and grows with what it [`takes`](Self::take).
    pub(crate) const NONE: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    /// Grows to hold a point.
    pub(crate) fn take(&mut self, [x, y]: Spot) {
        self.low = [self.low[0].min(x), self.low[1].min(y)];
        self.high = [self.high[0].max(x), self.high[1].max(y)];
    }

    /// Width and height; 0 where it holds nothing.
    pub(crate) fn size(&self) -> [f64; 2] {
        [(self.high[0] - self.low[0]).max(0.0), (self.high[1] - self.low[1]).max(0.0)]
    }

    /// Whether two rectangles share more than a border.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    /// The rectangle with a border of `by` more on every side.
    pub(crate) fn grown(&self, by: f64) -> Self {
        Self { low: self.low.map(|c| c - by), high: self.high.map(|c| c + by) }
    }
}

/// From the stage to the page: `page = origin + scale · (x, -y)`, the same scale both ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    /// Millimetres of the page a unit of the stage.
    pub(crate) scale: f64,
    origin: Spot,
    lens: Lens,
    /// The part of the page that the drawing may fill.
    pub(crate) area: Rect,
}

impl Layout {
    /// The largest scale at which `content` (flat: through the lens) fits into a width and a height; `None` where it
    /// has no size.
    pub(crate) fn scale_of(content: &Rect, width: f64, highest: f64) -> Option<f64> {
        let [w, h] = content.size();
        Some((width / w).min(highest / h)).filter(|scale| scale.is_finite())
    }

    /// Puts the middle of `content` (flat: through the lens) into the middle of an area of the page.
    pub(crate) fn new(content: &Rect, scale: f64, lens: Lens, area: Rect) -> Self {
        let middle = |rect: &Rect| [0, 1].map(|i| (rect.low[i] + rect.high[i]) / 2.0);
        let inner = if content.low[0].is_finite() { middle(content) } else { [0.0, 0.0] };
        let outer = middle(&area);
        let origin = [outer[0] - scale * inner[0], outer[1] + scale * inner[1]];
        Self { scale, origin, lens, area }
    }

    /// A point of the stage on the page.
    pub(crate) fn spot(&self, p: &Vector) -> Spot {
        let p = self.lens.flat(p);
        [self.origin[0] + self.scale * p.x, self.origin[1] - self.scale * p.y]
    }

    /// A point of the stage on the page, and how near the viewer it is, in millimetres as across.
    pub(crate) fn place(&self, p: &Vector) -> Vector {
        let p = self.lens.flat(p);
        Vector::new(self.origin[0] + self.scale * p.x, self.origin[1] - self.scale * p.y, self.scale * p.z)
    }

    /// A displacement of the stage at one of its points, on the page.
    pub(crate) fn shift(&self, at: &Vector, v: &Vector) -> Spot {
        let v = self.lens.shift(at, v);
        [self.scale * v.x, -self.scale * v.y]
    }

    /// Whether the page shows lengths to one scale.
    pub(crate) fn is_parallel(&self) -> bool {
        self.lens.is_parallel()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_is_in_the_middle_and_upright() {
        let wide = Rect { low: [-1.0, -0.1], high: [1.0, 0.1] };
        let scale = Layout::scale_of(&wide, 100.0, 80.0).unwrap();
        assert_eq!(scale, 50.0);
        let area = Rect { low: [10.0, 20.0], high: [110.0, 40.0] };
        let layout = Layout::new(&wide, scale, Lens::PARALLEL, area);
        assert_eq!(layout.spot(&Vector::new(-1.0, 0.0, 9.0)), [10.0, 30.0]);
        assert!(layout.spot(&Vector::new(0.0, 0.1, 0.0))[1] < 30.0);
        let high = Rect { low: [0.0, 0.0], high: [1.0, 8.0] };
        assert_eq!(Layout::scale_of(&high, 120.0, 80.0), Some(10.0));
    }

    #[test]
    fn nothing_and_a_point_have_a_layout() {
        let mut point = Rect::NONE;
        let area = Rect { low: [0.0, 0.0], high: [100.0, 18.0] };
        assert_eq!(Layout::scale_of(&point, 100.0, 50.0), None);
        assert_eq!(Layout::new(&point, 9.0, Lens::PARALLEL, area).spot(&Vector::zeros()), [50.0, 9.0]);
        point.take([0.25, 0.5]);
        assert_eq!(Layout::scale_of(&point, 100.0, 50.0), None);
        let spot = Layout::new(&point, 9.0, Lens::PARALLEL, area).spot(&Vector::new(0.25, 0.5, 0.0));
        assert_eq!(spot, [50.0, 9.0]);
    }
}
