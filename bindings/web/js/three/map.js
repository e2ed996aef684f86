// A map from above of what a camera's pass decided: a point for each mesh and each instance.

import { Kind } from './bounds.js';
import { Fate } from './decisions.js';
import { worldBox } from './footprint.js';

const SIZE = 240;
// Outside, drawn, hidden, clipped: bytes are those of canvas pixels, and brighter points lie on top.
const COLOURS = ['#46525c', '#6fd08c', '#e0704f', '#b48ae0'];
const words = Uint32Array.from(COLOURS, (c) => 0xff000000 | (parseInt(c.slice(5, 7), 16) << 16) | (parseInt(c.slice(3, 5), 16) << 8) | parseInt(c.slice(1, 3), 16));
const RANK = [1, 4, 3, 2];
const BACK = 0xff1f1810;
const NEAR_PIXELS = 8;

const box = new Float64Array(6);
const product = new Float64Array(16);

/** Calls `each(i, instance, x, y, z, fate)` for all that has a place; `instance` is -1 for a mesh. */
function points({ objects, kinds, hidden, boxes, parts, length }, decision, each) {
  const { boxes: local, matrices } = boxes;
  for (let i = 0; i < Math.min(length, decision.length); i++) {
    if (kinds[i] < Kind.Mesh || objects[i] === null || hidden[i] === 1 || !objects[i].visible) continue;
    const { elements: m } = objects[i].matrixWorld;
    if (kinds[i] === Kind.Mesh) {
      worldBox(local, 6 * i, matrices, 16 * i, box, 0);
      if (Number.isFinite(box[0] + box[3])) each(i, -1, (box[0] + box[3]) / 2, (box[1] + box[4]) / 2, (box[2] + box[5]) / 2, decision.fates[i]);
      else each(i, -1, m[12], m[13], m[14], decision.fates[i]);
      continue;
    }
    const lists = decision.lists?.get(i);
    const part = parts.get(i);
    const isBatch = kinds[i] === Kind.Batched;
    const count = isBatch ? part.length : objects[i].count;
    const fates = new Uint8Array(count).fill(lists ? Fate.Outside : Fate.Drawn);
    for (const k of lists?.inside ?? []) fates[k] = Fate.Hidden;
    for (const k of lists?.drawn ?? []) fates[k] = Fate.Drawn;
    const places = isBatch ? null : objects[i].instanceMatrix.array;
    for (let k = 0; k < count; k++) {
      if (isBatch) { part.matrixOf(k, product); each(i, k, product[12], product[13], product[14], fates[k]); continue; }
      const [x, y, z] = [places[16 * k + 12], places[16 * k + 13], places[16 * k + 14]];
      each(i, k, m[0] * x + m[4] * y + m[8] * z + m[12], m[1] * x + m[5] * y + m[9] * z + m[13], m[2] * x + m[6] * y + m[10] * z + m[14], fates[k]);
    }
  }
}

export class Map2D {
  canvas = document.createElement('canvas');
  /** How far the map reaches from its middle, in the scene's units; 0: as far as nine tenths of all points. */
  reach = 0;
  #found = null;

  constructor() {
    [this.canvas.width, this.canvas.height] = [SIZE, SIZE];
  }

  zoom(by) { this.reach *= by; }

