/* Presets: values of the relief's options for kinds of work, and the user's own. */

import { $ } from "../studio.js";
import { element, plain } from "../wording.js";

class Presets {
  constructor(studio, section) {
    this.studio = studio;
    this.presets = [];
    this.choice = element("select", { id: "preset" });
    this.choice.setAttribute("aria-describedby", "preset-about");
    this.apply = element("button", { type: "button", id: "preset-apply" }, "Apply");
    this.about = element("p", { id: "preset-about", className: "quiet" });
    this.name = element("input", { type: "text", id: "preset-name", maxLength: 60, placeholder: "name of a new preset" });
    this.name.setAttribute("aria-label", "Name of a new preset");
    this.keep = element("button", { type: "button", id: "preset-save", title: "Keep the present options as a preset" }, "Save");
    this.remove = element("button", { type: "button", id: "preset-delete" }, "Delete");
    const title = element("h2", {}, element("label", { htmlFor: "preset" }, "Preset"));
    section.append(
      title,
      element("div", { className: "row" }, this.choice, this.apply, this.remove),
      this.about,
      element("div", { className: "row" }, this.name, this.keep),
    );
    this.choice.addEventListener("change", () => this.show());
    this.apply.addEventListener("click", () => studio.ask({ do: "apply-preset", ...this.chosen }));
    this.remove.addEventListener("click", () => studio.ask({ do: "delete-preset", name: this.chosen.name }));
    this.keep.addEventListener("click", () => this.save());
    this.name.addEventListener("input", () => this.show());
    this.name.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.save();
    });
    studio.on("presets", (message) => this.offer(message.presets));
    studio.on("state", ({ plate }) => this.tellPlate(plate));
  }

  get chosen() {
    const { name, is_own } = this.presets[Number(this.choice.value)] ?? {};
    return { name, is_own };
  }

  offer(presets) {
    const chosen = this.wanted ?? this.chosen.name;
    this.wanted = undefined;
    this.presets = presets;
    const groups = [false, true].map((is_own) => {
      const options = presets.flatMap((one, number) => (one.is_own === is_own ? [new Option(one.name.replaceAll("-", is_own ? "-" : " "), number)] : []));
      return options.length ? [element("optgroup", { label: is_own ? "My own" : "Kinds of work" }, ...options)] : [];
    });
    this.choice.replaceChildren(...groups.flat());
    const found = presets.findIndex((one) => one.name === chosen);
    this.choice.value = Math.max(found, 0);
    this.show();
  }

  /** Say that exported files have a plate, which the stage does not show. */
  tellPlate(plate) {
    $("plate").hidden = !plate;
    if ($("plate").textContent !== (plate ?? "")) $("plate").textContent = plate ?? "";
  }

  show() {
    const one = this.presets[Number(this.choice.value)];
    this.about.textContent = plain(one?.description);
    this.apply.disabled = !one;
    this.remove.hidden = !one?.is_own;
    const taken = this.presets.some(({ name, is_own }) => is_own && name === this.name.value.trim());
    this.keep.textContent = taken ? "Replace" : "Save";
    this.keep.disabled = this.name.value.trim() === "";
  }

  save() {
    const name = this.name.value.trim();
    if (!name) return;
    this.wanted = name;
    this.studio.say("");
    this.studio.ask({ do: "save-preset", name, overwrite: this.keep.textContent === "Replace" });
    this.name.value = "";
    this.show();
  }
}

export function setUpPresets(studio) {
  return new Presets(studio, document.getElementById("presets"));
}
