// The compressed libraries and numbers of the page: unpacked here, run as scripts of the page, never fetched.
"use strict";

async function unpackedText(name) {
  const place = document.getElementById(`packed-${name}`);
  if (place === null) return null;
  const bytes = Uint8Array.from(atob(place.textContent), (letter) => letter.charCodeAt(0));
  const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  place.remove();
  return text;
}

async function runPacked(name) {
  const text = await unpackedText(name);
  if (text === null) return;
  const script = document.createElement("script");
  script.textContent = text;
  document.body.append(script);
}
