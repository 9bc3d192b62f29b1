/* The camera panel: a mesh as the camera of a bake sees it, and the options of the bake. */

import { frameCamera } from "../mesh/camera.js";
import { decodeMesh } from "../mesh/display.js";
import { setUpOrbit } from "../mesh/orbit.js";
import { MeshView } from "../mesh/view.js";
import { $ } from "../studio.js";
import { Form } from "./form.js";

const FIELDS = {
  "mesh-camera": ["up", "azimuth", "elevation", "roll", "fov"],
  "mesh-picture": ["size", "margin", "width"],
  "mesh-more": ["pitch", "target", "shading", "crease", "supersample", "geometry", "renderer"],
};
const MM = { mm: 1, cm: 10, m: 1000, in: 25.4 };
// the server is asked once the hand rests for so long, in ms
const REST = 200;

export class MeshPanel {
  constructor(studio) {
    this.studio = studio;
    this.dialog = $("mesh-dialog");
    this.view = null; // made when the panel is first opened
    this.forms = [];
    this.mesh = null; // id of the mesh, place of the layer that is baked again, and what the server sent
    this.values = { reading: {}, camera: {}, filter: {} };
    this.number = 0;
    this.timer = 0;
    studio.on("forms", (message) => this.build(message));
    studio.on("mesh", ({ id, name }) => this.open({ id, name }));
    studio.on("meshes", (message) => this.hear(message));
    studio.on("bake", (message) => this.progress(message));
    $("mesh-bake").addEventListener("click", () => this.bake());
    $("mesh-cancel").addEventListener("click", () => studio.ask({ do: "cancel-bake" }));
    $("mesh-close").addEventListener("click", () => this.dialog.close());
    $("mesh-without").addEventListener("click", () => {
      this.set("camera", "renderer", "numpy");
      this.bake();
    });
    $("mesh-as-map").addEventListener("change", () => this.draw());
    $("mesh-form").addEventListener("submit", (event) => event.preventDefault());
    this.dialog.addEventListener("close", () => this.view?.load(null));
    new ResizeObserver(() => this.draw()).observe($("mesh-stage"));
  }

