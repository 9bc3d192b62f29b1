/* Overlays that only the studio can compute, from the composed map: its curl and its coverage. */

import { OVERLAYS } from "./materials.js";

const NAMES = new Map([
  [OVERLAYS["background and coverage"], "coverage"],
  [OVERLAYS.curl, "curl"],
]);

/** Read the bytes of an overlay; see nmaptool.studio.overlays. */
export function unpacked(bytes) {
  const [width, height] = [0, 4].map((at) => new DataView(bytes).getUint32(at, true));
  return { width, height, values: new Uint8Array(bytes, 8, width * height) };
}

export class MapLayers {
  constructor(studio, view) {
    this.studio = studio;
    this.view = view;
    this.shown = "";
    studio.on("heights", () => this.refresh());
    view.canvas.addEventListener("webglcontextrestored", () => {
      this.shown = "";
      this.refresh();
    });
  }

  /** Fetch what the view shows, if it is of other maps. */
  async refresh() {
    const name = NAMES.get(this.view.overlay);
    const { frame } = this.studio;
    const wanted = `${name} ${frame?.maps}`;
    if (!name || !frame || wanted === this.shown) return;
    this.shown = wanted;
    const answer = await fetch(`overlay/${name}`).catch(() => null);
    if (this.shown !== wanted) return; // another one was asked for meanwhile
    if (!answer?.ok) {
      this.shown = "";
      this.studio.say(answer ? (await answer.json()).text : "the studio does not answer; start nmap studio again");
      return;
    }
    this.view.renderer.showLayer(unpacked(await answer.arrayBuffer()));
    this.view.draw();
  }
}
