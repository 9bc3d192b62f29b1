/* The studio's page: puts its parts together. */

import { setUpDrop } from "./files/drop.js";
import { setUpExport } from "./files/export.js";
import { setUpSaving } from "./files/saving.js";
import { setUpControls } from "./panels/controls.js";
import { setUpFiles } from "./panels/files.js";
import { setUpLayers } from "./panels/layers.js";
import { setUpPresets } from "./panels/presets.js";
import { setUpBrush } from "./stage/brush.js";
import { setUpHandles } from "./stage/handles.js";
import { setUpMeshes } from "./panels/meshes.js";
import { setUpStage } from "./stage/stage.js";
import { $, Studio } from "./studio.js";

const studio = new Studio();
const stage = setUpStage(studio);
setUpPresets(studio);
setUpControls(studio);
const layers = setUpLayers(studio);
const handles = setUpHandles(studio, stage, layers);
setUpBrush(studio, stage, handles);
const meshes = setUpMeshes(studio, layers);
setUpFiles(studio);
setUpDrop(studio);
setUpSaving(studio);
setUpExport(studio);

studio.on("state", (message) => {
  $("name").textContent = message.name;
  document.title = `${message.name} - nmap studio`;
});
studio.on("progress", ({ stage: name, share }) => studio.tell(`${name} ${Math.round(100 * share)} %`));
studio.on("heights", (frame) => {
  const grid = `${frame.cols - 1} x ${frame.rows - 1} px`;
  studio.tell(frame.is_full ? `full resolution, ${grid}` : `preview, ${grid}`);
});
studio.on("connected", (open) => {
  if (!open) studio.tell("waiting for the studio");
});
studio.connect();

// for tests in a browser
window.studio = Object.assign(studio, { stage, layers, meshes });
