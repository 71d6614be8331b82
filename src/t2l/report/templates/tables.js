"use strict";
// Tables of class "sortable": a click on a header, or Enter, sorts the rows; another turns them.

// the number that a cell stands for, or what is written in it; null where there is nothing
function valueOf(cell) {
  if (!cell) return null;
  const given = "value" in cell.dataset ? cell.dataset.value : cell.textContent.trim();
  if (given === "") return null;
  return "value" in cell.dataset && !isNaN(given) ? Number(given) : given;
}
function compared(a, b) {
  if (typeof a === "number" && typeof b === "number") return a - b;
  return String(a).localeCompare(String(b), "en", { numeric: true });
}
// rows in the order of a column; those without a value are last, whichever way
function inOrder(rows, column, down) {
  const keyed = [...rows].map(row => [valueOf(row.cells[column]), row]);
  const known = keyed.filter(([value]) => value !== null), rest = keyed.filter(([value]) => value === null);
  known.sort(([a], [b]) => (down ? -1 : 1) * compared(a, b));
  return [...known, ...rest].map(([, row]) => row);
}
for (const table of document.querySelectorAll("table.sortable")) {
  const headers = [...table.tHead.rows[0].cells];
  headers.forEach((header, column) => {
    header.tabIndex = 0;
    header.title = "sort by this column";
    header.setAttribute("aria-sort", "none");
    const sort = () => {
      const first = valueOf([...table.querySelectorAll("tbody tr:not(.group)")]
        .map(row => row.cells[column]).find(cell => valueOf(cell) !== null));
      const turned = { ascending: "descending", descending: "ascending" }[header.getAttribute("aria-sort")];
      // at first the largest number, or the first letter
      const way = turned || (typeof first === "number" ? "descending" : "ascending");
      for (const other of headers) other.setAttribute("aria-sort", other === header ? way : "none");
      const rows = inOrder(table.querySelectorAll("tbody tr:not(.group)"), column, way === "descending");
      for (const heading of table.querySelectorAll("tr.group")) heading.hidden = true;
      table.tBodies[0].append(...rows);
      table.classList.add("sorted");
    };
    header.addEventListener("click", sort);
    header.addEventListener("keydown", event => {
      if (event.key === "Enter" || event.key === " ") { event.preventDefault(); sort(); }
    });
  });
}
