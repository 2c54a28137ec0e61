//! Initial data and what is recorded of them.

use super::{parse, scene, wrong};

#[test]
fn data_that_a_model_cannot_take_are_mistakes() {
    let of = |model: &str, from: &str, to: &str| {
        let text = scene(model, "", "");
        assert!(text.contains(from), "{from}");
        wrong(&text.replacen(from, to, 1), ": ")
    };
    assert!(of("cluster", "[1, 1, 1]", "[1, 0, 1]").starts_with("initial[0].masses[1] = 0: must be above 0"));
    let four = of(
        "cluster",
        "points = [[0, 0], [1, 0], [0, 1]]\nmasses = [1, 1, 1]",
        "points = [[0, 0], [1, 1]]\nmasses = [1, 1]",
    );
    assert_eq!(four, "initial: 2 points: model = \"cluster\" needs three");
    assert!(of("pks", "mu = 1", "mu = 0\nheavy = 1").starts_with("pks.heavy: is in critical masses"));
    assert!(of("pks", "end = 0.5\ndt = 0.01", "end = 1e-12\ndt = 0.1").starts_with("time.dt = 0.1: time.end"));
    assert!(
        of("pks", "shape = \"bump\"", "shape = \"file\"\npath = \"none.csv\"")
            .starts_with("initial[0].path: no such file")
    );
}

/// Points without densities: the blob method sums its blobs, the particle method has none to sum.
#[test]
fn densities_of_points_are_carried_where_there_are_some() {
    let lacks = |model: &str, file: &str| {
        let text = scene(model, "density = true", "")
            .replace("shape = \"disc\"", &format!("shape = \"file\"\npath = \"{file}\""));
        let file = parse(&text, false).unwrap();
        (file.cases[0].lacks_density().is_some(), file.cases[0].has_column("density_maximum"))
    };
    assert_eq!((lacks("blob", "dense"), lacks("blob", "bare")), ((false, true), (false, true)));
    assert_eq!((lacks("particle", "dense"), lacks("particle", "bare")), ((false, true), (true, false)));
}

#[test]
fn rows_are_counted_as_they_are_written() {
    let file = parse(&scene("blob", "", "").replace("every = 0.1", "every = 0.04"), false).unwrap();
    let case = &file.cases[0];
    let times: Vec<f64> =
        (0..=case.steps).filter(|&step| case.has_row(step)).map(|step| step as f64 * case.dt).collect();
    // 0, 0.04 ... 0.48, and the end.
    assert_eq!(times.len(), 14);
    for from in 0..60 {
        for to in from..60 {
            let (from, to) = (f64::from(from) * 0.01, f64::from(to) * 0.01);
            let counted = times.iter().filter(|&&t| t > from - 1e-8 && t < to + 1e-8).count() as u64;
            assert_eq!(case.rows_between(from, to), counted, "{from} {to}");
        }
    }
}
