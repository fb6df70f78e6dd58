"""The Language Server Protocol: the only door to lsprotocol and pygls; what is said comes from the modules above it.

assistance      Help in writing: completion, signatures, rename, layout, colours, signal names, quick fixes
navigation      What stands where: hover, definition, uses, outline, folding, symbols, calls
open_files      The KRL files that an editor has open, and places in them from its words to ours
places          Places in a file as an editor counts them: lines from 0, and units of the encoding that it has chosen
server          `lwr-dyn lsp`: the language server over stdin and stdout, by pygls
urdf_documents  URDF and xacro files that an editor has open, judged in a thread
"""
