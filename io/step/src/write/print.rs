//! Entities as text: numbered in the order in which they are written.

use loftsman_kernel::brep::Frame;
use loftsman_kernel::text;
use loftsman_kernel::{Point, Vector};

/// What has been written so far, and the next number.
#[derive(Debug, Default)]
pub(crate) struct Printer {
    pub(crate) out: Vec<u8>,
    /// The context of curves in parameter planes, where there is one yet.
    pub(crate) plane: Option<u64>,
    /// Whether the file's unit of length is the millimetre.
    pub(crate) millimetres: bool,
    last: u64,
}

impl Printer {
    /// Writes an entity; its number.
    pub(crate) fn put(&mut self, entity: &str) -> u64 {
        self.last += 1;
        self.out.extend_from_slice(format!("#{}={entity};\n", self.last).as_bytes());
        self.last
    }

    /// A number for an entity that is written later, before all that are from now on.
    pub(crate) fn reserve(&mut self) -> u64 {
        self.last += 1;
        self.last
    }

    /// Writes the entity of a number that was [reserved](Self::reserve).
    pub(crate) fn put_as(&mut self, number: u64, entity: &str) {
        self.out.extend_from_slice(format!("#{number}={entity};\n").as_bytes());
    }

    pub(crate) fn point(&mut self, p: &Point) -> u64 {
        self.put(&format!("CARTESIAN_POINT('',{})", list(p.iter().map(|&c| real(c)))))
    }

    pub(crate) fn points(&mut self, points: &[Point]) -> String {
        let numbers: Vec<u64> = points.iter().map(|p| self.point(p)).collect();
        references(&numbers)
    }

    pub(crate) fn direction(&mut self, v: &Vector) -> u64 {
        self.put(&format!("DIRECTION('',{})", list(v.iter().map(|&c| real(c)))))
    }

    pub(crate) fn frame(&mut self, frame: &Frame) -> u64 {
        let origin = self.point(&frame.origin);
        let (z, x) = (self.direction(&frame.z), self.direction(&frame.x));
        self.put(&format!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }
}

/// A number with a point, as the format wants it; it reads back as the same bits.
pub(crate) fn real(x: f64) -> String {
    let mut digits = Vec::new();
    // Writing to a list cannot fail, and digits are ASCII.
    let _ = text::number(&mut digits, x);
    let plain = String::from_utf8_lossy(&digits).to_ascii_uppercase();
    match plain.split_once('E') {
        Some((mantissa, exponent)) if mantissa.contains('.') => format!("{mantissa}E{exponent}"),
        Some((mantissa, exponent)) => format!("{mantissa}.E{exponent}"),
        None if plain.contains('.') => plain,
        None => plain + ".",
    }
}

/// A list of what is written already.
pub(crate) fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("({})", items.into_iter().collect::<Vec<_>>().join(","))
}

/// A list of entities.
pub(crate) fn references(numbers: &[u64]) -> String {
    list(numbers.iter().map(|number| format!("#{number}")))
}

/// A list of numbers.
pub(crate) fn reals(numbers: &[f64]) -> String {
    list(numbers.iter().map(|&number| real(number)))
}

/// `.T.` or `.F.`.
pub(crate) fn flag(is: bool) -> &'static str {
    if is { ".T." } else { ".F." }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_and_read_back() {
        for x in [0.0, -0.0, 1.0, -2.5, 1e-7, 1.5e-300, 1e21, f64::MAX, 5e-324, 1.0 / 3.0, 123_456_789.0] {
            let text = real(x);
            assert!(text.contains('.'), "{text}");
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
        }
    }
}
