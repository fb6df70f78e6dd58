"""What an editor asks of KRL files, and the language server that answers; nothing here imports numerics.

calls           Calls: that in which the cursor stands with its parameters, who calls a routine, and whom it calls
coloring        What each name of a file means, for an editor that colours by meaning
completions     What can be written at a place: components, items, constants, names, keywords
edited_project  The KRL files of a folder as an editor has them: texts that are open stand in the place of those on
                disk
outlines        A file as a tree: routines, their blocks and folds; of a `.dat` what it declares
protocol        The Language Server Protocol: the server, and the answers in its words
quick_fixes     What a diagnosis would write instead
referents       What the name at a place in a file refers to, with its declaration, type and value as text for an
                editor
renaming        Another name for what the program declares: all its places, or why it keeps its name
session         The projects that an editor has open, and to which of them a file belongs
signal_hints    The names of inputs and outputs
urdf_files      URDF and xacro files: where the findings of the linter stand, and what they would write instead
"""
