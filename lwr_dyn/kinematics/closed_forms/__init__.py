"""Closed forms of inverse kinematics, written once in a small part of C, from which every language is made.

arm_numbers     The numbers of an arm in the texts of its closed form, by their names there
inlining        A text with its shortest functions put in where they are called, for Python, where a call takes as long
                as they do
judged          The result of inverse kinematics from the numbers that a text's `solutions` gives
lazy_solutions  The solutions of a pose, copies whole turns apart among them: rows are made when first read, then each
                `Solution`
python_text     The texts as Python: plain functions on lists of floats, short loops written out, for where nothing is
                compiled
runners         What works a closed form's text out for one pose: machine code where LLVM is installed, else Python; the
                same bits
text_parser     The small part of C of the texts, parsed into a tree
tree            The tree of a text: functions, statements, expressions, each with its place. Imported as a module:
                `tree.CSet`
texts           The closed forms as texts in a small part of C, from which C, JavaScript, Python and machine code are
                made
"""
