// The tour by the keyboard alone, and by the buttons that readers of a screen find.
import assert from "node:assert/strict";
import { join } from "node:path";
import { changed, data, open, settled, WAIT } from "./browser.mjs";

const spoken = (page) => page.textContent("#spoken");

export async function tour(browser, url, pictures) {
  const context = await browser.newContext({ viewport: { width: 960, height: 600 }, reducedMotion: "reduce" });
  const { page } = await open(context, url.replace(/#.*/, "#scene=solids"), "?webgl");
  await page.focus("#canvas");
  await page.keyboard.press("Enter");
  let step = await changed(page, "step", "");
  const all = Number(step.split("/")[1]);
  for (let n = 1; n <= all; n++) {
    assert.equal(step, `${n}/${all}`);
    assert.match(await spoken(page), new RegExp(`^Step ${n} of ${all}: .*Question: .*1: .*2: `));
    // By buttons now and then.
    if (n % 4 === 0) await page.locator("#tour button[data-order='1']").press("Enter");
    else await page.keyboard.press("2");
    const answer = await changed(page, "answer", "");
    await page.waitForFunction(() => !document.getElementById("spoken").textContent.startsWith("Step"), null, { timeout: WAIT });
    const said = await spoken(page);
    assert(said.startsWith(answer === "right" ? "Right." : "Not quite."), said);
    console.log(`tour: ${step}: ${said}`);
    if (pictures) await page.screenshot({ path: join(pictures, `tour-${n}.png`) });
    await page.focus("#canvas");
    await page.keyboard.press("Enter");
    step = await changed(page, "step", step);
  }
  assert.equal(step, "", "the tour has ended");
  await settled(page);
  assert.equal(await data(page, "scene"), "solids");
  await context.close();
}
