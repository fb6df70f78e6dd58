// The commands: what `lwr-dyn` prints becomes problems, a page beside the program, or a text.

const fs = require("node:fs/promises");
const os = require("node:os");
const path = require("node:path");
const { run } = require("./python");

/** Records of `krl check --json` and `lint --json` as [file, line, column, severity, code, message], counted from 1. */
function found(record, folder) {
  const ofProgram = (d) => [path.resolve(folder, d.file), d.line, d.column, d.severity, d.code, d.hint ? `${d.message} (${d.hint})` : d.message];
  const ofModel = (f) => [
    path.resolve(folder, f.file), f.line, f.column, f.severity, f.code,
    [f.subject ? `${f.subject}: ${f.what}` : f.what, f.why, f.instead && `Instead: ${f.instead}`].filter(Boolean).join("\n"),
  ];
  return [...(record.diagnoses ?? []).map(ofProgram), ...(record.findings ?? []).map(ofModel)];
}

const lastLine = (text) => text.trim().split("\n").pop();

/** The commands by name, as the editor calls them; what must be given back at the end is added to `subscriptions`. */
function commands({ vscode, service, problems, output, subscriptions }) {
  const { window, workspace, Uri } = vscode;
  const texts = new Map(); // address -> what a command printed
  const provideTextDocumentContent = (uri) => texts.get(uri.toString()) ?? "";
  subscriptions.push(workspace.registerTextDocumentContentProvider("lwr-dyn", { provideTextDocumentContent }));

  /** Run `lwr-dyn`; undefined, with the reason shown, where there is none or it printed only an error. */
  async function lwr(title, args, options) {
    const command = await service.command();
    if (!command) {
      window.showWarningMessage(`${title}: ${service.status.tooltip}`);
      return undefined;
    }
    const progress = { location: vscode.ProgressLocation.Notification, title };
    const result = await window.withProgress(progress, () => run(command, args, options));
    output.info(`lwr-dyn ${args.join(" ")}: exit code ${result.code}\n${result.stderr.trim()}`);
    if (result.code === 0 || result.code === 1) return result;
    window.showErrorMessage(`${title}: ${lastLine(result.stderr)}`);
    return undefined;
  }

  /** Show problems of files; those of open files come from the server as they are typed. */
  function show(rows) {
    const { Error, Warning, Information } = vscode.DiagnosticSeverity;
    const severities = { error: Error, warning: Warning, note: Information };
    const open = new Set(service.client ? workspace.textDocuments.map((document) => document.uri.fsPath) : []);
    const byFile = new Map();
    for (const [file, line, column, severity, code, message] of rows) {
      if (open.has(file)) continue;
      const at = new vscode.Range(line - 1, column - 1, line - 1, column);
      const one = Object.assign(new vscode.Diagnostic(at, message, severities[severity]), { code, source: "lwr-dyn" });
      byFile.set(file, [...(byFile.get(file) ?? []), one]);
    }
    problems.clear();
    for (const [file, shown] of byFile) problems.set(Uri.file(file), shown);
    if (rows.length) vscode.commands.executeCommand("workbench.actions.view.problems");
  }

  /** A page that a command wrote, one file that loads nothing, beside the editor. */
  async function page(title, args, uri) {
    const folder = await fs.mkdtemp(path.join(os.tmpdir(), "lwr-dyn-"));
    const file = path.join(folder, "page.html");
    try {
      const result = await lwr(title, [...args, "--html", file], { cwd: (workspace.getWorkspaceFolder(uri) ?? { uri: Uri.joinPath(uri, "..") }).uri.fsPath });
      if (!result) return;
      const html = await fs.readFile(file, "utf8").catch(() => undefined);
      if (html === undefined) {
        window.showErrorMessage(`${title}: ${lastLine(result.stderr) || "no page was written"}`);
        return;
      }
      const options = { enableScripts: true, retainContextWhenHidden: true, localResourceRoots: [] };
      const panel = window.createWebviewPanel("lwr-dyn", title, vscode.ViewColumn.Beside, options);
      panel.webview.html = html.replace("</head>", "<style>html > body { padding: 0 }</style></head>"); // VS Code's is 20 px
    } finally {
      await fs.rm(folder, { recursive: true, force: true });
    }
  }

  const active = (uri) => uri ?? window.activeTextEditor?.document.uri;
  const saved = (uri) => workspace.textDocuments.find((document) => document.uri.toString() === uri.toString())?.save();
  const root = () => workspace.workspaceFolders?.[0]?.uri;

  async function chosen(title, uri) {
    if (uri) return uri;
    const options = { canSelectFiles: true, canSelectFolders: true, openLabel: title, title, defaultUri: root() };
    return (await window.showOpenDialog(options))?.[0];
  }

  return {
    async checkBackup(uri) {
      const folder = uri ?? root() ?? (await chosen("Check this backup"));
      if (!folder) return;
      const result = await lwr(`Check ${path.basename(folder.fsPath)}`, ["krl", "check", folder.fsPath, "--json"]);
      if (!result) return;
      const record = JSON.parse(result.stdout);
      show(found(record, folder.fsPath));
      const { files, lines, errors, warnings, notes } = record.totals;
      window.showInformationMessage(`${path.basename(folder.fsPath)}: ${files} files, ${lines} lines; errors ${errors}, warnings ${warnings}, notes ${notes}.`);
    },

    async lintWorkspace() {
      const folder = root() ?? (await chosen("Lint this folder"));
      if (!folder) return;
      const result = await lwr("Lint URDF and xacro files", ["lint", folder.fsPath, "--json"]);
      if (!result) return;
      const rows = found(JSON.parse(result.stdout), folder.fsPath);
      show(rows);
      window.showInformationMessage(rows.length ? `URDF and xacro: ${rows.length} findings.` : "URDF and xacro: nothing to say.");
    },

    async runProgram(uri) {
      const program = active(uri);
      if (!program) return;
      await saved(program);
      const options = workspace.getConfiguration("lwr-dyn", program).get("runOptions");
      return page(`Run ${path.basename(program.fsPath)}`, ["krl", "run", program.fsPath, ...options], program);
    },

    async showArm(uri) {
      const model = active(uri);
      if (!model) return;
      await saved(model);
      return page(`Arm ${path.basename(model.fsPath)}`, ["show", model.fsPath, "--no-browser"], model);
    },

    async diffBackups(uri, both) {
      const [first, second] = both?.length === 2 ? both : [uri, undefined];
      const before = await chosen("Before: a backup or a program", first);
      const after = before && (await chosen("After: a backup or a program", second));
      if (!after) return;
      const result = await lwr("Compare", ["krl", "diff", before.fsPath, after.fsPath]);
      if (!result) return;
      const address = Uri.from({ scheme: "lwr-dyn", path: `/${path.basename(before.fsPath)} to ${path.basename(after.fsPath)}`, query: String(texts.size) });
      texts.set(address.toString(), result.stdout);
      const document = await workspace.openTextDocument(address);
      await vscode.languages.setTextDocumentLanguage(document, "diff");
      await window.showTextDocument(document, { preview: false });
    },

    restart: () => service.restart(),
  };
}

module.exports = { commands, found };
