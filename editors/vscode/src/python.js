// Find `lwr-dyn`: the setting, the workspace's environment, the Python extension's choice, the path, a login shell's path.

const { execFile } = require("node:child_process");
const fs = require("node:fs/promises");
const path = require("node:path");

const WINDOWS = process.platform === "win32";

/** Run a command to its end: exit code (-1 where it did not start), what it printed. */
function run(command, args, options = {}) {
  return new Promise((resolve) => {
    execFile(command[0], [...command.slice(1), ...args], { maxBuffer: 2 ** 28, windowsHide: true, ...options }, (error, stdout, stderr) => {
      const code = error ? (typeof error.code === "number" ? error.code : -1) : 0;
      resolve({ code, stdout, stderr: stderr || (code === 0 ? "" : String(error)) });
    });
  });
}

const there = (file) => fs.access(file).then(() => true, () => false);

/** Ways to start it, the best first: [where it was found, command]. */
async function* candidates(vscode, folder) {
  const own = vscode.workspace.getConfiguration("lwr-dyn").get("command");
  if (own?.length) return yield ["the setting lwr-dyn.command", own];
  for (const name of folder ? [".venv", "venv"] : []) {
    const python = path.join(folder.fsPath, name, WINDOWS ? "Scripts/python.exe" : "bin/python");
    if (await there(python)) yield [`${name} of the workspace`, [python, "-m", "lwr_dyn"]];
  }
  const python = await chosenPython(vscode, folder);
  if (python) yield ["the Python extension", [python, "-m", "lwr_dyn"]];
  yield ["the path", ["lwr-dyn"]];
  if (!WINDOWS) {
    // the window may have been started by a desktop that does not read the profile
    const { stdout } = await run([process.env.SHELL || "/bin/sh"], ["-lc", "command -v lwr-dyn"], { timeout: 10_000 });
    const found = stdout.trim().split("\n").pop();
    if (path.isAbsolute(found)) yield ["the path of a login shell", [found]];
  }
}

async function chosenPython(vscode, folder) {
  const extension = vscode.extensions.getExtension("ms-python.python");
  if (!extension) return undefined;
  try {
    const { environments } = await extension.activate().then(() => extension.exports);
    const environment = await environments.resolveEnvironment(environments.getActiveEnvironmentPath(folder));
    return environment?.executable?.uri?.fsPath;
  } catch {
    return undefined;
  }
}

/** The servers that a version may have, the best first: its arguments, and whether it also judges URDF. */
const SERVERS = [
  { args: ["lsp"], urdf: true },
  { args: ["krl", "server"], urdf: false },
];

/** The first way that works: { where, command, server }, else { missing: why }. */
async function find(vscode, folder, log) {
  let missing = "lwr-dyn is not installed where it is looked for";
  for await (const [where, command] of candidates(vscode, folder)) {
    let result;
    for (const server of SERVERS) {
      result = await run(command, [...server.args, "--help"], { timeout: 60_000 });
      if (result.code === 0) {
        log(`${where}: ${command.join(" ")} ${server.args.join(" ")}`);
        return { where, command, server };
      }
    }
    const why = result.stderr.trim().split("\n").pop();
    log(`${where}: ${command.join(" ")}: ${why}`);
    if (result.code > 0 && !why.includes("No module named lwr_dyn")) missing = `${where}: ${why}`;
  }
  return { missing };
}

module.exports = { candidates, find, run };