  build({ camera, reading, filter, views }) {
    this.views = views;
    this.defaults = Object.fromEntries(camera.map((field) => [field.name, field.default]));
    const add = (table, id, fields) => {
      const form = new Form($(id), fields, (name, value) => this.set(table, name, value));
      this.forms.push({ table, form });
      return form;
    };
    this.forms = [];
    for (const [id, names] of Object.entries(FIELDS))
      add("camera", id, names.map((name) => camera.find((field) => field.name === name)));
    this.direction = this.forms[0].form;
    this.more = this.forms.at(-1).form;
    add("reading", "mesh-unit", reading);
    this.filter = add("filter", "mesh-filter", filter);
    const buttons = Object.keys(views).map((name) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.addEventListener("click", () => this.turn({ view: name, azimuth: null, elevation: null }));
      return button;
    });
    $("mesh-views").replaceChildren(...buttons);
    this.show();
  }

  /** Open the panel for a mesh; with `place` and `values`, to bake a layer again. */
  async open({ id, name, place = null, values = null }) {
    this.mesh = { id, name, place, data: null, state: "reading" };
    this.values = structuredClone(values ?? { reading: {}, camera: this.asDocument(), filter: {} });
    for (const table of ["reading", "camera", "filter"]) this.values[table] ??= {};
    $("mesh-title").textContent = name;
    $("mesh-bake").textContent = place ? "Bake again" : "Bake";
    this.say("");
    this.facts(null);
    if (!this.dialog.open) this.dialog.showModal();
    this.show();
    const known = this.latest?.meshes.find((one) => one.id === id);
    if (known) this.hear(this.latest);
    if (this.latest?.running?.kind === "bake") this.progress(this.latest.running);
    else this.progress({ state: "idle" });
  }

  /** The size of the pictures of the document, if it has layers, so that a new layer fits. */
  asDocument() {
    const { frame, document: shown } = this.studio;
    if (!shown?.layers.length || !frame) return {};
    const [cols, rows] = frame.full ?? [frame.cols - 1, frame.rows - 1];
    return { size: `${cols}x${rows}` };
  }

  /** What the server says about the open meshes. */
  hear(message) {
    this.latest = message;
    if (!this.mesh || !this.dialog.open) return;
    const one = message.meshes.find(({ id }) => id === this.mesh.id);
    if (!one) {
      this.dialog.close();
      return;
    }
    const before = this.mesh.state;
    this.mesh.state = one.state;
    if (one.state === "failed") this.say(one.text);
    $("mesh-reading").hidden = one.state === "ready" && this.mesh.data !== null;
    $("mesh-reading").textContent = one.state === "failed" ? "" : `${one.text}: ${one.name}`;
    if (one.state === "ready" && (before !== "ready" || !this.mesh.data)) this.fetch(this.mesh);
    this.enable();
  }

  async fetch(mesh) {
    if (mesh.fetching) return;
    mesh.fetching = true;
    const answer = await fetch(`mesh/${mesh.id}`);
    if (!answer.ok) {
      this.say((await answer.json()).text);
      return;
    }
    const data = decodeMesh(await answer.arrayBuffer());
    if (mesh !== this.mesh) return;
    mesh.data = data;
    $("mesh-reading").hidden = true;
    this.view ??= new MeshView($("mesh-canvas"));
    this.view.load(data);
    const { triangles, all_triangles: all } = data.header;
    $("mesh-thinned").textContent = triangles < all ? `shown with ${triangles} of ${all} triangles; all are baked` : "";
    this.orbit ??= this.setUpOrbit();
    this.changed();
    this.enable();
  }

  setUpOrbit() {
    setUpOrbit($("mesh-canvas"), () => this.options(), (direction, moving) => this.turn(direction, moving));
    return true;
  }

  /** The values of the camera with defaults, and the direction as numbers. */
  options() {
    const given = this.values.camera;
    const all = { ...this.defaults };
    for (const [name, value] of Object.entries(given)) if (value !== null && value !== undefined) all[name] = value;
    const [azimuth, elevation] = this.views[all.view ?? "front"] ?? [0, 0];
    const number = (value, other) => (Number.isFinite(value) ? value : other);
    const turned = { azimuth: number(given.azimuth, azimuth), elevation: number(given.elevation, elevation) };
    return { ...all, ...turned, roll: number(all.roll, 0), fov: number(all.fov, 0) };
  }

  get mmPerUnit() {
    return MM[this.values.reading.unit] ?? this.mesh.data.header.mm_per_unit;
  }

  turn(direction, moving = false) {
    Object.assign(this.values.camera, direction);
    this.show();
    this.changed(moving);
  }

  set(table, name, value) {
    this.values[table][name] = value;
    this.show();
    this.changed();
  }

  show() {
    for (const { table, form } of this.forms) form.show(this.values[table]);
    const { view = "front", azimuth, elevation } = this.values.camera;
    for (const [name, value] of Object.entries({ azimuth: this.views?.[view]?.[0], elevation: this.views?.[view]?.[1] })) {
      const input = this.direction?.inputs.get(name)?.input;
      if (input) input.placeholder = `${Math.round(10 * (value ?? 0)) / 10}: ${view}`;
    }
    const isView = typeof azimuth !== "number" && typeof elevation !== "number";
    for (const button of $("mesh-views").children)
      button.setAttribute("aria-pressed", String(isView && button.textContent === view));
    const learned = this.values.filter.filter === "learned";
    this.filter?.reveal(learned ? ["filter"] : [...this.filter.inputs.keys()]);
    const isFlat = (this.values.camera.shading ?? "flat") === "flat";
    this.more?.reveal(FIELDS["mesh-more"].filter((name) => name !== "crease" || !isFlat));
  }

  /** What is sent to the server. */
  get order() {
    const given = (table) => Object.fromEntries(Object.entries(table).filter(([, value]) => value !== null && value !== undefined));
    const filter = given(this.values.filter);
    return {
      reading: given(this.values.reading),
      camera: given(this.values.camera),
      filter: filter.filter === "learned" ? { filter: "learned" } : filter,
    };
  }

  changed(moving = false) {
    this.draw();
    clearTimeout(this.timer);
    if (!moving && this.mesh?.data) this.timer = setTimeout(() => this.check(this.mesh), REST);
  }

  draw() {
    if (!this.view || !this.mesh?.data) return;
    this.view.asMap = $("mesh-as-map").checked;
    const camera = frameCamera(this.mesh.data.corners, this.options(), this.mmPerUnit);
    if (camera) this.view.show(camera);
  }

  async check(mesh) {
    const number = (this.number += 1);
    const body = JSON.stringify(this.order);
    const answer = await fetch(`mesh/${mesh.id}/check`, { method: "POST", body });
    const found = await answer.json();
    if (number !== this.number || mesh !== this.mesh) return;
    mesh.refused = Boolean(found.error);
    this.say(found.error ?? "");
    this.facts(found.error ? null : found);
    this.enable();
  }

  facts(found) {
    const lines = [];
    if (found) {
      const digits = (value) => Number(value.toPrecision(4));
      const [cols, rows] = found.size;
      lines.push(this.mesh.data.header.findings);
      lines.push(`${cols} x ${rows} px, ${digits(found.width_mm)} x ${digits(found.height_mm)} mm, ${digits(found.pitch_mm)} mm per px`);
      if (found.sigma_s_px) lines.push(`sigma s is ${digits(found.sigma_s_px)} px in the picture`);
    }
    $("mesh-facts").textContent = lines.join("; ");
    const warnings = (found?.warnings ?? []).map((text) => Object.assign(document.createElement("li"), { textContent: text }));
    $("mesh-warnings").replaceChildren(...warnings);
  }

  bake() {
    this.say("");
    this.asked = this.mesh;
    this.studio.ask({ do: "bake", id: this.mesh.id, values: this.order, place: this.mesh.place });
  }

  /** A message about a bake. */
  progress(message) {
    const running = message.state === "running";
    this.running = running;
    $("mesh-progress").hidden = !running;
    $("mesh-cancel").hidden = !running;
    if (running) {
      $("mesh-share").value = message.share;
      $("mesh-stage-name").textContent = message.stage ? `${message.what}: ${message.stage}` : message.what;
    }
    $("mesh-without").hidden = !message.lacks_renderer;
    if (message.state === "failed") this.say(message.text);
    if (message.state === "done" && this.dialog.open && this.asked === this.mesh) this.dialog.close();
    this.enable();
  }

  enable() {
    $("mesh-bake").disabled = this.running || this.mesh?.state !== "ready" || Boolean(this.mesh?.refused);
  }

  say(text) {
    $("mesh-error").textContent = text;
  }
}
