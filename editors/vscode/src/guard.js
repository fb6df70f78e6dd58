// Never save a byte that was not read: each file of KRL and URDF is compared with its bytes when it is opened.
//
// VS Code opens a file in the encoding of the settings. Bytes that do not fit become U+FFFD, and saving would write that.
// So: the file is opened again in the encoding that its bytes have; where that is not possible its editor is read-only,
// and a save is refused. An extension cannot cancel a save when it is asked before it (onWillSaveTextDocument), but a code
// action on save that ends as cancelled does. It is not asked before a save after a delay, so package.json turns that off
// for KRL. What was saved in spite of all this is put right afterwards.

const fs = require("node:fs/promises");
const path = require("node:path");
const { LOST, countOf, encodingOf, lineEnds, restored, unwritable, writtenLosses } = require("./texts");

const KIND = "source.lwr-dyn.keepBytes"; // on save, by `editor.codeActionsOnSave` of package.json

class ByteGuard {
  /** `vscode` is the editor's interface; `log` takes lines. */
  constructor(vscode, log) {
    this.vscode = vscode;
    this.log = log;
    this.files = new Map(); // address -> { bytes, encoding, fault, seen, tried, reopened, allowed, readonly }
  }

  /** What an extension must give back at its end. */
  start() {
    const { languages, workspace, window } = this.vscode;
    const guarded = [{ language: "krl", scheme: "file" }, { scheme: "file", pattern: "**/*.{urdf,xacro}" }];
    const kinds = { providedCodeActionKinds: [new this.vscode.CodeActionKind(KIND)] };
    const parts = [
      languages.registerCodeActionsProvider(guarded, { provideCodeActions: (document, _, { only }) => this.asked(document, only) }, kinds),
      workspace.onDidOpenTextDocument((document) => this.look(document)),
      workspace.onDidChangeTextDocument((event) => this.changed(event)),
      workspace.onDidSaveTextDocument((document) => this.saved(document)),
      workspace.onDidCloseTextDocument((document) => this.files.delete(document.uri.toString())),
      window.onDidChangeActiveTextEditor(() => this.showReadonly()),
    ];
    for (const document of workspace.textDocuments) this.look(document);
    return parts;
  }

  /** Whether a document is a file of KRL or URDF on a disk. */
  guards(document) {
    return document.uri.scheme === "file" && (document.languageId === "krl" || /\.(urdf|xacro)$/i.test(document.uri.fsPath));
  }

  /** After a change: what is as on the disk is compared again; an undo stops where the file was opened again. */
  changed({ document, reason }) {
    const record = this.files.get(document.uri.toString());
    if (record?.reopened && reason === this.vscode.TextDocumentChangeReason.Undo && document.getText().includes(LOST)) {
      // opening again is one more edit for the editor: undone, the text is the lost one in the right encoding
      return this.vscode.commands.executeCommand("redo");
    }
    return document.isDirty ? undefined : this.look(document);
  }

  /** Compare a document with its bytes; open it again in the right encoding where it was read in another. */
  async look(document) {
    if (!this.guards(document)) return;
    const key = document.uri.toString();
    const bytes = await fs.readFile(document.uri.fsPath).catch(() => null);
    if (bytes === null || document.isClosed) return;
    const fault = await this.fault(document, bytes);
    const record = this.files.get(key) ?? {};
    const [had, first] = [record.fault, !record.seen];
    this.files.set(key, Object.assign(record, { bytes, encoding: document.encoding, fault, seen: !document.isDirty }));
    const right = encodingOf(bytes, document.languageId === "krl", document.encoding);
    const other = right !== undefined && right !== document.encoding && (fault === "lost" ? !record.tried : first && right === "utf8");
    if (other && (await this.reopen(document, record, right))) return this.look(document);
    if (fault === "lost" && had !== "lost") this.say(document, "lost");
    await this.showReadonly();
  }

  /** Why saving the document would change bytes that no one edited: "lost" signs, line "ends", or null. */
  async fault(document, bytes) {
    const { workspace } = this.vscode;
    const text = document.getText();
    const written = document.encoding.startsWith("utf8") ? writtenLosses(bytes) : 0;
    if (countOf(text, LOST) > written) return "lost";
    const read = await workspace.decode(bytes, { encoding: document.encoding });
    return lineEnds(read).size > 1 ? "ends" : null;
  }

  /** Open it again in another encoding, once; a document with changes cannot be. */
  async reopen(document, record, encoding) {
    if (document.isDirty) return false;
    record.tried = true;
    try {
      await this.vscode.workspace.openTextDocument(document.uri, { encoding });
    } catch (error) {
      this.log(`${document.uri.fsPath}: not opened again as ${encoding}: ${error.message}`);
      return false;
    }
    this.log(`${document.uri.fsPath}: opened again as ${encoding}`);
    record.reopened = !document.getText().includes(LOST);
    return document.encoding === encoding;
  }

  /** The editor in front is read-only while signs of its file are lost. */
  async showReadonly() {
    const document = this.vscode.window.activeTextEditor?.document;
    const record = document && this.files.get(document.uri.toString());
    if (!record || (record.fault === "lost") === Boolean(record.readonly)) return;
    record.readonly = record.fault === "lost";
    const what = record.readonly ? "setActiveEditorReadonlyInSession" : "resetActiveEditorReadonlyInSession";
    await this.vscode.commands.executeCommand(`workbench.action.files.${what}`);
  }

