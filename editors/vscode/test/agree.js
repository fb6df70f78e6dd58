// The scopes that the grammar gives to tokens: `node agree.js GRAMMAR < [[line, [column, ...]], ...]`, as one JSON list.

const fs = require("node:fs");
const oniguruma = require("vscode-oniguruma");
const { INITIAL, Registry, parseRawGrammar } = require("vscode-textmate");

async function main(file) {
  await oniguruma.loadWASM(fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm")).buffer);
  const onigLib = Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  });
  const loadGrammar = async () => parseRawGrammar(fs.readFileSync(file, "utf8"), file);
  const grammar = await new Registry({ onigLib, loadGrammar }).loadGrammar("source.krl");
  const lines = JSON.parse(fs.readFileSync(0, "utf8"));
  const scopes = lines.map(([text, columns]) => {
    const found = grammar.tokenizeLine(text, INITIAL);
    if (found.ruleStack.depth !== 1) throw new Error(`a rule runs on into the next line: ${text}`);
    return columns.map((column) => found.tokens.findLast((token) => token.startIndex <= column).scopes.at(-1));
  });
  process.stdout.write(JSON.stringify(scopes));
}

main(process.argv[2]);
