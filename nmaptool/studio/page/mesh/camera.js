/* The camera of a bake: its direction and framing, as nmaptool.render.camera computes them. */

const TO_Z_UP = [1, 0, 0, 0, 0, 1, 0, -1, 0];
const MM = { mm: 1, cm: 10, m: 1000, in: 25.4 };
// smallest distance of a perspective camera from the mesh, as a share of its extent across the view
const CLEARANCE = 0.01;

/** Rotation from axis `first` towards axis `second`, row by row; exact for quarter turns. */
function turn(first, second, degrees) {
  const quarter = Math.floor(degrees / 90);
  const rest = ((degrees - 90 * quarter) * Math.PI) / 180;
  let [cosine, sine] = [Math.cos(rest), Math.sin(rest)];
  for (let i = 0; i < ((quarter % 4) + 4) % 4; i++) [cosine, sine] = [-sine, cosine];
  const out = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  out[4 * first] = cosine;
  out[4 * second] = cosine;
  out[3 * second + first] = sine;
  out[3 * first + second] = -sine;
  return out;
}

function product(a, b) {
  const out = new Array(9).fill(0);
  for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) for (let k = 0; k < 3; k++) out[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return out;
}

/** Rotation from mesh to eye space: x right, y up, z to the viewer. */
export function viewRotation(azimuth, elevation, roll, up) {
  let rotation = up === "z" ? TO_Z_UP : turn(0, 2, 0);
  for (const [first, second, angle] of [
    [2, 0, -azimuth],
    [1, 2, elevation],
    [0, 1, roll],
  ])
    rotation = product(turn(first, second, angle), rotation);
  return rotation;
}

export function rotated(r, x, y, z) {
  return [r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z];
}

/** Number and unit of a length such as "4%", "40px" or "0.1mm"; null if it is not one. */
export function lengthOf(text) {
  const found = /^\s*([-+.\de]+)\s*(mm|cm|m|inch|in|"|\u2033|px|%)\s*$/i.exec(String(text ?? ""));
  if (!found || !Number.isFinite(Number(found[1]))) return null;
  const unit = found[2].toLowerCase();
  return { number: Number(found[1]), unit: ["inch", '"', "\u2033"].includes(unit) ? "in" : unit };
}

/** Columns and rows of a size such as "1000x900"; null if it is not one. */
export function sizeOf(text) {
  const found = /^\s*(\d{1,7})\s*[x,×]\s*(\d{1,7})\s*$/i.exec(String(text ?? ""));
  return found && Number(found[1]) > 0 && Number(found[2]) > 0 ? { cols: Number(found[1]), rows: Number(found[2]) } : null;
}

/**
 * The camera of a bake; null if the options cannot be read or the mesh does not fit: the server says why.
 *
 * @param {Float64Array} corners  of the mesh's convex hull
 * @param {object} options  of BakeOptions, with azimuth and elevation as numbers
 * @param {number} mmPerUnit
 * @returns {{rotation: number[], center: number[], unitPerPx: number, cols: number, rows: number,
 *   distance: number | null, near: number, far: number} | null}  near and far: range of z in eye space around `center`
 */
export function frameCamera(corners, options, mmPerUnit) {
  const size = sizeOf(options.size);
  const border = lengthOf(options.margin);
  if (!size || !border) return null;
  const { cols, rows } = size;
  const margin = border.unit === "%" ? (border.number / 100) * Math.max(cols, rows) : border.number;
  const room = [cols - 2 * margin, rows - 2 * margin];
  if (!(room[0] > 0 && room[1] > 0)) return null;
  const rotation = viewRotation(options.azimuth, options.elevation, options.roll, options.up);
  const { low, high, turned } = extent(corners, rotation);
  const center = low.map((value, k) => (value + high[k]) / 2);
  const across = Math.max(high[0] - low[0], high[1] - low[1]);
  if (!(across > 0)) return null;
  const tangent = (Math.tan((options.fov * Math.PI) / 360) * 2) / Math.max(cols, rows);
  let unitPerPx = Math.max((high[0] - low[0]) / room[0], (high[1] - low[1]) / room[1]);
  if (options.fov) {
    const [x, y, distance] = fitted(turned, center[2], [(room[0] / 2) * tangent, (room[1] / 2) * tangent]);
    [center[0], center[1]] = [x, y];
    unitPerPx = Math.max(distance, (high[2] - low[2]) / 2 + CLEARANCE * across) * tangent;
  }
  const pitch = lengthOf(options.pitch);
  if (pitch && MM[pitch.unit]) unitPerPx = (pitch.number * MM[pitch.unit]) / mmPerUnit;
  const target = String(options.target ?? "").split(",").map(Number);
  if (options.target && target.length === 3 && target.every(Number.isFinite)) center.splice(0, 3, ...rotated(rotation, ...target));
  const distance = options.fov ? unitPerPx / tangent : null;
  return { rotation, center, unitPerPx, cols, rows, distance, near: high[2] - center[2], far: low[2] - center[2] };
}

function extent(corners, rotation) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const turned = new Float64Array(corners.length);
  for (let i = 0; i < corners.length; i += 3) {
    const point = rotated(rotation, corners[i], corners[i + 1], corners[i + 2]);
    for (let k = 0; k < 3; k++) {
      turned[i + k] = point[k];
      if (point[k] < low[k]) low[k] = point[k];
      if (point[k] > high[k]) high[k] = point[k];
    }
  }
  return { low, high, turned };
}

