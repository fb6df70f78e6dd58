// The guard with a fake of the editor: what stands on the disk after each way to save.

const assert = require("node:assert/strict");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { afterEach, beforeEach, test } = require("node:test");
const { ByteGuard, setEncoding } = require("../src/guard");
const { fakeVscode } = require("./fake_vscode");

const PROGRAM = Buffer.from("DEF a( )\r\n; gr\xfcn \x80\r\nEND\r\n", "latin1");
let folder;
beforeEach(() => (folder = fs.mkdtempSync(path.join(os.tmpdir(), "guard-"))));
afterEach(() => fs.rmSync(folder, { recursive: true }));

async function opened(bytes, { name = "a.src", guard = true, ...options } = {}) {
  const file = path.join(folder, name);
  fs.writeFileSync(file, bytes);
  const editor = fakeVscode(options);
  if (guard) new ByteGuard(editor.vscode, () => {}).start();
  const document = await editor.open(file, name.endsWith(".src") ? "krl" : "xml");
  return { ...editor, document, bytes: () => fs.readFileSync(file) };
}

/** Wait until it holds: what the guard does when it starts has no end that can be waited for. */
async function until(holds) {
  for (let i = 0; i < 500 && !holds(); i++) await new Promise((resolve) => setTimeout(resolve, 10));
  assert.ok(holds());
}

const above = (text) => `; \xfcber\r\n${text}`;

test("without the guard the editor loses the umlaut: the fake shows the trap", async () => {
  const { document, bytes } = await opened(PROGRAM, { guard: false });
  await document.edit((text) => `${text};`);
  await document.save();
  assert.ok(bytes().includes(Buffer.from([0xef, 0xbf, 0xbd])));
});

test("a program that was read as UTF-8 is opened again, and keeps its bytes", async () => {
  const { document, bytes, said } = await opened(PROGRAM);
  assert.equal(document.encoding, "windows1252");
  assert.equal(document.getText(), "DEF a( )\r\n; gr\xfcn €\r\nEND\r\n");
  await document.edit(above);
  assert.equal(await document.save(), true);
  assert.deepEqual(bytes(), Buffer.concat([Buffer.from("; \xfcber\r\n", "latin1"), PROGRAM]));
  await document.undo();
  await document.save();
  assert.deepEqual(bytes(), PROGRAM);
  assert.deepEqual(said, []);
});

test("undo does not go back before the file was opened again", async () => {
  const { document, bytes, ran } = await opened(PROGRAM);
  await document.undo();
  assert.deepEqual(ran, ["redo"]);
  assert.ok(document.getText().includes("gr\xfcn"));
  await document.save();
  assert.deepEqual(bytes(), PROGRAM);
});

test("a byte that Windows 1252 leaves open is kept by Latin-1", async () => {
  const odd = Buffer.from("; \x81 \xfc\r\n", "latin1");
  for (const encoding of ["utf8", "windows1252"]) {
    const { document, bytes } = await opened(odd, { encoding });
    assert.equal(document.encoding, "iso88591");
    await document.edit((text) => `${text};`);
    await document.save();
    assert.deepEqual(bytes(), Buffer.concat([odd, Buffer.from(";")]));
  }
});

test("a program in UTF-8 is shown as UTF-8, once: what the user chooses then stays", async () => {
  const { vscode, document } = await opened(Buffer.from("; \xfc\r\n"), { encoding: "windows1252" });
  assert.equal(document.encoding, "utf8");
  await vscode.workspace.openTextDocument(document.uri, { encoding: "windows1252" });
  assert.equal(document.encoding, "windows1252");
});

test("what was lost by another program before may be saved", async () => {
  const lost = Buffer.from("; gr\uFFFDn\r\n");
  const { document, bytes, said } = await opened(lost);
  await document.edit((text) => text.replace("\uFFFD", "\xfc"));
  assert.equal(await document.save(), true);
  assert.deepEqual(bytes(), Buffer.from("; gr\xfcn\r\n"));
  assert.deepEqual(said, []);
});

test("a model whose encoding is not known is read-only and is not saved", async () => {
  const model = Buffer.from('<robot name="gr\xfcn"/>\n', "latin1");
  const { document, bytes, said, ran } = await opened(model, { name: "a.urdf" });
  assert.ok(ran.includes("workbench.action.files.setActiveEditorReadonlyInSession"));
  await document.edit((text) => `${text} `); // by a program, such as a rename
  assert.equal(await document.save(), false);
  assert.deepEqual(bytes(), model);
  assert.match(said[0], /a\.urdf was read as utf8, which it is not/);
});

