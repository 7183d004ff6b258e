// What one can do with a page: sort and search tables; see pictures at other exposures, in turn and enlarged.
import { draw, make } from "../src/elements.js";

const all = (selector, root = document) => [...root.querySelectorAll(selector)];

function sortable(table) {
  const body = table.tBodies[0], rows = [...body.rows], heads = [...table.tHead.rows[0].cells];
  const valueOf = ({ cells }, column) => (cells[column].dataset.value === undefined ? cells[column].textContent.toLowerCase() : Number(cells[column].dataset.value));
  heads.forEach((head, column) => {
    const sort = () => {
      const isUp = head.getAttribute("aria-sort") === "descending";
      for (const each of heads) each.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", isUp ? "ascending" : "descending");
      const keyed = rows.map((row) => ({ value: valueOf(row, column), row }));
      keyed.sort((a, b) => (a.value > b.value ? 1 : b.value > a.value ? -1 : 0) * (isUp ? 1 : -1));
      body.append(...keyed.map(({ row }) => row));
    };
    head.replaceChildren(make("button", { type: "button", class: "sort", onclick: sort }, [...head.childNodes]));
  });
  const found = make("span", { class: "soft" }), texts = rows.map((row) => row.textContent.toLowerCase());
  const input = make("input", { type: "search", placeholder: "Search: name, target, failed ...", "aria-label": "Search the table", oninput: () => {
    const wanted = input.value.toLowerCase().split(/\s+/);
    rows.forEach((row, i) => (row.hidden = !wanted.every((each) => texts[i].includes(each))));
    found.textContent = `${rows.filter((row) => !row.hidden).length} of ${rows.length}`;
  } });
  table.parentElement.before(make("p", { class: "search" }, input, found));
}

/** Adds the filter that shows pictures at another exposure. Returns what sets it [stops]. */
function exposure() {
  const functions = ["feFuncR", "feFuncG", "feFuncB"].map((channel) => draw(channel, { type: "table", tableValues: "0 1" }));
  document.body.prepend(draw("svg", { width: 0, height: 0, "aria-hidden": "true", class: "filters" },
    draw("filter", { id: "exposure", "color-interpolation-filters": "sRGB" }, draw("feComponentTransfer", {}, functions))));
  return (stops) => {
    // The tone curve of the pictures is p = (e / (1 + e))^(1 / 2.2) of an exposed light e: it is undone, and done again at the other exposure.
    const values = Array.from({ length: 256 }, (_, code) => {
      const share = (Math.min(code, 254.5) / 255) ** 2.2, light = (2 ** stops * share) / (1 - share);
      return ((light / (1 + light)) ** (1 / 2.2)).toFixed(4);
    });
    for (const each of functions) each.setAttribute("tableValues", values.join(" "));
    for (const each of all(".tools input")) each.value = stops;
    for (const each of all(".tools output")) each.textContent = `${stops} stops`;
    for (const each of all("img.light")) each.classList.toggle("exposed", Number(stops) !== 0);
  };
}

/** Makes the button that shows two pictures in turn, in the place of the first. */
function blink(images) {
  const captions = images.map((image) => image.parentElement.querySelector("figcaption")), shown = images.map((image, i) => ({ src: image.src, caption: [...captions[i].childNodes] }));
  let timer = 0, at = 0;
  const show = (i) => {
    at = i;
    images[0].src = shown[i].src;
    captions[0].replaceChildren(...shown[i].caption.map((node) => node.cloneNode(true)));
  };
  const button = make("button", { type: "button", onclick: () => {
    if (timer) {
      clearInterval(timer);
      timer = 0;
      show(0);
    } else timer = window.setInterval(() => show(1 - at), 500);
    button.textContent = timer ? "Stop" : "Blink";
  } }, "Blink");
  return button;
}

/** Opens pictures enlarged when they are clicked. */
function enlargeable(images) {
  let scale = 1, large = null;
  const resize = (factor) => {
    scale = Math.min(32, Math.max(0.5, scale * factor));
    large.style.width = `${large.naturalWidth * scale}px`;
  };
  const frame = make("div", { class: "frame" }), button = (text, act) => make("button", { type: "button", onclick: act }, text);
  const dialog = make("dialog", { class: "zoom" }, button("−", () => resize(0.5)), button("+", () => resize(2)), button("Close", () => dialog.close()), frame);
  document.body.append(dialog);
  for (const image of images) {
    image.tabIndex = 0;
    image.title = "Enlarge";
    const open = () => {
      large = make("img", { src: image.src, alt: image.alt, class: image.className });
      frame.replaceChildren(large);
      scale = Math.max(1, Math.floor(Math.min((innerWidth * 0.9) / image.naturalWidth, (innerHeight * 0.8) / image.naturalHeight)));
      large.style.width = `${image.naturalWidth * scale}px`;
      dialog.showModal();
    };
    image.addEventListener("click", open);
    image.addEventListener("keydown", (event) => event.key === "Enter" && open());
  }
}

/** Opens folded sections where a link leads to them, and all of them on paper. */
function unfolding() {
  const follow = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1))), folded = target?.querySelector("details");
    if (!target || !folded) return;
    folded.open = true;
    target.scrollIntoView();
  };
  addEventListener("hashchange", follow);
  for (const link of all('a[href^="#"]')) link.addEventListener("click", () => setTimeout(follow));  // also for the address that the page has already
  follow();
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = all(".asset > details:not([open])");
    for (const each of opened) each.open = true;
  });
  addEventListener("afterprint", () => opened.forEach((each) => (each.open = false)));
}

/** Adds the tools to a page. */
export function addTools() {
  unfolding();
  for (const table of all("table.sortable")) sortable(table);
  const expose = exposure();
  for (const group of all(".lit")) {
    const images = all("figure img.light", group);
    if (images.length === 0) continue;
    const range = make("input", { type: "range", min: -4, max: 4, step: 0.25, value: 0, oninput: () => expose(range.value) });
    group.before(make("p", { class: "tools" }, make("label", {}, "Exposure ", range, make("output", {}, "0 stops")), images.length === 2 && blink(images)));
  }
  enlargeable(all("figure img"));
}
