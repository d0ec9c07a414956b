//! How light falls on faces.

use loftsman_kernel::Vector;

use crate::theme::{Color, Theme};

/// Levels of shading: few enough that an image of them is small, and more than the eye can tell.
const LEVELS: usize = 48;

/// A colour in all lights.
pub(super) fn tones(theme: Theme, base: Color) -> Vec<Color> {
    (0..=LEVELS).map(|level| theme.lit(base, level as f64 / LEVELS as f64)).collect()
}

/// The tone of a place with a normal (of any length): light comes from above the viewer's left shoulder, and both sides
/// are alike.
pub(super) fn tone(tones: &[Color], normal: &Vector) -> Color {
    tones[((light(normal) * LEVELS as f64).round() as usize).min(tones.len() - 1)]
}

/// From 0, edge on, to 1.
pub(super) fn light(normal: &Vector) -> f64 {
    let light = normal.dot(&Vector::new(-0.45, 0.55, 0.7)).abs() / normal.norm();
    if light.is_finite() { light.min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::face::newell;

    #[test]
    fn light_does_not_depend_on_the_side_or_the_size() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.3], [0.0, 1.0, 0.0]].map(Vector::from);
        let tones: Vec<Color> = (0..=LEVELS).map(|i| Color([i as u8; 3])).collect();
        let light = |corners: &[Vector]| tone(&tones, &newell(corners));
        let mut turned = corners;
        turned.reverse();
        assert_eq!(light(&corners), light(&turned));
        assert_eq!(light(&corners), light(&corners.map(|c| c * 1e-8)));
        assert_eq!(light(&[corners[0]; 3]), tones[0]);
    }
}
