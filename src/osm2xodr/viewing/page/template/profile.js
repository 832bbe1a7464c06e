// The profile of a road: height, ground, grade and structures along s. uPlot draws it.

class Profile {
  constructor(data, actions) {
    this.data = data;
    this.actions = actions;
    this.road = -1;
    this.plot = null;
    $("profile-close").addEventListener("click", () => actions.openRoad(-1));
    new ResizeObserver(() => this.plot && this.plot.setSize(this.size())).observe($("stage"));
  }

  size() {
    return { width: Math.max(240, $("stage").clientWidth - 20), height: window.innerHeight < 620 ? 150 : 190 };
  }

  show(road) {
    if (this.plot) { this.plot.destroy(); this.plot = null; }
    this.ready = false;
    this.wished = null;
    this.road = road;
    $("profile").hidden = road < 0;
    if (road < 0) return;
    const data = this.data, info = data.info;
    const rows = this.rows(road);
    this.stations = rows;
    $("profile-title").textContent = `Road ${info.road.id[road]}` + (info.road.name[road] ? ` · ${info.road.name[road]}` : "");
    const values = (array, factor = 1) => rows.map((i) => (Number.isFinite(array[i]) ? factor * array[i] : null));
    const css = getComputedStyle(document.documentElement), ink = css.getPropertyValue("--ink"), line = css.getPropertyValue("--line");
    const soft = css.getPropertyValue("--soft"), dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const metres = (u, value) => (value === null || value === undefined ? "–" : fix(value, 2) + " m");
    const percent = (u, value) => (value === null || value === undefined ? "–" : fix(value, 2) + " %");
    const series = [
      { label: "s", value: metres },
      { label: "road", stroke: dark ? "#74b4f2" : "#0b5cad", width: 2.2, value: metres },
    ];
    const columns = [values(data.s), values(data.z)];
    if (info.has_ground) {
      series.push({ label: "elevation model", stroke: dark ? "#d0a26a" : "#8a5a1f", width: 1.4, dash: [5, 3], value: metres });
      columns.push(values(data.ground));
    }
    series.push({ label: "grade", stroke: dark ? "#9db0a0" : "#5c7a63", width: 1.1, scale: "%", value: percent });
    columns.push(values(data.grade, 100));
    const limit = info.limits[road];
    for (const line_ of series.slice(1)) line_.points = { show: false };
    const axis = { stroke: soft, grid: { stroke: line, width: 0.5 }, ticks: { stroke: line }, font: "11px system-ui" };
    const steepest = Math.max(2, ...rows.map((i) => Math.abs(100 * data.grade[i]) || 0), 100 * (limit || 0));
    this.plot = new uPlot({
      ...this.size(), series,
      scales: { x: { time: false }, y: { range: (u, low, high) => heights(low, high) }, "%": { range: [-1.15 * steepest, 1.15 * steepest] } },
      axes: [
        { ...axis, label: "s (m)", labelSize: 16, labelFont: "11px system-ui", size: 30 },
        { ...axis, label: "height (m)", labelSize: 16, labelFont: "11px system-ui", size: 54 },
        { ...axis, scale: "%", side: 1, label: "grade (%)", labelSize: 16, labelFont: "11px system-ui", size: 40, grid: { show: false } },
      ],
      legend: { live: true },
      cursor: { y: false, drag: { x: true, y: false } },
      hooks: {
        ready: [() => { this.ready = true; if (this.wished !== null) this.point(this.wished); }],
        drawClear: [(u) => this.bands(u, road, ink), (u) => limit && this.limits(u, 100 * limit, soft)],
        setCursor: [(u) => this.moved(u)],
      },
    }, columns, $("plot"));
  }

  /** Stations of a road, each place once. */
  rows(road) {
    const data = this.data, rows = [];
    const first = data.stationStart[data.roadStrip[road]], last = data.stationStart[data.roadStrip[road + 1]];
    for (let i = first; i < last; i++) {
      if (!rows.length || data.s[i] > data.s[rows[rows.length - 1]]) rows.push(i);
    }
    return rows;
  }

