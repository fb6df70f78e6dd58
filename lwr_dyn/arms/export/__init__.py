"""Any arm as a Denavit-Hartenberg table, as a data file and as MJCF, the same motion and torque to rounding.

dh_table   `dh_table`: the rows of an arm in either convention, its bodies in those frames, what rows cannot carry
data_file  `data_file_text`: the TOML of such a table, which loads again as the same arm
mjcf       `mjcf_text`: MuJoCo's format
"""
