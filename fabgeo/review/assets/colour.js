// Data of the page, and colours of parts by class, figure or verdict.
const $ = (id) => document.getElementById(id);
const DATA = JSON.parse($("data").textContent);
const el = (tag, attributes = {}, ...children) => {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in node && key !== "list") node[key] = value; else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
};

// A column is a list, or its words and every row's place among them.
for (const table of Object.values(DATA.tables)) {
  const columns = table.values.map((own) => (Array.isArray(own) ? own : own.at.map((k) => own.words[k])));
  table.rows = columns[0].map((_, row) => columns.map((own) => own[row]));
}
const FLATS = new Map(DATA.flats.map((mark, number) => [mark, number]));

// Rows by mark: {table, values by column name}
const ROWS = new Map();
for (const [table, { columns, rows }] of Object.entries(DATA.tables)) {
  if (!["panels", "plates", "beams", "connectors"].includes(table)) continue;
  const names = columns.map((c) => c[0]);
  rows.forEach((row) => {
    const values = Object.fromEntries(names.map((name, k) => [name, row[k]]));
    ROWS.set(String(values.mark), { table, values });
  });
}

const MODES = {
  class: "class", verdict: "verdict", surface_deviation_mm: "deviation from the surface, mm",
  fit_deviation_mm: "deviation of the class fit, mm", kink_max_deg: "kink, degrees",
  gap_max_mm: "gap, mm", twist_max_deg: "twist, degrees", radius_min_mm: "smallest radius, mm",
  mass_kg: "mass, kg", forming: "forming", erection_order: "erection order",
};
const WORDS = ["class", "verdict", "forming"];
const panelValues = (key) => (DATA.tables.panels?.rows ?? []).map((row) => {
  const at = DATA.tables.panels.columns.findIndex((c) => c[0] === key);
  return row[at];
});

function colouring(mode) {
  if (WORDS.includes(mode)) {
    const known = mode === "class" ? DATA.classes : mode === "verdict" ? DATA.verdicts : {};
    const spare = ["#56b4e9", "#e69f00", "#cc79a7", "#009e73", "#0072b2"];
    const names = [...new Set(panelValues(mode).filter((v) => v != null && v !== ""))].sort();
    const colours = new Map(names.map((n, k) => [n, known[n] ?? spare[k % spare.length]]));
    return { words: colours, colour: (row) => colours.get(row?.[mode]) ?? "#9aa4ab" };
  }
  const numbers = panelValues(mode).filter((v) => typeof v === "number");
  const low = Math.min(...numbers), high = Math.max(...numbers);
  const span = high - low || 1;
  return {
    low, high,
    colour: (row) => typeof row?.[mode] === "number" ? ramp((row[mode] - low) / span) : "#9aa4ab",
  };
}

function ramp(t) {
  const table = DATA.cividis, x = Math.min(Math.max(t, 0), 1) * (table.length - 1);
  const k = Math.min(Math.floor(x), table.length - 2), f = x - k;
  const mix = (at) => Math.round(parseInt(table[k].slice(at, at + 2), 16) * (1 - f)
    + parseInt(table[k + 1].slice(at, at + 2), 16) * f);
  return "#" + [1, 3, 5].map((at) => mix(at).toString(16).padStart(2, "0")).join("");
}

function legend(mode, scheme) {
  const box = $("legend");
  box.replaceChildren(el("b", { textContent: MODES[mode] }));
  if (scheme.words) {
    const counts = new Map();
    panelValues(mode).forEach((v) => counts.set(v, (counts.get(v) ?? 0) + 1));
    for (const [name, colour] of scheme.words) {
      const swatch = el("i");
      swatch.style.background = colour;
      const sign = mode === "verdict" ? DATA.signs[name] + " " : "";
      box.append(el("div", {}, swatch, `${sign}${name} (${counts.get(name)})`));
    }
    return;
  }
  const strip = el("canvas", { width: 190, height: 1 });
  const pen = strip.getContext("2d");
  for (let x = 0; x < 190; x++) { pen.fillStyle = ramp(x / 189); pen.fillRect(x, 0, 1, 1); }
  const short = (v) => Number.isFinite(v) ? String(Number(v.toPrecision(4))) : "–";
  box.append(strip, el("div", { className: "ends" },
    el("span", { textContent: short(scheme.low) }), el("span", { textContent: short(scheme.high) })));
}
