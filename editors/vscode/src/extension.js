// KRL and URDF in VS Code: the guard of bytes, the language server of lwr-dyn, and commands that show what it finds.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");
const { commands } = require("./commands");
const { ByteGuard, setEncoding } = require("./guard");
const { find } = require("./python");

const KRL = { language: "krl", scheme: "file" };
const URDF = { scheme: "file", pattern: "**/*.{urdf,xacro}" };

/** The server and what it needs; started when the first file for it is opened. */
class Service {
  constructor(output) {
    this.output = output;
    this.status = vscode.window.createStatusBarItem("lwr-dyn", vscode.StatusBarAlignment.Right, 50);
    this.status.name = "lwr-dyn";
    this.status.command = "lwr-dyn.restart";
    this.starting = undefined;
  }

  /** The way to start `lwr-dyn`, undefined where there is none; looked for once. */
  command() {
    this.starting ??= this.start();
    return this.starting;
  }

  async restart() {
    await this.starting;
    await this.stop();
    return this.command();
  }

  async stop() {
    const client = this.client;
    this.client = this.starting = undefined;
    await client?.dispose().catch(() => {});
  }

  async start() {
    this.status.show();
    if (!vscode.workspace.isTrusted) return this.say("$(shield) lwr-dyn", "This workspace is not trusted: nothing is started. Colours, folds and snippets work.");
    this.say("$(sync~spin) lwr-dyn", "Looking for lwr-dyn");
    const folder = vscode.workspace.workspaceFolders?.[0]?.uri;
    const found = await find(vscode, folder, (line) => this.output.info(line));
    if (found.missing) return this.say("$(warning) lwr-dyn", `Colours, folds and snippets work. For diagnoses install Python 3.11 and lwr-dyn[krl,urdf], or name it in the setting lwr-dyn.command (${found.missing}).`);
    const { command, server, where } = found;
    const run = { command: command[0], args: [...command.slice(1), ...server.args], options: { cwd: folder?.fsPath } };
    this.client = new LanguageClient("lwr-dyn", "lwr-dyn", run, { documentSelector: server.urdf ? [KRL, URDF] : [KRL], outputChannel: this.output });
    try {
      await this.client.start();
    } catch (error) {
      return this.say("$(error) lwr-dyn", `The server did not start: ${error.message}`);
    }
    this.say("lwr-dyn", server.urdf ? where : `${where}; this version judges URDF by command only`);
    return command;
  }

  say(text, tooltip) {
    [this.status.text, this.status.tooltip] = [text, tooltip];
    if (text.includes("warning") || text.includes("error")) this.output.warn(tooltip);
    return undefined;
  }
}

const isOurs = (document) => vscode.languages.match([KRL, URDF], document) > 0;

exports.activate = async (context) => {
  const output = vscode.window.createOutputChannel("lwr-dyn", { log: true });
  const service = new Service(output);
  const problems = vscode.languages.createDiagnosticCollection("lwr-dyn workspace");
  const guard = new ByteGuard(vscode, (line) => output.info(line));
  const opened = (document) => {
    if (!isOurs(document)) return;
    service.command().then((command) => command && problems.delete(document.uri)); // now judged as it is typed
    if (document.languageId === "krl" && !opened.set) {
      opened.set = true;
      setEncoding(vscode).then((written) => written && output.info("user setting: [krl] files.encoding = windows1252, which the controller writes"), (error) => output.warn(error.message));
    }
  };
  context.subscriptions.push(
    output,
    problems,
    service.status,
    ...guard.start(),
    ...Object.entries(commands({ vscode, service, problems, output, subscriptions: context.subscriptions })).map(([name, act]) => vscode.commands.registerCommand(`lwr-dyn.${name}`, act)),
    vscode.workspace.onDidOpenTextDocument(opened),
    vscode.workspace.onDidGrantWorkspaceTrust(() => service.restart()),
    vscode.workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("lwr-dyn.command") && service.restart()),
    { dispose: () => service.stop() },
  );
  vscode.workspace.textDocuments.forEach(opened);
};
