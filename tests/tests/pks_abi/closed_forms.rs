//! Quantities that are known in closed form.

use super::*;

#[test]
fn the_theory_is_that_of_rust() {
    let masses = [0.5, 2.0, 1.25, 7.0];
    let (chi, noise, gamma) = (3.0, 0.4, 0.25);
    let law = theory::Constants { chi, noise, gamma };
    let group = theory::Group::of(&masses);
    let mut index = [0.0; 3];
    let kinds = [
        mollis_pks_species { mass: 4.0, mu: 17.5, sensitivity: 0.0 },
        mollis_pks_species { mass: 24.0, mu: 2.5, sensitivity: 0.5 },
    ];
    let species = [theory::Species::new(4.0, 17.5), theory::Species { mass: 24.0, mu: 2.5, sensitivity: 0.5 }];
    let (mut share, mut noise_of, mut rate) = ([0.0; 2], 0.0, 0.0);
    let empty = mollis_pks_prediction { critical_mass: 1.0, blow_up_bound: 2.0, second_moment_rate: 3.0 };
    let mut prediction = empty;
    // SAFETY: live arrays of these lengths.
    unsafe {
        assert_eq!(mollis_pks_index(4, masses.as_ptr(), chi, noise, gamma, index.as_mut_ptr()), 0);
        let done = mollis_pks_represent_species(
            2,
            kinds.as_ptr(),
            chi,
            1000,
            share.as_mut_ptr(),
            &raw mut noise_of,
            &raw mut rate,
        );
        assert_eq!(done, 0);
        let done = mollis_pks_predict(60.0, 1.5, chi, 0.7, 2, [20.0, 11.0].as_ptr(), &raw mut prediction);
        assert_eq!(done, 0);
    }
    assert_eq!(index, [law.index(&group), law.alpha(&group), law.beta_squared(&group)]);
    assert_eq!(share, [theory::species_share(&species, &species[0]), theory::species_share(&species, &species[1])]);
    assert_eq!(noise_of, theory::noise(28.0, theory::species_mu(&species), 1000));
    assert_eq!(rate, theory::second_moment_rate_of_species(&species, chi));
    let got = [prediction.critical_mass, prediction.blow_up_bound, prediction.second_moment_rate];
    let want = [
        theory::critical_mass(1.5, chi),
        theory::blow_up_bound(60.0, 1.5, chi, 0.7),
        theory::second_moment_rate(60.0, 1.5, chi, &[20.0, 11.0]),
    ];
    assert_eq!(got, want);

    let (mut index, mut prediction) = ([5.0; 3], empty);
    let (code, nan) = (|e: Error| e as i32, f64::NAN);
    // SAFETY: live arrays of these lengths, except invalid arguments, which are refused.
    unsafe {
        let out = index.as_mut_ptr();
        assert_eq!(mollis_pks_index(4, null(), chi, noise, gamma, out), code(Error::NullPointer));
        assert_eq!(mollis_pks_index(4, masses.as_ptr(), chi, noise, gamma, null_mut()), code(Error::NullPointer));
        assert_eq!(mollis_pks_index(4, masses.as_ptr(), nan, noise, gamma, out), code(Error::NotFinite));
        assert_eq!(mollis_pks_index(3, out, chi, noise, gamma, out), code(Error::Overlap));
        let out = &raw mut prediction;
        assert_eq!(mollis_pks_predict(nan, 1.0, 1.0, 1.0, 0, null(), out), code(Error::NotFinite));
        assert_eq!(mollis_pks_predict(1.0, 1.0, 1.0, 1.0, 1, null(), out), code(Error::NullPointer));
        assert_eq!(mollis_pks_predict(1.0, 1.0, 1.0, 1.0, 0, null(), null_mut()), code(Error::NullPointer));
        let wrong = [mollis_pks_species { mass: 0.0, mu: 1.0, sensitivity: 1.0 }];
        let lost = [mollis_pks_species { mass: nan, mu: 1.0, sensitivity: 1.0 }];
        let (noise, rate) = (&raw mut noise_of, &raw mut rate);
        for (n, kinds, chi, particles, error) in [
            (1, wrong.as_ptr(), 1.0, 9, Error::OutOfDomain),
            (1, lost.as_ptr(), 1.0, 9, Error::NotFinite),
            (2, kinds.as_ptr(), nan, 9, Error::NotFinite),
            (2, kinds.as_ptr(), 1.0, 0, Error::OutOfDomain),
            (0, null(), 1.0, 9, Error::OutOfDomain),
            (2, null(), 1.0, 9, Error::NullPointer),
        ] {
            assert_eq!(mollis_pks_represent_species(n, kinds, chi, particles, null_mut(), noise, rate), code(error));
        }
    }
    assert_eq!(index, [5.0; 3]);
    assert_eq!(prediction.critical_mass, 1.0);
    assert_eq!(noise_of, theory::noise(28.0, theory::species_mu(&species), 1000));
}
