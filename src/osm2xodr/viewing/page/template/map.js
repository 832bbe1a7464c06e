// The map: Leaflet moves it, tiles.js draws it.

class RoadMap {
  constructor(data, actions) {
    this.data = data;
    this.actions = actions;
    const [west, south, east, north] = data.info.bounds;
    this.bounds = L.latLngBounds([south, west], [north, east]);
    // Metres per pixel are powers of two times those at which the whole network fits: whole zooms, sharp tiles.
    const box = $("map"), fit = Math.min((box.clientWidth - 60) / Math.max(10, east - west), (box.clientHeight - 60) / Math.max(10, north - south));
    const base = Math.max(1e-4, fit), most = Math.max(0, Math.ceil(Math.log2(64 / base)));
    this.scale = (zoom) => base * 2 ** zoom;
    const crs = L.extend({}, L.CRS.Simple, { scale: this.scale, zoom: (scale) => Math.log2(scale / base) });
    this.map = L.map("map", {
      crs, minZoom: -1, maxZoom: most, zoomControl: false, attributionControl: false, wheelPxPerZoomLevel: 80,
      fadeAnimation: false, maxBounds: this.bounds.pad(1.5), maxBoundsViscosity: 0.6,
    });
    L.control.zoom({ position: "topleft" }).addTo(this.map);
    L.control.scale({ position: "bottomleft", imperial: false, maxWidth: 140 }).addTo(this.map);
    this.addNorth();
    const own = this;
    const Tiles = L.GridLayer.extend({
      createTile(coords) {
        const ratio = Math.min(3, window.devicePixelRatio || 1);
        const tile = el("canvas", { width: TILE * ratio, height: TILE * ratio });
        drawTile(tile.getContext("2d"), data, viewOf(coords, own.scale(coords.z), ratio), own.look);
        return tile;
      },
    });
    this.tiles = new Tiles({ tileSize: TILE, noWrap: true, minZoom: -1, maxZoom: most, keepBuffer: 1, updateWhenZooming: false });
    this.pick = L.polygon([], { color: "#d6007f", weight: 2.5, fill: true, fillOpacity: 0.06, interactive: false });
    this.spot = L.circleMarker([0, 0], { radius: 6, color: "#ffffff", weight: 2, fillColor: "#d6007f", fillOpacity: 1, interactive: false });
    this.map.on("mousemove", (event) => this.actions.hover(event.latlng.lng, event.latlng.lat));
    this.map.on("mouseout", () => this.actions.hover(NaN, NaN));
    this.rings = L.layerGroup().addTo(this.map);
    this.ends = L.layerGroup().addTo(this.map);
    this.map.on("click", (event) => this.click(event.latlng.lng, event.latlng.lat, event.originalEvent.shiftKey));
    this.map.setView(this.bounds.getCenter(), 0, { animate: false });
  }

  addNorth() {
    const control = L.control({ position: "topleft" });
    control.onAdd = () => {
      const box = el("div", { class: "north", role: "img", "aria-label": "North is up" });
      const make = (tag, attributes, text) => {
        const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
        for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
        if (text) node.textContent = text;
        return node;
      };
      const svg = make("svg", { viewBox: "0 0 34 44", width: 34, height: 44 });
      svg.append(make("path", { d: "M17 3 L25 27 L17 22 L9 27 Z", fill: "currentColor", stroke: "none" }),
        make("text", { x: 17, y: 41, "text-anchor": "middle", "font-size": 13, "font-weight": 700, fill: "currentColor" }, "N"));
      box.append(svg);
      return box;
    };
    control.addTo(this.map);
  }

  /** Use new colours, and redraw. */
  show(look) {
    this.look = look;
    if (this.map.hasLayer(this.tiles)) this.tiles.redraw();
    else this.tiles.addTo(this.map);
  }

