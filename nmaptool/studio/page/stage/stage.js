/* The picture and what surrounds it: the toolbar, the light, and the pointer on the canvas. */

import { combined, millimetres } from "../heights.js";
import { $ } from "../studio.js";
import { Pointer } from "./pointer.js";
import { MATERIALS, OVERLAYS } from "./materials.js";
import { View } from "./view.js";

const TURNS = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 3], ArrowDown: [0, -3] };

/**
 * Set up the picture. Returns, for tools on the canvas: `view` with `toGrid(event)` and `toScreen(x, y)`; `onView`, which
 * calls a listener when these change; `claim(tool)`, which gives a tool the pointer until the function that it returns
 * is called (see Pointer); and the layers above the picture that tools draw on, `svg` and `paint`.
 */
export function setUpStage(studio) {
  const view = new View($("view"));
  const pointer = new Pointer(view);
  setUpToolbar(studio, view);
  setUpLight(view);
  setUpLayers(view);
  view.canvas.addEventListener("keydown", (event) => keys(view, event));
  studio.on("render", () => render(studio, view));
  return {
    view,
    svg: $("tools-layer"),
    paint: $("paint-layer"),
    onView: (listener) => view.onView(listener),
    claim: (tool) => pointer.claim(tool),
  };
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

function render(studio, view) {
  const { frame, values } = studio;
  const { z, span, low, high, pitch } = combined(frame, values);
  const { cols, rows, surface, full } = frame;
  const width = (cols - 1) * pitch;
  const base = millimetres(values.base);
  // a surface without a back is shown as a thin plate
  const thick = Number.isFinite(base) ? base : 0.02 * width;
  view.show({ z, surface, cols, rows, low, high, pitch, full, base: thick });
  $("facts").textContent = `${width.toFixed(1)} x ${((rows - 1) * pitch).toFixed(1)} mm, ${span.toFixed(3)} mm high`;
}

function setUpToolbar(studio, view) {
  for (const name of Object.keys(MATERIALS))
    $("material").add(new Option(name, name, name === view.material, name === view.material));
  for (const name of Object.keys(OVERLAYS)) $("overlay").add(new Option(name, name));
  $("material").addEventListener("change", () => {
    view.material = $("material").value;
    view.draw();
  });
  $("overlay").addEventListener("change", () => {
    view.overlay = OVERLAYS[$("overlay").value];
    view.draw();
  });
  $("shadows").addEventListener("change", () => {
    view.shadows = $("shadows").checked;
    view.draw();
  });
  $("fit-view").addEventListener("click", () => studio.frame && view.fit());
  $("one-to-one").addEventListener("click", () => studio.frame && view.actual());
}

function keys(view, event) {
  const turn = TURNS[event.key];
  if (turn) moveLight(view, view.lights[0].azimuth + turn[0], view.lights[0].elevation + turn[1]);
  else if (event.key === "+" || event.key === "-")
    view.zoomAt(view.camera.width / 2, view.camera.height / 2, event.key === "+" ? 1.25 : 0.8);
  else return;
  event.preventDefault();
}

function moveLight(view, azimuth, elevation) {
  view.lights[0] = { ...view.lights[0], azimuth: (azimuth + 360) % 360, elevation: Math.min(Math.max(elevation, 3), 89) };
  const { clientWidth: width, clientHeight: height } = $("picture");
  const out = 0.42 * Math.min(width, height) * Math.cos((view.lights[0].elevation * Math.PI) / 180);
  const angle = (view.lights[0].azimuth * Math.PI) / 180;
  const [turned, high] = [view.lights[0].azimuth, view.lights[0].elevation].map(Math.round);
  const knob = $("light");
  knob.style.left = `${width / 2 + out * Math.cos(angle)}px`;
  knob.style.top = `${height / 2 - out * Math.sin(angle)}px`;
  knob.setAttribute("aria-valuenow", turned);
  knob.setAttribute("aria-valuetext", `${turned} degrees, ${high} high`);
  view.move();
}

function setUpLight(view) {
  function drag(event) {
    const box = $("picture").getBoundingClientRect();
    const x = event.clientX - box.left - box.width / 2;
    const y = box.top + box.height / 2 - event.clientY;
    const share = Math.min(Math.hypot(x, y) / (0.42 * Math.min(box.width, box.height)), 0.999);
    moveLight(view, (Math.atan2(y, x) * 180) / Math.PI, (Math.acos(share) * 180) / Math.PI);
  }

  const knob = $("light");
  knob.addEventListener("keydown", (event) => keys(view, event));
  knob.addEventListener("pointerdown", (event) => {
    knob.setPointerCapture(event.pointerId);
    knob.onpointermove = drag;
  });
  knob.addEventListener("pointerup", () => {
    knob.onpointermove = null;
  });
  new ResizeObserver(() => {
    view.look(() => {});
    moveLight(view, view.lights[0].azimuth, view.lights[0].elevation);
  }).observe($("picture"));
}
