// Starts the viewer, or says plainly why it cannot start.
import init from "./cullet_viewer.js";

const message = document.getElementById("message");

function fail(text) {
  document.body.dataset.state = "failed";
  message.textContent = text;
}

async function hasWebGpu() {
  try { return Boolean(await navigator.gpu?.requestAdapter()); } catch { return false; }
}

// What the viewer itself says of its start.
new MutationObserver(() => {
  const { state, error } = document.body.dataset;
  if (state === "running") message.textContent = "";
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

// A link that is pasted into the open page. The viewer's own changes of the address do not come here.
addEventListener("hashchange", () => location.reload());
