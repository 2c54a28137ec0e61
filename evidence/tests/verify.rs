//! `evidence verify` on every reference file, through both interfaces; and that it can fail.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data").join(name)
}

fn verify(arguments: &[&str], file: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mollis-evidence")).arg("verify").args(arguments).arg(file).output().unwrap()
}

fn objects(output: &Output) -> Vec<Value> {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Rows by order, counted without the program's reader.
fn rows_by_order(file: &Path) -> BTreeMap<u64, u64> {
    let text = std::fs::read_to_string(file).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<_> = lines.next().unwrap().split(',').collect();
    let kernels = columns.contains(&"kernel");
    let place = columns.iter().position(|&c| c == if kernels { "psi" } else { "order" }).unwrap();
    let mut count = BTreeMap::new();
    for line in lines {
        let field = line.split(',').nth(place).unwrap();
        // poly4_M9, gauss4: the first digit.
        let order = if kernels { &field[4..].trim_start_matches('s')[..1] } else { field };
        *count.entry(order.parse().unwrap()).or_insert(0) += 1;
    }
    count
}

#[test]
fn every_row_is_within_tolerance_through_both_interfaces() {
    for (name, scalar, quantities) in [
        ("mollifier.csv", "f64", 5),
        ("mollifier_o8.csv", "f64", 5),
        ("mollifier_f32.csv", "f32", 5),
        ("mollifier_f32.csv", "f64", 5),
        ("gaussian.csv", "f64", 5),
        ("gaussian_potential.csv", "f64", 1),
        ("kernels.csv", "f64", 3),
        ("kernels3.csv", "f64", 3),
    ] {
        let file = data(name);
        let expected = rows_by_order(&file);
        for api in ["rust", "c"] {
            let output = verify(&["--api", api, "--scalar", scalar], &file);
            let objects = objects(&output);
            assert!(output.status.success(), "{name} {api} {scalar}: {objects:#?}");
            assert_eq!(objects.len(), quantities * expected.len(), "{name}");
            for object in objects {
                let order = object["order"].as_u64().unwrap();
                assert_eq!((object["rows"].as_u64(), object["skipped"].as_u64()), (Some(expected[&order]), Some(0)));
                assert!(object["max_ulp_of_max"].as_f64().unwrap() <= object["limit"].as_f64().unwrap());
                assert!(object["max_rel_scale"].as_f64().unwrap() < 1e-6 && object["worst"]["r"].is_string());
            }
        }
    }
}

#[test]
fn inputs_that_f32_cannot_hold_are_skipped_and_counted() {
    let file = data("mollifier.csv");
    let output = verify(&["--scalar", "f32"], &file);
    assert!(output.status.success());
    let expected = rows_by_order(&file);
    for object in objects(&output) {
        let (rows, skipped) = (object["rows"].as_u64().unwrap(), object["skipped"].as_u64().unwrap());
        assert_eq!(rows + skipped, expected[&object["order"].as_u64().unwrap()]);
        assert!(rows > 0 && skipped > 0);
    }
}

/// A reference that is wrong by a few units in the last place, and files that are none.
#[test]
fn failures_have_status_one() {
    let folder = std::env::temp_dir().join(format!("mollis-verify-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let header = "dim,order,M,delta,r,B,phi,grad_factor,hess_factor,Bprime_over_r\n";
    let good = "1,2,1,1.0,0.0,0.75,0.1875,0.75,-0.5,-1.5\n";
    assert!(verify(&[], &write("good.csv", &format!("# comment\n{header}{good}"))).status.success());
    let wrong = good.replace(",0.1875,", ",0.1875000000000001,");
    let output = verify(&[], &write("wrong.csv", &format!("{header}{wrong}")));
    assert_eq!(output.status.code(), Some(1));
    let failed: Vec<_> = objects(&output).into_iter().filter(|o| o["passed"] == false).collect();
    assert_eq!(failed.len(), 1);
    assert_eq!(failed[0]["quantity"], "phi");
    assert!(failed[0]["max_ulp"].as_f64().unwrap() > 3.0);
    for (name, text) in [
        ("empty.csv", header.to_owned()),
        ("other.csv", "a,b\n1,2\n".to_owned()),
        ("text.csv", format!("{header}{}", good.replace("0.75", "three"))),
        ("exponent.csv", format!("{header}{}", good.replace("1,2,1,", "1,2,10,"))),
        ("delta.csv", format!("{header}{}", good.replace("1.0", "-1.0"))),
    ] {
        let output = verify(&[], &write(name, &text));
        assert_eq!(output.status.code(), Some(1), "{name}");
        assert!(!output.stderr.is_empty(), "{name}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_documented_table_is_what_the_command_prints() {
    let documented =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/accuracy.csv")).unwrap();
    let mut printed = String::from("file,scalar,dimension,exponent,order,quantity,error\n");
    for (name, scalar) in [
        ("mollifier.csv", "f64"),
        ("mollifier_o8.csv", "f64"),
        ("gaussian.csv", "f64"),
        ("gaussian_potential.csv", "f64"),
        ("mollifier_f32.csv", "f32"),
    ] {
        let output = verify(&["--table", "--scalar", scalar], &data(name));
        printed += std::str::from_utf8(&output.stdout).unwrap();
    }
    assert_eq!(documented, printed, "docs/accuracy.csv is out of date");
}
