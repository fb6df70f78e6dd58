"""Inertial and friction parameters from any motion (`lwr-dyn identify motion`).

friction_rows  Friction beyond Coulomb and viscous as tables: Stribeck speeds that were searched, shares of the load
gain_fit       Gains of the torques and bodies near a table, found in turn from the same logs
identifiable   Which parameters logs identify, which of them only together, why the others not, and which motion would
load_hint      Whether a fit without friction that grows with the load asks for it
motion_fit     Identification from any motion: base parameters by least squares, bodies near the table, judged on
               other motions
motion_result  What a fit to any motion found, for programs and people: what is identified and what cannot be, bodies,
               and what is left of torques that it did not see
validation     How well a fit predicts torques that it has not seen, and whether what it leaves is white noise
"""
