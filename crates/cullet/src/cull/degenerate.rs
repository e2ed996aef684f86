//! Triangles without area.
