// Parses a file, with those that it names, or makes a built-in scene, in a memory of its own, and decides from then on
// what of it is drawn: so the page goes on drawing meanwhile.
import init, { build, decide, keep, named, parse } from "./cullet_viewer.js";

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

const hand = (bytes) => postMessage(bytes, [bytes.buffer]);

async function load({ module, name, files }) {
  try {
    await init({ module_or_path: module });
    hand(files ? parse([...files, ...await beside(files[0])]) : build(name));
  } catch (error) {
    // A text is an error of the file or of the scene's settings; anything else broke off.
    if (typeof error !== "string") throw error;
    return postMessage(error);
  }
  // Once the page has its bytes: it unpacks them at the same time.
  keep();
}

// The first message is a scene to load; all others are requests about it.
onmessage = ({ data }) => data.request ? hand(decide(data.request)) : load(data);
// Errors of promises reach the page only as errors of the worker.
addEventListener("unhandledrejection", (event) => { throw event.reason; });
