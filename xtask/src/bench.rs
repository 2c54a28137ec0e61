//! Measures run time against error and writes the page `bench/results/README.md`.

use std::path::PathBuf;

use anyhow::Result;

use crate::{python, shell};

/// Spacings of the lattices on which the peer in NumPy solves the paper's problem.
const SPACINGS: [&str; 6] =
    ["0.1", "0.07071067811865475", "0.05", "0.035355339059327376", "0.025", "0.017677669529663688"];

/// What to measure.
#[derive(clap::Args)]
pub struct Args {
    /// libfmm2d.so, built for one thread (`make lib OMP=OFF`): a peer of the sums in the plane.
    #[arg(long)]
    fmm2d: Option<PathBuf>,
    /// Small sizes, into `target/xtask/bench/results`: whether it works, not what it measures.
    #[arg(long)]
    quick: bool,
    /// Studies; all if none is named.
    studies: Vec<String>,
}

/// Measures, in the order of the page.
pub fn run(args: &Args) -> Result<()> {
    shell::run(shell::cargo().args(["build", "--quiet", "--release", "-p", "mollis-bench"]))?;
    let folder = shell::scratch("bench")?.canonicalize()?;
    let mut bench = shell::program(shell::target().join("release/mollis-bench"));
    bench.arg("work").args(&args.studies);
    if args.studies.is_empty() || args.studies.iter().any(|study| study == "blob") {
        let environment = python::environment(&folder, &["numpy", "scipy"])?;
        for kernel in ["exact", "table"] {
            let mut peer = shell::program(environment.join("bin/python"));
            peer.arg(shell::root().join("bench/peers/numpy_blob.py")).args(["--rtol", "1e-9", "--atol", "1e-10"]);
            peer.args(["--kernel", kernel, "--h"]).args(&SPACINGS[..if args.quick { 2 } else { SPACINGS.len() }]);
            let file = folder.join(kernel).with_extension("json");
            std::fs::write(&file, shell::output(&mut peer)?)?;
            bench.arg("--numpy").arg(file);
        }
    }
    if let Some(library) = &args.fmm2d {
        bench.arg("--fmm2d").arg(library);
    }
    if args.quick {
        bench.arg("--quick").arg("--out").arg(folder.join("results"));
    } else {
        bench.arg("--out").arg(shell::root().join("bench/results"));
    }
    shell::run(&mut bench)
}
