/* The controls of the relief, made from the descriptions that the server derives from its options. */

import { millimetres } from "../heights.js";

// a control that was just used keeps what the user sees for this long: states on their way are older
const HELD_MS = 300;

/** Millimetres as text of three or four digits. */
function lengthText(mm) {
  return `${Number(mm.toPrecision(mm >= 100 ? 4 : 3))}mm`;
}

class Panel {
  /**
   * @param {HTMLFormElement} form
   * @param {(name: string, value: any, moving: boolean) => void} changed  called when the user sets a value
   */
  constructor(form, changed) {
    this.form = form;
    this.changed = changed;
    this.controls = new Map();
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  /** Build the controls. */
  build(descriptions) {
    this.form.replaceChildren();
    this.controls.clear();
    for (const one of descriptions) {
      const row = document.createElement("div");
      row.className = "control";
      const label = document.createElement("label");
      label.textContent = one.label;
      label.htmlFor = `value-${one.name}`;
      label.title = one.help;
      const help = document.createElement("p");
      help.className = "help";
      help.id = `help-${one.name}`;
      help.hidden = true;
      help.textContent = one.help;
      row.append(label, ...(one.kind === "choice" ? this.choice(one) : this.number(one)), help);
      row.addEventListener("focusin", () => this.explain(help));
      this.form.append(row);
    }
  }

  explain(help) {
    for (const each of this.form.querySelectorAll(".help")) each.hidden = each !== help;
  }

  choice(one) {
    const select = document.createElement("select");
    select.className = "wide";
    select.id = `value-${one.name}`;
    select.setAttribute("aria-describedby", `help-${one.name}`);
    for (const name of one.choices) select.add(new Option(name, name));
    select.addEventListener("change", () => this.changed(one.name, select.value, false));
    this.controls.set(one.name, { ...one, select });
    return [select];
  }

  number(one) {
    const text = document.createElement("input");
    text.type = "text";
    text.id = `value-${one.name}`;
    text.placeholder = one.kind === "length" ? "as it is" : one.example;
    text.setAttribute("aria-describedby", `help-${one.name}`);
    const control = { ...one, text, isTyping: false, used: -Infinity };
    text.addEventListener("input", () => {
      control.isTyping = true;
    });
    text.addEventListener("blur", () => {
      control.isTyping = false;
    });
    text.addEventListener("change", () => {
      control.isTyping = false;
      control.used = performance.now();
      this.changed(one.name, this.typed(one, text.value), false);
    });
    this.controls.set(one.name, control);
    if (!one.slider) return [document.createElement("span"), text];
    const slide = document.createElement("input");
    slide.type = "range";
    slide.id = `slide-${one.name}`;
    slide.min = 0;
    slide.max = one.slider.steps;
    slide.step = 1;
    slide.setAttribute("aria-label", one.label);
    slide.setAttribute("aria-describedby", `help-${one.name}`);
    const move = (moving) => {
      const value = this.at(one, Number(slide.value));
      text.value = value;
      control.used = performance.now();
      slide.setAttribute("aria-valuetext", value);
      this.changed(one.name, this.typed(one, String(value)), moving);
    };
    slide.addEventListener("input", () => move(true));
    slide.addEventListener("change", () => move(false));
    slide.addEventListener("dblclick", () => {
      control.used = -Infinity;
      this.changed(one.name, null, false);
    });
    control.slide = slide;
    return [slide, text];
  }

  /** The value that a typed text stands for; an empty one is the default. */
  typed(one, text) {
    const given = text.trim();
    if (given === "") return null;
    if (one.kind !== "number") return /^[-+.\d]+$/.test(given) && one.kind === "length" ? `${given}mm` : given;
    return Number.isFinite(Number(given)) ? Number(given) : given;
  }

  /** The value at a place of a slider, as text. */
  at(one, place) {
    const { low, high, is_log, steps } = one.slider;
    const share = place / steps;
    const value = is_log ? low * (high / low) ** share : low + (high - low) * share;
    return one.kind === "length" ? lengthText(value) : String(Number(value.toPrecision(3)));
  }

  step(one, value) {
    const { low, high, is_log, steps } = one.slider;
    const share = is_log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.round(steps * Math.min(Math.max(share, 0), 1));
  }

  /** Show the values of the document; a control that is in use, later. */
  show(values) {
    clearTimeout(this.later);
    const now = performance.now();
    let areAllShown = true;
    for (const [name, control] of this.controls) {
      const value = values[name];
      if (control.select) control.select.value = value;
      else if (now - control.used < HELD_MS) areAllShown = false;
      else this.place(control, value);
    }
    if (!areAllShown) this.later = setTimeout(() => this.show(values), HELD_MS);
  }

  place(control, value) {
    const { text, slide } = control;
    if (!control.isTyping) text.value = value ?? "";
    if (!slide) return;
    const number = control.kind === "length" ? millimetres(value) : value;
    if (Number.isFinite(number)) slide.value = this.step(control, number);
    slide.setAttribute("aria-valuetext", value ?? "");
  }
}

export function setUpControls(studio) {
  const panel = new Panel(document.getElementById("controls"), (...change) => studio.change(...change));
  studio.on("controls", (message) => panel.build(message.controls));
  studio.on("state", (message) => panel.show(message.values));
}
