/* Before and after: the snapshot on the left of a bar, the relief as it is on the right. */

import { $ } from "../studio.js";

const STEP = 0.02;

export function setUpSplit(view) {
  const bar = $("split-bar");

  function place(share) {
    view.split = Math.min(Math.max(share, 0), 1);
    bar.style.left = `${100 * view.split}%`;
    bar.setAttribute("aria-valuenow", Math.round(100 * view.split));
    view.draw();
  }

  function compare(isOn) {
    bar.hidden = !isOn;
    $("compare").setAttribute("aria-pressed", isOn);
    if (isOn) place(view.split ?? 0.5);
    else {
      view.split = null;
      view.draw();
    }
  }

  $("snapshot").addEventListener("click", () => {
    if (!view.relief) return;
    view.keep();
    $("compare").disabled = false;
    compare(true);
  });
  $("compare").addEventListener("click", () => compare(view.split === null));
  bar.addEventListener("pointerdown", (event) => {
    bar.setPointerCapture(event.pointerId);
    bar.onpointermove = (moved) => {
      const box = view.canvas.getBoundingClientRect();
      place((moved.clientX - box.left) / box.width);
    };
  });
  for (const end of ["pointerup", "pointercancel"])
    bar.addEventListener(end, () => {
      bar.onpointermove = null;
    });
  bar.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -STEP, ArrowRight: STEP, Home: -1, End: 1 }[event.key];
    if (way === undefined) return;
    event.preventDefault();
    place(view.split + way);
  });
}
