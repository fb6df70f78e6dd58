"""Arms with elastic joints: a spring and a damper between the motor side and the link side of every gear.

run                 run_elastic: a sampled run, its record and its audit; joined by the registry `LOOPS`
plant               ElasticPlant: 2n coordinates (q, theta), friction on the motors, stops on the links
dynamics            ElasticDynamics: the reduced model of Spong
full_model          FullElasticDynamics: with the rotors' spin coupled to the links
loop                what the sampled loop of rigid joints needs for elastic ones
exponential         HeldExponential: one step under a held torque, of any stiffness
matrix_exponential  MatrixExponential
radau               Radau IIA 5: events, steps that the exponential refuses, and the second road
second_road         a run moved again by another engine and another method
"""
