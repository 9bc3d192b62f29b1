/* The export dialog: what the file will be, the progress of making it, and its download. */

import { $ } from "../studio.js";
import { bytesText, element, plain } from "../wording.js";

const COUNT = new Intl.NumberFormat("en");
const PLACES = { centers: "centres of the pixels", corners: "corners of the pixels (exact)" };

function sizeText([x, y, z]) {
  return `${[x, y, z].map((mm) => Number(mm.toPrecision(4))).join(" x ")} mm`;
}

class ExportDialog {
  constructor(studio) {
    this.studio = studio;
    this.job = null; // id of the export that is under way
    this.build();
    $("export").addEventListener("click", () => this.open());
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "e") return;
      event.preventDefault();
      this.open();
    });
    studio.on("formats", ({ formats }) => this.offer(formats));
    studio.on("estimate", (message) => this.estimated(message));
    studio.on("export", (message) => this.heard(message));
    for (const kind of ["state", "heights"]) studio.on(kind, () => this.estimate());
    studio.on("error", () => this.unblock());
    studio.on("connected", (open) => open || this.lost());
  }

  build() {
    this.format = element("select", { id: "export-format" });
    this.about = element("p", { id: "export-about", className: "quiet" });
    this.format.setAttribute("aria-describedby", this.about.id);
    this.at = element("select", { id: "export-at" });
    for (const [place, name] of Object.entries(PLACES)) this.at.add(new Option(name, place));
    this.place = element("p", { className: "export-row" }, element("label", { htmlFor: "export-at" }, "Heights at"), this.at);
    this.facts = element("dl", { id: "export-facts" });
    this.bar = element("progress", { id: "export-bar", max: 1, value: 0 });
    this.bar.setAttribute("aria-label", "Progress of the export");
    this.said = element("p", { id: "export-said" });
    this.said.setAttribute("role", "status");
    this.found = element("ul", { id: "export-found" });
    this.stop = element("button", { id: "export-cancel", type: "button" }, "Cancel");
    this.close = element("button", { id: "export-close", type: "button" }, "Close");
    this.start = element("button", { id: "export-start", type: "submit", className: "primary" }, "Export");
    const choice = element("p", { className: "export-row" }, element("label", { htmlFor: "export-format" }, "Format"), this.format);
    const buttons = element("p", { className: "export-buttons" }, this.stop, this.close, this.start);
    const form = element("form", {}, choice, this.about, this.place, this.facts, this.bar, this.said, this.found, buttons);
    const title = element("h2", { id: "export-title" }, "Export");
    this.dialog = element("dialog", { id: "export-dialog" }, title, form);
    this.dialog.setAttribute("aria-labelledby", title.id);
    document.body.append(this.dialog);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.begin();
    });
    this.stop.addEventListener("click", () => this.cancel());
    this.close.addEventListener("click", () => this.dialog.close());
    this.format.addEventListener("change", () => this.chosen());
    this.at.addEventListener("change", () => this.chosen());
    this.show();
  }

  /** Fill the list of formats. */
  offer(formats) {
    const before = this.format.value;
    this.formats = new Map(formats.map((one) => [one.format, one]));
    const groups = new Map();
    for (const { format, group } of formats) {
      if (!groups.has(group)) groups.set(group, element("optgroup", { label: group }));
      groups.get(group).append(new Option(group === "Picture" ? "Preview (PNG)" : format.toUpperCase(), format));
    }
    this.format.replaceChildren(...groups.values());
    this.format.value = this.formats.has(before) ? before : "stl";
    this.chosen();
  }

  open() {
    if (this.dialog.open || $("export").disabled) return;
    if (!this.job) this.say("");
    this.dialog.showModal();
    this.chosen();
  }

  /** A format was chosen. */
  chosen() {
    const { group, description } = this.formats.get(this.format.value);
    this.about.textContent = description;
    this.place.hidden = group !== "Heights";
    this.facts.replaceChildren();
    this.estimate();
  }

  get wanted() {
    return { format: this.format.value, at: this.place.hidden ? "centers" : this.at.value };
  }

  estimate() {
    if (this.dialog.open && !this.job) this.studio.ask({ do: "estimate", ...this.wanted });
  }

  /** Show what the file will be. */
  estimated(message) {
    if (message.format !== this.format.value) return;
    if (message.text) {
      this.list([["File", plain(message.text)]]);
      return;
    }
    const rows = [["Size", sizeText(message.size_mm)]];
    if (message.grid) rows.push(["Pixels", message.grid.join(" x ")]);
    if (message.triangles) {
      rows.push(["Kind", message.is_closed ? "closed solid" : "open surface; a base makes it a solid"]);
      rows.push(["Triangles", `${message.at_most ? "at most " : ""}${COUNT.format(message.triangles)}`]);
    }
    const precision = message.precision === "exact" ? "" : `${message.precision} `;
    rows.push(["File", `${precision}${bytesText(message.bytes)}`]);
    this.list(rows);
  }

  list(rows) {
    this.facts.replaceChildren(...rows.flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)]));
  }

  begin() {
    if (this.job) return;
    this.say("");
    if (this.studio.ask({ do: "export", ...this.wanted })) this.job = "asked";
    this.show();
  }

  cancel() {
    this.studio.ask({ do: "cancel-export" });
    this.said.textContent = "cancelling";
    this.stop.disabled = true;
  }

  /** Show a message about the export. */
  heard(message) {
    const { state, id, stage, share, name } = message;
    if (state === "begun") this.job = id;
    else if (id !== this.job) return;
    if (state === "running") {
      this.bar.value = share;
      if (!this.stop.disabled) this.said.textContent = `${stage} ${Math.round(100 * share)} %`;
      if (!this.dialog.open) this.studio.tell(`exporting ${this.format.value}: ${stage} ${Math.round(100 * share)} %`);
      return;
    }
    if (state !== "begun") this.job = null;
    if (state === "cancelled") this.say("cancelled; no file was made");
    if (state === "failed") this.say(plain(message.text), true);
    if (state === "done") {
      element("a", { href: `export/${id}`, download: name }).click();
      this.say(`${name}, ${bytesText(message.bytes)}: your browser saves it`);
      const line = (className, text) => element("li", { className }, plain(text));
      this.found.replaceChildren(
        ...message.warnings.map((text) => line("warning", `Warning: ${text}`)),
        ...message.notes.map((text) => line("quiet", text)),
      );
      this.studio.tell(`exported ${name}`);
    }
    this.show();
  }

  /** Say how it went; the remarks on an earlier export are removed. */
  say(text, is_bad = false) {
    this.said.textContent = text;
    this.said.classList.toggle("bad", is_bad);
    this.found.replaceChildren();
    if (!this.dialog.open && is_bad) this.studio.say(text);
  }

  /** A request was refused before it began. */
  unblock() {
    if (this.job !== "asked") return;
    this.job = null;
    this.say($("error").textContent, true);
    this.show();
  }

  /** The server ends the export of a window that is gone. */
  lost() {
    if (!this.job) return;
    this.job = null;
    this.say("the connection was lost; export again", true);
    this.show();
  }

  show() {
    this.bar.hidden = this.stop.hidden = !this.job;
    this.stop.disabled = false;
    this.bar.value = 0;
    this.start.disabled = this.format.disabled = this.at.disabled = Boolean(this.job);
  }
}

export function setUpExport(studio) {
  return new ExportDialog(studio);
}
