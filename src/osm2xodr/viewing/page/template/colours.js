// Colours of strips: by category or by a ramp, as of the page's data.
const BINS = 48;

function rgbOf(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

/** Return the colours of a ramp in a number of steps. */
function rampSteps(stops) {
  const table = stops.map(rgbOf);
  return Array.from({ length: BINS }, (_, k) => {
    const at = (k / (BINS - 1)) * (table.length - 1), low = Math.min(Math.floor(at), table.length - 2);
    const mixed = table[low].map((value, c) => Math.round(value + (table[low + 1][c] - value) * (at - low)));
    return `rgb(${mixed.join(",")})`;
  });
}

/**
 * Say how a mode colours. `lane(strip, lane)` returns a colour for modes that colour lanes as a whole, `station(i)`
 * for those that colour along the road; the other one is null.
 */
function colouring(data, mode) {
  const unknown = data.info.unknown_colour;
  if (mode.kind === "category") {
    const colours = mode.entries.map((entry) => entry[1]);
    const of = { type: (strip, lane) => data.laneType[lane], class: (strip) => data.stripClass[strip],
      finding: (strip) => data.roadFinding[data.stripRoad[strip]] }[mode.key];
    return { lane: (strip, lane) => colours[of(strip, lane)] || unknown, station: null };
  }
  const steps = rampSteps(mode.stops);
  const colour = (value) => Number.isFinite(value)
    ? steps[Math.max(0, Math.min(BINS - 1, Math.round(((value - mode.low) / (mode.high - mode.low)) * (BINS - 1))))]
    : unknown;
  if (mode.key === "speed") return { lane: (strip, lane) => colour(data.laneSpeed[lane]), station: null };
  const value = stationValue(data, mode.key);
  return { lane: null, station: (i) => colour(value(i)) };
}

/** Return the mode of surfaces as they are built: a legend of the materials of what lies and stands on the ground. */
function builtMode(info) {
  const shown = new Map();
  for (const [layer, material, colour] of info.bodies) {
    if (["roads", "ground", "buildings"].includes(layer) && !material.startsWith("#")) shown.set(material, colour);
  }
  const entries = Array.from(shown, ([material, colour]) => [material, colour, material.replaceAll("_", " "), true]);
  return { key: "built", label: "as built", title: "Surfaces", kind: "category", entries };
}

/** Return the function that gives the value of a mode at a station, in the unit of its legend. */
function stationValue(data, key) {
  if (key === "height") return (i) => data.z[i];
  if (key === "grade") return (i) => 100 * Math.abs(data.grade[i]);
  return (i) => data.z[i] - data.ground[i];
}

/** Fill the legend for a mode; extra entries have a label and a function that draws a symbol of 22 x 20 pixels. */
function showLegend(box, mode, extra) {
  const parts = [el("h2", {}, mode.title)];
  if (mode.kind === "category") {
    parts.push(el("ul", {}, ...mode.entries.filter((entry) => entry[3]).map(([, colour, label]) => {
      const swatch = el("span", { class: "swatch" });
      swatch.style.background = colour;
      return el("li", {}, swatch, label);
    })));
  } else {
    const ramp = el("span", { class: "ramp" });
    ramp.style.background = `linear-gradient(to right, ${mode.stops.join(", ")})`;
    const middle = (mode.low + mode.high) / 2;
    const ticks = [mode.low, middle, mode.high].map((value) => el("span", {}, fix(value, mode.digits)));
    parts.push(ramp, el("div", { class: "ticks" }, ...ticks));
  }
  if (extra.length) {
    parts.push(el("ul", {}, ...extra.map(([label, draw]) => {
      const symbol = el("canvas", { class: "symbol", width: 44, height: 40 }), context = symbol.getContext("2d");
      context.scale(2, 2);
      draw(context);
      return el("li", {}, symbol, label);
    })));
  }
  box.replaceChildren(...parts);
}
