//! Mollifiers: scalar functions of r, and fields at points.
