"""The language: one line -> tokens -> a statement; a file as lines, written back byte for byte; routines and blocks.

lexer, line_parser, grammar.lark           one line -> tokens -> a statement
expressions, declarations, statements      the records, with the rule of the grammar that builds each
unparse                                    records -> text
source                                     `SourceFile`: a file as lines
blocks                                     routines and blocks
layout                                     `krl format`: indentation, spaces, capitals
"""
