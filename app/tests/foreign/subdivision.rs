//! Cages subdivided here, and by Blender's modifier.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use loftsman_tests::oracle::{Oracle, at, number};
use serde_json::{Value, json};

use crate::cages::{Wild, wild};
use crate::{LOFTSMAN, apart, save};

/// What is asked for of a cage.
#[derive(Debug, Clone)]
struct Task {
    name: String,
    cage: Wild,
    levels: usize,
    limit: bool,
}

/// Points and faces.
struct Mesh {
    points: Vec<[f64; 3]>,
    faces: Vec<Vec<usize>>,
}

impl Mesh {
    fn new(said: &Value) -> Self {
        let point = |p: &Value| [0, 1, 2].map(|k| p[k].as_f64().unwrap());
        Self {
            points: at(said, "points").as_array().unwrap().iter().map(point).collect(),
            faces: serde_json::from_value(at(said, "faces").clone()).unwrap(),
        }
    }
}

impl Task {
    fn step(&self) -> Value {
        let Wild { creases, corners, .. } = &self.cage;
        let mut step = json!({ "op": "subdivide", "object": self.name, "levels": self.levels, "limit": self.limit,
            "boundary": self.cage.boundary() });
        for (name, list) in [("creases", json!(creases)), ("corners", json!(corners))] {
            step[name] = list;
        }
        step
    }

    /// As the script for Blender reads it.
    fn file(&self, folder: &Path) -> PathBuf {
        let mut cage = self.cage.mesh();
        for (name, value) in [
            ("creases", json!(self.cage.creases)),
            ("corners", json!(self.cage.corners)),
            ("boundary", self.cage.boundary().into()),
            ("levels", self.levels.into()),
            ("limit", self.limit.into()),
        ] {
            cage[name] = value;
        }
        save(folder, &format!("{}.json", self.name), &cage)
    }
}

/// All of them subdivided by one recipe.
fn by_us(folder: &Path, tasks: &[Task]) -> Vec<Mesh> {
    let objects: Vec<Value> =
        tasks.iter().map(|t| json!({ "name": t.name, "mesh": t.cage.mesh() })).collect();
    save(folder, "cages.loft.json", &json!({ "loftsman": 1, "objects": objects }));
    let steps: Vec<Value> = tasks.iter().map(Task::step).collect();
    let recipe = json!({ "input": "cages.loft.json", "output": "fine.loft.json", "step": steps });
    save(folder, "recipe.json", &recipe);
    LOFTSMAN.done(folder, &["run", "recipe.json"]);
    let text = std::fs::read_to_string(folder.join("fine.loft.json")).unwrap();
    let fine: Value = serde_json::from_str(&text).unwrap();
    (0..tasks.len()).map(|k| Mesh::new(at(&fine, &format!("objects/{k}/mesh")))).collect()
}

/// All of them by Blender in one launch.
fn by_blender(folder: &Path, tasks: &[Task]) -> Option<Vec<Mesh>> {
    let files: Vec<PathBuf> = tasks.iter().map(|t| t.file(folder)).collect();
    let reports = Oracle::BlenderSubdivision.ask(&files, &[])?;
    for (task, report) in tasks.iter().zip(&reports) {
        assert!(report["error"].is_null(), "{task:?}: {report}");
        assert_eq!((number(report, "levels") as usize, &report["limit"]), (task.levels, &task.limit.into()));
    }
    Some(reports.iter().map(Mesh::new).collect())
}

/// Which vertex of one mesh is which of the other, the nearest one, and how far that is: one of each, and all faces are the same ones.
fn pairs(context: &str, ours: &Mesh, theirs: &Mesh) -> Vec<f64> {
    assert_eq!((ours.points.len(), ours.faces.len()), (theirs.points.len(), theirs.faces.len()), "{context}");
    let nearest = |p: &[f64; 3]| {
        let all = theirs.points.iter().enumerate().map(|(k, q)| (k, apart(*p, *q)));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    };
    let (place, off): (Vec<usize>, Vec<f64>) = ours.points.iter().map(nearest).unzip();
    assert_eq!(place.iter().collect::<BTreeSet<_>>().len(), place.len(), "{context}: two are near one");
    let from_least = |face: Vec<usize>| {
        let least = (0..face.len()).min_by_key(|&k| face[k]).unwrap();
        [&face[least..], &face[..least]].concat()
    };
    let sorted = |faces: Vec<Vec<usize>>| faces.into_iter().map(from_least).collect::<BTreeSet<_>>();
    let own = sorted(ours.faces.iter().map(|f| f.iter().map(|&v| place[v]).collect()).collect());
    assert!(own == sorted(theirs.faces.clone()), "{context}: other faces");
    off
}

