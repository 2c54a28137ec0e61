//! Memory that shows when a call writes, or reads, where it must not.
//!
//! Each buffer ends where a page without access begins, as nearly as its alignment lets it; known bytes lie before it and in what is left behind it.
//! (Without `mmap` there are only the known bytes.)
#![expect(unsafe_code, reason = "buffers for C functions")]

/// What a call may do to a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Read.
    Input,
    /// Write, unless it refuses its arguments.
    Output,
    /// Anything.
    Scratch,
}

/// What lies around buffers.
const CANARY: u8 = 0xC5;
/// Known bytes before a buffer.
const BEFORE: usize = 128;
/// Room for a buffer of ordinary size, and for a large one.
const SMALL: usize = 1 << 16;
/// The largest buffer.
pub const LARGE: usize = 1 << 25;

struct Slot {
    start: *mut u8,
    bytes: usize,
}

struct Used {
    slot: usize,
    start: *mut u8,
    bytes: usize,
    role: Role,
    /// The contents when the call begins, of what it may not change.
    held: Vec<u8>,
}

/// Buffers of a call, in memory that serves call after call.
#[derive(Default)]
pub struct Memory {
    slots: Vec<Slot>,
    used: Vec<Used>,
}

impl Memory {
    /// This many bytes at a multiple of `align`, and `offset` bytes before one.
    pub fn place(&mut self, bytes: usize, align: usize, offset: usize, role: Role) -> *mut u8 {
        let wanted = bytes + align + offset + BEFORE;
        let size = if wanted <= SMALL { SMALL } else { LARGE + SMALL };
        assert!(wanted <= size, "a check asks for too much memory");
        let free =
            (0..self.slots.len()).find(|&k| self.slots[k].bytes == size && self.used.iter().all(|used| used.slot != k));
        let slot = free.unwrap_or_else(|| {
            self.slots.push(Slot { start: map(size), bytes: size });
            self.slots.len() - 1
        });
        // SAFETY: the slot holds `wanted` bytes before its end.
        unsafe {
            let end = self.slots[slot].start.add(size);
            let start = end.sub(bytes);
            let start = start.sub(start.addr() % align).sub(offset);
            start.sub(BEFORE).write_bytes(CANARY, BEFORE);
            let last = start.add(bytes);
            last.write_bytes(CANARY, end.addr() - last.addr());
            self.used.push(Used { slot, start, bytes, role, held: Vec::new() });
            start
        }
    }

    /// Notes the contents of all buffers: a call follows.
    pub fn begin(&mut self) {
        for used in &mut self.used {
            if used.role != Role::Scratch {
                // SAFETY: a buffer of this many bytes, all written.
                used.held = unsafe { std::slice::from_raw_parts(used.start, used.bytes) }.to_vec();
            }
        }
    }

    /// Checks what the call left.
    pub fn check(&self, what: &str, status: i32, refused: bool) {
        for used in &self.used {
            // SAFETY: all of it lies in the slot.
            let (before, inside, behind) = unsafe {
                let slot = &self.slots[used.slot];
                let last = used.start.add(used.bytes);
                let left = slot.start.add(slot.bytes).addr() - last.addr();
                (
                    std::slice::from_raw_parts(used.start.sub(BEFORE), BEFORE),
                    std::slice::from_raw_parts(used.start, used.bytes),
                    std::slice::from_raw_parts(last, left),
                )
            };
            let around = before.iter().chain(behind).all(|&byte| byte == CANARY);
            assert!(around, "{what}, status {status}: wrote beside a buffer of {} bytes", used.bytes);
            let kept = match used.role {
                Role::Input => true,
                Role::Output => refused,
                Role::Scratch => false,
            };
            if kept {
                let at = inside.iter().zip(&used.held).position(|(now, held)| now != held);
                assert!(
                    at.is_none(),
                    "{what}, status {status}: changed byte {at:?} of {} ({:?})",
                    used.bytes,
                    used.role
                );
            }
        }
    }

    /// Forgets all buffers.
    pub fn clear(&mut self) {
        self.used.clear();
    }
}

/// Memory between two pages without access.
#[cfg(unix)]
fn map(bytes: usize) -> *mut u8 {
    // SAFETY: asks for fresh memory, and for its inner pages to be writable.
    unsafe {
        let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).expect("a page has a size");
        assert!(bytes.is_multiple_of(page));
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_NORESERVE;
        let all = libc::mmap(std::ptr::null_mut(), bytes + 2 * page, libc::PROT_NONE, flags, -1, 0);
        assert!(all != libc::MAP_FAILED, "no memory");
        let start = all.cast::<u8>().add(page);
        assert_eq!(libc::mprotect(start.cast(), bytes, libc::PROT_READ | libc::PROT_WRITE), 0);
        start
    }
}

#[cfg(not(unix))]
fn map(bytes: usize) -> *mut u8 {
    Box::leak(vec![0; bytes].into_boxed_slice()).as_mut_ptr()
}
