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

/** A mesh in {@link ModelInfo}. */
export interface MeshInfo {
  /** Its number in the scene. */
  mesh: number;
  name: string;
  /** Triangles stored, degenerate ones included. */
  triangles: number;
  /** Polygons that the triangles come from. */
  polygons: number;
  instances: number;
  /** Whether it is an opaque closed body wound outward. */
  solid: boolean;
  /** Why it is not a solid, in words. */
  defect: string | null;
  sides: 'one-sided' | 'two-sided' | 'mixed';
  /** Edges along which two triangles are wound against each other. */
  misoriented: number;
  /** Triangles without area. */
  degenerate: number;
  /** Triangles with the same three corners as an earlier one. */
  duplicate: number;
}

/** Contents of a model, and its defects: the fields of `cullet info --json`. Baked data is not listed. */
export interface ModelInfo {
  schema: 1;
  scene: {
    name: string;
    meshes: number;
    instances: number;
    /** Triangles of all instances. */
    triangles: number;
    /** Triangles stored, each mesh once. */
    unique_triangles: number;
    /** Polygons of all instances. */
    polygons: number;
    /** Meshes that are solids. */
    solids: number;
    materials: number;
    cameras: number;
    /** Least and greatest corner of all vertices in world space, in units of the file; null where nothing is drawn. */
    extent: [[number, number, number], [number, number, number]] | null;
    warnings: string[];
  };
  cameras: string[];
  cells: number;
  portals: number;
  /** Instances whose transform mirrors. */
  mirrored_instances: number;
  /** Instances with a transform that is not finite. */
  non_finite_instances: number;
  /** Instances without finite bounds, which every view keeps. */
  unbounded_instances: number;
  /** Instances scaled to nothing along an axis. */
  singular_instances: number;
  /** The node tree: its nodes, those with nothing to draw below, its depth, and the most that one node has. */
  groups: { nodes: number; empty: number; depth: number; widest: number } | null;
  /** Whether the file has baked data. */
  is_baked: boolean;
  meshes: MeshInfo[];
}

/**
 * Reads a file as {@link Scene.open} does, and returns what is in it and what is wrong with it. Takes time for each edge.
 *
 * @param name as for {@link Scene.open}.
 * @param files the files that it names, by their paths from the file's folder: see {@link filesNamed}. Default none.
 * @throws {CulletError} `file`, or `limit` where it has more than 500 million triangles or 50 million instances.
 */
export function info(bytes: Uint8Array | ArrayBuffer, name?: string, files?: Readonly<Record<string, Uint8Array | ArrayBuffer>>): ModelInfo;

/**
 * Returns the files that a model needs beside it, by their paths from its folder: buffers of glTF, materials of OBJ.
 * A file outside of that folder is never among them.
 *
 * @throws {CulletError} `file`.
 */
export function filesNamed(bytes: Uint8Array | ArrayBuffer, name?: string): string[];
