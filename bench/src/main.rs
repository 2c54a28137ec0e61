//! `mollis-bench`: run time and error, compared with other programs measured in the same run.

mod codes;
mod count;
mod field;
mod fmm;
mod peers;
mod pks;
mod scene;
mod skips;
mod work;

use clap::{Parser, Subcommand};

/// Run time and error, compared with other programs measured in the same run.
#[derive(Debug, Parser)]
#[command(name = "mollis-bench")]
struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Sums over sources.
    Field(field::Field),
    /// The fast multipole method beside FMM2D.
    Fmm2d(fmm::Fmm),
    /// The same in space, beside FMM3D.
    Fmm3d(fmm::Fmm),
    /// One sub-step of the Patlak-Keller-Segel particles on a mesh.
    Pks(pks::Pks),
    /// Sums as particle codes have them, through the C ABI, beside plain loops.
    Codes,
    /// Fixed cases whose instructions are counted (`cargo xtask counts`).
    Count(count::Count),
    /// Run time against error, as pictures and a page (`cargo xtask bench`).
    Work(work::Work),
    /// Sums without pairs: moments, and one sort in one dimension.
    Skips,
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().what {
        What::Field(field) => field.run(),
        What::Fmm2d(fmm) => fmm.run::<2>(),
        What::Fmm3d(fmm) => fmm.run::<3>(),
        What::Pks(pks) => pks.run(),
        What::Codes => codes::run(),
        What::Count(count) => count.run(),
        What::Work(work) => work.run(),
        What::Skips => skips::run(),
    }
}