/** Centre x and y, and the smallest distance from z = `middle` at which an eye sees all points within the slopes. */
function fitted(turned, middle, tangents) {
  const outer = [-Infinity, -Infinity];
  const inner = [Infinity, Infinity];
  for (let i = 0; i < turned.length; i += 3) {
    for (let k = 0; k < 2; k++) {
      const depth = (turned[i + 2] - middle) * tangents[k];
      outer[k] = Math.max(outer[k], turned[i + k] + depth);
      inner[k] = Math.min(inner[k], turned[i + k] - depth);
    }
  }
  const distance = Math.max(...[0, 1].map((k) => (outer[k] - inner[k]) / (2 * tangents[k])));
  return [(outer[0] + inner[0]) / 2, (outer[1] + inner[1]) / 2, distance];
}

/**
 * The 4 x 4 matrix, column by column, from positions around `origin` to clip space.
 *
 * @param {object} camera  as `frameCamera` returns it
 * @param {number[]} origin
 */
export function clipMatrix(camera, origin) {
  const { rotation: r, center, unitPerPx, cols, rows, distance, near, far } = camera;
  const at = rotated(r, ...origin).map((value, k) => value - center[k]);
  const x = 2 / (unitPerPx * cols);
  const y = 2 / (unitPerPx * rows);
  const slack = 1e-3 * Math.max(near - far, 1e-9 * unitPerPx * cols);
  // rows of the matrix, each as factors of the eye's x, y, z and 1
  let depth;
  let w = [0, 0, 0, 1];
  if (distance === null) {
    const span = near - far + 2 * slack;
    depth = [0, 0, -2 / span, (near + far) / span];
  } else {
    const closest = Math.max(distance - near - slack, 1e-6 * distance);
    const farthest = Math.max(distance - far + slack, 2 * closest);
    const scale = (farthest + closest) / (farthest - closest);
    // (scale * ahead - 2 farthest closest / (farthest - closest)) / ahead, where ahead = distance - z
    depth = [0, 0, -scale / distance, scale - (2 * farthest * closest) / (farthest - closest) / distance];
    w = [0, 0, -1 / distance, 1];
  }
  const lines = [[x, 0, 0, 0], [0, y, 0, 0], depth, w];
  const out = new Float32Array(16);
  lines.forEach((line, i) => {
    for (let j = 0; j < 3; j++) out[4 * j + i] = line[0] * r[j] + line[1] * r[3 + j] + line[2] * r[6 + j];
    out[12 + i] = line[0] * at[0] + line[1] * at[1] + line[2] * at[2] + line[3];
  });
  return out;
}
