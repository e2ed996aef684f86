// Uses the page as a user would, in Chromium: node page.mjs CULLET_SERVE PAGE_FOLDER [PICTURES_FOLDER]
// Exits with 1 at the first thing that is not as it should be, and says which.
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { inflateSync } from "node:zlib";
import { tmpdir } from "node:os";
import { join } from "node:path";
import assert from "node:assert/strict";
import { MIDDLE, SIZE, WAIT, ask, changed, data, drag, drop, launch, open, running, settled, start } from "./browser.mjs";
import { beside, stored } from "./beside.mjs";
import { controls } from "./controls.mjs";
import { large } from "./large.mjs";
import { phone } from "./phone.mjs";
import { tour } from "./tour.mjs";
import { worker } from "./worker.mjs";

const [serve, page_folder, pictures] = process.argv.slice(2);
assert(serve && page_folder, "usage: node page.mjs CULLET_SERVE PAGE_FOLDER [PICTURES_FOLDER]");
// Large enough that something is culled of the first view.
const SCENE = "city";

/** A cube as GLB: 8 vertices, 12 triangles. */
function cube() {
  const positions = new Float32Array([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [i & 1, (i >> 1) & 1, i >> 2]));
  const indices = new Uint32Array([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]);
  const bin = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(indices.buffer)]);
  const json = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0, name: "cube" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    buffers: [{ byteLength: bin.length }],
    bufferViews: [{ buffer: 0, byteLength: 96 }, { buffer: 0, byteOffset: 96, byteLength: 144 }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 8, type: "VEC3", min: [0, 0, 0], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5125, count: 36, type: "SCALAR" },
    ],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const word = (n) => { const b = Buffer.alloc(4); b.writeUInt32LE(n); return b; };
  return Buffer.concat([
    Buffer.from("glTF"), word(2), word(28 + text.length + bin.length),
    word(text.length), Buffer.from("JSON"), text, word(bin.length), Buffer.from("BIN\0"), bin,
  ]);
}

/** Colours of a PNG that Chromium wrote (8 bits, RGB or RGBA, not interlaced), sampled on every fourth pixel. */
function colours(png) {
  const [width, height, kind] = [png.readUInt32BE(16), png.readUInt32BE(20), png[25]];
  const step = kind === 6 ? 4 : 3;
  const parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  const raw = inflateSync(Buffer.concat(parts));
  const line = width * step;
  const seen = new Set();
  let above = Buffer.alloc(line);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (line + 1)];
    const row = raw.subarray(y * (line + 1) + 1, (y + 1) * (line + 1));
    for (let i = 0; i < line; i++) {
      const [a, b, c] = [i < step ? 0 : row[i - step], above[i], i < step ? 0 : above[i - step]];
      const p = a + b - c;
      const [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
      const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
      row[i] = row[i] + [0, a, b, (a + b) >> 1, paeth][filter];
    }
    above = row;
    for (let x = 0; x < width; x += 4) seen.add(row.readUIntBE(x * step, 3));
  }
  return seen.size;
}

const parse = (faces) => faces.split("/").map(Number);

async function use(browser, url, query, name) {
  const { page, said, took } = await open(browser, url, query);
  console.log(`${name}: running after ${took} ms`);

  const before = await data(page, "faces");
  const [left, all] = parse(before);
  assert(left > 0 && left < all, `something is culled and something is left: ${before}`);

  await page.waitForTimeout(1500);
  const picture = await page.screenshot(pictures ? { path: join(pictures, `${name}.png`) } : {});
  const count = colours(picture);
  assert(count > 200, `the picture has ${count} colours`);

  await drag(page, 160, 30);
  const turned = await changed(page, "faces", before);
  console.log(`${name}: ${count} colours; faces ${before}, turned ${turned}`);
  const spoken = await page.textContent("#spoken");
  assert(spoken.includes(turned), `read aloud: ${spoken}`);
  await page.waitForFunction(() => location.hash.includes("camera"), null, { timeout: WAIT });

  // Frozen, what is drawn stays though the camera turns.
  await page.keyboard.press("f");
  assert.equal(await changed(page, "frozen", "no"), "yes");
  const frozen = await data(page, "faces");
  await drag(page, -120, 20);
  await page.waitForTimeout(800);
  await settled(page);
  assert.equal(await data(page, "faces"), frozen, "frozen, yet the counter moves");
  await page.keyboard.press("f");
  assert.equal(await changed(page, "frozen", "yes"), "no");

  // A thing that is seen says so.
  for (let i = 0; i < 6 && !(await data(page, "reason")); i++) {
    await page.mouse.click(MIDDLE.x + 12 * i, MIDDLE.y + 15 * i);
    await page.waitForTimeout(500);
  }
  const reason = await data(page, "reason");
  assert(reason, "what was clicked has a reason");
  console.log(`${name}: clicked: ${reason}`);

  // A broken file is told; what was open stays.
  const scene = await data(page, "scene");
  await drop(page, ["broken.glb", cube().subarray(0, 150)]);
  const notice = await changed(page, "notice", await data(page, "notice"));
  assert.match(notice, /broken\.glb/);
  assert.equal(await data(page, "scene"), scene);
  assert.equal(await data(page, "state"), "running");
  console.log(`${name}: told: ${notice}`);

  await drop(page, ["cube.glb", cube()]);
  assert.equal(await changed(page, "scene", scene), "cube.glb");
  const [, triangles] = parse(await data(page, "faces"));
  assert.equal(triangles, 12);
  if (pictures) {
    await page.waitForTimeout(1500);
    await page.screenshot({ path: join(pictures, `${name}-cube.png`) });
  }

  // The same by the browser's dialog.
  const dialog = await ask(page);
  await dialog.setFiles({ name: "chosen.glb", mimeType: "model/gltf-binary", buffer: cube() });
  assert.equal(await changed(page, "scene", "cube.glb"), "chosen.glb");

  await taken(page, name);

  // What browsers say of a fallback renderer, and of what is slow in it, is about this machine, not about the page.
  const bad = said.filter((s) => !/fallback adapter|swiftshader|software|powerPreference|GPU stall|GL Driver Message \(OpenGL, Performance/i.test(s));
  assert.deepEqual(bad, [], "the console is clean");
  await page.close();
}

/** What a user takes with them: the funnel as JSON, and a picture of the page. */
async function taken(page, name) {
  await page.keyboard.press("j");
  await page.waitForFunction(() => document.body.dataset.notice.includes("copied"), null, { timeout: WAIT });
  const { funnel } = JSON.parse(await page.evaluate(() => navigator.clipboard.readText()));
  assert(funnel.length > 2 && funnel.every((row) => row.stage && row.left <= row.entered), JSON.stringify(funnel));
  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("i")]);
  const file = await readFile(await download.path());
  const size = [file.readUInt32BE(16), file.readUInt32BE(20)];
  assert.deepEqual([download.suggestedFilename(), ...size], ["cullet.png", SIZE.width, SIZE.height]);
  console.log(`${name}: a funnel of ${funnel.length} rows copied, a picture of ${size.join(" x ")} saved`);
}

