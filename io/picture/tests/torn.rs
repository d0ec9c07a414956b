//! Curves and surfaces with knots of every multiplicity up to `p + 1`, where a shape is torn: drawn in their parts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::scene::{Animation, Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_picture::{Against, Beads, Combs, Panel, Picture, View};

/// Numbers that look random (splitmix64): the same on every run.
struct Dice(u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn points(&mut self, n: usize, size: f64) -> Vec<Point> {
        let mut one = || size * (2.0 * self.unit() - 1.0);
        (0..n).map(|_| Point::new(one(), one(), one())).collect()
    }

    fn weights(&mut self, n: usize) -> Option<Vec<f64>> {
        (self.below(3) == 0).then(|| (0..n).map(|_| 10_f64.powf(2.0 * self.unit() - 1.0)).collect())
    }

    /// A space and at how many inner knots it can be torn.
    fn space(&mut self, p: usize) -> (Space, usize) {
        let kind = self.below(3);
        let most = if kind == 2 { p } else { p + 1 };
        let (mut inner, mut at, mut tears) = (Vec::new(), 0.0, 0);
        for _ in 0..1 + self.below(4) {
            at += 0.1 + self.unit();
            // Every other knot at full multiplicity.
            let times = if self.below(2) == 0 { most } else { 1 + self.below(most) };
            tears += usize::from(times > p);
            inner.extend(vec![at; times]);
        }
        let end = at + 0.5;
        let knots = match kind {
            0 => [vec![0.0; p + 1], inner, vec![end; p + 1]].concat(),
            1 => {
                let before = (0..=p).rev().map(|k| -0.3 * k as f64).collect();
                [before, inner, (0..=p).map(|k| end + 0.2 * k as f64).collect()].concat()
            }
            _ => [vec![0.0], inner, vec![end]].concat(),
        };
        let space = if kind == 2 { Space::periodic(p, knots) } else { Space::open(p, knots) };
        (space.unwrap(), tears)
    }

    fn degree(&mut self) -> usize {
        [1, 2, 3, 4, 5, 6, 7, 25][self.below(8)]
    }
}

fn one(geometry: Geometry) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("c", geometry)).unwrap();
    scene
}

/// The data of the paths of a class.
fn paths<'s>(svg: &'s str, class: &str) -> Vec<&'s str> {
    let head = format!("class=\"{class}\"");
    svg.split("<path")
        .filter(|part| part.contains(&head))
        .filter_map(|part| {
            let data = part.split(" d=\"").nth(1)?;
            data.split('"').next()
        })
        .collect()
}

fn parts(svg: &str, class: &str) -> usize {
    paths(svg, class).iter().map(|d| d.matches('M').count()).sum()
}

fn drawn(picture: &Picture<'_>) -> String {
    let svg = picture.to_svg().unwrap();
    // Shading is an image, whose letters mean nothing.
    let words: String = svg.split("base64,").map(|part| part.split_once('"').map_or(part, |p| p.1)).collect();
    assert!(!words.contains("NaN") && !words.contains("inf"), "{words}");
    svg
}

#[test]
fn two_pieces_of_a_cubic_are_two_pieces() {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let points = (0..8).map(|k| Point::new(f64::from(k), f64::from(k % 2), 0.0)).collect();
    let scene = one(Curve::new(Space::open(3, knots).unwrap(), points).unwrap().into());
    let svg = drawn(&Picture::of(&scene).combs(Combs::Automatic).beads(Beads::Knots));
    let [data] = paths(&svg, "curve")[..] else { panic!("one curve") };
    assert_eq!((data.matches('M').count(), data.matches('C').count()), (2, 2));
    // Two envelopes, and a knot at each of the four ends.
    assert_eq!((parts(&svg, "envelope"), parts(&svg, "beads")), (2, 4));
    let svg = drawn(&Picture::of(&scene).panels([Panel::profile(Against::ArcLength)]));
    assert_eq!(parts(&svg, "profile"), 2);
}