/// A cage of `tests/golden/opensubdiv.json`.
fn golden(cages: &Value, index: usize) -> Wild {
    let cage = &cages["cages"][index];
    let list = |name: &str| cage[name].clone();
    Wild {
        points: serde_json::from_value(list("points")).unwrap(),
        faces: serde_json::from_value(list("faces")).unwrap(),
        creases: serde_json::from_value(list("creases")).unwrap(),
        corners: serde_json::from_value(list("corners")).unwrap(),
        rounded: cage["boundary"] == "edge-only",
    }
}

/// A cage as Blender hands it to OpenSubdiv: to the sharpness of a vertex of two edges it adds the smaller one of theirs.
fn handed_on(mut cage: Wild) -> Wild {
    let crease = |cage: &Wild, e: (usize, usize)| {
        let at = |c: &&(usize, usize, f64)| (c.0.min(c.1), c.0.max(c.1)) == e;
        cage.creases.iter().find(at).map_or(0.0, |c| c.2)
    };
    let edges: Vec<(usize, usize)> = cage.edges().into_keys().collect();
    for (v, [valence, _]) in cage.valences().into_iter().enumerate() {
        let own = edges.iter().filter(|e| e.0 == v || e.1 == v);
        let least = own.map(|e| crease(&cage, *e)).fold(f64::INFINITY, f64::min);
        if valence != 2 || least == 0.0 {
            continue;
        }
        match cage.corners.iter_mut().find(|c| c.0 == v) {
            Some(corner) => corner.1 = (corner.1 + least).min(10.0),
            None => cage.corners.push((v, least)),
        }
    }
    cage
}

/// Whether Blender takes it as it is: it leaves out a face that has all vertices of another.
fn is_taken(cage: &Wild) -> bool {
    let sets = cage.faces.iter().map(|f| f.iter().collect::<BTreeSet<_>>());
    sets.collect::<BTreeSet<_>>().len() == cage.faces.len()
}

/// All tasks by Blender in one launch and by one recipe here; the distances of our points from Blender's, by the points. `None` without Blender.
fn compared(tasks: &[Task]) -> Option<Vec<Vec<f64>>> {
    let folder = tempfile::tempdir().unwrap();
    let theirs = by_blender(folder.path(), tasks)?;
    let own: Vec<Task> =
        tasks.iter().map(|t| Task { cage: handed_on(t.cage.clone()), ..t.clone() }).collect();
    let ours = by_us(folder.path(), &own);
    Some(tasks.iter().zip(ours.iter().zip(&theirs)).map(|(t, (a, b))| pairs(&t.name, a, b)).collect())
}

/// The vertices of a cage where Blender's limit is that of patches which come no nearer: inner ends of creases for ever, not sharp themselves, and ends of
/// a rounded boundary that are sharp to a finite degree.
fn approximated(cage: &Wild) -> BTreeSet<usize> {
    let cage = handed_on(cage.clone());
    let (edges, valences) = (cage.edges(), cage.valences());
    let sharpness = |v: usize| cage.corners.iter().find(|c| c.0 == v).map_or(0.0, |c| c.1);
    let is_dart = |v: usize| {
        let mut own = edges.iter().filter(|(e, _)| e.0 == v || e.1 == v);
        let lasting = cage.creases.iter().filter(|c| (c.0 == v || c.1 == v) && c.2 >= 10.0).count();
        own.all(|(_, faces)| faces.len() == 2) && lasting == 1 && sharpness(v) < 10.0
    };
    let is_end = |v: usize| cage.rounded && valences[v][1] == 1 && 0.0 < sharpness(v) && sharpness(v) < 10.0;
    (0..cage.points.len()).filter(|&v| is_dart(v) || is_end(v)).collect()
}

