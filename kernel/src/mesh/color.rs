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

/// A linear value, 0 to 1, as sRGB; beyond that the same formula.
pub fn to_srgb(value: f64) -> f64 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// An sRGB value, 0 to 1, as a linear one; beyond that the same formula.
pub fn from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(map_end(many), 9.0, "two of a hundred are far out");
        assert_eq!(map_end([f64::NAN, f64::INFINITY]), 0.0);
        assert_eq!(map_end([]), 0.0);
        for size in [5e-324, 1e-310, 1.7e308] {
            assert!(map_end([size]) >= size * 0.999 && map_end([size]).is_finite(), "{size:e}");
        }
    }
}
