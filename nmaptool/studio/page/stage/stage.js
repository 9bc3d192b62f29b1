/* The picture and what surrounds it. */

import { combined, millimetres } from "../heights.js";
import { $ } from "../studio.js";
import { Lights } from "./lights.js";
import { MapLayers } from "./map_layers.js";
import { Pointer } from "./pointer.js";
import { mmText } from "./scales.js";
import { Section } from "./section_panel.js";
import * as settings from "./settings.js";
import { setUpSplit } from "./split.js";
import { Toolbar } from "./toolbar.js";
import { View } from "./view.js";

// thickness of a plate whose back is not set, as a share of its width
const THIN = 0.02;
// options that the view needs, and after what time without a change it shows the full grid again
const USED = ["delta", "height", "width", "fit", "base"];
const REST_MS = 200;

/**
 * Set up the picture. Returns, for tools on the canvas: `view` with `toGrid(event)` and `toScreen(x, y)`; `onView`, which
 * calls a listener when these change; `claim(tool)`, which gives a tool the pointer until the function that it returns
 * is called (see Pointer); and the layers above the picture that tools draw on, `svg` and `paint`.
 */
export function setUpStage(studio) {
  const view = started(studio);
  Object.assign(view, settings.read());
  const pointer = new Pointer(view);
  const maps = new MapLayers(studio, view);
  const toolbar = new Toolbar(view, () => {
    settings.write(view);
    maps.refresh();
  });
  const lights = new Lights(view, $("knobs"), () => {
    toolbar.showLights();
    settings.write(view);
  });
  toolbar.useLights(lights);
  setUpLayers(view);
  setUpSplit(view);
  const section = new Section(view);
  setUpReadOut(view);
  view.canvas.addEventListener("keydown", (event) => {
    if (!pointer.tool) toolbar.key(event);
  });
  new ResizeObserver(() => view.look(() => {})).observe($("picture"));
  new Rendering(studio, view, () => {
    toolbar.legend();
    section.draw();
  });
  return {
    view,
    svg: $("tools-layer"),
    paint: $("paint-layer"),
    onView: (listener) => view.onView(listener),
    claim: (tool) => pointer.claim(tool),
  };
}

/** The view; if this browser cannot show it, the page says why. */
function started(studio) {
  try {
    return new View($("view"));
  } catch (error) {
    studio.say(error.message);
    throw error;
  }
}

/** Computes the heights for the view: while a value moves, on the smaller grid of the same solve. */
class Rendering {
  constructor(studio, view, shown) {
    Object.assign(this, { studio, view, shown, key: "", preview: null, isNew: false, later: null });
    studio.on("heights", (frame) => {
      if (!frame.is_full) this.preview = frame;
      this.isNew = true;
    });
    studio.on("render", () => this.render());
  }

  render() {
    const { frame, values } = this.studio;
    const key = JSON.stringify(USED.map((name) => values[name]));
    if (key === this.key && !this.isNew) return;
    const isSmall = !this.isNew && frame.is_full && this.preview?.request === frame.request;
    Object.assign(this, { key, isNew: false });
    clearTimeout(this.later);
    this.show(isSmall ? this.preview : frame);
    if (isSmall) this.later = setTimeout(() => this.show(this.studio.frame), REST_MS);
  }

  show(frame) {
    const { values } = this.studio;
    const { z, span, low, high, pitch } = combined(frame, values);
    const { cols, rows, surface, full } = frame;
    const width = (cols - 1) * pitch;
    const base = millimetres(values.base);
    const thick = Number.isFinite(base) ? base : THIN * width;
    this.view.show({ z, surface, cols, rows, low, high, pitch, full, base: thick });
    $("facts").textContent = `${width.toFixed(1)} x ${((rows - 1) * pitch).toFixed(1)} mm, ${span.toFixed(3)} mm high`;
    this.shown();
  }
}

/** The layers that tools draw on have the size of the picture; the 2D canvas has its device pixels. */
function setUpLayers(view) {
  const [svg, paint] = [$("tools-layer"), $("paint-layer")];
  view.onView(() => {
    const [width, height] = [view.camera.width, view.camera.height].map((size) => Math.round(size * view.density));
    if (paint.width !== width) paint.width = width;
    if (paint.height !== height) paint.height = height;
    svg.setAttribute("viewBox", `0 0 ${view.camera.width} ${view.camera.height}`);
  });
}

/** Where the pointer is on the relief, and how high that is. */
function setUpReadOut(view) {
  const shown = $("read-out");
  view.canvas.addEventListener("pointermove", (event) => {
    const place = view.relief && view.toGrid(event);
    const height = place ? view.heightAt(place.x, place.y) : NaN;
    if (!Number.isFinite(height)) {
      shown.textContent = "";
      return;
    }
    const [x, y] = [place.x, place.y].map((px) => mmText(px / view.pxPerMm, 0.1));
    shown.textContent = `${x}, ${y} mm: ${mmText(height, 0.001)} mm high`;
  });
  view.canvas.addEventListener("pointerleave", () => {
    shown.textContent = "";
  });
}
