//! What is known of coalescing particles in closed form.

use mollis_core::Error;
use mollis_core::memory::Plain;
use mollis_core::pks::theory;

use crate::buffers::{Input, Output, disjoint};
use crate::status::{mollis_status, status};

/// What is known in closed form of one kind of particles with total mass `mass`, diffusivity mu and sensitivity chi.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_prediction {
    /// 8 pi mu / chi (1.6); infinite for chi = 0.
    pub critical_mass: f64,
    /// The bound on the time of blow-up (1.8), infinite for a subcritical mass.
    pub blow_up_bound: f64,
    /// The rate of the second moment divided by the mass, heavy point masses beside the regular part (4.12).
    pub second_moment_rate: f64,
}
// SAFETY: numbers of eight bytes, no padding.
unsafe impl Plain for mollis_pks_prediction {}

/// Overwrites `out` with what is known of a mass: `second_moment` is the integral of |x|^2 rho about its centre, `heavy` the n_heavy masses that
/// have become points (their sum at most the mass). The rate of no mass is 0. MOLLIS_ERR_NOT_FINITE: some number is not.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_predict(
    mass: f64,
    mu: f64,
    chi: f64,
    second_moment: f64,
    n_heavy: usize,
    heavy: *const f64,
    out: *mut mollis_pks_prediction,
) -> mollis_status {
    status((|| {
        let (heavy, out) = (Input::new(heavy, n_heavy)?, Output::new(out, 1)?);
        disjoint(&[Some(out.range())], &[heavy.range()])?;
        // SAFETY: the caller promises the crate's contract.
        let (heavy, out) = unsafe { (heavy.slice(), out.slice()) };
        if ![mass, mu, chi, second_moment].iter().chain(heavy).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        for slot in out {
            *slot = mollis_pks_prediction {
                critical_mass: theory::critical_mass(mu, chi),
                blow_up_bound: theory::blow_up_bound(mass, mu, chi, second_moment),
                second_moment_rate: theory::second_moment_rate(mass, mu, chi, heavy),
            };
        }
        Ok(())
    })())
}

/// Overwrites index[0] with nu of (2.7), (4.30) for n particles of these masses, and index[1], index[2] with alpha and beta^2 of (2.4).
///
/// gamma: the potential is gamma log r near zero, 1 / (2 pi) for the logarithmic and the screened one. Without mass alpha and beta^2 are 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_index(
    n: usize,
    masses: *const f64,
    chi: f64,
    noise: f64,
    gamma: f64,
    index: *mut f64,
) -> mollis_status {
    status((|| {
        let (masses, index) = (Input::new(masses, n)?, Output::new(index, 3)?);
        disjoint(&[Some(index.range())], &[masses.range()])?;
        // SAFETY: the caller promises the crate's contract.
        let (masses, index) = unsafe { (masses.slice(), index.slice()) };
        if ![chi, noise, gamma].iter().chain(masses).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        let values = theory::Constants { chi, noise, gamma }.rates(masses);
        index.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
        Ok(())
    })())
}

/// One species: its total mass, diffusivity and sensitivity.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mollis_pks_species {
    /// Total mass M_i.
    pub mass: f64,
    /// Diffusivity mu_i.
    pub mu: f64,
    /// Sensitivity chi_i in units of chi, positive; 0 stands for 1. Particles of this species have the weight mass / sensitivity.
    pub sensitivity: f64,
}
// SAFETY: three numbers of eight bytes.
unsafe impl Plain for mollis_pks_species {}

/// What represents n species by `particles` particles with one noise: overwrites share[i] with eta_i, the share of the particles that species i
/// gets, noise with mu~ for the step's options, and rate with the rate of the second moment of all species together (4.28), the integral of |x|^2 sum rho_i / chi_i. Each output may be null.
///
/// From (4.25), mu_i = M eta_i chi_i mu / M_i.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_pks_represent_species(
    n: usize,
    species: *const mollis_pks_species,
    chi: f64,
    particles: usize,
    share: *mut f64,
    noise: *mut f64,
    rate: *mut f64,
) -> mollis_status {
    status((|| {
        let species = Input::new(species, n)?;
        let (share, noise, rate) =
            (Output::optional(share, n)?, Output::optional(noise, 1)?, Output::optional(rate, 1)?);
        disjoint(&[share.map(Output::range), noise.map(Output::range), rate.map(Output::range)], &[species.range()])?;
        if n == 0 || particles == 0 {
            return Err(Error::OutOfDomain);
        }
        // SAFETY: the caller promises the crate's contract.
        let given = unsafe { species.slice() };
        if !(chi.is_finite()
            && given.iter().all(|s| s.mass.is_finite() && s.mu.is_finite() && s.sensitivity.is_finite()))
        {
            return Err(Error::NotFinite);
        }
        if !given.iter().all(|s| s.mass > 0.0 && s.mu > 0.0 && s.sensitivity >= 0.0) {
            return Err(Error::OutOfDomain);
        }
        // SAFETY: as above; the two structures have the same three members in `repr(C)`.
        let given = unsafe { core::slice::from_raw_parts(given.as_ptr().cast::<theory::Species<f64>>(), given.len()) };
        let mass = given.iter().map(|s| s.mass).sum();
        // SAFETY: as above, for each output.
        unsafe {
            if let Some(out) = share {
                out.slice().iter_mut().zip(given).for_each(|(slot, s)| *slot = theory::species_share(given, s));
            }
            if let Some(out) = noise {
                let value = theory::noise(mass, theory::species_mu(given), particles);
                out.slice().iter_mut().for_each(|slot| *slot = value);
            }
            if let Some(out) = rate {
                let value = theory::second_moment_rate_of_species(given, chi);
                out.slice().iter_mut().for_each(|slot| *slot = value);
            }
        }
        Ok(())
    })())
}
