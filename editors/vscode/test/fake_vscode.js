// As much of the editor as the guard sees: documents that are read, edited and saved as VS Code does it.

const fs = require("node:fs");

const IN_1252 = "€\uFFFD‚ƒ„…†‡ˆ‰Š‹Œ\uFFFDŽ\uFFFD\uFFFD‘’“”•–—˜™š›œ\uFFFDžŸ";
const byteSign = { windows1252: (b) => (b >= 0x80 && b < 0xa0 ? IN_1252[b - 0x80] : String.fromCharCode(b)), iso88591: (b) => String.fromCharCode(b) };

function decode(bytes, encoding) {
  if (encoding === "utf8") return new TextDecoder("utf-8", { ignoreBOM: true }).decode(bytes);
  if (encoding === "utf8bom") return new TextDecoder("utf-8").decode(bytes);
  return [...bytes].map(byteSign[encoding]).join("");
}

function encode(text, encoding) {
  if (encoding === "utf8") return Buffer.from(text);
  if (encoding === "utf8bom") return Buffer.concat([Buffer.from([0xef, 0xbb, 0xbf]), Buffer.from(text)]);
  const byte = (sign) => {
    for (let b = 0; b < 256; b++) if (byteSign[encoding](b) === sign && sign !== "\uFFFD") return b;
    return "?".charCodeAt(0); // what the editor writes, without a word
  };
  return Buffer.from([...text].map(byte));
}

class CancellationError extends Error {}

function event() {
  const listeners = [];
  const on = (listener) => (listeners.push(listener), { dispose() {} });
  return { on, fire: (value) => Promise.all(listeners.map((listener) => listener(value))) };
}

/** The editor: `settings` are the user's, `answers` what the user presses in messages, `said` what was shown. */
function fakeVscode({ encoding = "utf8", answers = [], settings = {} } = {}) {
  const opened = event(), changed = event(), saved = event(), closed = event(), active = event();
  const [said, ran, providers, documents] = [[], [], [], []];

  const say = async (text, ...choices) => (said.push(text), choices.find((choice) => answers.includes(choice)));

  class Document {
    constructor(file, languageId) {
      Object.assign(this, { uri: uri(file), languageId, encoding, isDirty: false, isClosed: false, past: [] });
      this.read();
    }

    read() {
      const text = decode(fs.readFileSync(this.uri.fsPath), this.encoding);
      this.eol = (text.match(/\r\n/g)?.length ?? 0) * 2 > (text.match(/\n/g)?.length ?? 0) ? 2 : 1;
      this.text = text.replace(/\r\n|\r|\n/g, this.eol === 2 ? "\r\n" : "\n"); // the editor makes line ends one
    }

    getText() {
      return this.text;
    }

    async edit(change) {
      this.past.push(this.text);
      this.text = change(this.text);
      this.isDirty = true;
      await changed.fire({ document: this });
    }

    async undo() {
      if (!this.past.length) return;
      this.future = this.text;
      this.text = this.past.pop();
      await changed.fire({ document: this, reason: 1 });
    }

    /** Asked by a user, or after a delay: then no code action is asked. */
    async save(afterDelay = false) {
      try {
        if (!afterDelay) for (const provider of providers) await provider.provideCodeActions(this, undefined, { only: { value: "source.lwr-dyn.keepBytes" } });
      } catch (error) {
        if (error instanceof CancellationError) return false;
        throw error;
      }
      fs.writeFileSync(this.uri.fsPath, encode(this.text, this.encoding));
      this.isDirty = false;
      await saved.fire(this);
      return true;
    }
  }

  const uri = (file) => ({ scheme: "file", fsPath: file, toString: () => `file://${file}` });

  const vscode = {
    CancellationError,
    CodeActionKind: class { constructor(value) { this.value = value; } },
    ConfigurationTarget: { Global: 1 },
    EndOfLine: { LF: 1, CRLF: 2 },
    TextDocumentChangeReason: { Undo: 1, Redo: 2 },
    commands: {
      async executeCommand(name) {
        ran.push(name);
        const document = vscode.window.activeTextEditor?.document;
        if (name === "redo") [document.text] = [document.future, document.past.push(document.text)];
        if (name === "workbench.action.files.revert") (document.read(), (document.isDirty = false), await changed.fire({ document }));
      },
    },
    extensions: { getExtension: () => undefined },
    languages: { registerCodeActionsProvider: (_, provider) => (providers.push(provider), { dispose() {} }) },
    window: {
      onDidChangeActiveTextEditor: active.on,
      showErrorMessage: say,
      showWarningMessage: say,
      async showTextDocument(document) {
        vscode.window.activeTextEditor = { document };
        await active.fire({ document });
      },
    },
    workspace: {
      textDocuments: documents,
      onDidOpenTextDocument: opened.on,
      onDidChangeTextDocument: changed.on,
      onDidSaveTextDocument: saved.on,
      onDidCloseTextDocument: closed.on,
      decode: async (bytes, options) => decode(bytes, options.encoding),
      encode: async (text, options) => encode(text, options.encoding),
      getConfiguration: () => ({
        get: (name) => settings[name],
        inspect: () => settings,
        update: async (...update) => ran.push(update),
      }),
      async openTextDocument(address, options) {
        const document = documents.find((each) => each.uri.toString() === address.toString());
        if (document.isDirty) throw new Error("Cannot re-open a dirty text document with different encoding. Save it first.");
        document.past.push(document.text); // opening again can be undone
        document.encoding = options.encoding;
        document.read();
        await changed.fire({ document });
        return document;
      },
    },
  };

  /** Open a file in front, as a user does. */
  async function open(file, languageId) {
    const document = new Document(file, languageId);
    documents.push(document);
    vscode.window.activeTextEditor = { document };
    await opened.fire(document);
    await active.fire({ document });
    return document;
  }
  return { vscode, open, said, ran };
}

module.exports = { decode, encode, fakeVscode };
