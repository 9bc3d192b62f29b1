/* A form of options, made from the descriptions that the server derives from its options. */

let count = 0;

export class Form {
  /**
   * @param {HTMLElement} container
   * @param {object[]} fields  descriptions, see nmaptool.studio.descriptions
   * @param {(name: string, value: any) => void} changed  called when the user sets a value; null is the default
   */
  constructor(container, fields, changed) {
    this.changed = changed;
    this.inputs = new Map();
    const prefix = `form${(count += 1)}`;
    const rows = fields.map((field) => this.row(field, `${prefix}-${field.name}`));
    container.replaceChildren(...rows);
    container.addEventListener("focusin", (event) => this.explain(container, event.target));
  }

  row(field, id) {
    const row = document.createElement("div");
    row.className = "field";
    const label = Object.assign(document.createElement("label"), { textContent: field.label, htmlFor: id, title: field.help });
    const help = Object.assign(document.createElement("p"), { className: "help", id: `${id}-help`, hidden: true });
    help.textContent = field.help;
    const input = field.kind === "choice" ? choice(field) : entry(field);
    input.id = id;
    input.setAttribute("aria-describedby", help.id);
    const one = { field, input, row, isTyping: false };
    input.addEventListener("input", () => {
      one.isTyping = true;
    });
    input.addEventListener("blur", () => {
      one.isTyping = false;
    });
    input.addEventListener("change", () => {
      one.isTyping = false;
      this.changed(field.name, read(field, input));
    });
    this.inputs.set(field.name, one);
    row.append(label, input, help);
    return row;
  }

  explain(container, target) {
    for (const help of container.querySelectorAll(".help")) help.hidden = help.id !== target.getAttribute("aria-describedby");
  }

  /** Show values; a field that is being typed in keeps what the user sees. */
  show(values) {
    for (const [name, { field, input, isTyping }] of this.inputs) {
      const value = values[name] ?? field.default;
      if (field.kind === "switch") input.checked = Boolean(value);
      else if (!isTyping || input.tagName === "SELECT") input.value = value ?? "";
    }
  }

  /** The values that are not empty. */
  get values() {
    const read_ = [...this.inputs].map(([name, { field, input }]) => [name, read(field, input)]);
    return Object.fromEntries(read_.filter(([, value]) => value !== null));
  }

  /** Show or hide fields. */
  reveal(names) {
    for (const [name, { row }] of this.inputs) row.hidden = !names.includes(name);
  }
}

function choice(field) {
  const select = document.createElement("select");
  if (field.default === null) select.add(new Option("as it is", ""));
  for (const name of field.choices) select.add(new Option(name, name));
  return select;
}

function entry(field) {
  const input = document.createElement("input");
  input.type = field.kind === "switch" ? "checkbox" : "text";
  if (input.type === "text") input.placeholder = field.default === null ? `such as ${field.example}` : String(field.default);
  return input;
}

/** The value of a field; null if it is empty. */
function read(field, input) {
  if (field.kind === "switch") return input.checked;
  const text = input.value.trim();
  if (text === "") return null;
  return field.kind === "number" && Number.isFinite(Number(text)) ? Number(text) : text;
}
