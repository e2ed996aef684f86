import type { Numbers } from './boxes.js';
import { Scene as Base, View as BaseView, type ViewOptions } from './scene.js';

/** Stands for no instance where an id is expected: 2³² − 1. */
export const NONE: 4294967295;

/** Settings of lines of sight. */
export interface SightOptions {
  /** Instances in none of these layers do not block, u32. Default all. */
  layers?: number;
  /** Both sides of one-sided triangles block. Default: the side that is drawn. */
  bothSides?: boolean;
  /** Any blocker will do in place of the nearest: the search ends at the first. */
  any?: boolean;
  /** Up to two ids that do not block, such as who looks and who is looked at. @throws {CulletError} `id` for one that is not there. */
  ignore?: number | readonly number[] | Uint32Array;
}

/** The triangle that blocks a line of sight. */
export interface Blocker {
  id: number;
  /** Its number in the mesh, as the indices were given. */
  triangle: number;
  /** Share of the way at which it is crossed, above 0 and below 1. */
  share: number;
  /** Where, in world space. */
  point: [number, number, number];
}

/** Settings of queries from box to box. */
export interface BoxOptions {
  /** Instances in none of these layers hide nothing, u32. Default all. */
  layers?: number;
  /** How often boxes may be halved to find a proof for each half, 0 to 16. Default 0: one body hides all. Each may double the cost. */
  splits?: number;
  /**
   * How far the boxes may move along each axis, in world units: one number for both, or two, first for the box that looks.
   * `hidden` then holds for every place within. Default 0.
   */
  motion?: number | Numbers;
}

/** Whether one box may see another. */
export interface BoxSight {
  /** `hidden` is a proof, `visible` the absence of one; `empty` where a box has a least corner beyond its greatest. */
  sight: 'visible' | 'hidden' | 'empty';
  /** The id of what hides it; where boxes were halved, of what hides the first half. */
  by: number | null;
}

/** Settings of queries from a box of eyes. */
export interface RegionOptions {
  /** Layers that the eyes see, u32. A view brings its own. Default all. */
  layers?: number;
  /**
   * Longest side of a cell, in world units, above 0. Bodies lose half of it on every side: it must be less than walls are thick.
   * Cost grows with the third power of its inverse. Default 2.
   */
  cellWorld?: number;
  /** Most cells; a larger box has longer cells. Default 64. */
  mostCells?: number;
  /** Pixels across each of the six squares that are drawn for a cell, 8 to 4096. Default 512. */
  width?: number;
  /** Most bodies drawn for a query, those that look largest. Default 2048. */
  mostBodies?: number;
  /** Farthest that a point of a view's near rectangle may be from its eye, in world units. What is nearer hides nothing. Default 0.25. */
  nearWorld?: number;
}

/** Settings of queries along a way. */
export interface MotionOptions extends RegionOptions {
  /** How far the eye may stray from the way along each axis, in world units. Default 0. */
  radiusWorld?: number;
  /** How far along the way is looked, in world units. Default all. */
  reachWorld?: number;
  /** Length of a step, in world units: distances are known to a step. Default 4. */
  stepWorld?: number;
  /** Most steps; a longer way has longer ones. Default 1024. */
  mostSteps?: number;
}

/** What will be needed along a way: views of the engine's memory, good until the next query of any scene, or until the memory grows. */
export interface Needed {
  /** By distance. */
  ids: Uint32Array;
  /** For each: nothing of it is seen before this distance along the way, in world units; 0 for what may be seen at the start. */
  distances: Float64Array;
}

/** A light in world space. A number that makes none (NaN, a direction of 0) keeps it. */
export type Light =
  /** `direction` is the way that light travels. */
  | { kind: 'directional'; direction: Numbers }
  /** `range` in world units; default no limit. */
  | { kind: 'point'; position: Numbers; range?: number }
  /** `halfAngleRadians` is that between the axis and the side of the cone; default no cone. */
  | { kind: 'spot'; position: Numbers; direction: Numbers; halfAngleRadians?: number; range?: number };

