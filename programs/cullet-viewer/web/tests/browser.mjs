// Chromium and the server, for what uses the page.
import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import assert from "node:assert/strict";

export const SIZE = { width: 960, height: 600 };
export const WAIT = 180_000;
// Where the scene's picture is, between the panels.
export const MIDDLE = { x: 455, y: 300 };

// Software rendering for WebGPU as for WebGL; without the last two a WebGPU canvas stays blank.
const FLAGS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader",
  "--enable-features=Vulkan", "--use-vulkan=swiftshader",
];

export const launch = () =>
  chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", headless: true, args: FLAGS });

/** Starts the server on a free port; resolves to its address and a way to end it. */
export function start(serve, page_folder, scene) {
  const child = spawn(serve, [scene, "--page", page_folder, "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  // A check that fails must leave no server behind.
  process.on("exit", () => child.kill());
  return new Promise((resolve, reject) => {
    let text = "";
    child.on("exit", (code) => reject(new Error(`cullet-serve ended with ${code}: ${text}`)));
    child.stdout.on("data", (data) => {
      text += data;
      const url = text.match(/http:\S+/)?.[0];
      if (!url || !text.includes("\n")) return;
      child.removeAllListeners("exit");
      resolve({
        url,
        end: () => new Promise((ended, late) => {
          child.on("exit", (code) => (code === 0 ? ended() : late(new Error(`cullet-serve ended with ${code}`))));
          child.kill("SIGINT");
        }),
      });
    });
  });
}

/** Opens the page in a browser, or in what one pretends to be: a context. */
export async function open(browser, url, query) {
  const page = await browser.newPage(browser.newContext ? { viewport: SIZE } : undefined);
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  // Tests take the device away; the page itself has no use for it.
  await page.addInitScript(() => {
    if (!globalThis.GPUAdapter) return;
    const request = GPUAdapter.prototype.requestDevice;
    GPUAdapter.prototype.requestDevice = async function (...args) {
      return (globalThis.takenDevice = await request.apply(this, args));
    };
  });
  const said = [];
  page.on("console", (m) => { if (["error", "warning"].includes(m.type())) said.push(`${m.type()}: ${m.text()}`); });
  page.on("pageerror", (e) => said.push(`thrown: ${e}`));
  const workers = [];
  page.on("worker", (worker) => workers.push(worker.url()));
  const begun = Date.now();
  await page.goto(url.replace("/#", `/${query}#`));
  await running(page);
  assert.equal(workers.length, 1, "a scene is made in a worker, built-in or not");
  return { page, said, took: Date.now() - begun };
}

export const data = (page, name) => page.evaluate((n) => document.body.dataset[n] ?? "", name);
export const settled = (page) => page.waitForFunction(() => document.body.dataset.settled === "yes", null, { timeout: WAIT });

export async function running(page) {
  await page.waitForFunction(() => ["running", "failed"].includes(document.body.dataset.state), null, { timeout: WAIT });
  assert.equal(await data(page, "state"), "running", await data(page, "error"));
  await settled(page);
}

/** Waits until the page has drawn what it was told: a press and its release that come to one frame are a click, and no drag. */
const drawn = (page) => page.evaluate(() => new Promise((done) => {
  requestAnimationFrame(() => requestAnimationFrame(() => done()));
}));

export async function drag(page, dx, dy) {
  await page.mouse.move(MIDDLE.x, MIDDLE.y);
  await page.mouse.down();
  await drawn(page);
  await page.mouse.move(MIDDLE.x + dx / 2, MIDDLE.y + dy / 2, { steps: 3 });
  await page.mouse.move(MIDDLE.x + dx, MIDDLE.y + dy, { steps: 3 });
  await drawn(page);
  await page.mouse.up();
}

/** Waits until an attribute is other than it was. */
export async function changed(page, name, old, timeout = WAIT) {
  const args = [name, old];
  await page.waitForFunction(([n, o]) => document.body.dataset[n] !== o, args, { timeout })
    .catch(() => assert.fail(`data-${name} stays '${old}'`));
  await settled(page);
  return data(page, name);
}

/** Has the page ask for a file by its key, again where a slow page did not hear it. */
export async function ask(page) {
  for (let tries = 5; ; tries--) {
    const asked = page.waitForEvent("filechooser", { timeout: WAIT / 5 });
    await page.keyboard.press("l");
    try {
      return await asked;
    } catch (error) {
      if (tries === 1) throw error;
    }
  }
}

/** Drops files on the page at once, each a name and its bytes. */
export async function drop(page, ...files) {
  const carried = files.map(([name, bytes]) => [name, bytes.toString("base64")]);
  await page.evaluate((files) => {
    const carried = new DataTransfer();
    for (const [name, bytes] of files) {
      carried.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
    }
    const canvas = document.getElementById("canvas");
    for (const kind of ["dragover", "drop"]) {
      canvas.dispatchEvent(new DragEvent(kind, { dataTransfer: carried, bubbles: true, cancelable: true }));
    }
  }, carried);
}
