// Has Chromium's WebGPU list what many views see of many scenes: node lists.mjs MODULE_FOLDER ANSWERS
// Exits with 1 where that is not, to the byte, what ANSWERS says, which the CPU listed natively.
import { readFile } from "node:fs/promises";
import { basename, join } from "node:path";
import assert from "node:assert/strict";
import { WAIT, launch } from "./browser.mjs";

const [folder, answers] = process.argv.slice(2);
assert(folder && answers, "usage: node lists.mjs MODULE_FOLDER ANSWERS");
const expected = (await readFile(answers, "utf8")).trim();

const PAGE = `<!doctype html><title>lists</title><script type="module">
import init, { run } from "./lists_page.js";
globalThis.listed = init().then(async () => {
  const begun = performance.now();
  return { text: await run(), took: performance.now() - begun };
});
</script>`;
const TYPES = { js: "text/javascript", wasm: "application/wasm" };

const browser = await launch();
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(WAIT);
  const said = [];
  page.on("console", (m) => { if (["error", "warning"].includes(m.type())) said.push(`${m.type()}: ${m.text()}`); });
  // No server: WebGPU wants a secure address, and nothing else is asked there.
  await page.route("http://localhost/**", async (route) => {
    const name = basename(new URL(route.request().url()).pathname);
    const contentType = TYPES[name.split(".").pop()];
    if (!contentType) return route.fulfill({ body: name ? "" : PAGE, contentType: "text/html" });
    return route.fulfill({ body: await readFile(join(folder, name)), contentType });
  });
  await page.goto("http://localhost/");
  await page.waitForFunction(() => globalThis.listed);
  const { text, took } = await page.evaluate(() => globalThis.listed);
  assert.deepEqual(text.split("\n"), expected.split("\n"), "the browser lists what the CPU lists");
  const many = Math.max(...text.split("\n").map((line) => parseInt(line.split(", ")[1], 10)));
  assert(many >= 100_000, `at least a hundred thousand instances in one pass: ${many}`);
  assert.deepEqual(said, [], "the browser has nothing to complain of");
  console.log(`lists of ${text.split("\n").length} views of up to ${many} instances, byte for byte the CPU's, in ${Math.round(took)} ms`);
} finally {
  await browser.close();
}