/** Why a light cannot change a picture. */
export type LightReason = 'unlit' | 'frustum' | 'detail' | 'occlusion' | 'no-receiver';
/** Names of the numbers in {@link LightAnswer.reasons}: 0 is `kept`. */
export const LIGHT_REASONS: readonly ['kept', ...LightReason[]];

/** Settings of {@link View.lights}. */
export interface LightsOptions {
  /** Any place in view may receive light, as fog does. Default: only what the last cull of the view found visible. */
  anywhere?: boolean;
  /** Find the casters of each kept light too: {@link View.casters}. */
  casters?: boolean;
}

/** How many lights came to a stage, and how many it left. */
export interface LightRow { reason: LightReason; entered: number; left: number }

/** The lights that may matter: views of the engine's memory, good until the next `lights` of this view, or until the memory grows. */
export interface LightAnswer {
  /** Numbers of the lights that may change the picture, ascending. */
  kept: Uint32Array;
  /** For each light, a number of {@link LIGHT_REASONS}. */
  reasons: Uint8Array;
  /** Six numbers for each kept light: the box around what the view sees and the light reaches. Infinite with `anywhere`. */
  receivers: Float64Array;
  /** The stages that ran, in their order. */
  funnel: LightRow[];
}

/** A view that also culls among candidates, and culls lights. */
export class View extends BaseView {
  /**
   * As {@link View.cull}, of these instances alone: those that you know may be visible, from visible sets, streaming or fog of
   * war. The rest counts as dropped by the stage `pvs`. Takes the place of cells of a file; `explain` knows nothing of it.
   *
   * @throws {CulletError} `id` for one that is not there; `camera`.
   */
  cullAmong(ids: Uint32Array | readonly number[]): Uint32Array;
  /**
   * The lights that can change the picture of the last cull, and why others cannot. Conservative.
   *
   * @throws {CulletError} `argument` where scene or camera have changed since, but for `anywhere`.
   */
  lights(lights: readonly Light[], options?: LightsOptions): LightAnswer;
  /** Ids that may throw a shadow into the picture from the kept light at this place of `kept`, ascending; none without the option `casters`. */
  casters(at: number): Uint32Array;
}

/**
 * A scene that answers queries. They need no view, and are quick once the scene was committed. None says `hidden` without a proof.
 *
 * Arrays that are returned are views of the engine's memory, good until the next query of any scene, or until the memory grows.
 */
export class Scene extends Base {
  view(options?: ViewOptions): View;
  /** The opaque triangle between two points, or null. Exact; what is blended, masked or deformable does not block. */
  lineOfSight(from: Numbers, to: Numbers, options?: SightOptions): Blocker | null;
  /** As {@link lineOfSight} for many lines, six numbers each: the id of each blocker, {@link NONE} where the line is clear. */
  linesOfSight(lines: Numbers, options?: SightOptions): Uint32Array;
  /**
   * Whether all of a box is hidden from all of another, by one closed convex body, or with `splits` by several. Boxes are least
   * and greatest corner. `hidden` holds for the boxes exchanged as well, unless baked polygons of one side hide.
   */
  boxToBox(from: Numbers, to: Numbers, options?: BoxOptions): BoxSight;
  /** As {@link boxToBox} for many pairs, twelve numbers each: a byte a pair, 0 visible, 1 hidden, 2 empty. */
  boxesToBoxes(pairs: Numbers, options?: BoxOptions): Uint8Array;
  /**
   * The ids of what may be seen from anywhere in a box of eyes (least and greatest corner), in any direction or as a view
   * looks, ascending. Closed convex bodies hide, also several together.
   */
  visibleFrom(eyes: Numbers, options?: RegionOptions & { view?: View }): Uint32Array;
  /** What will be needed along a way of points, three numbers each, in the order in which it may come into sight. */
  neededAlong(points: Numbers, options?: MotionOptions): Needed;
}
