/* The connection to the server: messages as JSON, heights as bytes. */

export class Link {
  /**
   * @param {(message: object) => void} said  called with each message
   * @param {(bytes: ArrayBuffer) => void} heights  called with each frame
   * @param {(open: boolean) => void} changed  called when the connection opens or closes
   */
  constructor(said, heights, changed) {
    this.said = said;
    this.heights = heights;
    this.changed = changed;
    this.wait = 250;
    this.open();
  }

  open() {
    this.socket = new WebSocket(`ws://${location.host}/live`);
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("open", () => {
      this.wait = 250;
      this.changed(true);
    });
    this.socket.addEventListener("message", (event) => {
      if (typeof event.data === "string") this.said(JSON.parse(event.data));
      else this.heights(event.data);
    });
    this.socket.addEventListener("close", () => {
      this.changed(false);
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, 4000);
    });
  }

  /** Send a request; false if the server is not there. */
  ask(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
