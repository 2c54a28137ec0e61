//! Scenes from outside: what is refused before the run, where data go, what a run tells of its initial data.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

mod common;

use common::{folder, mollis, succeeded, text};

fn written(folder: &Path, scene: &str) -> PathBuf {
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    path
}

/// Runs a scene into `out` in its folder.
fn run(folder: &Path, scene: &str) -> Output {
    let path = written(folder, scene);
    mollis(&["run", text(&path), "--out", text(&folder.join("out"))]).output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("out/summary.json")).unwrap()).unwrap()
}

/// The lines under `key` of the only case.
fn lines(summary: &Value, key: &str) -> Vec<String> {
    summary["cases"][0][key].as_array().unwrap().iter().map(|line| line.as_str().unwrap().to_owned()).collect()
}

/// A table's header and numbers.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let content = std::fs::read_to_string(path).unwrap();
    let mut rows = content.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = rows.next().unwrap();
    (header, rows.map(|row| row.iter().map(|field| field.parse().unwrap()).collect()).collect())
}

/// A billion steps, so that a run which begins is noticed.
const ENDLESS: &str = r#"
title = "endless"
model = "blob"
dimension = 1
[[kernel]]
kind = "power"
p = 3
[mollifier]
kind = "compact"
order = 4
[[initial]]
shape = "polynomial"
k = 2
[sampling]
kind = "grid"
h = 0.02
[time]
end = 1e6
dt = 1e-3
[output]
every = 1e3
snapshots = [0, 1]
"#;

#[test]
fn what_a_run_cannot_give_is_refused_before_its_first_step() {
    let folder = folder("refused");
    let expect = |keys: &str| format!("[[expect]]\n{keys}\nmost = 1\nreason = \"none\"\n");
    for (rest, words) in [
        ("[[picture]]\nname = \"p\"\nkind = \"particles\"\n".to_owned(), "scene.toml:25: picture[0].kind = \"particles\": needs two dimensions"),
        ("[[picture]]\nname = \"p\"\nkind = \"count\"\n".to_owned(), "picture[0].kind = \"count\": needs model = \"pks\""),
        ("[[picture]]\nname = \"p\"\nkind = \"density\"\n".to_owned(), "the run carries no density"),
        ("[[picture]]\nname = \"p\"\nkind = \"trajectories\"\nplane = \"xyt\"\n".to_owned(), "needs output.trajectories above 0"),
        (expect("quantity = \"energy_rise\""), "the run has no energy"),
        (expect("quantity = \"second_moment\"\nat = 2e6"), "at = 2000000: is beyond time.end = 1000000"),
        (expect("quantity = \"second_moment\"\nleast = 2"), "no number is at least 2 and at most 1"),
        (expect("quantity = \"slope\"\nfrom = 3e3\nto = 2e3"), "from = 3000: is above to = 2000"),
        ("[study]\nh = [0.05, 0.02]\nreference = 0.01\n[[expect]]\nquantity = \"rate_positions\"\nat = 0.05\nmost = 1\nreason = \"none\"\n".to_owned(), "the coarsest spacing has no rate"),
        ("[study]\nh = [0.05, 0.02]\nreference = 0.008\n".to_owned(), "study.reference = 0.008: must divide every study.h"),
    ] {
        let scene = written(&folder, &format!("{ENDLESS}{rest}"));
        let out = folder.join("out");
        for arguments in [&["scene", text(&scene)][..], &["plan", text(&scene)], &["run", text(&scene), "--out", text(&out)]] {
            let output = mollis(arguments).output().unwrap();
            assert!(output.status.code() == Some(1) && errors(&output).contains(words), "{words}: {}", errors(&output));
        }
        assert!(!out.exists(), "{words}");
    }
}

/// What is only known when particles and kernels are made is known for all cases before the first of them runs.
#[test]
fn a_later_case_that_cannot_run_is_refused_before_the_first() {
    let folder = folder("later");
    std::fs::write(folder.join("good.csv"), "x,mass\n0,1\n1,1\n").unwrap();
    std::fs::write(folder.join("bad.csv"), "x,mass\n0,1\n1,one\n").unwrap();
    let given = |file: &str| format!("initial = [{{ shape = \"file\", path = \"{file}\" }}]\nmollifier.delta = 0.1\n");
    let fixed = ENDLESS.replace("order = 4\n", "order = 4\ndelta = 0.1\n");
    for (case, words) in [
        (given("bad.csv"), "bad.csv:3: mass = \"one\": not a number"),
        (given("none.csv"), "none.csv"),
        ("sampling.h = 1e-11\n".to_owned(), "grid points are too many"),
    ] {
        let scene =
            format!("{fixed}[[case]]\nname = \"first\"\n{}[[case]]\nname = \"second\"\n{case}", given("good.csv"));
        let output = run(&folder, &scene);
        assert!(output.status.code() == Some(1) && errors(&output).contains(words), "{words}: {}", errors(&output));
    }
}

