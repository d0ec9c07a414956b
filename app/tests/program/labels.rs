//! Labels of pictures stand on no line, and nothing is clipped.

/// A box: its lower corner and its upper.
type Rect = [[f64; 2]; 2];

/// What is wrong with the labels of a picture: each that meets a line that is drawn, or leaves the page.
pub(crate) fn faults(svg: &str) -> Vec<String> {
    let drawing = svg.split("<g id=\"legend\"").next().unwrap();
    let page: Vec<f64> = value(svg, "viewBox").unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let mut lines: Vec<[[f64; 2]; 2]> = Vec::new();
    let (mut labels, mut wrong): (Vec<(Rect, String)>, Vec<String>) = (Vec::new(), Vec::new());
    for element in drawing.split('<').skip(1) {
        let class = value(element, "class").unwrap_or_default();
        if element.starts_with("path ") {
            lines.extend(segments(&value(element, "d").unwrap()));
        } else if element.starts_with("line ") && class != "leader" {
            let number = |name| value(element, name).unwrap().parse::<f64>().unwrap();
            lines.push([[number("x1"), number("y1")], [number("x2"), number("y2")]]);
        } else if element.starts_with("text ") && class == "label" {
            let number = |name| value(element, name).unwrap().parse::<f64>().unwrap();
            let words = element.split_once('>').unwrap().1.to_owned();
            // No letter is narrower on average, so that nothing is found that is not there.
            let (wide, size) =
                (0.5 * words.chars().count() as f64 * number("font-size"), number("font-size"));
            let left = match value(element, "text-anchor").as_deref() {
                Some("end") => number("x") - wide,
                Some("middle") => number("x") - wide / 2.0,
                _ => number("x"),
            };
            labels.push(([[left, number("y") - 0.7 * size], [left + wide, number("y")]], words));
        }
    }
    for (rect, words) in &labels {
        if rect[0][0] < 0.0 || rect[0][1] < 0.0 || rect[1][0] > page[2] || rect[1][1] > page[3] {
            wrong.push(format!("\"{words}\" leaves the page: {rect:?}"));
        }
        if let Some(line) = lines.iter().find(|line| meets(**line, rect)) {
            wrong.push(format!("\"{words}\" at {rect:?} meets the line {line:?}"));
        }
    }
    wrong
}

/// An attribute of an element.
fn value(element: &str, name: &str) -> Option<String> {
    let from = element.find(&format!(" {name}=\""))? + name.len() + 3;
    element[from..].split('"').next().map(str::to_owned)
}

/// Whether a segment meets a box.
fn meets([from, to]: [[f64; 2]; 2], [low, high]: &Rect) -> bool {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for i in 0..2 {
        let d = to[i] - from[i];
        if d == 0.0 && (from[i] < low[i] || from[i] > high[i]) {
            return false;
        }
        if d != 0.0 {
            let (a, b) = ((low[i] - from[i]) / d, (high[i] - from[i]) / d);
            (start, end) = (start.max(a.min(b)), end.min(a.max(b)));
        }
    }
    start <= end
}

