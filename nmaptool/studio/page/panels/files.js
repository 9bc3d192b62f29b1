/* The files of the relief besides its layers: the detail map, masks and weights. */

import { $ } from "../studio.js";
import { short } from "./layer.js";

export function setUpFiles(studio) {
  let fields = [];
  const show = () => {
    const used = fields.filter((field) => studio.document?.files[field.name]);
    $("files-title").hidden = used.length === 0;
    $("relief-files").replaceChildren(...used.map((field) => item(studio, field)));
  };
  studio.on("forms", (message) => {
    fields = message.files;
    show();
  });
  studio.on("state", show);
}

function item(studio, field) {
  const name = studio.document.files[field.name];
  const li = document.createElement("li");
  const text = Object.assign(document.createElement("span"), { textContent: `${field.label}: ${short(name)}`, title: field.help });
  const remove = Object.assign(document.createElement("button"), { type: "button", textContent: "Remove" });
  remove.setAttribute("aria-label", `Remove the ${field.label}`);
  remove.addEventListener("click", () => studio.ask({ do: "set-file", role: field.name, file: null }));
  li.append(text, remove);
  return li;
}
