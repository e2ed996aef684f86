// The viewer's controls as a list, for readers of a screen and for the keyboard alone.
import assert from "node:assert/strict";
import { join } from "node:path";
import { changed, data, open, settled } from "./browser.mjs";

export async function controls(browser, url, pictures) {
  const { page } = await open(browser, url, "?webgl");
  const focused = () => page.evaluate(() => document.activeElement.id);
  // Out of the canvas and to the list, by keys.
  await page.focus("#canvas");
  await page.keyboard.press("F6");
  assert.equal(await focused(), "list", "F6 leaves the canvas");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelectorAll("#controls > *").length > 20);
  assert.equal(await focused(), "controls");
  const named = await page.$$eval("#controls > :not(p)", (all) => all.map((e) => e.ariaLabel ?? e.textContent));
  assert(named.every((name) => name.trim() !== ""), `controls without a name: ${named}`);
  console.log(`controls: ${named.length} by name`);
  // A switch is thrown, says so, and culls no more; the focus stays on it.
  const before = await data(page, "faces");
  const frustum = page.locator("#controls [role=checkbox]", { hasText: "frustum" }).first();
  assert.equal(await frustum.getAttribute("aria-checked"), "true");
  await frustum.focus();
  if (pictures) await page.screenshot({ path: join(pictures, "controls.png") });
  await page.keyboard.press("Space");
  await changed(page, "faces", before);
  await settled(page);
  assert.equal(await frustum.getAttribute("aria-checked"), "false");
  assert(await frustum.evaluate((e) => e === document.activeElement), "the focus stays on a switch that was thrown");
  await page.keyboard.press("Space");
  await changed(page, "faces", await data(page, "faces"));
  await settled(page);
  assert.equal(await data(page, "faces"), before);
  // Tab goes past the canvas now.
  await page.focus("#canvas");
  await page.keyboard.press("Tab");
  assert.notEqual(await focused(), "canvas", "Tab is no trap");
  await page.close();
}
