/* Messages of the library on the page: it names an option in backticks, alone or with a value. */

/** `slope_cap=3` and `fit='scale'` as "slope cap 3" and "fit scale". */
export function plain(text) {
  return String(text ?? "").replace(/`([a-z][a-z0-9_]*)(?:=([^`]*))?`/g, (_, name, value) => {
    const words = name.replace(/_$/, "").replaceAll("_", " ");
    if (value === undefined || value === "True") return words;
    return `${words} ${value.replace(/^(['"])(.*)\1$/, "$2")}`;
  });
}

/** A number of bytes, such as "21.8 MB". */
export function bytesText(bytes) {
  return bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.max(1, Math.round(bytes / 1e3))} kB`;
}

/** An element with properties and children. */
export function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}
