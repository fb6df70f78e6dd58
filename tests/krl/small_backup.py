"""A small backup: two modules, a $config.dat, and a second robot part whose names no other module sees."""

from lwr_dyn.krl.editor.referents import line_context

FILES = {
    "KRC/R1/Program/main.src": """&ACCESS RVP
DEF main( )
DECL INT i
DECL GRIP_T grip
;FOLD INI
BAS (#INITMOV,0 )
;ENDFOLD (INI)
PTP XHOME
again:
FOR i = 1 TO 3
  LIN pick C_DIS
  IF grip.state == #OPEN THEN
    close_it (grip, i)
  ENDIF
ENDFOR
$TOOL = TOOL_DATA[2]
shared_count = shared_count + i
helper ( )
GOTO again
END

DEF helper( )
DECL INT i
i = 2
SPEED = i
END
""",
    "KRC/R1/Program/main.dat": """DEFDAT main
DECL E6POS pick={X 100.0,Y 0.0,Z 900.0,A 0.0,B 90.0,C 0.0,S 2,T 2}
ENDDAT
""",
    "KRC/R1/Program/close_it.src": """DEF close_it(g:OUT, n:IN)
DECL GRIP_T g
DECL INT n
g.state = #SHUT
g.force = 1.5 * n
shared_count = 0
END
""",
    "KRC/R1/Program/close_it.dat": """DEFDAT close_it PUBLIC
DECL GLOBAL INT shared_count=7
DECL INT pick=1
ENDDAT
""",
    "KRC/R1/System/$config.dat": """DEFDAT $CONFIG
ENUM STATE_E OPEN, SHUT
STRUC GRIP_T STATE_E state, REAL force
DECL E6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}
DECL FRAME TOOL_DATA[16]
TOOL_DATA[1]={X 0.0,Y 0.0,Z 100.0,A 0.0,B 0.0,C 0.0}
TOOL_DATA[2]={X 0.0,Y 0.0,Z 200.0,A 0.0,B 0.0,C 0.0}
DECL REAL SPEED=0.25
ENDDAT
""",
    "KRC/STEU/$config.dat": "DEFDAT $CONFIG\nDECL REAL SPEED=9.0\nENDDAT\n",
}
MAIN = "KRC/R1/Program/main.src"
CLOSE = "KRC/R1/Program/close_it.src"
CONFIG = "KRC/R1/System/$config.dat"


def write_backup(folder):
    """The files in a folder, as a controller writes them."""
    for name, text in FILES.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.replace("\n", "\r\n").encode("latin-1"))
    return folder


def place_of(name, text, nth=0, word=""):
    """Line (from 0) and column (from 1) of the nth line that contains a text, at a word in it."""
    lines = FILES[name].split("\n")
    line = [i for i, x in enumerate(lines) if text in x][nth]
    return line, lines[line].index(text) + text.index(word or text) + 1


def cursor(text, nth=0, word="", name=MAIN):
    """The same as an editor counts: line and character from 0."""
    line, column = place_of(name, text, nth, word)
    return line, column - 1


def put(project, *lines, name=MAIN, at="GOTO again"):
    """Lines that are written before the first one with a text: the context of the last of them."""
    whole = project.texts.get(name, FILES[name]).split("\n")
    first = next(i for i, x in enumerate(whole) if at in x)
    project.set_text(name, "\n".join([*whole[:first], *lines, *whole[first:]]))
    return line_context(project.program(name), project.project.file(name), first + len(lines) - 1)
