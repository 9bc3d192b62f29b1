/* The pointer on the canvas: pan, zoom, orbit, two fingers; or a tool that has claimed it. */

const MIDDLE = 1;

/**
 * Who gets the pointer. A tool is an object with some of the methods `down`, `move`, `up` and `cancel`, each called with
 * the event and the place in document coordinates (null beside the plate in the orbit view); `move` is called while
 * the pointer hovers, too. `cursor` is the CSS cursor.
 */
export class Pointer {
  constructor(view) {
    this.view = view;
    this.canvas = view.canvas;
    this.tool = null;
    this.places = new Map(); // of the fingers and the mouse button that move the view, by pointer
    this.held = new Set(); // pointers that the tool has
    this.hasSpace = false;
    const handlers = { pointerdown: "down", pointermove: "move", pointerup: "up", pointercancel: "cancel" };
    for (const [event, method] of Object.entries(handlers))
      this.canvas.addEventListener(event, (given) => this[method](given));
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    window.addEventListener("keydown", (event) => this.space(event, true));
    window.addEventListener("keyup", (event) => this.space(event, false));
    window.addEventListener("blur", () => this.space({ code: "Space" }, false));
  }

  /** Give a tool the events of the canvas; returns a function that ends this. A second tool replaces the first. */
  claim(tool) {
    this.tool = tool;
    this.showCursor();
    return () => {
      if (this.tool !== tool) return;
      this.tool = null;
      this.held.clear();
      this.showCursor();
    };
  }

  showCursor() {
    const moves = !this.tool || this.hasSpace;
    this.canvas.style.cursor = moves ? "grab" : (this.tool.cursor ?? "crosshair");
  }

  space(event, isDown) {
    if (event.code !== "Space" || !this.tool) return;
    const typing = isDown && /^(INPUT|SELECT|TEXTAREA|BUTTON)$/.test(document.activeElement?.tagName ?? "");
    if (typing) return;
    if (isDown) event.preventDefault(); // the page does not scroll
    this.hasSpace = isDown;
    this.showCursor();
  }

  down(event) {
    if (!this.view.relief) return;
    this.canvas.setPointerCapture(event.pointerId);
    const forTool = this.tool && !this.hasSpace && event.button !== MIDDLE && this.places.size === 0;
    if (event.button === MIDDLE) event.preventDefault(); // no automatic scrolling
    if (forTool && event.pointerType === "touch" && this.held.size > 0) {
      // a second finger: the view moves, the stroke of the first ends
      for (const pointer of this.held) this.places.set(pointer, this.first);
      this.held.clear();
      this.tool.cancel?.(event, this.view.toGrid(event));
    } else if (forTool && event.button === 0) {
      this.held.add(event.pointerId);
      this.first = at(event);
      this.tool.down?.(event, this.view.toGrid(event));
      return;
    } else if (forTool) return;
    this.places.set(event.pointerId, at(event));
  }

  move(event) {
    if (!this.view.relief) return;
    const before = this.places.get(event.pointerId);
    if (!before) {
      if (this.tool && (this.held.has(event.pointerId) || this.held.size === 0))
        this.tool.move?.(event, this.view.toGrid(event));
      return;
    }
    const now = at(event);
    const others = [...this.places].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.places.set(event.pointerId, now);
    if (others.length) this.pinch(before, now, others[0]);
    else this.drag(event, now.x - before.x, now.y - before.y);
  }

  drag(event, dx, dy) {
    const pans = !this.view.camera.orbits || event.shiftKey || event.buttons === 4 || this.tool;
    if (pans) this.view.pan(dx, dy);
    else this.view.orbit(0.4 * dx, -0.4 * dy);
  }

  /** One of two fingers moved: what is under the fingers stays there. */
  pinch(before, now, other) {
    const box = this.canvas.getBoundingClientRect();
    const middle = { x: (now.x + other.x) / 2 - box.left, y: (now.y + other.y) / 2 - box.top };
    const apart = (place) => Math.max(Math.hypot(place.x - other.x, place.y - other.y), 8);
    this.view.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
    this.view.zoomAt(middle.x, middle.y, apart(now) / apart(before));
  }

  up(event) {
    this.places.delete(event.pointerId);
    if (this.held.delete(event.pointerId)) this.tool?.up?.(event, this.view.toGrid(event));
  }

  cancel(event) {
    this.places.delete(event.pointerId);
    if (this.held.delete(event.pointerId)) this.tool?.cancel?.(event, this.view.toGrid(event));
  }

  wheel(event) {
    event.preventDefault();
    if (!this.view.relief) return;
    const box = this.canvas.getBoundingClientRect();
    const lines = event.deltaMode === 1 ? 16 : 1; // px per line of the wheel
    this.view.zoomAt(event.clientX - box.left, event.clientY - box.top, 1.0015 ** (-event.deltaY * lines));
  }
}

function at(event) {
  return { x: event.clientX, y: event.clientY };
}
