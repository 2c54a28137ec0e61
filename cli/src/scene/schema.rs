//! Every key that a scene file may hold, stated once: the reader checks against this table and `mollis scene --schema`
//! prints it, so the two can't disagree.

use std::fmt::Write as _;

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number in a range, or text in multiples of pi.
    Number(Range),
    /// A whole number from .. to ..
    Count(u64, u64),
    /// Any text.
    Text,
    /// One of these texts.
    Choice(&'static [&'static str]),
    /// A list of some of these texts.
    Choices(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// A list of numbers in a range.
    Numbers(Range),
    /// As many numbers as the scene has dimensions.
    Vector(Range),
    /// Two numbers in a range.
    Pair(Range),
    /// A list of points, each as many numbers as the scene has dimensions.
    Points,
    /// Two numbers, the first below the second.
    Interval,
    /// This many whole numbers in a range.
    Counts(usize, u64, u64),
    /// A table with these keys.
    Table(&'static [Field]),
    /// A list of tables with these keys.
    Tables(&'static [Field]),
    /// A part of a scene that is laid over the whole one.
    Overlay,
    /// A list of those, each with a `name` and perhaps its own `quick`.
    Overlays,
}

/// The values that a number may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Any finite number.
    Any,
    /// Above 0.
    Positive,
    /// 0 or more.
    NonNegative,
    /// Above .. and below ..
    Open(f64, f64),
}

impl Range {
    /// Whether `number` lies in the range.
    pub fn holds(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Range::Any => true,
                Range::Positive => number > 0.0,
                Range::NonNegative => number >= 0.0,
                Range::Open(low, high) => number > low && number < high,
            }
    }

    /// The range in words: "must be ...".
    pub fn words(self) -> String {
        match self {
            Range::Any => "must be finite".to_owned(),
            Range::Positive => "must be above 0".to_owned(),
            Range::NonNegative => "must be 0 or more".to_owned(),
            Range::Open(low, high) => format!("must be above {low} and below {high}"),
        }
    }
}

