// A glTF that holds nothing itself: its buffer comes along, or is asked for.
import assert from "node:assert/strict";
import { mkdir, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { ask, changed, data, drop, open } from "./browser.mjs";

/** A triangle as glTF, which names its buffer, and moves. */
function triangle() {
  const bin = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 0]).buffer);
  const gltf = {
    asset: { version: "2.0" }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name: "triangle" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    animations: [{ samplers: [{ input: 1, output: 2 }], channels: [{ sampler: 0, target: { node: 0, path: "translation" } }] }],
    buffers: [{ byteLength: bin.length, uri: "parts/my%20triangle.bin" }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: 8 }, { buffer: 0, byteOffset: 44, byteLength: 24 }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [2] },
      { bufferView: 2, componentType: 5126, count: 2, type: "VEC3" },
    ],
  };
  return [["triangle.gltf", Buffer.from(JSON.stringify(gltf))], ["my triangle.bin", bin]];
}

/** The same as files in a folder; returns the model's path. */
export async function stored(folder) {
  const [[name, gltf], [buffer, bin]] = triangle();
  await mkdir(join(folder, "parts"), { recursive: true });
  await writeFile(join(folder, name), gltf);
  await writeFile(join(folder, "parts", buffer), bin);
  return join(folder, name);
}

export async function beside(browser, url) {
  const { page } = await open(browser, url, "?webgl");
  const scene = await data(page, "scene");
  const [model, buffer] = triangle();
  await drop(page, model);
  const missing = await changed(page, "notice", await data(page, "notice"));
  assert.match(missing, /triangle\.gltf.*my triangle\.bin is missing.*\.glb.*stays open/s);
  assert.equal(await data(page, "scene"), scene);
  console.log(`alone: told: ${missing}`);

  // The buffer first: the order in which files are picked up means nothing.
  await drop(page, buffer, model);
  assert.equal(await changed(page, "scene", scene), "triangle.gltf");
  const notice = await data(page, "notice");
  assert.match(notice, /at rest/);
  assert.equal((await data(page, "faces")).split("/")[1], "1");
  console.log(`with its buffer: told: ${notice}`);

  // Both by the browser's dialog.
  const dialog = await ask(page);
  const named = (name, [, buffer]) => ({ name, mimeType: "application/octet-stream", buffer });
  await dialog.setFiles([named("chosen.gltf", model), named("my triangle.bin", buffer)]);
  assert.equal(await changed(page, "scene", "triangle.gltf"), "chosen.gltf");
  await page.close();
}
