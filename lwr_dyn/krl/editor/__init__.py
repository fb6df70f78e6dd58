"""What an editor asks of KRL files, and the language server that answers; nothing here imports numerics.

edited_project   the files of a folder, with the texts that are open in the editor; a file as a tree
referents        what the name under the cursor refers to; where it is declared and used; its hover text
server           `lwr-dyn krl server`: the Language Server Protocol over stdin and stdout, by pygls
"""
