// The data of the page: unpacked arrays, places in metres, an index of strips by place.
const UNKNOWN = -2147483648;
const CELL = 200; // m, of the index
const $ = (id) => document.getElementById(id);

/** Make an element; children are nodes or texts, which are never read as markup. */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key === "class") node.className = value;
    else node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

/** Write a number with some digits after the point, thousands separated. */
function fix(value, digits = 0) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return value.toLocaleString("en-US", { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

async function inflated(id) {
  const text = atob($(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function unpacked(contents, bytes) {
  const arrays = {};
  let at = 0;
  for (const [name, count] of contents) {
    const out = new Int32Array(count);
    const b0 = at, b1 = at + count, b2 = b1 + count, b3 = b2 + count;
    let value = 0;
    for (let k = 0; k < count; k++) {
      value = (value + (bytes[b0 + k] | (bytes[b1 + k] << 8) | (bytes[b2 + k] << 16) | (bytes[b3 + k] << 24))) | 0;
      out[k] = value;
    }
    arrays[name] = out;
    at += 4 * count;
  }
  return arrays;
}

function scaled(whole, step) {
  const out = new Float64Array(whole.length);
  for (let k = 0; k < whole.length; k++) out[k] = whole[k] === UNKNOWN ? NaN : whole[k] * step;
  return out;
}

/** Read all data of the page. */
async function readData() {
  const info = JSON.parse(new TextDecoder().decode(await inflated("info-data")));
  const raw = unpacked(info.contents, await inflated("array-data"));
  const data = {
    info,
    stripRoad: raw.strip_road,
    stripClass: raw.strip_class,
    stationStart: raw.station_start,
    laneStart: raw.lane_start,
    s: scaled(raw.s, 0.01), x: scaled(raw.x, 0.01), y: scaled(raw.y, 0.01), z: scaled(raw.z, 0.01),
    heading: scaled(raw.heading, 1e-5), roll: scaled(raw.roll, 1e-5), grade: scaled(raw.grade, 1e-4),
    ground: scaled(raw.ground, 0.01),
    t: scaled(raw.border, 0.01),
    laneId: raw.lane_id, laneType: raw.lane_type, laneSpeed: scaled(raw.lane_speed, 0.1),
    lanePredecessor: raw.lane_predecessor, laneSuccessor: raw.lane_successor,
    mark: raw.mark,
    roadLength: scaled(raw.road_length, 0.01), roadJunction: raw.road_junction,
    laneTraffic: raw.lane_traffic, stepStart: raw.step_start, stepEnd: raw.step_end,
    objectRoad: raw.object_road, objectX: scaled(raw.object_x, 0.01), objectY: scaled(raw.object_y, 0.01), objectZ: scaled(raw.object_z, 0.01),
    formObject: raw.form_object, formKind: raw.form_kind, formColour: raw.form_colour, formSize: scaled(raw.form_size, 0.01),
    formLeast: scaled(raw.form_least, 0.1), formStart: raw.form_start, formX: scaled(raw.form_x, 0.01), formY: scaled(raw.form_y, 0.01),
    linkKind: raw.link_kind, link: raw.link, contact: raw.contact,
    bodyX: scaled(raw.body_x || [], 0.01), bodyY: scaled(raw.body_y || [], 0.01), bodyZ: scaled(raw.body_z || [], 0.01), bodyFace: raw.body_face || new Int32Array(0),
    terrain: raw.terrain ? scaled(raw.terrain, 0.1) : null,
  };
  place(data);
  placeForms(data);
  data.grid = gridOf(data);
  data.namesTunnels = Object.values(info.structures).some((items) => items.some(([kind]) => kind === "tunnel"));
  return data;
}

/** Compute where borders lie, and the extent of each road and strip. */
function place(data) {
  const strips = data.stripRoad.length, roads = data.info.road.id.length;
  data.borderStart = new Int32Array(strips + 1);
  for (let k = 0; k < strips; k++) {
    const stations = data.stationStart[k + 1] - data.stationStart[k];
    const borders = data.laneStart[k + 1] - data.laneStart[k] + 1;
    data.borderStart[k + 1] = data.borderStart[k] + stations * borders;
  }
  data.markStart = Int32Array.from(data.laneStart, (first, k) => first + k);
  data.bx = new Float32Array(data.t.length);
  data.by = new Float32Array(data.t.length);
  data.bz = new Float32Array(data.t.length);
  data.stripBox = new Float32Array(4 * strips);
  data.stripHeight = new Float32Array(strips);
  data.roadStrip = new Int32Array(roads + 1);
  data.roadBox = new Float32Array(4 * roads).fill(NaN);
  for (let k = 0; k < strips; k++) {
    data.roadStrip[data.stripRoad[k] + 1] = k + 1;
    const first = data.stationStart[k], last = data.stationStart[k + 1];
    const borders = data.laneStart[k + 1] - data.laneStart[k] + 1;
    let at = data.borderStart[k];
    let west = Infinity, east = -Infinity, south = Infinity, north = -Infinity, height = 0;
    for (let i = first; i < last; i++) {
      const sin = Math.sin(data.heading[i]), cos = Math.cos(data.heading[i]);
      const up = Math.sin(data.roll[i]), flat = Math.cos(data.roll[i]);
      height += data.z[i] || 0;
      for (let j = 0; j < borders; j++, at++) {
        const t = data.t[at] * flat;
        const x = data.x[i] - t * sin, y = data.y[i] + t * cos;
        data.bx[at] = x; data.by[at] = y; data.bz[at] = (data.z[i] || 0) + data.t[at] * up;
        if (x < west) west = x; if (x > east) east = x;
        if (y < south) south = y; if (y > north) north = y;
      }
    }
    data.stripBox.set([west, south, east, north], 4 * k);
    data.stripHeight[k] = height / Math.max(1, last - first);
    widen(data.roadBox, 4 * data.stripRoad[k], west, south, east, north);
  }
  for (let r = 0; r < roads; r++) data.roadStrip[r + 1] = Math.max(data.roadStrip[r + 1], data.roadStrip[r]);
  // Strips from the lowest to the highest: bridges are drawn over what they cross.
  data.rank = new Int32Array(strips);
  const order = Array.from({ length: strips }, (_, k) => k).sort((a, b) => data.stripHeight[a] - data.stripHeight[b] || a - b);
  order.forEach((strip, k) => { data.rank[strip] = k; });
}

/** Index the forms of each object, and the extent of each object. */
function placeForms(data) {
  const objects = data.objectX.length;
  data.objectForm = new Int32Array(objects + 1);
  data.objectBox = new Float32Array(4 * objects).fill(NaN);
  for (let form = 0; form < data.formObject.length; form++) {
    const k = data.formObject[form], reach = data.formSize[form] || 0;
    data.objectForm[k + 1] = form + 1;
    for (let i = data.formStart[form]; i < data.formStart[form + 1]; i++) {
      widen(data.objectBox, 4 * k, data.formX[i] - reach, data.formY[i] - reach, data.formX[i] + reach, data.formY[i] + reach);
    }
  }
  for (let k = 0; k < objects; k++) data.objectForm[k + 1] = Math.max(data.objectForm[k + 1], data.objectForm[k]);
}

function widen(box, at, west, south, east, north) {
  box[at] = Number.isNaN(box[at]) ? west : Math.min(box[at], west);
  box[at + 1] = Number.isNaN(box[at + 1]) ? south : Math.min(box[at + 1], south);
  box[at + 2] = Number.isNaN(box[at + 2]) ? east : Math.max(box[at + 2], east);
  box[at + 3] = Number.isNaN(box[at + 3]) ? north : Math.max(box[at + 3], north);
}

/** List strips by the cells of a grid that they extend into. */
function gridOf(data) {
  const cells = new Map();
  for (let k = 0; k < data.stripRoad.length; k++) {
    const [west, south, east, north] = data.stripBox.subarray(4 * k, 4 * k + 4);
    if (!Number.isFinite(west)) continue;
    // A long strip extends only into the cells around its stations.
    const seen = new Set();
    if ((east - west) * (north - south) < 9 * CELL * CELL) {
      for (let i = Math.floor(west / CELL); i <= Math.floor(east / CELL); i++) {
        for (let j = Math.floor(south / CELL); j <= Math.floor(north / CELL); j++) seen.add(i + ":" + j);
      }
    } else {
      alongStrip(data, k, CELL / 4, (x, y) => {
        for (const dx of [-40, 40]) for (const dy of [-40, 40]) {
          seen.add(Math.floor((x + dx) / CELL) + ":" + Math.floor((y + dy) / CELL));
        }
      });
    }
    for (const key of seen) {
      if (!cells.has(key)) cells.set(key, []);
      cells.get(key).push(k);
    }
  }
  return cells;
}

function alongStrip(data, strip, step, visit) {
  for (let i = data.stationStart[strip]; i + 1 < data.stationStart[strip + 1]; i++) {
    const dx = data.x[i + 1] - data.x[i], dy = data.y[i + 1] - data.y[i];
    const pieces = Math.max(1, Math.ceil(Math.hypot(dx, dy) / step));
    for (let k = 0; k <= pieces; k++) visit(data.x[i] + (dx * k) / pieces, data.y[i] + (dy * k) / pieces);
  }
}

/** Return the strips near a box, the lowest first. */
function stripsIn(data, west, south, east, north) {
  const found = new Set();
  const columns = (east - west) / CELL, rows = (north - south) / CELL;
  if (columns * rows > 4 * data.grid.size) {
    for (let k = 0; k < data.stripRoad.length; k++) found.add(k);
  } else {
    for (let i = Math.floor(west / CELL); i <= Math.floor(east / CELL); i++) {
      for (let j = Math.floor(south / CELL); j <= Math.floor(north / CELL); j++) {
        for (const strip of data.grid.get(i + ":" + j) || []) found.add(strip);
      }
    }
  }
  const box = data.stripBox;
  return Array.from(found)
    .filter((k) => box[4 * k] <= east && box[4 * k + 2] >= west && box[4 * k + 1] <= north && box[4 * k + 3] >= south)
    .sort((a, b) => data.rank[a] - data.rank[b]);
}

/** Return the strip at or nearest to a place: strip, station, share to the next station, t, distance; only of those that count. */
function nearest(data, x, y, reach, counts = () => true) {
  let best = null;
  for (const strip of stripsIn(data, x - reach, y - reach, x + reach, y + reach)) {
    if (!counts(strip)) continue;
    const found = nearestOn(data, strip, x, y);
    if (found && found.distance <= reach && (!best || found.distance <= best.distance + 1e-6)) best = found;
  }
  return best;
}

function nearestOn(data, strip, x, y) {
  const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
  let best = null;
  for (let i = data.stationStart[strip]; i + 1 < data.stationStart[strip + 1]; i++) {
    const dx = data.x[i + 1] - data.x[i], dy = data.y[i + 1] - data.y[i];
    const square = dx * dx + dy * dy;
    if (!(square > 0)) continue;
    const share = Math.min(1, Math.max(0, ((x - data.x[i]) * dx + (y - data.y[i]) * dy) / square));
    const px = x - data.x[i] - share * dx, py = y - data.y[i] - share * dy;
    const length = Math.sqrt(square);
    const t = (dx * py - dy * px) / length;
    const along = Math.abs(dx * px + dy * py) / length;
    const row = data.borderStart[strip] + (i - data.stationStart[strip]) * borders;
    const left = data.t[row] + share * (data.t[row + borders] - data.t[row]);
    const right = data.t[row + borders - 1] + share * (data.t[row + 2 * borders - 1] - data.t[row + borders - 1]);
    const beside = Math.max(0, t - left, right - t);
    const distance = Math.hypot(beside, along);
    if (!best || distance < best.distance) best = { strip, station: i, share, t, distance, road: data.stripRoad[strip] };
  }
  return best;
}

/** Return the left (0) or right (1) edge of a piece of a road as places x, y, z. */
function edgeOf(data, { road, from, to }, side) {
  const line = [], low = Math.min(from, to), high = Math.max(from, to);
  for (let strip = data.roadStrip[road]; strip < data.roadStrip[road + 1]; strip++) {
    const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1, first = data.stationStart[strip], last = data.stationStart[strip + 1] - 1;
    for (let i = first; i <= last; i++) {
      const k = data.borderStart[strip] + (i - first) * borders + side * (borders - 1), next = i < last ? data.s[i + 1] - data.s[i] : 0;
      const put = (share) => line.push([data.bx, data.by, data.bz].map((array) => array[k] + (share ? share * (array[k + borders] - array[k]) : 0)));
      if (next > 0 && data.s[i] < low && data.s[i + 1] > low) put((low - data.s[i]) / next);
      if (data.s[i] >= low && data.s[i] <= high) put(0);
      if (next > 0 && data.s[i] < high && data.s[i + 1] > high) put((high - data.s[i]) / next);
    }
  }
  return line.filter((place) => place.every(Number.isFinite));
}

/** Interpolate a value between two stations. */
function between(values, found) {
  const a = values[found.station], b = values[found.station + 1];
  return a + (b - a) * found.share;
}

/** Return longitude and latitude (degrees) of local metres, or null where these are unknown. */
function geographic(info, x, y) {
  const fit = info.geographic;
  if (!fit) return null;
  const u = (x - fit.x) / fit.scale, v = (y - fit.y) / fit.scale;
  let lon = 0, lat = 0, k = 0;
  for (let i = 0; i <= fit.order; i++) {
    for (let j = 0; i + j <= fit.order; j++, k++) {
      const term = u ** i * v ** j;
      lon += fit.lon[k] * term; lat += fit.lat[k] * term;
    }
  }
  return [lon, lat];
}