test("a model that names its encoding is opened in it, and an editor is writable again when nothing is lost", async () => {
  const named = Buffer.from('<?xml version="1.0" encoding="ISO-8859-1"?>\n<robot name="gr\xfcn"/>\n', "latin1");
  assert.equal((await opened(named, { name: "a.urdf" })).document.encoding, "windows1252");
  const { vscode, document, ran } = await opened(named.subarray(44), { name: "b.urdf" });
  await vscode.workspace.openTextDocument(document.uri, { encoding: "windows1252" }); // chosen by the user
  assert.equal(ran.at(-1), "workbench.action.files.resetActiveEditorReadonlyInSession");
});

test("a file that was changed before it could be opened again is refused, then saved as it was read", async () => {
  const { document, bytes, said, vscode } = await opened(PROGRAM, { guard: false });
  await document.edit((text) => `; x\r\n${text}`);
  new ByteGuard(vscode, () => {}).start();
  await until(() => said.length);
  assert.equal(await document.save(), false);
  assert.deepEqual(bytes(), PROGRAM);
  assert.match(said.at(-1), /characters are lost/);
});

test("the user may then save it in its own encoding: the lost signs are put back", async () => {
  const { document, bytes, vscode, said } = await opened(PROGRAM, { guard: false, answers: ["Save as windows1252"] });
  await document.edit((text) => `; x\r\n${text}`);
  new ByteGuard(vscode, () => {}).start();
  await until(() => document.encoding === "windows1252" && !document.isDirty && document.getText().includes("\xfc"));
  assert.deepEqual(bytes(), Buffer.concat([Buffer.from("; x\r\n"), PROGRAM]));
  assert.equal(document.encoding, "windows1252");
  assert.equal(said.length, 1);
});

for (const [what, change, wanted] of [
  ["is mended", (text) => `;${text}`, Buffer.concat([Buffer.from(";"), PROGRAM])],
  ["is kept beside it where a lost sign was taken out", (text) => text.replace("\uFFFD", ""), null],
]) {
  test(`a file that was saved all the same, after a delay, ${what}`, async () => {
    const { document, bytes, said, vscode } = await opened(PROGRAM, { guard: false });
    await document.edit(change);
    new ByteGuard(vscode, () => {}).start();
    await until(() => said.length);
    await document.save(true);
    if (wanted) assert.deepEqual(bytes(), wanted);
    else assert.deepEqual(fs.readFileSync(path.join(folder, "a.src.before")), PROGRAM);
  });
}

test("a sign that the encoding lacks is refused, with its line", async () => {
  const { document, bytes, said } = await opened(PROGRAM);
  await document.edit((text) => text.replace("END", "; \u0142\r\nEND"));
  assert.equal(await document.save(), false);
  assert.deepEqual(bytes(), PROGRAM);
  assert.match(said[0], /^a\.src is not saved: line 3 has \u0142, not in windows1252$/);
});

test("line ends of two kinds become one only when that is asked for", async () => {
  const two = Buffer.from("DEF a( )\r\n; x\nEND\r\n");
  const { document, bytes, said } = await opened(two);
  await document.edit((text) => `;${text}`);
  assert.equal(await document.save(), false);
  assert.deepEqual(bytes(), two);
  assert.match(said[0], /would write all as CRLF/);
  const asked = await opened(two, { answers: ["Save all as CRLF"] });
  await asked.document.edit((text) => `;${text}`);
  await asked.document.save();
  await until(() => !asked.document.isDirty);
  assert.deepEqual(asked.bytes(), Buffer.from(";DEF a( )\r\n; x\r\nEND\r\n"));
});

test("a file that is saved before it was compared is compared first", async () => {
  const { document, bytes, vscode } = await opened(Buffer.from("a\r\nb\n"), { guard: false });
  await document.edit((text) => `;${text}`);
  new ByteGuard(vscode, () => {}).start();
  assert.equal(await document.save(), false);
  assert.deepEqual(bytes(), Buffer.from("a\r\nb\n"));
});

test("other files are left alone", async () => {
  const { document, ran } = await opened(Buffer.from("\xfc", "latin1"), { name: "a.xml" });
  assert.equal(document.encoding, "utf8");
  await document.edit((text) => `${text};`);
  assert.deepEqual(ran, []);
});

test("the user's setting is written once, and never over one that is there", async () => {
  const { vscode, ran } = fakeVscode();
  assert.equal(await setEncoding(vscode), true);
  assert.deepEqual(ran, [["encoding", "windows1252", 1, true]]);
  for (const level of ["globalLanguageValue", "workspaceValue", "workspaceFolderLanguageValue"]) {
    assert.equal(await setEncoding(fakeVscode({ settings: { [level]: "iso88591" } }).vscode), false);
  }
});
