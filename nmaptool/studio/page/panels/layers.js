/* The list of layers, topmost first: shown or hidden, chosen, and put in another order. */

import { $ } from "../studio.js";
import { setUpLayerDetails } from "./layer.js";

export function setUpLayers(studio) {
  const chosen = { place: null, listeners: [] };
  let shown = [];
  let findings = new Map();

  function choose(place) {
    chosen.place = place;
    build();
    for (const listener of chosen.listeners) listener(layerAt(shown, place));
  }

  function build() {
    const at = document.activeElement?.dataset?.key;
    $("layers").replaceChildren(...flat(shown).map((layer) => item(studio, layer, chosen, findings, choose)));
    if (at) $("layers").querySelector(`[data-key="${at}"]`)?.focus();
  }

  studio.on("state", (message) => {
    const isNew = message.layers.length === shown.length + 1 && shown.length > 0;
    shown = message.layers;
    $("no-layers").hidden = shown.length > 0;
    if (!layerAt(shown, chosen.place)) chosen.place = null;
    if (isNew) studio.emit("added");
    choose(isNew ? [shown.length - 1] : chosen.place);
  });
  studio.on("findings", (message) => {
    findings = new Map(message.layers.map((one) => [key(one.place), one.findings]));
    choose(chosen.place);
  });
  const layers = {
    /** Call `listener` with the chosen layer, or undefined, whenever it or the document changes. */
    onChosen: (listener) => chosen.listeners.push(listener),
    choose,
    get chosen() {
      return layerAt(shown, chosen.place);
    },
    findingsOf: (layer) => findings.get(key(layer.place)) ?? [],
  };
  setUpLayerDetails(studio, layers);
  return layers;
}

const key = (place) => place.join(".");

/** The layer at a place; undefined if there is none. */
export function layerAt(layers, place) {
  let found;
  for (const number of place ?? []) {
    found = layers[number];
    layers = found?.layers ?? [];
  }
  return found;
}

/** The layers as the list shows them: topmost first, those of a group below it. */
export function flat(layers) {
  return [...layers].reverse().flatMap((layer) => [layer, ...flat(layer.layers)]);
}

function item(studio, layer, chosen, findings, choose) {
  const li = document.createElement("li");
  li.style.marginLeft = `${layer.place.length - 1}rem`;
  li.className = "layer";
  const isChosen = chosen.place && key(chosen.place) === key(layer.place);
  if (isChosen) li.classList.add("chosen");
  const found = findings.get(key(layer.place)) ?? [];
  const eye = button(layer.hidden ? "○" : "●", `${layer.hidden ? "Show" : "Hide"} ${layer.label}`, `eye${key(layer.place)}`, () =>
    studio.ask({ do: "set-layer", place: layer.place, values: { hidden: !layer.hidden } }),
  );
  eye.setAttribute("aria-pressed", String(!layer.hidden));
  const name = button(layer.label, "", `name${key(layer.place)}`, () => choose(isChosen ? null : layer.place));
  name.className = "name";
  name.setAttribute("aria-expanded", String(Boolean(isChosen)));
  if (found.length > 0) name.append(badge(found));
  const by = (steps) => {
    chosen.place = [...layer.place.slice(0, -1), layer.place.at(-1) + steps];
    studio.ask({ do: "move-layer", place: layer.place, to: steps > 0 ? [...chosen.place.slice(0, -1), chosen.place.at(-1) + 1] : chosen.place });
  };
  const up = button("↑", `Move ${layer.label} up`, `up${key(layer.place)}`, () => by(1));
  const down = button("↓", `Move ${layer.label} down`, `down${key(layer.place)}`, () => by(-1));
  down.disabled = layer.place.at(-1) === 0;
  up.disabled = layer.place.at(-1) + 1 === siblings(studio.document.layers, layer.place);
  li.append(eye, name, up, down);
  drags(studio, li, layer);
  return li;
}

function badge(found) {
  const mark = Object.assign(document.createElement("span"), { className: "badge", textContent: String(found.length) });
  mark.title = found.map((one) => one.message).join("\n");
  mark.setAttribute("aria-label", `${found.length} ${found.length === 1 ? "finding" : "findings"}`);
  mark.setAttribute("role", "img");
  return mark;
}

function siblings(layers, place) {
  return place.length === 1 ? layers.length : layerAt(layers, place.slice(0, -1)).layers.length;
}

function button(text, label, name, clicked) {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: text });
  if (label) {
    made.setAttribute("aria-label", label);
    made.title = label;
  }
  made.dataset.key = name;
  made.addEventListener("click", clicked);
  return made;
}

/** Order by drag: a layer dropped on the upper half of another goes above it, otherwise below it. */
function drags(studio, li, layer) {
  li.draggable = true;
  li.addEventListener("dragstart", (event) => {
    event.dataTransfer.setData("application/x-layer", JSON.stringify(layer.place));
    event.dataTransfer.effectAllowed = "move";
  });
  const half = (event) => (event.offsetY < li.clientHeight / 2 ? "above" : "below");
  li.addEventListener("dragover", (event) => {
    if (!event.dataTransfer.types.includes("application/x-layer")) return;
    event.preventDefault();
    li.dataset.drop = half(event);
  });
  li.addEventListener("dragleave", () => delete li.dataset.drop);
  li.addEventListener("drop", (event) => {
    const text = event.dataTransfer.getData("application/x-layer");
    const above = half(event) === "above";
    delete li.dataset.drop;
    if (!text) return;
    event.preventDefault();
    event.stopPropagation();
    const to = [...layer.place.slice(0, -1), layer.place.at(-1) + (above ? 1 : 0)];
    studio.ask({ do: "move-layer", place: JSON.parse(text), to });
  });
}
