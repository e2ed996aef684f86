// What drawing a mesh costs in this page: how much longer `render()` takes where nothing hidden is left out, for each mesh more.
//
// Renders with and without occlusion take turns for that, at the start and where much is hidden; pictures are the same. It is measured
// once, and the same from then on.

// Before it is measured.
const START = 8;
// For less than that nothing is staked on a thousand meshes, of which most may be hidden; what is staked is a fortieth of their cost.
const [LEAST, MOST] = [4, 50];
// A clock of a browser steps by up to 0.1 ms, so that few meshes tell nothing.
const LEAST_HIDDEN = 50;
// Renders that compile and upload, and then pairs of renders.
const [WARM, PAIRS] = [8, 16];
// Besides the page's own script the browser's process works on each draw: in Chromium with a software renderer five times as long for
// WebGL and three times for WebGPU, of which a part is the software renderer.
const WHOLE = 3;

/** Microseconds that a draw counts as. */
export class DrawCost {
  microseconds;
  /** `'given'`, `'measured'`, or the `'default'` until then. */
  from;
  /** Whether the next render is to go without occlusion. */
  isTrial = false;
  #camera = null;
  #warm = 0;
  #with = null;
  #slopes = [];
  #pass = { drawn: 0, hidden: 0, time: 0 };

  /** `given`: microseconds, or `undefined` to have them measured. */
  constructor(given) {
    this.microseconds = given ?? START;
    this.from = given === undefined ? 'default' : 'given';
  }

  /** Whether renders are still to be timed. */
  get isOpen() { return this.from === 'default'; }

  /** A render of a camera begins; `false` while one of another camera is waited for. */
  begin(camera) {
    if (this.isTrial && this.#camera !== camera) return false;
    this.#camera = camera;
    this.#pass = { drawn: 0, hidden: 0, time: 0 };
    return true;
  }

  /** A pass of it drew and left out so many meshes, and culling took `time` milliseconds. */
  pass({ visible, hidden, milliseconds }) {
    this.#pass.drawn += visible;
    this.#pass.hidden += hidden;
    this.#pass.time += milliseconds;
  }

  /** The render ends, `time` milliseconds after it began. */
  end(time) {
    const { drawn, hidden } = this.#pass;
    const work = time - this.#pass.time;
    if (!this.isTrial) {
      if (hidden < LEAST_HIDDEN || ++this.#warm <= WARM) return;
      this.#with = { drawn, work };
      this.isTrial = true;
      return;
    }
    this.isTrial = false;
    const more = drawn - this.#with.drawn;
    if (more < LEAST_HIDDEN) return;
    this.#slopes.push(1000 * (work - this.#with.work) / more);
    if (this.#slopes.length < PAIRS) return;
    const median = this.#slopes.sort((a, b) => a - b)[PAIRS / 2];
    // Given in tenths.
    this.microseconds = Math.round(10 * Math.min(MOST, Math.max(LEAST, WHOLE * median))) / 10;
    this.from = 'measured';
  }
}
