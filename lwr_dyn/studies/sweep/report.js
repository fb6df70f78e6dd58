// The replay of a run, inside the page: its own one-file page in a frame, made when it is asked for.
"use strict";

const replays = JSON.parse(document.getElementById("replays").textContent);
const place = document.getElementById("replay-place");

function showReplay(k) {
  const frame = document.createElement("iframe");
  frame.title = `Replay of ${replays.labels[k]}`;
  frame.sandbox = "allow-scripts";
  frame.srcdoc = replays.page.split("@@data@@").join(replays.runs[k].replaceAll("<", "\\u003c"));
  const heading = document.createElement("h3");
  heading.textContent = replays.labels[k];
  heading.tabIndex = -1;
  place.replaceChildren(heading, frame);
  place.hidden = false;
  heading.focus();
}

document.querySelectorAll("button[data-replay]").forEach((button) => {
  button.addEventListener("click", () => showReplay(Number(button.dataset.replay)));
});
