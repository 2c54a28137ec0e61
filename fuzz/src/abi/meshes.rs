//! Fields on a mesh.

use mollis_abi::*;

use super::Calls;
use super::forms::Scalar;
use super::sums::Placed;
use crate::memory::Role;

impl Calls<'_, '_> {
    pub fn rectangle(&mut self) -> mollis_mesh2 {
        let cells = if self.draw.tame {
            [2 + self.draw.below(10), 2 + self.draw.below(10)]
        } else {
            std::array::from_fn(|_| {
                let usual = self.draw.below(14);
                if self.draw.rarely(40) { self.draw.pick(&[usize::MAX, 1 << 32, 1 << 40]) } else { usual }
            })
        };
        let size = self.draw.positive();
        mollis_mesh2 {
            lower: std::array::from_fn(|_| self.draw.or_wild(-size)),
            upper: std::array::from_fn(|_| self.draw.or_wild(size)),
            cells,
        }
    }

    pub fn mesh_options(&mut self) -> *const mollis_grid2_options {
        let (walls, order) = if self.draw.tame {
            (self.draw.pick(&[0, 1, 2]), self.draw.pick(&[2, 4]))
        } else {
            (self.draw.pick(&[0, 1, 2, 3, -1]), self.draw.pick(&[2, 4, 3, 0]))
        };
        let screening = self.draw.pick(&[0.0, 0.0, 1.0]);
        let options = mollis_grid2_options {
            size: size_of::<mollis_grid2_options>() as u32,
            walls,
            screening: self.draw.or_wild(screening),
            order,
            reserved: 0,
            medium: std::ptr::null(),
            parabolic: std::ptr::null(),
        };
        self.options(options)
    }

    pub fn mesh<T: Scalar>(&mut self) {
        let rectangle = self.rectangle();
        let nodes = rectangle.cells.iter().map(|c| c.saturating_add(1)).fold(1, usize::saturating_mul);
        // Sizes that no memory holds are only asked for.
        let held = if nodes <= 400 { nodes } else { 0 };
        let mesh = self.input(&[rectangle]);
        let n = self.draw.count();
        let sources = self.sources::<T, 2>(n);
        let sources = self.input(&[sources]);
        let (targets, m) = self.targets::<T, 2>(n);
        let mut gradient = Placed([std::ptr::null_mut(); 2], 0);
        if !self.draw.rarely(3) {
            gradient = self.layout::<T, 2>(m, Role::Output);
        }
        let seven = T::of(7.0);
        let outputs = GridOutputsOf {
            gradient: gradient.0,
            gradient_stride: gradient.1,
            node_mass: self.perhaps(held, seven),
            node_potential: self.perhaps(held, seven),
            node_gradient: self.perhaps(held, [seven; 2]),
            total: self.perhaps(1, [seven; 3]),
            outside: self.perhaps(1, 7),
        };
        let outputs = self.input(&[outputs]);
        let options = self.mesh_options();
        let run = self.run();
        let needed = self.output(1, 0_usize);
        self.begin();
        // SAFETY: every pointer is null, misaligned, or has its length.
        let asked = unsafe { T::grid_bytes(mesh, sources, targets, outputs, options, run.options, needed) };
        self.end("grid_bytes", asked);
        if nodes > 400 {
            return;
        }
        // SAFETY: written, as the query succeeded.
        let bytes = (asked == 0).then(|| unsafe { *needed });
        let Some((workspace, room, enough)) = self.workspace(bytes) else { return };
        self.begin();
        // SAFETY: as above.
        let status = unsafe { T::grid_eval(mesh, sources, targets, outputs, options, run.options, workspace, room) };
        self.end("grid_eval", status);
        self.room("grid_eval", status, bytes, (room, enough), &run);
    }
}
