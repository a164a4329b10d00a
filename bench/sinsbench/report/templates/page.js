"use strict";
(() => {
  const root = document.documentElement;
  const all = (selector, where = document) => [...where.querySelectorAll(selector)];

  // Tables: sorting by numbers where a cell has one, else by text; empty cells stay last.
  const text = (cell) => cell.textContent.trim();
  function compare(a, b, sign) {
    const [x, y] = [a, b].map((cell) => cell.dataset.key);
    if (x !== undefined && y !== undefined) return sign * (parseFloat(x) - parseFloat(y));
    const [s, t] = [text(a), text(b)];
    if (!s || !t) return (s ? 0 : 1) - (t ? 0 : 1);
    return sign * s.localeCompare(t, "en", { numeric: true });
  }
  for (const table of all("table")) {
    const heads = all("thead th", table);
    heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((one) => one.setAttribute("aria-sort", one === head ? (up ? "ascending" : "descending") : "none"));
      const rows = [...table.tBodies[0].rows];
      rows.sort((a, b) => compare(a.cells[column], b.cells[column], up ? 1 : -1));
      table.tBodies[0].append(...rows);
    }));
  }
  for (const input of all(".filter input")) {
    const rows = [...document.getElementById(input.getAttribute("aria-controls")).rows];
    const told = input.parentElement.querySelector("output");
    const contents = rows.map((row) => row.textContent.toLowerCase());
    input.addEventListener("input", () => {
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      rows.forEach((row, n) => { row.hidden = !words.every((word) => contents[n].includes(word)); });
      told.value = words.length ? `${rows.filter((row) => !row.hidden).length} of ${rows.length} rows` : "";
    });
  }

  // Theme: that of the system until the switch is pressed.
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  function theme(dark) {
    root.dataset.theme = dark ? "dark" : "light";
    button.setAttribute("aria-pressed", String(dark));
    if (charts.size) all(".chart").filter((element) => charts.has(element)).forEach(draw);
  }
  button.addEventListener("click", () => theme(root.dataset.theme !== "dark"));
  system.addEventListener("change", (event) => theme(event.matches));

  // Charts: drawn when they come near the window, the rest when there is nothing else to do, so that all are printed.
  const { charts: known, data } = JSON.parse(document.getElementById("charts").textContent);
  const charts = new Map();
  const hidden = new Set();
  const tables = {};
  function rowsOf(name) {
    const { columns, rows } = data[name];
    return (tables[name] ??= rows.map((row) => Object.fromEntries(columns.map((column, n) => [column, row[n]]))));
  }
  function colours(quiet) {
    const of = (name) => getComputedStyle(root).getPropertyValue(name).trim();
    const [ink, soft, grid, line] = ["--ink", "--soft", "--grid", "--line"].map(of);
    const font = getComputedStyle(document.body).fontFamily;
    const narrow = innerWidth < 600;
    return {
      background: "transparent", font, padding: 4,
      axis: { labelColor: soft, titleColor: ink, gridColor: grid, domainColor: line, tickColor: line, labelFontSize: 11, titleFontSize: 12, titleFontWeight: "normal" },
      legend: { disable: quiet, labelColor: ink, titleColor: ink, labelLimit: 240, symbolLimit: 0, ...(narrow && { columns: 1 }) },
      axisY: { labelLimit: narrow ? 150 : 280 },
      view: { stroke: line }, aria: false,
    };
  }
  // What draws is read after the page stands: a person looks at the first screen meanwhile.
  function libraries() {
    if (globalThis.vegaEmbed) return;
    const script = document.createElement("script");
    script.textContent = document.getElementById("libraries").textContent;
    document.head.append(script);
  }
  async function draw(element) {
    libraries();
    const { specification, data: name } = known[element.id.replace("chart-", "")];
    const section = element.closest("section");
    const spec = structuredClone(specification);
    spec.datasets = { ...spec.datasets, [name]: rowsOf(name) };
    for (const one of spec.params ?? []) {
      if (one.name === "hidden") one.value = [...hidden];
      if (one.name === "shown_case") one.value = section.dataset.case;
    }
    charts.set(element, null);
    const actions = { export: { svg: true, png: true }, source: false, compiled: false, editor: false };
    const { view, finalize } = await vegaEmbed(element, spec, { config: colours(Boolean(section.querySelector(".legend"))), renderer: "svg", actions, downloadFileName: element.id });
    charts.get(element)?.finalize();
    charts.set(element, { view, finalize, section });
  }
  function signal(name, value, section) {
    for (const chart of charts.values()) {
      if (!chart || (section && chart.section !== section)) continue;
      try { chart.view.signal(name, value).runAsync(); } catch { /* a chart without series */ }
    }
  }
  const queue = all(".chart");
  const near = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting && !charts.has(target)) draw(target);
    }
  }, { rootMargin: "300px" });
  function next() {
    const element = queue.find((one) => !charts.has(one));
    if (element) draw(element).then(() => idle(next));
  }
  const idle = globalThis.requestIdleCallback ?? ((task) => setTimeout(task, 50));

  function apply() {
    all(".legend [data-series]").forEach((one) => one.setAttribute("aria-pressed", String(!hidden.has(one.dataset.series))));
    signal("hidden", [...hidden]);
  }
  for (const one of all(".legend [data-series]")) {
    one.addEventListener("click", () => {
      if (!hidden.delete(one.dataset.series)) hidden.add(one.dataset.series);
      apply();
    });
  }
  for (const section of all("main > section")) {
    const names = all(".legend [data-series]", section).map((one) => one.dataset.series);
    section.querySelector(".all")?.addEventListener("click", () => { names.forEach((name) => hidden.delete(name)); apply(); });
    section.querySelector(".none")?.addEventListener("click", () => { names.forEach((name) => hidden.add(name)); apply(); });
    section.querySelector(".case")?.addEventListener("change", (event) => {
      section.dataset.case = event.target.value;
      signal("shown_case", event.target.value, section);
    });
  }
  theme(system.matches);
  addEventListener("load", () => {
    all(".chart").forEach((element) => near.observe(element));
    idle(next);
  });
})();
