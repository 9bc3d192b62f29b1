/* One control of the relief: a slider, a field for typed values or a list, and a button back to the default. */

import { element, plain } from "../wording.js";

// a control that was just used keeps what the user sees for this long: states on their way are older
const HELD_MS = 300;

/** Millimetres as text of three or four digits. */
function lengthText(mm) {
  return `${Number(mm.toPrecision(mm >= 100 ? 4 : 3))}mm`;
}

export class Control {
  /**
   * @param {object} one  its description, see nmaptool.studio.controls
   * @param {(value: any, moving: boolean) => void} changed  called when the user sets a value; null is the default
   * @param {(text: string) => any} converted  turns typed text with a unit into a value; undefined leaves the text
   * @param {(value: any) => number} placed  the number that a slider shows for a value; NaN for none
   */
  constructor(one, changed, { converted = () => undefined, placed = Number } = {}) {
    Object.assign(this, { one, converted, placed, value: null, is_typed: false, used: -Infinity });
    this.changed = (value, moving) => {
      this.refuse("");
      changed(value, moving);
    };
    this.input = this.entry();
    this.input.id = `value-${one.name}`;
    this.reset = this.resetButton();
    this.label = element("label", { textContent: one.label, htmlFor: this.input.id, title: one.help });
    this.label.addEventListener("dblclick", () => this.toDefault());
    this.note = element("p", { className: "note", id: `note-${one.name}`, hidden: true });
    this.note.setAttribute("role", "status");
    this.help = element("p", { className: "help", id: `help-${one.name}`, hidden: true }, one.help);
    for (const input of this.inputs) input.setAttribute("aria-describedby", `${this.note.id} ${this.help.id}`);
    this.row = element("div", { className: "control" }, this.label, ...this.inputs.toReversed(), this.reset, this.note, this.help);
    this.row.dataset.name = one.name;
    if (!this.slide) this.input.classList.add("wide");
  }

  get inputs() {
    return this.slide ? [this.input, this.slide] : [this.input];
  }

  entry() {
    const { one } = this;
    if (one.kind === "choice") {
      const select = element("select", {}, ...one.choices.map((name) => new Option(name, name)));
      select.addEventListener("change", () => this.changed(select.value, false));
      return select;
    }
    if (one.kind === "switch") {
      const box = element("input", { type: "checkbox" });
      box.addEventListener("change", () => this.changed(box.checked, false));
      return box;
    }
    if (one.slider) this.slide = this.slider();
    const example = one.slider ? "not set" : `such as ${one.example}`; // a narrow field
    const placeholder = one.default === null ? example : String(one.default);
    const text = element("input", { type: "text", placeholder });
    text.addEventListener("input", () => (this.is_typed = true));
    text.addEventListener("blur", () => (this.is_typed = false));
    text.addEventListener("change", () => {
      this.is_typed = false;
      this.used = performance.now();
      this.changed(this.typed(text.value), false);
    });
    text.addEventListener("keydown", (event) => this.key(event));
    return text;
  }

  slider() {
    const { one } = this;
    const slide = element("input", { type: "range", id: `slide-${one.name}`, min: 0, max: one.slider.steps, step: 1 });
    slide.setAttribute("aria-label", one.label);
    const move = (moving) => {
      this.used = performance.now();
      const text = this.textAt(Number(slide.value));
      this.input.value = text;
      slide.setAttribute("aria-valuetext", text);
      this.changed(this.typed(text), moving);
    };
    slide.addEventListener("input", () => move(true));
    slide.addEventListener("change", () => move(false));
    slide.addEventListener("dblclick", () => this.toDefault());
    slide.addEventListener("keydown", (event) => {
      if (event.key !== "Delete") return;
      event.preventDefault();
      this.toDefault();
    });
    return slide;
  }

  resetButton() {
    const told = `Back to ${this.one.default ?? "no value"}`;
    const button = element("button", { type: "button", className: "reset", title: told, textContent: "↺" });
    button.setAttribute("aria-label", `${this.one.label}: ${told.toLowerCase()}`);
    button.addEventListener("click", () => {
      this.toDefault();
      this.input.focus();
    });
    return button;
  }

