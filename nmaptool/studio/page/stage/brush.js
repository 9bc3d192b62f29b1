/*
 * Brushes: paint the mask, or weights of mu, beta or delta, on the relief. The page shows a stroke while it is drawn; the
 * server paints it into the picture.
 */

import { $ } from "../studio.js";
import { shareAt, sizes } from "./placing.js";

const STEP = 0.12; // of the brush's size, between two points
const HELP = {
  mask: "White is the motif; erase takes parts away.",
  mu_map: "Multiplies mu: black means no detail.",
  beta_map: "Multiplies beta: black means that nothing pulls towards delta.",
  delta_map: "Multiplies delta: black pulls down to the plate.",
  "layer-mask": "White is where the chosen layer shows; erase hides it.",
};
const KEYS = { b: "paint", e: "erase", s: "smooth", g: "fill" };

export function setUpBrush(studio, stage, handles) {
  const brush = new Brush(studio, stage, handles);
  studio.on("state", () => brush.refresh());
  stage.onView(() => brush.draw());
  return brush;
}

class Brush {
  constructor(studio, stage, handles) {
    Object.assign(this, { studio, stage, handles });
    this.release = null; // ends the use of the pointer; null while no brush is in use
    this.picture = null; // the greys of the role, as the server has them
    this.shown = ""; // of which file
    this.points = null; // of the stroke that is drawn
    this.at = null; // where the brush is
    $("brush-on").addEventListener("click", () => this.use(!this.release));
    $("brush-role").addEventListener("change", () => this.choose());
    for (const name of ["size", "hardness", "opacity", "value"]) $(`brush-${name}`).addEventListener("input", () => this.draw());
    document.addEventListener("keydown", (event) => this.key(event));
    this.describe();
  }

  get role() {
    return $("brush-role").value;
  }

  get isMask() {
    return this.role === "mask" || this.role === "layer-mask";
  }

  /** The box of the chosen layer, if its mask is painted; null if the sheet is the whole map, undefined if it is missing. */
  get box() {
    return this.role === "layer-mask" ? (this.handles.box ?? undefined) : null;
  }

  get tool() {
    return document.querySelector("input[name=brush-tool]:checked").value;
  }

  get size() {
    return Number($("brush-size").value);
  }

  describe() {
    $("brush-help").textContent = HELP[this.role];
    $("brush-value-row").hidden = this.isMask;
  }

  choose() {
    this.describe();
    this.shown = "";
    this.refresh();
  }

  /** Take the brush into the hand, or put it down. */
  use(isUsed) {
    if (isUsed === Boolean(this.release) || (isUsed && !this.studio.frame)) return;
    $("brush-on").setAttribute("aria-pressed", String(isUsed));
    $("brush-on").textContent = isUsed ? "Stop painting" : "Paint";
    this.release?.();
    this.release = isUsed ? this.stage.claim(this) : null;
    this.shown = "";
    if (isUsed) {
      const span = Math.max(...this.studio.frame.full);
      $("brush-size").max = Math.round(span / 2);
      if (!this.sized) $("brush-size").value = Math.round(span / 12);
      this.sized = true;
      this.stage.view.canvas.focus();
    }
    this.refresh();
  }

  /** Fetch the picture of the role if another file holds it now. */
  async refresh() {
    const layer = this.studio.layers.chosen;
    const isLayer = this.role === "layer-mask";
    const file = isLayer ? `${layer?.place} ${layer?.file} ${layer?.mask}` : this.studio.document?.files?.[this.role];
    const shown = `${this.role} ${file}`;
    if (!this.release || shown === this.shown) {
      this.draw();
      return;
    }
    this.shown = shown;
    this.picture = null;
    if (isLayer && layer?.kind !== "map") {
      this.studio.say("choose a layer with a map to paint its mask");
      return;
    }
    const answer = await fetch(`painted/${this.role}${isLayer ? `?place=${layer.place}` : ""}`);
    if (!answer.ok) {
      this.studio.say((await answer.json()).text);
      return;
    }
    this.picture = tinted(await createImageBitmap(await answer.blob()));
    this.draw();
  }

  down(event, place) {
    if (!place) return;
    this.points = [];
    this.add(event, place);
  }

  move(event, place) {
    this.at = place;
    if (this.points && place) for (const one of event.getCoalescedEvents?.() ?? [event]) this.add(one, this.stage.view.toGrid(one) ?? place);
    this.draw();
  }

  up() {
    const points = this.points;
    this.points = null;
    if (points?.length) this.paint(points);
  }

