"""Any arm as a Denavit-Hartenberg table and as a data file, the same motion and torque to rounding.

screws      a constant pose between two joints as turns about and shifts along z, x, z
dh_table    `dh_table`: the rows of an arm in either convention, its bodies in those frames, what rows cannot carry
data_file   `data_file_text`: the TOML of such a table, which loads again as the same arm
toml_text   columns of a data file as text
command     `lwr-dyn dh`
"""
