// The panel of details: the network, a road, accuracy, coverage, findings, messages of the conversion.
const LISTED = 100; // entries at first; the rest on demand
const OSM = "https://www.openstreetmap.org/";

class Panel {
  constructor(data, actions) {
    this.data = data;
    this.actions = actions;
    this.road = -1;
    this.junction = -1;
    this.signal = -1;
    this.route = null;
    const info = data.info;
    this.tabs = [["overview", "Overview", () => this.overview()], ["road", "Details", () => this.roadPage()]];
    if (info.accuracy) this.tabs.push(["accuracy", "Heights", () => this.accuracy()]);
    if (info.coverage) this.tabs.push(["coverage", "Coverage", () => this.coverage()]);
    if (info.checked) this.tabs.push(["findings", `Findings ${fix(info.finding_count)}`, () => this.findings()]);
    if (info.log) this.tabs.push(["log", "Guesses", () => this.log()]);
    this.buttons = this.tabs.map(([key, label]) =>
      el("button", { type: "button", role: "tab", id: `tab-${key}`, "aria-controls": "content", onclick: () => this.open(key) }, label));
    $("tabs").append(...this.buttons);
    $("tabs").addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const at = (this.buttons.indexOf(document.activeElement) + step + this.buttons.length) % this.buttons.length;
      this.buttons[at].focus(); this.open(this.tabs[at][0]);
    });
  }

  open(key) {
    const at = Math.max(0, this.tabs.findIndex((tab) => tab[0] === key));
    this.tab = this.tabs[at][0];
    this.buttons.forEach((button, k) => { button.setAttribute("aria-selected", String(k === at)); button.tabIndex = k === at ? 0 : -1; });
    $("content").setAttribute("aria-labelledby", `tab-${this.tab}`);
    $("content").replaceChildren(...this.tabs[at][2]().filter(Boolean));
    $("content").scrollTop = 0;
  }

  overview() {
    const info = this.data.info;
    const tiles = info.figures.map(([label, value]) => el("div", { class: "tile" }, el("b", {}, value), el("span", {}, label)));
    return [
      el("h2", {}, "Network"), el("div", { class: "tiles" }, ...tiles),
      el("h2", {}, "File"), pairs(info.about),
      info.notes.length ? el("h2", {}, "To know") : null,
      info.notes.length ? el("ul", {}, ...info.notes.map((note) => el("li", {}, note))) : null,
      el("p", { class: "quiet" }, "Click a road for its profile and its data. This page contains all its data; it loads nothing."),
    ];
  }

  roadLink(road, text, s) {
    const info = this.data.info;
    const label = text || `${info.road.id[road]}${info.road.name[road] ? ` ${info.road.name[road]}` : ""}`;
    return el("button", { type: "button", class: "link", onclick: () => this.actions.openRoad(road, s, true) }, label);
  }

  roadPage() {
    if (this.route) return routePage(this, this.route);
    if (this.signal >= 0) return signalPage(this, this.signal);
    if (this.junction >= 0) return this.junctionPage();
    if (this.road < 0) return [el("p", { class: "quiet" }, "Nothing is selected. Click a road, a junction, a sign or a light on the map, or find a road by id or name.")];
    const info = this.data.info, road = this.road, data = this.data;
    const junction = data.roadJunction[road];
    const rows = [
      ["id", info.road.id[road]], ["name", info.road.name[road] || "–"], ["length", fix(data.roadLength[road], 2) + " m"],
      ["junction", junction >= 0 ? this.junctionLink(junction) : "–"], ["class", info.road.classes[road] || "–"],
      ["drives on", info.road.left_hand[road] ? "the left" : "the right"], ["speed", this.speeds(road)],
      ["height", this.range(road, data.z, 1, 2, "m")], ["grade", this.range(road, data.grade, 100, 2, "%")],
      ["from", this.linked(road, 0)], ["to", this.linked(road, 1)],
    ];
    if (info.limits[road]) rows.splice(9, 0, ["limit of its class", fix(100 * info.limits[road], 1) + " %"]);
    const ways = (info.ways[road] || []).map(([way, from, to, highway, name]) =>
      el("tr", {}, el("td", {}, osmLink(`way/${way}`)), el("td", {}, highway || "–"), el("td", {}, name || ""), el("td", { class: "n" }, from === null ? "" : `${fix(from)}–${fix(to)} m`)));
    const user = info.user[road] || [];
    const structures = info.structures[road] || [];
    return [
      pairs(rows),
      el("h2", {}, "Lanes"), this.lanes(road),
      structures.length ? el("h2", {}, "Structures") : null,
      structures.length ? el("table", {}, el("tbody", {}, ...structures.map(([kind, from, to, label]) =>
        el("tr", {}, el("td", {}, kind), el("td", { class: "n" }, `${fix(from)}–${fix(to)} m`), el("td", {}, label ? withLinks("", label) : ""))))) : null,
      ways.length ? el("h2", {}, "OpenStreetMap") : null,
      ways.length ? el("table", {}, el("tbody", {}, ...ways)) : null,
      user.length ? el("h2", {}, "userData") : null,
      user.length ? pairs(user.map(([code, value]) => [code, withLinks(code, value)])) : null,
      ...pasted(this.wayLines(road)),
      ...this.roadFindings(road),
    ];
  }

  /** Lines for a file of corrections, with the values that the road has now. */
  wayLines(road) {
    const data = this.data, info = data.info;
    const listed = (info.user[road] || []).flatMap(([code, value]) => (/way_id/i.test(code) ? value.match(/-?\d+/g) || [] : []));
    const ways = Array.from(new Set([...(info.ways[road] || []).map(([way]) => String(way)), ...listed]));
    const strip = data.roadStrip[road];
    if (data.roadJunction[road] >= 0 || strip >= data.roadStrip[road + 1]) return [];
    const first = data.laneStart[strip], count = data.laneStart[strip + 1] - first;
    const border = (k) => data.t[data.borderStart[strip] + k];
    let lanes = 0, width = 0, speed = NaN;
    for (let k = 0; k < count; k++) {
      if (!/^(driving|bidirectional|bus|taxi)$/.test(info.lane_types[data.laneType[first + k]])) continue;
      lanes += 1; width += border(k) - border(k + 1);
      if (Number.isFinite(data.laneSpeed[first + k])) speed = Math.round(data.laneSpeed[first + k]);
    }
    const values = [lanes ? `lanes = ${lanes}` : "", width > 0 ? `width = ${width.toFixed(2)}` : "", Number.isFinite(speed) ? `speed = ${speed}` : ""];
    return ways.flatMap((way) => values.filter(Boolean).map((value) => `way.${way}.${value}`));
  }

  junctionPage() {
    const data = this.data, info = data.info, k = this.junction;
    const inside = [], arms = new Set();
    data.roadJunction.forEach((junction, road) => {
      if (junction === k) {
        inside.push(road);
        for (const end of [0, 1]) if (data.linkKind[2 * road + end] === 1 && data.link[2 * road + end] >= 0) arms.add(data.link[2 * road + end]);
      }
    });
    const list = (roads) => el("ul", {}, ...roads.map((road) => el("li", {}, this.roadLink(road), ` ${fix(data.roadLength[road], 1)} m, ${this.range(road, data.grade, 100, 1, "%")}`)));
    const found = inside.flatMap((road) => data.roadFindings.get(road) || []);
    return [
      pairs([["junction", info.junctions.id[k]], ["name", info.junctions.name[k] || "–"]]),
      el("h2", {}, `Roads that meet here (${arms.size})`), list(Array.from(arms).sort((a, b) => a - b)),
      el("h2", {}, `Connecting roads (${inside.length})`), list(inside),
      ...this.nodesOf(k, inside[0]),
      found.length ? el("h2", {}, "Findings") : null, found.length ? el("ul", {}, ...found.map((j) => this.findingItem(j))) : null,
    ];
  }

  /** The nodes of a junction, and lines for a file of corrections; a connecting road has its height. */
  nodesOf(junction, road) {
    const data = this.data, nodes = data.info.junction_nodes[junction] || [];
    if (!nodes.length) return [];
    const z = road === undefined ? NaN : data.z[data.stationStart[data.roadStrip[road]]];
    const values = [nodes.length > 1 ? `split = [${nodes.slice(1).join(", ")}]` : "", Number.isFinite(z) ? `z = ${z.toFixed(2)}` : "", "no-u-turn = true"];
    const lines = values.filter(Boolean).map((value) => `node.${nodes[0]}.${value}`);
    return [el("h2", {}, "OpenStreetMap"), el("p", {}, ...nodes.flatMap((node) => [osmLink(`node/${node}`), " "])), ...pasted(lines)];
  }

  roadFindings(road) {
    if (!this.data.info.checked) return [];
    const found = this.data.roadFindings.get(road) || [];
    return [el("h2", {}, "Findings"), found.length ? el("ul", {}, ...found.map((k) => this.findingItem(k))) : el("p", { class: "quiet" }, "None.")];
  }

  junctionLink(junction) {
    const at = this.data.info.junctions;
    return el("button", { type: "button", class: "link", onclick: () => this.actions.openJunction(junction) }, `${at.id[junction]} ${at.name[junction]}`.trim());
  }

  linked(road, end) {
    const data = this.data, kind = data.linkKind[2 * road + end], other = data.link[2 * road + end];
    if (kind === 0) return "–";
    if (other < 0) return "not in the file";
    if (kind === 2) return el("span", {}, "junction ", this.junctionLink(other));
    const where = { 0: ", its start", 1: ", its end" }[data.contact[2 * road + end]] || "";
    return el("span", {}, "road ", this.roadLink(other), where);
  }

  speeds(road) {
    const seen = new Set();
    for (let strip = this.data.roadStrip[road]; strip < this.data.roadStrip[road + 1]; strip++) {
      for (let lane = this.data.laneStart[strip]; lane < this.data.laneStart[strip + 1]; lane++) {
        if (Number.isFinite(this.data.laneSpeed[lane])) seen.add(Math.round(this.data.laneSpeed[lane]));
      }
    }
    return seen.size ? Array.from(seen).sort((a, b) => a - b).join(", ") + " km/h" : "–";
  }

  range(road, values, factor, digits, unit) {
    const data = this.data;
    let low = Infinity, high = -Infinity;
    for (let i = data.stationStart[data.roadStrip[road]]; i < data.stationStart[data.roadStrip[road + 1]]; i++) {
      if (Number.isFinite(values[i])) { low = Math.min(low, values[i]); high = Math.max(high, values[i]); }
    }
    return low > high ? "–" : `${fix(factor * low, digits)} to ${fix(factor * high, digits)} ${unit}`;
  }

  lanes(road) {
    const data = this.data, info = data.info, rows = [];
    for (let strip = data.roadStrip[road]; strip < data.roadStrip[road + 1]; strip++) {
      const first = data.stationStart[strip], last = data.stationStart[strip + 1] - 1;
      const count = data.laneStart[strip + 1] - data.laneStart[strip];
      if (last < first) continue;
      rows.push(el("tr", {}, el("th", { colspan: 6, scope: "rowgroup" }, `s ${fix(data.s[first], 1)} to ${fix(data.s[last], 1)} m`)));
      const width = (row, k) => data.t[data.borderStart[strip] + row * (count + 1) + k] - data.t[data.borderStart[strip] + row * (count + 1) + k + 1];
      for (let k = 0; k < count; k++) {
        const lane = data.laneStart[strip] + k, a = width(0, k), b = width(last - first, k);
        const id = (value) => (value === UNKNOWN ? "–" : String(value));
        rows.push(el("tr", {}, el("td", { class: "n" }, id(data.laneId[lane])), el("td", {}, info.lane_types[data.laneType[lane]]),
          el("td", { class: "n" }, Math.abs(a - b) < 0.01 ? fix(a, 2) : `${fix(a, 2)} → ${fix(b, 2)}`),
          el("td", { class: "n" }, fix(data.laneSpeed[lane])),
          el("td", { class: "n" }, id(data.lanePredecessor[lane])), el("td", { class: "n" }, id(data.laneSuccessor[lane]))));
      }
    }
    const head = ["id", "type", "width m", "km/h", "from lane", "to lane"];
    return el("table", {}, el("thead", {}, el("tr", {}, ...head.map((text, k) => el("th", { scope: "col", class: k === 1 ? "" : "n" }, text)))), el("tbody", {}, ...rows));
  }

  accuracy() {
    const at = this.data.info.accuracy;
    const head = ["", "length km", "mean m", "rms m", "95 % m", "largest m"];
    const digits = [0, 2, 2, 2, 2, 2];
    return [
      el("p", {}, at.text),
      table(head, at.rows.map((row) => row.map((value, k) => (k ? fix(value, digits[k]) : value))), "Road less elevation model"),
      el("h2", {}, "Farthest roads"),
      table(["road", "s m", "largest m", "rms m"], at.worst.map(([road, s, value, rms]) => [this.roadLink(road, null, s), fix(s, 0), fix(value, 2), fix(rms, 2)])),
      el("h2", {}, "Steepest roads"),
      table(["road", "s m", "grade %"], at.steep.map(([road, s, value]) => [this.roadLink(road, null, s), fix(s, 0), fix(100 * value, 1)])),
    ];
  }

  coverage() {
    const at = this.data.info.coverage;
    return [
      el("p", {}, at.text),
      table(["highway", "km in OSM", "km covered", "%"], at.rows.map(([name, all, done]) => [name, fix(all, 2), fix(done, 2), fix((100 * done) / all, 1)]), "Length of car ways that lie on a carriageway"),
      el("h2", {}, `Ways with more than ${fix(at.least)} m uncovered (${fix(at.missing.length)})`),
      at.missing.length ? this.long(at.missing, ([way, highway, name, length, missing, x, y]) => el("li", {},
        osmLink(`way/${way}`), ` ${highway}${name ? `, ${name}` : ""}: ${fix(missing)} of ${fix(length)} m `, this.placeLink(x, y), el("code", { class: "line" }, `way.${way}.keep = true`))) : el("p", { class: "quiet" }, "None."),
    ];
  }

  placeLink(x, y) {
    return x === null || x === undefined ? null : el("button", { type: "button", class: "link", onclick: () => this.actions.go(x, y) }, "show");
  }

  findingItem(k) {
    const [severity, , road, lane, s, x, , text] = this.data.info.findings[k];
    const where = road >= 0 ? [this.roadLink(road, `road ${this.data.info.road.id[road]}`, s === null ? undefined : s), lane === null ? "" : `, lane ${lane}`, s === null ? "" : `, s ${fix(s, 1)} m`, ": "] : [];
    return el("li", {}, el("span", { class: `badge ${severity}` }, severity), " ", ...where, text, " ",
      x === null ? null : el("button", { type: "button", class: "link", onclick: () => this.actions.openFinding(k) }, "show"));
  }

  findings() {
    const { findings, checked } = this.data.info;
    if (!findings.length) return [el("p", {}, "Nothing was found."), el("p", { class: "quiet" }, checked)];
    const groups = new Map();
    for (const k of [...this.data.findingOrder].reverse()) {
      const [severity, rule] = findings[k], key = `${severity} ${rule}`;
      if (!groups.has(key)) groups.set(key, { severity, rule, members: [] });
      groups.get(key).members.push(k);
    }
    return [el("p", { class: "quiet" }, checked), ...Array.from(groups.values()).map((group) => group_(group.rule, group.severity, group.members.length, () => this.long(group.members, (k) => this.findingItem(k))))];
  }

  log() {
    const groups = new Map();
    for (const item of this.data.info.log.items) {
      const key = `${item[0]} ${item[1]}`;
      if (!groups.has(key)) groups.set(key, { kind: item[0], code: item[1], members: [] });
      groups.get(key).members.push(item);
    }
    const sorted = Array.from(groups.values());
    return [el("p", { class: "quiet" }, this.data.info.log.text), ...sorted.map((group) => group_(group.code, group.kind, group.members.length, () =>
      this.long(group.members, ([, , id, message, x, y, line]) => el("li", {}, message, " ", id ? osmLink(id) : null, " ", this.placeLink(x, y),
        line ? el("code", { class: "line" }, line) : null))))];
  }

  /** A list that shows its beginning first. */
  long(items, entry) {
    const list = el("ul", {}, ...items.slice(0, LISTED).map(entry));
    if (items.length <= LISTED) return list;
    const more = el("button", { type: "button", class: "link", onclick: () => { more.remove(); list.append(...items.slice(LISTED).map(entry)); } }, `all ${fix(items.length)}`);
    return el("div", {}, list, more);
  }
}

