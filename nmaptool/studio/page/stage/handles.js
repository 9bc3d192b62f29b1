/* The frame around the chosen layer: drag it to move the layer, its corners and sides to scale, the knob to turn. */

import { marks, moved, keysFor, pointAt, shareAt, sizes, snap, stretched, turned, wrapped } from "./placing.js";

const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]];
const SIDES = [[0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]];
const SNAP = 7; // CSS px
const SNAP_TURN = 2.5; // degrees from a multiple of 15
const SMALLEST = 0.01;
const MIDDLE = [0.5, 0.5];

export function setUpHandles(studio, stage, layers) {
  const handles = new Handles(studio, stage, layers);
  layers.onChosen(() => handles.draw());
  studio.on("placements", (message) => handles.place(message));
  stage.onView(() => handles.draw());
  return handles;
}

class Handles {
  constructor(studio, stage, layers) {
    Object.assign(this, { studio, stage, layers });
    this.placements = null;
    this.drag = null; // while something moves: the box before, and the one now
    this.guides = [];
    this.sending = false;
    this.isShown = true;
    this.group = stage.svg.appendChild(document.createElementNS(stage.svg.namespaceURI, "g"));
    this.group.id = "handles";
    this.parts = this.build();
  }

  place(message) {
    this.placements = message;
    this.draw();
  }

  /** Show the frame, or hide it while another tool is in use. */
  show(isShown) {
    this.isShown = isShown;
    this.draw();
  }

  /** The box of the chosen layer; null if it has none. */
  get box() {
    const chosen = this.layers.chosen;
    if (!chosen || !this.placements) return null;
    return this.placements.layers.find((one) => one.place.join() === chosen.place.join()) ?? null;
  }

  build() {
    const frame = this.part("path", "frame", "Layer: arrow keys move it", (event) => this.grabFrame(event));
    const corners = CORNERS.map((share) => this.part("rect", "knob", "Corner: + and - scale the layer", (event) => this.grabSize(event, share, true)));
    const sides = SIDES.map((share) => this.part("rect", "knob side", "", (event) => this.grabSize(event, share, false)));
    const stem = this.part("line", "stem", "");
    const turn = this.part("circle", "knob", "Turn: left and right arrow keys turn the layer", (event) => this.grabTurn(event));
    turn.setAttribute("r", 7);
    frame.addEventListener("keydown", (event) => this.key(event));
    for (const knob of [...corners, turn]) knob.addEventListener("keydown", (event) => this.key(event));
    for (const knob of corners.slice(1)) knob.removeAttribute("tabindex"); // one is enough for the keyboard
    return { frame, corners, sides, stem, turn, guides: this.part("path", "guide", "") };
  }

  part(tag, className, label, grab = null) {
    const made = this.group.appendChild(document.createElementNS(this.group.namespaceURI, tag));
    made.setAttribute("class", className);
    if (label) {
      made.setAttribute("tabindex", "0");
      made.setAttribute("role", "button");
      made.setAttribute("aria-label", label);
    }
    if (grab) made.addEventListener("pointerdown", (event) => event.button === 0 && grab(event));
    return made;
  }

  draw() {
    const box = this.drag?.box ?? this.box;
    const isFlat = !this.stage.view.camera.orbits;
    this.group.setAttribute("display", box && isFlat && this.isShown && this.stage.view.relief ? "inline" : "none");
    if (!box || !isFlat) return;
    const at = (share) => this.stage.view.toScreen(...pointAt(box, share));
    const { frame, corners, sides, stem, turn, guides } = this.parts;
    const points = CORNERS.map(at);
    frame.setAttribute("d", `M${points.map(({ x, y }) => `${x} ${y}`).join("L")}Z`);
    const put = (knob, { x, y }) => {
      for (const [name, value] of Object.entries({ x: x - 6, y: y - 6, width: 12, height: 12 })) knob.setAttribute(name, value);
    };
    corners.forEach((knob, i) => put(knob, points[i]));
    sides.forEach((knob, i) => put(knob, at(SIDES[i])));
    const [top, middle] = [at([0.5, 0]), at(MIDDLE)];
    const length = Math.hypot(top.x - middle.x, top.y - middle.y) || 1;
    const out = [(top.x - middle.x) / length, (top.y - middle.y) / length];
    const end = { x: top.x + 28 * out[0], y: top.y + 28 * out[1] };
    for (const [name, value] of Object.entries({ x1: top.x, y1: top.y, x2: end.x, y2: end.y })) stem.setAttribute(name, value);
    turn.setAttribute("cx", end.x);
    turn.setAttribute("cy", end.y);
    guides.setAttribute("d", this.guides.map((line) => this.guide(line)).join(""));
  }

  guide({ axis, value }) {
    const { cols, rows } = this.placements.canvas;
    const ends = axis === 0 ? [[value, 0], [value, rows]] : [[0, value], [cols, value]];
    const [from, to] = ends.map((end) => this.stage.view.toScreen(...end));
    return `M${from.x} ${from.y}L${to.x} ${to.y}`;
  }

