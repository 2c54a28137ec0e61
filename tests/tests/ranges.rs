//! Finite results are computed even if intermediate values leave the range; through the C ABI.
#![expect(unsafe_code, reason = "calls the C ABI as a C program does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each call passes buffers of the stated sizes that live through it"
)]

use std::f64::consts::PI;
use std::ptr::{null, null_mut};

use mollis_abi::*;
use mollis_tests::Aligned;
use mollis_tests::positional::*;

/// Sun and Earth in kilograms and metres, in single precision.
#[test]
fn moments_of_sun_and_planet() {
    let (m, x) = ([1.989e30_f32, 5.972e24], [[0.0_f32, 0.0], [1.496e11, 0.0]]);
    let (mut mass, mut absolute, mut centre, mut second) = (0.0, 0.0, [7.0; 2], 0.0);
    unsafe {
        let centre = &raw mut centre;
        let status =
            mollis_moments2_f32(2, x.as_ptr(), m.as_ptr(), &raw mut mass, &raw mut absolute, centre, &raw mut second);
        assert_eq!(status, 0);
    }
    let want = f64::from(m[1]) * f64::from(x[1][0]) / (f64::from(m[0]) + f64::from(m[1]));
    assert!((f64::from(centre[0]) / want - 1.0).abs() < f64::from(f32::EPSILON) && centre[1] == 0.0, "{centre:?}");
    assert_eq!((mass, absolute, second), (m[0] + m[1], m[0] + m[1], f32::INFINITY));
}

/// Far outside a Gaussian mollifier its field is Newtonian: 1 / (2 pi r) and log r / (2 pi) in the plane, 1/2 and r/2 on the line.
#[test]
fn gaussian_fields_far_outside() {
    let gaussian = mollis_mollifier { kind: MOLLIS_MOLLIFIER_GAUSSIAN, order: 4, exponent: 0 };
    for (delta, r) in [(1e-5_f32, 3e14_f32), (1e-15, 1e15), (1e-19, 1e19), (1e-30, 1e30), (3e-38, 1e38)] {
        let (x, y) = ([[0.6 * r, -0.8 * r]], [[r]]);
        let (mut density, mut potential, mut gradient) = ([7.0; 1], [7.0; 1], [[7.0; 2]]);
        let mut on_line = ([7.0; 1], [[7.0]]);
        unsafe {
            let (rho, u, g) = (density.as_mut_ptr(), potential.as_mut_ptr(), gradient.as_mut_ptr());
            let status = mollis_mollifier2_field_f32(gaussian, delta, 1, x.as_ptr(), rho, u, g, null_mut());
            assert_eq!(status, 0);
            let (u, g) = (on_line.0.as_mut_ptr(), on_line.1.as_mut_ptr());
            let status = mollis_mollifier1_field_f32(gaussian, delta, 1, y.as_ptr(), null_mut(), u, g, null_mut());
            assert_eq!(status, 0);
        }
        let (x, far) = (x[0].map(f64::from), f64::from(r));
        let square = x[0] * x[0] + x[1] * x[1];
        // Ten roundings. Values below the normal range are rounded to the spacing there.
        let close = |got: f32, want: f64| {
            let bound = 12.0 * f64::from(f32::EPSILON) * want.abs() + 1.5e-45;
            assert!((f64::from(got) - want).abs() <= bound, "{delta} {r}: {got:e} {want:e}");
        };
        assert_eq!(density, [0.0]);
        close(potential[0], 0.5 * square.ln() / (2.0 * PI));
        close(gradient[0][0], x[0] / square / (2.0 * PI));
        close(gradient[0][1], x[1] / square / (2.0 * PI));
        close(on_line.0[0], 0.5 * far);
        close(on_line.1[0][0], 0.5);
    }
    // And at the centre the plain formula holds: g = 3 / (4 pi delta^2) there, (1 - E)(1 + 2 E) / (2 pi r^2) with E = e^(-r^2 / (2 delta^2)).
    let mut gradient = [[7.0_f32; 2]; 2];
    let x = [[0.0; 2], [1e-25, 0.0]];
    unsafe {
        let (n, g) = (null_mut(), gradient.as_mut_ptr());
        assert_eq!(mollis_mollifier2_field_f32(gaussian, 1e-5, 2, x.as_ptr(), n, n, g, null_mut()), 0);
    }
    assert_eq!(gradient[0], [0.0; 2]);
    assert!((f64::from(gradient[1][0]) / (3e-25 / (4.0 * PI * 1e-10)) - 1.0).abs() < 2e-6, "{gradient:?}");
}

