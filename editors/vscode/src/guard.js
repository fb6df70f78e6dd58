// Never save a byte that was not read: each file of KRL and URDF is compared with its bytes when it is opened.
//
// VS Code opens a file in the encoding of the settings. Bytes that do not fit become U+FFFD, and saving would write that.
// So: the file is opened again in the encoding that its bytes have; where that is not possible its editor is read-only;
// and whoever saves it all the same (Save All, auto save, an edit before this extension was awake) is refused by a lock
// on the file, because an extension cannot cancel a save. What was saved in spite of the lock is put right afterwards.

const fs = require("node:fs");
const path = require("node:path");
const { LOST, countOf, encodingOf, lineEnds, restored, unwritable, writtenLosses } = require("./texts");

const LOCKED_FOR = 10_000; // [ms] a save that was refused does not say so: the lock is taken off after this time
const WRITERS = 0o222;

class ByteGuard {
  /** `vscode` is the editor's interface; `log` takes lines. */
  constructor(vscode, log) {
    this.vscode = vscode;
    this.log = log;
    this.files = new Map(); // address -> { bytes, encoding, fault, tried, allowed, readonly }
    this.locks = new Map(); // path -> { mode, timer }
  }

  /** What an extension must give back at its end. */
  start() {
    const { workspace, window } = this.vscode;
    const parts = [
      workspace.onDidOpenTextDocument((document) => this.look(document)),
      workspace.onDidChangeTextDocument((event) => event.document.isDirty || this.look(event.document)),
      workspace.onDidSaveTextDocument((document) => this.saved(document)),
      workspace.onDidCloseTextDocument((document) => this.closed(document)),
      workspace.onWillSaveTextDocument((event) => this.willSave(event)),
      window.onDidChangeActiveTextEditor(() => this.showReadonly()),
      { dispose: () => [...this.locks.keys()].forEach((file) => this.unlock(file)) },
    ];
    for (const document of workspace.textDocuments) this.look(document);
    return parts;
  }

  /** Whether a document is a file of KRL or URDF on a disk. */
  guards(document) {
    return document.uri.scheme === "file" && (document.languageId === "krl" || /\.(urdf|xacro)$/i.test(document.uri.fsPath));
  }

  /** Compare a document with its bytes; open it again in the right encoding where it was read in another. */
  async look(document) {
    if (!this.guards(document)) return;
    const key = document.uri.toString();
    const bytes = await fs.promises.readFile(document.uri.fsPath).catch(() => null);
    if (bytes === null || document.isClosed) return;
    const before = this.files.get(key);
    const record = { ...before, bytes, encoding: document.encoding, fault: await this.fault(document, bytes) };
    this.files.set(key, record);
    const right = encodingOf(bytes, document.languageId === "krl", document.encoding);
    const other = right !== undefined && right !== document.encoding && (record.fault === "lost" || right === "utf8");
    if (other && !record.tried && (await this.reopen(document, right))) return this.look(document);
    if (record.fault === "lost" && !before?.fault) this.say(document);
    await this.showReadonly();
  }

  /** Why saving the document would change bytes that no one edited: "lost" signs, line "ends", or null. */
  async fault(document, bytes) {
    const { workspace } = this.vscode;
    const text = document.getText();
    const written = document.encoding.startsWith("utf8") ? writtenLosses(bytes) : 0;
    if (countOf(text, LOST) > written) return "lost";
    if (document.isDirty) return null;
    const read = await workspace.decode(bytes, { encoding: document.encoding });
    return lineEnds(read).size > 1 ? "ends" : null;
  }