/** Lines to copy, if there are any; a click selects them. */
function pasted(lines) {
  if (!lines.length) return [];
  return [el("h2", {}, "Corrections"), el("p", { class: "quiet" }, "Lines for convert --corrections, to change:"), el("pre", { class: "line" }, lines.join("\n"))];
}

function osmLink(id) {
  return el("a", { href: /^(way|node|relation)\/-?\d+$/.test(id) ? OSM + id : null, target: "_blank", rel: "noopener noreferrer" }, id);
}

/** Turn OSM ids in a text into links: way/12, or plain numbers where the name of the text mentions ways. */
function withLinks(code, value) {
  const numbers = /way/i.test(code), parts = value.split(/([\s,;]+)/).map((word) => {
    if (/^(way|node|relation)\/\d+$/.test(word)) return osmLink(word);
    return numbers && /^\d+$/.test(word) ? osmLink(`way/${word}`) : word;
  });
  return el("span", {}, ...parts);
}

function pairs(rows) {
  return el("dl", {}, ...rows.flatMap(([key, value]) => [el("dt", {}, key), el("dd", {}, value)]));
}

function table(head, rows, caption) {
  return el("table", {}, caption ? el("caption", {}, caption) : null,
    el("thead", {}, el("tr", {}, ...head.map((text, k) => el("th", { scope: "col", class: k ? "n" : "" }, text)))),
    el("tbody", {}, ...rows.map((row) => el("tr", {}, ...row.map((value, k) => el("td", { class: k ? "n" : "" }, value))))));
}

/** A group that fills itself when it is opened. */
function group_(name, kind, count, fill) {
  const details = el("details", {}, el("summary", {}, el("b", {}, name), el("span", { class: `badge ${kind}` }, kind), el("span", {}, fix(count))));
  details.addEventListener("toggle", () => { if (details.open && details.children.length === 1) details.append(fill()); });
  return details;
}
