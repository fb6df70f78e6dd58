"""What acts on an arm from outside: walls that it touches, pushes against its links.

push            Push: a force at a point of the arm, with a smooth course over time
wall            Wall: a compliant plane that the tip touches, with friction
contact_figure  contact_figure: the force of a wall over runs
"""
