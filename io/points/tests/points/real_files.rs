//! Files made by other programs, against counts and areas that were made independently.

use loftsman_kernel::Point;

use super::common::{polyline, read};

fn data(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points/");
    std::fs::read(format!("{folder}{name}")).unwrap()
}

/// File, rows (without AeroDyn's reference row), shoelace area, whether the last row repeats the first.
type Fact = (&'static str, usize, f64, bool);

const FACTS: [Fact; 22] = [
    ("naca0012.dat", 160, 0.0821928, false),
    ("naca0012_clockwise.dat", 160, -0.0821928, false),
    ("naca0012_closed.dat", 161, 0.0821928, true),
    ("naca0012_sharp.dat", 153, 0.0821347, false),
    ("naca0012_zeroLE.dat", 161, 0.0821928, false),
    ("naca2412.dat", 160, 0.0821931, false),
    ("rae2822.dat", 129, 0.077843, true),
    ("AeroPython_naca0012.dat", 130, 0.0821778, false),
    ("cylinder.dat", 200, 3.14108, false),
    ("MainFoil_N=100.csv", 101, 0.102904, false),
    ("FlapFoil_N=100.csv", 101, 0.0118934, false),
    ("NACA23012_MainFoil.csv", 151, 0.0816808, true),
    ("Eppler_335_profile.csv", 72, 0.0851828, true),
    ("IEA-15-240-RWT_AF00_Coords.txt", 200, -0.785228, false),
    ("IEA-15-240-RWT_AF10_Coords.txt", 200, -0.265416, false),
    ("IEA-15-240-RWT_AF20_Coords.txt", 200, -0.182456, false),
    ("IEA-15-240-RWT_AF30_Coords.txt", 200, -0.143621, false),
    ("IEA-15-240-RWT_AF40_Coords.txt", 200, -0.119906, false),
    ("clark-y.dat", 33, 0.0806006, false),
    ("usa-35b.dat", 33, 0.0777225, false),
    ("naca-m6.dat", 35, 0.0845919, false),
    ("ex_curve3d.cpt", 51, -1495.19, true),
];

fn shoelace(points: &[Point]) -> f64 {
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>()
}

#[test]
fn counts_and_areas_are_those_of_the_files() {
    for (name, rows, area, closed) in FACTS {
        let (scene, report) = read(name, data(name)).unwrap();
        let (points, is_closed) = polyline(&scene);
        assert_eq!(points.len(), rows - usize::from(closed), "{name}");
        assert_eq!(is_closed, closed, "{name}");
        // Six digits, as they were printed.
        let found = shoelace(points);
        assert!((found - area).abs() <= 0.6e-5 * area.abs(), "{name}: {found}, not {area}");
        assert!(report.adds_up() && report.kept == points.len(), "{name}: {report:?}");
        let reference = usize::from(name.starts_with("IEA"));
        assert_eq!(report.entities, rows + reference, "{name}: {report:?}");
    }
}

#[test]
fn the_report_says_what_was_recognised() {
    let notes = |name: &str| {
        let (scene, report) = read(name, data(name)).unwrap();
        (scene.objects()[0].name().to_owned(), report.notes.join("\n"))
    };
    let (name, text) = notes("IEA-15-240-RWT_AF20_Coords.txt");
    assert_eq!(name, "IEA-15-240-RWT_AF20_Coords");
    assert!(text.contains("AeroDyn") && text.contains("reference point is (0.25, 0)"), "{text}");
    let (name, text) = notes("clark-y.dat");
    assert_eq!(name, "Clark Y");
    assert!(text.contains("Selig"), "{text}");
    let (name, text) = notes("rae2822.dat");
    assert_eq!(name, "RAE 2822 TRANSONIC AIRFOIL");
    assert!(text.contains("Tecplot"), "{text}");
    let (name, text) = notes("ex_curve3d.cpt");
    assert_eq!(name, "ex_curve3d");
    assert!(text.contains("3 columns separated by commas, 3 of them coordinates"), "{text}");
    let (_, text) = notes("naca0012.dat");
    assert!(text.contains("Selig") && text.contains("z is 0"), "{text}");
}