  /** Asked for code actions: there are none, but a save that would lose something ends here. */
  async asked(document, only) {
    if (only?.value !== KIND) return [];
    if (!this.files.has(document.uri.toString())) await this.look(document); // saved before it was compared
    const refusal = this.refusal(document);
    if (!refusal) return [];
    this.say(document, refusal);
    throw new this.vscode.CancellationError();
  }

  /** Why a document must not be saved as it is: "lost" signs, line "ends", a sign that its encoding lacks; else null. */
  refusal(document) {
    const record = this.files.get(document.uri.toString());
    const text = document.getText();
    if (record?.fault === "ends" && !record.allowed) return "ends";
    if (record?.fault === "lost" && text.includes(LOST)) return "lost";
    return unwritable(text, document.encoding);
  }

  /** After a save: nothing may be lost that was read. */
  async saved(document) {
    if (!this.guards(document)) return;
    const record = this.files.get(document.uri.toString());
    const odd = unwritable(document.getText(), document.encoding);
    if (record?.fault === "lost") {
      const bytes = await fs.readFile(document.uri.fsPath);
      if (writtenLosses(bytes) > writtenLosses(record.bytes)) return this.mend(document, record);
    } else if (odd) this.say(document, odd, "was saved with ? in its place");
    await this.look(document);
  }

  /** Put the lost signs back into a file that was saved in spite of this; else keep its bytes beside it. */
  async mend(document, record) {
    const file = document.uri.fsPath;
    if (await this.write(document, record)) {
      this.vscode.window.showWarningMessage(`${path.basename(file)} was saved in the wrong encoding: the characters that were lost are put back.`);
      return;
    }
    const kept = `${file}.before`;
    await fs.writeFile(kept, record.bytes, { flag: "wx" }).catch((error) => this.log(`${kept}: ${error.message}`));
    this.vscode.window.showErrorMessage(`${path.basename(file)} was saved with characters that were lost in reading. As it was: ${path.basename(kept)}.`);
  }

  /** Write the document in the encoding of its file, with its lost signs, and open it again; whether that was possible. */
  async write(document, record) {
    const { workspace, window, commands } = this.vscode;
    const encoding = encodingOf(record.bytes, document.languageId === "krl", document.encoding);
    if (encoding === undefined || encoding === record.encoding) return false;
    const decode = (bytes) => workspace.decode(bytes, { encoding });
    const text = await restored(document.getText(), record.bytes, record.encoding, decode);
    if (text === null || unwritable(text, encoding) || lineEnds(await decode(record.bytes)).size > 1) return false;
    await fs.writeFile(document.uri.fsPath, await workspace.encode(text, { encoding }));
    record.tried = false;
    await window.showTextDocument(document);
    await commands.executeCommand("workbench.action.files.revert");
    await this.look(document);
    return true;
  }

  /** Say why a document is not saved, and offer what can be done. */
  async say(document, refusal, what = "is not saved") {
    const { window, commands } = this.vscode;
    const name = path.basename(document.uri.fsPath);
    const record = this.files.get(document.uri.toString());
    if (refusal === "ends") {
      const all = document.eol === this.vscode.EndOfLine.CRLF ? "CRLF" : "LF";
      const ends = `${name} ${what}: its lines end in different ways, and VS Code would write all as ${all}.`;
      if (!(await window.showWarningMessage(ends, `Save all as ${all}`))) return;
      record.allowed = true;
      await document.save();
      return;
    }
    if (refusal !== "lost") {
      const code = `U+${refusal.sign.codePointAt(0).toString(16).toUpperCase().padStart(4, "0")}`;
      const sign = /[\p{L}\p{N}\p{P}\p{S}]/u.test(refusal.sign) ? refusal.sign : code;
      window.showErrorMessage(`${name} ${what}: line ${refusal.line} has ${sign}, not in ${document.encoding}`);
      return;
    }
    const right = encodingOf(record.bytes, document.languageId === "krl", document.encoding);
    const lost = `${name} was read as ${record.encoding}, which it is not: characters are lost (${LOST}), so it ${what}.`;
    const choices = right && right !== record.encoding && document.isDirty ? [`Save as ${right}`] : ["Choose the encoding"];
    const answer = await window.showErrorMessage(lost, ...choices);
    if (answer === "Choose the encoding") {
      await window.showTextDocument(document);
      await commands.executeCommand("workbench.action.editor.changeEncoding");
    } else if (answer && !(await this.write(document, record))) {
      window.showErrorMessage(`${name}: characters that were lost were also edited. Undo your changes, or File: Revert File; then it is opened as ${right}.`);
    }
  }
}

/** Have files of KRL opened as Windows 1252 from the next window on, unless the user has said otherwise; whether it was written. */
async function setEncoding(vscode) {
  // as a user's setting: configurationDefaults of an extension do not reach the reader of files (microsoft/vscode#39084)
  const files = vscode.workspace.getConfiguration("files", { languageId: "krl" });
  const now = files.inspect("encoding");
  const own = ["globalLanguageValue", "workspaceLanguageValue", "workspaceFolderLanguageValue", "workspaceValue", "workspaceFolderValue"];
  if (own.some((level) => now[level] !== undefined)) return false;
  await files.update("encoding", "windows1252", vscode.ConfigurationTarget.Global, true);
  return true;
}

module.exports = { ByteGuard, setEncoding };