const SHORT: &str = r#"
title = "short"
model = "pks"
dimension = 2
[pks]
chi = 1
mu = 1
mesh = [16, 16]
x = [-2, 2]
y = [-2, 2]
[[initial]]
shape = "bump"
mass = 1
[sampling]
kind = "random"
count = 50
[time]
end = 0.002
dt = 0.001
[output]
snapshots = [0.002]
"#;

#[test]
fn every_case_has_a_folder_within_the_output() {
    let folder = folder("cases");
    let long = "x".repeat(300);
    let names = ["..", "a b", "a/b", "summary.json", "../../up", long.as_str()];
    let cases: String = names.iter().map(|name| format!("[[case]]\nname = \"{name}\"\nseed = 3\n")).collect();
    let out = folder.join("deep/er");
    let scene = written(&folder, &format!("{SHORT}{cases}"));
    succeeded(&mollis(&["run", text(&scene), "--quiet", "--out", text(&out)]).output().unwrap());
    let list = |path: &Path| {
        let mut names: Vec<String> =
            std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(list(&folder), ["deep", "scene.toml"]);
    assert_eq!(list(&folder.join("deep")), ["er"]);
    let folders = ["case", "a_b", "a_b-2", "summary.json-2", "_.._up", &long[..100]];
    let mut expected: Vec<&str> = folders.iter().copied().chain(["summary.json"]).collect();
    expected.sort_unstable();
    assert_eq!(list(&out), expected);
    let summary: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    for ((case, name), folder) in summary["cases"].as_array().unwrap().iter().zip(names).zip(folders) {
        assert_eq!((case["name"].as_str(), case["folder"].as_str()), (Some(name), Some(folder)));
        assert_eq!(list(&out.join(folder)), ["diagnostics.csv", "events.csv", "particles.npy"]);
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_the_run() {
    let folder = folder("unwritable");
    std::fs::create_dir_all(folder.join("out/summary.json")).unwrap();
    let output = run(&folder, &ENDLESS.replace("snapshots = [0, 1]", ""));
    assert!(errors(&output).contains("summary.json: is a folder"), "{}", errors(&output));
    std::fs::remove_dir(folder.join("out/summary.json")).unwrap();
    std::fs::write(folder.join("out/b"), "a file").unwrap();
    let output = run(&folder, &format!("{ENDLESS}[[case]]\nname = \"a\"\n[[case]]\nname = \"b\"\n"));
    assert!(output.status.code() == Some(1) && errors(&output).contains("out/b: "), "{}", errors(&output));
}

/// A case may have any name, and a user's file in the folder any name that the run does not write.
#[test]
fn no_file_or_case_is_in_the_way_of_the_trial() {
    let folder = folder("trial");
    let cases = "[[case]]\nname = \"trial\"\n[[case]]\nname = \"other\"\n";
    let out = folder.join("out");
    for _ in 0..2 {
        succeeded(&run(&folder, &format!("{SHORT}{cases}")));
        assert!(out.join("trial/diagnostics.csv").exists());
    }
    let mine = out.join("other/trial");
    std::fs::write(&mine, "mine").unwrap();
    succeeded(&run(&folder, &format!("{SHORT}{cases}")));
    assert_eq!(std::fs::read_to_string(&mine).unwrap(), "mine");
}

#[test]
fn a_picture_that_fails_costs_no_number() {
    let folder = folder("picture");
    // The name under which the picture is written first is taken by a folder.
    std::fs::create_dir_all(folder.join("out/bad.png.new/full")).unwrap();
    let rest = "[[picture]]\nname = \"bad\"\nkind = \"particles\"\n[[picture]]\nname = \"good\"\nkind = \"density\"\n\
                [[expect]]\nquantity = \"particles\"\nmost = 50\nreason = \"there are 50\"\n";
    let output = run(&folder, &format!("{SHORT}{rest}"));
    assert!(output.status.code() == Some(1) && errors(&output).contains("picture \"bad\": "), "{}", errors(&output));
    let summary = summary(&folder);
    assert_eq!(summary["expectations"][0]["passed"], true);
    assert!(summary["pictures"][0]["error"].as_str().unwrap().contains("bad.png"));
    assert!(summary["pictures"][1]["error"].is_null());
    for file in ["good.png", "good.svg", "diagnostics.csv", "particles.npy"] {
        assert!(folder.join("out").join(file).exists(), "{file}");
    }
}

/// Three points, two of them within a blob of each other.
const POINTS: &str = r#"
title = "points"
dimension = 2
[[kernel]]
kind = "power"
p = 2
[[initial]]
shape = "file"
path = "points.csv"
[time]
end = 1e-9
dt = 1e-9
[output]
density = true
particles = ["csv", "vtk"]
"#;
const MOLLIFIER: &str = "[mollifier]\nkind = \"compact\"\norder = 2\nexponent = 4\ndelta = 0.5\n";

#[test]
fn densities_that_points_lack_are_summed_or_absent() {
    let folder = folder("densities");
    let bare = "x,y,mass\n0,0,2\n0.3,0,1\n5,5,1\n";
    std::fs::write(folder.join("points.csv"), bare).unwrap();
    let (blob, particle) =
        (format!("model = \"blob\"\n{POINTS}{MOLLIFIER}"), format!("model = \"particle\"\n{POINTS}"));
    succeeded(&run(&folder, &blob));
    let (header, rows) = table(&folder.join("out/particles.csv"));
    assert_eq!(header, ["x", "y", "mass", "density"]);
    // Order 2 with exponent M in the plane: psi(r) = (M + 1) / (pi delta^2) (1 - (r/delta)^2)^M. One step of 1e-9 changes it by
    // less than 1e-8 of itself.
    let psi = |r: f64| 5.0 / (std::f64::consts::PI * 0.25) * (1.0 - r * r / 0.25).powi(4);
    for (row, expected) in rows.iter().zip([2.0 * psi(0.0) + psi(0.3), 2.0 * psi(0.3) + psi(0.0), psi(0.0)]) {
        assert!((row[3] / expected - 1.0).abs() < 1e-7, "{} {expected}", row[3]);
    }
    assert!(
        lines(&summary(&folder), "plan")
            .contains(&"density at the start: the sum of the blobs, at all particles".to_owned())
    );
    assert!(
        String::from_utf8_lossy(&std::fs::read(folder.join("out/particles.vtp")).unwrap()).contains("Name=\"density\"")
    );

    // Without a mollifier there is nothing to sum: no column, and the run says why.
    succeeded(&run(&folder, &particle));
    assert_eq!(table(&folder.join("out/particles.csv")).0, ["x", "y", "mass"]);
    assert!(!table(&folder.join("out/diagnostics.csv")).0.contains(&"density_maximum".to_owned()));
    assert!(!String::from_utf8_lossy(&std::fs::read(folder.join("out/particles.vtp")).unwrap()).contains("density"));
    let skipped = lines(&summary(&folder), "skipped");
    assert!(skipped.iter().any(|line| line.contains("some points come without a density")), "{skipped:?}");

    // Given densities are taken, by both methods.
    std::fs::write(folder.join("points.csv"), "x,y,mass,DENSITY,id\n0,0,2,7,1\n0.3,0,1,8,2\n5,5,1,9,3\n").unwrap();
    for scene in [&blob, &particle] {
        succeeded(&run(&folder, scene));
        let (_, rows) = table(&folder.join("out/particles.csv"));
        for (row, expected) in rows.iter().zip([7.0, 8.0, 9.0]) {
            assert!((row[3] / expected - 1.0).abs() < 1e-7, "{} {expected}", row[3]);
        }
        assert!(lines(&summary(&folder), "plan").contains(&"ignored: columns of points.csv: id".to_owned()));
    }

    // Nor does a run have densities that it was not asked to carry.
    succeeded(&run(&folder, &blob.replace("density = true", "")));
    assert_eq!(table(&folder.join("out/particles.csv")).0, ["x", "y", "mass"]);
}

#[test]
fn coalescing_particles_start_on_a_grid_without_its_border() {
    let folder = folder("grid-pks");
    let scene = SHORT
        .replace("shape = \"bump\"\nmass = 1", "shape = \"polynomial\"\nk = 2")
        .replace("kind = \"random\"\ncount = 50", "kind = \"grid\"\nh = 0.25");
    succeeded(&run(&folder, &scene));
    let summary = summary(&folder);
    // 49 points (i, j) / 4 have i^2 + j^2 <= 16; the density is 0 at the four where it is 16.
    assert_eq!(summary["cases"][0]["particles_at_start"], 45);
    assert!(lines(&summary, "skipped").contains(&"4 points of the grid without mass".to_owned()));
    // A mass of 0 in the user's own data is a mistake, not a border.
    std::fs::write(folder.join("points.csv"), "x,y,mass\n0,0,1\n1,0,0\n").unwrap();
    let given = SHORT.replace("shape = \"bump\"\nmass = 1", "shape = \"file\"\npath = \"points.csv\"");
    let output = run(&folder, &given);
    assert!(errors(&output).contains("particle 1 has mass 0: must be above 0"), "{}", errors(&output));
}

#[test]
fn particles_outside_the_mesh_are_told() {
    let folder = folder("outside");
    let points = |points: &str, masses: &str| {
        // Next to no noise, so that they stay where they are.
        SHORT
            .replace("mu = 1", "mu = 1e-9")
            .replace("shape = \"bump\"\nmass = 1", &format!("shape = \"points\"\npoints = {points}\nmasses = {masses}"))
    };
    let output = run(&folder, &points("[[0, 0], [1, 0], [9, 9]]", "[1, 1, 1]"));
    succeeded(&output);
    let told = "outside the mesh, where the field is that of all mass at its centre: 1 particles at most (at time 0), 1 at the end";
    assert!(String::from_utf8_lossy(&output.stdout).contains(told));
    assert!(lines(&summary(&folder), "plan").contains(&told.to_owned()));
    let output = run(&folder, &points("[[0, 0], [1, 0], [1.5, 1.5]]", "[1, 1, 1]"));
    succeeded(&output);
    assert!(!String::from_utf8_lossy(&output.stdout).contains("outside the mesh"));
}

/// A hundred million particles take more than 3 GB; their plan has to do with 2 of address space.
#[test]
#[cfg(target_os = "linux")]
fn the_plan_of_many_particles_samples_few() {
    let folder = folder("plan");
    let plan = |scene: &str| {
        let scene = written(&folder, scene);
        let shell = "ulimit -v 2000000; exec \"$0\" plan \"$1\"";
        let output = std::process::Command::new("sh")
            .args(["-c", shell, env!("CARGO_BIN_EXE_mollis"), text(&scene)])
            .output()
            .unwrap();
        succeeded(&output);
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let random = plan(&SHORT.replace("count = 50", "count = 100000000"));
    assert!(
        random.contains("run: Pks, 100000000 particles in 2D, 2 steps") && random.contains("cost: about"),
        "{random}"
    );
    // The area of the disc over that of a cell.
    let grid = plan(&SHORT.replace("kind = \"random\"\ncount = 50", "kind = \"grid\"\nh = 1e-4"));
    assert!(grid.contains("run: Pks, about 3.14e8 particles"), "{grid}");
    let blob = plan(&ENDLESS.replace("h = 0.02", "h = 1e-8"));
    assert!(blob.contains("run: Blob, about 2.00e8 particles") && blob.contains("velocity: "), "{blob}");
    let few = plan(SHORT);
    assert!(few.contains("run: Pks, 50 particles in 2D"), "{few}");
}

/// In one long step clusters in many places merge, each in its own time.
#[test]
fn coalescences_are_written_in_order_of_time() {
    let folder = folder("events");
    let bumps = "shape = \"bump\"\nmass = \"60 pi\"\ncenter = [-2, 1]\n[[initial]]\nshape = \"bump\"\nmass = \"60 pi\"\ncenter = [2, -1]";
    let scene = SHORT
        .replace("shape = \"bump\"\nmass = 1", bumps)
        .replace("[-2, 2]", "[-4, 4]")
        .replace("count = 50", "count = 3000")
        .replace("end = 0.002\ndt = 0.001", "end = 0.06\ndt = 0.01")
        .replace("snapshots = [0.002]", "snapshots = [0.06]");
    succeeded(&run(&folder, &scene));
    let content = std::fs::read_to_string(folder.join("out/events.csv")).unwrap();
    let times: Vec<f64> =
        content.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(times.len() > 40, "{}", times.len());
    assert!(times.is_sorted());
    assert_eq!(summary(&folder)["cases"][0]["coalescences"], times.len());
}

/// The numbers at the ticks of the particles' count are numbers, and both ends of both axes carry one.
#[test]
fn counts_have_whole_numbers_at_their_ticks() {
    let folder = folder("ticks");
    let rest = "[[picture]]\nname = \"count\"\nkind = \"count\"\n[[picture]]\nname = \"moment\"\nkind = \"moment\"\n";
    succeeded(&run(&folder, &format!("{}{rest}", SHORT.replace("count = 50", "count = 40000"))));
    let texts = |name: &str| -> Vec<String> {
        let svg = std::fs::read_to_string(folder.join("out").join(name)).unwrap();
        svg.split("<text")
            .skip(1)
            .filter_map(|rest| Some(rest.split_once('>')?.1.split_once('<')?.0.trim().to_owned()))
            .collect()
    };
    let found = texts("count.svg");
    for label in ["0", "0.0005", "0.0010", "0.0015", "0.0020", "30000", "40000"] {
        assert!(found.iter().any(|text| text == label), "{label}: {found:?}");
    }
    for text in found.iter().chain(&texts("moment.svg")) {
        assert!(!text.is_empty() && !text.contains('\u{b7}'), "{text}");
    }
}
