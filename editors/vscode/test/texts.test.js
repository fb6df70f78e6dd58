// Encodings found by bytes, and lost signs put back.

const assert = require("node:assert/strict");
const { test } = require("node:test");
const { LOST, countOf, encodingOf, lostGroups, restored, unwritable, writtenLosses } = require("../src/texts");
const { decode } = require("./fake_vscode");

const latin1 = (text) => Buffer.from(text, "latin1");

test("the encoding of a file by its bytes", () => {
  const cases = [
    [latin1("DEF a( )"), true, "iso88591", "iso88591"], // ASCII: as it is
    [latin1("\xfc"), true, "utf8", "windows1252"],
    [latin1("\xfc\x8d"), true, "utf8", "iso88591"],
    [Buffer.from("\xfc"), true, "windows1252", "utf8"],
    [Buffer.from("\uFEFFDEF"), true, "utf8", "utf8bom"],
    [Buffer.from([0xff, 0xfe, 0x41, 0]), true, "utf8", "utf16le"],
    [latin1("\xfc"), false, "utf8", undefined],
    [latin1('<?xml version="1.0" encoding="latin-1"?>\xfc'), false, "utf8", "windows1252"],
    [latin1('<?xml version="1.0" encoding="koi8-r"?>\xfc'), false, "utf8", undefined],
  ];
  for (const [bytes, isKrl, now, wanted] of cases) assert.equal(encodingOf(bytes, isKrl, now), wanted);
});

test("groups of lost bytes are the signs that a reader of UTF-8 shows, on random bytes", () => {
  let seed = 20261127;
  const random = (n) => (seed = (seed * 1103515245 + 12345) % 2 ** 31) % n;
  const starts = [0x41, 0x80, 0xbf, 0xc1, 0xc3, 0xe0, 0xe2, 0xed, 0xef, 0xf0, 0xf1, 0xf4, 0xf5, 0xa0, 0x9f, 0x8f, 0x90, 0xbd, 0xff];
  for (let trial = 0; trial < 5000; trial++) {
    const bytes = Buffer.from(Array.from({ length: 1 + random(9) }, () => starts[random(starts.length)]));
    assert.equal(lostGroups(bytes, "utf8").length, countOf(decode(bytes, "utf8"), LOST), bytes.toString("hex"));
  }
});

test("what was lost is put back into an edited text, in its order", async () => {
  for (const shownAs of ["utf8", "windows1252"]) {
    const right = "iso88591";
    const bytes = latin1("; \xfc\xe4 \x81\r\nA\xdf\xff \x8f");
    const shown = decode(bytes, shownAs);
    assert.ok(shown.includes(LOST));
    const put = (edited) => restored(edited, bytes, shownAs, async (some) => decode(some, right));
    assert.equal(await put(shown), decode(bytes, right));
    assert.equal(await put(`; new\r\n${shown}x`), `; new\r\n${decode(bytes, right)}x`);
    assert.equal(await put(shown.replace(LOST, "")), null);
    assert.equal(await put(shown + LOST), null);
  }
});

test("a sign that an encoding cannot write, with its line", () => {
  assert.deepEqual(unwritable("a\r\nb\r\n\u0142", "windows1252"), { sign: "\u0142", line: 3 });
  assert.equal(unwritable("\xfc€ž", "windows1252"), null);
  assert.equal(unwritable("€", "iso88591").sign, "€");
  assert.equal(unwritable("\x80", "windows1252").sign, "\x80");
  assert.equal(unwritable("\u{1f916}\u0142", "utf8"), null);
  assert.equal(unwritable("\u{1f916}", "windows1252").sign, "\u{1f916}");
  assert.equal(writtenLosses(Buffer.from("a\uFFFDb\uFFFD")), 2);
});
