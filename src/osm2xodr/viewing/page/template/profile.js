// The profile of a road or of a route: height, ground, grade and structures along s. uPlot draws it.

const BANDS = { "height not measured": "rgba(193,39,45,0.14)", tunnel: "rgba(90,90,110,0.25)", bridge: "rgba(60,140,200,0.18)" };

class Profile {
  constructor(data, actions) {
    this.data = data;
    this.actions = actions;
    this.pieces = [];
    this.plot = null;
    $("profile-close").addEventListener("click", () => actions.close());
    new ResizeObserver(() => this.plot && this.plot.setSize(this.size())).observe($("stage"));
  }

  size() {
    return { width: Math.max(240, $("stage").clientWidth - 20), height: window.innerHeight < 620 ? 150 : 190 };
  }

  /** Show the profile along the pieces of a path: of one road, or of a route. */
  show(pieces, title, isRoute) {
    if (this.plot) { this.plot.destroy(); this.plot = null; }
    this.ready = false;
    this.wished = null;
    this.pieces = pieces;
    this.isRoute = isRoute;
    $("profile").hidden = !pieces.length;
    if (!pieces.length) return;
    const data = this.data, info = data.info, path = along(data, pieces, isRoute);
    this.path = path;
    $("profile-title").textContent = title;
    const values = (array, factor = 1) => array.map((value) => (Number.isFinite(value) ? factor * value : null));
    const css = getComputedStyle(document.documentElement), ink = css.getPropertyValue("--ink"), line = css.getPropertyValue("--line");
    const soft = css.getPropertyValue("--soft"), dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const metres = (u, value) => (value === null || value === undefined ? "–" : fix(value, 2) + " m");
    const percent = (u, value) => (value === null || value === undefined ? "–" : fix(value, 2) + " %");
    const series = [
      { label: isRoute ? "way" : "s", value: metres },
      { label: "road", stroke: dark ? "#74b4f2" : "#0b5cad", width: 2.2, value: metres },
    ];
    const columns = [path.d, values(path.z)];
    if (info.has_ground) {
      series.push({ label: "elevation model", stroke: dark ? "#d0a26a" : "#8a5a1f", width: 1.4, dash: [5, 3], value: metres });
      columns.push(values(path.ground));
    }
    series.push({ label: "grade", stroke: dark ? "#9db0a0" : "#5c7a63", width: 1.1, scale: "%", value: percent });
    columns.push(values(path.grade, 100));
    const limit = !isRoute ? info.limits[pieces[0].road] : 0;
    for (const line_ of series.slice(1)) line_.points = { show: false };
    const axis = { stroke: soft, grid: { stroke: line, width: 0.5 }, ticks: { stroke: line }, font: "11px system-ui" };
    const steepest = path.grade.reduce((most, grade) => Math.max(most, Math.abs(100 * grade) || 0), Math.max(2, 100 * (limit || 0)));
    this.plot = new uPlot({
      ...this.size(), series,
      scales: { x: { time: false }, y: { range: (u, low, high) => heights(low, high) }, "%": { range: [-1.15 * steepest, 1.15 * steepest] } },
      axes: [
        { ...axis, label: isRoute ? "way (m)" : "s (m)", labelSize: 16, labelFont: "11px system-ui", size: 30 },
        { ...axis, label: "height (m)", labelSize: 16, labelFont: "11px system-ui", size: 54 },
        { ...axis, scale: "%", side: 1, label: "grade (%)", labelSize: 16, labelFont: "11px system-ui", size: 40, grid: { show: false } },
      ],
      legend: { live: true },
      cursor: { y: false, drag: { x: true, y: false } },
      hooks: {
        ready: [() => { this.ready = true; if (this.wished !== null) this.point(...this.wished); }],
        drawClear: [(u) => this.bands(u, ink), (u) => this.borders(u, ink, soft), (u) => limit && this.limits(u, 100 * limit, soft)],
        setCursor: [(u) => this.moved(u)],
      },
    }, columns, $("plot"));
  }

