// SPDX-License-Identifier: GPL-3.0-or-later
// Sorts the table by the column clicked, worst first at the first click, and filters it by name.
"use strict";
{
  const table = document.querySelector("table.assets");
  const body = table && table.tBodies[0];
  const rows = body ? Array.from(body.rows) : [];
  const value = (row, column) => {
    const text = row.cells[column].dataset.v;
    const number = Number(text);
    return text === "" || Number.isNaN(number) ? text : number;
  };
  const sort = (header) => {
    const column = header.cellIndex;
    const before = header.getAttribute("aria-sort");
    const up = before ? before === "descending" : header.dataset.first === "up";
    for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
    header.setAttribute("aria-sort", up ? "ascending" : "descending");
    const keyed = rows.map((row, k) => ({ row, k, v: value(row, column) }));
    keyed.sort((a, b) => {
      const order = typeof a.v === "number" && typeof b.v === "number" ? a.v - b.v
        : String(a.v) < String(b.v) ? -1 : String(a.v) > String(b.v) ? 1 : 0;
      return (up ? order : -order) || a.k - b.k;
    });
    body.append(...keyed.map((entry) => entry.row));
  };
  for (const button of document.querySelectorAll("table.assets th button"))
    button.addEventListener("click", () => sort(button.parentNode));

  const filter = document.getElementById("filter");
  const shown = document.getElementById("shown");
  if (filter) filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    for (const row of rows) {
      const text = row.dataset.text.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
      count += row.hidden ? 0 : 1;
    }
    shown.textContent = words.length ? count + " of " + rows.length + " shown" : "";
  });
}
