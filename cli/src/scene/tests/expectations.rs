//! Expectations that a run can meet, and those that it cannot.

use super::{scene, wrong};

/// What is wrong with one expectation.
fn expect(model: &str, output: &str, keys: &str) -> String {
    let bound = if ["least", "most", "value"].iter().any(|key| keys.contains(key)) { "" } else { "most = 1" };
    let text = scene(model, output, &format!("[[expect]]\n{keys}\n{bound}\nreason = \"r\"\n"));
    wrong(&text, "expect[0]")
}

#[test]
fn expectations_that_a_run_cannot_meet_are_mistakes() {
    for (model, output, keys) in [
        ("line", "density = true", "quantity = \"error_density\""),
        ("line", "", "quantity = \"error_positions\"\nat = 0.04"),
        ("blob", "", "quantity = \"second_moment\"\nat = 0.3"),
        ("blob", "every = 0.04", "quantity = \"second_moment\"\nat = 0.5"),
        ("blob", "", "quantity = \"slope\"\nfrom = 0.4\nto = 0.5"),
        ("blob", "", "quantity = \"slope_error\"\nfrom = 0.3"),
        ("blob", "energy = true", "quantity = \"energy_rise\""),
        ("blob", "energy = true", "quantity = \"energy_drift\""),
        ("blob", "density = true", "quantity = \"density_maximum\"\nat = 0"),
        ("particle", "density = true", "quantity = \"density_maximum\""),
        ("pks", "", "quantity = \"heavy_mass\""),
        ("pks", "", "quantity = \"merges\"\nleast = 3\nmost = 3"),
        ("species", "", "quantity = \"part_slope\"\npart = 1"),
        ("cluster", "", "quantity = \"approximation_ratio\"\nat = 0.1"),
        ("profile", "", "quantity = \"density_at_zero\""),
    ] {
        let output = if output.contains("every") { "" } else { output };
        assert_eq!(expect(model, output, keys), "good", "{model} {keys}");
    }
    for (model, output, keys, words) in [
        ("blob", "", "quantity = \"clusters\"\nleast = 3\nmost = 2", ": no number is at least 3 and at most 2"),
        (
            "blob",
            "",
            "quantity = \"clusters\"\nvalue = 3\nband = 1\nmost = 1",
            ": no number is at least 2 and at most 1",
        ),
        ("blob", "", "quantity = \"clusters\"\nvalue = 3\nband = 1\nrelative = 1", ".relative: not used beside band"),
        ("blob", "", "quantity = \"slope\"\nfrom = 0.4\nto = 0.2", ".from = 0.4: is above to = 0.2"),
        ("blob", "", "quantity = \"slope\"\nfrom = 0.2\nto = 0.6", ".to = 0.6: is beyond time.end = 0.5"),
        ("blob", "", "quantity = \"slope\"\nfrom = 0.7", ".from = 0.7: is beyond time.end = 0.5"),
        (
            "blob",
            "",
            "quantity = \"decay_rate\"\nfrom = 0.2\nto = 0.29",
            ".to = 0.29: there are 1 rows of diagnostics from 0.2 to 0.29",
        ),
        ("blob", "", "quantity = \"slope_error\"\nfrom = 0.4", ".from = 0.4: there are 2 rows"),
        ("blob", "", "quantity = \"slope\"\nat = 0.4", ".at: not used with expect[0].quantity = \"slope\""),
        ("blob", "", "quantity = \"slope\"\npart = 1", ".part: not used with expect[0].quantity = \"slope\""),
        ("blob", "", "quantity = \"clusters\"\nat = 0.4", ".at: not used with"),
        ("blob", "", "quantity = \"second_moment\"\nfrom = 0.4", ".from: not used with"),
        ("blob", "", "quantity = \"second_moment\"\nat = 0.6", ".at = 0.6: is beyond time.end = 0.5"),
        ("pks", "", "quantity = \"heavy_mass\"\nat = 7", ".at = 7: is beyond time.end = 0.5"),
        (
            "pks",
            "",
            "quantity = \"particles\"\nat = 0.25",
            ".at = 0.25: no row of diagnostics is of this time; rows are 0.1 apart",
        ),
        ("blob", "", "quantity = \"particles\"", ".quantity = \"particles\": the run has no particles"),
        ("blob", "", "quantity = \"merges\"", ".quantity = \"merges\": the run has no particles"),
        ("blob", "", "quantity = \"heavy_mass\"", ".quantity = \"heavy_mass\": the run has no heaviest"),
        (
            "blob",
            "",
            "quantity = \"energy_rise\"",
            ".quantity = \"energy_rise\": the run has no energy (output.energy is not set)",
        ),
        (
            "blob",
            "",
            "quantity = \"rotation_rate\"",
            ".quantity = \"rotation_rate\": the run has no axis_angle (combination has no turned gradient)",
        ),
        ("pks", "", "quantity = \"energy_rise\"", ".quantity = \"energy_rise\": the run has no energy"),
        (
            "blob",
            "",
            "quantity = \"density_maximum\"",
            ".quantity = \"density_maximum\": the run has no density_maximum (output.density is not set)",
        ),
        ("pks", "", "quantity = \"part_slope\"", ".quantity = \"part_slope\": the run has no part_moment_0"),
        (
            "species",
            "",
            "quantity = \"part_slope\"\npart = 2",
            ".quantity = \"part_slope\": the run has no part_moment_2",
        ),
        ("blob", "", "quantity = \"density_at_zero\"", ".quantity = \"density_at_zero\": the run has no potential"),
        ("profile", "", "quantity = \"slope\"", ".quantity = \"slope\": the run has no second_moment"),
        (
            "profile",
            "",
            "quantity = \"mean_radius\"",
            ".quantity = \"mean_radius\": needs a model in which something moves",
        ),
        ("cluster", "", "quantity = \"centre_drift\"", ".quantity = \"centre_drift\": the run has no centre_x"),
        (
            "pks",
            "",
            "quantity = \"approximation_ratio\"",
            ".quantity = \"approximation_ratio\": the run has no error_plain",
        ),
        ("blob", "", "quantity = \"error_positions\"", ".quantity = \"error_positions\": no exact solution"),
        (
            "line",
            "",
            "quantity = \"error_positions\"\nat = 0.02",
            ".at = 0.02: there is no run of this spacing; there are [0.04]",
        ),
        (
            "line",
            "",
            "quantity = \"error_density\"",
            ".quantity = \"error_density\": the run carries no density: output.density is not set",
        ),
        ("line", "", "quantity = \"rate_positions\"", ".quantity = \"rate_positions\": needs a study"),
        ("pks", "", "quantity = \"rate_positions\"", ".quantity = \"rate_positions\": not of this model"),
    ] {
        let found = expect(model, output, keys);
        assert!(found.starts_with(words), "{model} {keys}: {found}");
    }
    let late = scene("line", "", "[[expect]]\nquantity = \"error_positions\"\nmost = 1\nreason = \"r\"\n");
    assert!(wrong(&late.replace("end = 0.5", "end = 1"), "expect[0]").contains("the exact solution blows up at t = 1"));
    let infinite = scene("pks", "", "[[expect]]\nquantity = \"heavy_mass\"\nmost = 1\nreason = \"r\"\n");
    assert!(wrong(&infinite.replace("chi = 1", "chi = 0"), "expect[0]").contains("infinite for pks.chi = 0"));
}
