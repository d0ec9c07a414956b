//! What the name of a colour says of it as light, to the bit, where its numbers of sRGB do not: `linear r g b a`.
//!
//! Between two neighbouring numbers of sRGB, light goes up by as much as twice the step from one number to the next, so that half of the colours near white
//! have no number of sRGB that reads back as they are; and of an opacity below a half, what is left to one is rounded.

use loftsman_kernel::text;

/// The word before the numbers.
const LINEAR: &str = "linear ";
/// Numbers that are further apart are not of one colour: somebody has changed the one or the other.
const SAME: f64 = 1e-9;

/// The name of a colour.
pub(crate) fn name(color: [f64; 4]) -> String {
    let numbers = color.map(|c| {
        let mut digits = Vec::new();
        // Writing to a list cannot fail, and digits are ASCII.
        let _ = text::number(&mut digits, c);
        String::from_utf8_lossy(&digits).into_owned()
    });
    format!("{LINEAR}{}", numbers.join(" "))
}

/// What a name says; nothing where it is of another's making.
pub(crate) fn parse(name: &str) -> Option<[f64; 4]> {
    let numbers = name.strip_prefix(LINEAR)?.split(' ').map(|n| n.parse().ok());
    numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()
}

/// A colour to the bit: what its name says where that is the colour, opacity by itself, as curves have none.
pub(crate) fn exact(color: [f64; 4], said: Option<[f64; 4]>) -> [f64; 4] {
    let Some(said) = said else { return color };
    let same = |k: usize| (color[k] - said[k]).abs() <= SAME;
    let [r, g, b] =
        if (0..3).all(same) { [said[0], said[1], said[2]] } else { [color[0], color[1], color[2]] };
    [r, g, b, if same(3) { said[3] } else { color[3] }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_colours_to_the_bit_and_only_those_that_numbers_say_too() {
        let color = [0.1 + 0.2, 1.0 / 3.0, 5e-324, 0.3];
        assert_eq!(parse(&name(color)), Some(color));
        for other in ["", "red", "linear", "linear 1 2 3", "linear 1 2 3 4 5", "linear a b c d"] {
            assert_eq!(parse(other), None, "{other}");
        }
        let near = color.map(|c| c + 1e-13);
        assert_eq!(exact(near, Some(color)), color);
        assert_eq!(exact(near, None), near);
        assert_eq!(exact([0.5; 4], Some(color)), [0.5; 4]);
        let opaque = [near[0], near[1], near[2], 1.0];
        assert_eq!(exact(opaque, Some(color)), [color[0], color[1], color[2], 1.0]);
        assert!(exact(near, Some([f64::NAN; 4])) == near);
    }
}
