//! Work grows with the input and not faster: allocated bytes, allocations and what comes out are counted, not seconds.

use allocation_counter::measure;
use loftsman::kernel::Point;
use loftsman::kernel::mesh::Mesh;
use loftsman::kernel::plugin::{Context, Parameters};
use loftsman::kernel::scene::{Object, Scene};
use loftsman::kernel::spline::{Curve, Space};
use loftsman::picture::{Look, encode};
use loftsman_tests::curves::Sequence;
use serde_json::json;

fn point(random: &mut Sequence) -> Point {
    let [x, y, z] = [0, 1, 2].map(|_| 2.0 * random.next_number() - 1.0);
    Point::new(x, y, z)
}

/// So many objects of a kind, all different, or faces all the same.
fn scene(random: &mut Sequence, kind: usize, count: usize) -> Scene {
    let mut scene = Scene::new();
    let mut add = |name: String, geometry| scene.add(Object::new(name, geometry)).unwrap();
    match kind {
        // Curves.
        0 => {
            for k in 0..count {
                let points = (0..6).map(|_| point(random)).collect();
                let curve = Curve::new(Space::clamped_uniform(3, 6).unwrap(), points).unwrap();
                add(format!("c{k}"), curve.into());
            }
        }
        // One face again and again in one mesh, and in as many meshes.
        1 => {
            let points = (0..3).map(|_| point(random)).collect();
            add("pile".into(), Mesh::new(points, &vec![[0, 1, 2]; count]).unwrap().into());
        }
        _ => {
            let points: Vec<Point> = (0..3).map(|_| point(random)).collect();
            for k in 0..count {
                add(format!("m{k}"), Mesh::new(points.clone(), &[[0, 1, 2]]).unwrap().into());
            }
        }
    }
    scene
}

/// Bytes and allocations of some work, and the bytes that it makes.
fn counted(work: impl FnOnce() -> usize) -> [u64; 3] {
    let mut made = 0;
    let info = measure(|| made = work());
    [info.bytes_total, info.count_total, made as u64]
}

#[test]
fn eight_times_the_input_is_about_eight_times_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Sequence::new(31);
    let (mut worst, mut tried) = (0.0_f64, 0);
    for member in 0..12 {
        for kind in 0..3 {
            let (few, many) = [(8, 64), (12, 96)][member % 2];
            let seed = random.clone();
            let [small, large] = [few, many].map(|count| scene(&mut seed.clone(), kind, count));
            random.next_number();
            for output in ["svg", "obj", "glb", "loft.json"] {
                if output == "svg" && member >= 2 {
                    continue;
                }
                let path = folder.path().join(format!("made.{output}"));
                let work = |scene: &Scene| {
                    counted(|| {
                        if output == "svg" {
                            return encode(&path, &Look::default().picture(scene, None, &[]), 400)
                                .unwrap()
                                .0
                                .len();
                        }
                        loftsman::write(scene, &path).unwrap();
                        std::fs::metadata(&path).unwrap().len() as usize
                    })
                };
                let (small, large) = (work(&small), work(&large));
                for ((a, b), what) in small.iter().zip(large).zip(["bytes", "allocations", "output"]) {
                    let ratio = b as f64 / *a as f64;
                    worst = worst.max(ratio);
                    assert!(
                        ratio <= 14.0,
                        "{output}, kind {kind}, {few} to {many}: {what} grow {ratio}: {a}, {b}"
                    );
                }
                tried += 1;
            }
        }
    }
    println!("{tried} tried, at worst {worst:.2} times the work for 8 times the input");
    assert!(tried >= 100, "{tried}");
}

/// Six vertices, whatever their weights: refused, or tessellated with bounded work.
#[test]
fn weights_of_any_size_cost_no_more_than_so_much() {
    let mut random = Sequence::new(77);
    let registry = loftsman::registry();
    let tessellate = registry.find_operation("tessellate", "op").unwrap();
    let (mut most, mut refused) = ([0; 2], Vec::new());
    for member in 0..120 {
        let degree = 1 + member % 5;
        let reach = [1.0, 30.0, 150.0, 308.0][member % 4];
        let points = (0..6).map(|_| point(&mut random)).collect();
        let weights: Vec<f64> =
            (0..6).map(|_| 10_f64.powf(reach * (2.0 * random.next_number() - 1.0))).collect();
        let curve = Curve::build(Space::clamped_uniform(degree, 6).unwrap(), points, Some(weights.clone()));
        let curve = match curve {
            Ok(curve) => curve,
            Err(error) => {
                assert!(reach > 1.0 && error.to_string().contains("weight"), "{reach}: {error}");
                refused.push(format!("{weights:?}"));
                continue;
            }
        };
        let mut scene = Scene::new();
        scene.add(Object::new("c", curve.into())).unwrap();
        let parameters = Parameters::new(json!({ "tolerance": 0.001 }), "step[0]").unwrap();
        let mut done = None;
        let info =
            measure(|| done = Some(tessellate.apply(&mut scene, &parameters, &Context::quiet(registry))));
        if let Err(error) = done.unwrap() {
            assert!(error.to_string().contains("\"c\"") || error.to_string().contains("weight"), "{error}");
            assert!(reach > 1.0, "{error}");
            refused.push(error.to_string());
        }
        most =
            [most[0].max(info.bytes_total), most[1].max(scene.objects()[0].geometry().points().len() as u64)];
    }
    println!(
        "at most {} bytes and {} points; {} of 120 refused:\n{}",
        most[0],
        most[1],
        refused.len(),
        refused.join("\n")
    );
    assert!(most[0] < 64 << 20 && most[1] < 20_000, "{most:?}");
    // Those of which something was measured.
    assert!(refused.len() <= 81, "{}", refused.len());
}
