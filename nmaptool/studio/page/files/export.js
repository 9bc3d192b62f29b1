/* Download the relief as a file. */

import { $ } from "../studio.js";

const FORMATS = ["stl", "3mf", "ply", "obj", "glb", "exr", "png", "tif"];

export function setUpExport(studio) {
  for (const ending of FORMATS) $("format").add(new Option(ending.toUpperCase(), ending));
  $("export").addEventListener("click", () => download(studio));
}

async function download(studio) {
  const ending = $("format").value;
  $("export").disabled = true;
  studio.tell(`exporting ${ending}`);
  try {
    const answer = await fetch(`export/${ending}`);
    if (!answer.ok) {
      studio.say((await answer.json()).text);
      return;
    }
    const named = /filename="?([^";]+)/.exec(answer.headers.get("content-disposition") ?? "");
    const url = URL.createObjectURL(await answer.blob());
    Object.assign(document.createElement("a"), { href: url, download: named ? named[1] : `relief.${ending}` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
    studio.tell("exported");
  } finally {
    $("export").disabled = false;
  }
}
