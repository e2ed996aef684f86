//! Clipping: outcodes.
