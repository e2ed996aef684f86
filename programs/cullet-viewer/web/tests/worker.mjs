// The worker that made a scene decides what of it is drawn; without it the page does so by itself.
import assert from "node:assert/strict";
import { WAIT, changed, data, drag, drop, open, settled } from "./browser.mjs";

/** Counts what the page's worker is asked from now on, and keeps it from beginning until `go`. */
const count = (worker, hold = false) => worker.evaluate((hold) => {
  const answer = globalThis.onmessage;
  globalThis.asked = 0;
  globalThis.held = hold ? [] : null;
  globalThis.onmessage = (event) => {
    globalThis.asked += 1;
    if (globalThis.held) globalThis.held.push(event);
    else answer(event);
  };
  globalThis.go = () => {
    const held = globalThis.held;
    globalThis.held = null;
    held.forEach(answer);
  };
}, hold);
const asked = (worker) => worker.evaluate(() => globalThis.asked);

/** The worker of what is shown, once those of scenes before it have ended. */
async function only(page) {
  for (let waited = 0; page.workers().length !== 1; waited += 100) {
    assert(waited < WAIT, `a page has one worker, not ${page.workers().length}`);
    await page.waitForTimeout(100);
  }
  return page.workers()[0];
}

export async function worker(browser, url, [name, model]) {
  const { page, said } = await open(browser, url, "?webgl");
  const told = [];
  page.on("console", (m) => told.push(`${m.type()}: ${m.text()}`));
  const first = await only(page);
  await count(first);
  let faces = await data(page, "faces");
  await drag(page, 160, 30);
  faces = await changed(page, "faces", faces);
  const times = await asked(first);
  assert(times > 0, "the page asks its worker what is drawn");

  // One that breaks off leaves its work to the page, which says so once.
  await first.evaluate(() => { globalThis.onmessage = () => { throw new Error("broken by a test"); }; });
  await drag(page, -160, 30);
  faces = await changed(page, "faces", faces);
  await drag(page, 160, -10);
  faces = await changed(page, "faces", faces);
  const broken = told.filter((t) => /broke off/.test(t));
  assert.equal(broken.length, 1, told.join("\n"));
  assert.match(broken[0], /^info: .*broken by a test/);

  // Another scene has another worker, and the one before is ended.
  const scene = await data(page, "scene");
  await drop(page, [name, model]);
  assert.equal(await changed(page, "scene", scene), name);
  const second = await only(page);
  assert.notEqual(second, first);
  await count(second);
  // Here the counter of faces may well stay.
  const link = await page.evaluate(() => location.hash);
  await drag(page, 90, 30);
  await page.waitForFunction((l) => location.hash !== l, link, { timeout: WAIT });
  await settled(page);
  assert(await asked(second) > 0, "the scene that was dropped has a worker to ask");
  assert.deepEqual(said.filter((s) => /^(error|thrown)/.test(s)), [], "a worker that breaks off is no error of the page");
  console.log(`the worker was asked ${times} times in a turn; ${broken[0]}`);
  await page.close();

  // What it cannot be asked: a scene that the page cut itself, and the occlusion buffer.
  for (const state of ["scene=solids&cut.on=true", "scene=solids&layout=buffer"]) {
    const { page } = await open(browser, url.replace(/#.*/, `#${state}`), "?webgl");
    assert.equal(await data(page, "notice"), "", state);
    const own = await only(page);
    await count(own);
    const link = await page.evaluate(() => location.hash);
    await drag(page, 90, 30);
    await page.waitForFunction((l) => location.hash !== l, link, { timeout: WAIT });
    await settled(page);
    assert.equal(await asked(own), 0, `${state}: decided by the page`);
    await page.close();
  }
  await slow(browser, url.replace(/#.*/, "#scene=city:cells=12,objects=1500"));
}

/** A worker that takes long is asked for what is newest, and what it says of a view that is gone is not shown. */
async function slow(browser, url) {
  const { page } = await open(browser, url, "?webgl");
  const own = await only(page);
  const before = await data(page, "faces");
  await count(own, true);
  await drag(page, 160, 30);
  await page.waitForFunction(() => document.body.dataset.settled === "no", null, { timeout: WAIT });
  assert.equal(await data(page, "faces"), before, "what was decided stays until more is");

  // Cut, and decided by the page; then whole again, while the worker is still at the first request.
  const total = before.split("/")[1];
  await page.keyboard.press("z");
  await page.waitForFunction((t) => document.body.dataset.faces.split("/")[1] !== t, total, { timeout: WAIT });
  await settled(page);
  await page.keyboard.press("z");
  await drag(page, 40, 10);
  await page.waitForTimeout(1000);
  assert.equal(await data(page, "settled"), "no");
  // Once before the cut and once after it, however far the camera went.
  assert(await asked(own) <= 2, `a worker that has not answered is asked ${await asked(own)} times`);
  await own.evaluate(() => globalThis.go());
  await settled(page);
  assert(await asked(own) <= 3, "it is asked for what is newest alone");
  await page.waitForFunction(() => location.hash.includes("camera"), null, { timeout: WAIT });
  const faces = await data(page, "faces");
  assert(faces !== before && faces.endsWith(`/${total}`), `${before}, then ${faces}`);
  const again = await open(browser, page.url().replace(/\?webgl/, ""), "?webgl");
  assert.equal(await data(again.page, "faces"), faces, "the last answer is about the last view");
  console.log(`a worker that is late: faces ${before}, then ${faces}`);
  await again.page.close();
  await page.close();
}
