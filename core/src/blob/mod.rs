//! The blob method for the aggregation equation (Craig & Bertozzi, Definitions 2.2 and 2.3).
