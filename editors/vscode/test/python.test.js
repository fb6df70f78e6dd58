// Where `lwr-dyn` is looked for, and what the commands make of its records.

const assert = require("node:assert/strict");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { test } = require("node:test");
const { found } = require("../src/commands");
const { candidates, find } = require("../src/python");
const { fakeVscode } = require("./fake_vscode");

/** A workspace whose environment has a program in place of Python. */
function workspace(script) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "python-"));
  fs.mkdirSync(path.join(folder, ".venv/bin"), { recursive: true });
  fs.writeFileSync(path.join(folder, ".venv/bin/python"), `#!/bin/sh\n${script}\n`, { mode: 0o755 });
  return { fsPath: folder };
}

const python = (file) => ({
  activate: async () => {},
  exports: { environments: { getActiveEnvironmentPath: () => "x", resolveEnvironment: async () => ({ executable: { uri: { fsPath: file } } }) } },
});

test("the setting is the only way; else the workspace, the Python extension, the path", async () => {
  const all = async (vscode, folder) => {
    const out = [];
    for await (const one of candidates(vscode, folder)) out.push(one);
    return out;
  };
  assert.deepEqual(await all(fakeVscode({ settings: { command: ["x", "y"] } }).vscode), [["the setting lwr-dyn.command", ["x", "y"]]]);
  const { vscode } = fakeVscode();
  vscode.extensions.getExtension = () => python("/opt/python");
  const folder = workspace("exit 0");
  const ways = await all(vscode, folder);
  assert.deepEqual(ways.slice(0, 3), [
    [".venv of the workspace", [path.join(folder.fsPath, ".venv/bin/python"), "-m", "lwr_dyn"]],
    ["the Python extension", ["/opt/python", "-m", "lwr_dyn"]],
    ["the path", ["lwr-dyn"]],
  ]);
});

test("the newest server that a version has is taken", async () => {
  const { vscode } = fakeVscode();
  const server = async (script) => (await find(vscode, workspace(script), () => {})).server;
  assert.deepEqual((await server("exit 0")).args, ["lsp"]);
  assert.deepEqual(await server('[ "$3" = krl ]'), { args: ["krl", "server"], urdf: false });
});

test("what is missing is said in the words of lwr-dyn", async () => {
  const command = [path.join(workspace("echo 'lwr-dyn: krl: needs pygls' >&2; exit 2").fsPath, ".venv/bin/python")];
  const { vscode } = fakeVscode({ settings: { command } });
  assert.match((await find(vscode, undefined, () => {})).missing, /lwr-dyn: krl: needs pygls/);
  const nowhere = fakeVscode({ settings: { command: ["/no/such/lwr-dyn"] } });
  assert.match((await find(nowhere.vscode, undefined, () => {})).missing, /not installed/);
});

test("records become rows of problems", () => {
  const program = { diagnoses: [{ file: "R1/a.src", line: 2, column: 3, severity: "error", code: "name", message: "m", hint: "h" }] };
  assert.deepEqual(found(program, "/b"), [["/b/R1/a.src", 2, 3, "error", "name", "m (h)"]]);
  const model = { findings: [{ file: "/b/a.urdf", line: 1, column: 1, severity: "note", code: "c", subject: "link", what: "w", why: "y", instead: "" }] };
  assert.deepEqual(found(model, "/x"), [["/b/a.urdf", 1, 1, "note", "c", "link: w\ny"]]);
});
