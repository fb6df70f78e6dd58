"""What can be said when any arm is loaded: which chain of a tree it is, where it stands, what it carries.

obvious_arm      the tip of the one arm in a tree, or the tips of all arms and legs
mount_and_tool   mount and tool from names, tables, .toml files, poses and options of the command
"""