  /** Follow the pointer until it is released; `change` returns the box for a place on the canvas. */
  follow(event, change) {
    const start = this.box;
    const target = event.currentTarget;
    const from = this.stage.view.toGrid(event);
    target.setPointerCapture(event.pointerId);
    this.drag = { start, box: start, options: this.layers.chosen.options, place: this.layers.chosen.place };
    target.onpointermove = (now) => {
      const to = this.stage.view.toGrid(now);
      if (!to) return;
      this.guides = [];
      this.drag.box = change(start, from, to, now);
      this.draw();
      this.send(true);
    };
    const end = () => {
      target.onpointermove = target.onpointerup = target.onpointercancel = null;
      this.guides = [];
      if (this.drag && this.drag.box !== start) this.send(false);
      else this.drag = null;
      this.draw();
    };
    target.onpointerup = target.onpointercancel = end;
  }

  grabFrame(event) {
    this.follow(event, (start, from, to, now) => this.snapped(moved(start, to.x - from.x, to.y - from.y), now.altKey));
  }

  /** The box, moved so that its edges or its middle lie on those of the canvas or of other layers. */
  snapped(box, isFree) {
    if (isFree) return box;
    const { canvas, layers } = this.placements;
    const reach = SNAP / this.stage.view.scale;
    const others = layers.filter((one) => one.place.join() !== this.drag.place.join());
    let now = box;
    for (const axis of [0, 1]) {
      const size = axis === 0 ? canvas.cols : canvas.rows;
      const targets = [0, size / 2, size, ...others.flatMap((one) => marks(one, axis))];
      const found = snap(marks(now, axis), targets, reach);
      if (!found) continue;
      now = moved(now, axis === 0 ? found.shift : 0, axis === 1 ? found.shift : 0);
      this.guides.push({ axis, value: found.target });
    }
    return now;
  }

  /** Scale from a corner or side; the opposite one stays, or the middle with Alt. */
  grabSize(event, share, isCorner) {
    this.follow(event, (start, from, to, now) => {
      const fixed = now.altKey ? MIDDLE : share.map((value) => 1 - value);
      const reached = shareAt(start, to.x, to.y);
      const factors = [0, 1].map((axis) => {
        const whole = share[axis] - fixed[axis];
        return whole === 0 ? 1 : Math.max((reached[axis] - fixed[axis]) / whole, SMALLEST);
      });
      if (!isCorner) return stretched(start, fixed, ...factors);
      const even = now.shiftKey ? factors : Array(2).fill(Math.max(...factors));
      return stretched(start, fixed, ...this.wholeFactors(start, even, now.altKey));
    });
  }

  /** Factors of the whole layer near 1 snap to it. */
  wholeFactors(start, factors, isFree) {
    const now = sizes(start).map((size, axis) => size * factors[axis]);
    if (isFree || now.some((size) => Math.abs(size - 1) > 0.03)) return factors;
    return sizes(start).map((size) => 1 / size);
  }

  grabTurn(event) {
    this.follow(event, (start, from, to, now) => {
      const [x, y] = pointAt(start, MIDDLE);
      const direction = (place) => (Math.atan2(y - place.y, place.x - x) * 180) / Math.PI;
      const wanted = wrapped(this.drag.options.rotate + direction(to) - direction(from));
      const step = 15 * Math.round(wanted / 15);
      const snaps = now.shiftKey || (!now.altKey && Math.abs(wrapped(wanted - step)) < SNAP_TURN);
      return turned(start, MIDDLE, (snaps ? step : wanted) - this.drag.options.rotate);
    });
  }

  key(event) {
    const start = this.box;
    const step = event.shiftKey ? 10 : 1;
    const isTurn = event.currentTarget === this.parts.turn;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    let box = null;
    if (isTurn && (event.key === "ArrowLeft" || event.key === "ArrowRight"))
      box = turned(start, MIDDLE, event.key === "ArrowLeft" ? step : -step);
    else if (!isTurn && moves[event.key]) box = moved(start, ...moves[event.key].map((value) => step * value));
    else if (event.key === "+" || event.key === "-") {
      const factor = event.key === "+" ? 1.01 ** step : 1.01 ** -step;
      box = stretched(start, MIDDLE, factor, factor);
    }
    if (!box) return;
    event.preventDefault();
    event.stopPropagation();
    this.drag = { start, box, options: this.layers.chosen.options, place: this.layers.chosen.place };
    this.send(false);
  }

  /** Tell the server where the layer is, once for each frame of the screen while it moves. */
  send(moving) {
    const { start, box, options, place } = this.drag;
    const values = keysFor(start, box, options, this.placements.canvas);
    if (!moving) {
      // until the server has placed it, the frame stays where it was left
      const kept = this.placements.layers.map((one) => (one === start ? box : one));
      this.placements = { ...this.placements, layers: kept };
      this.drag = null;
      this.waiting = null;
      this.studio.ask({ do: "set-layer", place, values, moving });
      return;
    }
    const isWaiting = Boolean(this.waiting);
    this.waiting = { do: "set-layer", place, values, moving };
    if (isWaiting) return;
    requestAnimationFrame(() => {
      if (this.waiting) this.studio.ask(this.waiting);
      this.waiting = null;
    });
  }
}
