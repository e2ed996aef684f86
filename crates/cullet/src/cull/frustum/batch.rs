//! Frustum tests of batches, with SIMD.
