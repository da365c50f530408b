// Show and hide parameters by their status.
for (const box of document.querySelectorAll(".filters input")) {
  box.addEventListener("change", () => {
    for (const row of document.querySelectorAll(`#parameters tr[data-status="${box.dataset.status}"]`)) row.hidden = !box.checked;
    for (const group of document.querySelectorAll("#parameters tbody"))
      group.hidden = ![...group.querySelectorAll("tr[data-status]")].some(row => !row.hidden);
  });
}
