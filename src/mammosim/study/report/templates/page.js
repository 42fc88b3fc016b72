// What a page does beside being read: search, a larger figure, tables that sort, filter and download.
// Nothing of a table or a text becomes HTML: text nodes only, and DataTables is told to escape every cell.
"use strict";
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const one = (selector, root = document) => root.querySelector(selector);

function made(tag, text, more = {}) {
  return Object.assign(document.createElement(tag), { textContent: text }, more);
}

// ---- Search: over titles, texts and captions.
function searchable() {
  return all("main h2, main p, main figcaption").map((part, number) => {
    const holder = part.closest("figure") ?? part;
    holder.id ||= `text-${number}`;
    const text = part.textContent.replace(/\s+/g, " ").trim();
    return { id: holder.id, text, low: text.toLowerCase(), where: one("h2", part.closest("section"))?.textContent ?? "" };
  });
}

function snippet(entry, word) {
  const start = Math.max(0, entry.low.indexOf(word) - 30);
  return `${start ? "…" : ""}${entry.text.slice(start, start + 90)}…`;
}

function foundLink(entry, word) {
  const link = made("a", "", { href: `#${entry.id}` });
  link.append(made("span", entry.where), made("br", ""), made("small", snippet(entry, word)));
  return link;
}

function search(entries, input) {
  const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
  const hits = words.length ? entries.filter((entry) => words.every((word) => entry.low.includes(word))) : [];
  one("#found").replaceChildren(...hits.slice(0, 12).map((entry) => foundLink(entry, words[0])));
  one(".search output").textContent = words.length ? `${hits.length} found${hits.length > 12 ? ", the first 12" : ""}` : "";
}

function startSearch() {
  const input = one("#search");
  const entries = searchable();
  one(".search").hidden = false;
  input.addEventListener("input", () => search(entries, input));
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") one("#found a")?.click();
  });
}

// ---- A larger figure, at twice the size of print; arrows lead to the next one, Escape closes.
function startZoom() {
  const dialog = one("dialog.zoom");
  const links = all("a.enlarge");
  let now = 0;
  const show = (number) => {
    now = (number + links.length) % links.length;
    const small = one("img", links[now]);
    const width = Math.min(2 * Number(small.getAttribute("width")) || 900, 1800);
    Object.assign(one("img", dialog), { src: small.src, alt: small.alt, width });
    one("p", dialog).textContent = one("figcaption", links[now].closest("figure")).textContent.replace(/\[PNG.*?\]/, "");
    if (!dialog.open) dialog.showModal();
  };
  const acts = { close: () => dialog.close(), previous: () => show(now - 1), next: () => show(now + 1) };
  links.forEach((link, number) => link.addEventListener("click", (event) => {
    event.preventDefault();
    show(number);
  }));
  dialog.addEventListener("click", (event) => (event.target === dialog ? acts.close() : acts[event.target.dataset.do]?.()));
  dialog.addEventListener("keydown", (event) => ({ ArrowLeft: acts.previous, ArrowRight: acts.next })[event.key]?.());
}

// ---- Tables. A cell is text as it is shown: 1,234, inf or a dash; where a column holds numbers it sorts as these.
function value(text, numeric) {
  if (!numeric) return text;
  const number = parseFloat(text.replaceAll(",", "").replace("inf", "Infinity"));
  return Number.isNaN(number) ? -Infinity : number;
}

function compared(a, b) {
  return typeof a === "number" ? a - b : a.localeCompare(b, "en", { numeric: true });
}

function sortRows(table, column, heading) {
  const up = heading.getAttribute("aria-sort") !== "ascending";
  const numeric = heading.classList.contains("number");
  const key = (row) => value(row.cells[column].textContent, numeric);
  const rows = [...table.tBodies[0].rows].sort((a, b) => (up ? 1 : -1) * compared(key(a), key(b)));
  all("th", table).forEach((other) => other.removeAttribute("aria-sort"));
  heading.setAttribute("aria-sort", up ? "ascending" : "descending");
  table.tBodies[0].append(...rows);
}

function startShort(table) {
  if (table.tBodies[0].rows.length < 2) return;
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    const button = made("button", heading.textContent, { type: "button" });
    heading.replaceChildren(button);
    button.addEventListener("click", () => sortRows(table, column, heading));
  });
}

function shown(text) {
  return text.replace(/[&<>"']/g, (letter) => `&#${letter.charCodeAt(0)};`);
}

function column(heading) {
  const numeric = heading.classList.contains("number");
  const render = (data, kind) => ({ display: shown(data), sort: value(data, numeric), type: value(data, numeric) })[kind] ?? data;
  return { className: heading.className, type: numeric ? "num" : "string", render };
}

function paged(table) {
  const figure = table.closest("figure");
  const caption = one("figcaption", figure);
  const rows = JSON.parse(one("script", figure).textContent);
  const filename = `${one("a[download]", caption)?.getAttribute("href")?.replace(/\.csv$/, "") ?? figure.id}_selected`;
  one(".first", caption)?.remove();
  table.tBodies[0].replaceChildren();
  return new DataTable(table, {
    data: rows,
    columns: [...table.tHead.rows[0].cells].map(column),
    order: [], pageLength: 15, lengthMenu: [15, 50, 200], autoWidth: false, deferRender: true,
    layout: {
      topStart: { buttons: [{ extend: "csv", text: "Download these rows", filename, exportOptions: { orthogonal: "export" } }] },
      topEnd: { search: { text: "Filter" } }, bottomStart: ["info", "pageLength"], bottomEnd: "paging",
    },
  });
}

// A long table becomes one that is paged when it is near the screen: the page itself is there at once.
function startLong() {
  const waiting = new Set(all("table.paged"));
  const grids = [];
  const start = (table) => waiting.delete(table) && grids.push(paged(table));
  const near = new IntersectionObserver((seen) => seen.filter((each) => each.isIntersecting)
    .forEach((each) => start(each.target)), { rootMargin: "600px" });
  waiting.forEach((table) => near.observe(table));
  addEventListener("beforeprint", () => {
    waiting.forEach(start);
    grids.forEach((grid) => grid.page.len(grid.rows().count() > 60 ? 30 : -1).draw());
  });
  addEventListener("afterprint", () => grids.forEach((grid) => grid.page.len(15).draw()));
}

// ---- Figures come as they are scrolled to, and behind the first screen all of them: else print would lack some.
function startFigures() {
  const load = () => all("img[loading]").forEach((image) => { image.loading = "eager"; });
  setTimeout(load, 1500);
  addEventListener("beforeprint", load);
}

// ---- Where the reader is.
function startContents() {
  const links = new Map(all("nav li a").map((link) => [decodeURIComponent(link.hash.slice(1)), link]));
  if (matchMedia("(max-width: 860px)").matches) one("nav details").open = false;
  const there = new Set();
  const seen = new IntersectionObserver((entries) => {
    entries.forEach((entry) => there[entry.isIntersecting ? "add" : "delete"](entry.target.id));
    const first = [...links.keys()].find((id) => there.has(id));
    links.forEach((link, id) => (id === first ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current")));
  }, { rootMargin: "0px 0px -80% 0px" });
  all("main > section").forEach((section) => seen.observe(section));
}

if (matchMedia("(prefers-color-scheme: dark)").matches) document.documentElement.classList.add("dark");
startContents();
startSearch();
startZoom();
all("table.short").forEach(startShort);
addEventListener("load", startFigures);
addEventListener("DOMContentLoaded", () => typeof DataTable === "undefined" || startLong());
