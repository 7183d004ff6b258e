#include "pipeline/report/page_frame.h"

#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {
namespace {

/// Returns the filter that shows pictures at another exposure. The script sets the tables.
Html exposureFilter() {
    Html functions;
    for (const char* channel : {"feFuncR", "feFuncG", "feFuncB"})
        functions += element(channel, {{"type", "table"}, {"tableValues", "0 1"}}, {});
    const Html filter =
        element("filter", {{"id", "exposure"}, {"color-interpolation-filters", "sRGB"}}, element("feComponentTransfer", functions));
    return element("svg", {{"width", "0"}, {"height", "0"}, {"aria-hidden", "true"}, {"class", "filters"}}, filter);
}

}  // namespace

// No "<" in it, so that the page reads as markup to the simplest of parsers.
std::string_view reportScript() {
    return R"js(
"use strict";
(() => {
  const make = (name, properties, parent) => {
    const made = Object.assign(document.createElement(name), properties);
    if (parent) parent.append(made);
    return made;
  };
  const all = (selector, root) => Array.from((root || document).querySelectorAll(selector));

  // Tables that can be sorted and searched
  for (const table of all("table.sortable")) {
    const body = table.tBodies[0], rows = Array.from(body.rows), heads = Array.from(table.tHead.rows[0].cells);
    const valueOf = (row, column) => {
      const cell = row.cells[column], value = cell.dataset.value;
      return value === undefined ? cell.textContent.toLowerCase() : Number(value);
    };
    heads.forEach((head, column) => {
      const button = make("button", { type: "button", className: "sort" });
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const isUp = head.getAttribute("aria-sort") === "descending";
        for (const each of heads) each.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", isUp ? "ascending" : "descending");
        const keyed = rows.map((row) => [valueOf(row, column), row]);
        keyed.sort((a, b) => (a[0] > b[0] ? 1 : b[0] > a[0] ? -1 : 0) * (isUp ? 1 : -1));
        body.append(...keyed.map((pair) => pair[1]));
      });
    });
    const bar = make("p", { className: "search" });
    const input = make("input", { type: "search", placeholder: "Search: name, target, failed ..." }, bar);
    input.setAttribute("aria-label", "Search the table");
    const found = make("span", { className: "soft" }, bar);
    const texts = rows.map((row) => row.textContent.toLowerCase());
    input.addEventListener("input", () => {
      const wanted = input.value.toLowerCase().split(/\s+/);
      let shown = 0;
      rows.forEach((row, index) => {
        row.hidden = !wanted.every((each) => texts[index].includes(each));
        shown += row.hidden ? 0 : 1;
      });
      found.textContent = shown + " of " + rows.length;
    });
    table.parentElement.before(bar);
  }

  // Pictures: exposure, blink, enlargement
  // The pictures' tone curve is p = (e / (1 + e))^(1 / 2.2) of an exposed light e: it is undone, and done again at the other exposure.
  const setExposure = (stops) => {
    const values = Array.from({ length: 256 }, (_, code) => {
      const part = Math.pow(Math.min(code, 254.5) / 255, 2.2), light = Math.pow(2, stops) * part / (1 - part);
      return Math.pow(light / (1 + light), 1 / 2.2).toFixed(4);
    });
    for (const each of all("#exposure feComponentTransfer *")) each.setAttribute("tableValues", values.join(" "));
  };
  for (const group of all(".lit")) {
    const images = all("figure img.light", group);
    if (images.length === 0) continue;
    const tools = make("p", { className: "tools" });
    const label = make("label", { textContent: "Exposure " }, tools);
    const range = make("input", { type: "range", min: -4, max: 4, step: 0.25, value: 0 }, label);
    const shown = make("output", { textContent: "0 stops" }, label);
    range.addEventListener("input", () => {
      for (const each of all(".tools input")) each.value = range.value;
      for (const each of all(".tools output")) each.textContent = range.value + " stops";
      setExposure(Number(range.value));
      for (const each of all("img.light")) each.classList.toggle("exposed", Number(range.value) !== 0);
    });
    if (images.length === 2) {
      const blink = make("button", { type: "button", textContent: "Blink" }, tools);
      const source = images[0].src, caption = images[0].parentElement.querySelector("figcaption");
      const words = caption.innerHTML;
      let timer = 0, isOther = false;
      const show = (other) => {
        isOther = other;
        images[0].src = other ? images[1].src : source;
        caption.innerHTML = other ? images[1].parentElement.querySelector("figcaption").innerHTML : words;
      };
      blink.addEventListener("click", () => {
        if (timer) { clearInterval(timer); timer = 0; show(false); }
        else timer = setInterval(() => show(!isOther), 500);
        blink.textContent = timer ? "Stop" : "Blink";
      });
    }
    group.before(tools);
  }
  const dialog = make("dialog", { className: "zoom" }, document.body);
  if (dialog.showModal) {
    const close = make("button", { type: "button", textContent: "Close" }, dialog);
    const frame = make("div", { className: "frame" }, dialog);
    let scale = 1, large = null;
    const resize = (factor) => {
      scale = Math.min(32, Math.max(0.5, scale * factor));
      large.style.width = large.naturalWidth * scale + "px";
    };
    const less = make("button", { type: "button", textContent: "\u2212" }), more = make("button", { type: "button", textContent: "+" });
    close.before(less, more);
    less.addEventListener("click", () => resize(0.5));
    more.addEventListener("click", () => resize(2));
    close.addEventListener("click", () => dialog.close());
    for (const image of all("figure img")) {
      image.tabIndex = 0;
      image.title = "Enlarge";
      const open = () => {
        frame.textContent = "";
        large = make("img", { src: image.src, alt: image.alt, className: image.className }, frame);
        scale = Math.max(1, Math.floor(Math.min(innerWidth * 0.9 / image.naturalWidth, innerHeight * 0.8 / image.naturalHeight)));
        large.style.width = image.naturalWidth * scale + "px";
        dialog.showModal();
      };
      image.addEventListener("click", open);
      image.addEventListener("keydown", (event) => { if (event.key === "Enter") open(); });
    }
  }
})();
)js";
}

std::string pageText(const std::string& title, const Html& main) {
    const Html head = element("head", voidElement("meta", {{"charset", "utf-8"}}) +
                                          voidElement("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}}) +
                                          voidElement("meta", {{"name", "color-scheme"}, {"content", "light dark"}}) +
                                          element("title", text(title)) + element("style", raw(reportStyle())));
    const Html body = element("body", exposureFilter() + element("main", main) + element("script", raw(reportScript())));
    return "<!DOCTYPE html>\n" + element("html", {{"lang", "en"}}, head + body).markup() + "\n";
}

}  // namespace lightcook::pipeline