/// Whether a key must stand, and what holds when it does not.
#[derive(Clone, Copy, Debug)]
pub enum Need {
    /// It must stand.
    Required,
    /// What holds when it is absent.
    Otherwise(&'static str),
}

/// One key.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Its name.
    pub key: &'static str,
    /// What it holds.
    pub kind: Kind,
    /// Its unit; empty for a pure number or text.
    pub unit: &'static str,
    /// Whether it must stand.
    pub need: Need,
    /// The key beside it whose value decides whether this one is used, and the values for which it is.
    pub when: Option<(&'static str, &'static [&'static str])>,
    /// What it means.
    pub doc: &'static str,
}

const fn field(key: &'static str, kind: Kind, unit: &'static str, need: Need, doc: &'static str) -> Field {
    Field { key, kind, unit, need, when: None, doc }
}

const fn only(when: (&'static str, &'static [&'static str]), field: Field) -> Field {
    Field { when: Some(when), ..field }
}

use Kind::{
    Choice, Choices, Count, Counts, Flag, Interval, Number, Numbers, Overlay, Overlays, Pair, Points, Table, Tables,
    Text, Vector,
};
use Need::{Otherwise, Required};
use Range::{Any, NonNegative, Open, Positive};

/// The models.
pub const MODELS: &[&str] = &["blob", "particle", "pks", "cluster", "profile"];
const DETERMINISTIC: &[&str] = &["blob", "particle"];
const MOVING: &[&str] = &["blob", "particle", "pks", "cluster"];
const STOCHASTIC: &[&str] = &["pks", "cluster"];

/// The whole scene.
pub const SCENE: &[Field] = &[
    field("title", Text, "", Required, "what the scene shows"),
    field("source", Text, "", Otherwise("none"), "paper and figure"),
    field("note", Text, "", Otherwise("none"), "anything a reader of the gallery should know"),
    field(
        "model",
        Choice(MODELS),
        "",
        Required,
        "blob: aggregation equation with a mollified kernel; particle: the same without mollifier; pks: coalescing Patlak-Keller-Segel particles; cluster: second moment of two particles near a third; profile: curves of a mollifier, nothing moves",
    ),
    field("dimension", Count(1, 3), "", Required, "dimensions of space; pks and cluster are planar"),
    field("seed", Count(0, 1 << 53), "", Otherwise("1"), "of all random numbers; --seed overrides it"),
    only(
        ("model", DETERMINISTIC),
        field(
            "kernel",
            Tables(KERNEL),
            "",
            Required,
            "terms of the kernel K, which are added; velocity = -grad K * rho, or what `combination` makes of it",
        ),
    ),
    only(
        ("model", DETERMINISTIC),
        field(
            "combination",
            Pair(Any),
            "",
            Otherwise("[1, 0]"),
            "[a, b], in two dimensions: velocity = -(a grad u + b (grad u turned by +90 degrees)) with u = K * rho; [0, -1] with a newtonian kernel moves vortices, whose circulations are the masses",
        ),
    ),
    only(
        ("model", DETERMINISTIC),
        field(
            "diffusion",
            Table(DIFFUSION),
            "",
            Otherwise("none"),
            "rho_t = coefficient Laplacian(rho^exponent) besides, by blobs; a kernel of coefficient 0 leaves it alone",
        ),
    ),
    only(
        ("model", &["blob", "profile"]),
        field("mollifier", Table(MOLLIFIER), "", Required, "what the kernel is softened with"),
    ),
    only(
        ("model", MOVING),
        field(
            "initial",
            Tables(INITIAL),
            "",
            Required,
            "parts of the initial density, which are added; in pks one part fills one share of the particles",
        ),
    ),
    only(
        ("model", MOVING),
        field(
            "sampling",
            Table(SAMPLING),
            "",
            Otherwise("none (points and files need none)"),
            "how the density becomes particles",
        ),
    ),
    only(("model", MOVING), field("time", Table(TIME), "", Required, "how long and in what steps")),
    only(
        ("model", DETERMINISTIC),
        field("method", Table(METHOD), "", Otherwise("automatic"), "how sums over particles are evaluated"),
    ),
    only(("model", STOCHASTIC), field("pks", Table(PKS), "", Required, "Patlak-Keller-Segel parameters")),
    only(
        ("model", DETERMINISTIC),
        field("study", Table(STUDY), "", Otherwise("one run"), "repeat the run on finer and finer grids"),
    ),
    only(
        ("model", MOVING),
        field(
            "output",
            Table(OUTPUT),
            "",
            Otherwise("diagnostics and summary only"),
            "what is recorded and written; what is not asked for is not computed",
        ),
    ),
    field("picture", Tables(PICTURE), "", Otherwise("none"), "pictures, each written as PNG and SVG"),
    field(
        "expect",
        Tables(EXPECT),
        "",
        Otherwise("none"),
        "numbers that the run must meet; one that it doesn't makes the run fail",
    ),
    field(
        "case",
        Overlays,
        "",
        Otherwise("the scene itself"),
        "variants: each has a `name`, and any keys of the scene to be replaced for it",
    ),
    field("quick", Overlay, "", Otherwise("the same size"), "keys to be replaced under --quick"),
];

const KERNEL: &[Field] = &[
    field(
        "kind",
        Choice(&["newtonian", "power", "exponential", "screened"]),
        "",
        Required,
        "newtonian: |x|/2, log|x|/(2 pi), -1/(4 pi |x|); power: |x|^p/p, p = 0 is log|x|; exponential: e^(-|x|/length), half of a Morse potential; screened: (Laplacian - k^2) K = Dirac",
    ),
    field("coefficient", Number(Any), "", Otherwise("1"), "factor of the term; with newtonian, -1 repels"),
    only(("kind", &["power"]), field("p", Number(Any), "", Required, "exponent, above 1 - dimension")),
    only(("kind", &["exponential"]), field("length", Number(Positive), "length", Required, "decay length")),
    only(("kind", &["screened"]), field("k", Number(Positive), "1/length", Required, "inverse screening length")),
];

const DIFFUSION: &[Field] = &[
    field("coefficient", Number(Positive), "length^(2+d(m-1))/time/mass^(m-1)", Otherwise("1"), "nu"),
    field("exponent", Number(Any), "", Otherwise("1"), "m, 1 or more: 1 is the heat equation, above 1 a porous medium"),
    field(
        "mollifier",
        Table(MOLLIFIER),
        "",
        Required,
        "the blobs: of order 2, or m is a whole number from 2 to 64; a compact one of exponent 2 or more",
    ),
];

const MOLLIFIER: &[Field] = &[
    field(
        "kind",
        Choice(&["compact", "gaussian", "richardson"]),
        "",
        Required,
        "compact: polynomial (1 - r^2)^M ... in the ball of radius delta; gaussian: sums of Gaussians of width delta; richardson: order / 2 compact ones of order 2, of the radii delta j / (order / 2)",
    ),
    field("order", Count(2, 8), "", Required, "2, 4, 6 or 8 (gaussian: 2, 4 or 6; richardson: 4, 6 or 8)"),
    only(("kind", &["compact", "richardson"]), field("exponent", Count(1, 9), "", Otherwise("4"), "M")),
    field(
        "delta",
        Number(Positive),
        "length",
        Otherwise("from `scale`"),
        "radius of the ball or width of the Gaussian",
    ),
    field("scale", Number(Positive), "", Otherwise("1"), "delta = scale h^power, when `delta` is absent"),
    field("power", Number(Open(0.0, 2.0)), "", Otherwise("0.9"), "see `scale`"),
];

const SHAPES: &[&str] = &["polynomial", "bump", "disc", "ellipse", "star", "points", "file"];
const ROUND: &[&str] = &["polynomial", "bump", "disc"];
const SMOOTH: &[&str] = &["polynomial", "bump", "disc", "ellipse", "star"];

const INITIAL: &[Field] = &[
    field(
        "shape",
        Choice(SHAPES),
        "",
        Required,
        "with s = (x/a)^2 + (y/b)^2 + ...: polynomial (1 - s)^k, bump e^(1/(s - 1)), disc and ellipse 1, each for s < 1; star: 1 for r < (sin^2(5 theta/2) + 1/2)/4; points; file",
    ),
    only(("shape", &["polynomial"]), field("k", Count(0, 64), "", Required, "exponent")),
    only(("shape", ROUND), field("radius", Number(Positive), "length", Otherwise("1"), "a = b = ...")),
    only(
        ("shape", &["polynomial", "bump", "ellipse"]),
        field("axes", Vector(Positive), "length", Otherwise("radius"), "a, b, ...: half the width along each axis"),
    ),
    only(("shape", SMOOTH), field("center", Vector(Any), "length", Otherwise("origin"), "of the shape")),
    only(
        ("shape", SMOOTH),
        field("height", Number(Positive), "mass/length^d", Otherwise("1"), "factor of the density"),
    ),
    only(
        ("shape", SMOOTH),
        field("mass", Number(Positive), "mass", Otherwise("from `height`"), "total mass; replaces `height`"),
    ),
    only(("shape", &["points"]), field("points", Points, "length", Required, "[[x, y], ...]")),
    only(("shape", &["points"]), field("masses", Numbers(Any), "mass", Required, "one for each point")),
    only(
        ("shape", &["file"]),
        field(
            "path",
            Text,
            "",
            Required,
            "a table (CSV; a header, columns x, y, z as the dimension needs, mass, perhaps density) or NPY (shape (n, d+1): coordinates, mass), relative to the scene; see docs/scenes.md",
        ),
    ),
    field(
        "share",
        Number(Positive),
        "",
        Otherwise("its mass (pks)"),
        "share of the particles under random sampling, relative to the other parts'",
    ),
    field(
        "diffusivity",
        Number(NonNegative),
        "length^2/time",
        Otherwise("pks.mu"),
        "of this part as a species of its own (pks): shares and masses then follow (5.3)-(5.5)",
    ),
    field(
        "sensitivity",
        Number(Positive),
        "pks.chi",
        Otherwise("1"),
        "chi_i of this part as a species of its own (pks): particles weigh mass / chi_i, the second moment and the centre are those of the weights; not with pks.heavy",
    ),
];

const SAMPLING: &[Field] = &[
    field(
        "kind",
        Choice(&["grid", "random"]),
        "",
        Required,
        "grid: the points of h Z^d in the support, masses rho h^d; random: rejection, equal masses within a part",
    ),
    only(("kind", &["grid"]), field("h", Number(Positive), "length", Required, "grid spacing")),
    only(("kind", &["random"]), field("count", Count(1, 100_000_000), "", Required, "particles")),
];

const TIME: &[Field] = &[
    field("end", Number(Positive), "time", Required, "when the run stops"),
    field("dt", Number(Positive), "time", Required, "step; the last one is not shortened, so end must be a multiple"),
];

const METHOD: &[Field] = &[
    field("sum", Choice(&["auto", "direct"]), "", Otherwise("auto"), "auto: the fastest method that serves the kernel"),
    field(
        "tolerance",
        Number(Open(0.0, 1.0)),
        "",
        Otherwise("1e-12"),
        "of sums by the fast multipole method, relative to sum |m| |K|",
    ),
];

const PKS: &[Field] = &[
    field("chi", Number(NonNegative), "", Required, "chemosensitivity; 0 solves no field"),
    field("mu", Number(NonNegative), "length^2/time", Required, "diffusivity; 0 draws no random number"),
    field("mesh", Counts(2, 3, 4096), "cells", Otherwise("[270, 270]"), "cells along x and y"),
    field("x", Interval, "length", Otherwise("[-15, 15]"), "the mesh along x"),
    field("y", Interval, "length", Otherwise("[-15, 15]"), "the mesh along y"),
    field(
        "border",
        Choice(&["monopole", "quadrupole"]),
        "",
        Otherwise("monopole"),
        "the field on the mesh's border: of all mass at its centre, or with its second moments",
    ),
    field(
        "scheme",
        Choice(&["second", "fourth"]),
        "",
        Otherwise("second"),
        "order of the mesh's field: five points as in the paper, or nine; the latter wants nearly square cells",
    ),
    field(
        "heavy",
        Number(Positive),
        "critical masses",
        Otherwise("none"),
        "particles of at least this mass, the 64 heaviest at most, act pair by pair, softened over a quarter of a mesh width, not through the mesh",
    ),
    field(
        "law",
        Choice(&["exact", "printed"]),
        "",
        Otherwise("exact"),
        "collision of a cluster: the squared Bessel hitting law, or the increment test as printed",
    ),
    field(
        "collapse",
        Choice(&["soft", "hard"]),
        "",
        Otherwise("soft"),
        "clusters that may merge: soft, index below 0; hard, index at most -1",
    ),
    field("cell", Number(Positive), "length", Otherwise("1"), "root cells of the cluster search"),
    field("separation", Number(Open(0.0, 1.0)), "", Otherwise("0.1"), "eta of (3.1)"),
    field(
        "probability",
        Number(Open(0.0, 1.0)),
        "",
        Otherwise("1e-4"),
        "a cluster less likely to collide within the step is left alone",
    ),
];

const STUDY: &[Field] = &[
    field("h", Numbers(Positive), "length", Required, "grid spacings, from coarse to fine; each is a run"),
    field(
        "reference",
        Number(Positive),
        "length",
        Otherwise("the exact solution"),
        "spacing of the run that errors are measured against; a half, a third ... of every spacing of `h`",
    ),
];

const OUTPUT: &[Field] = &[
    field("every", Number(Positive), "time", Otherwise("end/100"), "between rows of diagnostics.csv"),
    field("trajectories", Count(0, 100_000), "particles", Otherwise("0"), "particles whose paths are kept"),
    field("snapshots", Numbers(NonNegative), "time", Otherwise("none"), "when all particles are kept for pictures"),
    field(
        "particles",
        Choices(&["npy", "vtk", "csv"]),
        "",
        Otherwise("[\"npy\"]"),
        "how the final particles are written",
    ),
    field("density", Flag, "", Otherwise("false"), "carry the density along trajectories (blob)"),
    field(
        "energy",
        Flag,
        "",
        Otherwise("false"),
        "the regularised energy (2.4), a column of diagnostics.csv (blob, particle)",
    ),
    field("events", Flag, "", Otherwise("true"), "events.csv with every coalescence (pks)"),
];

const KINDS: &[&str] = &["trajectories", "density", "moment", "count", "convergence", "particles", "field", "profile"];

const PICTURE: &[Field] = &[
    field("name", Text, "", Required, "file name without ending"),
    field(
        "kind",
        Choice(KINDS),
        "",
        Required,
        "trajectories; density (a curve in 1D, a map in 2D); moment: second moment over time; count: particles over time; convergence: errors over h; particles: one panel a snapshot; field: c(x) on the mesh (pks); profile: curves of the mollifier",
    ),
    field("title", Text, "", Otherwise("the scene's"), "above the picture"),
    field("case", Text, "", Otherwise("all"), "draw only this case"),
    field("x", Interval, "", Otherwise("all that is drawn"), "horizontal range"),
    field("y", Interval, "", Otherwise("all that is drawn"), "vertical range"),
    only(
        ("kind", &["trajectories", "density"]),
        field(
            "exact",
            Flag,
            "",
            Otherwise("false"),
            "draw the exact solution beneath (Newtonian kernel; one round part, an ellipse of vortices, or two points): paths over time, or densities in 1D",
        ),
    ),
    only(
        ("kind", &["trajectories"]),
        field(
            "plane",
            Choice(&["xt", "xy", "xyt"]),
            "",
            Otherwise("xt in 1D, else xy"),
            "which coordinates; xyt is an oblique view with time upwards",
        ),
    ),
    only(
        ("kind", &["density", "particles", "field"]),
        field("times", Numbers(NonNegative), "time", Otherwise("all snapshots"), "which of `output.snapshots`"),
    ),
    only(
        ("kind", &["convergence", "profile"]),
        field(
            "quantity",
            Choice(&["positions", "density", "potential"]),
            "",
            Otherwise("all errors, or density"),
            "which error (positions, density) or which curve (density, potential)",
        ),
    ),
    only(
        ("kind", &["convergence"]),
        field("rates", Numbers(Positive), "", Otherwise("none"), "slopes of lines drawn for comparison"),
    ),
    only(
        ("kind", &["moment"]),
        field("parts", Flag, "", Otherwise("false"), "one curve for each part of the initial data beside the total"),
    ),
    only(
        ("kind", &["moment", "count"]),
        field("slope", Tables(SLOPE), "", Otherwise("none"), "predicted slopes, drawn dashed"),
    ),
];

const SLOPE: &[Field] = &[
    field("value", Number(Any), "", Required, "slope"),
    field("at", Number(NonNegative), "time", Required, "the line goes through the curve at this time"),
    field("label", Text, "", Otherwise("the value"), "in the legend"),
];

/// What may be expected of a run.
pub const QUANTITIES: &[&str] = &[
    "error_positions",
    "error_density",
    "rate_positions",
    "rate_density",
    "slope",
    "slope_error",
    "decay_rate",
    "part_slope",
    "part_nonlinearity",
    "heavy_mass",
    "particles",
    "mean_radius",
    "radius_spread",
    "largest_radius",
    "clusters",
    "second_moment",
    "centre_drift",
    "energy_rise",
    "energy_drift",
    "rotation_rate",
    "density_maximum",
    "merges",
    "density_at_zero",
    "potential_at_zero",
    "approximation_ratio",
];

/// Quantities at a spacing or at a time.
const AT: &[&str] = &[
    "error_positions",
    "error_density",
    "rate_positions",
    "rate_density",
    "heavy_mass",
    "particles",
    "second_moment",
    "density_maximum",
    "approximation_ratio",
];
/// Quantities of an interval of spacings or of times.
const INTERVAL: &[&str] = &[
    "rate_positions",
    "rate_density",
    "slope",
    "slope_error",
    "decay_rate",
    "rotation_rate",
    "part_slope",
    "part_nonlinearity",
];
/// Quantities of one part of the initial data.
const PART: &[&str] = &["part_slope", "part_nonlinearity"];

const EXPECT: &[Field] = &[
    field("quantity", Choice(QUANTITIES), "", Required, "which number; see docs/scenes.md"),
    field("case", Text, "", Otherwise("the only one"), "of which case"),
    only(
        ("quantity", AT),
        field(
            "at",
            Number(NonNegative),
            "length or time",
            Otherwise("the last"),
            "a spacing of the study (errors, rates: from the next coarser one) or the time of a row of diagnostics (all else)",
        ),
    ),
    only(
        ("quantity", INTERVAL),
        field(
            "from",
            Number(NonNegative),
            "time or length",
            Otherwise("start"),
            "start of the interval of a slope or rate",
        ),
    ),
    only(("quantity", INTERVAL), field("to", Number(NonNegative), "time or length", Otherwise("end"), "end of it")),
    only(("quantity", PART), field("part", Count(0, 255), "", Otherwise("0"), "which part of the initial data")),
    field("value", Number(Any), "", Otherwise("none"), "what it should be"),
    field("band", Number(NonNegative), "", Otherwise("none"), "how far off it may be"),
    field("relative", Number(NonNegative), "", Otherwise("none"), "how far off it may be, as a fraction of the value"),
    field("least", Number(Any), "", Otherwise("none"), "lower bound"),
    field("most", Number(Any), "", Otherwise("none"), "upper bound"),
    field("paper", Text, "", Otherwise("not stated"), "what the paper states, for the gallery"),
    field("reason", Text, "", Required, "why this value and this band"),
];

/// The schema as text.
pub fn print() -> String {
    let mut text = String::from(
        "# Keys of a mollis scene (TOML). Unknown keys are errors. Lists count from 0 in messages.\n\
         # A number may be written as text in multiples of pi: \"32 pi\". Units follow from one unit of length,\n\
         # of mass and of time, which the papers leave open.\n",
    );
    section(&mut text, "", SCENE);
    text
}

fn section(text: &mut String, path: &str, fields: &[Field]) {
    for field in fields {
        let unit = if field.unit.is_empty() { String::new() } else { format!(" [{}]", field.unit) };
        let need = match field.need {
            Required => "required".to_owned(),
            Otherwise(value) => format!("otherwise {value}"),
        };
        let when =
            field.when.map_or(String::new(), |(key, values)| format!("; only with {key} = {}", values.join(" | ")));
        let _ = writeln!(text, "{path}{} : {}{unit} ({need}{when})\n    {}", field.key, words(field.kind), field.doc);
        match field.kind {
            Table(inner) => section(text, &format!("{path}{}.", field.key), inner),
            Tables(inner) => section(text, &format!("{path}{}[].", field.key), inner),
            _ => {}
        }
    }
}

/// A kind in words.
pub fn words(kind: Kind) -> String {
    match kind {
        Number(range) => format!("number, {}", range.words()),
        Count(low, high) => format!("whole number from {low} to {high}"),
        Text => "text".to_owned(),
        Choice(values) => values.join(" | "),
        Choices(values) => format!("list of {}", values.join(", ")),
        Flag => "true | false".to_owned(),
        Numbers(range) => format!("list of numbers, each {}", range.words()),
        Vector(range) => format!("list of `dimension` numbers, each {}", range.words()),
        Points => "list of points of `dimension` numbers".to_owned(),
        Pair(range) => format!("list of two numbers, each {}", range.words()),
        Interval => "[low, high], low below high".to_owned(),
        Counts(n, low, high) => format!("{n} whole numbers from {low} to {high}"),
        Table(_) => "table".to_owned(),
        Tables(_) => "list of tables".to_owned(),
        Overlay => "table of scene keys".to_owned(),
        Overlays => "list of tables of scene keys".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every(path: &str, fields: &[Field], seen: &mut Vec<String>) {
        for field in fields {
            let name = format!("{path}{}", field.key);
            assert!(!field.doc.is_empty(), "{name}");
            if let Some((key, values)) = field.when {
                // The deciding key stands in the same table and is a choice that offers these values.
                let deciding = fields.iter().find(|f| f.key == key).unwrap_or_else(|| panic!("{name}: no {key}"));
                let Choice(offered) = deciding.kind else { panic!("{name}: {key} is no choice") };
                assert!(values.iter().all(|value| offered.contains(value)), "{name}");
            }
            assert!(!seen.contains(&name), "{name} twice");
            seen.push(name.clone());
            if let Table(inner) | Tables(inner) = field.kind {
                every(&format!("{name}."), inner, seen);
            }
        }
    }

    #[test]
    fn the_table_is_consistent_and_printed_whole() {
        let mut seen = Vec::new();
        every("", SCENE, &mut seen);
        let text = print();
        for name in seen {
            let key = name.rsplit('.').next().unwrap();
            assert!(text.contains(&format!("{key} : ")), "{name}");
        }
    }
}
