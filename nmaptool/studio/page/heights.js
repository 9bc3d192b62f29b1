/* Heights of a relief from the server's frames: z = base + s (h0 + delta h1). */

/** Read a frame; see nmaptool.studio.frames. */
export function decode(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const count = header.rows * header.cols;
  let at = 4 + length;
  const fields = {};
  for (const { name, low, high } of header.fields) {
    const numbers = new Uint16Array(bytes, at, count);
    const step = (high > low ? high - low : 1) / 65535;
    const values = new Float32Array(count);
    for (let i = 0; i < count; i++) values[i] = low + numbers[i] * step;
    fields[name] = values;
    at += 2 * count;
  }
  return { ...header, ...fields, surface: bits(new Uint8Array(bytes, at), count) };
}

let last = { packed: new Uint8Array(0), mask: new Uint8Array(0) };

/** A mask of 0 and 1 from bits, the highest of a byte first; the same array as long as the mask is the same. */
function bits(packed, count) {
  if (last.mask.length === count && packed.every((byte, i) => byte === last.packed[i])) return last.mask;
  const mask = new Uint8Array(count);
  for (let i = 0; i < count; i++) mask[i] = (packed[i >> 3] >> (7 - (i & 7))) & 1;
  last = { packed, mask };
  return mask;
}

/** Millimetres of a length such as "3mm", "2cm" or "0.1in"; NaN if it is relative or not a length. */
export function millimetres(text) {
  const found = /^\s*([-+.\de]+)\s*(mm|cm|m|inch|in|"|\u2033)\s*$/i.exec(String(text ?? ""));
  const unit = { mm: 1, cm: 10, m: 1000, in: 25.4, inch: 25.4, '"': 25.4, "\u2033": 25.4 };
  return found ? Number(found[1]) * unit[found[2].toLowerCase()] : NaN;
}

/** Millimetres of a length, also of one in px or in % of the longer side of the picture; NaN if it is not a length. */
export function inMillimetres(text, frame) {
  const found = /^\s*([-+.\de]+)\s*(px|%)\s*$/i.exec(String(text ?? ""));
  if (!found || !frame) return millimetres(text);
  const longer = Math.max(frame.rows, frame.cols) - 1;
  const size = longer * pitchOf(frame, {});
  return Number(found[1]) * (found[2] === "%" ? size / 100 : size / Math.max(...(frame.full ?? [longer])));
}

/** The size of a pixel of a frame in mm. */
export function pitchOf(frame, values) {
  const width = millimetres(values.width);
  return Number.isFinite(width) ? width / (frame.cols - 1) : frame.pitch_mm;
}

/** The weight of the slopes; see nmaptool.reliefs.targets.Weights. */
function stiffness(values, hasDetail) {
  return hasDetail && values.energy === "eq6" ? 1 + values.mu : 1;
}

/** Millimetres of the largest forms that beta keeps, without a map of beta; infinite for beta 0. */
export function reachOf(frame, values, hasDetail) {
  return Math.sqrt(stiffness(values, hasDetail) / values.beta) * frame.px_per_delta * pitchOf(frame, values);
}

/** The beta that keeps forms up to so many millimetres; NaN if there is none. */
export function betaFor(mm, frame, values, hasDetail) {
  if (!(mm > 0)) return NaN;
  return stiffness(values, hasDetail) / (mm / (frame.px_per_delta * pitchOf(frame, values))) ** 2;
}

/** Lowest and highest value of a h0 + b h1 on the surface. */
function rangeOf({ first, second, surface }, a, b) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < first.length; i++) {
    if (!surface[i]) continue;
    const height = a * first[i] + b * second[i];
    if (height < low) low = height;
    if (height > high) high = height;
  }
  return [low, high];
}

/** The factor, zero or more, at which `span` reaches what is wanted; 1 if none does. */
function factorFor(span, wanted) {
  let top = 1;
  while (span(top) < wanted && top < 1e6) top *= 2;
  if (span(top) < wanted || span(0) > wanted) return 1;
  let bottom = 0;
  for (let i = 0; i < 40; i++) {
    const middle = (bottom + top) / 2;
    if (span(middle) < wanted) bottom = middle;
    else top = middle;
  }
  return top;
}

/** Factors on h0 and h1, and on both, that give the wanted range in px; see ReliefOptions.fit. */
function factors(frame, delta, wanted, fit) {
  const span = (a, b) => {
    const [low, high] = rangeOf(frame, a, b);
    return high - low;
  };
  if (!Number.isFinite(wanted)) return [1, delta, 1];
  if (fit === "slope") return [factorFor((f) => span(f, delta), wanted), delta, 1];
  if (fit === "delta") {
    const side = delta < 0 ? -1 : 1;
    return [1, side * factorFor((f) => span(1, side * f), wanted), 1];
  }
  const found = span(1, delta);
  return [1, delta, found > 0 ? wanted / found : 1];
}

/**
 * Heights for a document's options.
 *
 * @param {object} frame  as `decode` returns it
 * @param {object} values  the options: delta, height, width, fit
 * @returns {{z: Float32Array, span: number, low: number, high: number, pitch: number}}  z in px; the range above the
 *   background, and the lowest and highest point, in mm
 */
export function combined(frame, values) {
  const { first, second, base, surface, rows, cols } = frame;
  const pitch = pitchOf(frame, values);
  const wanted = inMillimetres(values.height, { ...frame, pitch_mm: pitch }) / pitch;
  const [a, b, scale] = factors(frame, values.delta * frame.px_per_delta, wanted, values.fit);
  const z = new Float32Array(rows * cols);
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < z.length; i++) {
    z[i] = scale * (a * first[i] + b * second[i]) + (base ? base[i] : 0);
    if (!surface[i]) continue;
    if (z[i] < low) low = z[i];
    if (z[i] > high) high = z[i];
  }
  const [bottom, top] = rangeOf(frame, a, b);
  return { z, span: scale * (top - bottom) * pitch, low: low * pitch, high: high * pitch, pitch };
}
