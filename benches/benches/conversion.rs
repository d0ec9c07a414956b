//! W7: an OBJ of a million triangles (76 MB) to GLB, as a whole process: wall time, processor time, peak memory.
//!
//! Aim: 0.7 s on two cores and 250 MiB. The peer is tobj, which only reads; `cp` is the floor. Not criterion's matter:
//! each contestant is a process, run five times, and the median run counts. Needs GNU time (`/usr/bin/time`) and
//! the program: `LOFTSMAN=target/release/loftsman`, or the one that `cargo build --release` put there.

use std::error::Error;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

type Outcome<T> = Result<T, Box<dyn Error>>;

const RUNS: usize = 5;
/// Vertices along `x`, then along `y`; the last is the workload, the others say how it grows.
const SIZES: [(usize, usize); 3] = [(101, 51), (317, 159), (1001, 501)];

/// A grid as triangles with normals, numbers with six digits.
fn write_grid(path: &Path, (columns, rows): (usize, usize)) -> Outcome<()> {
    let mut text = String::from("o grid\n");
    let mut normals = String::new();
    for i in 0..columns {
        for j in 0..rows {
            let (x, y) = (2.0 * i as f64 / (columns - 1) as f64, j as f64 / (rows - 1) as f64);
            let z = 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
            let (zx, zy) =
                (0.9 * (9.0 * x).cos() * (7.0 * y).cos(), -0.7 * (9.0 * x).sin() * (7.0 * y).sin());
            let length = (zx * zx + zy * zy + 1.0).sqrt();
            writeln!(text, "v {x:.6} {y:.6} {z:.6}")?;
            writeln!(normals, "vn {:.6} {:.6} {:.6}", -zx / length, -zy / length, 1.0 / length)?;
        }
    }
    text.push_str(&normals);
    for i in 0..columns - 1 {
        for j in 0..rows - 1 {
            let k = i * rows + j + 1;
            for [a, b, c] in [[k, k + rows, k + rows + 1], [k, k + rows + 1, k + 1]] {
                writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}")?;
            }
        }
    }
    BufWriter::new(std::fs::File::create(path)?).write_all(text.as_bytes())?;
    Ok(())
}

/// Wall time, processor time (both s) and peak memory (MiB) of the run in the middle.
fn measure(command: &[&str], scratch: &Path) -> Outcome<[f64; 3]> {
    let said = scratch.join("time.txt");
    let mut runs = Vec::new();
    for _ in 0..RUNS {
        let mut timed = Command::new("/usr/bin/time");
        timed.args(["-f", "%e %U %S %M", "-o"]).arg(&said).args(command);
        let output = timed.output()?;
        if !output.status.success() {
            return Err(format!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr)).into());
        }
        let said = std::fs::read_to_string(&said)?;
        let [wall, user, system, kilobytes] = said
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<Vec<f64>, _>>()?
            .try_into()
            .map_err(|_| format!("`time` said {said:?}"))?;
        runs.push([wall, user + system, kilobytes / 1024.0]);
    }
    runs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(runs[RUNS / 2])
}

/// The peer's process: reads and says how many triangles there are.
fn read_with_tobj(path: &str) -> Outcome<()> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj(path, &options)?;
    println!("{}", models.iter().map(|m| m.mesh.indices.len() / 3).sum::<usize>());
    Ok(())
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|a| a == "--tobj") {
        return read_with_tobj(arguments.get(at + 1).ok_or("--tobj needs a file")?);
    }
    let program = std::env::var_os("LOFTSMAN").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target/release/loftsman"),
        PathBuf::from,
    );
    let program = program.to_str().ok_or("the path of the program is not UTF-8")?;
    if !Path::new(program).exists() {
        // Said aloud and passed over, so that a run of all benches goes on.
        eprintln!("W7 is left out: {program} is not there (cargo build --release, or set LOFTSMAN)");
        return Ok(());
    }
    let this = std::env::current_exe()?;
    let this = this.to_str().ok_or("the path of this bench is not UTF-8")?;
    let scratch = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    println!("\n## W7 OBJ to GLB, whole processes\n");
    println!("| triangles | who | wall | processor | peak memory |\n|---|---|---|---|---|");
    for size in SIZES {
        let triangles = 2 * (size.0 - 1) * (size.1 - 1);
        let (obj, glb) = (scratch.join("grid.obj"), scratch.join("grid.glb"));
        write_grid(&obj, size)?;
        let (obj, glb) =
            (obj.to_str().ok_or("a path is not UTF-8")?, glb.to_str().ok_or("a path is not UTF-8")?);
        let contestants: [(&str, Vec<&str>); 3] = [
            ("cp (floor)", vec!["cp", obj, glb]),
            ("loftsman convert", vec![program, "convert", obj, glb]),
            ("tobj, reading alone", vec![this, "--tobj", obj]),
        ];
        for (who, command) in contestants {
            if Path::new(glb).exists() {
                std::fs::remove_file(glb)?;
            }
            let [wall, processor, peak] = measure(&command, &scratch)?;
            println!("| {triangles} | {who} | {wall:.2} s | {processor:.2} s | {peak:.0} MiB |");
        }
    }
    Ok(())
}
