"""Makes the explorer's bundle of three.js again: `python scripts/build_three.py FOLDER`, with three and esbuild in it.

FOLDER holds node_modules of `npm install three@0.187.0 esbuild@0.28.2`. The page pastes the file in as it is. Its first
lines name the version and the licence; three.sha256 beside it holds its digest, which a test compares.
"""

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
BUNDLE = HERE.parent / "lwr_dyn" / "pages" / "explorer" / "bundle"
HEAD = """/* three.js {version} with OrbitControls and TransformControls; esbuild {builder}, scripts/build_three.py
{licence}*/
"""


SHADER = re.compile(r"`(?=[^`]*\n)[^`$\\]{40,}`")
"""A template literal of several lines; shorter ones are separators and messages."""


def shaders_without_space(script: str) -> str:
    """The script whose shaders, template literals in GLSL, have no space that only people need, and no comments.

    A line that begins with # (preprocessor) keeps its inner space; line ends stay.
    """

    def line(text: str) -> str:
        text = text.strip().partition("//")[0].rstrip()
        return text if text.startswith("#") else re.sub(r"\s*([-+*/=<>!&|?:;,(){}\[\]])\s*", r"\1", text)

    def shader(found: re.Match[str]) -> str:
        lines = [line(each) for each in found[0][1:-1].split("\n")]
        return "`" + "\n".join(each for each in lines if each) + "`"

    return SHADER.sub(shader, script)


def main(folder: Path) -> None:
    """Write the bundle and its digest."""
    modules = folder.resolve() / "node_modules"
    entry = folder.resolve() / "lwr_dyn_entry.js"  # esbuild looks for three beside its entry
    entry.write_text((HERE / "three_entry.js").read_text(encoding="utf-8"), encoding="utf-8")
    command = [modules / ".bin" / "esbuild", entry, "--bundle", "--minify", "--format=iife", "--global-name=lwrThree"]
    command += ["--charset=ascii", "--legal-comments=none"]
    script = shaders_without_space(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    versions = [json.loads((modules / name / "package.json").read_text())["version"] for name in ("three", "esbuild")]
    licence = (modules / "three" / "LICENSE").read_text(encoding="utf-8")
    text = HEAD.format(version=versions[0], builder=versions[1], licence=licence) + script
    if "</script" in text.lower():
        raise SystemExit("the bundle would close the script element that it is pasted into")
    (BUNDLE / "three.min.js").write_text(text, encoding="utf-8")
    digest = hashlib.sha256(text.encode()).hexdigest()
    (BUNDLE / "three.sha256").write_text(f"{digest}  three.min.js\n", encoding="utf-8")
    print(f"three.min.js: {len(text.encode())} bytes, sha256 {digest}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
