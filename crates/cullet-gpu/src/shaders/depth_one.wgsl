// The depth that was drawn, of one sample a pixel.

@group(1) @binding(0) var depth: texture_depth_2d;

// Where in a pixel what is drawn can be seen: in its middle.
const INSET = 0.5;

fn depth_of(pixel: vec2<u32>) -> f32 { return textureLoad(depth, pixel, 0); }
