// Details of a signal and of a route, for the panel.

/** Return the controllers of a signal, each with its row. */
function controllersOf(info, signal) {
  return info.controllers.filter((controller) => controller[2].includes(signal));
}

/** Return a signal and all others of its controllers. */
function fellowsOf(info, signal) {
  return signal < 0 ? [] : Array.from(new Set([signal, ...controllersOf(info, signal).flatMap((controller) => controller[2])]));
}

function signalName(info, signal) {
  const of = Object.fromEntries(info.signals[signal][9]);
  return `${of.id || "–"}${of.name ? ` ${of.name}` : ""}${of.type ? `, type ${of.type}` : ""}`;
}

function signalPage(panel, signal) {
  const { data, actions } = panel, info = data.info;
  const [road, x, y, z, heading, , , isLight, , attributes, referring] = info.signals[signal];
  const degrees = geographic(info, x, y), button = (k) => el("button", { type: "button", class: "link", onclick: () => actions.openSignal(k, true) }, signalName(info, k));
  const rows = [["road", panel.roadLink(road)], ["x, y", `${fix(x + info.origin[0], 2)}, ${fix(y + info.origin[1], 2)} m`], ["height of the road", `${fix(z, 2)} m`]];
  if (degrees) rows.push(["latitude, longitude", `${degrees[1].toFixed(6)}, ${degrees[0].toFixed(6)}°`]);
  if (heading !== null) rows.push(["faces", `${fix((450 - (heading * 180) / Math.PI) % 360, 0)}° from north`]);
  if (referring.length) rows.push(["holds on", el("span", {}, ...referring.flatMap((other, k) => [k ? ", " : "", panel.roadLink(other)]))]);
  const controllers = controllersOf(info, signal).map(([id, name, members, junctions]) => el("div", { class: "controller" },
    pairs([["controller", `${id}${name ? ` ${name}` : ""}`], ...junctions.filter((k) => k >= 0).map((k) => ["junction", panel.junctionLink(k)])]),
    el("ul", {}, ...members.filter((k) => k !== signal).map((k) => el("li", {}, button(k), " on road ", panel.roadLink(info.signals[k][0]))))));
  return [
    el("h2", {}, `${isLight ? "Traffic light" : "Sign"} ${signalName(info, signal)}`), pairs(attributes), pairs(rows),
    el("h2", {}, "Controller"), ...(controllers.length ? controllers : [el("p", { class: "quiet" }, "None controls it.")]),
  ];
}

function routePage(panel, pieces) {
  const data = panel.data, path = along(data, pieces, true);
  let up = 0, down = 0, steepest = 0;
  path.z.forEach((z, k) => {
    const rise = k && Number.isFinite(z - path.z[k - 1]) ? z - path.z[k - 1] : 0;
    if (rise > 0) up += rise; else down -= rise;
    steepest = Math.max(steepest, Math.abs(path.grade[k]) || 0);
  });
  const inside = pieces.filter(({ road }) => data.roadJunction[road] >= 0).length;
  return [
    el("h2", {}, "Route"),
    pairs([["length", `${fix(path.length, 1)} m`], ["roads", `${pieces.length - inside} and ${inside} through junctions`], ["climb", `${fix(up, 1)} m`], ["descent", `${fix(down, 1)} m`], ["steepest", `${fix(100 * steepest, 1)} %`]]),
    el("table", {}, el("thead", {}, el("tr", {}, ...["at m", "road", "m", ""].map((text, k) => el("th", { scope: "col", class: k % 2 ? "" : "n" }, text)))),
      el("tbody", {}, ...pieces.map(({ road, from, to }, k) => el("tr", {}, el("td", { class: "n" }, fix(path.begins[k], 0)), el("td", {}, panel.roadLink(road, null, from)),
        el("td", { class: "n" }, fix(Math.abs(to - from), 1)), el("td", {}, data.roadJunction[road] >= 0 ? "in a junction" : ""))))),
    el("p", { class: "quiet" }, "The shortest way along lanes that cars drive on, in the direction of traffic."),
  ];
}
