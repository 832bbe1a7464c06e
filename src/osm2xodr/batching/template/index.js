"use strict";
(() => {
  const $ = (id) => document.getElementById(id), svg = $("map"), body = $("table").tBodies[0];
  const rows = Array.from(body.rows), areas = rows.map((row) => $(row.id.replace("a", "m")));
  const heads = Array.from($("table").tHead.rows[0].cells);
  const words = ["failed", "empty", "done", "unchanged"], data = svg.dataset;
  const home = svg.viewBox.baseVal, whole = { x: home.x, y: home.y, w: home.width, h: home.height };
  const names = rows.map((row) => row.cells[0].textContent), RADIUS = 6378137, FIGURES = 12;
  const boxes = areas.map((area) => area && middle(area));
  const STEP = 100;
  let view = { ...whole }, chosen = -1, order = rows.map((_, i) => i), limit = STEP;

  // Where an area is: from the numbers of its path, without waiting for the layout.
  function middle(area) {
    const path = area.querySelector("path"), sign = area.querySelector("g");
    area.signed = sign !== null;
    const numbers = (path ? path.getAttribute("d") : sign.getAttribute("transform")).match(/-?[\d.]+/g).map(Number);
    const xs = numbers.filter((_, k) => k % 2 === 0), ys = numbers.filter((_, k) => k % 2);
    const [x0, x1] = range(xs), [y0, y1] = range(ys);
    return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, w: x1 - x0, h: y1 - y0 };
  }
  function range(values) {
    return values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  }
  // The cell of a row under a heading; in rows without figures one cell stands for all of them.
  function cell(row, column) {
    const short = row.cells.length < heads.length;
    if (!short || column < 3) return row.cells[column];
    return column < 3 + FIGURES ? null : row.cells[column - FIGURES];
  }

  // The map: the view is a part of the drawing, extended to the shape of the window.
  function size() { return { w: svg.clientWidth || 1, h: svg.clientHeight || 1 }; }
  function perPixel() { const s = size(); return Math.max(view.w / s.w, view.h / s.h); }
  function draw() {
    if (!svg.clientWidth) return;
    const s = size(), k = perPixel(), w = k * s.w, h = k * s.h;
    view = { x: view.x + (view.w - w) / 2, y: view.y + (view.h - h) / 2, w, h };
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${w} ${h}`);
    svg.style.setProperty("--k", k);
    for (const name of ["p-unchanged", "p-empty"]) $(name).setAttribute("patternTransform", `scale(${k})`);
    scale(k);
    grid(k);
    labels(k);
  }
  function zoom(factor, x = view.x + view.w / 2, y = view.y + view.h / 2) {
    const w = Math.min(Math.max(view.w / factor, whole.w / 1e5), whole.w * 4), f = w / view.w;
    view = { x: x - (x - view.x) * f, y: y - (y - view.y) * f, w, h: view.h * f };
    draw();
  }
  function all() { view = { ...whole }; draw(); }
  function place(event) {
    const r = svg.getBoundingClientRect(), k = perPixel();
    return [view.x + (event.clientX - r.left) * k, view.y + (event.clientY - r.top) * k];
  }
  function degrees(x, y) {
    const lon = (+data.left + x * data.unit) / RADIUS, lat = Math.atan(Math.sinh((data.top - y * data.unit) / RADIUS));
    return [lat * 180 / Math.PI, lon * 180 / Math.PI];
  }
  function scale(k) {
    const lat = degrees(0, view.y + view.h / 2)[0], metres = k * data.unit * Math.cos(lat * Math.PI / 180);
    const step = [5, 2, 1].map((f) => f * 10 ** Math.floor(Math.log10(metres * 140))).find((m) => m / metres <= 140);
    $("scale").firstChild.style.width = `${step / metres}px`;
    if ($("scale").childNodes.length > 1) $("scale").lastChild.remove();
    $("scale").append(step >= 1000 ? `${step / 1000} km` : `${step} m`);
  }
  // Meridians and parallels at round intervals, with their degrees at the left and lower edges.
  function grid(k) {
    const [north, west] = degrees(view.x, view.y), [south, east] = degrees(view.x + view.w, view.y + view.h);
    const step = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60].find((d) => (east - west) / d < view.w / k / 110) || 90;
    const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)), lines = [], group = $("grid");
    group.replaceChildren();
    const line = (value, sides, x, y) => {
      const v = Math.round(value / step) * step, size = Math.abs(v).toFixed(digits);
      text(group, "degree", `${size}°${+size && +size !== 180 ? sides[v > 0 ? 0 : 1] : ""}`, x, y, 10.5 * k);
    };
    for (let lon = Math.ceil(west / step) * step; lon < east; lon += step) {
      const x = (lon * Math.PI / 180 * RADIUS - data.left) / data.unit;
      lines.push(`M${x} ${view.y}v${view.h}`);
      line(((lon + 180) % 360 + 360) % 360 - 180, "EW", x + 3 * k, view.y + view.h - 6 * k);
    }
    for (let lat = Math.ceil(Math.max(south, -85) / step) * step; lat < Math.min(north, 85); lat += step) {
      const y = (data.top - Math.asinh(Math.tan(lat * Math.PI / 180)) * RADIUS) / data.unit;
      lines.push(`M${view.x} ${y}h${view.w}`);
      line(lat, "NS", view.x + 5 * k, y - 4 * k);
    }
    const path = document.createElementNS(svg.namespaceURI, "path");
    path.setAttribute("class", "grid");
    path.setAttribute("d", lines.join(""));
    group.prepend(path);
  }
  function text(parent, name, words, x, y, height) {
    const item = document.createElementNS(svg.namespaceURI, "text");
    for (const [key, value] of Object.entries({ class: name, x, y, "font-size": height })) item.setAttribute(key, value);
    item.textContent = words;
    parent.append(item);
    return item;
  }
  // Names are written into areas with room for them, and beside small ones where nothing is in the way.
  function labels(k) {
    const group = $("labels"), taken = [], todo = [];
    group.replaceChildren();
    boxes.forEach((box, i) => {
      if (!box || areas[i].classList.contains("out")) return;
      if (Math.abs(box.x - view.x - view.w / 2) > (view.w + box.w) / 2 || Math.abs(box.y - view.y - view.h / 2) > (view.h + box.h) / 2) return;
      const width = names[i].length * 7.2 * k, half = [Math.max(box.w / 2, 6 * k), Math.max(box.h / 2, 6 * k)];
      todo.push({ i, box, width, half, inside: width < box.w && box.h > (areas[i].signed ? 42 : 16) * k });
    });
    const fitting = todo.filter((item) => item.inside).slice(0, 500), beside = todo.length > 120 ? [] : todo.filter((item) => !item.inside);
    for (const { i, box } of fitting) put(i, box.x, box.y + (areas[i].signed ? 17 : 4) * k, "middle");
    const free = (at) => at.x0 > view.x && at.x1 < view.x + view.w && at.y0 > view.y && at.y1 < view.y + view.h && !taken.some((o) => at.x0 < o.x1 && at.x1 > o.x0 && at.y0 < o.y1 && at.y1 > o.y0);
    for (const { box, half } of beside) taken.push({ x0: box.x - half[0], x1: box.x + half[0], y0: box.y - half[1], y1: box.y + half[1] });
    for (const { box } of fitting) taken.push({ x0: box.x - box.w / 2, x1: box.x + box.w / 2, y0: box.y - box.h / 2, y1: box.y + box.h / 2 });
    for (const { i, box, width, half } of beside) {
      const places = [
        { x0: box.x + half[0] + 3 * k, y0: box.y - 7 * k, anchor: "start" },
        { x0: box.x - width / 2, y0: box.y + half[1] + k, anchor: "middle" },
        { x0: box.x - width / 2, y0: box.y - half[1] - 15 * k, anchor: "middle" },
        { x0: box.x - half[0] - 3 * k - width, y0: box.y - 7 * k, anchor: "end" },
      ].map((at) => ({ ...at, x1: at.x0 + width, y1: at.y0 + 14 * k }));
      const at = places.find(free);
      if (!at) continue;
      taken.push(at);
      put(i, at.anchor === "start" ? at.x0 : at.anchor === "end" ? at.x1 : box.x, at.y0 + 11 * k, at.anchor);
    }
    function put(i, x, y, anchor) {
      const item = text(group, "label", names[i], x, y, 11.5 * k);
      item.setAttribute("text-anchor", anchor);
      item.setAttribute("stroke-width", 3 * k);
    }
  }

  // Choosing an area marks it on the map and in the table, and shows a card about it.
  function choose(i, move) {
    for (const item of [areas[chosen], rows[chosen]]) if (item) item.classList.remove("here");
    chosen = i;
    for (const item of [areas[i], rows[i]]) if (item) item.classList.add("here");
    $("card").hidden = i < 0;
    if (i < 0) return;
    describe(i);
    const box = boxes[i];
    if (!box || !move) return;
    const inside = box.x > view.x && box.x < view.x + view.w && box.y > view.y && box.y < view.y + view.h;
    if (!inside) { view.x = box.x - view.w / 2; view.y = box.y - view.h / 2; draw(); }
    aside(box);
  }
  // The card is on the side where the area is not.
  function aside(box) {
    $("card").classList.toggle("right", box.x - box.w / 2 < view.x + 350 * perPixel());
  }
  function element(name, text, of) {
    const item = document.createElement(name);
    item.textContent = text;
    of.append(item);
    return item;
  }
  function describe(i) {
    const counted = (text, what) => `${text} ${what}${text === "1" ? "" : "s"}`;
    const card = $("card"), cells = rows[i].cells, value = (k) => (cell(rows[i], k) || { textContent: "" }).textContent;
    card.replaceChildren();
    cells[0].querySelectorAll(".thumb").forEach((image) => card.append(image.cloneNode()));
    element("h3", names[i], card);
    const status = element("div", "", card), sign = document.createElementNS(svg.namespaceURI, "svg"), use = document.createElementNS(svg.namespaceURI, "use");
    sign.setAttribute("class", "sym");
    for (const [key, text] of Object.entries({ href: `#s-${value(1)}`, x: 7, y: 7 })) use.setAttribute(key, text);
    sign.append(use);
    status.append(sign, value(1));
    if (cells[2].colSpan > 1) element("p", cells[2].lastChild.textContent, card);
    const said = [];
    if (value(3)) said.push(`${value(3)} km in ${counted(value(4), "road")}, ${counted(value(5), "junction")}`);
    if (value(7)) said.push(`${value(7)} to ${value(8)} m high`);
    if (value(9)) said.push(`grades up to ${value(9)} %`);
    if (value(15)) said.push(`took ${value(15)} s`);
    if (said.length) element("p", said.join(" · "), card);
    const links = element("div", "", card);
    links.className = "links";
    cells[2].querySelectorAll("a").forEach((link) => links.append(link.cloneNode(true)));
    const row = element("a", "row in the table", links);
    row.href = `#${rows[i].id}`;
    if (boxes[i]) {
      const [lat, lon] = degrees(boxes[i].x, boxes[i].y).map((d, k) => (k ? ((d + 540) % 360) - 180 : d).toFixed(5));
      const osm = element("a", "OpenStreetMap", links);
      osm.href = `https://www.openstreetmap.org/#map=14/${lat}/${lon}`;
      osm.rel = "noopener noreferrer";
      osm.target = "_blank";
    }
    const close = element("button", "×", card);
    close.type = "button";
    close.className = "close";
    close.setAttribute("aria-label", "Close");
    close.onclick = () => { choose(-1); svg.focus(); };
  }
  function show(i) {
    if (!matches[i]) { find.value = ""; pressed.clear(); filter(); }
    limit = Math.max(limit, order.filter((k) => matches[k]).indexOf(i) + STEP);
    reveal();
    choose(i, true);
    rows[i].scrollIntoView({ block: "center" });
    const link = rows[i].querySelector("a");
    if (link) link.focus({ preventScroll: true });
  }
  function neighbour(dx, dy) {
    const from = boxes[chosen];
    let best = -1, least = Infinity;
    boxes.forEach((box, i) => {
      if (!box || i === chosen || areas[i].classList.contains("out")) return;
      if (!from) { if (best < 0) best = i; return; }
      const ahead = (box.x - from.x) * dx + (box.y - from.y) * dy, aside = Math.abs((box.x - from.x) * dy - (box.y - from.y) * dx);
      if (ahead > 1e-6 && aside <= ahead * 1.5 && ahead + 2 * aside < least) { best = i; least = ahead + 2 * aside; }
    });
    if (best >= 0) choose(best, true);
  }

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  svg.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (arrows[event.key]) neighbour(...arrows[event.key]);
    else if (event.key === "+" || event.key === "=") zoom(1.5);
    else if (event.key === "-") zoom(1 / 1.5);
    else if (event.key === "0") all();
    else if (event.key === "Escape") choose(-1);
    else if (event.key === "Enter" && chosen >= 0) show(chosen);
    else return;
    event.preventDefault();
  });
  svg.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.002)), ...place(event));
  }, { passive: false });
  svg.addEventListener("dblclick", (event) => { event.preventDefault(); zoom(2, ...place(event)); });
  let grip = null, moved = false;
  svg.addEventListener("pointerdown", (event) => { if (event.button === 0) { grip = place(event); moved = false; } });
  window.addEventListener("pointermove", (event) => {
    if (!grip) return;
    const [x, y] = place(event), k = perPixel();
    if (!moved && Math.hypot(x - grip[0], y - grip[1]) < 4 * k) return;
    moved = true;
    svg.classList.add("moving");
    view.x += grip[0] - x;
    view.y += grip[1] - y;
    draw();
  });
  window.addEventListener("pointerup", () => { grip = null; svg.classList.remove("moving"); });
  window.addEventListener("pointercancel", () => { grip = null; svg.classList.remove("moving"); });
  svg.addEventListener("dragstart", (event) => event.preventDefault());
  svg.addEventListener("click", (event) => {
    const area = event.target.closest("a");
    if (area) event.preventDefault();
    if (!moved) { choose(area ? areas.indexOf(area) : -1, true); svg.focus({ preventScroll: true }); }
  });
  $("zoom-in").onclick = () => zoom(1.5);
  $("zoom-out").onclick = () => zoom(1 / 1.5);
  $("zoom-all").onclick = all;
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='#a']");
    if (!link || svg.contains(link)) return;
    event.preventDefault();
    const i = rows.indexOf($(link.hash.slice(1)));
    if (link.closest("#failures")) choose(i, true); else show(i);
  });
  body.addEventListener("click", (event) => {
    const row = event.target.closest("tr");
    if (row && !event.target.closest("a")) choose(rows.indexOf(row), true);
  });

  // What is shown: areas of the pressed statuses (all, if none is pressed) that match the search.
  const find = $("find"), pressed = new Set(), texts = rows.map((row, i) => `${names[i]} ${row.cells[2].colSpan > 1 ? row.cells[2].textContent : ""}`.toLowerCase());
  let matches = rows.map(() => true);
  // Rows are laid out when they come near: thousands at once take long.
  function reveal() {
    let rank = 0;
    for (const i of order) rows[i].hidden = !(matches[i] && rank++ < limit);
    $("more").hidden = rank <= limit;
  }
  function filter() {
    const wanted = find.value.toLowerCase().trim();
    matches = rows.map((row, i) => (!pressed.size || pressed.has(row.className.split(" ")[0])) && texts[i].includes(wanted));
    areas.forEach((area, i) => { if (area) area.classList.toggle("out", !matches[i]); });
    limit = STEP;
    reveal();
    const count = matches.filter(Boolean).length;
    document.querySelectorAll("#statuses button").forEach((button) => button.setAttribute("aria-pressed", String(pressed.has(button.dataset.status))));
    $("shown").textContent = count === rows.length ? "" : `${count.toLocaleString("en")} of ${rows.length.toLocaleString("en")}`;
    $("clear").hidden = count === rows.length;
    labels(perPixel());
  }
  find.addEventListener("input", filter);
  $("clear").onclick = () => { find.value = ""; pressed.clear(); filter(); find.focus(); };
  document.querySelectorAll("#statuses button").forEach((button) => {
    button.onclick = () => {
      const word = button.dataset.status;
      if (!pressed.delete(word)) pressed.add(word);
      filter();
    };
  });

  // Order: names by the value of numbers in them, statuses the worst first, numbers the largest first, unknown ones last.
  const collator = new Intl.Collator("en", { numeric: true, sensitivity: "base" });
  function keys(column) {
    return rows.map((row, i) => {
      if (column === 0) return names[i];
      const found = cell(row, column), said = found ? found.textContent : "";
      return column === 1 ? words.indexOf(said) : parseFloat(said.replace(/,/g, ""));
    });
  }
  function sort(column, down) {
    const key = keys(column), sign = down ? -1 : 1;
    const compare = (a, b) => {
      if (column === 0) return sign * collator.compare(key[a], key[b]);
      if (Number.isNaN(key[a]) || Number.isNaN(key[b])) return Number.isNaN(key[a]) - Number.isNaN(key[b]);
      return sign * (key[a] - key[b]);
    };
    order = rows.map((_, i) => i).sort((a, b) => compare(a, b) || a - b);
    heads.forEach((head) => head.removeAttribute("aria-sort"));
    heads[column].setAttribute("aria-sort", down ? "descending" : "ascending");
    limit = STEP;
    body.append(...order.map((i) => rows[i]));
    reveal();
  }
  heads.forEach((head, column) => {
    const button = head.querySelector("button");
    if (!button) return;
    button.onclick = () => {
      const now = head.getAttribute("aria-sort");
      sort(column, now ? now === "ascending" : head.className === "n");
    };
  });

  const observer = new IntersectionObserver((entries) => {
    if (!entries[entries.length - 1].isIntersecting) return;
    limit += 2 * STEP;
    reveal();
    // Reports again if it is still in view.
    observer.unobserve($("more"));
    observer.observe($("more"));
  }, { root: document.querySelector(".scroll"), rootMargin: "600px" });
  svg.tabIndex = 0;
  document.querySelectorAll(".bar, .zoom, #scale, #hint").forEach((item) => { item.hidden = false; });
  reveal();
  document.documentElement.className = "";
  new ResizeObserver(draw).observe(svg);
  draw();
  const asked = rows.indexOf($(location.hash.slice(1)));
  if (asked >= 0) choose(asked, true);
  observer.observe($("more"));
  document.documentElement.dataset.ready = "true";
})();
