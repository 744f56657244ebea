// The schedules: sort, filter, search; rows are made as they scroll into sight.
const MAIN = {
  panels: ["mark", "class", "radius_min_mm", "fit_deviation_mm", "surface_deviation_mm", "kink_max_deg", "gap_max_mm", "twist_max_deg", "material", "thickness_mm", "area_m2", "mass_kg", "sheet", "forming", "verdict", "reason"],
  plates: ["mark", "parent", "role", "length_mm", "width_mm", "thickness_mm", "area_m2", "mass_kg", "material", "radius_min_mm", "camber_mm", "sheet", "verdict"],
};
const CHUNK = 120;

class Tables {
  constructor(onPick) {
    this.onPick = onPick;
    this.names = Object.keys(DATA.tables);
    this.name = this.names[0];
    this.sort = null;
    this.names.forEach((name) => {
      const tab = el("button", { textContent: `${name} (${DATA.tables[name].rows.length})`, id: `tab-${name}` });
      tab.setAttribute("role", "tab");
      tab.addEventListener("click", () => this.open(name));
      $("tabs").append(tab);
    });
    for (const id of ["filter", "verdict", "all"]) $(id).addEventListener("input", () => this.render());
    $("grid").addEventListener("scroll", () => this.more());
    $("grid").addEventListener("click", (e) => {
      const row = e.target.closest("tr[data-mark]");
      if (row) this.onPick(row.dataset.mark, true);
    });
    $("grid").addEventListener("keydown", (e) => {
      const step = { ArrowDown: 1, ArrowUp: -1 }[e.key];
      if (step) { e.preventDefault(); this.step(step); }
      if (e.key === "Enter" && this.selected) this.onPick(this.selected, true);
    });
    this.render();
  }

  open(name) { this.name = name; this.sort = null; this.render(); }

  columns() {
    const { columns } = DATA.tables[this.name], main = MAIN[this.name];
    const every = columns.map((c, at) => ({ name: c[0], unit: c[1], decimals: c[2], at }));
    if ($("all").checked || !main) return every;
    return main.map((name) => every.find((c) => c.name === name));
  }

  // Words must all be found; name=text, name>number and name<number ask one column.
  test(words) {
    const at = Object.fromEntries(DATA.tables[this.name].columns.map((c, k) => [c[0], k]));
    const find = (key) => at[key] ?? at[Object.keys(at).find((name) => name.startsWith(key))];
    return words.toLowerCase().split(/[\s,]+/).filter(Boolean).map((word) => {
      const [, key, sign, text] = /^([a-z_0-9]+)([=<>])(.+)$/.exec(word) ?? [];
      const column = key && find(key);
      if (column === undefined || !key) return (row) => row.some((v) => v != null && String(v).toLowerCase().includes(word));
      if (sign === "=") return (row) => String(row[column] ?? "").toLowerCase() === text;
      return (row) => typeof row[column] === "number" && (sign === ">" ? row[column] > Number(text) : row[column] < Number(text));
    });
  }

  render() {
    const { columns, rows } = DATA.tables[this.name], tests = this.test($("filter").value);
    const verdictAt = columns.findIndex((c) => c[0] === "verdict"), wanted = $("verdict").value;
    this.rows = rows.filter((row) => tests.every((t) => t(row)) && (!wanted || verdictAt < 0 || row[verdictAt] === wanted));
    if (this.sort) {
      const { at, down } = this.sort, sign = down ? -1 : 1;
      this.rows.sort((a, b) => (a[at] == null) - (b[at] == null) || sign * (typeof a[at] === "number" && typeof b[at] === "number" ? a[at] - b[at] : String(a[at]).localeCompare(String(b[at]), "en", { numeric: true })));
    }
    this.shown = this.columns();
    const head = el("tr");
    for (const c of this.shown) {
      const label = c.name.replace(/_(mm|deg|m2|kg)$/, "").replaceAll("_", " ");
      const button = el("button", {}, label, c.unit ? el("small", { textContent: ` ${c.unit}` }) : "", this.sort?.at === c.at ? (this.sort.down ? " ▼" : " ▲") : "");
      button.addEventListener("click", () => { this.sort = { at: c.at, down: this.sort?.at === c.at && !this.sort.down }; this.render(); });
      const cell = el("th", { className: c.decimals == null ? "" : "n", scope: "col" }, button);
      cell.setAttribute("aria-sort", this.sort?.at === c.at ? (this.sort.down ? "descending" : "ascending") : "none");
      head.append(cell);
    }
    this.body = el("tbody");
    $("grid").replaceChildren(el("table", {}, el("thead", {}, head), this.body));
    $("grid").scrollTop = 0;
    this.more();
    $("count").textContent = `${this.rows.length} of ${rows.length}`;
    for (const name of this.names) $(`tab-${name}`).setAttribute("aria-selected", String(name === this.name));
  }

  more(until = 0) {
    const grid = $("grid");
    while (this.body.childElementCount < this.rows.length && (this.body.childElementCount < until
      || grid.scrollTop + 2 * grid.clientHeight + 200 > this.body.offsetHeight)) {
      const from = this.body.childElementCount;
      this.body.append(...this.rows.slice(from, from + CHUNK).map((row) => this.row(row)));
    }
  }

  row(row) {
    const line = el("tr"), mark = String(row[0]);
    line.dataset.mark = mark;
    if (mark === this.selected) line.className = "on";
    for (const c of this.shown) {
      const value = row[c.at];
      const text = value == null ? "" : typeof value === "number" && c.decimals ? value.toFixed(c.decimals) : String(value);
      const cell = el("td", { className: c.name === "verdict" ? text : c.decimals == null ? "" : "n" });
      cell.textContent = c.name === "verdict" && text ? `${DATA.signs[text] ?? ""} ${text}` : text;
      if (text.length > 40) cell.title = text;
      line.append(cell);
    }
    return line;
  }

  select(mark) {
    this.selected = mark;
    const table = ROWS.get(mark)?.table;
    if (table && table !== this.name) this.open(table);
    let at = this.rows.findIndex((row) => String(row[0]) === mark);
    if (at < 0 && table) { $("filter").value = ""; $("verdict").value = ""; this.render(); at = this.rows.findIndex((row) => String(row[0]) === mark); }
    this.body.querySelectorAll(".on").forEach((line) => line.classList.remove("on"));
    if (at < 0) return;
    this.more(at + 1);
    const line = this.body.children[at], grid = $("grid");
    line.classList.add("on");
    const top = line.offsetTop - 40;
    if (top < grid.scrollTop || line.offsetTop + 30 > grid.scrollTop + grid.clientHeight) grid.scrollTop = Math.max(top - grid.clientHeight / 3, 0);
  }

  step(way) {
    const at = this.rows.findIndex((row) => String(row[0]) === this.selected);
    const next = this.rows[Math.min(Math.max(at + way, 0), this.rows.length - 1)];
    if (next) this.onPick(String(next[0]), true);
  }
}
