// The picture of the example page: node test/three/shot.mjs FILE.png
import { launch, serve } from './harness.mjs';

const { url, close } = await serve();
const browser = await launch();
const page = await browser.newPage({ viewport: { width: 960, height: 540 } });
page.on('pageerror', (e) => console.log(String(e)));
page.on('console', (m) => m.type() === 'error' && console.log(m.text()));
await page.goto(`${url}/example/`);
await page.waitForSelector('body[data-state]', { state: 'attached', timeout: 40_000 });
const panel = async () => (await page.locator('table, dl').allInnerTexts()).join('; ').replace(/\s+/g, ' ');
await page.waitForTimeout(4000);
console.log('all:', await panel());
// The loop stops: a screenshot waits for a page that is at rest.
if (process.argv[2]) await page.evaluate(() => { window.requestAnimationFrame = () => 0; });
if (process.argv[2]) await page.screenshot({ path: process.argv[2] });
for (const key of process.argv[2] ? [] : ['3', '2', '1']) { await page.keyboard.press(key); await page.waitForTimeout(8000); console.log(`key ${key}:`, await panel()); }
await browser.close();
close();
