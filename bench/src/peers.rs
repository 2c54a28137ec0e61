//! The sums as a competent user writes them in C (`peers/direct.c`).

use crate::scene::Scene;

#[expect(unsafe_code, reason = "C functions")]
unsafe extern "C" {
    fn peer_gradient2(
        n: usize,
        x: *const f64,
        y: *const f64,
        m: *const f64,
        k: usize,
        tx: *const f64,
        ty: *const f64,
        delta: f64,
        gx: *mut f64,
        gy: *mut f64,
    );
    fn peer_gradient3(
        n: usize,
        x: *const f64,
        y: *const f64,
        z: *const f64,
        m: *const f64,
        k: usize,
        tx: *const f64,
        ty: *const f64,
        tz: *const f64,
        delta: f64,
        gx: *mut f64,
        gy: *mut f64,
        gz: *mut f64,
    );
    fn peer_both2(
        n: usize,
        x: *const f64,
        y: *const f64,
        m: *const f64,
        k: usize,
        tx: *const f64,
        ty: *const f64,
        delta: f64,
        p: *mut f64,
        gx: *mut f64,
        gy: *mut f64,
    );
}

/// One array for each coordinate, as the C loop needs them.
pub struct Peer {
    x: Vec<Vec<f64>>,
    m: Vec<f64>,
    targets: usize,
    out: Vec<Vec<f64>>,
    delta: f64,
    potential: bool,
}

impl Peer {
    /// The C loop for this sum, if there is one.
    pub fn new<const D: usize>(scene: &Scene<D>, targets: usize, gradient: bool, potential: bool) -> Option<Self> {
        let offered = gradient && ((D == 2) || (D == 3 && !potential));
        let column = |k: usize| scene.positions.iter().map(|x| x[k]).collect::<Vec<_>>();
        offered.then(|| Self {
            x: (0..D).map(column).collect(),
            m: scene.masses.clone(),
            targets,
            out: vec![vec![0.0; targets]; 4],
            delta: scene.delta.unwrap_or(0.0),
            potential,
        })
    }

    /// Runs the loop once. The targets are the first of the sources.
    pub fn run(&mut self) {
        let (n, k, m, delta) = (self.m.len(), self.targets, self.m.as_ptr(), self.delta);
        let x: Vec<*const f64> = self.x.iter().map(|x| x.as_ptr()).collect();
        let out: Vec<*mut f64> = self.out.iter_mut().map(|x| x.as_mut_ptr()).collect();
        // SAFETY: the inputs hold n >= k numbers, the outputs k, and the C functions access no others.
        #[expect(unsafe_code, reason = "C functions")]
        unsafe {
            match (x.len(), self.potential) {
                (2, false) => peer_gradient2(n, x[0], x[1], m, k, x[0], x[1], delta, out[0], out[1]),
                (2, true) => peer_both2(n, x[0], x[1], m, k, x[0], x[1], delta, out[2], out[0], out[1]),
                _ => {
                    peer_gradient3(n, x[0], x[1], x[2], m, k, x[0], x[1], x[2], delta, out[0], out[1], out[3]);
                }
            }
        }
        std::hint::black_box(&self.out);
    }

    /// The gradient in the plane that the last run has computed at a target, times 2 pi.
    pub fn gradient(&self, target: usize) -> [f64; 2] {
        [self.out[0][target], self.out[1][target]]
    }
}
