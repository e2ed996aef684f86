// The lectures, an item at a time, as slides: the claim, what was measured of it, and its scene to turn. lectures.json is
// the book's own docs/lectures.json.
const by = (id) => document.getElementById(id);
const scene = by("scene");
// In a published book the chapters lie beside the viewer's folder.
const inBook = location.pathname.split("/").at(-2) === "viewer";

/** What a slide shows of an item. */
function slide(item) {
  // A figure is "1,234", "1,234 = FORMULA" or "1.2 ~ = FORMULA".
  const figures = (item.figures ?? []).map((figure) => figure.split(" = ")[0].split(" ~")[0]);
  const measured = item.measured.split("{}").map((part, at) => part + (figures[at] ?? "")).join("");
  const { number, claim, command, chapter, live } = item;
  return {
    number: String(number), title: `${number}. ${item.title}`, claim, command,
    texts: item.places.map(({ text }) => text),
    where: item.places.map(({ text, at }) => `${text}, ${at}`).join("; "),
    text: item.said && `The text: ${item.said}.`,
    here: `Here: ${measured}.`,
    error: item.fault && `The text errs. ${item.fault}`,
    live: live && `index.html#scene=${live.scene}&${live.state}`,
    chapter: chapter.replace(".md", ".html"),
  };
}

/** A paragraph, with what stands between back quotes as code. */
function paragraph(text, kind) {
  const p = document.createElement("p");
  if (kind) p.className = kind;
  text.replaceAll("*", "").split("`").forEach((part, at) => {
    const place = at % 2 ? p.appendChild(document.createElement("code")) : p;
    place.append(part);
  });
  return p;
}

function heading(text) {
  const h = document.createElement("h1");
  h.textContent = text;
  return h;
}

function link(href, textContent) {
  return Object.assign(document.createElement("a"), { href, textContent });
}

function show(item) {
  const parts = [heading(item.title), paragraph(item.where, "where"), paragraph(item.claim)];
  if (item.text) parts.push(paragraph(item.text, "text"));
  if (item.here) parts.push(paragraph(item.here, "here"));
  if (item.error) parts.push(paragraph(item.error, "error"));
  parts.push(paragraph(`On your machine: \`cullet lecture ${item.number}\`, and \`${item.command}\`.`));
  const links = document.createElement("p");
  if (item.live) links.append(link(item.live, "All switches of this scene"), document.createElement("br"));
  if (inBook) links.append(link(`../${item.chapter}`, "The chapter"));
  by("message").replaceChildren(...parts, links);
  by("number").value = item.number;
  document.title = `${item.title} · cullet`;
  by("now").textContent = "";
  // What has no scene has its chapter beside it.
  const address = item.live ? `${item.live}&panels=false` : (inBook ? `../${item.chapter}` : "index.html");
  scene.title = item.live ? "The item's scene in the viewer" : "The item's chapter";
  // In place of the one before, so that the browser's button leads to the item before.
  scene.contentWindow.location.replace(new URL(address, location.href));
}

/** What the viewer beside decides now, measured where the page is read. */
function watch() {
  const body = scene.contentDocument?.body;
  if (!body || !scene.contentDocument.getElementById("canvas")) return;
  const tell = () => {
    if (body.dataset.settled !== "yes" || !body.dataset.faces) return;
    const [left, all] = body.dataset.faces.split("/").map(Number);
    by("now").textContent = `In this view, culled in your browser now: ${left.toLocaleString("en")} of ${all.toLocaleString("en")} triangles are left.`;
  };
  new MutationObserver(tell).observe(body, { attributes: true });
  tell();
}

async function begin() {
  const answer = await fetch("lectures.json");
  if (!answer.ok) throw new Error(`lectures.json: ${answer.status} ${answer.statusText}`);
  const { texts, items: all } = await answer.json();
  const items = all.map(slide);
  for (const { name, about } of texts) {
    const option = by("text").appendChild(new Option(name, name));
    option.title = about;
  }
  let shown = items;
  const at = () => shown.findIndex((item) => item.number === location.hash.slice(1));
  const go = (n) => { if (shown[n]) location.hash = shown[n].number; };
  const list = () => {
    const text = by("text").value;
    shown = items.filter((item) => !text || item.texts.includes(text));
    by("number").replaceChildren(...shown.map((item) => new Option(item.title, item.number)));
  };
  const turn = () => {
    if (at() < 0) return go(0);
    by("back").disabled = at() === 0;
    by("next").disabled = at() === shown.length - 1;
    show(shown[at()]);
  };
  by("where").onsubmit = (event) => event.preventDefault();
  by("text").onchange = () => { list(); turn(); };
  by("number").onchange = () => { location.hash = by("number").value; };
  by("back").onclick = () => go(at() - 1);
  by("next").onclick = () => go(at() + 1);
  addEventListener("keydown", (event) => {
    if (event.target.tagName === "SELECT" || event.altKey || event.ctrlKey || event.metaKey) return;
    const step = { ArrowRight: 1, PageDown: 1, ArrowLeft: -1, PageUp: -1 }[event.key];
    if (step) go(at() + step);
  });
  addEventListener("hashchange", turn);
  scene.onload = watch;
  list();
  turn();
}

if (location.protocol !== "file:") {
  begin().catch((error) => { by("message").textContent = `The lectures cannot be shown: ${error.message}`; });
}
