/* Files that are dropped on the window or chosen: they are sent to the server, and become layers or the document. */

import { $ } from "../studio.js";

export function setUpDrop(studio) {
  document.addEventListener("dragover", (event) => {
    if (!event.dataTransfer.types.includes("Files")) return;
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  document.addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) document.body.classList.remove("dropping");
  });
  document.addEventListener("drop", (event) => {
    document.body.classList.remove("dropping");
    if (!event.dataTransfer.files.length) return;
    event.preventDefault();
    take(studio, [...event.dataTransfer.files]);
  });
  $("add-files").addEventListener("click", () => $("files").click());
  $("files").addEventListener("change", () => {
    take(studio, [...$("files").files]);
    $("files").value = "";
  });
  studio.on("forms", (message) => fillRoles(message.files));
}

/** Send the files, then use each: a recipe last, because it names others. */
async function take(studio, files) {
  studio.say("");
  const sent = [];
  for (const file of files) {
    const answer = await send(studio, file);
    if (answer) sent.push(answer);
  }
  const recipe = sent.find((one) => one.kind === "recipe");
  if (recipe) {
    studio.ask({ do: "open-recipe", file: recipe.file });
    return;
  }
  for (const { file, kind } of sent) {
    if (kind === "map") studio.ask({ do: "add-layer", file });
    else if (kind === "mesh") studio.ask({ do: "open-mesh", file });
    else if (kind === "grey") await ask(studio, file);
  }
}

async function send(studio, file) {
  studio.tell(`reading ${file.name}`);
  try {
    const answer = await fetch(`files/${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    const found = await answer.json();
    if (answer.ok) return found;
    studio.say(found.text);
  } catch {
    studio.say(`${file.name}: the studio does not answer; start nmap studio again`);
  }
  return null;
}

function fillRoles(fields) {
  const roles = fields.filter((field) => field.name !== "detail");
  const uses = [
    ["depth", "heights or depths: a new layer"],
    ["layer", "a normal map: a new layer"],
    ...roles.map((field) => [field.name, `${field.label}: ${field.help}`]),
  ];
  uses.splice(2, 0, ["layer-mask", "mask of the chosen layer: white where it shows; has the size of its map"]);
  $("grey-uses").replaceChildren(...uses.map(([value, text]) => choice(value, text)));
}

function choice(value, text) {
  const label = document.createElement("label");
  const input = Object.assign(document.createElement("input"), { type: "radio", name: "use", value, required: true });
  input.checked = value === "depth";
  label.append(input, ` ${text}`);
  return label;
}

/** Ask what a grey picture is, and use it so. */
function ask(studio, file) {
  const dialog = $("grey-dialog");
  $("grey-name").textContent = file;
  dialog.querySelector("input[value=layer-mask]").disabled = studio.layers.chosen?.kind !== "map";
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener(
      "close",
      () => {
        const use = dialog.querySelector("input:checked").value;
        if (dialog.returnValue === "use") {
          if (use === "depth") studio.ask({ do: "add-depth", file });
          else if (use === "layer") studio.ask({ do: "add-layer", file });
          else if (use === "layer-mask") studio.ask({ do: "set-layer-mask", place: studio.layers.chosen.place, file });
          else studio.ask({ do: "set-file", role: use, file });
        }
        done();
      },
      { once: true },
    );
  });
}
