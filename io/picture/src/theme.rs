//! Colours: a palette that colour-blind readers can tell apart, on light or dark paper.

/// The colours of a picture.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// Dark lines on white paper, for print. The default.
    #[default]
    Light,
    /// Light lines on dark paper, for screens.
    Dark,
}

/// Red, green and blue, each 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Color(pub(crate) [u8; 3]);

impl Color {
    /// `#rrggbb`.
    pub(crate) fn hex(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// This colour with `share` of another in it: 0 leaves it, 1 gives the other.
    pub(crate) fn mixed(self, other: Self, share: f64) -> Self {
        let mix = |i: usize| {
            let (a, b) = (f64::from(self.0[i]), f64::from(other.0[i]));
            (a + (b - a) * share).round().clamp(0.0, 255.0) as u8
        };
        Self([mix(0), mix(1), mix(2)])
    }

    /// Lightness as the eye weighs the three (Rec. 709), 0 to 1.
    fn lightness(self) -> f64 {
        let [r, g, b] = self.0.map(f64::from);
        (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0
    }
}

/// Okabe and Ito (2008), "Color universal design", without the yellow (too light for thin lines on paper).
const PALETTE: [Color; 6] = [
    Color([0x00, 0x72, 0xb2]),
    Color([0x00, 0x9e, 0x73]),
    Color([0xcc, 0x79, 0xa7]),
    Color([0xe6, 0x9f, 0x00]),
    Color([0x56, 0xb4, 0xe9]),
    Color([0x8c, 0x6d, 0x46]),
];

impl Theme {
    /// The background.
    pub(crate) fn paper(self) -> Color {
        match self {
            Self::Light => Color([255, 255, 255]),
            Self::Dark => Color([24, 26, 31]),
        }
    }

    /// Text and kept marks.
    pub(crate) fn ink(self) -> Color {
        match self {
            Self::Light => Color([34, 34, 34]),
            Self::Dark => Color([230, 230, 230]),
        }
    }

    /// Frames, scale bars, control polygons.
    pub(crate) fn faint(self) -> Color {
        self.ink().mixed(self.paper(), 0.45)
    }

    /// What was moved or asked for: Okabe and Ito's vermilion, which no object gets.
    pub(crate) fn accent(self) -> Color {
        Color([0xd5, 0x5e, 0x00])
    }

    /// The colour of the `index`-th object, or its own where it has one. A colour that could not be seen on the
    /// paper is mixed with ink until it can.
    pub(crate) fn object(self, index: usize, own: Option<[f64; 4]>) -> Color {
        let Some(own) = own else {
            let color = PALETTE[index % PALETTE.len()];
            // The next six are darker, six more lighter, before colours come again; on a dark screen the other way round, where faces are dark and
            // what is darker is not seen on them.
            let darker = |share: f64| color.mixed(Color([0; 3]), share);
            let lighter = |share: f64| color.mixed(Color([255; 3]), share);
            let color = match (index / PALETTE.len() % 3, self) {
                (0, _) => color,
                (1, Self::Light) => darker(0.4),
                (1, Self::Dark) => lighter(0.6),
                (_, Self::Light) => lighter(0.5),
                (_, Self::Dark) => darker(0.35),
            };
            // The palette is made for print; on a dark screen it needs more light.
            return if self == Self::Dark { color.mixed(self.ink(), 0.2) } else { color };
        };
        let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let mut color = Color([byte(own[0]), byte(own[1]), byte(own[2])]);
        for _ in 0..8 {
            if (color.lightness() - self.paper().lightness()).abs() >= 0.25 {
                break;
            }
            color = color.mixed(self.ink(), 0.25);
        }
        color
    }

    /// The colour of an object's state before the step: the same, much lighter; on dark paper greyer.
    pub(crate) fn old(self, color: Color) -> Color {
        match self {
            Self::Light => color.mixed(Color([128, 128, 128]), 0.6).mixed(self.paper(), 0.45),
            // Nearly grey, so that it is told from frames, and lighter than faces.
            Self::Dark => color.mixed(Color([150, 150, 150]), 0.75).mixed(self.paper(), 0.1),
        }
    }

    /// An earlier frame of what has a colour: of a `share` from 0 (the first) to 1 (the last), the fainter (nearer to the paper) the earlier,
    /// on dark paper as on light. The first can still be seen, the last has nearly the colour itself, so that those between are told apart.
    pub(crate) fn frame(self, color: Color, share: f64) -> Color {
        let (first, last) = if self == Self::Light { (0.77, 0.2) } else { (0.64, 0.02) };
        color.mixed(self.paper(), first + (last - first) * share.clamp(0.0, 1.0))
    }

    /// A face of a colour, lit with `light` from 0 (edge on) to 1 (facing the light).
    pub(crate) fn lit(self, color: Color, light: f64) -> Color {
        let light = light.clamp(0.0, 1.0);
        // Towards the paper, which is light or dark.
        let share = if self == Self::Light { 0.45 + 0.45 * light } else { 0.82 - 0.45 * light };
        color.mixed(self.paper(), share)
    }

    /// A face that has colours of its own, which stay what they are where it faces the light.
    pub(crate) fn painted(self, color: Color, light: f64) -> Color {
        color.mixed(Color([0; 3]), 0.35 * (1.0 - light.clamp(0.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_objects_can_be_seen_on_white_paper() {
        let color = Theme::Light.object(0, Some([1.0; 4]));
        assert!(color.lightness() < 0.75, "{}", color.hex());
        assert_eq!(Theme::Light.object(0, Some([0.0, 0.0, 1.0, 1.0])).hex(), "#0000ff");
        assert_eq!(Theme::Light.object(0, Some([f64::NAN; 4])), Theme::Light.object(0, Some([0.0; 4])));
    }

    /// Of eighteen objects no two have one colour, and all are seen; frames stand off the paper, and from one another.
    #[test]
    fn many_objects_and_frames_are_told_apart_on_any_paper() {
        let apart = |a: Color, b: Color| (0..3).map(|k| a.0[k].abs_diff(b.0[k])).max().unwrap_or(0);
        for theme in [Theme::Light, Theme::Dark] {
            let colors: Vec<Color> = (0..18).map(|k| theme.object(k, None)).collect();
            for (k, a) in colors.iter().enumerate() {
                assert!(colors[..k].iter().all(|b| apart(*a, *b) >= 20), "{theme:?} {k}");
                assert!(apart(*a, theme.paper()) >= 60, "{theme:?} {k} {}", a.hex());
            }
            for color in &colors[..6] {
                let frames: Vec<Color> = (0..6).map(|k| theme.frame(*color, f64::from(k) / 5.0)).collect();
                assert!(apart(frames[0], theme.paper()) >= 30, "{theme:?} {}", frames[0].hex());
                assert!(frames.windows(2).all(|w| apart(w[0], w[1]) >= 15), "{theme:?}");
                let old = theme.old(*color);
                let faces = [0.0, 0.5, 1.0].map(|light| theme.lit(*color, light));
                assert!(faces.iter().all(|face| apart(old, *face) >= 20), "{theme:?} {}", old.hex());
                assert!(frames.iter().all(|frame| apart(old, *frame) >= 12), "{theme:?} {}", old.hex());
                let off = |frame: &Color| (frame.lightness() - theme.paper().lightness()).abs();
                assert!(
                    frames.windows(2).all(|w| off(&w[0]) < off(&w[1])),
                    "{theme:?}: the fainter the earlier"
                );
            }
        }
    }
}
