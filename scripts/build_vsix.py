"""Build the extension for VS Code: `python scripts/build_vsix.py [--modules FOLDER] [OUT.vsix]`.

FOLDER holds the packages of editors/vscode/package-lock.json, as `npm ci --ignore-scripts` puts them there (default).
esbuild makes one script of our sources and the client library; the .vsix is a zip with the same bytes each time. The
licences of what is bundled are in it, THIRD_PARTY.txt.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

EDITOR = Path(__file__).resolve().parent.parent / "editors" / "vscode"
FILES = ("LICENSE", "README.md", "language-configuration.json", "package.json", "snippets/krl.json",
         "syntaxes/krl.tmLanguage.json")  # fmt: skip
"""What is packed as it stands; dist/extension.js and THIRD_PARTY.txt are made."""
ALLOWED = {"MIT", "ISC", "BlueOak-1.0.0", "BSD-2-Clause", "BSD-3-Clause"}
"""Licences under which a package may be bundled."""
TYPES = {"json": "application/json", "js": "application/javascript", "md": "text/markdown", "txt": "text/plain",
         "vsixmanifest": "text/xml"}  # fmt: skip


def bundled(modules: Path) -> tuple[str, list[str]]:
    """The script, and the names of the packages of which something is in it."""
    with tempfile.TemporaryDirectory() as folder:
        out, meta = Path(folder) / "extension.js", Path(folder) / "meta.json"
        options = ["--bundle", "--minify", "--platform=node", "--target=node20", "--format=cjs", "--external:vscode"]
        options += ["--charset=ascii", "--legal-comments=none", f"--outfile={out}", f"--metafile={meta}"]
        command = [str(modules / ".bin" / "esbuild"), str(EDITOR / "src" / "extension.js"), "--log-level=warning"]
        subprocess.run([*command, *options], check=True, env={**os.environ, "NODE_PATH": str(modules)})
        inputs = json.loads(meta.read_text(encoding="utf-8"))["inputs"]
        names = {match[1] for name in inputs if (match := re.search(r"node_modules/((?:@[^/]+/)?[^/]+)/", name))}
        return out.read_text(encoding="utf-8"), sorted(names)


def licences(modules: Path, names: Iterable[str]) -> str:
    """Name, version and licence of each package that is bundled; raises SystemExit for one that may not be."""
    parts = []
    for name in names:
        about = json.loads((modules / name / "package.json").read_text(encoding="utf-8"))
        texts = sorted(path for path in (modules / name).iterdir() if re.match(r"licen[cs]e", path.name, re.I))
        if about["license"] not in ALLOWED or not texts:
            raise SystemExit(
                f"{name}: licence {about['license']}; allowed: {', '.join(sorted(ALLOWED))}, with its text"
            )
        text = texts[0].read_text(encoding="utf-8").strip()
        parts.append(f"{name} {about['version']}: {about['license']}\n\n{text}\n")
    return ("\n" + "-" * 80 + "\n\n").join(parts)


def manifest(about: Mapping[str, object]) -> str:
    """What a gallery and the editor read of the package."""
    identity = " ".join(
        f"{key}={quoteattr(str(value))}"
        for key, value in (("Language", "en-US"), ("Id", about["name"]), ("Version", about["version"]),
                           ("Publisher", about["publisher"]))
    )  # fmt: skip
    engines, kind = about["engines"], about["extensionKind"]
    assert isinstance(engines, dict)
    assert isinstance(kind, list)
    properties = {"Engine": engines["vscode"], "ExtensionDependencies": "", "ExtensionPack": "",
                  "ExtensionKind": ",".join(kind)}  # fmt: skip
    tags, categories = (",".join(about[key]) for key in ("keywords", "categories"))  # type: ignore[arg-type]
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        '<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">',
        f"<Metadata><Identity {identity}/>",
        f"<DisplayName>{escape(str(about['displayName']))}</DisplayName>",
        f'<Description xml:space="preserve">{escape(str(about["description"]))}</Description>',
        f"<Tags>{escape(tags)}</Tags><Categories>{escape(categories)}</Categories><Properties>",
        *(f'<Property Id="Microsoft.VisualStudio.Code.{key}" Value={quoteattr(value)}/>'
          for key, value in properties.items()),
        "</Properties><License>extension/LICENSE</License></Metadata>",
        '<Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation><Dependencies/><Assets>',
        *(f'<Asset Type="Microsoft.VisualStudio.{kind}" Path="extension/{path}" Addressable="true"/>'
          for kind, path in (("Code.Manifest", "package.json"), ("Services.Content.Details", "README.md"),
                             ("Services.Content.License", "LICENSE"))),
        "</Assets></PackageManifest>",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def content_types() -> str:
    """The kinds of the files by their endings."""
    rows = "".join(f'<Default Extension=".{ending}" ContentType="{kind}"/>' for ending, kind in TYPES.items())
    licence = '<Override PartName="/extension/LICENSE" ContentType="text/plain"/>'
    space = "http://schemas.openxmlformats.org/package/2006/content-types"
    return f'<?xml version="1.0" encoding="utf-8"?>\n<Types xmlns="{space}">{rows}{licence}</Types>\n'


def build(out: Path, modules: Path) -> None:
    """Write the package."""
    script, names = bundled(modules)
    about = json.loads((EDITOR / "package.json").read_text(encoding="utf-8"))
    texts = {"[Content_Types].xml": content_types(), "extension.vsixmanifest": manifest(about)}
    texts |= {f"extension/{name}": (EDITOR / name).read_text(encoding="utf-8") for name in FILES}
    texts |= {"extension/dist/extension.js": script, "extension/THIRD_PARTY.txt": licences(modules, names)}
    out.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as package:
        for name, text in sorted(texts.items()):
            row = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            row.external_attr, row.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
            package.writestr(row, text.encode())
    print(f"wrote {out}: {out.stat().st_size} bytes, {len(texts)} files; bundled: {', '.join(names)}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", nargs="?", type=Path, default=EDITOR / "dist" / "lwr-dyn.vsix")
    parser.add_argument("--modules", type=Path, default=EDITOR / "node_modules", help="The packages of the lock file.")
    options = parser.parse_args()
    if not (options.modules / ".bin" / "esbuild").exists():
        parser.error(f"{options.modules}: no packages; run npm ci --ignore-scripts in {EDITOR}")
    build(options.out, options.modules.resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