/// The segments of a path; of a curve, sixteen.
fn segments(data: &str) -> Vec<[[f64; 2]; 2]> {
    let mut found = Vec::new();
    let (mut pen, mut start) = ([0.0; 2], [0.0; 2]);
    let mut rest = data;
    while let Some(command) = rest.chars().next() {
        let end = rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |at| at + 1);
        let spaced = rest[1..end].replace('-', " -");
        let numbers: Vec<f64> =
            spaced.split([' ', ',']).filter(|n| !n.is_empty()).map(|n| n.parse().unwrap()).collect();
        rest = &rest[end..];
        let base = if command.is_ascii_lowercase() { pen } else { [0.0; 2] };
        let mut draw = |to: [f64; 2], pen: &mut [f64; 2]| {
            found.push([*pen, to]);
            *pen = to;
        };
        match command {
            'M' | 'm' | 'L' | 'l' => {
                let mut at = base;
                for (k, pair) in numbers.chunks(2).enumerate() {
                    at = if command.is_ascii_lowercase() {
                        [at[0] + pair[0], at[1] + pair[1]]
                    } else {
                        [pair[0], pair[1]]
                    };
                    if k == 0 && command.eq_ignore_ascii_case(&'m') {
                        (pen, start) = (at, at);
                    } else {
                        draw(at, &mut pen);
                    }
                }
            }
            'H' | 'h' => numbers.iter().for_each(|x| draw([base[0] + x, pen[1]], &mut pen)),
            'V' | 'v' => numbers.iter().for_each(|y| draw([pen[0], base[1] + y], &mut pen)),
            'C' => {
                for six in numbers.chunks(6) {
                    let from = pen;
                    for k in 1..=16 {
                        let (t, s) = (f64::from(k) / 16.0, 1.0 - f64::from(k) / 16.0);
                        let at = |i: usize| {
                            s * s * s * from[i]
                                + 3.0 * s * s * t * six[i]
                                + 3.0 * s * t * t * six[2 + i]
                                + t * t * t * six[4 + i]
                        };
                        draw([at(0), at(1)], &mut pen);
                    }
                }
            }
            'Z' | 'z' => draw(start, &mut pen),
            other => panic!("{other} in {data}"),
        }
    }
    found
}

#[test]
fn a_label_on_a_line_is_found() {
    let picture = |x: f64| {
        format!(
            "<svg viewBox=\"0 0 100 50\"><path d=\"M0 20C10 20 20 20 30 20\"/>\
             <text class=\"label\" x=\"{x}\" y=\"21\" font-size=\"3\" text-anchor=\"start\">here</text></svg>"
        )
    };
    assert_eq!(
        [faults(&picture(10.0)).len(), faults(&picture(40.0)).len(), faults(&picture(98.0)).len()],
        [1, 0, 1]
    );
}

/// What `at` takes is read from a picture of every example's shapes: at least the ends and the middle of each direction, or as many as
/// there are places of their own; and no number stands on a line.
#[test]
fn parameters_are_read_from_the_pictures_of_all_examples() {
    let examples = loftsman_tests::repository().join("examples");
    let bench = crate::LOFTSMAN.bench();
    let mut drawn = 0;
    let mut files: Vec<_> = std::fs::read_dir(examples)
        .unwrap()
        .flat_map(|folder| std::fs::read_dir(folder.unwrap().path()).into_iter().flatten())
        .map(|file| file.unwrap().path())
        .filter(|path| path.to_string_lossy().ends_with(".loft.json"))
        .collect();
    files.sort();
    for path in files {
        let scene = loftsman::read_scene(&path).unwrap();
        let name = path.to_string_lossy();
        for object in scene.objects() {
            let least = match object.geometry() {
                loftsman::kernel::scene::Geometry::Curve(_) => 3,
                loftsman::kernel::scene::Geometry::Surface(_) => 6,
                _ => continue,
            };
            bench.done(&["plot", &name, "p.svg", "--parameters", "--object", object.name()]);
            let svg = String::from_utf8(bench.read("p.svg")).unwrap();
            let found = faults(&svg);
            assert!(found.is_empty(), "{name}, {}: {found:#?}", object.name());
            let places: usize = svg
                .split("<path class=\"parameters\" d=\"")
                .skip(1)
                .map(|data| data.split('"').next().unwrap().matches('M').count())
                .sum();
            let labels = svg.matches("class=\"label\"").count();
            // Places that are one share a label, and a closed shape has one fewer.
            let words = svg.split("class=\"label\"").skip(1).map(|label| label.split_once('>').unwrap().1);
            let named: usize = words
                .map(|words| words.split("</").next().unwrap())
                .map(|words| words.split([' ', ',']).filter(|word| word.parse::<f64>().is_ok()).count())
                .sum();
            assert!(named >= least.min(places), "{name}, {}: {named} of {places}, {labels}", object.name());
            drawn += 1;
        }
    }
    assert!(drawn >= 20, "{drawn}");
}
