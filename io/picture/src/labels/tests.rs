//! Where labels stand, and where they do not.

use super::drawn::{GAP, LEVEL_GAP};
use super::*;

fn label(anchor: Spot, words: &str) -> Label {
    Label { anchor, lines: vec![words.into()], color: Color([0; 3]), row: None }
}

#[test]
fn a_row_is_halved_again_and_again() {
    assert_eq!(ranks(11), [0, 3, 2, 3, 4, 1, 3, 2, 3, 4, 0]);
    assert_eq!((ranks(0), ranks(1), ranks(2), ranks(3)), (vec![], vec![0], vec![0; 2], vec![0, 1, 0]));
}

/// A row along a line, as close as is said.
fn row(count: usize, gap: f64) -> Vec<Label> {
    let ranks = ranks(count);
    (0..count)
        .map(|k| Label {
            row: Some(Row { rank: ranks[k], object: "c".into() }),
            ..label([10.0 + gap * k as f64, 30.0], &format!("0.{k:02}"))
        })
        .collect()
}

/// Of a crowded row of numbers those stay that have room near their spots, its ends and its middle first, and the others are counted;
/// one with room around is whole, at a line as well.
#[test]
fn of_a_crowded_row_the_ends_and_the_middle_stay() {
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    ink.segment([0.0, 30.0], [100.0, 30.0], 6);
    let found = place(&row(201, 0.2), &ink, (Theme::Light, false), &mut Vec::new());
    let boxes: Vec<Rect> = found.drawn.split("<text").skip(1).map(around).collect();
    assert!((10..100).contains(&boxes.len()), "{}", found.drawn);
    assert_eq!(found.left, [("c".to_owned(), 201 - boxes.len())]);
    for (k, rect) in boxes.iter().enumerate() {
        assert!(boxes[..k].iter().all(|other| !other.overlaps(rect)), "{boxes:?}");
        let near = |anchor: f64| (rect.low[0].max(rect.high[0].min(anchor)) - anchor).abs();
        assert!((0..201).any(|k| near(10.0 + 0.2 * f64::from(k)) < NEAR), "{rect:?}");
    }
    for held in ["0.00", "0.100", "0.200"] {
        assert!(found.drawn.contains(&format!(">{held}<")), "{held}: {}", found.drawn);
    }
    let apart = place(&row(10, 9.0), &ink, (Theme::Light, false), &mut Vec::new());
    assert!(apart.drawn.matches("<text").count() == 10 && apart.left.is_empty(), "{apart:?}");
}

/// Spots below one another, closer than numbers are high, beside a wall: where a number has slipped along to its neighbour's spot a leader says whose it is.
#[test]
fn no_number_stands_at_the_spot_of_another_without_a_leader() {
    let mut ink = Ink::new(Rect { low: [0.0; 2], high: [100.0; 2] });
    for column in 0..50 {
        ink.segment([50.0 + f64::from(column), 0.0], [50.0 + f64::from(column), 100.0], 1);
    }
    let anchors: Vec<Spot> = (0..5).map(|k| [49.0, 40.0 + 2.6 * f64::from(k)]).collect();
    let page = Page { spots: anchors.clone(), ..Page::clean(&ink) };
    let row = |rank| Some(Row { rank, object: "a".into() });
    let one = Label { row: row(2), ..label(anchors[2], "v 0.4") };
    let [w, h] = one.size();
    let beside = |y: f64| Rect { low: [46.5 - w, y - h / 2.0], high: [46.5, y + h / 2.0] };
    assert!(page.is_told(&one, &beside(anchors[2][1]), 2.0));
    assert!(!page.is_told(&one, &beside(anchors[1][1] - 1.0), 3.0));
    // A box that is nearer to its own spot by a hair, with the other one below its middle.
    let below = Page { spots: vec![[49.0, 43.0], [51.0 + w / 2.0, 45.1 + h / 2.0]], ..page };
    let of = Label { anchor: [49.0, 43.0], ..one.clone() };
    let at = |y: f64| Rect { low: [51.0, y - h / 2.0], high: [51.0 + w, y + h / 2.0] };
    assert!(!below.is_told(&of, &at(43.0), 2.0) && below.is_told(&of, &at(40.5), 2.1));
    // One that is nearer to its own spot, seen from its box and its middle, and in a line with the other.
    let along = Page { spots: vec![[13.27, 27.63], [14.44, 23.69]], ..below };
    let of = Label { anchor: [13.27, 27.63], ..one.clone() };
    let at = |y: f64| Rect { low: [12.2 - w, y - h / 2.0], high: [12.2, y + h / 2.0] };
    assert!(!along.is_told(&of, &at(24.2), 2.0) && along.is_told(&of, &at(27.0), 2.0));
    let page = Page { spots: anchors.clone(), ..along };
    assert!(page.is_told(&one, &beside(anchors[0][1]), 5.0));
    let (rect, radius) = page.beside(&one).unwrap();
    assert!(page.is_told(&one, &rect, radius));
}

