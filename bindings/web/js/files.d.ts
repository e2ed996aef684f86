import { Scene as Base } from './core/scene.js';

export { BoxSet, CulletError, init, type CulletErrorCode, type Numbers, type Source } from './core/boxes.js';
export {
  STAGES, View,
  type Counts, type Draws, type Explanation, type FunnelRow, type InstanceState, type MeshOptions, type Stage, type Surface, type Unit, type ViewOptions,
} from './core/scene.js';

/** A scene that may be read from a file. */
export class Scene extends Base {
  /**
   * Reads a file: glTF and GLB (also baked by `cullet bake`, with its levels and occluders), OBJ, PLY, STL, OFF and maps of
   * Quake, as far as one file holds all. The scene is committed; ids are in the order of the file.
   *
   * @param name stands for the file in messages; its ending tells formats without a signature apart. Default `model.glb`.
   * @throws {CulletError} `file`, with the item, its value and what would be right.
   */
  static open(bytes: Uint8Array | ArrayBuffer, name?: string): Scene;
}
