"""What an editor asks of KRL files, and the language server that answers; nothing here imports numerics.

edited_project  The KRL files of a folder as an editor has them: texts that are open stand in the place of those on
                disk
referents       What the name at a place in a file refers to, with its declaration, type and value as text for an
                editor
server          `lwr-dyn krl server`: the Language Server Protocol for KRL over stdin and stdout, by pygls
"""
