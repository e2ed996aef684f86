// Parses one file, in a memory of its own, so that the page stays responsive.
import init, { parse } from "./cullet_viewer.js";

onmessage = async ({ data: { module, name, bytes } }) => {
  try {
    await init({ module_or_path: module });
    const packed = parse(name, bytes);
    postMessage(packed, [packed.buffer]);
  } catch (error) {
    // A text is the file's own error; anything else broke off.
    if (typeof error !== "string") throw error;
    postMessage(error);
  }
};
// Errors of promises reach the page only as errors of the worker.
addEventListener("unhandledrejection", (event) => { throw event.reason; });
