"""The language: one line -> tokens -> a statement; a file as lines, written back byte for byte; routines and blocks.

blocks        Routines and blocks of a file: which ENDIF closes which IF, and what is missing or in the wrong place
declarations  Headers and declarations of KRL as records: DEF, DECL, STRUC, ENUM, SIGNAL, EXT
expressions   Expressions of KRL as records; the parser builds them with `RULES`. `column` (from 1) is left out of
              equality
layout        The layout of a KRL file: indentation by blocks, one space where words need it, keywords in capitals
lexer         Tokens of one line of KRL: keywords in any case, names, numbers, strings, signs; a comment begins with
              `;`
line_parser   One line of KRL -> its statement, by lark's LALR(1) parser; the grammar is `grammar.lark` beside this
              file
source        A KRL file as lines: read from bytes, and written back byte for byte where nothing was changed
statements    Statements of KRL as records. KRL has one statement a line; `blocks` pairs the lines of a block (IF ...
              ENDIF)
unparse       Expressions and statements -> their text, as KUKA's own editor writes it
"""
