//! Back-face culling of triangles.
