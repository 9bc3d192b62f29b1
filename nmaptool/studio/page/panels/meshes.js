/* The open meshes, the layers that were baked from them, and the detail map. */

import { $ } from "../studio.js";
import { Form } from "./form.js";
import { MeshPanel } from "./mesh.js";

export function setUpMeshes(studio, layers) {
  const panel = new MeshPanel(studio);
  let latest = null;
  const baked = (layer) => latest?.layers.find((one) => one.place.join() === layer?.place.join());

  function show() {
    $("meshes-title").hidden = !latest?.meshes.length;
    $("meshes").replaceChildren(...(latest?.meshes ?? []).map((one) => item(studio, panel, one)));
    $("layer-bake").hidden = !baked(layers.chosen);
    const running = latest?.running;
    $("job").hidden = !running;
    if (running) progress(running);
  }

  function again() {
    const one = baked(layers.chosen);
    const mesh = latest.meshes.find(({ id }) => id === one.mesh);
    if (!mesh) studio.say(`${one.label}: its mesh was closed; drop it again`);
    else panel.open({ id: mesh.id, name: mesh.name, place: one.place, values: one.values });
  }

  studio.on("meshes", (message) => {
    latest = message;
    show();
  });
  for (const kind of ["bake", "detail"])
    studio.on(kind, (message) => {
      $("job").hidden = message.state !== "running";
      progress(message);
      const ended = { done: message.text, cancelled: `${message.what}: cancelled`, failed: "" }[message.state];
      if (ended !== undefined) $("job-result").textContent = ended;
      if (message.state === "failed") studio.say(message.text);
    });
  layers.onChosen(() => show());
  $("layer-bake").addEventListener("click", again);
  $("job-cancel").addEventListener("click", () => studio.ask({ do: "cancel-bake" }));
  setUpDetail(studio);
  return panel;
}

function progress({ what, stage, share }) {
  $("job-share").value = share;
  $("job-name").textContent = stage ? `${what}: ${stage}` : what;
}

function item(studio, panel, one) {
  const li = document.createElement("li");
  const text = document.createElement("span");
  text.textContent = one.state === "failed" ? one.text : `${one.name}: ${one.text}`;
  const button = (label, name, clicked) => {
    const made = Object.assign(document.createElement("button"), { type: "button", textContent: label });
    made.setAttribute("aria-label", name);
    made.addEventListener("click", clicked);
    return made;
  };
  const camera = button("Camera", `Camera of ${one.name}`, () => panel.open(one));
  camera.disabled = one.state === "failed";
  const close = button("Close", `Close ${one.name}`, () => studio.ask({ do: "close-mesh", id: one.id }));
  li.append(text, camera, close);
  return li;
}

function setUpDetail(studio) {
  let form = null;
  studio.on("forms", (message) => {
    form = new Form($("split-form"), message.split, () => {});
    form.show({});
  });
  $("split-detail").addEventListener("click", () => {
    studio.say("");
    studio.ask({ do: "split-detail", values: form.values });
  });
  $("follow-details").addEventListener("click", () => studio.ask({ do: "follow-details" }));
  studio.on("meshes", ({ detail }) => {
    const hasLayers = Boolean(studio.document?.layers.length);
    $("detail").hidden = !hasLayers;
    $("detail-state").textContent = stateOf(detail);
    $("follow-details").hidden = !detail.is_offered;
    $("split-detail").textContent = detail.split ? "Make the detail map again" : "Make a detail map";
    if (detail.split && form) form.show(detail.split);
  });
}

function stateOf(detail) {
  if (!detail.name) return "There is no detail map, so mu has no effect.";
  if (detail.is_stale) return `${detail.name} belongs to the layers as they were before they changed; make it again.`;
  if (detail.split) return `${detail.name} was split off the layers as they are.`;
  if (detail.is_followed) return "The detail of the baked layers is used and moves with them.";
  return `${detail.name} is used as it is; it does not move with the layers.`;
}
