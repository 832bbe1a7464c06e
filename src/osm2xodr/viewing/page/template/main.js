// Connects the parts: the address, the selection, the views.

async function start() {
  const data = await readData(), info = data.info;
  index(data);
  $("title").textContent = info.title;
  $("subtitle").textContent = info.subtitle;
  $("credits").textContent = info.credits;
  $("credits").title = info.credits;
  // What roads look like in 3D unless a colour is chosen.
  const built = info.bodies.length ? builtMode(info) : null;
  const state = { road: -1, signal: -1, pieces: [], route: null, ends: [], picking: false, mode: info.modes[0], view: "2d", scene: null };
  const actions = {
    openRoad: (road, s, move) => openRoad(road, s, move),
    openFinding: (k) => openFinding(k),
    openJunction: (junction) => openJunction(junction),
    openSignal: (signal, move) => openSignal(signal, move),
    routeClick: (x, y, shift) => routeClick(x, y, shift),
    close: () => openRoad(-1),
    go: (x, y) => { show2d(); map.go(x, y); },
    mark: (x, y) => map.mark(x, y),
    hover: (x, y) => hover(x, y),
  };
  const panel = new Panel(data, actions), profile = new Profile(data, actions), map = new RoadMap(data, actions);

  const wish = new URLSearchParams(location.hash.slice(1)), off = wish.get("off");
  // Findings are shown at first if they are what roads are coloured by.
  const layers = new Layers(data, off === null ? (wish.get("mode") === "finding" ? [] : ["findings"]) : off.split(","), () => recolour());

  const hills = new Map();
  function hill(dark) {
    if (!hills.has(dark)) hills.set(dark, hillOf(data, dark));
    return hills.get(dark);
  }

  /** Return the mode of the view that is seen. */
  function modeSeen() {
    return state.view === "3d" ? state.mode3d : state.mode;
  }

  function look(mode) {
    const css = getComputedStyle(document.documentElement), of = (name) => css.getPropertyValue(name).trim();
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    return {
      colour: mode === built ? null : colouring(data, mode), built: mode === built, dark, hill: hill(dark),
      ink: of("--ink"), halo: of("--halo"), soft: of("--soft"), ground: of("--ground"), edge: dark ? "#8b98a5" : "#3d4853",
      layers: layers.shown,
    };
  }

  function recolour() {
    state.look = look(state.mode);
    map.show(state.look);
    if (state.scene) state.scene.show(look(state.mode3d));
    legend();
    remember();
  }

  function legend() {
    showLegend($("legend"), modeSeen(), state.view === "3d" && modeSeen() === built ? [] : symbols());
  }

  /** Return what the legend explains besides colours. */
  function symbols() {
    const out = [], shown = layers.shown, used = info.signals.find((signal) => signal[7]), sign = info.signals.find((signal) => !signal[7]);
    const face = (signal) => (context) => drawSymbol(context, info.faces[signal[8]], 11, 10, 9, -1);
    if (shown.junctions) out.push(["junction", (context) => { context.beginPath(); context.arc(11, 10, 4, 0, 7); context.fillStyle = state.look.halo; context.fill(); context.strokeStyle = state.look.ink; context.lineWidth = 1.4; context.stroke(); }]);
    if (shown.signals && used) out.push(["traffic light", face(used)]);
    if (shown.signals && sign) out.push(["sign", face(sign)]);
    for (const [severity, colour] of Object.entries(info.severities)) {
      if (shown.findings && info.findings.some((finding) => finding[0] === severity)) out.push([severity, (context) => drawPin(context, 11, 19, 1, colour, -1)]);
    }
    return out;
  }

  /** Show a path, or nothing, and what was selected with it. */
  function select(pieces, title, { road = -1, junction = -1, signal = -1, route = null, move = false }) {
    Object.assign(state, { road, signal, pieces, route });
    if (!route) state.ends = [];
    Object.assign(panel, { road, junction, signal, route });
    profile.show(pieces, title, route !== null);
    map.map.invalidateSize({ pan: false });
    map.select(pieces, move);
    map.markEnds(state.ends);
    const fellows = fellowsOf(info, signal);
    map.highlight(fellows);
    if (state.scene) { state.scene.select(pieces); state.scene.highlight(fellows); }
    const any = road >= 0 || junction >= 0 || signal >= 0 || route;
    panel.open(any ? "road" : panel.tab === "road" ? "overview" : panel.tab);
    remember();
  }

  function openRoad(road, s, move) {
    const name = road >= 0 && info.road.name[road];
    select(road >= 0 ? wholeRoad(data, road) : [], road >= 0 ? `Road ${info.road.id[road]}${name ? ` · ${name}` : ""}` : "", { road, move });
    if (road >= 0 && s !== undefined && s !== null) { profile.point(road, s); if (move) { const at = placeAt(data, road, s); if (at) map.mark(...at); } }
    if (state.scene && move && road >= 0) lookAt(road);
  }

  function openSignal(signal, move) {
    select([], "", { signal });
    const [, x, y] = info.signals[signal];
    if (move && state.view === "3d") state.scene.look(x, y, 60);
    else if (move) { map.go(x, y); map.mark(NaN, NaN); }
  }

  /** Take a place of a route, if one is being chosen; return whether it was. */
  function routeClick(x, y, shift) {
    if (!state.picking && !shift) return false;
    const found = nearest(data, x, y, Math.max(3, 12 * map.pixel()), (strip) => graph().nodesOf(strip, 0).length + graph().nodesOf(strip, 1).length > 0);
    if (!found) { hint("No car drives there."); return true; }
    const end = { strip: found.strip, s: between(data.s, found), x, y };
    if (state.ends.length !== 1) {
      select([], "", {});
      state.ends = [end];
      map.markEnds([[x, y]]);
      pick(true);
      return true;
    }
    const begin = state.ends[0], pieces = graph().route(begin, end);
    state.ends = [[begin.x, begin.y], [x, y]];
    pick(false);
    if (pieces) {
      const name = ({ road }) => info.road.name[road] || `road ${info.road.id[road]}`;
      select(pieces, `Route · ${name(pieces[0])} – ${name(pieces[pieces.length - 1])}`, { route: pieces });
    } else {
      map.markEnds(state.ends);
      hint("No lane leads from A to B in the direction of traffic.");
    }
    return true;
  }

  function graph() {
    state.graph ??= new LaneGraph(data);
    return state.graph;
  }

  function pick(on) {
    state.picking = on;
    $("route").setAttribute("aria-pressed", String(on));
    hint(!on ? "" : state.ends.length === 1 ? "Click where the route ends." : "Click where the route begins.");
  }

  function hint(text) {
    $("hint").textContent = text;
    $("hint").hidden = !text;
  }

  function openJunction(junction) {
    select([], "", { junction });
    if (info.junctions.x[junction] !== null) { show2d(); map.go(info.junctions.x[junction], info.junctions.y[junction]); }
  }

  function openFinding(k) {
    const [, , road, , s, x, y] = info.findings[k];
    if (road >= 0) openRoad(road, s, false);
    if (x !== null) { show2d(); map.go(x, y); }
  }

  function hover(x, y) {
    if (!Number.isFinite(x)) { $("place").textContent = ""; return; }
    const found = nearest(data, x, y, 6 * map.pixel());
    const parts = [`x ${fix(x + info.origin[0], 2)}  y ${fix(y + info.origin[1], 2)} m`];
    const degrees = geographic(info, x, y);
    if (degrees) parts.push(`${degrees[1].toFixed(6)}, ${degrees[0].toFixed(6)}°`);
    if (found) {
      parts.push(`z ${fix(between(data.z, found) + found.t * Math.sin(data.roll[found.station]), 2)} m`, `road ${info.road.id[found.road]} s ${fix(between(data.s, found), 1)}`);
      if (state.pieces.length) profile.point(found.road, between(data.s, found));
    }
    $("place").textContent = parts.join("  ·  ");
  }

  /** A colour is for both views, what roads look like for 3D alone. */
  function choose(key) {
    const mode = info.modes.find((item) => item.key === key);
    if (mode) state.mode = state.mode3d = mode;
    else if (built && key === built.key) state.mode3d = built;
  }

  function show2d() {
    state.view = "2d";
    $("scene").hidden = true;
    press();
  }

  async function show3d() {
    state.view = "3d";
    $("scene").hidden = false;
    press();
    if (state.scene) { state.scene.resize(); return; }
    $("scene-message").textContent = "Building the view …";
    try {
      const library = await loadThree();
      state.scene = new RoadScene(data, actions, library);
      state.scene.show(look(state.mode3d));
      $("scene-message").textContent = "";
      const { center, metres } = seen();
      state.scene.look(center.lng, center.lat, metres);
      state.scene.select(state.pieces);
      state.scene.highlight(fellowsOf(info, state.signal));
    } catch (error) {
      $("scene-message").textContent = `The view in 3D cannot be drawn here: the browser offers no WebGL (${error.message}). The map needs none.`;
    }
  }

  function fitAll() {
    map.fitAll();
    if (state.view !== "3d") return;
    const [west, south, east, north] = info.bounds;
    state.scene.look((west + east) / 2, (south + north) / 2, Math.max(60, 1.1 * Math.max(east - west, north - south)));
  }

  function seen() {
    const bounds = map.map.getBounds(), [west, south, east, north] = info.bounds;
    const metres = Math.max(60, Math.min(bounds.getEast() - bounds.getWest(), 1.1 * Math.max(east - west, north - south)));
    const center = bounds.getCenter();
    return { center: { lng: Math.min(east, Math.max(west, center.lng)), lat: Math.min(north, Math.max(south, center.lat)) }, metres };
  }

  function lookAt(road) {
    const [west, south, east, north] = data.roadBox.subarray(4 * road, 4 * road + 4);
    if (Number.isFinite(west)) state.scene.look((west + east) / 2, (south + north) / 2, Math.max(80, 1.6 * Math.max(east - west, north - south)));
  }

  function press() {
    $("view-2d").setAttribute("aria-pressed", String(state.view === "2d"));
    $("view-3d").setAttribute("aria-pressed", String(state.view === "3d"));
    const option = $("mode").querySelector("option[value=built]");
    if (option) option.hidden = option.disabled = state.view !== "3d";
    $("mode").value = modeSeen().key;
    legend();
    remember();
  }

  /** Keep what is shown in the address, so that it can be shared. */
  function remember() {
    const words = [`mode=${modeSeen().key}`];
    if (state.road >= 0) words.push(`road=${encodeURIComponent(info.road.id[state.road])}`);
    if (state.route) words.push(`route=${state.ends.flat().map((value, k) => (value + info.origin[k % 2]).toFixed(1)).join(",")}`);
    if (state.signal >= 0) words.push(`signal=${encodeURIComponent(Object.fromEntries(info.signals[state.signal][9]).id || "")}`);
    if (layers.hidden().length) words.push(`off=${layers.hidden().join(",")}`);
    if (state.view === "3d") words.push("view=3d");
    try { history.replaceState(null, "", "#" + words.join("&")); } catch { /* Some browsers forbid it for local files. */ }
  }

  for (const mode of built ? [built, ...info.modes] : info.modes) $("mode").append(el("option", { value: mode.key }, mode.label));
  $("mode").addEventListener("change", () => { choose($("mode").value); if (modeSeen().key === "finding") layers.set("findings", true); recolour(); });
  $("view-2d").addEventListener("click", show2d);
  $("view-3d").addEventListener("click", show3d);
  $("reset").addEventListener("click", () => { const { center, metres } = seen(); state.scene.look(center.lng, center.lat, metres); });
  $("fit").addEventListener("click", fitAll);
  $("route").addEventListener("click", () => { if (!state.picking) { state.ends = []; map.markEnds([]); } pick(!state.picking); });
  document.addEventListener("keydown", (event) => { if (event.key === "Escape" && state.picking) { state.ends = []; map.markEnds([]); pick(false); } });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { recolour(); profile.show(state.pieces, $("profile-title").textContent, state.route !== null); });
  addSearch(data, actions);
  state.mode3d = built || state.mode;
  choose(wish.get("mode"));
  const road = info.road.id.indexOf(wish.get("road") || "\u0000");
  recolour();
  press();
  panel.open(wish.get("tab") || "overview");
  $("message").textContent = info.road.id.length ? "" : "The file has no roads.";
  const signal = wish.has("signal") ? info.signals.findIndex((row) => Object.fromEntries(row[9]).id === wish.get("signal")) : -1;
  const ends = (wish.get("route") || "").split(",").map((word, k) => Number(word || NaN) - info.origin[k % 2]);
  if (ends.length === 4 && ends.every(Number.isFinite)) { routeClick(ends[0], ends[1], true); if (state.ends.length === 1) routeClick(ends[2], ends[3], true); }
  else if (signal >= 0) openSignal(signal, true);
  else if (road >= 0) openRoad(road, Number(wish.get("s")) || undefined, true);
  if (wish.get("view") === "3d") await show3d();
  // For scripts that control the page.
  window.osm2xodr = {
    data, state, openRoad, openJunction, openSignal, layers, graph, profile,
    pixelOf: (x, y) => { const at = map.map.latLngToContainerPoint([y, x]), box = $("map").getBoundingClientRect(); return [at.x + box.left, at.y + box.top]; },
    setView: (x, y, zoom) => map.map.setView([y, x], zoom, { animate: false }),
  };
  document.documentElement.dataset.ready = "true";
}

