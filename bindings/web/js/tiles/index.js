// Culling for 3d-tiles-renderer. Nothing is imported from it or from `three`: tiles and meshes are known by what they are.

export { init } from '../three/init.js';
export { CullingPlugin } from './plugin.js';
