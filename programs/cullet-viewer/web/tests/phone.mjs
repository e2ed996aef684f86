// The page on a telephone: fingers turn, move and zoom, and nothing is cut off.
import assert from "node:assert/strict";
import { join } from "node:path";
import { open, settled, WAIT } from "./browser.mjs";

const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 3, hasTouch: true, isMobile: true };
const MIDDLE = [195, 450];

export async function phone(browser, url, pictures) {
  const context = await browser.newContext(PHONE);
  // Where Chromium only pretends to a pixel ratio it gives this in points, which no telephone does.
  await context.addInitScript(() => delete ResizeObserverEntry.prototype.devicePixelContentBoxSize);
  const { page } = await open(context, url.replace(/#.*/, "#scene=office"), "?webgl");
  const shoot = async (name) => {
    await page.waitForTimeout(1500);
    if (pictures) await page.screenshot({ path: join(pictures, `phone-${name}.png`) });
  };
  await shoot("first");
  const size = await page.evaluate(() => {
    const canvas = document.getElementById("canvas");
    return [canvas.width, canvas.height, document.documentElement.scrollWidth];
  });
  assert.deepEqual(size, [390 * 3, 844 * 3, 390], "the picture has the pixels of the screen, and nothing is wider");

  const device = await page.context().newCDPSession(page);
  const touch = (type, points) =>
    device.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  /** Moves fingers from where they are put down to where they are lifted, in steps as a screen reports them. */
  const move = async (from, to) => {
    const before = await page.evaluate(() => location.hash);
    await touch("touchStart", from);
    const steps = 8;
    for (let i = 1; i <= steps; i++) {
      await touch("touchMove", from.map(([x, y], n) => [x + ((to[n][0] - x) * i) / steps, y + ((to[n][1] - y) * i) / steps]));
      await page.waitForTimeout(40);
    }
    await touch("touchEnd", []);
    await page.waitForFunction((b) => location.hash !== b, before, { timeout: WAIT })
      .catch(() => assert.fail("fingers do not move the camera"));
    await settled(page);
    return camera();
  };
  const camera = async () => {
    const link = new URLSearchParams((await page.evaluate(() => location.hash)).slice(1));
    return Object.fromEntries([...link].filter(([key]) => key.startsWith("camera")));
  };
  const [x, y] = MIDDLE;
  const first = await camera();
  const turned = await move([[x, y]], [[x + 90, y + 20]]);
  const slid = await move([[x - 50, y], [x + 50, y]], [[x - 50, y + 80], [x + 50, y + 80]]);
  const zoomed = await move([[x - 40, y], [x + 40, y]], [[x - 120, y], [x + 120, y]]);
  console.log(`phone: turned to ${turned["camera.yaw"]}, moved to ${slid["camera.target"]}, zoomed to ${zoomed["camera.distance"]}`);
  const same = (a, b, ...names) => names.every((n) => a[`camera.${n}`] === b[`camera.${n}`]);
  assert(!same(first, turned, "yaw") && same(first, turned, "target", "distance"), "one finger turns, and no more");
  assert(!same(turned, slid, "target") && same(turned, slid, "yaw", "pitch"), "two fingers move, and turn nothing");
  const nearer = zoomed["camera.distance"] / slid["camera.distance"];
  assert(nearer < 0.6 && same(slid, zoomed, "yaw", "pitch"), `two fingers zoom: ${nearer}`);
  await shoot("zoomed");
  await context.close();
}
