//! Adaptive Euler-Maruyama sub-steps (Zhelezov & Fatkullin (3.4), (3.5)).
