// A picture of the page: node picture.mjs CULLET_SERVE PAGE_FOLDER SCENE STATE FILE
import assert from "node:assert/strict";
import { drag, launch, open, settled, start } from "./browser.mjs";

const [serve, page_folder, scene, state, file] = process.argv.slice(2);
assert(file, "usage: node picture.mjs CULLET_SERVE PAGE_FOLDER SCENE STATE FILE");
const browser = await launch();
try {
  const server = await start(serve, page_folder, scene);
  const { page } = await open(browser, server.url + (state && `&${state}`), "");
  // The figures of the first view are those of a program that finds everything cold: turn there and back.
  for (const dx of [40, -40]) {
    await drag(page, dx, 0);
    await page.waitForTimeout(1000);
    await settled(page);
  }
  await page.screenshot({ path: file });
  await server.end();
} finally {
  await browser.close();
}
