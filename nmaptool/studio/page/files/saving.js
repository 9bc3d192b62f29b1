/* Open, save, save under another name, undo and redo; and the work that was not saved. */

import { $ } from "../studio.js";

export function setUpSaving(studio) {
  const save = () => (studio.document?.path ? studio.ask({ do: "save" }) : saveAs(studio));
  const undo = () => studio.ask({ do: "undo" });
  const redo = () => studio.ask({ do: "redo" });
  $("undo").addEventListener("click", undo);
  $("redo").addEventListener("click", redo);
  $("save").addEventListener("click", save);
  $("save-as").addEventListener("click", () => saveAs(studio));
  $("open").addEventListener("click", () => studio.ask({ do: "recipes" }));
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || document.querySelector("dialog[open]")) return;
    const key = event.key.toLowerCase();
    if (key === "z") (event.shiftKey ? redo : undo)();
    else if (key === "y") redo();
    else if (key === "s") (event.shiftKey ? () => saveAs(studio) : save)();
    else if (key === "o") studio.ask({ do: "recipes" });
    else return;
    event.preventDefault();
  });
  studio.on("state", (message) => {
    $("saved").textContent = message.is_saved ? "saved" : "not saved";
    $("undo").disabled = message.undo === 0;
    $("redo").disabled = message.redo === 0;
    $("save").disabled = $("save-as").disabled = $("export").disabled = message.layers.length === 0;
    document.body.classList.toggle("empty", message.layers.length === 0);
  });
  setUpSaveDialog(studio);
  setUpOpenDialog(studio);
  studio.on("unsaved", ({ items }) => {
    $("unsaved").hidden = items.length === 0;
    $("unsaved").replaceChildren(...items.map((item) => unsaved(studio, item)));
  });
}

function saveAs(studio) {
  if (!studio.document?.layers.length) return;
  const { name } = studio.document;
  $("save-name").value = name.endsWith(".toml") ? name : `${name}.toml`;
  $("save-overwrite").checked = false;
  $("save-exists").hidden = true;
  $("save-error").textContent = "";
  $("save-dialog").showModal();
  $("save-name").select();
}

function setUpSaveDialog(studio) {
  const dialog = $("save-dialog");
  $("save-form").addEventListener("submit", (event) => {
    event.preventDefault();
    studio.ask({ do: "save", name: $("save-name").value.trim(), overwrite: $("save-overwrite").checked });
  });
  $("save-cancel").addEventListener("click", () => dialog.close());
  studio.on("saved", (message) => {
    dialog.close();
    const beside = message.files.length ? `, and ${message.files.join(", ")} beside it` : "";
    studio.tell(`saved ${message.path}${beside}`);
  });
  studio.on("error", ({ text }) => {
    if (!dialog.open) return;
    $("save-error").textContent = text;
    if (text.includes("exists already")) $("save-exists").hidden = false;
  });
}

function setUpOpenDialog(studio) {
  const dialog = $("open-dialog");
  studio.on("recipes", ({ folder, names }) => {
    $("open-folder").textContent = names.length ? `Recipes in ${folder}` : `There is no recipe in ${folder}.`;
    const choices = names.map((name) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.addEventListener("click", () => {
        dialog.close();
        studio.ask({ do: "open", name });
      });
      const li = document.createElement("li");
      li.append(button);
      return li;
    });
    $("open-names").replaceChildren(...choices);
    dialog.showModal();
  });
  $("open-files").addEventListener("click", () => {
    dialog.close();
    $("files").click();
  });
  $("open-cancel").addEventListener("click", () => dialog.close());
}

function unsaved(studio, { id, name, time }) {
  const item = document.createElement("p");
  const when = new Date(1000 * time).toLocaleString();
  const recover = Object.assign(document.createElement("button"), { type: "button", textContent: "Recover" });
  recover.setAttribute("aria-label", `Recover ${name}`);
  recover.addEventListener("click", () => studio.ask({ do: "recover", id }));
  const discard = Object.assign(document.createElement("button"), { type: "button", textContent: "Discard" });
  discard.setAttribute("aria-label", `Discard ${name}`);
  discard.addEventListener("click", () => studio.ask({ do: "discard", id }));
  item.append(`${name} was not saved when the studio ended (${when}). `, recover, " ", discard);
  return item;
}
