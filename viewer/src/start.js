// Runs before the page, as a plain script: browsers load no modules, and no data, from files.
if (location.protocol === "file:") {
  const loading = /** @type {HTMLElement} */ (document.getElementById("loading"));
  loading.classList.add("failed");
  /** @type {HTMLElement} */ (document.getElementById("progress")).hidden = true;
  /** @type {HTMLElement} */ (document.getElementById("loading-text")).textContent =
    "Browsers do not open this page from a file. Serve its folder: python3 -m http.server --bind 127.0.0.1 --directory FOLDER";
}