#[test]
fn curves_of_all_multiplicities_are_drawn_in_as_many_parts_as_they_have() {
    let mut dice = Dice(1);
    let mut torn = 0;
    for member in 0..160 {
        let p = dice.degree();
        let (space, tears) = dice.space(p);
        let size = [1e-9, 1.0, 1e9][member % 3];
        let n = space.len();
        let curve = Curve::build(space, dice.points(n, size), dice.weights(n)).unwrap();
        let mut scene = one(curve.into());
        let frames = vec![dice.points(n, size), dice.points(n, size)];
        scene.object_mut("c").unwrap().animation = Some(Animation { rate: 24.0, frames });
        let plain = Picture::of(&scene).combs(Combs::Automatic).beads(Beads::Uniform(3)).frames(true);
        let svg = drawn(&plain);
        assert_eq!(parts(&svg, "curve"), tears + 1, "member {member} of degree {p}");
        assert_eq!(parts(&svg, "frame"), 2 * (tears + 1), "member {member} of degree {p}");
        torn += usize::from(tears > 0);
        drawn(&Picture::of(&scene).alternate(true).view(View::Perspective));
        drawn(
            &Picture::of(&scene)
                .panels([Panel::profile(Against::ArcLength), Panel::profile(Against::Parameter)]),
        );
        // Beside faces, which may hide curves, these go another way.
        let face = Mesh::new(dice.points(3, 0.1 * size), &[[0, 1, 2]]).unwrap();
        scene.add(Object::new("face", face.into())).unwrap();
        let before = one(Curve::bezier(dice.points(4, size)).unwrap().into());
        drawn(&Picture::of(&scene).before(&before).combs(Combs::Scale(size * size)).view(View::Isometric));
    }
    assert!(torn > 60, "{torn}");
}

#[test]
fn surfaces_of_all_multiplicities_are_drawn_in_their_patches() {
    let mut dice = Dice(2);
    let mut torn = 0;
    for member in 0..100 {
        let degrees = [1, 2, 3, 5];
        let ((u, tears_u), (v, tears_v)) =
            (dice.space(degrees[dice.0 as usize % 4]), dice.space(degrees[member % 4]));
        let n = u.len() * v.len();
        let points = dice.points(n, 1.0);
        let surface = Surface::build(u, v, points, dice.weights(n)).unwrap();
        let scene = one(surface.into());
        drawn(&Picture::of(&scene).view(View::Isometric).beads(Beads::Knots));
        drawn(&Picture::of(&scene).view(View::Top).before(&one(Geometry::Group)));
        torn += usize::from(tears_u + tears_v > 0);
    }
    assert!(torn > 40, "{torn}");
}

/// Two flat squares side by side, as one surface of degree (1, 1), with a gap.
#[test]
fn nothing_is_drawn_in_the_gap_of_a_surface() {
    let u = Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap();
    let v = Space::clamped(1, &[0.0, 1.0]).unwrap();
    let net = |gap: f64| -> Vec<Point> {
        [0.0, 1.0, 1.0 + gap, 2.0 + gap]
            .iter()
            .flat_map(|&x| [Point::new(x, 0.0, 0.0), Point::new(x, 1.0, 0.0)])
            .collect()
    };
    let svg = |gap: f64| {
        let scene = one(Surface::new(u.clone(), v.clone(), net(gap)).unwrap().into());
        drawn(&Picture::of(&scene).view(View::Top).control_polygons(false))
    };
    // Borders: across u both ends, and each side of the tear; along u two sides of each part.
    assert_eq!(parts(&svg(1.0), "border"), 4 + 4);
    // Where it could be torn but is not, there is one square.
    assert_eq!(parts(&svg(0.0), "border"), 4);
    // No line of any kind runs through the middle of the gap.
    let wide = svg(1.0);
    let xs: Vec<f64> = ["inner", "border", "outline"]
        .iter()
        .flat_map(|class| paths(&wide, class))
        .flat_map(|d| d.split('M').filter(|c| !c.is_empty()))
        .flat_map(|chain| {
            let n: Vec<f64> = chain.split(['L', ' ']).map(|x| x.parse().unwrap()).collect();
            let (low, high) =
                n.iter().step_by(2).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            [low, high]
        })
        .collect();
    let (left, right) = xs.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let middle = (left + right) / 2.0;
    assert!(xs.chunks(2).all(|pair| pair[1] < middle || pair[0] > middle), "{xs:?} {middle}");
}
