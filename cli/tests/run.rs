//! `mollis run` from outside: what it writes, killed runs, a user's own points.

use std::path::Path;
use std::time::{Duration, Instant};

mod common;

use common::{folder, mollis, succeeded, text};

#[test]
fn a_scene_leaves_data_pictures_and_numbers() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/craig-bertozzi-fig6-star-quadratic.toml");
    let out = folder("outputs");
    let output = mollis(&["run", text(&scene), "--quick", "--quiet", "--out", text(&out)]).output().unwrap();
    succeeded(&output);
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    for file in ["summary.json", "diagnostics.csv", "particles.npy", "density.png", "density.svg"] {
        assert!(std::fs::metadata(out.join(file)).unwrap().len() > 100, "{file}");
    }
    assert!(!out.join("checkpoint.mollis").exists());
    let summary: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    let expectations = summary["expectations"].as_array().unwrap();
    assert!(expectations.len() == 2 && expectations.iter().all(|e| e["passed"] == true));
    let plan = mollis(&["plan", text(&scene)]).output().unwrap();
    succeeded(&plan);
    assert!(String::from_utf8_lossy(&plan.stdout).contains("cost"));
}

/// Each compares with an exact motion.
#[test]
fn the_scenes_of_vortices_meet_their_expectations() {
    for name in ["vortex-pair", "vortex-patch", "vortex-kirchhoff"] {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml"));
        let out = folder(name);
        succeeded(&mollis(&["run", text(&scene), "--quick", "--quiet", "--out", text(&out)]).output().unwrap());
    }
}

/// Killed as soon as there is a checkpoint, a run goes on to the same final bytes.
fn killed_and_resumed(name: &str, scene: &str) {
    let folder = folder(name);
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    let (whole, broken) = (folder.join("whole"), folder.join("broken"));
    succeeded(&mollis(&["run", text(&path), "--quiet", "--out", text(&whole)]).output().unwrap());
    let arguments = ["run", text(&path), "--quiet", "--checkpoint-every", "0.01", "--out", text(&broken)];
    let mut run = mollis(&arguments).spawn().unwrap();
    let start = Instant::now();
    while !broken.join("checkpoint.mollis").exists() {
        assert!(run.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    // SIGKILL where there are signals.
    run.kill().unwrap();
    assert!(!run.wait().unwrap().success(), "the run was over before it was killed");
    assert!(!broken.join("particles.npy").exists());
    let output = mollis(&["run", text(&path), "--quiet", "--resume", "--out", text(&broken)]).output().unwrap();
    succeeded(&output);
    for file in ["particles.npy", "diagnostics.csv"] {
        let bytes = |folder: &Path| std::fs::read(folder.join(file)).unwrap();
        assert!(bytes(&whole).len() > 1000 && bytes(&whole) == bytes(&broken), "{file}");
    }
}

#[test]
fn a_killed_blob_run_resumes_to_the_same_bytes() {
    killed_and_resumed(
        "killed-blob",
        r#"
title = "killed"
model = "blob"
dimension = 2
combination = [0.5, -1]
[[kernel]]
kind = "power"
p = 3
[mollifier]
kind = "compact"
order = 4
exponent = 4
[[initial]]
shape = "polynomial"
k = 2
[sampling]
kind = "grid"
h = 0.2
[time]
end = 2
dt = 0.002
"#,
    );
}

#[test]
fn a_killed_run_of_coalescing_particles_resumes_to_the_same_bytes() {
    killed_and_resumed(
        "killed-pks",
        r#"
title = "killed"
model = "pks"
dimension = 2
seed = 5
[pks]
chi = 1
mu = 1
mesh = [64, 64]
x = [-4, 4]
y = [-4, 4]
scheme = "fourth"
[[initial]]
shape = "bump"
mass = "6 pi"
[sampling]
kind = "random"
count = 4000
[time]
end = 0.5
dt = 0.0005
"#,
    );
}

#[test]
fn a_users_points_run_and_broken_ones_are_refused_with_their_line() {
    let folder = folder("points");
    let scene = folder.join("scene.toml");
    std::fs::write(
        &scene,
        r#"
title = "points of one's own"
model = "particle"
dimension = 2
[[kernel]]
kind = "power"
p = 4
[[initial]]
shape = "file"
path = "points.csv"
[time]
end = 0.04
dt = 0.01
"#,
    )
    .unwrap();
    let points = |n: usize| {
        let row = |k: usize| {
            let (a, b) = (k as f64 * 0.618_033_988_749, k as f64 * 0.754_877_666_246);
            format!("{},{},1e-5\n", a.fract() - 0.5, b.fract() - 0.5)
        };
        (0..n).map(row).collect::<String>()
    };
    let run = |text_of_file: String| {
        std::fs::write(folder.join("points.csv"), text_of_file).unwrap();
        mollis(&["run", text(&scene), "--quiet", "--out", text(&folder.join("out"))]).output().unwrap()
    };
    succeeded(&run(format!("x,y,mass\n{}", points(100_000))));
    assert!(std::fs::metadata(folder.join("out/particles.npy")).unwrap().len() > 2_400_000);
    for (file, words) in [
        (format!("x,y,mass\n{}NaN,0,1\n", points(3)), "5"),
        (format!("x,mass\n{}", "0,1\n"), "y"),
        ("x,y,mass\n".to_owned(), "points.csv"),
        (format!("x,y,z,mass\n{}", "0,0,0,1\n"), "z"),
    ] {
        let output = run(file.clone());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && message.contains("points.csv") && message.contains(words),
            "{file}: {message}"
        );
    }
}
