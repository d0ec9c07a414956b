//! Any bytes as an OBJ file with a library beside it: read or refused; what is read is sound and can be written.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::Scene;
use loftsman_obj::Obj;

fuzz_target!(|bytes: &[u8]| {
    // What follows a zero byte is the material library.
    let (main, library) = match bytes.iter().position(|&b| b == 0) {
        Some(at) if at > 0 => (&bytes[..at], &bytes[at + 1..]),
        _ => (bytes, &[][..]),
    };
    let mut file = Memory::new("fuzz.obj", main);
    file.siblings.insert("a.mtl".to_owned(), library.to_vec());
    _ = Obj.confidence(&main[..main.len().min(4096)]);
    let Ok((scene, report)) = Obj.read(&file, &ReadOptions::default()) else { return };
    assert!(report.adds_up(), "{report:?}");
    scene.check().unwrap();
    let finite = |p: &loftsman_kernel::Point| p.iter().all(|c| c.is_finite());
    assert!(scene.objects().iter().all(|o| o.geometry().points().iter().all(finite)));
    let mut out = Memory::new("out.obj", "");
    let Ok(report) = Obj.write(&scene, &mut out, &WriteOptions::default()) else { return };
    // A file of which nothing went out is none.
    if report.objects.iter().any(|o| o.fate != Fate::LeftOut) {
        let (again, _) = Obj.read(&out, &ReadOptions::default()).unwrap();
        for kind in ["curve", "surface", "trimmed", "mesh"] {
            let count = |s: &Scene| s.objects().iter().filter(|o| o.geometry().kind() == kind).count();
            assert_eq!(count(&again), count(&scene), "{kind}");
        }
    }
});
