// Opens the published book in Chromium: node published.mjs BOOK [PICTURES_FOLDER]
// Exits with 1 where a chapter misses something, under a path of a server or from the file system, or the page in it neither
// starts nor says why.
import assert from "node:assert/strict";
import { createServer } from "node:http";
import { readFile, readdir } from "node:fs/promises";
import { extname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { data, launch, running, WAIT } from "./browser.mjs";

const [folder, pictures] = process.argv.slice(2);
assert(folder, "usage: node published.mjs BOOK [PICTURES_FOLDER]");
const book = resolve(folder);
const TYPES = {
  ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml",
  ".txt": "text/plain; charset=utf-8",
};
// As deep as a host may put it.
const PATH = "/some/one's books/cullet/";

/** Serves the files of the book below a path, and nothing elsewhere. */
function serve() {
  const server = createServer(async (request, response) => {
    const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    try {
      assert(path.startsWith(PATH));
      const name = path.slice(PATH.length).replace(/(^|\/)$/, "$1index.html");
      const bytes = await readFile(join(book, name));
      response.writeHead(200, { "content-type": TYPES[extname(name)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((ready) => {
    server.listen(0, "127.0.0.1", () => ready({
      url: `http://127.0.0.1:${server.address().port}${encodeURI(PATH)}`,
      end: () => server.close(),
    }));
  });
}

/** A page that keeps what it misses. */
async function reader(browser) {
  const page = await browser.newPage();
  page.setDefaultTimeout(WAIT);
  const missed = [];
  // What the next chapter cuts short is not missing.
  page.on("requestfailed", (r) => {
    const why = r.failure()?.errorText;
    if (why !== "net::ERR_ABORTED") missed.push(`${r.url()}: ${why}`);
  });
  page.on("response", (r) => { if (r.status() >= 400) missed.push(`${r.url()}: ${r.status()}`); });
  page.on("pageerror", (e) => missed.push(`thrown: ${e}`));
  return { page, missed };
}

/** Opens every chapter, and looks at its contents and pictures. */
async function chapters(browser, url) {
  const { page, missed } = await reader(browser);
  const names = (await readdir(book)).filter((name) => name.endsWith(".html") && name !== "toc.html");
  assert(names.length > 40, `only ${names.length} chapters`);
  for (const name of names) {
    await page.goto(url + name, { waitUntil: "load" });
    const blank = await page.evaluate(async () => {
      const pictures = [...document.querySelectorAll("img")];
      await Promise.all(pictures.map((p) => p.decode().catch(() => {})));
      return pictures.filter((p) => p.naturalWidth === 0).map((p) => p.src);
    });
    assert.deepEqual(blank, [], `${name} shows them`);
    const links = await page.locator("#mdbook-sidebar a, .sidebar a").count();
    assert(links > 40, `${name} has ${links} links beside it`);
    assert.deepEqual(missed, [], `${name} misses them`);
  }
  // From a chapter to its live scene, as a reader goes.
  await page.goto(`${url}frustum.html`);
  const live = page.getByRole("link", { name: "Open this state" });
  assert.equal(new URL(await live.evaluate((a) => a.href)).pathname, new URL(`${url}viewer/index.html`).pathname);
  await page.close();
  return names.length;
}

/** Turns over the slides of the lectures, as a lecturer would. */
async function slides(browser, url, pictures) {
  const { page, missed } = await reader(browser);
  await page.setViewportSize({ width: 1280, height: 720 });
  await page.goto(`${url}lectures.html`);
  await page.getByRole("link", { name: "As slides" }).click();
  const turned = (number) => page.waitForFunction((n) => document.querySelector("h1")?.textContent.startsWith(`${n}. `), number);
  await turned(1);
  const all = await page.locator("#number option").count();
  assert(all > 100, `${all} items`);
  const errors = [];
  for (let n = 1; n <= all; n++) {
    await turned(n);
    const said = await page.locator("#message").innerText();
    assert(!said.includes("undefined") && await page.locator("p.where, p.here").count() === 2, said);
    if (await page.locator("p.error").count()) errors.push(n);
    const scene = page.frames()[1].url();
    assert(scene.startsWith(url) && !/[()]|%20/.test(scene.slice(url.length)), `${n}: ${scene} lies beside it`);
    if (n < all) await page.locator("#next").click();
  }
  assert(errors.length >= 10, `errors of the texts: ${errors}`);
  // One lecture alone; a scene of it that is culled here and now; its chapter.
  await page.selectOption("#text", "ucsd");
  const part = await page.locator("#number option").count();
  assert(part > 10 && part < all, `${part} items of one lecture`);
  await page.selectOption("#text", "");
  await page.selectOption("#number", "13");
  await turned(13);
  await page.locator("#now:not(:empty)").waitFor();
  assert.match(await page.locator("#now").innerText(), /[\d,]+ of [\d,]+ triangles are left/);
  assert.equal(await page.frames()[1].evaluate(() => document.body.dataset.notice), "");
  // By the keys of a pointer for slides, too.
  await page.keyboard.press("PageDown");
  await turned(14);
  await page.keyboard.press("PageUp");
  await turned(13);
  await page.locator("#now:not(:empty)").waitFor();
  if (pictures) await page.screenshot({ path: join(pictures, "slides.png") });
  await page.setViewportSize({ width: 360, height: 720 });
  assert(await page.evaluate(() => document.documentElement.scrollWidth) <= 360, "it fits a phone");
  if (pictures) await page.screenshot({ path: join(pictures, "slides-phone.png") });
  await page.selectOption("#number", String(all));
  await turned(all);
  await page.goBack();
  await turned(13);
  await page.goForward();
  await turned(all);
  await page.getByRole("link", { name: "The chapter" }).click();
  await page.waitForURL(/cutting\.html/);
  assert.deepEqual(missed, [], "the slides miss nothing");
  console.log(`${all} slides of the lectures, ${errors.length} with an error of a text: the last leads to its chapter`);
  await page.close();
}

const browser = await launch();
try {
  const files = `${pathToFileURL(book)}/`;
  console.log(`${await chapters(browser, files)} chapters open from the file system, with all that they show`);
  const { page } = await reader(browser);
  await page.goto(`${files}viewer/index.html#scene=city`);
  const said = await page.locator("#message").innerText();
  assert(said.includes("python3 -m http.server"), `the page says what to do: ${said}`);
  assert.equal(await data(page, "state"), "failed");
  await page.close();

  const server = await serve();
  console.log(`${await chapters(browser, server.url)} chapters open at ${server.url}`);
  const served = await reader(browser);
  await served.page.goto(`${server.url}viewer/index.html?webgl#scene=solids:n=9`);
  await running(served.page);
  assert.deepEqual(served.missed, [], "the page misses nothing");
  console.log("the page in the book starts there");
  // From the first chapter to the tour, with nothing pressed.
  await served.page.goto(`${server.url}index.html`);
  await served.page.getByRole("link", { name: "the tour" }).click();
  await served.page.waitForFunction(() => document.body.dataset.step === "1/14");
  assert.deepEqual(served.missed, [], "the tour misses nothing");
  await slides(browser, server.url, pictures);
  server.end();
} finally {
  await browser.close();
}