  /** Draws a decision, and where its camera is now. Where the mark is, pixels. */
  draw(nodes, decision, mark) {
    const { camera, world, projection } = decision;
    // Up is the camera's: y, or z where a page has it so.
    const isZUp = Math.abs(camera.up.z) > Math.abs(camera.up.y);
    const flat = (x, y, z) => (isZUp ? [x, -y] : [x, z]);
    const eye = camera.matrixWorld.elements;
    const [mx, my] = flat(eye[12], eye[13], eye[14]);
    if (this.reach === 0) {
      const distances = [];
      points(nodes, decision, (i, k, x, y, z) => { const [a, b] = flat(x, y, z); const d = Math.hypot(a - mx, b - my); if (Number.isFinite(d)) distances.push(d); });
      this.reach = 1.1 * (distances.sort((a, b) => a - b)[Math.floor(0.9 * distances.length)] ?? 0) || 10;
    }
    const scale = SIZE / 2 / this.reach;
    const pixel = ([a, b]) => [SIZE / 2 + (a - mx) * scale, SIZE / 2 + (b - my) * scale];
    const context = this.canvas.getContext('2d');
    const image = context.createImageData(SIZE, SIZE);
    const pixels = new Uint32Array(image.data.buffer).fill(BACK);
    const rank = new Uint8Array(SIZE * SIZE);
    const found = this.#found = new Float64Array(2 * SIZE * SIZE).fill(-1);
    points(nodes, decision, (i, k, x, y, z, fate) => {
      const px = Math.floor(SIZE / 2 + (x - mx) * scale);
      const py = Math.floor(SIZE / 2 + ((isZUp ? -y : z) - my) * scale);
      if (!(px >= 0 && py >= 0 && px < SIZE - 1 && py < SIZE - 1)) return;
      // Two by two pixels.
      for (let corner = 0; corner < 4; corner++) {
        const at = SIZE * (py + (corner >> 1)) + px + (corner & 1);
        if (rank[at] >= RANK[fate]) continue;
        rank[at] = RANK[fate]; pixels[at] = words[fate]; found[2 * at] = i; found[2 * at + 1] = k;
      }
    });
    context.putImageData(image, 0, 0);
    this.#frustum(context, flat, pixel, world, projection);
    context.fillStyle = '#ffffff';
    context.beginPath();
    context.arc(SIZE / 2, SIZE / 2, 3, 0, 7);
    context.fill();
    if (mark) { context.strokeStyle = '#ffffff'; context.strokeRect(mark[0] - 4.5, mark[1] - 4.5, 9, 9); }
  }

  // The two sides of what the camera saw, and a line where it looked.
  #frustum(context, flat, pixel, world, projection) {
    const isOrthographic = projection[15] === 1;
    const half = 1 / projection[0];
    context.strokeStyle = '#ffe28a';
    context.beginPath();
    for (const side of [-half, half]) {
      // A side's point at the camera and one far ahead, in the camera's space.
      const ends = [[isOrthographic ? side : 0, 0], [(isOrthographic ? side : 3 * this.reach * side), -3 * this.reach]];
      ends.forEach(([x, z], k) => {
        const at = pixel(flat(...[0, 1, 2].map((r) => world[12 + r] + world[r] * x + world[8 + r] * z)));
        if (k === 0) context.moveTo(...at); else context.lineTo(...at);
      });
    }
    context.stroke();
  }

  /** `{ number, instance }` of the point nearest to a pixel; `null` where there is none. */
  at(x, y) {
    let [best, near] = [null, NEAR_PIXELS];
    for (let py = Math.max(0, Math.floor(y - NEAR_PIXELS)); py < Math.min(SIZE, y + NEAR_PIXELS); py++) {
      for (let px = Math.max(0, Math.floor(x - NEAR_PIXELS)); px < Math.min(SIZE, x + NEAR_PIXELS); px++) {
        const distance = Math.hypot(px + 0.5 - x, py + 0.5 - y);
        const at = 2 * (SIZE * py + px);
        if (distance >= near || !this.#found || this.#found[at] < 0) continue;
        [best, near] = [{ number: this.#found[at], instance: this.#found[at + 1] }, distance];
      }
    }
    return best;
  }
}

/** Colours by fate, for a legend. */
export const legend = [['drawn', COLOURS[Fate.Drawn]], ['hidden', COLOURS[Fate.Hidden]], ['clipped', COLOURS[Fate.Clipped]], ['outside', COLOURS[Fate.Outside]]];
