//! Keys, their values, and what is said of a wrong one.

use super::{mistakes, parse};
use crate::scene::Sampling;

pub const GOOD: &str = r#"
title = "A bump"
model = "blob"
dimension = 2
[[kernel]]
kind = "newtonian"
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
h = 0.1
[time]
end = 0.5
dt = 0.025
[output]
trajectories = 5
[[picture]]
name = "paths"
kind = "trajectories"
[quick]
sampling.h = 0.2
"#;

fn changed(from: &str, to: &str) -> Vec<String> {
    assert!(GOOD.contains(from), "{from}");
    mistakes(&GOOD.replacen(from, to, 1))
}

#[test]
fn a_good_scene_is_read() {
    let file = parse(GOOD, false).unwrap();
    let scene = &file.cases[0];
    assert_eq!((scene.dimension, scene.kernel.len(), scene.sampling), (2, 2, Some(Sampling::Grid { h: 0.1 })));
    assert_eq!(parse(GOOD, true).unwrap().cases[0].sampling, Some(Sampling::Grid { h: 0.2 }));
}

#[test]
fn mistakes_name_line_key_and_what_is_allowed() {
    assert_eq!(changed("p = 3", "p = -3"), ["9: kernel[1].p = -3: must be above 1 - d = -1"]);
    assert_eq!(changed("k = 2", "k = 2\nq = 1").len(), 1);
    assert!(
        changed("k = 2", "k = 2\nq = 1")[0]
            .starts_with("16: initial[0].q: unknown key; allowed here: shape, k, radius")
    );
    assert!(
        changed("k = 2", "path = \"x\"").iter().any(|m| m.contains("not used with initial[0].shape = \"polynomial\""))
    );
    assert!(changed("k = 2", "").iter().any(|m| m.starts_with("13: initial[0].k: missing")));
    assert_eq!(changed("h = 0.1", "h = 0"), ["18: sampling.h = 0: must be above 0"]);
    assert_eq!(changed("h = 0.1", "h = nan"), ["18: sampling.h = NaN: must be above 0"]);
    assert_eq!(changed("order = 4", "order = 5"), ["12: mollifier.order = 5: must be 2, 4, 6 or 8"]);
    assert_eq!(
        changed("dt = 0.025", "dt = 0.03"),
        ["21: time.dt = 0.03: time.end = 0.5 must be a whole number of steps"]
    );
    assert_eq!(
        changed("\"newtonian\"", "\"newton\"")[0],
        "6: kernel[0].kind = \"newton\": must be one of newtonian, power, exponential, screened"
    );
    assert_eq!(changed("dimension = 2", "dimension = 4"), ["4: dimension = 4: must be a whole number from 1 to 3"]);
    assert_eq!(changed("[time]", "[tyme]").len(), 2);
    assert!(changed("title = \"A bump\"", "title = \"A bump").iter().all(|m| m.starts_with("2: not TOML")));
}

#[test]
fn combinations_are_two_numbers_of_the_plane() {
    let with = |value: &str| GOOD.replace("dimension = 2\n", &format!("dimension = 2\ncombination = {value}\n"));
    assert_eq!(parse(GOOD, false).unwrap().cases[0].combination, [1.0, 0.0]);
    assert_eq!(parse(&with("[0, -1]"), false).unwrap().cases[0].combination, [0.0, -1.0]);
    assert_eq!(mistakes(&with("[1, 2, 3]")), ["5: combination = [1, 2, 3]: must be a list of two numbers"]);
    assert_eq!(mistakes(&with("1")), ["5: combination = 1: must be a list of two numbers"]);
    assert_eq!(mistakes(&with("[1, inf]")), ["5: combination[1] = inf: must be finite"]);
    for dimension in [1, 3] {
        let text = GOOD.replace("dimension = 2\n", &format!("dimension = {dimension}\ncombination = [0, 1]\n"));
        assert_eq!(mistakes(&text), ["5: combination = [0.0, 1.0]: only in two dimensions; else [1, 0]"]);
        // The default may be named.
        assert_eq!(mistakes(&text.replace("[0, 1]", "[1, 0]")), [""; 0]);
    }
    let profile = with("[0, 1]").replace("\"blob\"", "\"profile\"");
    assert!(mistakes(&profile).iter().any(|m| m.contains("combination: not used with model = \"profile\"")));
}

#[test]
fn gaussians_have_few_orders() {
    let text = GOOD.replace("\"compact\"", "\"gaussian\"").replace("order = 4", "order = 8");
    assert_eq!(mistakes(&text), ["12: mollifier.order = 8: a gaussian has order 2, 4 or 6"]);
}

#[test]
fn richardson_combinations_are_of_order_4_and_more_and_not_of_diffusion() {
    let text = GOOD.replace("\"compact\"", "\"richardson\"");
    assert_eq!(mistakes(&text), [""; 0]);
    assert_eq!(
        mistakes(&text.replace("order = 4", "order = 2")),
        ["12: mollifier.order = 2: a combination has order 4, 6 or 8"]
    );
    let blobs = "[diffusion]\nexponent = 2\n[diffusion.mollifier]\nkind = \"richardson\"\norder = 4\n";
    let expected = "diffusion.mollifier.kind = \"richardson\": not of diffusion";
    assert!(mistakes(&format!("{GOOD}{blobs}")).iter().any(|m| m.contains(expected)));
}
