//! Moments of a scene: the panels of a film strip.

use loftsman_kernel::scene::Scene;

use crate::choices::Frames;
use crate::error::PictureError;
use crate::panel::{Panel, Shown};

/// The panels with each drawing once for each frame of a film; as they are where there is none.
pub(crate) fn strip(panels: Vec<Panel>, frames: Frames, scene: &Scene) -> Result<Vec<Panel>, PictureError> {
    let Frames::Film(count) = frames else { return Ok(panels) };
    let moments = scene.moments()?;
    if moments.is_empty() {
        return Err(PictureError::Still);
    }
    let shown = chosen(moments.len(), count);
    let mut strip = Vec::new();
    for panel in panels {
        if !matches!(panel.shown, Shown::Drawing(_)) || panel.moment.is_some() {
            strip.push(panel);
            continue;
        }
        for &frame in &shown {
            let time = format!("{} s", seconds(moments[frame]));
            let caption = match &panel.caption {
                Some(own) => format!("{own}, {time}"),
                None => time,
            };
            strip.push(panel.clone().at(moments[frame]).caption(caption));
        }
    }
    Ok(strip)
}

/// So many of the frames, evenly spread from the first to the last; of one, the last.
pub(crate) fn chosen(frames: usize, count: usize) -> Vec<usize> {
    let count = count.min(frames);
    match count {
        0 => Vec::new(),
        1 => vec![frames - 1],
        _ => (0..count).map(|i| (i * (frames - 1) + (count - 1) / 2) / (count - 1)).collect(),
    }
}

/// A time in three figures.
fn seconds(time: f64) -> String {
    let decimals = if time < 1e-9 { 0 } else { (2 - time.log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{time:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_from_the_first_to_the_last() {
        assert_eq!(chosen(49, 5), [0, 12, 24, 36, 48]);
        assert_eq!(chosen(10, 4), [0, 3, 6, 9]);
        assert_eq!(chosen(3, 100), [0, 1, 2]);
        assert_eq!((chosen(7, 1), chosen(1, 3)), (vec![6], vec![0]));
        for frames in 1..60 {
            for count in 2..20 {
                let found = chosen(frames, count);
                assert!(found.is_sorted_by(|a, b| a < b), "{found:?}");
                assert_eq!((found.first(), found.last()), (Some(&0), Some(&(frames - 1))));
            }
        }
    }

    #[test]
    fn times_are_short() {
        let all = [0.0, 0.5, 1.0 / 24.0, 2.0, 12.345, 1234.56].map(seconds);
        assert_eq!(all, ["0", "0.5", "0.0417", "2", "12.3", "1235"]);
    }
}
