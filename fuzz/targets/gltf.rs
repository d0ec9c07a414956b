//! Whatever the bytes: the reader returns a scene that checks, with a report that adds up, or one error with a
//! reason; what it returns can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loftsman_gltf::Gltf;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};

fuzz_target!(|bytes: &[u8]| {
    let mut file = Memory::new("fuzz.glb", bytes);
    // Files beside it that data may refer to: short ones, and one with numbers in it.
    file.siblings.insert("a.bin".to_owned(), vec![0; 48]);
    file.siblings.insert("buffer.bin".to_owned(), (0..=255).cycle().take(4096).collect());
    match Gltf.read(&file, &ReadOptions::default()) {
        Ok((scene, report)) => {
            assert!(report.adds_up(), "{report:?}");
            scene.check().unwrap();
            for object in scene.objects() {
                assert!(object.geometry().points().iter().all(|p| p.iter().all(|x| x.is_finite())));
            }
            let mut out = Memory::new("out.glb", "");
            // Numbers beyond single precision are refused: then nothing has to be read again.
            if Gltf.write(&scene, &mut out, &WriteOptions::default()).is_ok() {
                let (again, _) = Gltf.read(&out, &ReadOptions::default()).unwrap();
                assert!(again.objects().len() <= scene.objects().len());
            }
        }
        Err(error) => assert!(!error.problem.is_empty()),
    }
});
