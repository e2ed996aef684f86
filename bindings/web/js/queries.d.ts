export { BoxSet, CulletError, init, type CulletErrorCode, type Numbers, type Source } from './core/boxes.js';
export {
  STAGES,
  type Counts, type Draws, type Explanation, type FunnelRow, type InstanceState, type MeshOptions, type Stage, type Surface, type Unit, type ViewOptions,
} from './core/scene.js';
export {
  LIGHT_REASONS, NONE, Scene, View,
  type Blocker, type BoxOptions, type BoxSight, type Light, type LightAnswer, type LightReason, type LightRow, type LightsOptions, type MotionOptions,
  type Needed, type RegionOptions, type SightOptions,
} from './core/queries.js';
