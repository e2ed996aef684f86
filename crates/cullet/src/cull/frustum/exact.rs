//! The exact test of a box against a frustum: its corners against the faces of the box.
