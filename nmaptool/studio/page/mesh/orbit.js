/* Turns the camera around a mesh by drag and arrow keys. */

const DEGREES_PER_PX = 0.4;
const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** The angle between -180 and 180 degrees, to a tenth. */
export function wrapped(degrees) {
  const around = ((((degrees + 180) % 360) + 360) % 360) - 180;
  return Math.round(10 * around) / 10 || 0;
}

/** Azimuth and elevation after a drag of the picture by dx, dy px, which `roll` degrees have rotated. */
export function dragged({ azimuth, elevation, roll }, dx, dy) {
  const angle = (roll * Math.PI) / 180;
  const across = dx * Math.cos(angle) - dy * Math.sin(angle);
  const down = dx * Math.sin(angle) + dy * Math.cos(angle);
  return moved(azimuth - DEGREES_PER_PX * across, elevation + DEGREES_PER_PX * down);
}

function moved(azimuth, elevation) {
  return { azimuth: wrapped(azimuth), elevation: Math.round(10 * Math.min(Math.max(elevation, -90), 90)) / 10 };
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {() => {azimuth: number, elevation: number, roll: number}} now
 * @param {(direction: {azimuth: number, elevation: number}, moving: boolean) => void} turned
 */
export function setUpOrbit(canvas, now, turned) {
  let from = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    from = { x: event.clientX, y: event.clientY, at: now() };
  });
  const move = (event, moving) => {
    if (!from) return;
    const [dx, dy] = [event.clientX - from.x, event.clientY - from.y];
    if (dx || dy) turned(dragged(from.at, dx, dy), moving);
  };
  canvas.addEventListener("pointermove", (event) => move(event, true));
  canvas.addEventListener("pointerup", (event) => {
    move(event, false);
    from = null;
  });
  canvas.addEventListener("pointercancel", () => {
    from = null;
  });
  canvas.addEventListener("keydown", (event) => {
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    const by = event.shiftKey ? 1 : 5;
    const { azimuth, elevation } = now();
    turned(moved(azimuth + by * step[0], elevation + by * step[1]), false);
  });
}