/** Index what is looked up often. */
function index(data) {
  const info = data.info, rank = Object.keys(info.severities);
  data.findingOrder = info.findings.map((_, k) => k).sort((a, b) => rank.indexOf(info.findings[b][0]) - rank.indexOf(info.findings[a][0]) || b - a);
  data.roadFindings = new Map();
  // 0: none; then the worst first, as in the legend.
  data.roadFinding = new Int32Array(info.road.id.length);
  info.findings.forEach(([severity, , road], k) => {
    if (road < 0) return;
    if (!data.roadFindings.has(road)) data.roadFindings.set(road, []);
    data.roadFindings.get(road).push(k);
    const grave = rank.length - rank.indexOf(severity);
    data.roadFinding[road] = Math.max(data.roadFinding[road], grave);
  });
  data.namedRoads = info.road.id.map((_, k) => k)
    .filter((road) => info.road.name[road] && data.roadJunction[road] < 0 && data.roadStrip[road + 1] > data.roadStrip[road])
    .sort((a, b) => data.roadLength[b] - data.roadLength[a] || a - b);
}

/** Return the place at an s of a road. */
function placeAt(data, road, s) {
  const first = data.stationStart[data.roadStrip[road]], last = data.stationStart[data.roadStrip[road + 1]] - 1;
  for (let i = first; i < last; i++) {
    if (data.s[i + 1] >= s && data.s[i + 1] > data.s[i]) {
      const share = Math.max(0, (s - data.s[i]) / (data.s[i + 1] - data.s[i]));
      return [data.x[i] + share * (data.x[i + 1] - data.x[i]), data.y[i] + share * (data.y[i + 1] - data.y[i])];
    }
  }
  return last >= first ? [data.x[last], data.y[last]] : null;
}