  /** Open it again in another encoding, once; a document with changes cannot be. */
  async reopen(document, encoding) {
    this.files.get(document.uri.toString()).tried = true;
    if (document.isDirty) return false;
    try {
      await this.vscode.workspace.openTextDocument(document.uri, { encoding });
      this.log(`${document.uri.fsPath}: opened again as ${encoding}`);
      return document.encoding === encoding;
    } catch (error) {
      this.log(`${document.uri.fsPath}: not opened again as ${encoding}: ${error.message}`);
      return false;
    }
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

  /** Before a save: lock the file where it would lose something. Without a wait: what waits may come too late. */
  willSave({ document }) {
    if (!this.guards(document)) return;
    const record = this.files.get(document.uri.toString());
    const text = document.getText();
    const odd = unwritable(text, document.encoding);
    if (record?.fault === "lost" && text.includes(LOST)) this.lock(document);
    else if (record?.fault === "ends" && !record.allowed) this.lock(document);
    else if (odd) this.lock(document, odd);
    else this.unlock(document.uri.fsPath);
  }

  lock(document, odd) {
    const file = document.uri.fsPath;
    try {
      const { mode } = fs.statSync(file);
      const held = this.locks.get(file);
      clearTimeout(held?.timer);
      fs.chmodSync(file, mode & ~WRITERS);
      const timer = setTimeout(() => this.unlock(file), LOCKED_FOR);
      timer.unref?.();
      this.locks.set(file, { mode: held?.mode ?? mode, timer });
    } catch (error) {
      this.log(`${file}: cannot be locked: ${error.message}`);
    }
    this.say(document, odd);
  }

  unlock(file) {
    const held = this.locks.get(file);
    if (!held) return;
    clearTimeout(held.timer);
    this.locks.delete(file);
    try {
      fs.chmodSync(file, held.mode);
    } catch (error) {
      this.log(`${file}: cannot be unlocked: ${error.message}`);
    }
  }

  /** After a save: nothing may be lost that was read. */
  async saved(document) {
    if (!this.guards(document)) return;
    this.unlock(document.uri.fsPath);
    const record = this.files.get(document.uri.toString());
    if (record?.fault === "lost") {
      const bytes = await fs.promises.readFile(document.uri.fsPath);
      if (writtenLosses(bytes) > writtenLosses(record.bytes)) return this.mend(document, record);
    }
    await this.look(document);
  }

  /** Put the lost signs back into a file that was saved in spite of the lock; else keep its bytes beside it. */
  async mend(document, record) {
    const file = document.uri.fsPath;
    if (await this.write(document, record)) {
      this.vscode.window.showWarningMessage(`${path.basename(file)} was saved in the wrong encoding: the signs that were lost are put back.`);
      return;
    }
    const kept = `${file}.before`;
    await fs.promises.writeFile(kept, record.bytes, { flag: "wx" }).catch((error) => this.log(`${kept}: ${error.message}`));
    this.vscode.window.showErrorMessage(`${path.basename(file)} was saved with signs that were lost in reading. As it was: ${path.basename(kept)}.`);
  }

  /** Write the document in the encoding of its file, with its lost signs, and open it again; whether that was possible. */
  async write(document, record) {
    const { workspace, window, commands } = this.vscode;
    const encoding = encodingOf(record.bytes, document.languageId === "krl", document.encoding);
    if (encoding === undefined || encoding === record.encoding) return false;
    const decode = (bytes) => workspace.decode(bytes, { encoding });
    const text = await restored(document.getText(), record.bytes, record.encoding, decode);
    if (text === null || unwritable(text, encoding) || lineEnds(await decode(record.bytes)).size > 1) return false;
    this.unlock(document.uri.fsPath);
    await fs.promises.writeFile(document.uri.fsPath, await workspace.encode(text, { encoding }));
    record.tried = false;
    await window.showTextDocument(document);
    await commands.executeCommand("workbench.action.files.revert");
    await this.look(document);
    return true;
  }

  /** Say why a document is not saved, with what can be done. */
  async say(document, odd) {
    const { window, commands } = this.vscode;
    const name = path.basename(document.uri.fsPath);
    const record = this.files.get(document.uri.toString());
    if (odd) {
      const sign = `${odd.sign} (U+${odd.sign.codePointAt(0).toString(16).toUpperCase().padStart(4, "0")})`;
      return window.showErrorMessage(`${name} is not saved: line ${odd.line} has ${sign}, which ${document.encoding} cannot write.`);
    }
    if (record.fault === "ends") {
      const all = document.eol === this.vscode.EndOfLine.CRLF ? "CRLF" : "LF";
      const answer = await window.showWarningMessage(`${name} is not saved: its lines end in different ways, and VS Code would write all as ${all}.`, `Save all as ${all}`);
      if (answer) {
        record.allowed = true;
        this.unlock(document.uri.fsPath);
        await document.save();
      }
      return;
    }
    const right = encodingOf(record.bytes, document.languageId === "krl", document.encoding);
    const lost = `${name} was read as ${record.encoding}, which it is not: signs are lost (\uFFFD), so it is not saved.`;
    const choices = right && document.isDirty ? [`Save as ${right}`] : ["Choose the encoding"];
    const answer = await window.showErrorMessage(lost, ...choices);
    if (answer === "Choose the encoding") {
      await window.showTextDocument(document);
      await commands.executeCommand("workbench.action.editor.changeEncoding");
    } else if (answer && !(await this.write(document, record))) {
      window.showErrorMessage(`${name}: signs that were lost were also edited. Undo your changes, or File: Revert File; then it is opened as ${right}.`);
    }
  }

  closed(document) {
    this.unlock(document.uri.fsPath);
    this.files.delete(document.uri.toString());
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
