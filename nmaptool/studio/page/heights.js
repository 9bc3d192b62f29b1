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
  return { ...header, ...fields, surface: new Uint8Array(bytes, at, count) };
}

/** Millimetres of a length such as "3mm", "2cm" or "0.1in"; NaN if it is relative or not a length. */
export function millimetres(text) {
  const found = /^\s*([-+.\de]+)\s*(mm|cm|m|in)\s*$/i.exec(String(text ?? ""));
  const unit = { mm: 1, cm: 10, m: 1000, in: 25.4 };
  return found ? Number(found[1]) * unit[found[2].toLowerCase()] : NaN;
}

/**
 * Heights in px for a document's options.
 *
 * @param {object} frame  as `decode` returns it
 * @param {object} values  the options: delta, height, width, fit
 * @returns {{z: Float32Array, low: number, high: number, pitch: number, scale: number}}  z in px; low and high in mm
 */
export function combined(frame, values) {
  const { first, second, base, surface, rows, cols } = frame;
  const count = rows * cols;
  const delta = values.delta * frame.px_per_delta;
  const width = millimetres(values.width);
  const pitch = Number.isFinite(width) ? width / (cols - 1) : frame.pitch_mm;
  const z = new Float32Array(count);
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < count; i++) {
    const height = first[i] + delta * second[i];
    z[i] = height;
    if (surface[i]) {
      if (height < low) low = height;
      if (height > high) high = height;
    }
  }
  const wanted = millimetres(values.height);
  const scale = Number.isFinite(wanted) && high > low ? wanted / pitch / (high - low) : 1;
  if (scale !== 1) for (let i = 0; i < count; i++) z[i] *= scale;
  if (base) for (let i = 0; i < count; i++) z[i] += base[i];
  return { z, low: low * scale * pitch, high: high * scale * pitch, pitch, scale };
}
