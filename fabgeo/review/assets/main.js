// Wiring: one selection for the model, the tables, the sheets and the still picture.
let view = null, tables = null, selected = null;

function pick(mark, fly = false) {
  const sheet = !ROWS.has(mark) && [...document.querySelectorAll(".sheet")].find((f) => f.dataset.sheet.endsWith(`/${mark}`));
  if (sheet) { sheet.scrollIntoView({ block: "center" }); return; }
  selected = mark;
  showDetail(mark);
  tables.select(mark);
  recolour();
  if (fly && view) view.fly(mark);
  document.querySelectorAll("#sheets use.on").forEach((node) => node.classList.remove("on"));
  document.querySelectorAll(`#sheets use[data-mark="${CSS.escape(mark)}"]`).forEach((node) => node.classList.add("on"));
  document.body.dataset.selected = mark;
}

function recolour() {
  const mode = $("colour").value, scheme = colouring(mode);
  legend(mode, scheme);
  if (view) view.colour(scheme, selected);
  else colourStill();
}

// The still picture: shown without WebGL and on paper.
function colourStill() {
  const scheme = colouring($("colour").value);
  document.querySelectorAll("#still path").forEach((node) => {
    const row = ROWS.get(node.dataset.mark)?.values, shade = Number(node.dataset.shade);
    const base = scheme.colour(row);
    const part = [1, 3, 5].map((at) => Math.round(parseInt(base.slice(at, at + 2), 16) * shade));
    node.style.fill = `rgb(${part})`;
    node.classList.toggle("on", node.dataset.mark === selected);
  });
}

function modes() {
  for (const [key, label] of Object.entries(MODES)) {
    if (panelValues(key).some((v) => v != null && v !== "")) $("colour").append(el("option", { value: key, textContent: label }));
  }
  if (!$("colour").options.length) $("colour").append(el("option", { value: "verdict", textContent: "verdict" }));
  $("colour").addEventListener("input", recolour);
}

function layers() {
  for (const name of view.layers.keys()) {
    const box = el("input", { type: "checkbox", checked: name === "panels" || !view.layers.has("panels"), id: `layer-${name}` });
    box.addEventListener("input", () => view.show(name, box.checked));
    $("layers").append(el("label", {}, box, ` ${name}`));
    view.show(name, box.checked);
  }
}

function start3d() {
  try {
    view = new View($("view"), (mark) => pick(mark));
    layers();
    $("axis").addEventListener("input", () => view.section($("axis").value, $("cut").value / 1000));
    $("cut").addEventListener("input", () => view.section($("axis").value, $("cut").value / 1000));
    $("explode").addEventListener("input", () => view.explode($("explode").value / 100));
    $("fit").addEventListener("click", () => view.fit());
  } catch (error) {
    view = null;
    $("view").replaceChildren();
    document.body.classList.add("flat-picture");
    $("layers").textContent = "Still picture: this browser offers no WebGL.";
    for (const id of ["axis", "cut", "explode", "fit"]) $(id).disabled = true;
  }
}

function theme() {
  const dark = getComputedStyle(document.documentElement).colorScheme.includes("dark");
  document.documentElement.dataset.theme = dark ? "light" : "dark";
  if (view) view.draw();
}

for (const use of document.querySelectorAll("#sheets use")) use.dataset.mark = DATA.flats[use.getAttribute("href").slice(2)];
tables = new Tables(pick);
modes();
start3d();
recolour();
$("theme").addEventListener("click", theme);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view?.draw());
$("print").addEventListener("click", () => window.print());
window.addEventListener("beforeprint", () => { tables.more(tables.rows.length); colourStill(); });
$("search").addEventListener("input", (e) => {
  const text = e.target.value.trim().toUpperCase();
  const mark = text && (ROWS.has(text) ? text : [...ROWS.keys()].find((m) => m.toUpperCase().startsWith(text)));
  if (mark) pick(mark, true);
});
document.addEventListener("click", (e) => {
  const link = e.target.closest("button.mark[data-mark], #still path[data-mark], #sheets use[data-mark]");
  if (link) pick(link.dataset.mark, !link.closest("svg"));
  const tile = e.target.closest(".tile");
  if (tile) { $("verdict").value = tile.dataset.verdict; tables.render(); $("tables").scrollIntoView(); }
});
document.addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT)$/.test(e.target.tagName)) return;
  if (e.key === "n") tables.step(1);
  if (e.key === "b") tables.step(-1);
  if (e.key === "f" && view) view.fit();
  if (e.key === "/") { e.preventDefault(); $("search").focus(); }
});
document.body.dataset.ready = "yes";
