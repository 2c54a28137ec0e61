//! Coalescing particles for the Patlak-Keller-Segel model (Zhelezov & Fatkullin, Sections 2 to 5).
//!
//! `dX_n = -chi grad sum m_i V(X_n - X_i) dt + sqrt(2 mu~ / m_n) dW_n` (1.3), with inelastic collisions: [`step`] moves and merges the
//! particles of a [`State`]; [`theory`] holds what is known of them in closed form.
//!
//! Two readings of the paper: the collision test (3.11) is `Y + dY <= 0`, and by default it is replaced by the exact law of the squared
//! Bessel process ([`collision`]).

mod close;
pub mod collision;
pub mod extent;
mod heavy;
mod merge;
mod motion;
pub mod search;
mod state;
mod step;
#[cfg(test)]
mod testing;
pub mod theory;
mod weights;

pub use collision::{CollisionLaw, Merging};
pub use heavy::{Heavy, MAX_HEAVY};
pub use state::{Counters, Event, Events, Options, Report, Scheme, State};
pub use step::{Attraction, Setting, Summed, step, workspace_bytes, workspace_bytes_on_ranks};
