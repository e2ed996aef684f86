// Starts the viewer, or says plainly why it cannot start.
import init from "./cullet_viewer.js";

const message = document.getElementById("message");

function fail(text) {
  document.body.dataset.state = "failed";
  message.textContent = text;
}

// Nothing more can be drawn; the address has the scene, the camera and the switches.
function lost(why) {
  message.textContent = `The viewer stopped: ${why}.\n\nOpened again it shows what it showed; a file that was dropped or chosen is to be `
    + "given once more. If it happens again, close other pages that draw, or add ?webgl to the address.\n\n";
  const again = document.createElement("button");
  again.textContent = "Open again";
  again.onclick = () => location.reload();
  message.append(again);
  again.focus();
}

async function hasWebGpu() {
  try { return Boolean(await navigator.gpu?.requestAdapter()); } catch { return false; }
}

// The tour by buttons that a reader of a screen finds; the viewer takes the order with its next picture.
document.getElementById("tour").onclick = ({ target }) => {
  if (!target.dataset.order) return;
  document.body.dataset.order = target.dataset.order;
  // One of the events after which it draws.
  dispatchEvent(new Event("popstate"));
};

// What the viewer itself says of its start and its end.
new MutationObserver(() => {
  const { state, error } = document.body.dataset;
  if (state === "running") {
    message.textContent = "";
    // In a frame of another page it keeps no focus that nobody gave it.
    frameElement?.blur();
  }
  if (state === "lost") lost(error);
  if (state === "failed" && error) {
    message.textContent = `The viewer did not start: ${error}\n\nTry the page with ?webgl in its address, or another browser.`;
  }
}).observe(document.body, { attributes: true, attributeFilter: ["data-state", "data-error"] });

if (document.createElement("canvas").getContext("webgl2") === null && !await hasWebGpu()) {
  fail("This browser gives the page neither WebGPU nor WebGL2, so nothing can be drawn.\n\n"
    + "Turn on hardware acceleration in the browser's settings, update the browser or the graphics driver, "
    + "or run the native viewer: cargo run --release -p cullet-viewer");
} else {
  init().catch((error) => fail(`The viewer cannot be loaded: ${error?.message ?? error}`));
}

// WebGL's way to lose its device; the viewer tells of WebGPU's.
document.getElementById("canvas").addEventListener("webglcontextlost", () => {
  document.body.dataset.error = "the graphics device was lost: the browser took WebGL away";
  document.body.dataset.state = "lost";
});

// A picture that the viewer took of itself, as RGBA.
addEventListener("picture", async ({ detail: { width, pixels } }) => {
  const image = new ImageData(pixels, width);
  const canvas = new OffscreenCanvas(image.width, image.height);
  canvas.getContext("2d").putImageData(image, 0, 0);
  const address = URL.createObjectURL(await canvas.convertToBlob());
  const link = document.createElement("a");
  Object.assign(link, { href: address, download: "cullet.png" });
  link.click();
  // The download has begun by then.
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
});

// A link that is pasted into the open page. The viewer's own changes of the address do not come here.
addEventListener("hashchange", () => location.reload());
