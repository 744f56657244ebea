// What is known of one part: its verdict, its row, its flat outline and its sheet.
const SVG = "http://www.w3.org/2000/svg";
const svg = (tag, attributes = {}, ...children) => {
  const node = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};

function flatPicture(mark) {
  const number = FLATS.get(mark);
  if (number === undefined) return null;
  const [x0, y0, x1, y1] = $(`f${number}`).dataset.box.split(" ").map(Number);
  const pad = 0.03 * Math.max(x1 - x0, y1 - y0);
  const box = [x0 - pad, -y1 - pad, x1 - x0 + 2 * pad, y1 - y0 + 2 * pad].join(" ");
  const picture = svg("svg", { class: "flat", viewBox: box, role: "img" });
  const title = svg("title");
  title.textContent = `Flat outline of ${mark}`;
  picture.append(title, svg("use", { href: `#f${number}`, transform: "scale(0.1 -0.1)" }));
  return el("div", {}, el("h3", { textContent: `Flat part, ${(x1 - x0).toFixed(1)} x ${(y1 - y0).toFixed(1)} mm` }), picture);
}

function sheetPicture(mark) {
  const use = document.querySelector(`.sheet use[data-mark="${CSS.escape(mark)}"]`);
  if (!use) return null;
  const figure = use.closest("figure").cloneNode(true);
  figure.querySelectorAll("use.on").forEach((node) => node.classList.remove("on"));
  figure.querySelector(`use[data-mark="${CSS.escape(mark)}"]`).classList.add("on");
  return figure;
}

function showDetail(mark) {
  const found = ROWS.get(mark), box = $("detail");
  if (!found) { box.replaceChildren(el("p", { className: "note", textContent: `${mark} has no row` })); return; }
  const { values, table } = found, verdict = values.verdict;
  const title = el("h2", {}, mark);
  if (verdict) title.append(el("span", { className: `badge ${verdict}`, textContent: `${DATA.signs[verdict] ?? ""} ${verdict}` }));
  const list = el("dl");
  for (const [name, unit, decimals] of DATA.tables[table].columns) {
    const value = values[name];
    if (value == null || value === "" || ["mark", "verdict", "reason"].includes(name)) continue;
    const text = typeof value === "number" && decimals ? String(Number(value.toFixed(decimals))) : String(value);
    list.append(el("dt", { textContent: name.replace(/_(mm|deg|m2|kg)$/, "").replaceAll("_", " ") }), el("dd", { textContent: unit ? `${text} ${unit}` : text }));
  }
  const pieces = [title];
  if (values.reason) pieces.push(el("p", { textContent: values.reason }));
  pieces.push(...[flatPicture(mark), sheetPicture(mark)].filter(Boolean), list);
  const children = [...ROWS.entries()].filter(([, r]) => r.values.parent === mark || r.values.panel === mark || r.values.beam === mark).slice(0, 24);
  if (children.length) {
    const links = children.map(([own]) => el("button", { className: "mark", textContent: own, onclick: () => pick(own, true) }));
    pieces.push(el("h3", { textContent: "Belongs to it" }), el("p", {}, ...links));
  }
  box.replaceChildren(...pieces);
  box.scrollTop = 0;
}
