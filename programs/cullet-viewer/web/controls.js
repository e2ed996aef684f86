// Elements for the controls that the canvas draws, for readers of a screen and for the keyboard: data-controls has a line for
// each (controls.rs), and what is done to one goes back in data-control.
const list = document.getElementById("controls");
const canvas = document.getElementById("canvas");
const made = new Map();

function order(text) {
  document.body.dataset.control = text;
  // One of the events after which the viewer draws.
  dispatchEvent(new Event("popstate"));
}

function make(id, kind) {
  const element = document.createElement(kind === "number" ? "input" : kind === "text" ? "p" : "button");
  if (kind === "number") {
    Object.assign(element, { type: "number", step: "any", onchange: () => order(`${id} ${element.value}`) });
  } else if (kind !== "text") {
    element.onclick = () => order(id);
    if (kind !== "button") element.setAttribute("role", kind);
  }
  element.dataset.kind = kind;
  return element;
}

function show() {
  const rows = (document.body.dataset.controls ?? "").split("\n").filter(Boolean).map((row) => row.split("\t"));
  const old = new Map(made);
  made.clear();
  const hadFocus = list.contains(document.activeElement);
  for (const [id, kind, name, state, value, min, max] of rows) {
    let element = old.get(id);
    if (element?.dataset.kind === kind) old.delete(id);
    else element = make(id, kind);
    made.set(id, element);
    if (kind === "number") {
      element.setAttribute("aria-label", name);
      Object.assign(element, { min, max });
      if (element !== document.activeElement) element.value = Number(Number(value).toPrecision(6));
    } else if (element.textContent !== name) element.textContent = name;
    element.disabled = state === "disabled";
    if (state === "on" || state === "off") {
      element.setAttribute(kind === "button" ? "aria-pressed" : "aria-checked", state === "on");
    }
  }
  for (const element of old.values()) element.remove();
  // What is in its place stays there: an element that is moved loses the focus.
  [...made.values()].forEach((element, at) => {
    if (list.children[at] !== element) list.insertBefore(element, list.children[at] ?? null);
  });
  if (hadFocus && !list.contains(document.activeElement)) list.focus();
}

new MutationObserver(show).observe(document.body, { attributes: true, attributeFilter: ["data-controls"] });

document.getElementById("list").onclick = () => {
  order("on");
  list.focus();
};

// The viewer takes Tab for what the canvas draws; where that is in the list as well, Tab goes on, and F6 leaves it always.
addEventListener("keydown", (event) => {
  if (event.target !== canvas) return;
  if (event.key === "F6") document.getElementById("list").focus();
  if (event.key === "Tab" && made.size > 0) event.stopPropagation();
}, true);