/// The cages that OpenSubdiv's limits are known of, refined once and twice.
#[test]
fn blender_makes_the_same_of_the_cages_of_opensubdiv() {
    let cages = loftsman_tests::repository().join("tests/golden/opensubdiv.json");
    let cages: Value = serde_json::from_str(&std::fs::read_to_string(cages).unwrap()).unwrap();
    let mut tasks = Vec::new();
    for index in 0..cages["cages"].as_array().unwrap().len() {
        let cage = golden(&cages, index);
        if is_taken(&cage) {
            tasks.push(Task { name: format!("cage-{index}"), cage, levels: 1 + index % 2, limit: false });
        }
    }
    assert_eq!(tasks.len(), 195);
    let Some(off) = compared(&tasks) else { return };
    for (task, off) in tasks.iter().zip(off) {
        let most = off.into_iter().fold(0.0, f64::max);
        assert!(most < 1e-6, "{}: {most:e}", task.name);
    }
}

/// Random cages of all families: the vertices of one to three levels, and limits at those of one level.
#[test]
fn blender_makes_the_same_of_random_cages() {
    let mut tasks = Vec::new();
    let mut seen = BTreeMap::new();
    for number in 0..120 {
        let cage = wild(number);
        assert!(is_taken(&cage), "{number}");
        families(&cage).into_iter().for_each(|name| *seen.entry(name).or_insert(0) += 1);
        let levels = if number % 10 == 0 { 3 } else { 1 + number as usize % 2 };
        let name = format!("wild-{number}");
        tasks.push(Task { name: format!("{name}-limit"), cage: cage.clone(), levels: 1, limit: true });
        tasks.push(Task { name, cage, levels, limit: false });
    }
    assert!(seen.len() == FAMILIES && seen.values().all(|count| *count >= 10), "{seen:?}");
    let Some(off) = compared(&tasks) else { return };
    let mut less = 0;
    for (task, off) in tasks.iter().zip(off) {
        let near = if task.limit { approximated(&task.cage) } else { BTreeSet::new() };
        // Single precision has seven digits of the largest coordinate.
        let size = task.cage.points.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()));
        for (v, off) in off.into_iter().enumerate() {
            // The vertices of a cage keep their numbers.
            let is_near = near.contains(&v);
            less += usize::from(is_near);
            let bound = if is_near { 2e-4 } else { 6e-7 * size };
            assert!(off < bound, "{}, vertex {v}: {off:e}", task.name);
        }
    }
    assert!(less > 40, "{less}");
}

/// How many [`families`] there are.
const FAMILIES: usize = 16;

/// What a cage is, by the words of what it is to be compared in.
fn families(cage: &Wild) -> BTreeSet<&'static str> {
    let (edges, valences) = (cage.edges(), cage.valences());
    let inner = |v: usize| valences[v][0] == valences[v][1];
    let sharpness: Vec<f64> = cage.creases.iter().map(|c| c.2).collect();
    let any = |test: &dyn Fn(f64) -> bool| sharpness.iter().any(|s| test(*s));
    let faces = |test: fn(usize) -> bool| cage.faces.iter().any(|f| test(f.len()));
    let vertices = |test: &dyn Fn([usize; 2]) -> bool| valences.iter().any(|v| test(*v));
    let is_open = edges.values().any(|faces| faces.len() == 1);
    let all = [
        ("closed", !is_open),
        ("open, with corners", is_open && !cage.rounded),
        ("open, rounded", is_open && cage.rounded),
        ("boundary vertices of one face", vertices(&|v| v == [2, 1])),
        ("triangles", faces(|n| n == 3)),
        ("quads", faces(|n| n == 4)),
        ("faces of more corners", faces(|n| n > 4)),
        (
            "triangles, quads and larger faces",
            [3, 4, 5].iter().all(|&n| cage.faces.iter().any(|f| f.len().min(5) == n)),
        ),
        ("inner vertices of two edges", (0..valences.len()).any(|v| inner(v) && valences[v][0] == 2)),
        (
            "inner vertices of five edges and more",
            (0..valences.len()).any(|v| inner(v) && valences[v][0] > 4),
        ),
        ("several parts", cage.parts() > 1),
        ("creases below one level", any(&|s| s < 1.0)),
        (
            "creases that end within the levels or later, at fractions",
            any(&|s| s > 1.0 && s < 10.0 && s.fract() != 0.0),
        ),
        ("creases for ever", any(&|s| s >= 10.0)),
        ("corners", !cage.corners.is_empty()),
        ("nothing sharp", cage.corners.is_empty() && sharpness.is_empty()),
    ];
    all.into_iter().filter(|(_, is)| *is).map(|(name, _)| name).collect()
}