  /** Stretches without a measured height, bridges, tunnels and findings. */
  bands(u, ink) {
    const context = u.ctx, ratio = devicePixelRatio;
    context.save();
    this.pieces.forEach(({ road, from, to }, k) => {
      const low = Math.min(from, to), high = Math.max(from, to);
      const place = (s) => u.valToPos(this.path.begins[k] + Math.abs(s - from), "x", true);
      const gaps = (this.data.info.unmeasured[road] || []).map(([begin, end]) => ["height not measured", begin, end]);
      for (const [kind, begin, end] of [...gaps, ...(this.data.info.structures[road] || [])]) {
        if (Math.min(end, high) <= Math.max(begin, low)) continue;
        const [a, b] = [place(Math.max(begin, low)), place(Math.min(end, high))].sort((one, other) => one - other);
        const x0 = Math.max(u.bbox.left, a), x1 = Math.min(u.bbox.left + u.bbox.width, b);
        if (x1 <= x0) continue;
        context.fillStyle = BANDS[kind] || BANDS.bridge;
        context.fillRect(x0, u.bbox.top, x1 - x0, u.bbox.height);
        context.fillStyle = ink; context.font = `${11 * ratio}px system-ui`;
        if (x1 - x0 > 40 * ratio) context.fillText(kind, x0 + 4 * ratio, u.bbox.top + 13 * ratio);
      }
      context.strokeStyle = "#c1272d"; context.lineWidth = 1.5;
      for (const finding of this.data.roadFindings.get(road) || []) {
        const s = this.data.info.findings[finding][4];
        if (s === null || s < low || s > high) continue;
        const x = place(s);
        if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
        context.beginPath(); context.moveTo(x, u.bbox.top); context.lineTo(x, u.bbox.top + 10 * ratio); context.stroke();
      }
    });
    context.restore();
  }

  /** Where one road of a route ends and the next begins; names where there is room. */
  borders(u, ink, soft) {
    if (!this.isRoute) return;
    const context = u.ctx, ratio = devicePixelRatio, { begins } = this.path, info = this.data.info;
    context.save();
    context.strokeStyle = soft; context.fillStyle = ink; context.lineWidth = ratio; context.setLineDash([ratio, 3 * ratio]);
    context.font = `${10 * ratio}px system-ui`; context.textAlign = "left";
    let free = -Infinity;
    begins.forEach((distance, k) => {
      const x = u.valToPos(distance, "x", true), next = u.valToPos(begins[k + 1] ?? begins[0] + this.path.length, "x", true);
      if (x < u.bbox.left - 1 || x > u.bbox.left + u.bbox.width) return;
      if (k) { context.beginPath(); context.moveTo(x, u.bbox.top); context.lineTo(x, u.bbox.top + u.bbox.height); context.stroke(); }
      const { road } = this.pieces[k], text = info.road.name[road] || `road ${info.road.id[road]}`, width = context.measureText(text).width;
      if (this.data.roadJunction[road] >= 0 || x + 3 * ratio < free || width > next - x - 6 * ratio) return;
      context.fillText(text, x + 3 * ratio, u.bbox.top + u.bbox.height - 5 * ratio);
      free = x + width + 9 * ratio;
    });
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
    const path = this.path, off = path.z[k] - path.ground[k];
    const parts = [`s ${fix(path.s[k], 1)} m`, `height ${fix(path.z[k], 2)} m`, `grade ${fix(100 * path.grade[k], 2)} %`];
    if (this.isRoute) parts.unshift(`${fix(path.d[k])} m`, `road ${this.data.info.road.id[path.road[k]]}`);
    if (Number.isFinite(off)) parts.push(`${fix(Math.abs(off), 2)} m ${off < 0 ? "below" : "above"} the elevation model`);
    $("profile-value").textContent = parts.join(" · ");
    if (!this.quiet) this.actions.mark(path.x[k], path.y[k]);
  }

  /** Point at a place on a road of the path, as when the map's pointer is there. */
  point(road, s) {
    const k = this.pieces.findIndex((piece) => piece.road === road && (s - piece.from) * (s - piece.to) <= 0);
    if (!this.plot || (k < 0 && Number.isFinite(s))) return;
    if (!this.ready) { this.wished = [road, s]; return; }
    this.quiet = true;
    const left = k < 0 ? -10 : this.plot.valToPos(this.path.begins[k] + Math.abs(s - this.pieces[k].from), "x");
    this.plot.setCursor({ left, top: k < 0 ? -10 : 20 });
    this.quiet = false;
  }
}

/** Widen a range of heights, so that a level road looks level. */
function heights(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const middle = (low + high) / 2, half = Math.max(1.2, 0.56 * (high - low));
  return [middle - half, middle + half];
}
