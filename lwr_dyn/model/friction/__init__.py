"""Joint friction.

models      Coulomb, viscous, static and Stribeck friction per direction
smooth      the same with a tanh at rest
passivity   the speeds at which friction adds energy
refit       the nearest passive friction
"""
