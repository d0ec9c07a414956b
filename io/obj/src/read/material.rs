//! The colours of a material library: `newmtl`, `Kd`, `d`, `Tr`.

use std::collections::HashMap;

use crate::text::{Statements, decode, keyword, number, words};

/// Adds the colour of each material of a library. Whatever else a library says, or says wrongly, is passed over:
/// it does not change the geometry.
pub(crate) fn colors(bytes: &[u8], out: &mut HashMap<Vec<u8>, [f64; 4]>) {
    let text = decode(bytes);
    let mut current: Option<Vec<u8>> = None;
    for (_, statement) in Statements::new(&text) {
        let (word, rest) = keyword(&statement);
        if word == b"newmtl" {
            current = Some(rest.to_vec());
            continue;
        }
        let Some(name) = &current else { continue };
        let mut numbers = words(rest).map_while(|w| number(w).ok()).map(|n| n.clamp(0.0, 1.0));
        match word {
            b"Kd" => {
                if let (Some(r), Some(g), Some(b)) = (numbers.next(), numbers.next(), numbers.next()) {
                    let alpha = out.get(name).map_or(1.0, |c| c[3]);
                    out.insert(name.clone(), [r, g, b, alpha]);
                }
            }
            b"d" | b"Tr" => {
                if let Some(value) = numbers.next() {
                    let alpha = if word == b"d" { value } else { 1.0 - value };
                    out.entry(name.clone()).or_insert([0.8, 0.8, 0.8, 1.0])[3] = alpha;
                }
            }
            _ => {}
        }
    }
}
