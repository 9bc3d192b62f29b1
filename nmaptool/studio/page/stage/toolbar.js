/* The toolbar below the picture, and the keys of the canvas. */

import { $ } from "../studio.js";
import { legendOf, showLegend } from "./legend.js";
import { MATERIALS, OVERLAYS } from "./materials.js";
import { MOST_LIGHTS } from "./settings.js";

const PACE = 40; // CSS px for each press of an arrow key
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Toolbar {
  /**
   * @param {import("./view.js").View} view
   * @param {() => void} chosen  called when the user chose something that is kept
   */
  constructor(view, chosen) {
    this.view = view;
    this.chosen = chosen;
    for (const name of Object.keys(MATERIALS)) $("material").add(new Option(name, name));
    for (const [name, number] of Object.entries(OVERLAYS)) $("overlay").add(new Option(name, number));
    $("material").value = view.material;
    $("overlay").value = view.overlay;
    $("shadows").checked = view.shadows;
    $("draft").value = view.draft;
    $("draft-row").hidden = view.overlay !== OVERLAYS["draft angle"];
    for (const id of ["material", "overlay", "shadows", "draft"]) $(id).addEventListener("change", () => this.choose());
    $("draft").addEventListener("input", () => this.choose());
    $("fit-view").addEventListener("click", () => view.relief && view.fit());
    $("one-to-one").addEventListener("click", () => view.relief && view.actual());
    $("orbit").addEventListener("click", () => this.turn());
  }

  choose() {
    const { view } = this;
    view.material = $("material").value;
    view.overlay = Number($("overlay").value);
    view.shadows = $("shadows").checked;
    const draft = $("draft").valueAsNumber;
    if (draft >= 0 && draft <= 89) view.draft = draft;
    $("draft-row").hidden = view.overlay !== OVERLAYS["draft angle"];
    this.legend();
    view.draw();
    this.chosen();
  }

  legend() {
    const { view } = this;
    showLegend($("legend"), view.relief ? legendOf(view.overlay, view.relief, view.draft) : null);
  }

  /** Change between the flat view and the orbit view. */
  turn() {
    if (!this.view.relief) return;
    const orbits = !this.view.camera.orbits;
    $("orbit").setAttribute("aria-pressed", orbits);
    this.view.turn(orbits);
  }

  /** Show the lights: what their buttons and their strength are about. */
  useLights(lights) {
    this.lights = lights;
    $("add-light").addEventListener("click", () => lights.add());
    $("remove-light").addEventListener("click", () => lights.remove(lights.chosen));
    $("strength").addEventListener("input", () => {
      this.view.lights[lights.chosen].strength = $("strength").valueAsNumber / 100;
      this.view.move();
      this.chosen();
    });
    this.showLights();
  }

  showLights() {
    if (!this.lights) return;
    const { lights } = this.view;
    $("strength-name").textContent = `Light ${this.lights.chosen + 1}`;
    $("strength").value = 100 * lights[this.lights.chosen].strength;
    $("strength").setAttribute("aria-valuetext", `${$("strength").value} %`);
    $("add-light").disabled = lights.length >= MOST_LIGHTS;
    $("remove-light").disabled = lights.length < 2;
  }

  /** A key on the canvas that no tool has. */
  key(event) {
    const { view } = this;
    if (!view.relief || event.ctrlKey || event.metaKey || event.altKey) return;
    const { width, height, orbits } = view.camera;
    const way = MOVES[event.key];
    if (way && orbits && !event.shiftKey) view.orbit(-5 * way[0], 4 * way[1]);
    else if (way) view.pan(-PACE * way[0], -PACE * way[1]);
    else if (event.key === "+" || event.key === "=") view.zoomAt(width / 2, height / 2, 1.25);
    else if (event.key === "-") view.zoomAt(width / 2, height / 2, 0.8);
    else if (event.key === "1") view.actual();
    else if (event.key === "f" || event.key === "Home") view.reset();
    else if (event.key === "o") this.turn();
    else return;
    event.preventDefault();
  }
}
