/* The studio's page: puts the controls, the picture and the server together. */

import { combined, decode } from "./heights.js";
import { Link } from "./link.js";
import { Panel } from "./panel.js";
import { MATERIALS, OVERLAYS, View } from "./view.js";

const $ = (id) => document.getElementById(id);
// the page computes these from the two parts of the heights; the server only stores them
const LOCAL = new Set(["delta", "height", "width", "fit"]);
const FORMATS = ["stl", "3mf", "ply", "obj", "glb", "exr", "png", "tif"];

const state = { values: null, frame: null, asked: null };
const view = new View($("view"));
const panel = new Panel($("controls"), change);
const link = new Link(hear, (bytes) => see(decode(bytes)), connected);

function change(name, value, moving) {
  say("");
  state.values = { ...state.values, [name]: value };
  if (LOCAL.has(name) && state.values.edge === "blend") {
    if (state.frame && value !== null) render();
    if (moving) return;
  }
  state.asked = { do: "set", values: { [name]: value }, moving };
  // one message for each frame of the screen at most
  requestAnimationFrame(() => {
    if (state.asked && !link.ask(state.asked)) say("the studio does not answer; start nmap studio again");
    state.asked = null;
  });
}

function hear(message) {
  if (message.kind === "controls") panel.build(message.controls);
  else if (message.kind === "state") {
    state.values = message.values;
    panel.show(message.values);
    $("name").textContent = message.name;
    document.title = `${message.name} - nmap studio`;
    $("saved").textContent = message.is_saved ? "saved" : "not saved";
    $("undo").disabled = message.undo === 0;
    $("redo").disabled = message.redo === 0;
    state.path = message.path;
    $("layers").replaceChildren(
      ...message.layers.map((label) => Object.assign(document.createElement("li"), { textContent: label })),
    );
    if (state.frame) render();
  } else if (message.kind === "progress") {
    $("status").textContent = `${message.stage} ${Math.round(100 * message.share)} %`;
  } else if (message.kind === "saved") {
    $("status").textContent = `saved ${message.path}`;
  } else if (message.kind === "error") say(message.text);
}

function see(frame) {
  state.frame = frame;
  say("");
  render();
  const grid = `${frame.cols - 1} x ${frame.rows - 1} px`;
  $("status").textContent = frame.is_full ? `full resolution, ${grid}` : `preview, ${grid}`;
}

function render() {
  const { frame, values } = state;
  const { z, span, low, high, pitch } = combined(frame, values);
  view.show(z, frame.surface, frame.cols, frame.rows, { low, high, pitch });
  const size = `${((frame.cols - 1) * pitch).toFixed(1)} x ${((frame.rows - 1) * pitch).toFixed(1)} mm`;
  $("facts").textContent = `${size}, ${span.toFixed(3)} mm high`;
}

function say(text) {
  $("error").textContent = text;
}

function connected(open) {
  if (!open) $("status").textContent = "waiting for the studio";
}

function save() {
  let name = null;
  if (!state.path) {
    name = prompt("Name of the recipe", "relief.toml");
    if (!name) return;
  }
  link.ask({ do: "save", name });
}

async function download() {
  const ending = $("format").value;
  $("export").disabled = true;
  $("status").textContent = `exporting ${ending}`;
  try {
    const answer = await fetch(`export/${ending}`);
    if (!answer.ok) {
      say((await answer.json()).text);
      return;
    }
    const named = /filename="?([^";]+)/.exec(answer.headers.get("content-disposition") ?? "");
    const url = URL.createObjectURL(await answer.blob());
    Object.assign(document.createElement("a"), { href: url, download: named ? named[1] : `relief.${ending}` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
    $("status").textContent = "exported";
  } finally {
    $("export").disabled = false;
  }
}

function moveLight(azimuth, elevation) {
  view.light = { azimuth: (azimuth + 360) % 360, elevation: Math.min(Math.max(elevation, 3), 89) };
  const reach = 0.42 * Math.min($("picture").clientWidth, $("picture").clientHeight);
  const out = reach * Math.cos((view.light.elevation * Math.PI) / 180);
  const angle = (view.light.azimuth * Math.PI) / 180;
  const knob = $("light");
  knob.style.left = `${$("picture").clientWidth / 2 + out * Math.cos(angle)}px`;
  knob.style.top = `${$("picture").clientHeight / 2 - out * Math.sin(angle)}px`;
  knob.setAttribute("aria-valuenow", Math.round(view.light.azimuth));
  knob.setAttribute("aria-valuetext", `${Math.round(view.light.azimuth)} degrees, ${Math.round(view.light.elevation)} high`);
  view.draw();
}

function dragLight(event) {
  const box = $("picture").getBoundingClientRect();
  const x = event.clientX - box.left - box.width / 2;
  const y = box.top + box.height / 2 - event.clientY;
  const share = Math.min(Math.hypot(x, y) / (0.42 * Math.min(box.width, box.height)), 0.999);
  moveLight((Math.atan2(y, x) * 180) / Math.PI, (Math.acos(share) * 180) / Math.PI);
}

const TURNS = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 3], ArrowDown: [0, -3] };

function keys(event) {
  const turn = TURNS[event.key];
  if (turn) moveLight(view.light.azimuth + turn[0], view.light.elevation + turn[1]);
  else if (event.key === "+" || event.key === "-")
    view.zoomAt(view.canvas.width / 2, view.canvas.height / 2, event.key === "+" ? 1.25 : 0.8);
  else return;
  event.preventDefault();
}

for (const name of Object.keys(MATERIALS)) $("material").add(new Option(name, name, name === view.material, name === view.material));
for (const name of Object.keys(OVERLAYS)) $("overlay").add(new Option(name, name));
for (const ending of FORMATS) $("format").add(new Option(ending.toUpperCase(), ending));

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
$("fit-view").addEventListener("click", () => state.frame && view.fit());
$("one-to-one").addEventListener("click", () => state.frame && view.actual());
$("undo").addEventListener("click", () => link.ask({ do: "undo" }));
$("redo").addEventListener("click", () => link.ask({ do: "redo" }));
$("save").addEventListener("click", save);
$("export").addEventListener("click", download);
$("light").addEventListener("keydown", keys);
$("light").addEventListener("pointerdown", (event) => {
  event.target.setPointerCapture(event.pointerId);
  event.target.onpointermove = dragLight;
});
$("light").addEventListener("pointerup", (event) => {
  event.target.onpointermove = null;
});

const canvas = $("view");
canvas.addEventListener("keydown", keys);
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  canvas.onpointermove = (moved) => {
    const density = canvas.width / canvas.clientWidth;
    view.pan(moved.movementX * density, moved.movementY * density);
  };
});
canvas.addEventListener("pointerup", () => {
  canvas.onpointermove = null;
});
canvas.addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    if (!state.frame) return;
    const density = canvas.width / canvas.clientWidth;
    view.zoomAt(event.offsetX * density, event.offsetY * density, 1.0015 ** -event.deltaY);
  },
  { passive: false },
);
document.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey)) return;
  const key = event.key.toLowerCase();
  if (key === "z") link.ask({ do: event.shiftKey ? "redo" : "undo" });
  else if (key === "y") link.ask({ do: "redo" });
  else if (key === "s") save();
  else return;
  event.preventDefault();
});
new ResizeObserver(() => {
  moveLight(view.light.azimuth, view.light.elevation);
  view.draw();
}).observe($("picture"));

// for tests in a browser
window.studio = { state, view };
