//! Frustum tests of single things, and the slow oracles.