macro_rules! field {
    ($t:ty, $side:expr, $mass:expr, $bytes:ident() $eval:ident()) => {{
        let side: f64 = $side;
        let mesh = mollis_mesh2 { lower: [-side; 2], upper: [side; 2], cells: [64, 64] };
        let mut options = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
        let options = unsafe {
            assert_eq!(mollis_grid2_options_init(options.as_mut_ptr(), size_of::<mollis_grid2_options>()), 0);
            mollis_grid2_options { walls: MOLLIS_WALLS_FREE_QUADRUPOLE, ..options.assume_init() }
        };
        // Two masses, with targets inside the mesh and outside.
        let at = |x: f64, y: f64| [(side * x) as $t, (side * y) as $t];
        let (x, m) = ([at(0.25, 0.0), at(-0.25, 0.0)], [$mass as $t; 2]);
        let targets = [at(0.0, 0.7), at(3.0, 4.0)];
        let (mut gradient, mut u) = ([[7.0 as $t; 2]; 2], vec![7.0 as $t; 65 * 65]);
        let mut bytes = 0;
        unsafe {
            assert_eq!($bytes(&raw const mesh, &raw const options, null(), &raw mut bytes), 0);
            let mut memory = Aligned::new(bytes);
            let status = $eval(
                &raw const mesh,
                &raw const options,
                2,
                x.as_ptr(),
                m.as_ptr(),
                2,
                targets.as_ptr(),
                gradient.as_mut_ptr(),
                null_mut(),
                u.as_mut_ptr(),
                null_mut(),
                null_mut(),
                null_mut(),
                memory.pointer(),
                bytes,
                null(),
            );
            assert_eq!(status, 0);
        }
        // Inside: sum m / (2 pi r) of the two masses, up to the square of the mesh width over the distance. Outside: the first terms
        // of the expansion.
        let per = $mass / (2.0 * PI * side);
        let want = 2.0 * per * 0.7 / (0.7 * 0.7 + 0.25 * 0.25);
        let [inside, outside] = gradient.map(|g| g.map(|g| g as f64));
        assert!((inside[1] / want - 1.0).abs() < 5e-3 && inside[0].abs() < 1e-3 * want, "{side} {inside:?} {want}");
        let seen = [3.0, 4.0].map(|x: f64| 2.0 * per * x / 25.0);
        for k in 0..2 {
            // The quadrupole is (0.25 / 5)^2 of the whole.
            assert!((outside[k] / seen[k] - 1.0).abs() < 1e-2, "{side} {outside:?} {seen:?}");
        }
        // At a corner of the mesh.
        let want = 2.0 * $mass * (side.ln() + 0.5 * 2.0_f64.ln()) / (2.0 * PI);
        assert!((u[0] as f64 - want).abs() <= 2e-2 * $mass + 1e-5 * want.abs(), "{side} {} {want}", u[0]);
    }};
}

#[test]
fn meshes_of_any_size() {
    for (side, mass) in [(1.0, 1.0), (1e160, 1.0), (1e-160, 1.0), (1e300, 1e280), (1e-300, 1e-290), (1e200, 1e-100)] {
        field!(f64, side, mass, grid2_workspace_bytes() grid2_eval());
    }
    // Protons in metres, and stars in metres.
    for (side, mass) in [(1.0, 1.0), (1e-3, 1.67e-27), (1e-12, 1.67e-27), (1e20, 2e30), (1e33, 2e36), (1e-30, 1e-30)] {
        field!(f32, side, mass, grid2_workspace_bytes_f32() grid2_eval_f32());
    }
}
