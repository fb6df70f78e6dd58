// A list above a table shows the rows of one state.
document.querySelectorAll("select.states").forEach((list) => {
  list.addEventListener("change", () => {
    list.closest("p").nextElementSibling.querySelectorAll("tr[data-state]").forEach((row) => {
      row.hidden = list.value !== "" && row.dataset.state !== list.value;
    });
  });
});