/** The device is taken away: the page says so, and opened again it shows what it showed. */
async function lose(browser, url, query, name) {
  const { page } = await open(browser, url, query);
  const before = await data(page, "faces");
  await drag(page, 160, 30);
  const turned = await changed(page, "faces", before);
  await page.waitForFunction(() => location.hash.includes("camera"), null, { timeout: WAIT });
  const address = page.url();
  await page.evaluate(() => {
    const device = globalThis.takenDevice;
    if (device) device.destroy();
    else document.getElementById("canvas").getContext("webgl2").getExtension("WEBGL_lose_context").loseContext();
  });
  await page.waitForFunction(() => document.body.dataset.state === "lost", null, { timeout: WAIT });
  const message = page.locator("#message");
  assert.match(await message.textContent(), /graphics device was lost/);
  if (pictures) await page.screenshot({ path: join(pictures, `${name}-lost.png`) });
  await message.getByRole("button").click();
  await page.waitForFunction(() => document.body.dataset.state !== "lost", null, { timeout: WAIT });
  await running(page);
  assert.equal(page.url(), address);
  assert.equal(await data(page, "faces"), turned, "it shows what it showed");
  console.log(`${name}: lost, and opened again`);
  await page.close();
}

/** The state that a chapter of the book links to opens in the page. */
async function linked(browser, url, chapter) {
  const text = await readFile(new URL(`../../../../docs/src/${chapter}.md`, import.meta.url), "utf8");
  const [, state] = text.match(/\]\(viewer\/index\.html(#[^)]*)\)/) ?? [];
  assert(state, `${chapter}.md links to the page`);
  const { page } = await open(browser, url.replace(/#.*/, state), "?webgl");
  assert.equal(await data(page, "notice"), "", `${chapter}: the link makes sense`);
  console.log(`${chapter}: shows ${await data(page, "scene")}, faces ${await data(page, "faces")}`);
  await page.close();
}

const folder = await mkdtemp(join(tmpdir(), "cullet-page-"));
const browser = await launch();
try {
  const server = await start(serve, page_folder, SCENE);
  await use(browser, server.url, "", "webgpu");
  await use(browser, server.url, "?webgl", "webgl");
  await lose(browser, server.url, "", "webgpu");
  await lose(browser, server.url, "?webgl", "webgl");

  await beside(browser, server.url);
  await worker(browser, server.url, ["cube.glb", cube()]);
  await phone(browser, server.url, pictures);
  await tour(browser, server.url, pictures);
  await controls(browser, server.url, pictures);
  // In a browser of its own: what pages before have left draws no more.
  const fresh = await launch();
  await large(fresh, server.url, folder);
  await fresh.close();

  // Nonsense in a link opens the default, and says so.
  const { page } = await open(browser, server.url.replace(/#.*/, "#scene=city&wipe=%22no%22"), "?webgl");
  assert.match(await data(page, "notice"), /link/);
  await page.close();
  for (const chapter of ["frustum", "hierarchy", "backface", "clipping", "occlusion"]) {
    await linked(browser, server.url, chapter);
  }
  await server.end();

  // A file that is served.
  await writeFile(join(folder, "a cube.glb"), cube());
  const files = await start(serve, page_folder, join(folder, "a cube.glb"));
  const served = await open(browser, files.url, "?webgl");
  assert.deepEqual(parse(await data(served.page, "faces"))[1], 12);
  console.log(`served: ${await data(served.page, "scene")} after ${served.took} ms`);
  await files.end();

  // One that names another file, in a folder below.
  const several = await start(serve, page_folder, await stored(folder));
  const { page: named, said } = await open(browser, several.url, "?webgl");
  assert.equal(await data(named, "scene"), "/scene/triangle.gltf");
  assert.equal(await data(named, "faces").then((f) => f.split("/")[1]), "1");
  assert.deepEqual(said.filter((s) => /404/.test(s)), [], "nothing is asked for that is not served");
  console.log(`served with its buffer: ${await data(named, "notice")}`);
  await several.end();
} finally {
  await browser.close();
  await rm(folder, { recursive: true, force: true });
}
console.log("the page works");
