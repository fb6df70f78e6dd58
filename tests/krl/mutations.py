"""Sample programs beside this file, and seeded mutations of their bytes and lines."""

import random
from pathlib import Path

PROGRAMS = Path(__file__).parent / "programs"
SOURCES = sorted(PROGRAMS.glob("*.src"))
_SCRAPS = [
    b"PTP ", b"LIN ", b"{", b"}", b"(", b")", b"[", b"]", b'"', b"'", b";", b":", b"=", b"==", b",", b".", b"-", b"\t",
    b"\r", b"\n", b"\r\n", b"\x00", b"\xff", b"\xe4", b"\xc3\xbc", b"&", b"#", b"$", b"ENDIF", b"IF ", b"THEN",
    b"LOOP\n",
    b"ENDLOOP\n", b"END\n", b"DEF x( )\n", b"DECL ", b"INT ", b"NOT ", b"1E999", b"99999999999", b"'B2'", b"0", b"/0",
    b"FOR i=1 TO 1000000000\n", b"ENDFOR\n", b"SWITCH 1\n", b"CASE 1\n", b"GOTO again\n", b"WAIT SEC -1\n", b"CIRC ",
    b"PTP_REL {A1 720}\n", b"again:\n", b"RETURN\n", b"$VEL.CP=0\n", b"$OV_PRO=1000\n", b"shake(1)\n", b"C_DIS",
    b"C_PTP",
    b"$BASE={X 1}\n", b"x = x\n", b"{A1 0, A2 -90, A3 90, A4 0, A5 0, A6 0}", b"{X 91,Y -1139,Z 1392,A 0,B 0,C 0}",
]  # fmt: skip


def mutated(data: bytes, rng: random.Random) -> bytes:
    """One to eight small changes: bytes, scraps, lines removed, doubled or swapped, the end cut off."""
    for _ in range(rng.randint(1, 8)):
        data = rng.choice(_CHANGES)(data, rng)
    return data


def _cut(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + data[at + rng.randint(1, 12) :]


def _byte(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + bytes([rng.randrange(256)]) + data[at:]


def _scrap(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(_SCRAPS) + data[at + rng.choice((0, 0, 1, 4)) :]


def _end(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)] if rng.random() < 0.2 else data


def _lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if lines:
        i, j, kind = rng.randrange(len(lines)), rng.randrange(len(lines)), rng.randrange(3)
        if kind == 0:
            del lines[i]
        elif kind == 1:
            lines.insert(j, lines[i])
        else:
            lines[i], lines[j] = lines[j], lines[i]
    return b"".join(lines)


_CHANGES = (_cut, _byte, _scrap, _scrap, _end, _lines, _lines)
