// Which layers are shown, in the map and in 3D.

/** Return the layers of this page: key, label, and whether it is shown at first. */
function layersOf(info) {
  const has = (layer) => info.bodies.some((row) => row[0] === layer);
  return [
    ["roads", "lanes", info.road.id.length],
    ["marks", "lane marks", info.marks.some((lines) => lines.length)],
    ["objects", "objects, paint", info.object_types.length],
    ["signals", "signs, lights", info.signals.length],
    ["junctions", "junctions", info.junctions.id.length],
    ["names", "names", info.road.name.some(Boolean)],
    ["findings", "findings", info.findings.length],
    ["ground", "ground", info.terrain || has("ground")],
    ["structures", "bridges, tunnels (3D)", has("structures")],
    ["buildings", "buildings (3D)", has("buildings")],
  ].filter((row) => row[2]);
}

class Layers {
  /** `changed` is called after each change by the reader; findings are shown at first if that is what colours show. */
  constructor(data, hidden, changed) {
    this.rows = layersOf(data.info);
    this.shown = Object.fromEntries(this.rows.map(([key]) => [key, !hidden.includes(key)]));
    this.boxes = Object.fromEntries(this.rows.map(([key]) => [key, el("input", {
      type: "checkbox", id: `layer-${key}`, checked: this.shown[key],
      onchange: () => { this.shown[key] = this.boxes[key].checked; changed(); },
    })]));
    $("layers-list").replaceChildren(...this.rows.map(([key, label]) => el("label", {}, this.boxes[key], ` ${label}`)));
    $("layers").hidden = !this.rows.length;
  }

  set(key, shown) {
    if (!(key in this.shown)) return;
    this.shown[key] = shown;
    this.boxes[key].checked = shown;
  }

  /** Return the layers that are not shown. */
  hidden() {
    return this.rows.map(([key]) => key).filter((key) => !this.shown[key]);
  }
}
