/* What the user chose for the view: kept in this browser, not in the document. */

import { MATERIALS, OVERLAYS } from "./materials.js";

const KEY = "nmap-studio-view";
export const MOST_LIGHTS = 3;

/** Settings as read from anywhere: what is not sensible is left out. */
export function sensible(read) {
  const found = {};
  const given = read !== null && typeof read === "object" ? read : {};
  if (Object.hasOwn(MATERIALS, given.material)) found.material = given.material;
  if (Object.values(OVERLAYS).includes(given.overlay)) found.overlay = given.overlay;
  if (typeof given.shadows === "boolean") found.shadows = given.shadows;
  if (given.draft >= 0 && given.draft <= 89) found.draft = given.draft;
  const lights = (Array.isArray(given.lights) ? given.lights : []).filter(isLight).slice(0, MOST_LIGHTS);
  if (lights.length) found.lights = lights.map(({ azimuth, elevation, strength }) => ({ azimuth, elevation, strength }));
  return found;
}

function isLight(light) {
  return (
    Number.isFinite(light?.azimuth) &&
    light.elevation >= 3 &&
    light.elevation <= 89 &&
    light.strength >= 0 &&
    light.strength <= 1.5
  );
}

/** Read the settings; a browser may forbid it. */
export function read() {
  try {
    return sensible(JSON.parse(localStorage.getItem(KEY)));
  } catch {
    return {};
  }
}

export function write(view) {
  try {
    localStorage.setItem(KEY, JSON.stringify(sensible(view)));
  } catch {
    // the choice lasts as long as the page
  }
}
