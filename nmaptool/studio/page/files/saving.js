/* Save, undo and redo. */

import { $ } from "../studio.js";

export function setUpSaving(studio) {
  function save() {
    let name = null;
    if (!studio.document?.path) {
      name = prompt("Name of the recipe", "relief.toml");
      if (!name) return;
    }
    studio.ask({ do: "save", name });
  }

  const undo = () => studio.ask({ do: "undo" });
  const redo = () => studio.ask({ do: "redo" });
  $("undo").addEventListener("click", undo);
  $("redo").addEventListener("click", redo);
  $("save").addEventListener("click", save);
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    if (key === "z") (event.shiftKey ? redo : undo)();
    else if (key === "y") redo();
    else if (key === "s") save();
    else return;
    event.preventDefault();
  });
  studio.on("state", (message) => {
    $("saved").textContent = message.is_saved ? "saved" : "not saved";
    $("undo").disabled = message.undo === 0;
    $("redo").disabled = message.redo === 0;
  });
  studio.on("saved", (message) => studio.tell(`saved ${message.path}`));
}
