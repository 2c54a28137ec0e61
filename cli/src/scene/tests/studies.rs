//! Studies of grids.

use super::{scene, wrong};

#[test]
fn studies_that_cannot_be_compared_are_mistakes() {
    let with = |study: &str, rest: &str| {
        let text = scene("blob", "density = true", &format!("[study]\n{study}\n{rest}"));
        wrong(&text, ": ")
    };
    let expect = |keys: &str| format!("[[expect]]\n{keys}\nmost = 1\nreason = \"r\"\n");
    let good = "h = [0.2, 0.1]\nreference = 0.05";
    assert_eq!(with(good, ""), "good");
    assert_eq!(with("h = [0.3, 0.1]\nreference = 0.1e-1", ""), "good");
    for (study, words) in [
        (
            "h = [0.2, 0.1]\nreference = 0.03",
            "study.reference = 0.03: must divide every study.h two times or more; 0.2 is",
        ),
        (
            "h = [0.2, 0.1]\nreference = 0.1",
            "study.reference = 0.1: must divide every study.h two times or more; 0.1 is 1",
        ),
        ("h = [0.2, 0.1]\nreference = 0.4", "study.reference = 0.4: must divide every"),
        ("h = [0.2, 0.1]\nreference = 0.0333333", "study.reference = 0.0333333: must divide"),
        ("h = [0.1, 0.2]\nreference = 0.05", "study.h: 0.2 after 0.1: must fall"),
        ("h = [0.1, 0.1]\nreference = 0.05", "study.h: 0.1 after 0.1: must fall"),
    ] {
        assert!(with(study, "").starts_with(words), "{study}: {}", with(study, ""));
    }
    let picture = "[[picture]]\nname = \"p\"\nkind = \"convergence\"\n";
    for rest in [
        picture.to_owned(),
        expect("quantity = \"rate_density\"\nat = 0.1"),
        expect("quantity = \"rate_positions\""),
        expect("quantity = \"error_density\"\nat = 0.2"),
    ] {
        assert_eq!(with(good, &rest), "good", "{rest}");
        assert!(with("h = [0.2, 0.1]", &rest).contains("no exact solution of this scene is known"), "{rest}");
    }
    for (keys, words) in [
        ("quantity = \"rate_positions\"\nat = 0.2", "the coarsest spacing has no rate"),
        ("quantity = \"rate_positions\"\nat = 0.15", "the study has no such spacing"),
        ("quantity = \"rate_positions\"\nat = 0.1\nto = 0.2", "not used beside at"),
        ("quantity = \"rate_positions\"\nfrom = 0.2\nto = 0.1", "is above to"),
        ("quantity = \"rate_positions\"\nto = 0.15", "1 of the study's spacings"),
        ("quantity = \"error_positions\"\nat = 0.15", "there is no run of this spacing"),
    ] {
        let found = with(good, &expect(keys));
        assert!(found.contains(words), "{keys}: {found}");
    }
    let found = with(good, &format!("{picture}x = [0, 1]\n"));
    assert!(found.contains("picture[0].x") || found.contains("must be above 0"), "{found}");
    let points = scene("blob", "", &format!("[study]\n{good}\n"))
        .replace("shape = \"disc\"", "shape = \"file\"\npath = \"dense\"");
    assert!(wrong(&points, ": ").contains("needs densities on grids, not points"));
}
