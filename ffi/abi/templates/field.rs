/// The sources of a sum in {dimension}, and their core radii.
///
/// Coordinates: `positions[k]` points to coordinate k of the first source, and `stride` is the number of {scalar}s from one source to the next. With `positions[1]` (and [2]) null
/// the coordinates of a source follow one another. A stride of 0 is that of arrays without gaps. So `{{x}}` is an array `{scalar} x[n][{d}]`; `{{&p->x}}` with the stride
/// `sizeof *p / sizeof({scalar})` is an array of structures; and `{{x, y}}` are arrays of their own.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_sources{d}{f} {
    /// How many.
    pub n: usize,
    /// Their coordinates.
    pub positions: [*const {T}; {d}],
    /// From one to the next.
    pub stride: usize,
    /// Masses of any sign; sources of mass 0 are dropped. Not looked at with vector strengths.
    pub masses: *const {T},
    /// From one to the next; 0: 1.
    pub mass_stride: usize,
    /// Core radii, positive, in place of the kernel's delta: for Newtonian kernels with a mollifier. Null: the kernel's delta.
    pub radii: *const {T},
    /// From one to the next; 0: 1.
    pub radius_stride: usize,
    /// In space: vector strengths instead of masses, or null. The gradient is then sum_j grad K_delta(x_i - x_j) x strength_j, the velocity of vortex elements by the law of Biot
    /// and Savart for the coefficient 1, of Newtonian kernels. Else null.
    pub strengths: [*const {T}; {d}],
    /// From one to the next.
    pub strength_stride: usize,
}

/// Where a sum is evaluated, in {dimension}: coordinates as in mollis_sources{d}{f}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_targets{d}{f} {
    /// How many.
    pub n: usize,
    /// Their coordinates.
    pub positions: [*const {T}; {d}],
    /// From one to the next.
    pub stride: usize,
}

/// Where the results of a sum in {dimension} go: arrays as in mollis_sources{d}{f}; null is not computed. All zero but the pointers: overwritten.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct mollis_outputs{d}{f} {
    /// u.
    pub potential: *mut {T},
    /// From one to the next; 0: 1.
    pub potential_stride: usize,
    /// grad u, or what `combination` makes of it.
    pub gradient: [*mut {T}; {d}],
    /// From one to the next.
    pub gradient_stride: usize,
    /// The Laplacian of u: the density of the blobs of a Newtonian kernel of coefficient 1.
    pub laplacian: *mut {T},
    /// From one to the next; 0: 1.
    pub laplacian_stride: usize,
    /// What all results are multiplied by. 0, a member that was left alone, means 1.
    pub factor: f64,
    /// 1: results are added to what is there; 0: overwritten.
    pub add: i32,
    /// 0.
    pub reserved: i32,
}

/// Bytes of workspace that mollis_field{d}_eval{f} needs for the same arguments, wherever the workspace begins. Only counts, strides and which pointers are null are looked
/// at.
#[cfg({features})]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_workspace_bytes{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    run: *const mollis_run,
    bytes: *mut usize,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.bytes(run, bytes) })
}

/// Writes a sentence that says which method will run, why, and what is skipped: at most `text_bytes` with the zero at its end. `length` (may be null): the whole
/// sentence's length, without the zero.
#[cfg({features})]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_text{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    text: *mut c_char,
    text_bytes: usize,
    length: *mut usize,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    status(unsafe { ask.text(text, text_bytes, length) })
}

/// {evaluation}
#[cfg({features})]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mollis_field{d}_eval{f}(
    kernel: *const c_void,
    kernel_bytes: usize,
    sources: *const mollis_sources{d}{f},
    targets: *const mollis_targets{d}{f},
    outputs: *const mollis_outputs{d}{f},
    options: *const mollis_field_options,
    run: *const mollis_run,
    workspace: *mut c_void,
    workspace_bytes: usize,
    counters: *mut mollis_counters,
) -> mollis_status {
    let (sources, targets, outputs) = (sources.cast(), targets.cast(), outputs.cast());
    let ask = Ask::<{T}, {d}> { kernel, kernel_bytes, sources, targets, outputs, options };
    // SAFETY: the caller promises the crate's contract.
    unsafe { ask.evaluate(run, (workspace, workspace_bytes), counters) }
}
