"""The robot as a KUKA controller describes it.

kuka_pose     A pose in a KUKA controller's terms: X, Y, Z in mm, A, B, C in deg, Status and Turn, which select a
              solution
machine_data  The machine data of a six-axis KUKA robot, from a `$machine.dat` or a TOML file in its words, and its
              `Arm`
"""
