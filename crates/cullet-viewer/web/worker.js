// Parses a file, with those that it names, or makes a built-in scene, in a memory of its own, so that the page stays responsive.
import init, { build, named, parse } from "./cullet_viewer.js";

// What a served model names is served beside it; of what is missing the parser tells.
async function beside([address, bytes]) {
  const folder = "/scene/";
  if (!address.startsWith(folder)) return [];
  const files = named(address, bytes).map(async (path) => {
    const answer = await fetch(folder + path.split("/").map(encodeURIComponent).join("/"));
    return answer.ok ? [[path, new Uint8Array(await answer.arrayBuffer())]] : [];
  });
  return (await Promise.all(files)).flat();
}

onmessage = async ({ data: { module, name, files } }) => {
  try {
    await init({ module_or_path: module });
    const packed = files ? parse([...files, ...await beside(files[0])]) : build(name);
    postMessage(packed, [packed.buffer]);
  } catch (error) {
    // A text is an error of the file or of the scene's settings; anything else broke off.
    if (typeof error !== "string") throw error;
    postMessage(error);
  }
};
// Errors of promises reach the page only as errors of the worker.
addEventListener("unhandledrejection", (event) => { throw event.reason; });
