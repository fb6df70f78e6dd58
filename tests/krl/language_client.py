"""A scripted editor: starts `lwr-dyn lsp` and speaks the Language Server Protocol with it."""

import json
import queue
import subprocess
import sys
import threading
import time
from pathlib import Path
from urllib.parse import unquote

PATIENCE = 60.0


class LanguageClient:
    """One server process; `texts` are the files that are open."""

    def __init__(self, folder, encodings=("utf-16",), options=(), **capabilities):
        self.began = time.perf_counter()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "lwr_dyn", "lsp", *options], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self.messages = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.count, self.versions = 0, {}
        self.other = []
        uri = None if folder is None else Path(folder).as_uri()
        folders = None if folder is None else [{"uri": uri, "name": "backup"}]
        general = {"positionEncodings": list(encodings)}
        wishes = {"general": general, **capabilities}
        initialize = {"processId": None, "rootUri": uri, "capabilities": wishes, "workspaceFolders": folders}
        self.capabilities = self.request("initialize", initialize)["capabilities"]
        self.notify("initialized", {})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.request("shutdown", None)
            self.notify("exit", None)
            self.process.wait(timeout=PATIENCE)
        self.process.stdin.close()
        self.process.stdout.close()

    def _read(self):
        stream = self.process.stdout
        while header := stream.readline():
            length = int(header.split(b":")[1])
            while stream.readline().strip():
                pass
            self.messages.put((time.perf_counter(), json.loads(stream.read(length))))
        self.messages.put((time.perf_counter(), {"ended": True}))

    def send(self, message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))
        self.process.stdin.flush()

    def notify(self, method, params):
        self.send({"method": method, "params": params})

    def request(self, method, params):
        message = self._answer(method, params)
        assert "error" not in message, message
        return message["result"]

    def refused(self, method, params):
        """What an error says."""
        return self._answer(method, params)["error"]["message"]

    def _answer(self, method, params):
        self.count += 1
        wanted = self.count
        self.send({"id": wanted, "method": method, "params": params})
        return self.until(lambda m: m.get("id") == wanted and "method" not in m)[1]

    def until(self, holds):
        """(Time, message) of the next message that is wanted; the others are kept in `other`."""
        for kept in self.other:
            if holds(kept[1]):
                self.other.remove(kept)
                return kept
        end = time.perf_counter() + PATIENCE
        while True:
            got = self.messages.get(timeout=max(0.01, end - time.perf_counter()))
            assert "ended" not in got[1], "the server has ended"
            if holds(got[1]):
                return got
            self.other.append(got)

    def open(self, path, text, language="krl"):
        self.versions[path] = 1
        document = {"uri": path.as_uri(), "languageId": language, "version": 1, "text": text}
        self.notify("textDocument/didOpen", {"textDocument": document})

    def change(self, path, text):
        self.versions[path] += 1
        document = {"uri": path.as_uri(), "version": self.versions[path]}
        self.notify("textDocument/didChange", {"textDocument": document, "contentChanges": [{"text": text}]})

    def diagnostics(self, path):
        """(Time, diagnoses) of the next publication for a file."""
        uri = path.as_uri()
        at, message = self.until(
            lambda m: m.get("method") == "textDocument/publishDiagnostics" and m["params"]["uri"] == uri
        )
        return at, message["params"]["diagnostics"]

    def save(self, path):
        self.notify("textDocument/didSave", {"textDocument": {"uri": path.as_uri()}})

    def close(self, path):
        self.notify("textDocument/didClose", {"textDocument": {"uri": path.as_uri()}})

    def ask(self, what, path, line, character, **more):
        return self.of(what, path, position={"line": line, "character": character}, **more)

    def of(self, what, path, **more):
        """The answer about a file."""
        return self.request(f"textDocument/{what}", {"textDocument": {"uri": path.as_uri()}, **more})


def short(answer):
    """An answer with its ranges as (line, character, line, character), and files by the end of their addresses."""
    if isinstance(answer, list):
        return [short(x) for x in answer]
    if not isinstance(answer, dict):
        return answer
    if answer.keys() == {"start", "end"}:
        return tuple(answer[end][of] for end in ("start", "end") for of in ("line", "character"))
    return {key: unquote(x).rpartition("/")[2] if key == "uri" else short(x) for key, x in answer.items()}


def span(first, last):
    """A range from one (line, character) to another."""
    return {end: dict(zip(("line", "character"), x, strict=True)) for end, x in (("start", first), ("end", last))}