  bands(u, road, ink) {
    const unmeasured = (this.data.info.unmeasured[road] || []).map(([from, to]) => ["height not measured", from, to]);
    const bands = [...unmeasured, ...(this.data.info.structures[road] || [])];
    const context = u.ctx;
    context.save();
    for (const [kind, from, to] of bands) {
      const x0 = Math.max(u.bbox.left, u.valToPos(from, "x", true)), x1 = Math.min(u.bbox.left + u.bbox.width, u.valToPos(to, "x", true));
      if (x1 <= x0) continue;
      context.fillStyle = kind === "height not measured" ? "rgba(193,39,45,0.14)" : kind === "tunnel" ? "rgba(90,90,110,0.25)" : "rgba(60,140,200,0.18)";
      context.fillRect(x0, u.bbox.top, x1 - x0, u.bbox.height);
      context.fillStyle = ink; context.font = `${11 * devicePixelRatio}px system-ui`;
      if (x1 - x0 > 40 * devicePixelRatio) context.fillText(kind, x0 + 4 * devicePixelRatio, u.bbox.top + 13 * devicePixelRatio);
    }
    context.strokeStyle = "#c1272d"; context.lineWidth = 1.5;
    for (const k of this.data.roadFindings.get(road) || []) {
      const s = this.data.info.findings[k][4];
      if (s === null) continue;
      const x = u.valToPos(s, "x", true);
      if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
      context.beginPath(); context.moveTo(x, u.bbox.top); context.lineTo(x, u.bbox.top + 10 * devicePixelRatio); context.stroke();
    }
    context.restore();
  }

  /** The usual limit of the grade, up and down. */
  limits(u, limit, ink) {
    const context = u.ctx, ratio = devicePixelRatio;
    context.save();
    context.strokeStyle = "#b5543c"; context.fillStyle = ink; context.lineWidth = ratio; context.setLineDash([2 * ratio, 4 * ratio]);
    context.font = `${10 * ratio}px system-ui`; context.textAlign = "right";
    for (const value of [limit, -limit]) {
      const y = u.valToPos(value, "%", true);
      context.beginPath(); context.moveTo(u.bbox.left, y); context.lineTo(u.bbox.left + u.bbox.width, y); context.stroke();
      if (value > 0) context.fillText(`limit of the class ${fix(limit, 0)} %`, u.bbox.left + u.bbox.width - 4 * ratio, y + 11 * ratio);
    }
    context.restore();
  }

  moved(u) {
    const k = u.cursor.idx;
    if (k === null || k === undefined || u.cursor.left < 0) { $("profile-value").textContent = ""; if (!this.quiet) this.actions.mark(NaN, NaN); return; }
    const data = this.data, i = this.stations[k];
    const parts = [`s ${fix(data.s[i], 1)} m`, `height ${fix(data.z[i], 2)} m`, `grade ${fix(100 * data.grade[i], 2)} %`];
    if (Number.isFinite(data.ground[i])) { const off = data.z[i] - data.ground[i]; parts.push(`${fix(Math.abs(off), 2)} m ${off < 0 ? "below" : "above"} the elevation model`); }
    $("profile-value").textContent = parts.join(" · ");
    if (!this.quiet) this.actions.mark(data.x[i], data.y[i]);
  }

  /** Point at a place on the road, as when the map's pointer is there. */
  point(s) {
    if (!this.plot) return;
    if (!this.ready) { this.wished = s; return; }
    this.quiet = true;
    const left = Number.isFinite(s) ? this.plot.valToPos(s, "x") : -10;
    this.plot.setCursor({ left, top: Number.isFinite(s) ? 20 : -10 });
    this.quiet = false;
  }
}

/** Widen a range of heights, so that a level road looks level. */
function heights(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const middle = (low + high) / 2, half = Math.max(1.2, 0.56 * (high - low));
  return [middle - half, middle + half];
}
