//! Draws what the last runs of the benches left in `target/criterion`: nanoseconds an element over how many there are,
//! both on logarithmic axes, a panel a question; beside it, as rings, what programs in other languages took
//! (`peers/elsewhere.tsv`). `cargo run --profile bench --bin chart > chart.svg`.

use std::fmt::Write as _;

use loftsman_benches::measure::median;

/// A panel: its title, criterion's group, the cases' names with their numbers of elements, and whose lines.
struct Panel {
    title: &'static str,
    group: &'static str,
    cases: &'static [(&'static str, f64)],
    lines: &'static [(&'static str, &'static str)],
}

const OURS: &str = "#1f5fbf";
const SINGLE: &str = "#7fa8e0";
const FLOOR: &str = "#8a8a8a";
const CURVO: &str = "#c65911";
const TRUCK: &str = "#7a3b9e";
const ELSEWHERE: &str = "#2f7d4f";

const W1: &[(&str, f64)] = &[("10000", 1e4), ("100000", 1e5), ("1000000", 1e6)];
const W2: &[(&str, f64)] = &[("100", 1e4), ("300", 9e4), ("1000", 1e6)];
const LINES: &[(&str, &str)] = &[
    ("floor", FLOOR),
    ("loftsman", OURS),
    ("loftsman, one by one", SINGLE),
    ("curvo", CURVO),
    ("truck", TRUCK),
];

const PANELS: [Panel; 3] = [
    Panel { title: "Points on a cubic", group: "W1 points", cases: W1, lines: LINES },
    Panel { title: "… with two derivatives", group: "W1 derivatives", cases: W1, lines: LINES },
    Panel { title: "Surface grid with normals", group: "W2 grid", cases: W2, lines: LINES },
];

const WIDTH: f64 = 300.0;
/// Room for the labels to the right of a panel.
const LABELS: f64 = 150.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 52.0;
const TOP: f64 = 40.0;
/// Decades of nanoseconds an element, and of elements.
const TIMES: [f64; 2] = [0.0, 5.0];
const COUNTS: [f64; 2] = [3.8, 6.2];

fn main() {
    let mut svg = String::new();
    let (width, height) = (PANELS.len() as f64 * (WIDTH + LABELS) + 20.0, HEIGHT + TOP + 50.0);
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>"
    );
    for (i, panel) in PANELS.iter().enumerate() {
        draw(&mut svg, panel, 10.0 + i as f64 * (WIDTH + LABELS));
    }
    svg.push_str("</svg>\n");
    print!("{svg}");
}

fn draw(svg: &mut String, panel: &Panel, x0: f64) {
    let (left, right, bottom) = (x0 + LEFT, x0 + WIDTH, TOP + HEIGHT);
    let x = |count: f64| left + (count.log10() - COUNTS[0]) / (COUNTS[1] - COUNTS[0]) * (right - left);
    let y = |time: f64| bottom - (time.log10() - TIMES[0]) / (TIMES[1] - TIMES[0]) * HEIGHT;
    let mut say = |line: String| {
        let _ = writeln!(svg, "{line}");
    };
    say(format!(
        "<text x=\"{left}\" y=\"{}\" font-size=\"14\" font-weight=\"bold\">{}</text>",
        TOP - 14.0,
        panel.title
    ));
    for decade in 0..=TIMES[1] as i32 {
        let at = y(10_f64.powi(decade));
        let label = ["1 ns", "10 ns", "100 ns", "1 µs", "10 µs", "100 µs"][decade as usize];
        say(format!("<path d=\"M{left} {at:.1}H{right}\" stroke=\"#dddddd\"/>"));
        say(format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>", left - 5.0, at + 4.0));
    }
    for (decade, label) in [(4, "10⁴"), (5, "10⁵"), (6, "10⁶")] {
        let at = x(10_f64.powi(decade));
        say(format!("<path d=\"M{at:.1} {TOP}V{bottom}\" stroke=\"#eeeeee\"/>"));
        say(format!("<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>", bottom + 16.0));
    }
    say(format!(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">points asked for</text>",
        0.5 * (left + right),
        bottom + 34.0
    ));
    // Each label stands to the right, at the height of its line's last point or as near above as there is room.
    let mut labels: Vec<(f64, &str, &str)> = Vec::new();
    for (who, color) in panel.lines {
        let measured: Vec<(f64, f64)> = (panel.cases.iter())
            .filter_map(|(case, count)| Some((x(*count), y(median(panel.group, who, case)? / count))))
            .collect();
        let Some(&(end, last)) = measured.last() else { continue };
        let path: Vec<String> = measured.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        say(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            path.join(" ")
        ));
        for (x, y) in &measured {
            say(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>"));
        }
        if end < x(1e5) {
            say(format!(
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{who}</text>",
                end + 8.0,
                last + 4.0
            ));
        } else {
            labels.push((last, who, color));
        }
    }
    for (who, count, nanoseconds) in elsewhere(panel.group) {
        let (x, y) = (x(count), y(nanoseconds / count));
        say(format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"white\" stroke=\"{ELSEWHERE}\" stroke-width=\"1.5\"/>"
        ));
        labels.push((y, who, ELSEWHERE));
    }
    labels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut free = f64::INFINITY;
    for (at, who, color) in labels {
        free = at.min(free - 14.0);
        let [near, far] = [x(1e6) + 5.0, right + 10.0];
        say(format!("<path d=\"M{near:.1} {at:.1}L{far:.1} {free:.1}\" stroke=\"#cccccc\" fill=\"none\"/>"));
        say(format!("<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{who}</text>", far + 4.0, free + 4.0));
    }
}

/// Who else was measured with a question: name, elements, nanoseconds in all.
fn elsewhere(group: &str) -> Vec<(&'static str, f64, f64)> {
    include_str!("../../peers/elsewhere.tsv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| {
            let [of, who, count, seconds] = line.split('\t').collect::<Vec<_>>()[..] else { return None };
            Some((of, who, count.parse::<f64>().ok()?, seconds.parse::<f64>().ok()? * 1e9))
        })
        .filter(|&(of, ..)| of == group)
        .map(|(_, who, count, time)| (who, count, time))
        .collect()
}
