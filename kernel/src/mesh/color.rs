//! Colour values as light (linear) and as files and screens have them (sRGB, IEC 61966-2-1).

/// Blue, white, vermilion in sRGB, 0 to 255: the ends are of Okabe and Ito (2008), "Color universal design", which colour-blind readers can
/// tell apart.
const DIVERGING: [[f64; 3]; 3] = [[0.0, 114.0, 178.0], [245.0, 245.0, 245.0], [213.0, 94.0, 0.0]];

/// The colour of a signed value at a share of a map, -1 (blue) over 0 (white) to 1 (vermilion), in sRGB from 0 to 255; beyond the ends theirs.
pub fn diverging(share: f64) -> [f64; 3] {
    let [below, middle, above] = DIVERGING;
    let end = if share < 0.0 { below } else { above };
    let by = share.abs().min(1.0);
    std::array::from_fn(|k| middle[k] + (end[k] - middle[k]) * by)
}

/// Where a map from minus to plus this ends that shows values well: the least number of two digits that no more than a fiftieth of them
/// is beyond, so that a few far out do not make all others white. 0 where all are, or none is finite. `O(n log n)`.
pub fn map_end(values: impl IntoIterator<Item = f64>) -> f64 {
    const WITHIN: f64 = 0.98;
    let mut sizes: Vec<f64> = values.into_iter().map(f64::abs).filter(|size| size.is_finite()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let most = ((sizes.len() as f64 * WITHIN).ceil() as usize).saturating_sub(1);
    sizes.get(most).copied().map_or(0.0, rounded_up)
}

/// A number not smaller that has two digits.
fn rounded_up(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    let up = (value / unit * (1.0 - 1e-12)).ceil() * unit;
    // Without the digits that multiplying leaves; and what is too small for digits, or too large, as it is.
    format!("{up:.1e}").parse().ok().filter(|up: &f64| up.is_normal()).unwrap_or(value)
}

/// Where such a map ends for values all of which count, such as distances: the least number of two digits that none is beyond. 0 where all are, or
/// none is finite. `O(n)`.
pub fn map_end_of_all(values: impl IntoIterator<Item = f64>) -> f64 {
    rounded_up(values.into_iter().map(f64::abs).filter(|size| size.is_finite()).fold(0.0, f64::max))
}

/// A linear value, 0 to 1, as sRGB; beyond that the same formula. Of the numbers within rounding it is one of few decimals, or a share of 255, of which
/// [`from_srgb`] makes the same value, if there is one: so a colour that was read is written as it was. Where no number makes the same value it is one
/// that is written again once it was read, `to_srgb(from_srgb(x)) = x`: what is handed on from file to file stays.
pub fn to_srgb(value: f64) -> f64 {
    // Each round is one writing and reading, and moves by rounding alone: of 300,000 values 4,603 needed one more, none two.
    const ROUNDS: usize = 8;
    let mut shown = shortest_srgb(value);
    for _ in 0..ROUNDS {
        let again = shortest_srgb(from_srgb(shown));
        if again == shown || again.is_nan() {
            break;
        }
        shown = again;
    }
    shown
}

/// The sRGB value by the formula, or the first of few digits beside it that makes the same linear one.
fn shortest_srgb(value: f64) -> f64 {
    let found = if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
    let near = |share: f64| (found * share).round() / share;
    [255.0, 1e3, 1e6, 1e9, 1e12, 1e15].map(near).into_iter().find(|x| from_srgb(*x) == value).unwrap_or(found)
}

/// An sRGB value, 0 to 1, as a linear one; beyond that the same formula.
pub fn from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What files say, bytes and decimals, comes back to the bit.
    #[test]
    fn colours_are_written_as_they_were_read() {
        let said = (0..=255).map(|byte| f64::from(byte) / 255.0);
        let said = said.chain((0..=1000).map(|k| f64::from(k) / 1000.0));
        let said = said.chain([0.48627, 0.041_234_5, 0.123_456_789, 1e-6, 1.5, 7.25, 0.999_999_999_999]);
        let mut count = 0;
        for shown in said {
            assert_eq!(to_srgb(from_srgb(shown)), shown);
            count += 1;
        }
        assert_eq!(count, 256 + 1001 + 7);
        // Any value is met to rounding.
        for k in 1..100_000 {
            let value = (f64::from(k) * 0.618_033_988_749_894_9).fract();
            assert!((from_srgb(to_srgb(value)) - value).abs() < 1e-15 && to_srgb(value) != 0.0);
            assert_eq!(to_srgb(from_srgb(to_srgb(value))), to_srgb(value), "{value}: a second writing");
        }
        assert!(to_srgb(f64::NAN).is_nan() && to_srgb(f64::INFINITY).is_infinite());
    }

    #[test]
    fn the_map_has_its_ends_and_its_middle() {
        assert_eq!([0.0, -0.0].map(diverging), [[245.0; 3]; 2]);
        assert_eq!([-1.0, -2.0, f64::NEG_INFINITY].map(diverging), [[0.0, 114.0, 178.0]; 3]);
        assert_eq!([1.0, 7.0].map(diverging), [[213.0, 94.0, 0.0]; 2]);
        assert_eq!(diverging(-0.5), [122.5, 179.5, 211.5]);
    }

    #[test]
    fn it_ends_at_two_digits_that_most_values_are_within() {
        for (value, up) in [(0.0123, 0.013), (0.013, 0.013), (9.99, 10.0), (1234.0, 1300.0), (4e-9, 4e-9)] {
            assert_eq!(map_end([value, -value, 0.0]), up, "{value}");
        }
        let many = (0..100).map(|k| if k < 2 { 1e9 } else { f64::from(k % 10) });
        assert_eq!(map_end(many.clone()), 9.0, "two of a hundred are far out");
        assert_eq!(map_end_of_all(many), 1e9);
        assert_eq!(map_end_of_all([0.0, -0.0123, f64::NAN]), 0.013);
        assert_eq!(map_end_of_all([]), 0.0);
        assert_eq!(map_end([f64::NAN, f64::INFINITY]), 0.0);
        assert_eq!(map_end([]), 0.0);
        for size in [5e-324, 1e-310, 1.7e308] {
            assert!(map_end([size]) >= size * 0.999 && map_end([size]).is_finite(), "{size:e}");
        }
    }
}
