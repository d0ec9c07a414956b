//! The program with a registry of one's own, and conversions in the library.

use std::ffi::OsString;

use loftsman::convert::Conversion;
use loftsman::kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport,
};
use loftsman::kernel::scene::Scene;
use loftsman::kernel::shape::Shape;

use crate::LOFTSMAN;

/// Lifts a curve.
struct Lift;

impl Operation for Lift {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] =
            &[Field::required("object", "text", "the curve"), Field::required("by", "length", "")];
        Declaration { name: "lift", help: "up", fields: FIELDS }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let (name, by) = (p.text("object")?, p.number("by")?);
        let mut curve = scene.curve(name).map_err(|e| p.error("object", e.to_string()))?.clone();
        curve.control_vertices_mut().iter_mut().for_each(|vertex| vertex.z += by);
        scene.replace(name, curve)?;
        Ok(StepReport { op: "lift".into(), object: Some(name.into()), ..StepReport::default() })
    }
}

#[test]
fn a_registry_of_ones_own_has_the_whole_command_line() {
    let bench = LOFTSMAN.bench().with_wave();
    let recipe = bench.path("r.toml");
    let text = "input = \"wave.loft.json\"\noutput = \"up.loft.json\"\n[[step]]\nop = \"lift\"\nobject = \"wave\"\nby = 2.5\n";
    bench.write("r.toml", text);
    let mut registry = loftsman::registry().clone();
    registry.operation(Lift);
    let run = |registry: &loftsman::kernel::plugin::Registry| {
        let arguments = ["loftsman", "run"].map(OsString::from).into_iter().chain([recipe.clone().into()]);
        // An exit status says no more of itself than this.
        format!("{:?}", loftsman::program::main_with(registry, arguments))
    };
    let failed = run(loftsman::registry());
    assert!(!bench.path("up.loft.json").exists(), "what is built in does not know it");
    let done = run(&registry);
    assert_ne!(failed, done);
    assert_eq!(done, format!("{:?}", std::process::ExitCode::SUCCESS));
    let (before, after) =
        ["wave.loft.json", "up.loft.json"].map(|f| loftsman::read_scene(bench.path(f)).unwrap()).into();
    let heights =
        |scene: &Scene| -> Vec<f64> { scene.curve("wave").unwrap().points().iter().map(|p| p.z).collect() };
    assert!(heights(&before).iter().zip(heights(&after)).all(|(a, b)| b - a == 2.5));
}

#[test]
fn a_conversion_in_the_library_is_that_of_the_program() {
    let bench = LOFTSMAN.bench().with_wave();
    let (from, to) = (bench.path("wave.loft.json"), bench.path("library.glb"));
    let done = loftsman::convert(&from, &to, &Conversion::default(), loftsman::registry()).unwrap();
    let told = bench.json(&["convert", "wave.loft.json", "program.glb"]);
    assert_eq!(bench.read("library.glb"), bench.read("program.glb"));
    assert_eq!(told["bytes"].as_u64().unwrap(), done.bytes);
    assert_eq!(told["objects"].as_array().unwrap().len(), done.objects.len());
    assert_eq!((done.format, done.left_out(), done.output), ("loft", 0, to.display().to_string()));
    // Errors name the file, and nothing is written.
    let missing = loftsman::convert(
        bench.path("no.obj"),
        bench.path("x.glb"),
        &Conversion::default(),
        loftsman::registry(),
    );
    assert!(missing.unwrap_err().to_string().contains("no.obj"));
    let unknown = loftsman::convert(&from, bench.path("x.dwg"), &Conversion::default(), loftsman::registry());
    assert!(unknown.unwrap_err().to_string().contains("x.dwg"));
    let onto_itself = loftsman::convert(&from, &from, &Conversion::default(), loftsman::registry());
    assert!(
        onto_itself.is_err()
            && bench.read("wave.loft.json").starts_with(b"{ \"loftsman\": 1, \"unit\": \"mm\"")
    );
    assert!(!bench.path("x.glb").exists() && !bench.path("x.dwg").exists());
}
