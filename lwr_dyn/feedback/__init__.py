"""Control laws beyond the paper, one a file: they join the registry of controllers.

wrapped                what is put around a controller
friction_compensation  friction of the reference's or the measured velocity added to any law
"""