  cancel() {
    this.points = null;
    this.draw();
  }

  add(event, { x, y }) {
    const pressure = event.pointerType === "pen" ? event.pressure : 1;
    const last = this.points.at(-1);
    if (last && Math.hypot(x - last[0], y - last[1]) < STEP * this.size) return;
    if (this.points.length < 5000) this.points.push([x, y, pressure]);
    this.at = { x, y };
  }

  paint(points) {
    const tool = this.tool;
    const value = this.isMask ? 1 : Number($("brush-value").value);
    const brush = { tool, size: this.size, value, hardness: Number($("brush-hardness").value), opacity: Number($("brush-opacity").value) };
    // erasing a mask takes away, erasing weights goes back to 1
    if (this.isMask && tool === "erase") Object.assign(brush, { tool: "paint", value: 0 });
    this.last = points;
    const box = this.box;
    if (box === undefined) return;
    if (box) {
      const [across, down] = sizes(box);
      brush.size /= Math.sqrt(across * down);
      const within = (x, y) => shareAt(box, x, y).map((share, axis) => share * (axis ? box.rows : box.cols));
      points = points.map(([x, y, pressure]) => [...within(x, y), pressure]);
    }
    const place = box ? this.studio.layers.chosen.place : null;
    this.studio.ask({ do: "paint", role: this.role, place, brush, points });
    this.draw();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    if (!this.release) return;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const size = $("brush-size");
    if (event.key === "[") size.value = this.size / 1.15;
    else if (event.key === "]") size.value = this.size * 1.15 + 1;
    else if (event.key === "Escape") this.use(false);
    else if (KEYS[event.key]) document.querySelector(`input[name=brush-tool][value=${KEYS[event.key]}]`).checked = true;
    else if (event.target === this.stage.view.canvas && moves) {
      const step = (event.shiftKey ? 0.5 : 0.1) * this.size;
      const { x, y } = this.at ?? { x: this.studio.frame.full[0] / 2, y: this.studio.frame.full[1] / 2 };
      this.at = { x: x + step * moves[0], y: y + step * moves[1] };
    } else if (event.target === this.stage.view.canvas && event.key === "Enter" && this.at) this.paint([[this.at.x, this.at.y, 1]]);
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.draw();
  }

  /** Show the picture of the role, the stroke that is drawn, and the rim of the brush. */
  draw() {
    const { paint, view } = this.stage;
    const context = paint.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, paint.width, paint.height);
    if (!this.release || view.camera.orbits || !this.studio.frame) return;
    const density = paint.width / view.camera.width;
    const corner = view.toScreen(0, 0);
    context.setTransform(density * view.scale, 0, 0, density * view.scale, density * corner.x, density * corner.y);
    const [cols, rows] = this.studio.frame.full;
    const box = this.box;
    if (this.picture && box !== undefined) {
      context.save();
      if (box) context.transform(...[0, 1, 2].flatMap((column) => box.matrix.map((row) => row[column])));
      context.drawImage(this.picture, 0, 0, box?.cols ?? cols, box?.rows ?? rows);
      context.restore();
    }
    if (this.points) this.drawStroke(context);
    if (this.at) {
      context.lineWidth = 1.5 / view.scale;
      for (const [colour, more] of [["#1d1b18", context.lineWidth], ["#fffbe8", 0]]) {
        context.strokeStyle = colour;
        context.beginPath();
        context.arc(this.at.x, this.at.y, this.size / 2 + more, 0, 2 * Math.PI);
        context.stroke();
      }
    }
  }

  drawStroke(context) {
    context.strokeStyle = this.tool === "erase" ? "rgb(255 251 232 / 45%)" : "rgb(64 128 255 / 45%)";
    context.lineCap = context.lineJoin = "round";
    context.lineWidth = this.size;
    context.beginPath();
    context.moveTo(...this.points[0].slice(0, 2));
    context.lineTo(...this.points[0].slice(0, 2));
    for (const [x, y] of this.points) context.lineTo(x, y);
    context.stroke();
  }
}

/** A picture that tints what is dark, and shows what is white. */
function tinted(bitmap) {
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext("2d");
  context.drawImage(bitmap, 0, 0);
  const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height);
  const { data } = pixels;
  for (let i = 0; i < data.length; i += 4) {
    data[i + 3] = 0.55 * (255 - data[i]);
    [data[i], data[i + 1], data[i + 2]] = [64, 128, 255];
  }
  context.putImageData(pixels, 0, 0);
  return canvas;
}
