/* The panels beside the picture: one of them is shown. */

import { $ } from "../studio.js";

const TURNS = { ArrowLeft: -1, ArrowRight: 1 };

export function setUpTabs(studio, handles, brush) {
  const tabs = [...$("tabs").querySelectorAll("[role=tab]")];

  function show(chosen) {
    for (const tab of tabs) {
      const isChosen = tab === chosen;
      tab.setAttribute("aria-selected", String(isChosen));
      tab.tabIndex = isChosen ? 0 : -1;
      $(tab.getAttribute("aria-controls")).hidden = !isChosen;
    }
    handles.show(chosen.id === "tab-layers");
    if (chosen.id !== "tab-brushes") brush.use(false);
  }

  for (const tab of tabs) tab.addEventListener("click", () => show(tab));
  $("tabs").addEventListener("keydown", (event) => {
    const turn = TURNS[event.key];
    if (!turn) return;
    const next = tabs[(tabs.indexOf(document.activeElement) + turn + tabs.length) % tabs.length];
    next.focus();
    show(next);
    event.preventDefault();
  });
  handles.show(false);
  studio.on("added", () => show($("tab-layers"))); // to put the new layer in its place
  studio.on("findings", ({ layers }) => {
    const count = layers.reduce((sum, one) => sum + one.findings.length, 0);
    $("tab-layers").textContent = count ? `Layers (${count})` : "Layers";
    $("tab-layers").title = count ? `${count} ${count === 1 ? "finding" : "findings"} in the maps` : "";
  });
}
