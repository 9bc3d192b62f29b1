/* The options of the chosen layer, what was found in its map, and the remedies. */

import { $ } from "../studio.js";
import { Form } from "./form.js";

// a group has these alone
const GROUP = ["name", "mode", "strength", "clip"];

export function setUpLayerDetails(studio, layers) {
  let forms = null;
  let own = null;
  let reading = null;
  let depth = null;

  const set = (values) => studio.ask({ do: "set-layer", place: layers.chosen.place, values });
  studio.on("forms", (message) => {
    forms = message;
    own = new Form($("layer-form"), forms.layer, (name, value) => set({ [name]: value }));
    reading = new Form($("layer-read"), forms.read, (name, value) => set({ read: { [name]: value } }));
    depth = new Form($("layer-depth"), forms.depth, () =>
      studio.ask({ do: "set-depth", place: layers.chosen.place, values: depth.values }),
    );
  });
  $("layer-remove").addEventListener("click", () => studio.ask({ do: "remove-layer", place: layers.chosen.place }));
  $("layer-double").addEventListener("click", () => studio.ask({ do: "double-layer", place: layers.chosen.place }));
  $("layer-detail").addEventListener("click", () => studio.ask({ do: "use-as-detail", place: layers.chosen.place }));
  $("layer-unmask").addEventListener("click", () => set({ mask: null }));

  layers.onChosen((layer) => {
    $("layer-details").hidden = !layer;
    if (!layer || !own) return;
    const isMap = layer.kind === "map";
    $("layer-title").textContent = layer.label;
    own.reveal(isMap ? [...own.inputs.keys()] : GROUP);
    own.show(layer.options);
    $("layer-reading").hidden = !isMap;
    reading.show(layer.read);
    const made = studio.document.depths[layer.file];
    $("layer-from-depth").hidden = !made;
    if (made) depth.show(made);
    $("layer-masked").hidden = !layer.mask;
    $("layer-mask").textContent = layer.mask ? short(layer.mask) : "";
    $("layer-file").textContent = layer.file ? short(layer.file) : "";
    $("layer-file").title = layer.file ?? "";
    $("layer-detail").hidden = !isMap || studio.document.layers.length < 2;
    $("layer-findings").replaceChildren(...layers.findingsOf(layer).map((found) => finding(studio, layer, found)));
  });
}

export function short(file) {
  return file.replaceAll("\\", "/").split("/").at(-1);
}

function finding(studio, layer, found) {
  const li = document.createElement("li");
  const text = document.createElement("p");
  text.textContent = found.remedy ? `${found.message}; ${found.remedy}` : found.message;
  li.append(text);
  for (const offer of found.offers) {
    const remedy = Object.assign(document.createElement("button"), { type: "button", textContent: `Use ${offer.label}` });
    remedy.addEventListener("click", () => {
      if (offer.of === "read") studio.ask({ do: "set-layer", place: layer.place, values: { read: offer.values } });
      else studio.ask({ do: "set", values: offer.values });
    });
    li.append(remedy);
  }
  return li;
}
