// A still becomes the page behind it when it is clicked.
document.addEventListener("click", (event) => {
  const still = event.target.closest("a.still");
  if (!still || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  const frame = document.createElement("iframe");
  frame.src = still.getAttribute("href");
  frame.title = still.dataset.title;
  frame.className = "live";
  still.replaceWith(frame);
  frame.focus();
});
