// Culling for three.js. Nothing is imported from `three`: objects are known by what they are, so a page may use `three` or
// `three/webgpu`.

export { bakedLevels } from './baked.js';
export { Culling } from './culling.js';
export { init } from './init.js';