  toDefault() {
    this.is_typed = false;
    this.used = -Infinity;
    this.changed(null, false);
  }

  /** Arrow keys in the field move it by a step of its slider, ten with Shift. */
  key(event) {
    const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!step || !this.slide) return;
    event.preventDefault();
    const { low, high, is_log, steps } = this.one.slider;
    const share = (step * (event.shiftKey ? 10 : 1)) / steps;
    const now = this.placed(this.typed(this.input.value) ?? this.one.default);
    const start = Number.isFinite(now) ? now : low;
    const moved = is_log && start > 0 ? start * (high / low) ** share : start + (high - low) * share;
    this.input.value = this.text(low >= 0 ? Math.max(moved, 0) : moved);
    this.used = performance.now();
    this.changed(this.typed(this.input.value), false);
  }

  /** The value that a typed text stands for; an empty one is the default. */
  typed(text) {
    const given = text.trim().replace(",", ".");
    if (given === "") return null;
    const value = this.converted(given);
    if (value !== undefined) return value;
    if (this.one.kind === "length") return /^[-+.\d]+$/.test(given) ? `${given}mm` : given;
    return this.one.kind === "number" && Number.isFinite(Number(given)) ? Number(given) : text.trim();
  }

  text(number) {
    return this.one.kind === "length" ? lengthText(number) : String(Number(number.toPrecision(3)));
  }

  /** The text for a place of the slider. */
  textAt(place) {
    const { low, high, is_log, steps } = this.one.slider;
    const share = place / steps;
    return this.text(is_log ? low * (high / low) ** share : low + (high - low) * share);
  }

  placeOf(number) {
    const { low, high, is_log, steps } = this.one.slider;
    const share = is_log ? Math.log(Math.max(number, 1e-12) / low) / Math.log(high / low) : (number - low) / (high - low);
    return Math.round(steps * Math.min(Math.max(share, 0), 1));
  }

  /** Show a value of the document: later, if the control is in use. */
  show(value) {
    clearTimeout(this.later);
    this.value = value;
    if (performance.now() - this.used < HELD_MS) this.later = setTimeout(() => this.show(this.value), HELD_MS);
    else this.place(value);
  }

  place(value) {
    this.reset.classList.toggle("unused", value === this.one.default);
    this.reset.tabIndex = value === this.one.default ? -1 : 0;
    if (this.one.kind === "switch") this.input.checked = Boolean(value);
    else if (!this.is_typed) this.input.value = value ?? "";
    if (this.slide) this.slideTo(value);
  }

  slideTo(value) {
    const number = this.placed(value);
    if (Number.isFinite(number)) this.slide.value = this.placeOf(number);
    this.slide.classList.toggle("unset", value === null);
    this.slide.setAttribute("aria-valuetext", value ?? "not set");
  }

  /** Say why it cannot be used now, or that it can ("" and no choices). */
  explain(reason, choices) {
    for (const input of this.inputs) input.disabled = Boolean(reason);
    this.row.classList.toggle("disabled", Boolean(reason));
    for (const option of this.one.kind === "choice" ? this.input.options : []) {
      const why = choices?.[option.value];
      option.disabled = Boolean(why);
      option.textContent = why ? `${option.value} (${plain(why)})` : option.value;
    }
    this.reason = plain(reason);
    if (!this.row.classList.contains("refused")) this.tell(this.reason);
  }

  /** Say that a value was refused; "" takes it back. */
  refuse(text) {
    this.row.classList.toggle("refused", Boolean(text));
    this.input.setAttribute("aria-invalid", String(Boolean(text)));
    this.tell(text ? plain(text) : this.reason ?? "");
    if (text) this.is_typed = false;
    if (text) this.used = -Infinity;
  }

  tell(text) {
    this.note.textContent = text;
    this.note.hidden = !text;
  }
}
