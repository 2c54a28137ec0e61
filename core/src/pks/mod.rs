//! Coalescing particles for the Patlak-Keller-Segel model (Zhelezov & Fatkullin, Sections 2 to 5).

pub mod clusters;
pub mod collision;
mod sort;
pub mod theory;
