// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a run of dgm-bench (the JSON in #run): plots with d3 (version 3), tables that sort.
"use strict";
(function () {
  const run = JSON.parse(document.getElementById("run").textContent);
  const main = d3.select("#main");
  const tip = d3.select("body").append("div").attr("id", "tip");
  const valueOf = cell => cell !== null && typeof cell === "object" ? cell.median : cell;

  function short(value) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    return size < 1e-3 || size >= 1e7 ? value.toExponential(2) : String(Number(value.toPrecision(3)));
  }
  function shown(cell) {
    if (cell === null || cell === undefined) return "";
    if (typeof cell === "string") return cell;
    if (typeof cell === "number") return short(cell);
    if (cell.median === null) return "";
    const spread = cell.n < 2 ? " (once)" : " ±" + Math.round(100 * (cell.high / cell.median - 1)) + " %";
    return short(cell.median) + spread;
  }
  const heading = column => column.title + (column.unit ? ", " + column.unit : "");
  const axis_title = column => column.unit === "bytes" ? column.title : heading(column);  // its ticks have kB and MB

  // --- light and dark -------------------------------------------------------------------------------------------
  const themes = ["system", "light", "dark"];
  const button = d3.select("#theme");
  let theme = 0;
  function show_theme() {
    button.text("Theme: " + themes[theme]);
    if (theme === 0) document.documentElement.removeAttribute("data-theme");
    else document.documentElement.setAttribute("data-theme", themes[theme]);
  }
  button.on("click", () => { theme = (theme + 1) % themes.length; show_theme(); });
  if (location.hash === "#dark") theme = 2;
  if (location.hash === "#light") theme = 1;
  show_theme();

  // --- plots ----------------------------------------------------------------------------------------------------
  const width = 720, height = 420, margin = {left: 78, right: 186, top: 12, bottom: 48};
  // In the picture itself, so that it looks the same when it is saved; the page's colours, else those of paper.
  const colours = ["#0072b2", "#d55e00", "#009e73", "#b0479a", "#8a6d00", "#3a8fc4", "#7a4b2a", "#6a6fd0", "#5c646d",
    "#c2185b"];
  const style = "text{font:12px system-ui,'DejaVu Sans',sans-serif;fill:var(--ink,#1c1f23)}" +
    ".axis path,.axis line{fill:none;stroke:var(--line,#c9ced4);stroke-width:1}" +
    ".front{fill:none;stroke:var(--front,#1c1f23);stroke-width:1.2;stroke-dasharray:5 3}" +
    ".ring{fill:none;stroke:var(--front,#1c1f23);stroke-width:1.6}.joined{fill:none;stroke-width:1.4}" +
    colours.map((c, k) => ".f" + k + "{fill:var(--s" + k + "," + c + ")}.l" + k + "{stroke:var(--s" + k + "," + c +
      ")}").join("");

  function log_scale(values, range) {
    let [low, high] = d3.extent(values);
    if (high / low < 1.2) { low /= 1.5; high *= 1.5; }
    const room = Math.pow(high / low, 0.04);
    return d3.scale.log().domain([low / room, high * room]).range(range);
  }
  function tick_text(value, unit) {
    const number = Number(value.toPrecision(6));
    if (unit === "bytes" && number >= 1000) {
      const step = Math.min(4, Math.floor(Math.log10(number) / 3 + 1e-9));
      return short(number / Math.pow(1000, step)) + " " + ["", "kB", "MB", "GB", "TB"][step];
    }
    return number >= 1e-5 && number < 1e7 ? String(number) : number.toExponential();
  }
  function axis(scale, orient, unit) {
    const [low, high] = scale.domain(), decades = Math.log10(high / low);
    const every = Math.ceil(decades / 9);
    const label = value => {
      const power = Math.floor(Math.log10(value) + 1e-9), lead = Math.round(value / Math.pow(10, power));
      const wanted = decades > 3 ? lead === 1 && power % every === 0 : decades > 1.2 ? [1, 2, 5].includes(lead) : true;
      return wanted ? tick_text(value, unit) : "";
    };
    const out = d3.svg.axis().scale(scale).orient(orient).tickFormat(label).outerTickSize(0);
    return decades > 12 ? out.tickValues(d3.range(every * Math.ceil(Math.log10(low) / every), Math.log10(high), every)
      .map(power => Math.pow(10, power))) : out;
  }

  function draw(figure, table, plot, facet) {
    const at = key => table.columns.findIndex(column => column.key === key);
    const x = at(plot.x), y = at(plot.y), series = at(plot.series), facets = plot.facet ? at(plot.facet) : -1;
    const here = table.rows.map((cells, row) => ({row, cells, x: valueOf(cells[x]), y: valueOf(cells[y]),
      series: cells[series]})).filter(p => facets < 0 || p.cells[facets] === facet);
    const points = here.filter(p => p.x > 0 && p.y > 0);
    figure.selectAll("svg").remove();
    figure.selectAll("p.note").remove();
    const svg = figure.append("svg").attr("viewBox", "0 0 " + width + " " + height)
      .attr("xmlns", "http://www.w3.org/2000/svg").attr("role", "img").attr("data-points", points.length)
      .attr("data-plot", table.key + "-" + plot.x + "-" + plot.y + "-" + facet);
    svg.append("title").text(plot.title + (facet ? ": " + facet : ""));
    svg.append("style").text(style);
    const zeros = here.filter(p => p.x === 0 || p.y === 0).length;
    if (zeros) figure.append("p").attr("class", "note")
      .text(zeros + " points are exactly 0, where a logarithmic axis does not go; the table has them.");
    if (!points.length) {
      svg.append("text").attr("x", 20).attr("y", 40).text("nothing to draw");
      return;
    }
    const across = log_scale(points.map(p => p.x), [margin.left, width - margin.right]);
    const up = log_scale(points.map(p => p.y), [height - margin.bottom, margin.top]);
    const size = {x: height - margin.bottom - margin.top, y: width - margin.left - margin.right};
    svg.append("g").attr("class", "axis").attr("transform", "translate(0," + (height - margin.bottom) + ")")
      .call(axis(across, "bottom", table.columns[x].unit).innerTickSize(-size.x).tickPadding(6));
    svg.append("g").attr("class", "axis").attr("transform", "translate(" + margin.left + ",0)")
      .call(axis(up, "left", table.columns[y].unit).innerTickSize(-size.y).tickPadding(6));
    svg.selectAll(".axis line").style("opacity", 0.55);
    svg.append("text").attr("x", margin.left + size.y / 2).attr("y", height - 10).attr("text-anchor", "middle")
      .text(axis_title(table.columns[x]));
    svg.append("text").attr("transform", "translate(14," + (margin.top + size.x / 2) + ")rotate(-90)")
      .attr("text-anchor", "middle").text(axis_title(table.columns[y]));

    const names = [];
    for (const p of points) if (!names.includes(p.series)) names.push(p.series);
    const colour = name => names.indexOf(name) % colours.length;
    const shapes = ["circle", "square", "triangle-up", "diamond", "cross", "triangle-down"];
    const symbol = name => d3.svg.symbol().type(shapes[names.indexOf(name) % shapes.length]).size(52)();
    const line = d3.svg.line().x(p => across(p.x)).y(p => up(p.y));
    if (plot.joined) {
      for (const name of names)
        svg.append("path").attr("class", "joined l" + colour(name)).attr("data-series", name)
          .attr("d", line(points.filter(p => p.series === name).sort((a, b) => a.x - b.x)));
    } else {
      const front = plot.pareto_rows[facet].map(row => points.find(p => p.row === row)).filter(p => p);
      svg.append("path").attr("class", "front").attr("d", line(front));
      svg.selectAll(".ring").data(front).enter().append("circle").attr("class", "ring").attr("r", 7.5)
        .attr("cx", p => across(p.x)).attr("cy", p => up(p.y));
    }
    const identity = p => table.columns.map((column, k) => column.identifies ? shown(p.cells[k]) : "")
      .filter(text => text).join(" ");
    const story = p => identity(p) + "\n" + heading(table.columns[x]) + ": " + shown(p.cells[x]) + "\n" +
      heading(table.columns[y]) + ": " + shown(p.cells[y]);
    svg.selectAll(".point").data(points).enter().append("path").attr("class", p => "point f" + colour(p.series))
      .attr("data-series", p => p.series).attr("d", p => symbol(p.series))
      .attr("transform", p => "translate(" + across(p.x) + "," + up(p.y) + ")")
      .on("mousemove", p => tip.text(story(p)).style("visibility", "visible")
        .style("left", Math.min(d3.event.clientX + 14, innerWidth - 320) + "px")
        .style("top", d3.event.clientY + 14 + "px"))
      .on("mouseout", () => tip.style("visibility", "hidden"))
      .append("title").text(story);

    const legend = svg.append("g")
      .attr("transform", "translate(" + (width - margin.right + 16) + "," + (margin.top + 8) + ")");
    names.forEach((name, k) => {
      const entry = legend.append("g").attr("transform", "translate(0," + 19 * k + ")").style("cursor", "pointer")
        .on("click", function () {
          const hide = !d3.select(this).classed("off");
          d3.select(this).classed("off", hide).style("opacity", hide ? 0.35 : 1);
          svg.selectAll("[data-series]").filter(function () { return this.getAttribute("data-series") === name; })
            .style("display", hide ? "none" : null);
        });
      entry.append("path").attr("class", "f" + colour(name)).attr("d", symbol(name));
      entry.append("text").attr("x", 11).attr("dy", "0.34em").text(name);
    });
    if (!plot.joined) {
      const entry = legend.append("g").attr("transform", "translate(0," + (19 * names.length + 6) + ")");
      entry.append("circle").attr("class", "ring").attr("r", 6);
      entry.append("text").attr("x", 11).attr("dy", "0.34em").text("Pareto front");
    }
  }

  function save(figure, name) {
    const svg = figure.select("svg").node();
    const link = document.createElement("a");
    link.href = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(svg));
    link.download = name + ".svg";
    link.click();
  }

  function plots(section, table) {
    const all = section.append("div").attr("class", "plots");
    for (const plot of table.plots) for (const facet of Object.keys(plot.pareto_rows)) {
      const figure = all.append("figure");
      const caption = figure.append("figcaption");
      caption.append("span").text(plot.title + (facet ? ": " + facet : ""));
      draw(figure, table, plot, facet);
      caption.append("button").attr("type", "button").text("SVG")
        .on("click", () => save(figure, [table.key, plot.y, "by", plot.x, facet].filter(t => t).join("-")));
    }
  }

  // --- tables ---------------------------------------------------------------------------------------------------
  function grid(section, table) {
    const fronts = new Set();
    for (const plot of table.plots) if (!plot.joined)
      for (const rows of Object.values(plot.pareto_rows)) rows.forEach(row => fronts.add(row));
    if (fronts.size) section.append("p").attr("class", "note")
      .text("Bold: on the Pareto front of one of the plots. ± is where another run is expected with 95 %; (once) was " +
        "not repeated, and no ratio can be had from it.");
    const element = section.append("div").attr("class", "scroll").append("table");
    const is_text = table.columns.map((c, k) =>
      table.rows.every(cells => cells[k] === null || typeof cells[k] === "string"));
    const stage = /^(import|repair|textures|map|fit|layers|measure|write)_seconds$/;  // too much for paper
    const kind = k => is_text[k] ? "text" : stage.test(table.columns[k].key) ? "stage" : null;
    const head = element.append("thead").append("tr").selectAll("th").data(table.columns).enter().append("th")
      .attr("class", (c, k) => kind(k)).attr("scope", "col");
    const rows = element.append("tbody").selectAll("tr").data(table.rows.map((cells, row) => ({cells, row}))).enter()
      .append("tr").attr("class", d => fronts.has(d.row) ? "front" : null);
    rows.selectAll("td").data(d => d.cells).enter().append("td").attr("class", (c, k) => kind(k))
      .each(function (cell) {
        const [value, spread] = shown(cell).split(/(?= [±(])/);
        const here = d3.select(this).text(is_text_cell(cell) ? cell : value);
        if (spread && !is_text_cell(cell)) here.append("span").attr("class", "spread").text(spread);
      });
    let sorted = -1, up = true;
    head.append("button").attr("type", "button").text(heading).on("click", (column, k) => {
      up = sorted === k ? !up : column.better !== "higher";
      sorted = k;
      head.attr("aria-sort", (c, other) => other === k ? (up ? "ascending" : "descending") : null);
      rows.sort((a, b) => {
        const p = valueOf(a.cells[k]), q = valueOf(b.cells[k]);
        if (p === null || q === null) return (p === null) - (q === null);  // gaps last, either way
        const order = typeof p === "string" ? String(p).localeCompare(String(q), "en", {numeric: true}) : p - q;
        return (up ? order : -order) || a.row - b.row;
      });
    });
  }
  function is_text_cell(cell) { return typeof cell === "string"; }

  function list(title, lines) {
    if (!lines.length) return;
    main.append("h2").text(title);
    main.append("ul").selectAll("li").data(lines).enter().append("li").text(line => line)
      .attr("class", line => /^(slower|worse|larger)/.test(line) ? "bad" : null);
  }
  function pairs(title, object) {
    main.append("h2").text(title);
    const rows = main.append("table").append("tbody").selectAll("tr").data(Object.entries(object)).enter().append("tr");
    rows.append("td").attr("class", "text").text(d => d[0].replace(/_/g, " "));
    rows.append("td").attr("class", "text").text(d => d[1]);
  }

  main.append("p").attr("class", "facts").text([run.machine.processor, run.machine.cores + " cores",
    run.machine.compiler, "dgm " + run.machine.version].join(" · "));
  list("In words", run.findings);
  list("Compared with the earlier run", run.comparison);
  for (const table of run.tables) {
    const section = main.append("section").attr("id", table.key);
    section.append("h2").text(table.title);
    if (table.note) section.append("p").attr("class", "note").text(table.note);
    plots(section, table);
    grid(section, table);
  }
  pairs("Settings", run.settings);
  pairs("Machine", run.machine);
  document.documentElement.setAttribute("data-drawn", String(d3.selectAll("svg .point").size()));
})();