  click(x, y, shift) {
    if (this.actions.routeClick(x, y, shift)) return;
    const pixel = this.pixel();
    const signal = this.signalAt(x, y, pixel);
    const finding = this.look.layers.findings ? this.findingAt(x, y - 10 * pixel, 11 * pixel) : -1;
    const found = nearest(this.data, x, y, 10 * pixel);
    const junction = pixel > 0.8 || pixel < 0.06 || !this.look.layers.junctions ? -1 : this.junctionAt(x, y, 6 * pixel);
    if (finding >= 0) this.actions.openFinding(finding);
    else if (signal >= 0) this.actions.openSignal(signal);
    else if (junction >= 0) this.actions.openJunction(junction);
    else if (found) this.actions.openRoad(found.road, between(this.data.s, found));
    else this.actions.close();
  }

  /** Return the signal at a place; -1 without one, or where signals are not shown. */
  signalAt(x, y, pixel) {
    if (!this.look.layers.signals || pixel * this.data.info.drawing.furniture_from > 1) return -1;
    let best = -1, least = Math.max(symbolSize(this.data, pixel), 6 * pixel);
    this.data.info.signals.forEach(([, u, v], k) => {
      const far = Math.hypot(u - x, v - y);
      if (far <= least) { best = k; least = far; }
    });
    return best;
  }

  /** Mark signals: the first one is the one that was chosen. */
  highlight(signals) {
    this.rings.clearLayers();
    [...signals].reverse().forEach((k) => {
      const [, x, y] = this.data.info.signals[k], chosen = k === signals[0];
      L.circleMarker([y, x], { radius: chosen ? 15 : 12, weight: 3, color: chosen ? "#d6007f" : "#00b7c7", fill: false, interactive: false }).addTo(this.rings);
    });
  }

  /** Mark the ends of a route. */
  markEnds(places) {
    this.ends.clearLayers();
    places.forEach(([x, y], k) => L.marker([y, x], { interactive: false, keyboard: false, icon: L.divIcon({ className: "end", html: "", iconSize: [20, 20] }) })
      .addTo(this.ends).getElement().append("AB"[k]));
  }

  junctionAt(x, y, reach) {
    const at = this.data.info.junctions;
    return at.x.findIndex((value, k) => value !== null && Math.hypot(value - x, at.y[k] - y) <= reach);
  }

  findingAt(x, y, reach) {
    let best = -1, least = reach;
    this.data.info.findings.forEach((finding, k) => {
      const far = finding[5] === null ? Infinity : Math.hypot(finding[5] - x, finding[6] - y);
      if (far <= least) { best = k; least = far; }
    });
    return best;
  }

  /** Mark the pieces of a path, and move there if they are out of view or if asked to. */
  select(pieces, move) {
    const flat = (line) => line.map(([x, y]) => [y, x]);
    const areas = pieces.map((piece) => flat(edgeOf(this.data, piece, 0)).concat(flat(edgeOf(this.data, piece, 1)).reverse())).filter((area) => area.length > 2);
    if (!areas.length) { this.pick.remove(); if (!pieces.length) this.mark(NaN, NaN); return; }
    this.pick.setLatLngs(areas.map((area) => [area])).addTo(this.map);
    const bounds = this.pick.getBounds();
    if (move || !this.map.getBounds().intersects(bounds)) this.fit(bounds);
  }

  fitAll() {
    this.map.invalidateSize({ pan: false });
    this.map.fitBounds(this.bounds, { padding: [20, 20], animate: false });
  }

  fit(bounds) {
    const most = Math.round(Math.log2(16 / this.scale(0)));
    this.map.fitBounds(bounds.pad(0.2), { maxZoom: Math.max(0, most), padding: [30, 30] });
  }

  /** Return the size of a pixel, m. */
  pixel() {
    return 1 / this.scale(this.map.getZoom());
  }

  /** Move to a place. */
  go(x, y) {
    this.map.setView([y, x], Math.max(this.map.getZoom(), Math.min(this.map.getMaxZoom(), Math.round(Math.log2(8 / this.scale(0))))));
    this.mark(x, y);
  }

  mark(x, y) {
    if (Number.isFinite(x)) this.spot.setLatLng([y, x]).addTo(this.map);
    else this.spot.remove();
  }
}
