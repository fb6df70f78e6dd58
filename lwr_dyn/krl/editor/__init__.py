"""What an editor asks of KRL files, and the language server that answers; nothing here imports numerics.

edited_project   the files of a folder, with the texts that are open in the editor
outlines         routines, blocks, folds and data of a file as a tree
referents        what the name under the cursor refers to; where it is declared and used
hover            a name's declaration, type and value as text
positions        characters of a line, and the units in which an editor counts
server           `lwr-dyn krl server`: the Language Server Protocol over stdin and stdout, by pygls
"""
