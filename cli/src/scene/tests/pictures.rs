//! Pictures that a run can give, and those that it cannot.

use super::{mistakes, scene, wrong};

const SNAPSHOTS: &str = "snapshots = [0, 0.2, 0.5]";

/// What is wrong with one picture of a scene, without its place.
fn picture(model: &str, output: &str, keys: &str) -> String {
    let text = scene(model, output, &format!("[[picture]]\nname = \"p\"\n{keys}\n"));
    wrong(&text, "picture[0].")
}

#[test]
fn pictures_that_a_run_cannot_give_are_mistakes() {
    for (model, output, keys) in [
        ("line", "trajectories = 3", "kind = \"trajectories\"\nexact = true"),
        ("blob", "trajectories = 3", "kind = \"trajectories\"\nplane = \"xyt\""),
        ("blob", "trajectories = 3", "kind = \"trajectories\"\nplane = \"xt\""),
        ("line", "density = true\nsnapshots = [0.2]", "kind = \"density\"\nexact = true\ntimes = [0.2]"),
        ("blob", SNAPSHOTS, "kind = \"density\"\ntimes = [0.5, 0]"),
        ("pks", SNAPSHOTS, "kind = \"density\""),
        ("pks", SNAPSHOTS, "kind = \"field\"\ntimes = [0.2]"),
        ("pks", SNAPSHOTS, "kind = \"particles\""),
        ("particle", SNAPSHOTS, "kind = \"particles\""),
        ("pks", "", "kind = \"count\"\ny = [1, 100]"),
        ("species", "", "kind = \"moment\"\nparts = true"),
        ("blob", "", "kind = \"moment\"\nslope = [{ value = 1, at = 0.5 }]"),
        ("profile", "", "kind = \"profile\"\nquantity = \"potential\""),
        ("cluster", "trajectories = 3", "kind = \"trajectories\""),
    ] {
        assert_eq!(picture(model, output, keys), "good", "{model} {keys}");
    }
    for (model, output, keys, words) in [
        ("line", SNAPSHOTS, "kind = \"particles\"", "kind = \"particles\": needs two dimensions"),
        ("blob", "", "kind = \"trajectories\"", "kind = \"trajectories\": needs output.trajectories above 0"),
        ("line", "trajectories = 3", "kind = \"trajectories\"\nplane = \"xy\"", "plane = \"xy\": needs two dimensions"),
        (
            "line",
            "trajectories = 3",
            "kind = \"trajectories\"\nplane = \"xyt\"",
            "plane = \"xyt\": needs two dimensions",
        ),
        (
            "blob",
            "trajectories = 3",
            "kind = \"trajectories\"\nexact = true",
            "exact = true: exact paths are drawn in the plane xt",
        ),
        (
            "blob",
            "trajectories = 3",
            "kind = \"trajectories\"\nplane = \"xt\"\nexact = true",
            "exact = true: no exact solution",
        ),
        ("profile", "", "kind = \"trajectories\"", "kind = \"trajectories\": needs a model in which something moves"),
        ("profile", "", "kind = \"moment\"", "kind = \"moment\": needs a model in which something moves"),
        ("line", "density = true", "kind = \"density\"", "kind = \"density\": needs output.snapshots"),
        (
            "line",
            SNAPSHOTS,
            "kind = \"density\"",
            "kind = \"density\": the run carries no density: output.density is not set",
        ),
        ("particle", SNAPSHOTS, "kind = \"density\"", "kind = \"density\": needs one or two dimensions"),
        ("blob", SNAPSHOTS, "kind = \"density\"\nexact = true", "exact = true: densities are compared"),
        (
            "blob",
            SNAPSHOTS,
            "kind = \"density\"\ntimes = [0.2, 0.3]",
            "times = [0.2, 0.3]: there is no snapshot at 0.3",
        ),
        ("blob", SNAPSHOTS, "kind = \"density\"\ntimes = [0.205]", "times = [0.205]: there is no snapshot at 0.205"),
        ("blob", SNAPSHOTS, "kind = \"particles\"\ntimes = [2]", "times = [2]: there is no snapshot at 2"),
        ("pks", "", "kind = \"field\"", "kind = \"field\": needs output.snapshots"),
        ("blob", SNAPSHOTS, "kind = \"field\"", "kind = \"field\": needs model = \"pks\""),
        ("cluster", SNAPSHOTS, "kind = \"field\"", "kind = \"field\": needs model = \"pks\""),
        ("blob", "", "kind = \"count\"", "kind = \"count\": needs model = \"pks\""),
        ("cluster", "", "kind = \"count\"", "kind = \"count\": needs model = \"pks\""),
        ("pks", "", "kind = \"count\"\ny = [0, 100]", "y = [0, 100]: must be above 0 on a logarithmic axis"),
        ("blob", "", "kind = \"convergence\"", "kind = \"convergence\": needs a study"),
        ("blob", "", "kind = \"profile\"", "kind = \"profile\": needs model = \"profile\""),
        (
            "profile",
            "",
            "kind = \"profile\"\nquantity = \"positions\"",
            "quantity = \"positions\": must be density or potential",
        ),
        ("pks", "", "kind = \"moment\"\nparts = true", "parts = true: needs model = \"pks\" with several parts"),
        ("blob", "", "kind = \"moment\"\nparts = true", "parts = true: needs model = \"pks\" with several parts"),
        (
            "blob",
            "",
            "kind = \"moment\"\nslope = [{ value = 1, at = 0.6 }]",
            "slope = [{ ... }]: slope[0].at = 0.6 is beyond time.end = 0.5",
        ),
        ("blob", "", "kind = \"moment\"\nexact = true", "exact: not used with picture[0].kind = \"moment\""),
    ] {
        let found = picture(model, output, keys);
        assert!(found.starts_with(words), "{model} {keys}: {found}");
    }
    let many: Vec<String> = (0..=50).map(|step| format!("{}", f64::from(step) / 100.0)).collect();
    let many = format!("snapshots = [{}, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1]", many.join(", "));
    assert!(picture("pks", &many, "kind = \"density\"").contains("61 panels; at most 60"));
    let long = "x".repeat(200);
    for name in ["", "a b", "../p", long.as_str(), "nul"] {
        let text = scene("pks", "", &format!("[[picture]]\nname = \"{name}\"\nkind = \"count\"\n"));
        assert!(mistakes(&text)[0].contains(&format!("picture[0].name = \"{name}\": must be")), "{name}");
    }
    let text =
        scene("pks", "", "[[picture]]\nname = \"a\"\nkind = \"count\"\n[[picture]]\nname = \"A\"\nkind = \"count\"\n");
    assert!(mistakes(&text)[0].contains("must be unique"));
}
