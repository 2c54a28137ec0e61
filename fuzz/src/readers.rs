//! What users write: scenes, tables and NPY files. They are read or refused with a message that says where.

use std::path::PathBuf;

/// Reads a scene.
pub fn scene(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    // A line more, as a mistake may be that the text ends.
    let lines = text.split('\n').count() + 1;
    for quick in [false, true] {
        match mollis_cli::inputs::scene(&text, quick) {
            Ok(cases) => assert!(cases > 0, "a scene without a case"),
            Err(mistakes) => {
                assert!(!mistakes.is_empty(), "refused without a mistake");
                for (line, text) in mistakes {
                    assert!((1..=lines).contains(&line), "line {line} of {lines}: {text}");
                    assert!(!text.is_empty());
                }
            }
        }
    }
}

/// Reads a file of points. The first byte says its dimension and format.
pub fn points(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    let dimension = 1 + usize::from(first % 3);
    let ending = ["npy", "csv", "tsv", "dat"][usize::from(first / 16 % 4)];
    let path = folder().join(format!("mollis-fuzz-{}-{:?}.{ending}", std::process::id(), std::thread::current().id()));
    std::fs::write(&path, rest).expect("a file can be written");
    let read = mollis_cli::inputs::points(&path, dimension);
    std::fs::remove_file(&path).expect("it was written");
    match read {
        Ok(([positions, masses, densities], promised)) => {
            assert!(!masses.is_empty());
            assert_eq!((positions.len(), densities.len()), (masses.len() * dimension, masses.len()));
            assert!(positions.iter().chain(&masses).all(|x| x.is_finite()));
            assert!(densities.iter().all(|x| x.is_finite() == promised));
        }
        Err(error) => {
            let text = format!("{error:#}");
            assert!(text.starts_with(&path.display().to_string()), "no path: {text}");
        }
    }
}

/// Memory where there is such a folder.
fn folder() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    if memory.is_dir() { memory } else { std::env::temp_dir() }
}