/// Spots in a block of ink, with room on one side only: leaders lead there side by side.
#[test]
fn leaders_do_not_cross_one_another() {
    let mut ink = Ink::new(Rect { low: [0.0; 2], high: [120.0; 2] });
    for k in 0..=100 {
        ink.segment([10.0, 10.0 + 0.5 * f64::from(k)], [60.0, 10.0 + 0.5 * f64::from(k)], 1);
    }
    let mut seed = 5_u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 16) / 65_536.0
    };
    let mut leaders = 0;
    for _ in 0..20 {
        let spots: Vec<Spot> = (0..7).map(|_| [50.0 + 9.0 * next(), 15.0 + 40.0 * next()]).collect();
        let labels: Vec<Label> = spots.iter().map(|spot| label(*spot, "position at 0.5")).collect();
        let drawn = place(&labels, &ink, (Theme::Light, false), &mut Vec::new()).drawn;
        let lines: Vec<[Spot; 2]> = drawn
            .split("<line class=\"leader\"")
            .skip(1)
            .map(|line| {
                let number = |name: &str| -> f64 {
                    let from = line.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
                    line[from..].split('"').next().unwrap().parse().unwrap()
                };
                [[number("x1"), number("y1")], [number("x2"), number("y2")]]
            })
            .collect();
        leaders += lines.len();
        for (k, one) in lines.iter().enumerate() {
            assert!(lines[..k].iter().all(|other| !cross(*one, *other)), "{lines:?}");
        }
    }
    assert!(leaders > 100, "{leaders}");
}

/// In a net of lines too narrow for a number it stands outside, at the end of a leader.
#[test]
fn the_numbers_of_a_row_have_leaders_out_of_a_net() {
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    for k in 0..=8 {
        let y = 26.0 + f64::from(k);
        ink.segment([5.0, y], [95.0, y], 1);
    }
    let found = place(&row(9, 10.0), &ink, (Theme::Light, true), &mut Vec::new());
    assert_eq!((found.drawn.matches("<text").count(), found.left.len()), (9, 0), "{found:?}");
    assert_eq!(found.drawn.matches("\"leader\"").count(), 9);
    // Beneath each there is paper, so that it is seen on faces of any colour.
    assert_eq!(found.drawn.matches("\"halo\"").count(), 9);
    for rect in found.drawn.split("<text").skip(1).map(around) {
        assert!(rect.high[1] < 26.0 || rect.low[1] > 34.0, "{rect:?}");
    }
}

