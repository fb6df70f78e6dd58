// The commands with a program in place of `lwr-dyn`: what they ask it, and what they show.

const assert = require("node:assert/strict");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");
const { test } = require("node:test");
const { commands } = require("../src/commands");
const about = require("../package.json");

const file = (fsPath) => ({ fsPath, toString: () => `file://${fsPath}` });

/** The commands, and what they made: `script` is what `lwr-dyn` does, by a shell; "$@" are its arguments. */
function made(script, { open = [], runOptions = [], command } = {}) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "commands-"));
  fs.writeFileSync(path.join(folder, "lwr-dyn"), `#!/bin/sh\necho "$@" > ${folder}/asked\n${script}\n`, { mode: 0o755 });
  const shown = { problems: new Map(), said: [], pages: [], texts: [] };
  const root = file(folder);
  const provider = {};
  const vscode = {
    Diagnostic: class { constructor(range, message, severity) { Object.assign(this, { range, message, severity }); } },
    DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2 },
    ProgressLocation: {},
    Range: class { constructor(...at) { this.at = at; } },
    Uri: { file, from: ({ path: name }) => ({ toString: () => name }), joinPath: (uri, up) => file(path.join(uri.fsPath, up)) },
    ViewColumn: {},
    commands: { executeCommand: async () => {} },
    languages: { setTextDocumentLanguage: async () => {} },
    window: {
      createWebviewPanel: (_, title) => ({ title, webview: { set html(text) { shown.pages.push([title, text]); } } }),
      showErrorMessage: (text) => shown.said.push(text),
      showInformationMessage: (text) => shown.said.push(text),
      showTextDocument: async (document) => shown.texts.push(document),
      showWarningMessage: (text) => shown.said.push(text),
      withProgress: (_, act) => act(),
    },
    workspace: {
      textDocuments: open.map((name) => ({ uri: file(path.join(folder, name)), save: async () => {} })),
      workspaceFolders: [{ uri: root }],
      getConfiguration: () => ({ get: () => runOptions }),
      getWorkspaceFolder: () => ({ uri: root }),
      openTextDocument: async (address) => provider.provideTextDocumentContent(address),
      registerTextDocumentContentProvider: (_, given) => Object.assign(provider, given),
    },
  };
  const problems = { clear: () => shown.problems.clear(), set: (uri, all) => shown.problems.set(path.relative(folder, uri.fsPath), all) };
  const service = { client: {}, command: async () => (command === null ? undefined : [path.join(folder, "lwr-dyn")]), status: { tooltip: "no Python" } };
  const acts = commands({ vscode, service, problems, output: { info() {} }, subscriptions: [] });
  const asked = () => fs.readFileSync(path.join(folder, "asked"), "utf8").trim().replaceAll(folder, "ROOT");
  return { acts, shown, asked, at: (name) => file(path.join(folder, name)) };
}

const CHECKED = { diagnoses: [
  { file: "a.src", line: 2, column: 3, severity: "error", code: "undeclared", message: "x is not declared", hint: null },
  { file: "b.src", line: 1, column: 1, severity: "note", code: "n", message: "m", hint: "h" },
], totals: { files: 2, lines: 9, errors: 1, warnings: 0, notes: 1 } };

test("each command of the package is there", () => {
  const names = Object.keys(made("").acts).map((name) => `lwr-dyn.${name}`);
  assert.deepEqual(names.sort(), about.contributes.commands.map(({ command }) => command).sort());
});

test("a backup's diagnoses are problems, but for files that are open", async () => {
  const { acts, shown, asked } = made(`echo '${JSON.stringify(CHECKED)}'; exit 1`, { open: ["b.src"] });
  await acts.checkBackup();
  assert.equal(asked(), "krl check ROOT --json");
  const [one] = shown.problems.get("a.src");
  assert.deepEqual([one.range.at, one.message, one.severity, one.code], [[1, 2, 1, 3], "x is not declared", 0, "undeclared"]);
  assert.deepEqual([...shown.problems.keys()], ["a.src"]);
  assert.match(shown.said[0], /2 files, 9 lines; errors 1, warnings 0, notes 1\.$/);
});

test("a run is a page, with the options of the setting; a refusal is one line", async () => {
  const { acts, shown, asked, at } = made("for last; do :; done; echo '<head></head>made' > $last", { runOptions: ["--cell", "c.toml"] });
  await acts.runProgram(at("a.src"));
  assert.match(asked(), /^krl run ROOT\/a\.src --cell c\.toml --html \S+page\.html$/);
  assert.equal(shown.pages[0][0], "Run a.src");
  assert.match(shown.pages[0][1], /padding: 0.*<\/head>made/);
  for (const code of [1, 2]) {
    const refused = made(`echo 'note: x' >&2; echo 'lwr-dyn: a.src:1: no value' >&2; exit ${code}`);
    await refused.acts.runProgram(refused.at("a.src"));
    assert.deepEqual(refused.shown.said, ["Run a.src: lwr-dyn: a.src:1: no value"]);
    assert.deepEqual(refused.shown.pages, []);
  }
});

test("an arm is a page, two backups are a text, models are problems", async () => {
  const arm = made("for last; do :; done; echo '<head></head>' > $last");
  await arm.acts.showArm(arm.at("a.urdf"));
  assert.match(arm.asked(), /^show ROOT\/a\.urdf --no-browser --html/);
  const diff = made("echo 'a.src: changed'; exit 1");
  await diff.acts.diffBackups(diff.at("old"), [diff.at("old"), diff.at("new")]);
  assert.equal(diff.asked(), "krl diff ROOT/old ROOT/new");
  assert.deepEqual(diff.shown.texts, ["a.src: changed\n"]);
  const lint = made(`echo '{"findings": [{"file": "m.urdf", "line": 1, "column": 1, "severity": "warning", "code": "c", "what": "w"}]}'`);
  await lint.acts.lintWorkspace();
  assert.equal(lint.asked(), "lint ROOT --json");
  assert.equal(lint.shown.problems.get("m.urdf")[0].message, "w");
});

test("without lwr-dyn a command says what is missing", async () => {
  const { acts, shown } = made("", { command: null });
  await acts.checkBackup();
  assert.match(shown.said[0], /no Python/);
});
