// Tables sort by a click on a heading; a second click turns the order round.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  if (body.rows.length < 3) continue;
  const number = text => parseFloat(text.replace("−", "-").replace(/·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)/, (_, power) =>
    "e" + [...power].map(c => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c)).map(k => k === 0 ? "-" : k - 1).join("")));
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      heads.forEach(h => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const text = row => row.cells[column] ? row.cells[column].textContent.trim() : "";
      const rows = [...body.rows].sort((a, b) => {
        const x = number(text(a)), y = number(text(b));
        const order = isNaN(x) || isNaN(y) ? (isNaN(x) - isNaN(y)) || text(a).localeCompare(text(b)) : x - y;
        return down ? -order : order;
      });
      body.append(...rows);
    });
  });
}
