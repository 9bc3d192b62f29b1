/* The controls of the relief, made from the descriptions that the server derives from its options. */

import { betaFor, inMillimetres, pitchOf, reachOf } from "../heights.js";
import { element } from "../wording.js";
import { Control } from "./control.js";

/** Typed text with a unit that an option itself does not take. */
const CONVERTED = {
  // a height in mm, as a number of px of a picture of 1000 px
  delta: (text, { studio }) => {
    const mm = inMillimetres(text, studio.frame);
    if (!Number.isFinite(mm) || !studio.frame) return undefined;
    return Number((mm / (studio.frame.px_per_delta * pitchOf(studio.frame, studio.values))).toPrecision(6));
  },
  // an angle
  slope_cap: (text) => {
    const found = /^([\d.]+)\s*(?:°|deg)$/i.exec(text);
    return found ? Number(Math.tan((Number(found[1]) * Math.PI) / 180).toPrecision(6)) : undefined;
  },
};

class Panel {
  constructor(studio, form) {
    this.studio = studio;
    this.form = form;
    this.controls = new Map();
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("focusin", (event) => this.explain(event.target.closest(".control")));
  }

  /** Build the controls under their headings; the last group is folded. */
  build(descriptions) {
    this.controls.clear();
    const groups = new Map();
    for (const one of descriptions) {
      if (!groups.has(one.group)) groups.set(one.group, []);
      groups.get(one.group).push(this.control(one).row);
    }
    this.form.replaceChildren(...[...groups].map(([name, rows]) => this.group(name, rows)));
    this.reach = this.reachField();
    this.controls.get("beta").note.before(this.reach.row);
  }

  group(name, rows) {
    if (name === "Advanced") return element("details", { id: "advanced" }, element("summary", {}, name), ...rows);
    const title = element("h2", { id: `group-${name.toLowerCase()}` }, name);
    const section = element("section", { className: "group" }, title, ...rows);
    section.setAttribute("aria-labelledby", title.id);
    return section;
  }

  control(one) {
    const { studio } = this;
    const convert = CONVERTED[one.name];
    const control = new Control(one, (value, moving) => this.change(one.name, value, moving), {
      converted: (text) => convert?.(text, this),
      placed: (value) => (one.kind === "length" ? inMillimetres(value, studio.frame) : Number(value ?? NaN)),
    });
    this.controls.set(one.name, control);
    return control;
  }

  change(name, value, moving) {
    this.studio.change(name, value, moving);
    if (name === "beta" || name === "mu") this.showReach();
  }

  /** The length that the shape keeps, beside beta; a typed length sets beta. */
  reachField() {
    const text = element("input", { type: "text", id: "reach" });
    const label = element("label", { htmlFor: "reach" }, "keeps forms up to");
    text.setAttribute("aria-describedby", "help-beta");
    const field = { text, row: element("p", { className: "readout" }, label, text), is_typed: false };
    text.addEventListener("input", () => (field.is_typed = true));
    text.addEventListener("change", () => {
      field.is_typed = false;
      const given = text.value.trim();
      const mm = inMillimetres(/^[.\d]+$/.test(given) ? `${given}mm` : given, this.studio.frame);
      const beta = betaFor(mm, this.studio.frame, this.studio.values, this.hasDetail);
      if (Number.isFinite(beta)) this.change("beta", Number(beta.toPrecision(4)), false);
      else this.controls.get("beta").refuse(`${given || "nothing"}: give a length, such as 8mm`);
      this.showReach();
    });
    return field;
  }

  get hasDetail() {
    return Boolean(this.studio.document?.files.detail);
  }

  showReach() {
    const { frame, values } = this.studio;
    if (!this.reach || this.reach.is_typed) return;
    this.reach.text.disabled = !frame;
    if (!frame || !values) return;
    const mm = reachOf(frame, values, this.hasDetail);
    this.reach.text.value = Number.isFinite(mm) ? `${Number(mm.toPrecision(3))}mm` : "any size";
  }

  explain(row) {
    for (const { help } of this.controls.values()) help.hidden = help.parentElement !== row;
  }

  /** Show the document. */
  show({ values, reasons }) {
    for (const [name, control] of this.controls) {
      control.show(values[name]);
      control.explain(reasons.controls[name] ?? "", reasons.choices[name]);
    }
    this.showReach();
  }

  /** A change was refused: say why beside its controls, which go back. */
  refuse({ names, text }) {
    const known = names.filter((name) => this.controls.has(name));
    for (const name of known) {
      const control = this.controls.get(name);
      control.refuse(text);
      if (control.row.closest("details")) control.row.closest("details").open = true;
    }
    if (known.length) this.show(this.studio.document);
    else this.studio.say(text);
  }
}

export function setUpControls(studio) {
  const panel = new Panel(studio, document.getElementById("controls"));
  studio.on("controls", (message) => panel.build(message.controls));
  studio.on("state", (message) => panel.show(message));
  let pitch = null; // the reach of beta depends on it
  studio.on("heights", (frame) => {
    if (!studio.document || frame.pitch_mm === pitch) return;
    pitch = frame.pitch_mm;
    panel.show(studio.document);
  });
  studio.on("refused", (message) => panel.refuse(message));
}
