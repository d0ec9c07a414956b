//! Where the stage goes on the page.

use loftsman_kernel::Vector;

use crate::path::Spot;

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
    /// The part of the page that the drawing may fill.
    pub(crate) area: Rect,
}

impl Layout {
    /// Fits `content` (in stage coordinates) into the page's width between margins, below `top`, no higher than
    /// `highest`; as large as it goes, in the middle.
    pub(crate) fn fit(content: &Rect, width: f64, margin: f64, top: f64, highest: f64) -> Self {
        let [w, h] = content.size();
        let room = width - 2.0 * margin;
        // A single point or an empty scene has no size to fit: it goes to the middle of a small area.
        let scale = (room / w).min(highest / h);
        let scale = if scale.is_finite() { scale } else { room / 4.0 };
        let lowest = (0.2 * room).min(highest);
        let height = (h * scale).max(lowest);
        let middle = if w.max(h) >= 0.0 && content.low[0].is_finite() {
            [(content.low[0] + content.high[0]) / 2.0, (content.low[1] + content.high[1]) / 2.0]
        } else {
            [0.0, 0.0]
        };
        let area = Rect { low: [margin, top], high: [width - margin, top + height] };
        let centre = [width / 2.0, top + height / 2.0];
        let origin = [centre[0] - scale * middle[0], centre[1] + scale * middle[1]];
        Self { scale, origin, area }
    }

    /// A point of the stage on the page.
    pub(crate) fn spot(&self, p: &Vector) -> Spot {
        [self.origin[0] + self.scale * p.x, self.origin[1] - self.scale * p.y]
    }

    /// A displacement of the stage on the page.
    pub(crate) fn shift(&self, v: &Vector) -> Spot {
        [self.scale * v.x, -self.scale * v.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_fills_the_width_or_the_height_and_stays_upright() {
        let wide = Rect { low: [-1.0, -0.1], high: [1.0, 0.1] };
        let layout = Layout::fit(&wide, 120.0, 10.0, 20.0, 80.0);
        assert_eq!(layout.scale, 50.0);
        assert_eq!(layout.spot(&Vector::new(-1.0, 0.0, 9.0)), [10.0, 30.0]);
        assert!(layout.spot(&Vector::new(0.0, 0.1, 0.0))[1] < 30.0);
        let high = Rect { low: [0.0, 0.0], high: [1.0, 8.0] };
        assert_eq!(Layout::fit(&high, 120.0, 10.0, 0.0, 80.0).scale, 10.0);
    }

    #[test]
    fn nothing_and_a_point_have_a_layout() {
        let mut point = Rect::NONE;
        assert!(Layout::fit(&point, 100.0, 5.0, 0.0, 50.0).scale.is_finite());
        point.take([0.25, 0.5]);
        let spot = Layout::fit(&point, 100.0, 5.0, 0.0, 50.0).spot(&Vector::new(0.25, 0.5, 0.0));
        assert_eq!(spot, [50.0, 9.0]);
    }
}