/// Where there is no room for words they have a number, the same in every drawing of a page and wherever they are.
#[test]
fn words_have_one_number() {
    let mut full = Ink::new(Rect { low: [0.0; 2], high: [40.0, 30.0] });
    for row in 0..38 {
        full.segment([0.0, 0.8 * f64::from(row)], [40.0, 0.8 * f64::from(row)], 6);
    }
    let mut apart = Vec::new();
    for _ in 0..3 {
        let labels = [label([20.0, 15.0], "position at 0.5"), label([9.0, 9.0], "position at 0.25")];
        place(&labels, &full, (Theme::Light, false), &mut apart);
    }
    assert_eq!(apart, ["position at 0.5", "position at 0.25"]);
}

/// A level leader would be the sign of its number: it ends a digit's width away.
#[test]
fn leaders_are_no_minus_signs() {
    let of = |row: Option<Row>| {
        let label = Label { row, ..label([0.0, 0.0], "0.5") };
        let rect = Rect { low: [9.0, -1.0], high: [15.0, 3.0] };
        leader(&label, &rect, 9.0).unwrap()[1][0]
    };
    assert!((of(None) - (9.0 - GAP)).abs() < 1e-9);
    assert!((of(Some(Row { rank: 3, object: "c".into() })) - (9.0 - LEVEL_GAP)).abs() < 1e-9);
}

/// What has to be said has the first choice of places, whatever is given first.
#[test]
fn rows_make_way_for_what_has_to_be_said() {
    let ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    let said = label([50.0, 30.0], "position at 0.25");
    let alone = place(std::slice::from_ref(&said), &ink, (Theme::Light, false), &mut Vec::new()).drawn;
    let mut all = row(41, 2.0);
    all.push(said);
    assert!(place(&all, &ink, (Theme::Light, false), &mut Vec::new()).drawn.starts_with(&alone));
}

#[test]
fn labels_of_one_spot_do_not_overlap_and_keep_off_the_line() {
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    ink.segment([0.0, 30.0], [100.0, 30.0], 4);
    let labels: Vec<Label> = (0..6).map(|_| label([50.0, 30.0], "position at 0.25")).collect();
    let text = place(&labels, &ink, (Theme::Light, false), &mut Vec::new()).drawn;
    let boxes: Vec<Rect> = text.split("<text").skip(1).map(around).collect();
    assert_eq!(boxes.len(), 6, "{text}");
    for (k, rect) in boxes.iter().enumerate() {
        assert!(rect.high[1] < 30.0 || rect.low[1] > 30.0, "{rect:?} is on the line");
        assert!((0..2).all(|i| rect.low[i] >= 0.0 && rect.high[i] <= [100.0, 60.0][i]), "{rect:?}");
        for other in &boxes[..k] {
            let apart = |i: usize| rect.low[i] >= other.high[i] || other.low[i] >= rect.high[i];
            assert!(apart(0) || apart(1), "{rect:?} {other:?}");
        }
    }
    // Without the others, and without the line, all would stand in the same place.
    let clean = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    let alone = around(
        place(&labels[..1], &clean, (Theme::Light, false), &mut Vec::new())
            .drawn
            .split("<text")
            .nth(1)
            .unwrap(),
    );
    assert!((alone.low[1]..alone.high[1]).contains(&30.0), "{alone:?}");
}

/// What a text element covers: as wide as its letters, from a little below its base line to their height.
fn around(element: &str) -> Rect {
    let value = |name: &str| {
        let from = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        element[from..].split('"').next().unwrap().to_owned()
    };
    let number = |name: &str| -> f64 { value(name).parse().unwrap() };
    let words = element.split('>').nth(1).unwrap().split('<').next().unwrap();
    let (wide, x, y) = (text::width(words) * SIZE, number("x"), number("y"));
    let left = match value("text-anchor").as_str() {
        "start" => x,
        "end" => x - wide,
        _ => x - wide / 2.0,
    };
    Rect { low: [left, y - 0.75 * SIZE], high: [left + wide, y + 0.2 * SIZE] }
}

