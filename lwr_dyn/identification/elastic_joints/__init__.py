"""Arms with elastic joints whose logs have both encoders, the links' and the motors'.

identify_elastic  stiffness, damping, rotors, friction and the links' base parameters in one regression
elastic_tables    the result as text and record
"""
