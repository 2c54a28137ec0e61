//! Mesh fields: all walls, both orders, with and without screening, particles inside, on the border and outside, masses that add up to 0.

use std::ptr::null;

use mollis_tests::Aligned;
use mollis_tests::exceptions::Rows;
use mollis_tests::positional::*;

use super::*;

/// Every combination of options.
pub fn options() -> Vec<mollis_grid2_options> {
    let mut defaults = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
    let defaults = unsafe {
        assert_eq!(mollis_grid2_options_init(defaults.as_mut_ptr(), size_of::<mollis_grid2_options>()), 0);
        defaults.assume_init()
    };
    let mut all = Vec::new();
    for walls in [MOLLIS_WALLS_FREE, MOLLIS_WALLS_NO_FLUX, MOLLIS_WALLS_FREE_QUADRUPOLE] {
        for screening in [0.0, 1.5] {
            for order in [2, 4] {
                if walls != MOLLIS_WALLS_FREE_QUADRUPOLE || screening == 0.0 {
                    all.push(mollis_grid2_options { walls, screening, order, ..defaults });
                }
            }
        }
    }
    all
}

macro_rules! check {
    ($name:ident, $t:ty; $bytes:ident() $eval:ident()) => {
        #[test]
        fn $name() {
            const N: usize = 30;
            let mut rows = Rows::default();
            let mut x = points!(N, $t, 2);
            x[4] = [1.0, 1.0];
            x[5] = [-1.0, 0.3];
            x[6] = [2.5, -7.0];
            x[7] = [0.5, -1.0000001];
            let same: Vec<$t> = vec![0.25; N];
            let opposite: Vec<$t> = (0..N).map(|k| if k % 2 == 0 { 0.25 } else { -0.25 }).collect();
            let zeros = vec![0.0 as $t; N];
            // Transforms by powers of two, by another radix, and by Bluestein's algorithm.
            for cells in [[2, 2], [16, 16], [15, 14], [37, 41]] {
                let mesh = mollis_mesh2 { lower: [-1.0; 2], upper: [1.0; 2], cells };
                let nodes = (cells[0] + 1) * (cells[1] + 1);
                // A jump of 10 in the middle, the same on the border.
                let inside = |k: usize| (k % (cells[0] + 1)).min(k / (cells[0] + 1)) > 0 && k * 2 < nodes;
                let inside = |k: usize| inside(k) && k % (cells[0] + 1) < cells[0];
                let diffusivity: Vec<f64> = (0..nodes).map(|k| if inside(k) { 10.0 } else { 1.0 }).collect();
                let media = [null(), diffusivity.as_ptr()].map(|decay| mollis_medium2 {
                    diffusivity: diffusivity.as_ptr(),
                    decay,
                    tolerance: 1e-3,
                    iterations: 50,
                    report: std::ptr::null_mut(),
                });
                let plain = options();
                let in_media = plain.iter().filter(|options| {
                    options.screening == 0.0 && options.order == 2 && options.walls != MOLLIS_WALLS_FREE_QUADRUPOLE
                });
                let in_media = in_media
                    .flat_map(|options| media.iter().map(move |medium| mollis_grid2_options { medium, ..*options }));
                let mut attractant = vec![0.0; nodes];
                let past = mollis_parabolic2 { time_scale: 0.5, time: 0.1, attractant: attractant.as_mut_ptr() };
                let with_memory = plain.iter().filter(|options| {
                    options.order == 2 && options.walls != MOLLIS_WALLS_FREE_QUADRUPOLE
                });
                let with_memory =
                    with_memory.map(|options| mollis_grid2_options { parabolic: &raw const past, ..*options });
                for options in plain.iter().copied().chain(in_media).chain(with_memory) {
                    let what = |function: &str, kind: &str| {
                        let mollis_grid2_options { walls, screening, order, medium, parabolic, .. } = options;
                        let medium = if medium.is_null() { "" } else { ", a medium" };
                        let memory = if parabolic.is_null() { "" } else { ", a memory" };
                        format!(
                            "{function}, {cells:?}, walls {walls}, screening {screening}, order {order}{medium}{memory}, {kind}"
                        )
                    };
                    // Cells that are too coarse for the screening are refused.
                    if options.order == 4 && cells[0] == 2 {
                        continue;
                    }
                    let mut bytes = 0;
                    rows.row(what(stringify!($bytes), ""), || unsafe {
                        $bytes(&raw const mesh, &raw const options, null(), &raw mut bytes)
                    });
                    let mut memory = Aligned::new(bytes);
                    let workspace = pointer(&mut memory);
                    for (kind, m) in [("masses", &same), ("total 0", &opposite), ("zeros", &zeros)] {
                        for n in [0, 1, N] {
                            let (mut gradient, mut total, mut outside) = ([[0.0 as $t; 2]; N], [0.0 as $t; 3], 0);
                            let (mut mass, mut u) = (vec![0.0 as $t; nodes], vec![0.0 as $t; nodes]);
                            let mut du = vec![[0.0 as $t; 2]; nodes];
                            rows.row(what(stringify!($eval), &format!("{kind} {n}")), || unsafe {
                                $eval(
                                    &raw const mesh,
                                    &raw const options,
                                    n,
                                    x.as_ptr(),
                                    m.as_ptr(),
                                    N,
                                    x.as_ptr(),
                                    gradient.as_mut_ptr(),
                                    mass.as_mut_ptr(),
                                    u.as_mut_ptr(),
                                    du.as_mut_ptr(),
                                    &raw mut total,
                                    &raw mut outside,
                                    workspace,
                                    bytes,
                                    null(),
                                )
                            });
                        }
                    }
                }
            }
            rows.finish();
        }
    };
}

check!(double, f64; grid2_workspace_bytes() grid2_eval());
check!(single, f32; grid2_workspace_bytes_f32() grid2_eval_f32());