function addSearch(data, actions) {
  const info = data.info, input = $("search"), list = $("results");
  let hits = [], at = -1;
  const wayRoads = new Map();
  for (const [road, ways] of Object.entries(info.ways)) for (const [way] of ways) if (!wayRoads.has(String(way))) wayRoads.set(String(way), Number(road));
  const find = (text) => {
    const word = text.trim().toLowerCase();
    if (!word) return [];
    const exact = [], begin = [], inside = [], seen = new Set();
    info.road.id.forEach((id, road) => {
      const name = info.road.name[road];
      const hit = { label: `road ${id}`, more: name, act: () => actions.openRoad(road, undefined, true) };
      if (id.toLowerCase() === word) exact.push(hit);
      else if (name && name.toLowerCase().includes(word) && data.roadJunction[road] < 0) {
        if (inside.length < 300 && !seen.has(name)) { seen.add(name); (name.toLowerCase().startsWith(word) ? begin : inside).push({ ...hit, label: name, more: `road ${id}` }); }
      }
    });
    info.junctions.id.forEach((id, k) => {
      if (id.toLowerCase() === word) exact.push({ label: `junction ${id}`, more: info.junctions.name[k], act: () => actions.openJunction(k) });
    });
    const way = wayRoads.get(word.replace(/^way\/?/, ""));
    if (way !== undefined) exact.push({ label: `road ${info.road.id[way]}`, more: `way/${word.replace(/^way\/?/, "")}`, act: () => actions.openRoad(way, undefined, true) });
    return exact.concat(begin, inside).slice(0, 14);
  };
  const paint = () => {
    list.replaceChildren(...hits.map((hit, k) => el("li", { role: "option", id: `hit-${k}`, "aria-selected": String(k === at), onmousedown: (event) => { event.preventDefault(); choose(k); } },
      hit.label, " ", el("small", {}, hit.more || ""))));
    if (!hits.length && input.value.trim()) list.append(el("li", { role: "option", "aria-selected": "false" }, "nothing found"));
    list.hidden = !input.value.trim();
    input.setAttribute("aria-expanded", String(!list.hidden));
    if (at >= 0) input.setAttribute("aria-activedescendant", `hit-${at}`); else input.removeAttribute("aria-activedescendant");
  };
  const choose = (k) => { if (hits[k]) { hits[k].act(); list.hidden = true; input.setAttribute("aria-expanded", "false"); } };
  input.addEventListener("input", () => { hits = find(input.value); at = hits.length ? 0 : -1; paint(); });
  input.addEventListener("focus", paint);
  input.addEventListener("blur", () => { list.hidden = true; input.setAttribute("aria-expanded", "false"); });
  input.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown" || event.key === "ArrowUp") { at = Math.max(0, Math.min(hits.length - 1, at + (event.key === "ArrowDown" ? 1 : -1))); paint(); event.preventDefault(); }
    if (event.key === "Enter") { choose(Math.max(0, at)); event.preventDefault(); }
    if (event.key === "Escape") { list.hidden = true; }
  });
}

start().catch((error) => {
  $("message").textContent = `This report cannot be drawn: ${error.message}. It needs a browser of 2023 or later.`;
  console.error(error);
});
