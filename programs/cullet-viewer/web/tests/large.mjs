// A million instances come to the page, and it goes on drawing.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { join } from "node:path";
import { ask, changed, data, drag, open } from "./browser.mjs";

const COUNT = 1_000_000;
// What the page's thread may be kept from all else, in milliseconds. It decides nothing and does the rest in slices, but for
// nodes and textures, which are made at once: with four times as many programs as processors that took 0.46 s at the most,
// and what a turn takes 0.06 s.
const MOST = Number(process.env.CULLET_LONGEST_TASK ?? 1000);
const MOST_IN_TURN = Number(process.env.CULLET_LONGEST_TURN ?? 250);

/** One triangle a million times, as GLB with EXT_mesh_gpu_instancing. */
export function many() {
  const side = Math.ceil(Math.cbrt(COUNT));
  const places = new Float32Array(COUNT * 3);
  for (let i = 0; i < COUNT; i++) {
    places.set([i % side, Math.floor(i / side) % side, Math.floor(i / side / side)].map((v) => v * 3), i * 3);
  }
  const bin = Buffer.concat([Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer), Buffer.from(places.buffer)]);
  const json = JSON.stringify({
    asset: { version: "2.0" }, scenes: [{ nodes: [0] }],
    extensionsUsed: ["EXT_mesh_gpu_instancing"],
    nodes: [{ mesh: 0, extensions: { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: 1 } } } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    buffers: [{ byteLength: bin.length }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: places.byteLength }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: COUNT, type: "VEC3" },
    ],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const word = (n) => { const b = Buffer.alloc(4); b.writeUInt32LE(n); return b; };
  return Buffer.concat([
    Buffer.from("glTF"), word(2), word(28 + text.length + bin.length),
    word(text.length), Buffer.from("JSON"), text, word(bin.length), Buffer.from("BIN\0"), bin,
  ]);
}

export async function large(browser, url, folder) {
  // As a file: what the browser's driver hands over as bytes is unpacked by the page's own thread.
  const file = join(folder, "many.glb");
  await writeFile(file, many());
  const { page } = await open(browser, url.replace(/#.*/, "#scene=solids"), "?webgl");
  await page.evaluate(() => {
    globalThis.tasks = [];
    new PerformanceObserver((list) => globalThis.tasks.push(...list.getEntries().map((e) => Math.round(e.duration))))
      .observe({ type: "longtask" });
  });
  const dialog = await ask(page);
  const begun = Date.now();
  await dialog.setFiles(file);
  assert.equal(await changed(page, "scene", "solids"), "many.glb");
  const took = Date.now() - begun;
  assert.equal((await data(page, "faces")).split("/")[1], String(COUNT));
  const loading = await longest(page);
  const faces = await data(page, "faces");
  // A page that is busy may take a drag for a click.
  for (let tries = 3; ; tries--) {
    await drag(page, 160, 30);
    try {
      await changed(page, "faces", faces, 60_000);
      break;
    } catch (error) {
      if (tries === 1) throw error;
    }
  }
  const turning = await longest(page);
  const say = (tasks) => tasks.join(", ") || "none";
  console.log(`a million instances: there after ${took} ms; tasks of more than 50 ms: ${say(loading)}; in a turn: ${say(turning)}`);
  for (const [tasks, most] of [[loading, MOST], [turning, MOST_IN_TURN]]) {
    assert(Math.max(0, ...tasks) <= most, `the page stands still for ${Math.max(...tasks)} ms; at most ${most} are allowed`);
  }
  await page.close();
}

/** The page's long tasks since the last call, in milliseconds. */
const longest = (page) => page.evaluate(() => globalThis.tasks.splice(0));
