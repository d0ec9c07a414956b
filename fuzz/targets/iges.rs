//! Any bytes as an IGES file: read or refused; what is read is sound, adds up, and can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loftsman_iges::Iges;
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions};

fuzz_target!(|bytes: &[u8]| {
    _ = Iges.confidence(&bytes[..bytes.len().min(4096)]);
    let Ok((scene, report)) = Iges.read(&Memory::new("fuzz.igs", bytes), &ReadOptions::default()) else { return };
    assert!(report.adds_up(), "{report:?}");
    scene.check().unwrap();
    let finite = |p: &loftsman_kernel::Point| p.iter().all(|c| c.is_finite());
    assert!(scene.objects().iter().all(|o| o.geometry().points().iter().all(finite)));
    let mut out = Memory::new("out.igs", "");
    let Ok(report) = Iges.write(&scene, &mut out, &WriteOptions::default()) else { return };
    // A file of which nothing went out is none.
    if report.objects.iter().any(|o| o.fate != Fate::LeftOut) {
        Iges.read(&out, &ReadOptions::default()).unwrap();
    }
});
