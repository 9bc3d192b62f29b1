/* The list of layers. */

import { $ } from "../studio.js";

export function setUpLayers(studio) {
  studio.on("state", ({ layers }) => {
    const items = layers.map((layer) => Object.assign(document.createElement("li"), { textContent: layer.name }));
    $("layers").replaceChildren(...items);
  });
}
