// The worker that made a scene decides what of it is drawn; without it the page does so by itself.
import assert from "node:assert/strict";
import { WAIT, changed, data, drag, drop, open, settled } from "./browser.mjs";

/** Counts what the page's worker is asked from now on. */
const count = (worker) => worker.evaluate(() => {
  const answer = globalThis.onmessage;
  globalThis.asked = 0;
  globalThis.onmessage = (event) => { globalThis.asked += 1; return answer(event); };
});
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
}
