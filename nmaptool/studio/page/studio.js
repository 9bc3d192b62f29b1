/* What the parts of the page share: the document as the server last told it, the heights, and the connection. */

import { decode } from "./heights.js";
import { Link } from "./link.js";

// the page computes these from the two parts of the heights; the server only stores them
const LOCAL = new Set(["delta", "height", "width", "fit"]);
// a change that needs no solve brings no heights
const PATIENCE_MS = 250;
// one is solved while the heights of the other are drawn; more would only queue up
const MOST_OPEN = 1;

export const $ = (id) => document.getElementById(id);

export class Studio {
  constructor() {
    this.document = null; // the last message "state"
    this.values = null; // its options; while a control moves, ahead of the server
    this.frame = null; // the last heights
    this.fault = null; // why there were no heights
    this.listeners = new Map();
    this.asked = null; // a change that waits to be sent
    this.isPaced = false;
  }

  /**
   * Call `listener` with each message of a kind: those of the server, "heights" with a frame, "render" when the heights
   * must be computed again, and "connected" with whether the server is there.
   */
  on(kind, listener) {
    this.listeners.set(kind, [...(this.listeners.get(kind) ?? []), listener]);
  }

  emit(kind, value) {
    for (const listener of this.listeners.get(kind) ?? []) listener(value);
  }

  /** Connect to the server, once the parts listen. */
  connect() {
    this.link = new Link(
      (message) => this.hear(message),
      (bytes) => this.see(decode(bytes)),
      (open) => this.emit("connected", open),
    );
  }

  hear(message) {
    if (message.kind === "state") {
      this.document = message;
      this.values = message.values;
    } else if (message.kind === "error" && message.names) {
      this.values = this.document.values;
      this.emit("refused", message);
      if (this.frame) this.emit("render");
      return;
    } else if (message.kind === "error") {
      this.fault = message.request === undefined ? null : message.text;
      this.say(message.text);
    }
    this.emit(message.kind, message);
    if (message.kind === "state" && this.frame) this.emit("render");
  }

  see(frame) {
    this.frame = frame;
    if ($("error").textContent === this.fault) this.say(""); // heights say nothing of a file that was refused
    this.answered();
    this.emit("heights", frame);
    this.emit("render");
  }

  /** Send a request; says so if the server is not there. */
  ask(message) {
    this.send(); // what was changed before
    const sent = this.link.ask(message);
    if (!sent) this.say("the studio does not answer; start nmap studio again");
    return sent;
  }

  /** Set an option; null is its default. While it moves, requests wait until the heights of earlier ones are shown. */
  change(name, value, moving) {
    this.say("");
    this.values = { ...this.values, [name]: value };
    if (LOCAL.has(name) && this.values.edge === "blend") {
      if (this.frame && value !== null) this.emit("render");
      if (moving) return;
    }
    if (this.asked && !(name in this.asked.values)) this.send();
    this.asked = { do: "set", values: { [name]: value }, moving };
    if (!moving || this.open < MOST_OPEN) this.send();
  }

  /** Send what was asked; while it moves, what is asked next waits for heights, but not for ever. */
  send() {
    const asked = this.asked;
    this.asked = null;
    if (!asked) return;
    clearTimeout(this.patience);
    this.open = asked.moving ? this.open + 1 : 0;
    if (asked.moving) this.patience = setTimeout(() => this.answered(MOST_OPEN), PATIENCE_MS);
    this.ask(asked);
  }

  /** Heights have come: the next change may be sent. */
  answered(count = 1) {
    this.open = Math.max(0, this.open - count);
    this.send();
  }

  /** Show an error, in the words of the command line; "" clears it. */
  say(text) {
    write("error", text);
  }

  /** Show what is going on. */
  tell(text) {
    write("status", text);
  }
}

/** Show a text; the page is laid out again only if it is another one. */
function write(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}
