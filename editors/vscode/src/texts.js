// Bytes and texts without an editor: which encoding a file has, and what was lost where it was read in another.

const LOST = "\uFFFD";
const LINE_END = /\r\n|\r|\n/g;
const IN_1252 = "€‚ƒ„…†‡ˆ‰Š‹ŒŽ‘’“”•–—˜™š›œžŸ";
const NOT_IN_1252 = [0x81, 0x8d, 0x8f, 0x90, 0x9d];

const MARKS = [
  ["utf8bom", [0xef, 0xbb, 0xbf]],
  ["utf16le", [0xff, 0xfe]],
  ["utf16be", [0xfe, 0xff]],
];

/** What an encoding cannot write; a file would get "?" in its place. */
const UNWRITABLE = {
  windows1252: new RegExp(`[^\\x00-\\x7F\\xA0-\\xFF${IN_1252}]`, "u"),
  iso88591: /[^\x00-\xFF]/u,
  utf8: /\p{Surrogate}/u,
  utf8bom: /\p{Surrogate}/u,
  utf16le: /\p{Surrogate}/u,
  utf16be: /\p{Surrogate}/u,
};

/**
 * The encoding of a file by its bytes, as VS Code names it; undefined where they do not say, so that it must be asked.
 *
 * A byte order mark says it, and bytes beyond ASCII that are valid UTF-8. Other files of KRL are Windows 1252, which the
 * controller writes, or Latin-1 where a byte occurs that Windows 1252 leaves open; a file of XML names its own. With
 * ASCII alone each answer is right: it stays as it is `now`.
 */
function encodingOf(bytes, isKrl, now) {
  const mark = MARKS.find(([, start]) => start.every((byte, i) => bytes[i] === byte));
  if (mark) return mark[0];
  if (bytes.every((byte) => byte < 0x80)) return now;
  const groups = sequences(bytes);
  if (groups.every((group) => group.valid)) return "utf8";
  const named = /^<\?xml[^>]*?encoding\s*=\s*["']([\w.-]+)/.exec(Buffer.from(bytes.subarray(0, 200)).toString("latin1"))?.[1];
  if (!isKrl && !/^(iso-?8859-?1|latin-?1|windows-?1252|cp1252)$/i.test(named ?? "")) return undefined;
  return NOT_IN_1252.some((byte) => bytes.includes(byte)) ? "iso88591" : "windows1252";
}

/** Second bytes that may follow the first ones with a rule of their own (The Unicode Standard, table 3-7). */
const SECOND = { 0xe0: [0xa0, 0xbf], 0xed: [0x80, 0x9f], 0xf0: [0x90, 0xbf], 0xf4: [0x80, 0x8f] };

/**
 * The bytes beyond ASCII as a reader of UTF-8 groups them: each sequence that is one sign, and each that is none and is
 * shown as one U+FFFD (a "maximal subpart"; The Unicode Standard, section 3.9).
 */
function sequences(bytes) {
  const out = [];
  for (let i = 0; i < bytes.length; ) {
    const first = bytes[i];
    if (first < 0x80) {
      i++;
      continue;
    }
    const more = first >= 0xc2 && first <= 0xdf ? 1 : first >= 0xe0 && first <= 0xef ? 2 : first >= 0xf0 && first <= 0xf4 ? 3 : 0;
    let j = 1;
    for (let [low, high] = SECOND[first] ?? [0x80, 0xbf]; j <= more && bytes[i + j] >= low && bytes[i + j] <= high; j++) [low, high] = [0x80, 0xbf];
    const valid = more > 0 && j === more + 1;
    out.push({ valid, bytes: bytes.subarray(i, i + j) });
    i += j;
  }
  return out;
}

const isLost = (bytes) => bytes.length === 3 && bytes[0] === 0xef && bytes[1] === 0xbf && bytes[2] === 0xbd;

/** How many times the bytes hold U+FFFD itself: lost before, by another program. */
const writtenLosses = (bytes) => sequences(bytes).filter((group) => isLost(group.bytes)).length;

/** The bytes for which a reader in that encoding shows U+FFFD, each group one sign, in the order of the file. */
function lostGroups(bytes, encoding) {
  if (encoding === "windows1252") return NOT_IN_1252.flatMap((byte) => positions(bytes, byte)).sort((a, b) => a - b).map((i) => bytes.subarray(i, i + 1));
  return sequences(bytes).filter((group) => !group.valid || isLost(group.bytes)).map((group) => group.bytes);
}

const positions = (bytes, byte) => [...bytes.keys()].filter((i) => bytes[i] === byte);

/**
 * An edited text with what was lost in reading put back, or null where that is not certain.
 *
 * The k-th U+FFFD of the edited text is the k-th of the file, as long as none was taken out, copied or moved away:
 * where their numbers differ there is no answer. `decode` gives the text of some bytes in the right encoding.
 */
async function restored(edited, bytes, encoding, decode) {
  const groups = lostGroups(bytes, encoding);
  if (countOf(edited, LOST) !== groups.length) return null;
  const signs = await Promise.all(groups.map(decode));
  let k = 0;
  return edited.replaceAll(LOST, () => signs[k++]);
}

const countOf = (text, part) => text.split(part).length - 1;

/** The kinds of line ends of a text. */
const lineEnds = (text) => new Set(text.match(LINE_END) ?? []);

/** The first sign that an encoding cannot write, with its line from 1; null if there is none, or the encoding is not known. */
function unwritable(text, encoding) {
  const found = UNWRITABLE[encoding]?.exec(text);
  return found ? { sign: found[0], line: (text.slice(0, found.index).match(LINE_END) ?? []).length + 1 } : null;
}

module.exports = { LOST, countOf, encodingOf, lineEnds, lostGroups, restored, unwritable, writtenLosses };
