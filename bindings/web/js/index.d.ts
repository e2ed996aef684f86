export { BoxSet, CulletError, init, type CulletErrorCode, type Numbers, type Source } from './core/boxes.js';
export {
  Scene, STAGES, View,
  type Counts, type Draws, type Explanation, type FunnelRow, type InstanceState, type MeshOptions, type Stage, type Surface, type Unit, type ViewOptions,
} from './core/scene.js';
