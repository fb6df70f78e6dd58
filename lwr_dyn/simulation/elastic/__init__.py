"""Arms with elastic joints: a spring and a damper between the motor side and the link side of every gear.

exponential  One step of an arm with elastic joints under a held torque: the exponential of the linearised motion
plant        The plant with elastic joints: 2n coordinates, friction on the motors' side, position stops on the links'
             side
run          `run_elastic`: a sampled run of an arm with elastic joints, with its record and its audit
"""
