// Parses a file, with those that it names, or makes a built-in scene, in a memory of its own, so that the page stays responsive.
import init, { build, parse } from "./cullet_viewer.js";

onmessage = async ({ data: { module, name, files } }) => {
  try {
    await init({ module_or_path: module });
    const packed = files ? parse(files) : build(name);
    postMessage(packed, [packed.buffer]);
  } catch (error) {
    // A text is an error of the file or of the scene's settings; anything else broke off.
    if (typeof error !== "string") throw error;
    postMessage(error);
  }
};
// Errors of promises reach the page only as errors of the worker.
addEventListener("unhandledrejection", (event) => { throw event.reason; });
