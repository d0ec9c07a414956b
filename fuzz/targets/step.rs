//! Any bytes as a STEP file: read or refused; what is read is sound, adds up, and can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions};
use loftsman_step::Step;

fuzz_target!(|bytes: &[u8]| {
    _ = Step.confidence(&bytes[..bytes.len().min(4096)]);
    let Ok((scene, report)) = Step.read(&Memory::new("fuzz.step", bytes), &ReadOptions::default()) else { return };
    assert!(report.adds_up(), "{report:?}");
    scene.check().unwrap();
    let finite = |p: &loftsman_kernel::Point| p.iter().all(|c| c.is_finite());
    assert!(scene.objects().iter().all(|o| o.geometry().points().iter().all(finite)));
    let mut out = Memory::new("out.step", "");
    let Ok(report) = Step.write(&scene, &mut out, &WriteOptions::default()) else { return };
    // A file of which nothing went out is none.
    if report.objects.iter().any(|o| o.fate != Fate::LeftOut) {
        Step.read(&out, &ReadOptions::default()).unwrap();
    }
});