#[test]
fn a_leader_keeps_off_lines_that_lead_elsewhere() {
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    // No room but above and below, and above a line in between.
    (0..=20).for_each(|k| {
        let y = 25.0 + 0.5 * f64::from(k);
        ink.segment([0.0, y], [100.0, y], 9);
    });
    ink.segment([0.0, 22.0], [100.0, 22.0], 9);
    let text = place(&[label([50.0, 30.0], "position")], &ink, (Theme::Light, false), &mut Vec::new()).drawn;
    let y2: f64 = text.split("y2=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    assert!(y2 > 30.0, "{text}");
}

/// Where no place around is free a label stands beside the drawing; where it would be too far off it has a number, and its words are for
/// the legend.
#[test]
fn labels_never_stand_on_lines() {
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [200.0, 60.0] });
    (0..=60).for_each(|k| ink.segment([0.0, f64::from(k)], [160.0, f64::from(k)], 1));
    let mut apart = Vec::new();
    let text =
        place(&[label([140.0, 30.0], "position at 0.5")], &ink, (Theme::Light, false), &mut apart).drawn;
    let rect = around(text.split("<text").nth(1).unwrap());
    assert!(rect.low[0] > 160.0 && apart.is_empty() && text.contains("leader"), "{rect:?}");
    // A slit of no more than a figure.
    let mut ink = Ink::new(Rect { low: [0.0, 0.0], high: [200.0, 60.0] });
    (0..=60).for_each(|k| {
        ink.segment([0.0, f64::from(k)], [95.0, f64::from(k)], 1);
        ink.segment([100.0, f64::from(k)], [200.0, f64::from(k)], 1);
    });
    // Six have theirs already.
    let mut apart: Vec<String> = (0..6).map(|k| format!("position at 0.{k}1")).collect();
    let text =
        place(&[label([90.0, 30.0], "position at 0.5")], &ink, (Theme::Light, false), &mut apart).drawn;
    let rect = around(text.split("<text").nth(1).unwrap());
    assert!(rect.low[0] > 95.0 && rect.high[0] < 100.0 && text.contains(">7<"), "{rect:?} {text}");
    assert_eq!((apart.len(), apart[6].as_str()), (7, "position at 0.5"));
}

#[test]
fn a_label_in_the_corner_stays_inside() {
    let ink = Ink::new(Rect { low: [0.0, 0.0], high: [100.0, 60.0] });
    let text =
        place(&[label([99.0, 1.0], "a long label here")], &ink, (Theme::Light, false), &mut Vec::new()).drawn;
    assert!(text.contains("text-anchor=\"end\""), "{text}");
}

/// A leader runs neither over the spot of another label, where it would seem to end, nor between another's leader and its words.
#[test]
fn leaders_keep_off_spots_and_leaders_of_others() {
    let ink = Ink::new(Rect { low: [0.0; 2], high: [100.0; 2] });
    let one = label([20.0, 50.0], "0.5");
    let [w, h] = one.size();
    let at = |x: f64, y: f64| Rect { low: [x, y - h / 2.0], high: [x + w, y + h / 2.0] };
    let mut page = Page { anchors: vec![one.anchor, [30.0, 50.3]], ..Page::clean(&ink) };
    assert!(page.crossed(&one, &at(40.0, 50.0), 9.0) >= 1000.0);
    assert!(page.crossed(&one, &at(40.0, 60.0), 9.0) < 1000.0);
    page.anchors.clear();
    let mut of = |own: &Label, rect: Rect| _ = page.take(own, (rect, 9.0), Theme::Light, false);
    of(&label([60.0, 20.0], "0.7"), at(80.0, 20.0));
    // From above to below through the gap before the words.
    let through = label([79.7, 10.0], "u 1");
    let [w, h] = through.size();
    let below = Rect { low: [79.7 - w / 2.0, 30.0], high: [79.7 + w / 2.0, 30.0 + h] };
    assert!(page.crossed(&through, &below, 9.0) >= 1000.0);
}
