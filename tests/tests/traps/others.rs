//! Random numbers, options, texts.

use mollis_tests::exceptions::Rows;

use super::*;

#[test]
fn random_numbers_options_and_texts() {
    let mut rows = Rows::default();
    const N: usize = 1000;
    let labels: Vec<u64> = (0..N as u64).collect();
    // Uniform words, and the words at both ends of the range.
    let mut words = vec![0_u64; N];
    rows.row("mollis_philox_words", || unsafe { mollis_philox_words(3, 4, 5, 6, N, words.as_mut_ptr()) });
    (words[0], words[1], words[2], words[3]) = (0, 0, u64::MAX, u64::MAX);
    let (mut pairs, mut narrow_pairs) = (vec![[0.0_f64; 2]; N], vec![[0.0_f32; 2]; N]);
    let (mut normals, mut narrow) = (vec![0.0_f64; N], vec![0.0_f32; N]);
    let (l, w) = (labels.as_ptr(), words.as_ptr());
    rows.row("mollis_philox_normals", || unsafe { mollis_philox_normals(3, N, l, 5, 6, pairs.as_mut_ptr()) });
    rows.row("mollis_philox_normals_f32", || unsafe {
        mollis_philox_normals_f32(3, N, l, 5, 6, narrow_pairs.as_mut_ptr())
    });
    rows.row("mollis_normals", || unsafe { mollis_normals(N, w, normals.as_mut_ptr()) });
    rows.row("mollis_normals_f32", || unsafe { mollis_normals_f32(N, w, narrow.as_mut_ptr()) });
    let mut run = std::mem::MaybeUninit::<mollis_run>::uninit();
    rows.row("mollis_run_init", || unsafe { mollis_run_init(run.as_mut_ptr(), size_of::<mollis_run>()) });
    let mut options = std::mem::MaybeUninit::<mollis_pks_options>::uninit();
    rows.row("mollis_pks_options_init", || unsafe {
        mollis_pks_options_init(options.as_mut_ptr(), size_of::<mollis_pks_options>())
    });
    let mut options = std::mem::MaybeUninit::<mollis_grid2_options>::uninit();
    rows.row("mollis_grid2_options_init", || unsafe {
        mollis_grid2_options_init(options.as_mut_ptr(), size_of::<mollis_grid2_options>())
    });
    let mut options = std::mem::MaybeUninit::<mollis_blob_options>::uninit();
    rows.row("mollis_blob_options_init", || unsafe {
        mollis_blob_options_init(options.as_mut_ptr(), size_of::<mollis_blob_options>())
    });
    let mut options = std::mem::MaybeUninit::<mollis_field_options>::uninit();
    rows.row("mollis_field_options_init", || unsafe {
        mollis_field_options_init(options.as_mut_ptr(), size_of::<mollis_field_options>())
    });
    rows.row("mollis_abi_version", || i32::from(mollis_abi_version() == 0));
    rows.row("mollis_status_text", || i32::from(mollis_status_text(20).is_null()));
    rows.finish();
}
